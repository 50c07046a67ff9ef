// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mechanism/mechanism.h"
#include "statics/resting_joint.h"

namespace dttmm::plugin {

/// Inner frames that hang on the rest of a network as a tree: each by one joint from the frame before it. No loop goes
/// through such a joint. Its deformation alone decides where the frame is.
///
/// A correction is linear. Taken as displacements, a turn by θ of a bar stretches it by θ²/2, and the forces of that are
/// large in a slender bar. Taken as changes of the deformations, it stretches nothing.
class HangingFrames {
public:
    explicit HangingFrames(const Mechanism& mechanism);

    bool hangs(int frame) const { return hangs_[as_size(frame)]; }
    /// By which they hang, from the rest outwards.
    template <class Function>
    void for_each_joint(const Function& function) const {
        for (const Hanging& hanging : all_) function(hanging.joint);
    }
    /// Takes the deformations after a correction: placed_at(joint) is the joint before it, motion_of(frame) the shift and
    /// the small turn of a frame, world axes [m, rad].
    template <class PlacedAt, class Motion>
    void deform(const PlacedAt& placed_at, const Motion& motion_of) {
        for (Hanging& hanging : all_) {
            const PlacedJoint& placed = placed_at(hanging.joint);
            hanging.take(placed, motion_of(placed.joint.from()), motion_of(placed.joint.to()));
        }
    }
    /// Puts the frames that hang where these deformations have them. The others are in their new places already.
    void place(const Mechanism& mechanism, std::vector<Frame>& frames) const;

private:
    struct Hanging {
        size_t joint;
        int end;  ///< the one that hangs: 0 `from`, 1 `to`
        Vector3 d = Vector3::Zero();
        Matrix3 attitude = Matrix3::Identity();  ///< of the `to` end in the joint's axes
        void take(const PlacedJoint& placed, const Vector6& of_from, const Vector6& of_to);
    };
    std::vector<Hanging> all_;  ///< from the rest outwards
    std::vector<bool> hangs_;   ///< by frame
};

}  // namespace dttmm::plugin
