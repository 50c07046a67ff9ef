// SPDX-License-Identifier: BSD-3-Clause
#include "time/inner_loads.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "time/inside_math.h"

namespace dttmm::plugin {

InnerLoads::InnerLoads(Inside& inside) : inside_(inside), values_(inside.loading.value_count(), 0.0) {
    const size_t count = inside.massless.frames().size();
    for (auto* list : {&end_wrench_, &damping_wrench_}) list->assign(count, Vector6::Zero());
    residuals_.resize(count);
}

void InnerLoads::read(const double* loads) {
    if (loads)
        std::copy_n(loads, values_.size(), values_.begin());
    else
        std::ranges::fill(values_, 0.0);
}

void InnerLoads::start_loads() {
    for (size_t k = 0; k < inside_.loaded.size(); ++k) {
        Inside::FrameLoad& own = inside_.frame_loads[k];
        own.load[1] = own.load[2] = load_at_end(k, inside_.now(inside_.loaded[k]));
    }
}

void InnerLoads::start_elastic() {
    take_elastic();
    for (size_t i : inside_.massless.frames()) {
        Inside::FrameLoad& own = inside_.frame_load(i);
        own.elastic[1] = own.elastic[2] = own.elastic[0];
        own.settled = -in_axes(inside_.now(i), own.elastic[0]);
    }
}

/// The load on a loaded frame at the end of the step, at its origin, when it is then at `frame`.
Vector6 InnerLoads::load_at_end(size_t loaded, FrameView frame) const {
    return inside_.loading.wrench(as_int(inside_.frame_of(inside_.loaded[loaded])), frame, values_.data());
}

Vector6 InnerLoads::load_over_step(size_t loaded, FrameView frame) const {
    const Scheme& scheme = inside_.mechanism.scheme;
    const Inside::FrameLoad& own = inside_.frame_loads[loaded];
    return scheme.weight(0) * load_at_end(loaded, frame) + scheme.weight(1) * own.load[1] + scheme.weight(2) * own.load[2];
}

void InnerLoads::add_over_step() {
    for (size_t k = 0; k < inside_.loaded.size(); ++k) {
        const size_t f = inside_.frame_of(inside_.loaded[k]);
        inside_.wrench[f] += load_over_step(k, inside_.trial[f]);
    }
}

void InnerLoads::forget_wrenches() {
    for (auto* wrenches : {&end_wrench_, &damping_wrench_}) std::ranges::fill(*wrenches, Vector6::Zero());
}

void InnerLoads::balance_massless(std::span<Vector6> lack) {
    const MasslessFrames& massless = inside_.massless;
    const Scheme& scheme = inside_.mechanism.scheme;
    const double h = inside_.step_size();
    const std::vector<size_t>& frames = massless.frames();
    for (size_t m = 0; m < frames.size(); ++m) {
        const size_t i = frames[m];
        const Inside::FrameLoad& own = inside_.frame_load(i);
        const FrameView now = inside_.now(i), end = inside_.trial[inside_.frame_of(i)];
        const Vector6 load = load_at_end(as_size(inside_.load_of[i]), end);
        const Vector6 elastic = in_axes(end, end_wrench_[m]), load_then = in_axes(end, load);
        MasslessFrames::Residual& residual = residuals_[m];
        residual.step = lack[i];
        // Both with the factors that make their derivatives by the end of the step those of the forces over it
        residual.end = h * (scheme.weight(0) + massless.relaxation(m) * scheme.rate(0)) * (elastic + settled(m, load_then));
        residual.half_way = 0.25 * h * (elastic + load_then + in_axes(now, own.elastic[1] + own.load[1])) +
                            0.5 * h * in_axes(now, damping_wrench_[m]);
    }
    massless.combine(residuals_);
    for (size_t m = 0; m < frames.size(); ++m) {
        const size_t i = frames[m];
        const int receiver = inside_.receivers[i];
        Vector6 balance = residuals_[m].step;
        if (massless.balances_at_end(m)) {  // in the axes at t_n, as the matrix has it: otherwise passes converge slowly
            const RowMajor3 turn = inside_.now(i).axes().transpose() * FrameView(inside_.trial[inside_.frame_of(i)]).axes();
            for (int half : {0, 1})
                if (massless.has_none(m, half)) balance.segment<3>(3 * half) = (turn * balance.segment<3>(3 * half)).eval();
        }
        const Vector6 left = lack[i] - balance;
        lack[i] = balance;
        if (!inside_.is_inner(receiver)) continue;
        lack[inside_.at(receiver)] += in_axes(inside_.mechanism.frame(receiver),
                                              passed_on(inside_.mechanism.frames, i, in_world(inside_.now(i), left)));
    }
}

/// What the elastic forces on a massless frame balance at the end of the step, its axes: ψ + τ ψ' = load, exactly for a load
/// that goes along a line in between. `m`: index into MasslessFrames::frames(); load: at the end of the step.
Vector6 InnerLoads::settled(size_t m, const Vector6& load) const {
    const double relaxation = inside_.massless.relaxation(m) / inside_.step_size();
    if (relaxation == 0) return load;
    const size_t i = inside_.massless.frames()[m];
    const Inside::FrameLoad& own = inside_.frame_load(i);
    const Vector6 load_now = in_axes(inside_.now(i), own.load[1]);
    const double relaxed = -std::expm1(-1 / relaxation);
    return load - relaxation * relaxed * (load - load_now) + (1 - relaxed) * (own.settled - load_now);
}

Vector6 InnerLoads::passed_on(const std::vector<Frame>& frames, size_t i, const Vector6& left) const {
    const auto origin = [&](size_t f) { return FrameView(frames[f]).origin(); };
    Vector6 wrench = left;
    wrench.tail<3>() += Vector3(origin(inside_.frame_of(i)) - origin(as_size(inside_.receivers[i]))).cross(head(left));
    return wrench;
}

Vector6 InnerLoads::left_over(size_t i, FrameView end) const {
    const Vector6 left = inside_.wrench[inside_.frame_of(i)] + load_over_step(as_size(inside_.load_of[i]), end) +
                         inside_.momenta[i] / inside_.step_size();
    return passed_on(inside_.mechanism.frames, i, massless_part(i, left));
}

Vector6 InnerLoads::massless_part(size_t i, Vector6 wrench) const {
    for (int half : {0, 1})
        if (!inside_.massless.is_massless(i, half)) wrench.segment<3>(3 * half).setZero();
    return wrench;
}

/// By the same force and lever arm as in the equations of the motion. Another lever arm would drive the motion: let a
/// lasting load P act on a node at the end of a beam, and let the momentum take the elastic force −P with the arm l_n of the
/// instant. The motion has (l_{n+1} + 2 l_n + l_{n−1})/4. With θ the turn of the last lump and g = P l its stiffness by the
/// load,
///     J (θ_{n+1} − 2θ_n + θ_{n−1})/h² = −g (θ_{n+1} + θ_n + 3θ_{n−1} − θ_{n−2})/4
/// in place of (θ_{n+1} + 2θ_n + θ_{n−1})/4. That is not symmetric in time: a negative damping in proportion to P.
void InnerLoads::pass_momenta_on() {
    for (size_t i : inside_.massless.frames()) {
        if (!inside_.is_inner(inside_.receivers[i])) continue;
        const size_t receiver = inside_.at(inside_.receivers[i]);
        Vector6 force = left_over(i, inside_.trial[inside_.frame_of(i)]);
        for (int half : {0, 1})
            if (inside_.massless.is_massless(receiver, half)) force.segment<3>(3 * half).setZero();
        inside_.momenta[receiver] += inside_.step_size() * force;
    }
}

void InnerLoads::take_elastic() {
    for (size_t i : inside_.massless.frames()) inside_.frame_load(i).elastic[0].setZero();
    const auto elastic_on = [&](int frame) {
        const bool is_massless = inside_.is_inner(frame) && inside_.massless.index_of(inside_.at(frame)) >= 0;
        return is_massless ? inside_.frame_load(inside_.at(frame)).elastic[0].data() : nullptr;
    };
    for (size_t j : inside_.settling_joints) {
        const Joint& joint = inside_.mechanism.joints[j];
        Joint::add_wrench(inside_.mechanism.states[j].elastic, elastic_on(joint.from()), elastic_on(joint.to()));
    }
}

void InnerLoads::take_step() {
    for (size_t m = 0; m < inside_.massless.frames().size(); ++m) {
        const size_t i = inside_.massless.frames()[m];
        const FrameView end = inside_.trial[inside_.frame_of(i)];
        Inside::FrameLoad& own = inside_.frame_load(i);
        own.settled = settled(m, in_axes(end, load_at_end(as_size(inside_.load_of[i]), end)));
        own.elastic[2] = own.elastic[1];
        own.elastic[1] = own.elastic[0];
    }
    // Mean force times displacement: exact for Newmark's rule
    Inside::Record& record = inside_.record;
    record.load_work += record.last_work;
    record.last_work = 0;
    for (size_t k = 0; k < inside_.loaded.size(); ++k) {
        const size_t i = inside_.loaded[k];
        Inside::FrameLoad& own = inside_.frame_loads[k];
        own.load[0] = load_at_end(k, inside_.trial[inside_.frame_of(i)]);
        record.last_work += 0.5 * inside_.step_size() * (own.load[1] + own.load[0]).dot(joined(inside_.past.velocity[i]));
        own.load[2] = own.load[1];
        own.load[1] = own.load[0];
    }
}

}  // namespace dttmm::plugin
