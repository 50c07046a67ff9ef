// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "analysis/json.h"
#include "analysis/modal_machine.h"
#include "record/warnings.h"

namespace dttmm::host {

/// The modes of a machine with its damping, up to a frequency.
struct DampedModes {
    double below = 0;                          ///< largest |s|/2π [Hz]
    std::vector<ModalInstance::Damped> modes;  ///< by |s|, rigid-body modes first
    int32_t is_proved = 0;                     ///< see dttmm_response.h
};

/// Up to which |s|/2π damped modes are looked for beside these undamped ones [Hz]: a little beyond the last, or as the model
/// says; far enough for all that grows.
double range_of_damped(const Model& model, const std::vector<ModalInstance::Mode>& modes);

/// Those up to `below` [Hz]; undamped: the modes without damping. What is not proved, what grows, and what the list does
/// not have goes to the warnings.
DampedModes find_damped_modes(ModalMachine& machine, const std::vector<ModalInstance::Mode>& undamped, double below,
                              Warnings& warnings);

/// damped.csv: a row per mode: damped frequency, |s|/2π, damping ratio −Re s/|s|, decay −Re s, correction.
std::string damped_table(const DampedModes& damped);
/// damped_shapes.csv: a row per mode and place, complex.
std::string damped_shapes(const ModalMachine& machine, const DampedModes& damped);
Json describe(const DampedModes& damped);
void print_damped(const DampedModes& damped);

}  // namespace dttmm::host
