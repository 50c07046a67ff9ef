// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/joints_by_four.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <type_traits>

#include "core/index.h"

namespace dttmm::plugin {

namespace {

constexpr size_t kCount = Lanes::kCount;
using SixLanes = Eigen::Matrix<Lanes, 6, 1>;

/// place(index) of four indices, looked up once. For all the compiler knows, what is stored between may change an index.
[[gnu::always_inline]] inline auto each_of(const uint32_t (&index)[kCount], const auto& place) {
    return std::array{place(index[0]), place(index[1]), place(index[2]), place(index[3])};
}

/// frame(index): pointer to the numbers of a Frame.
[[gnu::always_inline]] inline FrameOf<Lanes> gather_frames(const auto& frame, const uint32_t (&index)[kCount]) {
    static_assert(kIsPlain<FrameOf>);
    const std::array<const double*, kCount> at = each_of(index, frame);
    FrameOf<Lanes> four;
    gather<Frame::kNumbers>({at[0], at[1], at[2], at[3]}, reinterpret_cast<Lanes*>(&four));
    return four;
}

/// Frames of a list; and of the host where they are ports.
auto numbers_in(const std::vector<Frame>& frames) {
    return [first = frames.data()](uint32_t index) { return numbers_of(first[index]); };
}
auto numbers_in(const PortBodies& ports, const dttmm_motion* motions) {
    static_assert(offsetof(dttmm_motion, position) == 0 && offsetof(dttmm_motion, rotation) == 3 * sizeof(double));
    return [&ports, motions](uint32_t index) { return ports.seen(as_int(index), motions).position; };
}
auto wrenches_in(std::vector<Vector6>& wrenches) {
    return [first = wrenches.data()](uint32_t index) { return first[index].data(); };
}

/// Calls take(count, first) for the numbers in use of a DamperState: without moments those of translations, and the losses.
[[gnu::always_inline]] inline void for_parts_of_damper(bool turns, const auto& take) {
    static_assert(kIsPlain<DamperStateOf>);
    constexpr int kTranslations = sizeof(DamperState::Half) / sizeof(double),
                  kLosses = offsetof(DamperState, dissipated) / sizeof(double);
    if (turns) return take(std::integral_constant<int, DamperState::kNumbers>{}, 0);
    take(std::integral_constant<int, kTranslations>{}, 0);
    take(std::integral_constant<int, DamperState::kNumbers - kLosses>{}, kLosses);
}
template <class Number>
[[gnu::always_inline]] inline void gather_dampers(bool turns, const std::array<Number*, kCount>& at,
                                                  DamperStateOf<Lanes>& four) {
    for_parts_of_damper(turns, [&]<int N>(std::integral_constant<int, N>, int first) {
        gather<N>({at[0] + first, at[1] + first, at[2] + first, at[3] + first}, reinterpret_cast<Lanes*>(&four) + first);
    });
}
[[gnu::always_inline]] inline void scatter_dampers(bool turns, const DamperStateOf<Lanes>& four,
                                                   const std::array<double*, kCount>& at) {
    for_parts_of_damper(turns, [&]<int N>(std::integral_constant<int, N>, int first) {
        scatter<N>(reinterpret_cast<const Lanes*>(&four) + first,
                   {at[0] + first, at[1] + first, at[2] + first, at[3] + first});
    });
}

/// Adds forces of four joints to the wrenches on their frames, wrench(index).
[[gnu::always_inline]] inline void add_wrenches(const JointForceOf<Lanes>& force, const uint32_t (&from)[kCount],
                                                const uint32_t (&to)[kCount], const auto& wrench) {
    JointForce each[kCount];
    scatter_records(
        force, [&](size_t k) -> auto& { return each[k]; });
    for (size_t k = 0; k < kCount; ++k) Joint::add_wrench(each[k], wrench(from[k]), wrench(to[k]));
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

std::vector<size_t> JointsByFour::not_taken(size_t count) const {
    std::vector<bool> is_taken(count);
    for (const Four& four : fours_)
        for (uint32_t j : four.joint) is_taken[j] = true;
    std::vector<size_t> rest;
    for (size_t j = 0; j < count; ++j)
        if (!is_taken[j]) rest.push_back(j);
    return rest;
}

void JointsByFour::take(const Mechanism& mechanism, std::span<const size_t> four) {
    std::array<const Joint*, kCount> joints;
    Four taken{};
    taken.keeps_rates = mechanism.damper(four.front()) != nullptr;
    taken.point.has_lever = false;
    for (size_t k = 0; k < kCount; ++k) {
        joints[k] = &mechanism.joints[four[k]];
        taken.joint[k] = as_whole<uint32_t>(four[k]);
        if (taken.keeps_rates) taken.damper[k] = as_whole<uint32_t>(mechanism.damper_of[four[k]]);
        taken.from[k] = as_whole<uint32_t>(joints[k]->from());
        taken.to[k] = as_whole<uint32_t>(joints[k]->to());
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
    if (differ([](const Joint* a, const Joint* b) { return have_axes_alike(*a->seat().own, *b->seat().own); }))
        take_axes(joints);
    taken.springs = as_whole<uint32_t>(springs_.size() - 1);
    taken.axes = as_whole<uint32_t>(axes_.size() - 1);
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
        taken.line.half.set(i, one.line.half);
    }
}

void JointsByFour::take_axes(std::span<const Joint* const> four) {
    JointAxesOf<Lanes>& taken = axes_.emplace_back();
    taken.is_aligned = taken.is_straight = true;
    for (size_t k = 0; k < kCount; ++k) {
        const JointAxesOf<double>& one = *four[k]->seat().own;
        set_lane(taken.from_axes, as_int(k), one.from_axes);
        set_lane(taken.to_axes, as_int(k), one.to_axes);
        taken.is_aligned &= one.is_aligned;
        taken.is_straight &= one.is_straight;
    }
}

[[gnu::always_inline]] inline double JointsByFour::add_forces_at(const Mechanism& mechanism, const auto& frame,
                                                                 const auto& wrench) const {
    double largest = 0;
    for (const Four& four : fours_) {
        const FrameOf<Lanes> from = gather_frames(frame, four.from), to = gather_frames(frame, four.to);
        const SpringsOf<Lanes>& springs = springs_[four.springs];
        const JointAxesOf<Lanes>& axes = axes_[four.axes];
        const JointPoseOf<Lanes> pose = four.point.pose(axes, from, to);
        const StrainedOf<Lanes> end = springs.strain(four.point.rest, pose, axes.axes_at_to(to), !four.keeps_rates);
        const auto states = each_of(four.joint, [&](uint32_t j) { return &mechanism.states[j]; });
        const auto state = gather_records<JointStateOf>([&](size_t k) -> auto& { return *states[k]; });
        JointForceOf<Lanes> force;
        if (four.keeps_rates) {
            DamperStateOf<Lanes> damper;
            gather_dampers(springs.turns, each_of(four.damper, [&](uint32_t d) { return numbers_of(mechanism.dampers[d]); }),
                           damper);
            force = springs.weigh(mechanism.scheme, end, pose, state, &damper);
        } else {
            force = springs.weigh(mechanism.scheme, end, pose, state, nullptr);
        }
        add_wrenches(force, four.from, four.to, wrench);
        const Lanes squared = squared_norm(force.force);
        largest = std::max({largest, squared[0], squared[1], squared[2], squared[3]});
    }
    return largest;
}

[[gnu::always_inline]] inline void JointsByFour::advance_at(Mechanism& mechanism, const auto& frame,
                                                            const auto& wrench) const {
    constexpr bool kAddsForces = !std::is_null_pointer_v<std::remove_cvref_t<decltype(wrench)>>;
    for (const Four& four : fours_) {
        const FrameOf<Lanes> from = gather_frames(frame, four.from), to = gather_frames(frame, four.to);
        const SpringsOf<Lanes>& springs = springs_[four.springs];
        const JointAxesOf<Lanes>& axes = axes_[four.axes];
        const JointPoseOf<Lanes> pose = four.point.pose(axes, from, to);
        const StrainedOf<Lanes> end = springs.strain(four.point.rest, pose, axes.axes_at_to(to));
        const auto states = each_of(four.joint, [&](uint32_t j) { return &mechanism.states[j]; });
        const auto state_of = [&](size_t k) -> auto& { return *states[k]; };
        auto state = gather_records<JointStateOf>(state_of);
        const auto pose_now = [&] {
            const auto now = numbers_in(mechanism.frames);
            return four.point.pose(axes, gather_frames(now, four.from), gather_frames(now, four.to));
        };
        const auto move_on = [&](DamperStateOf<Lanes>* damper) {
            if constexpr (kAddsForces)
                add_wrenches(springs.weigh(mechanism.scheme, end, pose, state, damper), four.from, four.to, wrench);
            springs.advance(mechanism.scheme, end, pose, pose_now, state, damper);
        };
        if (four.keeps_rates) {
            const auto at = each_of(four.damper, [&](uint32_t d) { return numbers_of(mechanism.dampers[d]); });
            DamperStateOf<Lanes> damper;
            gather_dampers(springs.turns, at, damper);
            move_on(&damper);
            scatter_dampers(springs.turns, damper, at);
        } else {
            move_on(nullptr);
        }
        scatter_records(state, state_of);
    }
}

/// Calls take(four, its springs, their poses, their states) for every four at t_{n−1}.
[[gnu::always_inline]] inline void JointsByFour::for_each_before(const Mechanism& mechanism, const auto& take) const {
    const auto frame = numbers_in(mechanism.before);
    for (const Four& four : fours_) {
        const JointPoseOf<Lanes> pose =
            four.point.pose(axes_[four.axes], gather_frames(frame, four.from), gather_frames(frame, four.to));
        const auto states = each_of(four.joint, [&](uint32_t j) { return &mechanism.states[j]; });
        take(four, springs_[four.springs], pose,
             gather_records<JointStateOf>([&](size_t k) -> auto& { return *states[k]; }));
    }
}

DTTMM_WIDE double JointsByFour::add_forces(const Mechanism& mechanism, const std::vector<Frame>& trial,
                                           std::vector<Vector6>& wrench) const {
    return add_forces_at(mechanism, numbers_in(trial), wrenches_in(wrench));
}

DTTMM_WIDE void JointsByFour::advance(Mechanism& mechanism, const std::vector<Frame>& next,
                                      std::vector<Vector6>& wrench) const {
    advance_at(mechanism, numbers_in(next), wrenches_in(wrench));
}

DTTMM_WIDE void JointsByFour::add_forces(const PortBodies& ports, const dttmm_motion* trial, double* wrenches) const {
    add_forces_at(ports.mechanism, numbers_in(ports, trial),
                  [&](uint32_t frame) { return ports.on_body(as_int(frame), wrenches); });
}

DTTMM_WIDE void JointsByFour::advance(Mechanism& mechanism, const PortBodies& ports, const dttmm_motion* next) const {
    advance_at(mechanism, numbers_in(ports, next), nullptr);
}

DTTMM_WIDE void JointsByFour::add_forces_before(const Mechanism& mechanism, std::vector<Vector6>& rates,
                                                std::vector<Vector6>& wrench) const {
    const auto take = [&](const Four& four, const SpringsOf<Lanes>& springs, const JointPoseOf<Lanes>& pose,
                          const JointStateOf<Lanes>& state) {
        const auto at = each_of(four.joint, [&](uint32_t j) { return rates[j].data(); });
        SixLanes rate = SixLanes::Zero();
        if (four.keeps_rates) gather<6>({at[0], at[1], at[2], at[3]}, rate.data());
        const SixLanes x = state.deformation_before(), f = springs.force(x, springs.along(x), rate);
        scatter<6>(f.data(), {at[0], at[1], at[2], at[3]});
        add_wrenches(pose.act(f), four.from, four.to, wrenches_in(wrench));
    };
    for_each_before(mechanism, take);
}

DTTMM_WIDE void JointsByFour::add_mean_forces(const Mechanism& mechanism, std::vector<Vector6>& wrench) const {
    const double per_step = 1 / mechanism.scheme.step_size();
    const auto take = [&](const Four& four, const SpringsOf<Lanes>& springs, const JointPoseOf<Lanes>& pose,
                          const JointStateOf<Lanes>& state) {
        SixLanes rate = SixLanes::Zero();
        if (four.keeps_rates) {
            const auto damper = each_of(four.damper, [&](uint32_t d) { return &mechanism.dampers[d]; });
            for (int half = 0; half < (springs.turns ? 2 : 1); ++half) {
                const auto increment = [&](size_t k) { return damper[k]->halves[half].delta[0].data(); };
                gather<3>({increment(0), increment(1), increment(2), increment(3)}, &rate(3 * half));
            }
            rate *= Lanes(per_step);
        }
        const SixLanes x = state.deformation_before();
        JointForceOf<Lanes> force = pose.act(springs.force(x, Lanes(0.5) * springs.along(x), rate));
        force.add(0.5, state.elastic);
        add_wrenches(force, four.from, four.to, wrenches_in(wrench));
    };
    for_each_before(mechanism, take);
}

}  // namespace dttmm::plugin
