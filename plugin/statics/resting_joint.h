// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mechanism/joint.h"

namespace dttmm::plugin {

// A joint at rest: its laws have gone the straight way from the undeformed state to a deformation x. Forces along the
// deformations are gradients by θ in rotations.

/// The elastic forces along the deformations there, and their derivatives.
struct RestingForce {
    Vector6 force, tangent;
};
RestingForce resting_force(const Joint& joint, const Vector6& x);

/// The derivatives where the laws have come to rest there: those of small vibrations, with which sliders stick.
Vector6 unloading_tangent(const Joint& joint, const Vector6& x);

/// How small motions of its frames (shifts and turns, world axes) change a deformation x.
Vector6 change_of_deformation(const Joint& joint, const JointPose& pose, const Vector6& x, const Vector6& of_from,
                              const Vector6& of_to);

/// What forces along the deformations do to the frames; `rigid` are those of rigid directions.
JointForce carried_force(const Joint& joint, Ends at, const Vector6& force, const Vector6& rigid);

/// How such forces change as [force; moment] in the joint's axes while they keep their size, by a small relative motion
/// [d; ε] of the `to` end.
Matrix6 spread_tangent(const Joint& joint, Ends at, const Vector6& force, const Vector6& rigid);

/// −∂(wrench)/∂(pose) of such forces while they keep their size: all that stems from their directions and lever arms.
EndBlocks turning_stiffness(const Joint& joint, Ends at, const Vector6& force, const Vector6& rigid);

}  // namespace dttmm::plugin
