// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "analysis/modal_machine.h"

namespace dttmm::host {

/// Where the energy of a mode is.
struct ModeEnergies {
    using Vector6 = ModalMachine::Vector6;
    struct OfBody {
        double total = 0;  ///< share of the kinetic energy of the mode
        /// Shares by direction: displacement of the centre of mass and rotation about it, world axes. q_d (M q)_d of each
        /// over qᵀ M q of all: products of inertia belong half to each of their axes, so that a share may be negative.
        Vector6 world = Vector6::Zero();
        Eigen::Vector3d principal = Eigen::Vector3d::Zero();  ///< of rotation, about its principal axes by ascending moment
    };
    std::vector<OfBody> bodies;
    double others = 0;                ///< share of the kinetic energy of all that is no body: beams, masses at nodes
    std::vector<Vector6> directions;  ///< of the strain energy, by element; none: not known
};

/// `index`: of the mode among those found.
ModeEnergies energies_of(const Model& model, ModalMachine& machine, const ModalInstance::Mode& mode, uint32_t index);

/// The kind of a mode in words: "roll 54 %, yaw 40 %" of a body that has most of the kinetic energy; directions below 10 %
/// are left out. Empty where no body has a half of it.
std::string kind_of(const Model& model, const ModeEnergies& energies);

/// kind_of(); where no body has half of the kinetic energy, the place and direction that move most.
std::string motion_in_words(const Model& model, const ModalMachine& machine, const ModalInstance::Mode& mode,
                            const ModeEnergies& energies);

/// energies.csv: a row per mode and body, then per mode and element.
std::string energies_table(const Model& model, const std::vector<ModalInstance::Mode>& modes,
                           const std::vector<ModeEnergies>& energies);

}  // namespace dttmm::host
