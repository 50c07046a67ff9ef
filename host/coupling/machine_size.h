// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "model/model.h"
#include "world/inertia.h"
#include "world/joint_system.h"

namespace dttmm::host {

/// Where the bodies are before they move, velocities zero.
std::vector<BodyState> states_at_start(const Model& model);

/// How large and heavy a machine is: what its motions are measured by.
struct MachineSize {
    MachineSize(const Model& model, const std::vector<JointEquations>& joints);

    std::vector<Inertia> inertias;
    std::vector<double> reach;  ///< of forces on each body from its centre of mass [m]
    double mass = 0;            ///< of all [kg]
    double span = 0;            ///< of the machine and the ways of its sliders [m]
    double extent = 0;          ///< that and its distance from the origin [m]
};

}  // namespace dttmm::host
