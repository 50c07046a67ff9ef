// SPDX-License-Identifier: BSD-3-Clause
#include "statics/hanging_frames.h"

#include <algorithm>

#include "core/index.h"
#include "core/rotation.h"

namespace dttmm::plugin {

/// Takes off frames that one joint holds, until none is left: the last one taken off hangs on the rest.
HangingFrames::HangingFrames(const Mechanism& mechanism) : hangs_(mechanism.assembly.frames.size(), false) {
    const int driven = mechanism.assembly.driven_count;
    std::vector<std::vector<size_t>> joints_at(hangs_.size());
    std::vector<int> degree(hangs_.size(), 0);
    for (size_t j = 0; j < mechanism.joints.size(); ++j)
        for (const int end : {0, 1}) {
            const auto f = as_size(mechanism.joints[j].frame(end));
            joints_at[f].push_back(j);
            ++degree[f];
        }
    std::vector<int> tips;
    const auto add_tip = [&](int frame) {
        if (frame >= driven && degree[as_size(frame)] == 1) tips.push_back(frame);
    };
    for (int f = driven; f < as_int(hangs_.size()); ++f) add_tip(f);
    for (size_t i = 0; i < tips.size(); ++i) {
        for (const size_t j : joints_at[as_size(tips[i])]) {
            const Joint& joint = mechanism.joints[j];
            const int end = joint.to() == tips[i] ? 1 : 0, other = joint.frame(1 - end);
            // The joint that is left; nothing is where an axial one has its ends but their distance
            if (hangs_[as_size(other)] || joint.is_axial() || degree[as_size(tips[i])] != 1) continue;
            hangs_[as_size(tips[i])] = true;
            all_.push_back({j, end});
            degree[as_size(tips[i])] = 0;
            --degree[as_size(other)];
            add_tip(other);
        }
    }
    std::ranges::reverse(all_);
}

void HangingFrames::Hanging::take(const PlacedJoint& placed, const Vector6& of_from, const Vector6& of_to) {
    const Vector6 change = change_of_motion(placed, of_from, of_to);
    d = placed.x.head<3>() + change.head<3>();
    if (placed.joint.turns())
        attitude = rotation_from_vector<double>(Vector3(placed.x.tail<3>() + change.tail<3>()));
    else
        attitude =
            rotation_from_vector<double>(Vector3(change.tail<3>())) * placed.joint.attitude(placed.at.from, placed.at.to);
}

void HangingFrames::place(const Mechanism& mechanism, std::vector<Frame>& frames) const {
    for (const Hanging& hanging : all_) {
        const Joint& joint = mechanism.joints[hanging.joint];
        const JointSeat& seat = joint.seat();
        const FrameView known(frames[as_size(joint.frame(1 - hanging.end))]);
        Matrix3 R;
        Vector3 origin;
        if (hanging.end == 1) {
            const Matrix3 axes = seat.axes(known);
            R = axes * hanging.attitude * seat.own->to_axes.transpose();
            origin = known.origin() + axes * (seat.rest + hanging.d) - R * seat.to_point;
        } else {
            const Matrix3 axes = seat.axes_at_to(known) * hanging.attitude.transpose();
            R = axes * seat.own->from_axes.transpose();
            origin = known.origin() + known.axes() * seat.to_point - axes * (seat.rest + hanging.d);
        }
        Frame& frame = frames[as_size(joint.frame(hanging.end))];
        Eigen::Map<Vector3>{frame.position} = origin;
        Eigen::Map<RowMajor3>{frame.rotation} = R;
    }
}

}  // namespace dttmm::plugin
