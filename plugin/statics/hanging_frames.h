// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mechanism/mechanism.h"
#include "statics/resting_joint.h"

namespace dttmm::plugin {

/// Inner frames that hang on the rest of a network, or on each other, as a tree: each by one joint that it shares with the
/// frame it hangs on. No loop goes through such a joint, so that its deformation decides alone where the frame is. A small
/// turn of a long arm, taken as a displacement, would stretch the arm by its square; deformations know no such turn.
class HangingFrames {
public:
    explicit HangingFrames(const Mechanism& mechanism);

    bool hangs(int frame) const { return hangs_[as_size(frame)]; }
    /// By which they hang, from the rest outwards.
    template <class Function>
    void for_each_joint(const Function& function) const {
        for (const Hanging& hanging : all_) function(hanging.joint);
    }
    /// Takes the deformations that small motions of the frames lead to from where the joints are placed.
    /// motion_of(frame): world axes.
    template <class PlacedAt, class Motion>
    void deform(const PlacedAt& placed_at, const Motion& motion_of) {
        for (Hanging& hanging : all_) {
            const PlacedJoint& placed = placed_at(hanging.joint);
            hanging.take(placed, motion_of(placed.joint.from()), motion_of(placed.joint.to()));
        }
    }
    /// Puts the frames where these deformations have them; the frames that hang on nothing are where they will be.
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
