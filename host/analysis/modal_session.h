// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <vector>

#include "analysis/modal_machine.h"
#include "analysis/request.h"
#include "loader/plugins.h"
#include "record/warnings.h"

namespace dttmm::host {

/// Notes what of the model is not in its natural frequencies: gravity and lasting loads.
void warn_preload(const Model& model, Warnings& warnings);

/// Notes where the machine leaves the equilibria that a growing load leads through. has_potential: all loads have one.
/// place: its case, before the text.
void note_path_end(const RestState& rest, bool has_potential, const std::string& place, Warnings& warnings);

/// Notes bodies and nodes that turn at the start: what their turning does is in no small vibration and in no rest. `code`;
/// `what` follows their name.
void note_velocities(const Model& model, const char* code, const char* what, Warnings& warnings);

/// Warns where the forces of a machine at rest balance worse than results have digits. place: its case, before the text.
void warn_unbalanced(const RestState& rest, const std::string& place, Warnings& warnings);

/// Warns of loads at rest that have no potential: what is known of stability is that of a symmetric part.
void warn_nonconservative(const Model& model, const ModalMachine& machine, Warnings& warnings);

/// What motions that grow say in a machine under such loads, of "1 motion grows" in the symmetric part.
std::string undecided(const std::string& what_grows);

/// What [damping] does not damp.
void note_damping(const Model& model, Warnings& warnings);
/// Of damping that belongs to no element, for commands that show forces of elements.
void note_forces_of_damping(const Model& model, Warnings& warnings);

/// Its machine about the state that the model asks for; what that is, and what is not in the frequencies, goes to the
/// warnings.
ModalMachine make_machine(const Model& model, const Plugins& plugins, Warnings& warnings);

/// A model as one command works on its small vibrations: read and checked, before anything is written.
class ModalSession {
public:
    /// Its plugins and its warnings, those of the file and of what its frequencies leave out, are the caller's: the cases of
    /// a sweep share them. Throws Error for a model in which nothing vibrates.
    ModalSession(const Request& request, const Plugins& plugins, Warnings& warnings);

    /// The natural frequencies that the model asks for; says so where there are none.
    std::vector<ModalInstance::Mode> find_modes();

    const Model model;
    ModalMachine machine;
};

/// Where the results go: the folder asked for, or the model's with `suffix` behind its name.
std::filesystem::path results_path(const Request& request, const char* suffix);

}  // namespace dttmm::host
