// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/joint.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "core/error.h"
#include "core/index.h"
#include "core/rotation.h"

namespace dttmm::plugin {

void Joint::set_scheme(const Scheme& scheme) {
    try {
        kind_->set_scheme(scheme);
    } catch (const Error& error) {
        throw Error(error.status(), error.what(), element());
    }
}

// ---- The force law ------------------------------------------------------------------------------------------------------

/// What the law of a direction answers; a fault names the element.
LawOnPath Joint::ask(int direction, const LawPath& path) const {
    if (at_work_) *at_work_ = reported_;
    try {
        const LawOnPath answer = kind_->law->along(direction, path);
        if (at_work_) *at_work_ = -1;
        return answer;
    } catch (const Error& error) {
        throw Error(error.status(), error.what(), element());
    }
}

/// The forces of laws in place of those of linear springs.
void Joint::put_laws(const LawsAt& from, const Vector6& x, Vector6& f) const {
    for (int d = 0; d < 6; ++d) f(d) = ask(d, {from.x(d), x(d), from.time, from.memory}).force;
}

/// Its derivative by the deformations.
Vector6 Joint::spring_tangent(const LawsAt& from, const Vector6& x) const {
    if (!kind_->has_laws) return kind_->law->stiffness;
    Vector6 k;
    for (int d = 0; d < 6; ++d) k(d) = ask(d, {from.x(d), x(d), from.time, from.memory}).tangent;
    return k;
}

double Joint::energy_of_laws(const Vector6& x, const double* memory) const {
    double stored = 0;
    for (int d = 0; d < 6; ++d) stored += ask(d, {x(d), x(d), 0, memory}).stored;
    return stored;
}

LawOnPath Joint::law_on_path(int direction, const LawPath& path) const {
    LawOnPath on_path = ask(direction, path);
    if (takes_ends_[direction / 3]) {
        on_path.mean = 0.5 * (ask(direction, {path.from, path.from, 0, path.memory}).force + on_path.force);
        on_path.mean_tangent = 0.5 * on_path.tangent;
    }
    return on_path;
}

Joint::OnPath Joint::on_path(const Scheme& scheme, int direction, double now, double end, const double* memory) const {
    const double weight = scheme.elastic_weight(0), lag = scheme.lag(), k = kind_->law->stiffness(direction);
    const LawOnPath path = law_on_path(direction, {now, end, scheme.step_size(), memory});
    const double start = ask(direction, {now, now, 0, memory}).force;
    OnPath step;
    step.mean = path.mean - 0.5 * (start + path.force);
    step.rate = lag * (path.force - start - k * (end - now)) + 0.5 * step.mean;
    step.rate_gain = lag * (path.tangent - k) + 0.5 * (path.mean_tangent - 0.5 * path.tangent);
    step.force = weight * path.force + step.rate;
    step.gain = weight * path.tangent + step.rate_gain;
    return step;
}

Joint::Beyond Joint::beyond(const Scheme& scheme, const Vector6& x, const Vector6& end, const double* memory) const {
    Beyond beyond;
    for (int d = 0; d < 6; ++d) {
        if (!kind_->law->laws[as_size(d)]) continue;
        const OnPath step = on_path(scheme, d, x(d), end(d), memory);
        beyond.force(d) = step.force - scheme.elastic_weight(0) * kind_->law->stiffness(d) * end(d);
        beyond.mean(d) = step.mean;
        beyond.rate(d) = step.rate;
        beyond.gain(d) = step.rate_gain;
    }
    return beyond;
}

JointForce Joint::act(const JointPose& pose, const Vector6& x, const Vector6& f) const {
    return kind_->springs.act(pose, x.head<3>(), x.tail<3>(), f.head<3>(), f.tail<3>(), Vector3::Zero());
}

void Joint::strain_laws(Ends at, const JointPose& pose, const LawsAt& from, Strained& strained) const {
    if (is_axial()) strained.d = strained.strains = deformation(pose, at.from, at.to).head<3>();
    const Vector6 x = strained.deformation();
    Vector6 f;
    put_laws(from, x, f);
    strained.elastic = act(pose, x, f);
}

/// Laws come to where the joint is at the start on the straight way.
void Joint::start_laws(Ends at, const JointPose& pose, LawMemory memory, Strained& strained) const {
    const Vector6 x = deformation(pose, at.from, at.to);
    if (is_axial()) strained.d = strained.strains = x.head<3>();
    const size_t size = kind_->law->memory_before(6);
    std::fill_n(memory.before, size, 0.0);
    std::fill_n(memory.now, size, 0.0);
    for (int d = 0; d < 6; ++d) ask(d, {0, x(d), 0, memory.before, memory.now});
    std::copy_n(memory.now, size, memory.before);
    strained.elastic = act(pose, x, spring_force(x, memory.now));
}

/// Adds to the force over the step what laws do otherwise than linear springs.
void Joint::add_laws(const Scheme& scheme, const Strained& end, const JointPose& at_end, const JointState& state,
                     const double* memory, JointForce& force) const {
    if (!scheme.is_implicit()) return;
    const Beyond more = beyond(scheme, state.deformation(), end.deformation(), memory);
    force.add(1, act(at_end, end.deformation(), more.force));
}

Matrix6 Joint::stiffness_tangent(const Vector6& x, const double* memory) const {
    return along(x, spring_tangent({x, memory, 0}, x));
}

/// Of translations: Gᵀ k G, G the columns of the strains.
Matrix6 Joint::of_translations(const Vector6& x, const Vector3& k) const {
    Matrix6 K = Matrix6::Zero();
    if (!is_line()) {
        K.diagonal().head<3>() = k;
        return K;
    }
    const Matrix36 G = strain_columns(x);
    K.noalias() = G.transpose() * k.asDiagonal() * G;
    return K;
}

/// The change of d that makes a change of the strains with a relative turn.
Vector3 Joint::motion_of_strains(const Vector6& x, const Vector6& change) const {
    if (!is_line()) return change.head<3>();
    const Matrix36 G = strain_columns(x);
    return G.leftCols<3>().inverse() * (change.head<3>() - G.rightCols<3>() * change.tail<3>());
}

/// Of springs of the stiffness k along the strains.
Matrix6 Joint::along(const Vector6& x, const Vector6& k) const {
    Matrix6 K = of_translations(x, k.head<3>());
    if (!turns()) return K;
    const Matrix3 inverse_J = rotation_vector_rate(x.tail<3>());
    K.bottomRightCorner<3, 3>() += inverse_J.transpose() * k.tail<3>().asDiagonal() * inverse_J;
    return K;
}

Matrix6 Joint::damping_tangent(const Vector6& x) const {
    Matrix6 C = of_translations(x, kind_->springs.halves[0].damping);
    C.diagonal().tail<3>() += kind_->springs.halves[1].damping;
    return C;
}

Matrix6 Joint::gain(const Scheme& scheme, const Vector6& now, const Vector6& x, const double* memory) const {
    // Beside the elastic force over the step there are its dampers, and the scheme's own
    const double weight = scheme.elastic_weight(0);
    Matrix6 gain = weight * along(x, spring_tangent({now, memory, scheme.step_size()}, x));
    if (kind_->has_laws) gain += along(x, beyond(scheme, now, x, memory).gain);
    Vector6 other;
    other << kind_->solved[0] - weight * kind_->springs.halves[0].stiffness,
        kind_->solved[1] - weight * kind_->springs.halves[1].stiffness;
    gain += of_translations(x, other.head<3>());
    if (turns()) gain.diagonal().tail<3>() += other.tail<3>();
    return gain;
}

// ---- Time steps ---------------------------------------------------------------------------------------------------------

/// The past before the start is the parabola through it, which suits every explicit scheme; for the centred one the elastic
/// force before the start counts as that at the start.
void Joint::start(const Scheme& scheme, FrameView from, FrameView to, const Vector6& rate, const Vector6& acceleration,
                  JointState& state, DamperState* damper, LawMemory memory) const {
    const double h = scheme.step_size();
    const JointPose now = pose(from, to);
    Strained strained = kind_->springs.strain(seat_.rest, now, seat_.axes_at_to(to));
    if (kind_->has_laws) start_laws({from, to}, now, memory, strained);
    state.elastic = strained.elastic;
    state.d = strained.d;
    state.theta = strained.theta;
    const auto increment = [&](int back) -> Vector6 { return h * rate - (back + 0.5) * h * h * acceleration; };
    state.d_before = state.d - motion_of_strains(strained.deformation(), increment(0));
    state.theta_before = turns() ? Vector3(state.theta - increment(0).tail<3>()) : Vector3(Vector3::Zero());
    if (damper) {
        for (int half : {0, 1}) {
            for (int back = 0; back < 3; ++back) damper->halves[half].delta[back] = increment(back).segment<3>(3 * half);
        }
        damper->attitude = turns() ? strained.attitude : Matrix3(Matrix3::Identity());
        damper->dissipated = 0;
        damper->last_loss = 0;
    }
    if (!scheme.is_implicit()) return kind_->springs.recall(scheme, now, state.elastic, state, damper);
    // The rate of the first step is Newmark's from d, d', d'': γ δ₊/h + (1 − γ) d' + (β − γ/2) h d''
    const double gamma = scheme.centred().gamma;
    const Vector6 known = (1 - gamma) * rate + (scheme.centred().beta - 0.5 * gamma) * h * acceleration;
    state.known = {};
    state.known.add(1 - scheme.elastic_weight(0), state.elastic);
    state.known.add(
        1, kind_->springs.act(now, state.d, state.theta, kind_->springs.halves[0].damping.cwiseProduct(known.head<3>()),
                              Vector3::Zero(), kind_->springs.halves[1].damping.cwiseProduct(known.tail<3>())));
}

JointForce Joint::damping_half_way(Ends trial, Ends now, double h, const JointState& state,
                                   const DamperState& damper) const {
    const JointPose at = pose(now), end = pose(trial);
    const Vector6 x = deformation(end, trial.from, trial.to);
    const auto strains = [&](const Vector3& d, const Vector3& theta) { return kind_->springs.strains(d, theta); };
    const Vector3 slide = (kind_->springs.halves[0].damping / h)
                              .cwiseProduct(strains(x.head<3>(), x.tail<3>()) - strains(state.d, state.theta));
    Vector3 turn = Vector3::Zero();
    if (turns())
        turn = (kind_->springs.halves[1].damping / h)
                   .cwiseProduct(rotation_vector(attitude(trial.from, trial.to) * damper.attitude.transpose()));
    const Vector3 d = 0.5 * (x.head<3>() + state.d), theta = 0.5 * (x.tail<3>() + state.theta);
    return kind_->springs.act({0.5 * (end.axes + at.axes), at.arm, at.lever}, d, theta, slide, Vector3::Zero(), turn);
}

[[gnu::flatten]] void Joint::advance(const Scheme& scheme, Ends next, Ends now, JointState& state, DamperState* damper,
                                     LawMemory memory, JointForce* force) const {
    if (kind_->has_laws) [[unlikely]]
        return advance_with_laws(scheme, next, now, state, damper, memory, force);
    const JointPose at_end = seat_.pose(next.from, next.to);
    const Strained end = kind_->springs.strain(seat_.rest, at_end, seat_.axes_at_to(next.to));
    if (force) *force = kind_->springs.weigh(scheme, end, at_end, state, damper);
    kind_->springs.advance(
        scheme, end, at_end, [&] { return seat_.pose(now.from, now.to); }, state, damper);
}

/// The same; what laws did over the step is known of the coming one too.
void Joint::advance_with_laws(const Scheme& scheme, Ends next, Ends now, JointState& state, DamperState* damper,
                              LawMemory memory, JointForce* force) const {
    const JointPose at_end = pose(next), at_now = pose(now);
    const Strained end = strain(scheme, next, at_end, state, memory.now);
    if (force) *force = weigh(scheme, end, at_end, state, damper, memory.now);
    kind_->springs.advance(
        scheme, end, at_end, [&] { return at_now; }, state, damper);
    const Vector6 start = state.deformation_before(), x = state.deformation();
    if (scheme.is_implicit()) state.known.add(1, act(at_now, start, beyond(scheme, start, x, memory.now).rate));
    std::copy_n(memory.now, kind_->law->memory_before(6), memory.before);
    for (int d = 0; d < 6; ++d)
        damper->last_loss += ask(d, {start(d), x(d), scheme.step_size(), memory.before, memory.now}).dissipated;
}

}  // namespace dttmm::plugin
