// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "mechanism/joint.h"

namespace dttmm::plugin {

// A joint at rest: its laws have gone straight from the undeformed state to a deformation x. Forces along the strains are
// gradients by θ in rotations.

/// A joint between its frames: its pose and its deformation there. The joint and the frames must outlive it and stay where
/// they are.
struct PlacedJoint {
    PlacedJoint(const Joint& of, Ends frames)
        : joint(of), at(frames), pose(of.pose(frames)), x(of.deformation(pose, frames.from, frames.to)) {}
    const Joint& joint;
    Ends at;
    JointPose pose;
    Vector6 x;
};

/// The elastic forces along the strains there, and their derivatives.
struct RestingForce {
    Vector6 force, tangent;
};
RestingForce resting_force(const Joint& joint, const Vector6& x);

/// The derivatives where the laws have come to rest there: those of small vibrations, with which sliders stick.
Vector6 unloading_tangent(const Joint& joint, const Vector6& x);

/// How small motions of its frames (shifts and turns, world axes) change its deformation [d; θ].
Vector6 change_of_motion(const PlacedJoint& placed, const Vector6& of_from, const Vector6& of_to);
/// The same with its strains in place of d.
Vector6 change_of_deformation(const PlacedJoint& placed, const Vector6& of_from, const Vector6& of_to);

/// What forces along the strains do to the frames; `rigid` are those of rigid directions.
JointForce carried_force(const PlacedJoint& placed, const Vector6& force, const Vector6& rigid);

/// How such forces change as [force; moment] in the joint's axes while they keep their size, by a small relative motion
/// [d; ε] of the `to` end. The axes of an axial joint follow its line: zero.
Matrix6 spread_tangent(const PlacedJoint& placed, const Vector6& force, const Vector6& rigid);

/// −∂(wrench)/∂(pose) of such forces while they keep their size: all that stems from their directions and lever arms.
/// spread: by spread_tangent.
EndBlocks turning_stiffness(const PlacedJoint& placed, const Vector6& force, const Vector6& rigid, const Matrix6& spread);

}  // namespace dttmm::plugin
