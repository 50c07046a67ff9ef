// SPDX-License-Identifier: BSD-3-Clause
#include "network/joints_by_four.h"

#include <algorithm>
#include <array>

namespace dttmm {

namespace {

constexpr size_t kCount = Lanes::kCount;

/// Four records of numbers, Record<double>, side by side as one Record<Lanes>; and the way back.
template <template <class> class Record>
[[gnu::always_inline]] inline Record<Lanes> gather_records(const Record<double>* const (&one)[kCount]) {
    static_assert(sizeof(Record<Lanes>) == Record<double>::kNumbers * sizeof(Lanes));
    const double* numbers[kCount];
    for (size_t k = 0; k < kCount; ++k) numbers[k] = reinterpret_cast<const double*>(one[k]);
    Record<Lanes> four;
    gather<Record<double>::kNumbers>(numbers, reinterpret_cast<Lanes*>(&four));
    return four;
}
template <template <class> class Record>
[[gnu::always_inline]] inline void scatter_records(const Record<Lanes>& four, Record<double>* const (&one)[kCount]) {
    double* numbers[kCount];
    for (size_t k = 0; k < kCount; ++k) numbers[k] = reinterpret_cast<double*>(one[k]);
    scatter<Record<double>::kNumbers>(reinterpret_cast<const Lanes*>(&four), numbers);
}

[[gnu::always_inline]] inline FrameOf<Lanes> gather_frames(const std::vector<Frame>& frames, const size_t (&index)[kCount]) {
    const Frame* one[kCount];
    for (size_t k = 0; k < kCount; ++k) one[k] = &frames[index[k]];
    return gather_records<FrameOf>(one);
}

/// Adds forces of four joints to the wrenches on their frames; returns the largest force's square.
[[gnu::always_inline]] inline double add_wrenches(const JointForceOf<Lanes>& force, const size_t (&from)[kCount],
                                                  const size_t (&to)[kCount], std::vector<Vector6>& wrench) {
    JointForce each[kCount];
    JointForce* const one[kCount] = {&each[0], &each[1], &each[2], &each[3]};
    scatter_records<JointForceOf>(force, one);
    for (size_t k = 0; k < kCount; ++k) Joint::add_wrench(each[k], wrench[from[k]].data(), wrench[to[k]].data());
    const Lanes squared = detail::squared(force.force);
    return std::max({squared[0], squared[1], squared[2], squared[3]});
}

}  // namespace

JointsByFour::JointsByFour(const Mechanism& mechanism, std::span<const size_t> joints) {
    std::vector<size_t> open[2][2];  // by what they carry, by damping
    for (size_t j : joints) {
        const Joint& joint = mechanism.joints[j];
        const bool is_damped = mechanism.damper(j) != nullptr;
        std::vector<size_t>& four = open[joint.turns()][is_damped];
        four.push_back(j);
        if (four.size() < kCount) continue;
        Four& taken = fours_.emplace_back();
        taken.is_damped = is_damped;
        taken.springs.turns = joint.turns();
        taken.seat.is_aligned = taken.seat.is_straight = true;
        taken.seat.has_lever = false;
        for (size_t k = 0; k < kCount; ++k) {
            const Joint& one = mechanism.joints[four[k]];
            const auto i = static_cast<int>(k);
            taken.joint[k] = four[k];
            taken.from[k] = static_cast<size_t>(one.from());
            taken.to[k] = static_cast<size_t>(one.to());
            for (int half : {0, 1}) {
                set_lane(taken.springs.halves[half].stiffness, i, one.springs().halves[half].stiffness);
                set_lane(taken.springs.halves[half].damping, i, one.springs().halves[half].damping);
            }
            set_lane(taken.springs.rest, i, one.springs().rest);
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
    for (const auto& by_damping : open)
        for (const std::vector<size_t>& left : by_damping) others_.insert(others_.end(), left.begin(), left.end());
    std::sort(others_.begin(), others_.end());
}

DTTMM_WIDE double JointsByFour::add_forces(const Mechanism& mechanism, const std::vector<Frame>& trial,
                                           std::vector<Vector6>& wrench) const {
    double largest = 0;
    for (const Four& four : fours_) {
        const FrameOf<Lanes> from = gather_frames(trial, four.from), to = gather_frames(trial, four.to);
        const StrainedOf<Lanes> end = four.springs.strain(four.seat.pose(from, to), four.seat.axes_at_to(to));
        const JointState* states[kCount];
        for (size_t k = 0; k < kCount; ++k) states[k] = &mechanism.states[four.joint[k]];
        const JointStateOf<Lanes> state = gather_records<JointStateOf>(states);
        const auto now = [&] {
            return four.seat.pose(gather_frames(mechanism.frames, four.from), gather_frames(mechanism.frames, four.to));
        };
        JointForceOf<Lanes> force;
        if (four.is_damped) {
            const DamperState* dampers[kCount];
            for (size_t k = 0; k < kCount; ++k) dampers[k] = mechanism.damper(four.joint[k]);
            const DamperStateOf<Lanes> damper = gather_records<DamperStateOf>(dampers);
            force = four.springs.weigh(mechanism.scheme, end, now, state, &damper);
        } else {
            force = four.springs.weigh(mechanism.scheme, end, now, state, nullptr);
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
        JointState* states[kCount];
        for (size_t k = 0; k < kCount; ++k) states[k] = &mechanism.states[four.joint[k]];
        JointStateOf<Lanes> state = gather_records<JointStateOf>({states[0], states[1], states[2], states[3]});
        const auto now = [&] {
            return four.seat.pose(gather_frames(mechanism.frames, four.from), gather_frames(mechanism.frames, four.to));
        };
        const auto move_on = [&](DamperStateOf<Lanes>* damper) {
            const JointForceOf<Lanes> force = four.springs.weigh(mechanism.scheme, end, now, state, damper);
            four.springs.advance(mechanism.scheme, mechanism.steps, end, pose, state, damper);
            add_wrenches(force, four.from, four.to, wrench);
        };
        if (four.is_damped) {
            DamperState* dampers[kCount];
            for (size_t k = 0; k < kCount; ++k) dampers[k] = mechanism.damper(four.joint[k]);
            DamperStateOf<Lanes> damper = gather_records<DamperStateOf>({dampers[0], dampers[1], dampers[2], dampers[3]});
            move_on(&damper);
            scatter_records(damper, dampers);
        } else {
            move_on(nullptr);
        }
        scatter_records(state, states);
    }
}

DTTMM_WIDE void move_frames(double h, std::span<const Frame> from, std::span<const Vector6> u, std::span<Frame> to) {
    const auto move = [h]<class Real>(const FrameOf<Real>& now, const Eigen::Matrix<Real, 6, 1>& u_, FrameOf<Real>& next) {
        const Vector3Of<Real> way = now.axes() * u_.template head<3>(), turn = Real(h) * u_.template tail<3>();
        Eigen::Map<Vector3Of<Real>>{next.position} = now.origin() + Real(h) * way;
        Eigen::Map<RowMajor3Of<Real>>{next.rotation}.noalias() = now.axes() * rotation_from_vector<Real>(turn);
    };
    size_t i = 0;
    for (; i + kCount <= from.size(); i += kCount) {
        const FrameOf<Lanes> now = gather_records<FrameOf>({&from[i], &from[i + 1], &from[i + 2], &from[i + 3]});
        Eigen::Matrix<Lanes, 6, 1> velocity;
        gather<6>({u[i].data(), u[i + 1].data(), u[i + 2].data(), u[i + 3].data()}, velocity.data());
        FrameOf<Lanes> next;
        move(now, velocity, next);
        scatter_records<FrameOf>(next, {&to[i], &to[i + 1], &to[i + 2], &to[i + 3]});
    }
    for (; i < from.size(); ++i) move(from[i], u[i], to[i]);
}

}  // namespace dttmm
