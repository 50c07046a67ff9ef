// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/joints_by_four.h"

#include <algorithm>
#include <array>

#include "core/index.h"

namespace dttmm::plugin {

namespace {

constexpr size_t kCount = Lanes::kCount;

[[gnu::always_inline]] inline FrameOf<Lanes> gather_frames(const std::vector<Frame>& frames,
                                                           const uint32_t (&index)[kCount]) {
    return gather_records<FrameOf>([&](size_t k) -> auto& { return frames[index[k]]; });
}

/// Adds forces of four joints to the wrenches on their frames; returns the largest force's square.
[[gnu::always_inline]] inline double add_wrenches(const JointForceOf<Lanes>& force, const uint32_t (&from)[kCount],
                                                  const uint32_t (&to)[kCount], std::vector<Vector6>& wrench) {
    JointForce each[kCount];
    scatter_records(
        force, [&](size_t k) -> auto& { return each[k]; });
    for (size_t k = 0; k < kCount; ++k) Joint::add_wrench(each[k], wrench[from[k]].data(), wrench[to[k]].data());
    const Lanes squared = squared_norm(force.force);
    return std::max({squared[0], squared[1], squared[2], squared[3]});
}

bool have_axes_alike(const JointAxesOf<double>& a, const JointAxesOf<double>& b) {
    const auto alike = [](bool a_is_one, bool b_is_one, const Matrix3& a_axes, const Matrix3& b_axes) {
        return a_is_one == b_is_one && (a_is_one || a_axes == b_axes);
    };
    return alike(a.is_aligned, b.is_aligned, a.from_axes, b.from_axes) &&
           alike(a.is_straight, b.is_straight, a.to_axes, b.to_axes);
}

}  // namespace

JointsByFour::JointsByFour(const Mechanism& mechanism, std::span<const size_t> joints) {
    std::vector<size_t> open[2][2];  // by whether they carry moments, keep rates
    fours_.reserve(joints.size() / kCount);
    for (size_t j : joints) {
        const Joint& joint = mechanism.joints[j];
        std::vector<size_t>& four = open[joint.turns()][mechanism.damper(j) != nullptr];
        four.push_back(j);
        if (four.size() < kCount) continue;
        take(mechanism, four);
        four.clear();
    }
    for (const auto& by_rates : open)
        for (const std::vector<size_t>& left : by_rates) others_.insert(others_.end(), left.begin(), left.end());
    std::sort(others_.begin(), others_.end());
}

void JointsByFour::take(const Mechanism& mechanism, std::span<const size_t> four) {
    std::array<const Joint*, kCount> joints;
    Four taken{};
    taken.keeps_rates = mechanism.damper(four.front()) != nullptr;
    taken.point.has_lever = false;
    for (size_t k = 0; k < kCount; ++k) {
        joints[k] = &mechanism.joints[four[k]];
        taken.joint[k] = static_cast<uint32_t>(four[k]);
        taken.from[k] = static_cast<uint32_t>(joints[k]->from());
        taken.to[k] = static_cast<uint32_t>(joints[k]->to());
        const JointSeat& seat = joints[k]->seat();
        set_lane(taken.point.rest, as_int(k), seat.rest);
        set_lane(taken.point.to_point, as_int(k), seat.to_point);
        taken.point.has_lever |= seat.has_lever;
    }
    std::array<const Joint*, kCount> last{};
    if (!fours_.empty())
        for (size_t k = 0; k < kCount; ++k) last[k] = &mechanism.joints[fours_.back().joint[k]];
    const auto differ = [&](const auto& alike) { return fours_.empty() || !std::ranges::equal(joints, last, alike); };
    if (differ([](const Joint* a, const Joint* b) { return &a->kind() == &b->kind(); })) take_springs(joints);
    if (differ([](const Joint* a, const Joint* b) { return have_axes_alike(a->seat(), b->seat()); })) take_axes(joints);
    taken.springs = static_cast<uint32_t>(springs_.size() - 1);
    taken.axes = static_cast<uint32_t>(axes_.size() - 1);
    fours_.push_back(taken);
}

void JointsByFour::take_springs(std::span<const Joint* const> four) {
    SpringsOf<Lanes>& taken = springs_.emplace_back();
    taken.turns = four.front()->turns();
    for (size_t k = 0; k < kCount; ++k) {
        const SpringsOf<double>& one = four[k]->springs();
        const auto i = as_int(k);
        for (int half : {0, 1}) {
            set_lane(taken.halves[half].stiffness, i, one.halves[half].stiffness);
            set_lane(taken.halves[half].damping, i, one.halves[half].damping);
        }
        taken.is_line |= one.is_line;
        taken.line.bow.set(i, one.line.bow);
        taken.line.sway_y.set(i, one.line.sway_y);
        taken.line.sway_z.set(i, one.line.sway_z);
        taken.line.mixed.set(i, one.line.mixed);
    }
}

void JointsByFour::take_axes(std::span<const Joint* const> four) {
    JointAxesOf<Lanes>& taken = axes_.emplace_back();
    taken.is_aligned = taken.is_straight = true;
    for (size_t k = 0; k < kCount; ++k) {
        const JointSeat& seat = four[k]->seat();
        set_lane(taken.from_axes, as_int(k), seat.from_axes);
        set_lane(taken.to_axes, as_int(k), seat.to_axes);
        taken.is_aligned &= seat.is_aligned;
        taken.is_straight &= seat.is_straight;
    }
}

DTTMM_WIDE double JointsByFour::add_forces(const Mechanism& mechanism, const std::vector<Frame>& trial,
                                           std::vector<Vector6>& wrench) const {
    double largest = 0;
    for (const Four& four : fours_) {
        const FrameOf<Lanes> from = gather_frames(trial, four.from), to = gather_frames(trial, four.to);
        const SpringsOf<Lanes>& springs = springs_[four.springs];
        const JointAxesOf<Lanes>& axes = axes_[four.axes];
        const JointPoseOf<Lanes> pose = four.point.pose(axes, from, to);
        const StrainedOf<Lanes> end = springs.strain(four.point.rest, pose, axes.axes_at_to(to), !four.keeps_rates);
        const auto state = gather_records<JointStateOf>([&](size_t k) -> auto& { return mechanism.states[four.joint[k]]; });
        JointForceOf<Lanes> force;
        if (four.keeps_rates) {
            const auto damper =
                gather_records<DamperStateOf>([&](size_t k) -> auto& { return *mechanism.damper(four.joint[k]); });
            force = springs.weigh(mechanism.scheme, end, pose, state, &damper);
        } else {
            force = springs.weigh(mechanism.scheme, end, pose, state, nullptr);
        }
        largest = std::max(largest, add_wrenches(force, four.from, four.to, wrench));
    }
    return largest;
}

DTTMM_WIDE void JointsByFour::advance(Mechanism& mechanism, const std::vector<Frame>& next,
                                      std::vector<Vector6>& wrench) const {
    for (const Four& four : fours_) {
        const FrameOf<Lanes> from = gather_frames(next, four.from), to = gather_frames(next, four.to);
        const SpringsOf<Lanes>& springs = springs_[four.springs];
        const JointAxesOf<Lanes>& axes = axes_[four.axes];
        const JointPoseOf<Lanes> pose = four.point.pose(axes, from, to);
        const StrainedOf<Lanes> end = springs.strain(four.point.rest, pose, axes.axes_at_to(to));
        const auto state_of = [&](size_t k) -> auto& { return mechanism.states[four.joint[k]]; };
        auto state = gather_records<JointStateOf>(state_of);
        const auto pose_now = [&] {
            return four.point.pose(axes, gather_frames(mechanism.frames, four.from),
                                   gather_frames(mechanism.frames, four.to));
        };
        const auto move_on = [&](DamperStateOf<Lanes>* damper) {
            const JointForceOf<Lanes> force = springs.weigh(mechanism.scheme, end, pose, state, damper);
            springs.advance(mechanism.scheme, end, pose, pose_now, state, damper);
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
