// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/joints_by_four.h"

#include <algorithm>

#include "core/index.h"

namespace dttmm::plugin {

namespace {

constexpr size_t kCount = Lanes::kCount;

[[gnu::always_inline]] inline FrameOf<Lanes> gather_frames(const std::vector<Frame>& frames, const size_t (&index)[kCount]) {
    return gather_records<FrameOf>([&](size_t k) -> auto& { return frames[index[k]]; });
}

/// Adds forces of four joints to the wrenches on their frames; returns the largest force's square.
[[gnu::always_inline]] inline double add_wrenches(const JointForceOf<Lanes>& force, const size_t (&from)[kCount],
                                                  const size_t (&to)[kCount], std::vector<Vector6>& wrench) {
    JointForce each[kCount];
    scatter_records(
        force, [&](size_t k) -> auto& { return each[k]; });
    for (size_t k = 0; k < kCount; ++k) Joint::add_wrench(each[k], wrench[from[k]].data(), wrench[to[k]].data());
    const Lanes squared = squared_norm(force.force);
    return std::max({squared[0], squared[1], squared[2], squared[3]});
}

}  // namespace

JointsByFour::JointsByFour(const Mechanism& mechanism, std::span<const size_t> joints) {
    std::vector<size_t> open[2][2];  // by whether they carry moments, keep rates
    fours_.reserve(joints.size() / kCount);
    for (size_t j : joints) {
        const Joint& joint = mechanism.joints[j];
        const bool keeps_rates = mechanism.damper(j) != nullptr;
        std::vector<size_t>& four = open[joint.turns()][keeps_rates];
        four.push_back(j);
        if (four.size() < kCount) continue;
        Four& taken = fours_.emplace_back();
        taken.keeps_rates = keeps_rates;
        taken.springs.turns = joint.turns();
        taken.seat.is_aligned = taken.seat.is_straight = true;
        taken.seat.has_lever = false;
        for (size_t k = 0; k < kCount; ++k) {
            const Joint& one = mechanism.joints[four[k]];
            const auto i = as_int(k);
            taken.joint[k] = four[k];
            taken.from[k] = as_size(one.from());
            taken.to[k] = as_size(one.to());
            for (int half : {0, 1}) {
                set_lane(taken.springs.halves[half].stiffness, i, one.springs().halves[half].stiffness);
                set_lane(taken.springs.halves[half].damping, i, one.springs().halves[half].damping);
            }
            set_lane(taken.springs.rest, i, one.springs().rest);
            taken.springs.is_line |= one.springs().is_line;
            taken.springs.line.bow.set(i, one.springs().line.bow);
            taken.springs.line.sway_y.set(i, one.springs().line.sway_y);
            taken.springs.line.sway_z.set(i, one.springs().line.sway_z);
            taken.springs.line.mixed.set(i, one.springs().line.mixed);
            const JointSeat& seat = one.seat();
            set_lane(taken.seat.from_axes, i, seat.from_axes);
            set_lane(taken.seat.to_axes, i, seat.to_axes);
            set_lane(taken.seat.to_point, i, seat.to_point);
            taken.seat.is_aligned &= seat.is_aligned;
            taken.seat.is_straight &= seat.is_straight;
            taken.seat.has_lever |= seat.has_lever;
        }
        four.clear();
    }
    for (const auto& by_rates : open)
        for (const std::vector<size_t>& left : by_rates) others_.insert(others_.end(), left.begin(), left.end());
    std::sort(others_.begin(), others_.end());
}

DTTMM_WIDE double JointsByFour::add_forces(const Mechanism& mechanism, const std::vector<Frame>& trial,
                                           std::vector<Vector6>& wrench) const {
    double largest = 0;
    for (const Four& four : fours_) {
        const FrameOf<Lanes> from = gather_frames(trial, four.from), to = gather_frames(trial, four.to);
        const JointPoseOf<Lanes> pose = four.seat.pose(from, to);
        const StrainedOf<Lanes> end = four.springs.strain(pose, four.seat.axes_at_to(to), !four.keeps_rates);
        const auto state = gather_records<JointStateOf>([&](size_t k) -> auto& { return mechanism.states[four.joint[k]]; });
        JointForceOf<Lanes> force;
        if (four.keeps_rates) {
            const auto damper =
                gather_records<DamperStateOf>([&](size_t k) -> auto& { return *mechanism.damper(four.joint[k]); });
            force = four.springs.weigh(mechanism.scheme, end, pose, state, &damper);
        } else {
            force = four.springs.weigh(mechanism.scheme, end, pose, state, nullptr);
        }
        largest = std::max(largest, add_wrenches(force, four.from, four.to, wrench));
    }
    return largest;
}

DTTMM_WIDE void JointsByFour::advance(Mechanism& mechanism, const std::vector<Frame>& next,
                                      std::vector<Vector6>& wrench) const {
    for (const Four& four : fours_) {
        const FrameOf<Lanes> from = gather_frames(next, four.from), to = gather_frames(next, four.to);
        const JointPoseOf<Lanes> pose = four.seat.pose(from, to);
        const StrainedOf<Lanes> end = four.springs.strain(pose, four.seat.axes_at_to(to));
        const auto state_of = [&](size_t k) -> auto& { return mechanism.states[four.joint[k]]; };
        auto state = gather_records<JointStateOf>(state_of);
        const auto pose_now = [&] {
            return four.seat.pose(gather_frames(mechanism.frames, four.from), gather_frames(mechanism.frames, four.to));
        };
        const auto move_on = [&](DamperStateOf<Lanes>* damper) {
            const JointForceOf<Lanes> force = four.springs.weigh(mechanism.scheme, end, pose, state, damper);
            four.springs.advance(mechanism.scheme, end, pose, pose_now, state, damper);
            add_wrenches(force, four.from, four.to, wrench);
        };
        if (four.keeps_rates) {
            const auto damper_of = [&](size_t k) -> auto& { return *mechanism.damper(four.joint[k]); };
            auto damper = gather_records<DamperStateOf>(damper_of);
            move_on(&damper);
            scatter_records(damper, damper_of);
        } else {
            move_on(nullptr);
        }
        scatter_records(state, state_of);
    }
}

}  // namespace dttmm::plugin
