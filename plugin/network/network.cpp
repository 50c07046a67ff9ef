// SPDX-License-Identifier: BSD-3-Clause
#include "network/network.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/rotation.h"
#include "element/registry.h"

namespace dttmm {

namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

Eigen::Map<const Vector3> vector(const double* v) { return Eigen::Map<const Vector3>(v); }
Eigen::Map<const RowMajor3> matrix(const double* m) { return Eigen::Map<const RowMajor3>(m); }
Eigen::Map<Vector3> vector(double* v) { return Eigen::Map<Vector3>(v); }

/// The output channels of every joint, in the order outputs() writes them.
struct JointChannel {
    const char *name, *unit;
    uint32_t role = DTTMM_ROLE_RESULT;
};
constexpr JointChannel kChannels[] = {
    {"force.x", "N"},
    {"force.y", "N"},
    {"force.z", "N"},
    {"moment.x", "N*m"},
    {"moment.y", "N*m"},
    {"moment.z", "N*m"},
    {"deflection.x", "m"},
    {"deflection.y", "m"},
    {"deflection.z", "m"},
    {"rotation.x", "rad"},
    {"rotation.y", "rad"},
    {"rotation.z", "rad"},
    {"strain_energy", "J", DTTMM_ROLE_STRAIN_ENERGY},
    {"dissipated_energy", "J", DTTMM_ROLE_DISSIPATED_ENERGY},
};
constexpr size_t kChannelsPerJoint = std::size(kChannels);

bool is_rotation(const RowMajor3& R) {
    return R.allFinite() && (R * R.transpose() - RowMajor3::Identity()).cwiseAbs().maxCoeff() < 1e-9 && R.determinant() > 0;
}

}  // namespace

// ---- Construction -------------------------------------------------------------------------------------------------------

Network::Network(const dttmm_network& description)
    : scheme_(description.scheme), centred_{description.beta, description.gamma} {
    if (scheme_ > DTTMM_SCHEME_PARK) throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("there is no scheme {}", scheme_));
    if (is_implicit() && !(centred_.beta > 0 && std::isfinite(centred_.beta) && std::isfinite(centred_.gamma)))
        throw Error(DTTMM_ERROR_ARGUMENT, "the centred scheme wants a finite beta > 0 and a finite gamma");
    if (description.element_count == 0) throw Error(DTTMM_ERROR_MODEL, "a network without an element");

    const std::vector<End> ends = place_ends(description);
    for (uint32_t e = 0; e < description.element_count; ++e) build_joint(description, ends, e);
    joint_states_.resize(joints_.size());
    ports_.resize(static_cast<size_t>(port_count_));
}

std::vector<Network::End> Network::place_ends(const dttmm_network& description) {
    std::vector<End> ends;
    for (uint32_t i = 0; i < description.node_count; ++i) {
        const dttmm_node& node = description.nodes[i];
        if (node.kind > DTTMM_NODE_PORT)
            throw Error(DTTMM_ERROR_MODEL, fmt::format("node \"{}\": there is no node kind {}, or none this plugin knows",
                                                       node.name, node.kind));
        if (!vector(node.position).allFinite() || !is_rotation(matrix(node.rotation)))
            throw Error(DTTMM_ERROR_ARGUMENT,
                        fmt::format("node \"{}\": its position must be finite and its axes orthonormal", node.name));
        End end{node.kind == DTTMM_NODE_PORT ? port_count_++ : -1, {}};
        std::copy_n(node.position, 3, end.start.position);
        std::copy_n(node.rotation, 9, end.start.rotation);
        ends.push_back(end);
    }
    return ends;
}

void Network::build_joint(const dttmm_network& description, const std::vector<End>& ends, uint32_t index) {
    const dttmm_element& data = description.elements[index];
    const int element = static_cast<int>(index);
    if (data.end_count != 2 || data.ends == nullptr) throw Error(DTTMM_ERROR_MODEL, "it wants two ends", element);
    const uint32_t from = data.ends[0], to = data.ends[1];
    if (from >= ends.size() || to >= ends.size())
        throw Error(DTTMM_ERROR_MODEL, "an end is no node of the network", element);
    if (from == to) throw Error(DTTMM_ERROR_MODEL, "both ends are the same node", element);
    Joint joint{ends[from], ends[to], {}, -1, {}, {}, nullptr};
    if (joint.from.port < 0 && joint.to.port < 0) throw Error(DTTMM_ERROR_MODEL, "both ends are on the ground", element);
    try {
        joint.element = make_element(data.type, data.values);
    } catch (const Error& error) {
        throw Error(error.status(), error.what(), element);
    }
    for (int half : {kTranslation, kRotation}) {
        joint.halves[half].stiffness = joint.element->stiffness().segment<3>(3 * half);
        joint.halves[half].damping = joint.element->damping().segment<3>(3 * half);
        joint.halves[half].law.setZero();
    }
    if ((joint.element->carried() >> 3).any()) {
        joint.turn = static_cast<int>(turn_states_.size());
        turn_states_.emplace_back();
    }
    const RowMajor3 R_from = matrix(joint.from.start.rotation);
    joint.rest_position = R_from.transpose() * (vector(joint.to.start.position) - vector(joint.from.start.position));
    joint.rest_rotation = R_from.transpose() * matrix(joint.to.start.rotation);
    joints_.push_back(std::move(joint));
    for (const auto& [name, unit, role] : kChannels) channels_.push_back({name, unit, DTTMM_OF_ELEMENT, index, role});
}

void Network::load_weights(double weights[3]) const {
    weights[0] = is_implicit() ? centred_.weight_after() : 0;
    weights[1] = is_implicit() ? centred_.weight_now() : 1;
    weights[2] = is_implicit() ? centred_.weight_before() : 0;
}

// ---- Kinematics of a joint ----------------------------------------------------------------------------------------------

inline Network::FrameView Network::committed(const End& end) const {
    const Frame& frame = end.port < 0 ? end.start : ports_[static_cast<size_t>(end.port)];
    return {frame.position, frame.rotation};
}

inline Network::FrameView Network::trial(const End& end, const dttmm_motion* ports) {
    if (end.port < 0) return {end.start.position, end.start.rotation};
    return {ports[end.port].position, ports[end.port].rotation};
}

inline Vector3 Network::arm(FrameView from, FrameView to) { return vector(to.position) - vector(from.position); }

inline Vector3 Network::translation(const Joint& joint, FrameView from, const Vector3& arm) {
    return matrix(from.rotation).transpose() * arm - joint.rest_position;
}

Matrix3 Network::attitude(const Joint& joint, FrameView from, FrameView to) {
    return matrix(from.rotation).transpose() * matrix(to.rotation) * joint.rest_rotation.transpose();
}

Vector6 Network::deformation_rate(const Joint& joint, const dttmm_motion* ports) {
    // r = R_fromᵀ p,  p = p_to − p_from  =>  r' = R_fromᵀ (p' − ω_from × p)
    const FrameView from = trial(joint.from, ports), to = trial(joint.to, ports);
    Vector3 v = Vector3::Zero(), w = Vector3::Zero();
    if (joint.to.port >= 0) {
        v += vector(ports[joint.to.port].velocity);
        w += vector(ports[joint.to.port].angular_velocity);
    }
    if (joint.from.port >= 0) {
        const Vector3 w_from = vector(ports[joint.from.port].angular_velocity);
        v -= vector(ports[joint.from.port].velocity) + w_from.cross(arm(from, to));
        w -= w_from;
    }
    Vector6 rate;
    rate << matrix(from.rotation).transpose() * v, matrix(from.rotation).transpose() * w;
    return rate;
}

Vector6 Network::deformation_acceleration(const Joint& joint, const dttmm_motion* ports, const double* accelerations) {
    // r'' = R_fromᵀ (p'' − α × p − ω × (ω × p) − 2 ω × (p' − ω × p)),   ω and α of the `from` end
    const FrameView from = trial(joint.from, ports), to = trial(joint.to, ports);
    Vector3 a = Vector3::Zero(), alpha = Vector3::Zero(), p_rate = Vector3::Zero(), w_to = Vector3::Zero();
    if (joint.to.port >= 0) {
        a += vector(accelerations + 6 * joint.to.port);
        alpha += vector(accelerations + 6 * joint.to.port + 3);
        p_rate += vector(ports[joint.to.port].velocity);
        w_to = vector(ports[joint.to.port].angular_velocity);
    }
    if (joint.from.port >= 0) {
        const Vector3 p = arm(from, to);
        const Vector3 w = vector(ports[joint.from.port].angular_velocity);
        const Vector3 alpha_from = vector(accelerations + 6 * joint.from.port + 3);
        p_rate -= vector(ports[joint.from.port].velocity);
        a -= vector(accelerations + 6 * joint.from.port) + alpha_from.cross(p) + w.cross(w.cross(p)) +
             2 * w.cross(p_rate - w.cross(p));
        alpha -= alpha_from + w.cross(w_to);
    }
    Vector6 acceleration;
    acceleration << matrix(from.rotation).transpose() * a, matrix(from.rotation).transpose() * alpha;
    return acceleration;
}

// ---- Wrenches on the ports ----------------------------------------------------------------------------------------------

inline void Network::add_wrench(const Joint& joint, const Vector3& arm, const Vector3& F, const Vector3& M, double* wrench) {
    // to: (−F, −M); from: (F, M + arm × F): forces and moments of the two ends balance about any point
    if (joint.to.port >= 0) {
        double* on_to = wrench + 6 * joint.to.port;
        vector(on_to) -= F;
        vector(on_to + 3) -= M;
    }
    if (joint.from.port >= 0) {
        double* on_from = wrench + 6 * joint.from.port;
        vector(on_from) += F;
        vector(on_from + 3) += M + arm.cross(F);
    }
}

void Network::add_stiffness(const Joint& joint, const Answer& answer, FrameView from, FrameView to,
                            double* stiffness) const {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> S(stiffness, 6 * port_count_, 6 * port_count_);

    // [δd; δε] = G_to δ(pose_to) + G_from δ(pose_from)
    const Matrix3 to_local = matrix(from.rotation).transpose();
    Matrix6 G_to = Matrix6::Zero(), G_from = Matrix6::Zero();
    G_to.topLeftCorner<3, 3>() = G_to.bottomRightCorner<3, 3>() = to_local;
    G_from = -G_to;
    G_from.topRightCorner<3, 3>() = to_local * skew(arm(from, to));

    // δ(wrench_to) = −H [δd; δε],  δ(wrench_from) = +H [δd; δε] with the moment of the force over the lever arm
    Matrix6 H = Matrix6::Zero();
    H.topLeftCorner<3, 3>() = answer.R_now * answer.gain.asDiagonal();
    H.bottomRightCorner<3, 3>() = answer.R_now * answer.turn_gain;
    Matrix6 H_from = H;
    H_from.bottomLeftCorner<3, 3>() = skew(answer.arm_now) * H.topLeftCorner<3, 3>();

    const auto add = [&](int row_port, const Matrix6& rows, int column_port, const Matrix6& columns, double sign) {
        if (row_port < 0 || column_port < 0) return;
        S.block<6, 6>(6 * row_port, 6 * column_port) += sign * (rows * columns);
    };
    add(joint.to.port, H, joint.to.port, G_to, 1);
    add(joint.to.port, H, joint.from.port, G_from, 1);
    add(joint.from.port, H_from, joint.to.port, G_to, -1);
    add(joint.from.port, H_from, joint.from.port, G_from, -1);
}

void Network::linearise(const dttmm_motion* ports, double* wrench, double* stiffness, double* damping) const {
    const size_t n = 6 * static_cast<size_t>(port_count_);
    std::fill_n(wrench, n, 0.0);
    if (stiffness) std::fill_n(stiffness, n * n, 0.0);
    if (damping) std::fill_n(damping, n * n, 0.0);
    for (const Joint& joint : joints_) {
        const FrameView from = trial(joint.from, ports), to = trial(joint.to, ports);
        const Vector3 lever = arm(from, to);
        const Matrix3 R = matrix(from.rotation);
        const Half &slide = joint.halves[kTranslation], &turn = joint.halves[kRotation];
        const Vector6 rate = deformation_rate(joint, ports);

        // m = J⁻ᵀ(θ) (k ∘ θ) + c ∘ ω: the gradient of ½ θᵀ k θ, for δθ = J⁻¹ ε
        const Vector3 theta = joint.turn >= 0 ? rotation_vector(attitude(joint, from, to)) : Vector3(Vector3::Zero());
        const Matrix3 inverse_J = rotation_vector_rate(theta);
        const Vector3 f =
            slide.stiffness.cwiseProduct(translation(joint, from, lever)) + slide.damping.cwiseProduct(rate.head<3>());
        const Vector3 m =
            inverse_J.transpose() * turn.stiffness.cwiseProduct(theta) + turn.damping.cwiseProduct(rate.tail<3>());
        add_wrench(joint, lever, R * f, R * m, wrench);
        if (stiffness)
            add_stiffness(joint,
                          {slide.stiffness, inverse_J.transpose() * turn.stiffness.asDiagonal() * inverse_J, R, lever}, from,
                          to, stiffness);
        if (damping) add_stiffness(joint, {slide.damping, turn.damping.asDiagonal(), R, lever}, from, to, damping);
    }
}

// ---- The scheme ---------------------------------------------------------------------------------------------------------

namespace {

/// Velocity formula of an explicit scheme at t_n as weights of x at t_n, t_{n−1}, t_{n−2}, t_{n−3}: one unit history each.
/// The previous velocity that Fox-Euler wants is the host's, read as everywhere as the mean of those over the two steps
/// around t_{n−1}: (x_n − x_{n−2})/2h. With it the formula coincides with BDF2's. Its own recursion would be driven unstable
/// by a leap-frog host.
std::array<double, 4> velocity_weights(uint32_t scheme, double h) {
    const auto rule = [&](const History& past) {
        switch (scheme) {
            case DTTMM_SCHEME_BDF1:
                return bdf1(past, h);
            case DTTMM_SCHEME_BDF2:
                return bdf2(past, h);
            case DTTMM_SCHEME_HOUBOLT:
                return houbolt(past, h);
            case DTTMM_SCHEME_PARK:
                return park(past, h);
            default:
                return fox_euler(past, h);
        }
    };
    std::array<double, 4> weights{};
    for (size_t instant = 0; instant < 4; ++instant) {
        Vector6 x[4];
        for (size_t i = 0; i < 4; ++i) x[i] = Vector6::Constant(i == instant ? 1 : 0);
        History past;
        past.x = {x[1], x[2], x[3]};
        past.v = {(x[0] - x[2]) / (2 * h), (x[1] - x[3]) / (2 * h), Vector6::Zero()};
        past.a = {Vector6::Zero(), Vector6::Zero(), Vector6::Zero()};
        weights[instant] = rule(past).velocity(x[0])(0);
    }
    return weights;
}

}  // namespace

Network::Weights Network::weights_of(double h) const {
    // centred:  w₊ d₊ + w₀ d + w₋ d₋ = d + w₊ δ₊ − w₋ δ,   (γ d₊ + (1 − 2γ) d + (γ − 1) d₋)/h = (γ δ₊ + (1 − γ) δ)/h
    if (is_implicit())
        return {{centred_.weight_after(), -centred_.weight_before()}, {centred_.gamma / h, (1 - centred_.gamma) / h, 0, 0}};
    // explicit:  Σ w_i x_{n−i} with Σ w_i = 0, in increments
    const std::array<double, 4> w = velocity_weights(scheme_, h);
    return {{0, 0}, {0, w[0], w[0] + w[1], w[0] + w[1] + w[2]}};
}

void Network::set_step_size(double h) {
    clock_ = {h, 0};
    weights_ = weights_of(h);
    // The unknown of the transfer equations is the increment over the open step, or, explicit, the one that ends at t_n.
    const StepCoefficients step =
        is_implicit() ? StepCoefficients{weights_.elastic[0], weights_.rate[0]} : StepCoefficients{1, weights_.rate[1]};
    for (size_t j = 0; j < joints_.size(); ++j) {
        try {
            solve_law(joints_[j], step);
        } catch (const Error& error) {
            throw Error(error.status(), error.what(), static_cast<int>(j));
        }
    }
}

void Network::solve_law(Joint& joint, const StepCoefficients& step) const {
    // f = [−q; m] of the input end against d = x_O − x_I: −∂q/∂x_O for forces, ∂m/∂θ_O for moments
    const EndForces ends = solve_driven_ends(joint.element->transfer(step, Vector6::Zero()), joint.element->carried());
    for (int i = 0; i < 3; ++i) {
        joint.halves[kTranslation].law(i) = -ends.S(i, 6 + i);
        joint.halves[kRotation].law(i) = ends.S(3 + i, 9 + i);
    }
}

/// What of the force over the coming step is known before its end is: for an explicit scheme all of it.
inline void Network::recall(const Half& half, HalfState& state) const {
    if (is_implicit()) {
        state.known = half.stiffness.cwiseProduct(state.d + weights_.elastic[1] * state.delta[0]) +
                      half.damping.cwiseProduct(weights_.rate[1] * state.delta[0]);
    } else {
        // k d + c Σ rate δ = k̂ δ + k (d − δ) + c (…),   k̂ = k + c rate[1]
        state.known = half.law.cwiseProduct(state.delta[0]) + half.stiffness.cwiseProduct(state.d - state.delta[0]) +
                      half.damping.cwiseProduct(weights_.rate[2] * state.delta[1] + weights_.rate[3] * state.delta[2]);
    }
}

/// What a finite rotation adds to the linear law: k ∘ θ becomes J⁻ᵀ (k ∘ θ).
void Network::settle_turn(const Joint& joint, TurnState& state) const {
    const Half& half = joint.halves[kRotation];
    state.conjugate = rotation_vector_rate(state.rotation.d).transpose();
    const Vector3 elastic = half.stiffness.cwiseProduct(state.rotation.d + weights_.elastic[1] * state.rotation.delta[0]);
    state.rotation.known += state.conjugate * elastic - elastic;
}

/// ∂m/∂δ₊ of the open step, the same addition in it.
Matrix3 Network::turn_gain(const Half& half, const TurnState& state) const {
    Matrix3 gain = half.law.asDiagonal();
    const Vector3 elastic = weights_.elastic[0] * half.stiffness;
    gain += (state.conjugate - Matrix3::Identity()) * elastic.asDiagonal();
    return gain;
}

// ---- Time steps ---------------------------------------------------------------------------------------------------------

void Network::start(const dttmm_step& step, const dttmm_motion* ports, const double* accelerations, const double*) {
    if (open_) throw Error(DTTMM_ERROR_PHASE, "start: a step is open");
    if (!(step.size > 0) || !std::isfinite(step.size))
        throw Error(DTTMM_ERROR_ARGUMENT, "start: the step size must be positive");
    refuse_large_rotation(ports);
    set_step_size(step.size);
    for (size_t j = 0; j < joints_.size(); ++j) start_joint(j, ports, accelerations);
    for (int p = 0; p < port_count_; ++p) {
        std::copy_n(ports[p].position, 3, ports_[static_cast<size_t>(p)].position);
        std::copy_n(ports[p].rotation, 9, ports_[static_cast<size_t>(p)].rotation);
    }
    started_ = true;
}

void Network::start_joint(size_t index, const dttmm_motion* ports, const double* accelerations) {
    const Joint& joint = joints_[index];
    const FrameView from = trial(joint.from, ports), to = trial(joint.to, ports);
    const Vector6 rate = deformation_rate(joint, ports);
    const Vector6 acceleration = deformation_acceleration(joint, ports, accelerations);
    JointState& state = joint_states_[index];
    state.dissipated = 0;
    state.power = 0;
    start_half(joint.halves[kTranslation], translation(joint, from, arm(from, to)), rate.head<3>(), acceleration.head<3>(),
               state.translation);
    if (joint.turn < 0) return;
    TurnState& turn = turn_states_[static_cast<size_t>(joint.turn)];
    turn.attitude = attitude(joint, from, to);
    start_half(joint.halves[kRotation], rotation_vector(turn.attitude), rate.tail<3>(), acceleration.tail<3>(),
               turn.rotation);
    settle_turn(joint, turn);
}

/// The past before the start is the parabola through it, which suits every explicit scheme. The first step of the centred
/// scheme is Newmark's from d, d', d'': the elastic force before the start counts as that at the start, and the rate is
/// γ δ₊/h + (1 − γ) d' + (β − γ/2) h d''.
void Network::start_half(const Half& half, const Vector3& d, const Vector3& rate, const Vector3& acceleration,
                         HalfState& state) const {
    const double h = clock_.step_size, beta = centred_.beta, gamma = centred_.gamma;
    state.d = d;
    state.rate = rate;
    for (int back = 0; back < 3; ++back) state.delta[back] = h * rate - (back + 0.5) * h * h * acceleration;
    state.d_before = d - state.delta[0];
    if (is_implicit())
        state.known = half.stiffness.cwiseProduct(d) +
                      half.damping.cwiseProduct((1 - gamma) * rate + (beta - 0.5 * gamma) * h * acceleration);
    else
        recall(half, state);
}

void Network::begin_step(const dttmm_step& step, const double*) {
    if (!started_) throw Error(DTTMM_ERROR_PHASE, "begin_step: start has not been called");
    if (open_) throw Error(DTTMM_ERROR_PHASE, "begin_step: the step before is still open");
    if (step.size != clock_.step_size) throw Error(DTTMM_ERROR_ARGUMENT, "begin_step: a new step size wants a new start");
    open_ = true;
}

void Network::evaluate(const dttmm_motion* motion, double* wrench, double* stiffness) const {
    if (!open_) throw Error(DTTMM_ERROR_PHASE, "evaluate: no step is open");
    const size_t n = 6 * static_cast<size_t>(port_count_);
    std::fill_n(wrench, n, 0.0);
    if (stiffness) std::fill_n(stiffness, n * n, 0.0);
    for (size_t j = 0; j < joints_.size(); ++j) {
        const Joint& joint = joints_[j];
        const HalfState& slide = joint_states_[j].translation;
        const TurnState* turn = joint.turn >= 0 ? &turn_states_[static_cast<size_t>(joint.turn)] : nullptr;
        const FrameView from_now = committed(joint.from), from = trial(joint.from, motion), to = trial(joint.to, motion);
        const Vector3 arm_now = arm(from_now, committed(joint.to));
        const auto R_now = matrix(from_now.rotation);

        Vector3 f = slide.known, M = Vector3::Zero();
        if (is_implicit())
            f += joint.halves[kTranslation].law.cwiseProduct(translation(joint, from, arm(from, to)) - slide.d);
        Vector3 delta = Vector3::Zero();  // of the rotation over the open step
        if (turn) {
            Vector3 m = turn->rotation.known;
            if (is_implicit()) {
                delta = rotation_vector(attitude(joint, from, to) * turn->attitude.transpose());
                m += turn_gain(joint.halves[kRotation], *turn) * delta;
            }
            M = R_now * m;
        }
        add_wrench(joint, arm_now, R_now * f, M, wrench);
        if (stiffness && is_implicit()) {
            const Matrix3 turn_answer =
                turn ? Matrix3(turn_gain(joint.halves[kRotation], *turn) * rotation_vector_rate(delta))
                     : Matrix3(Matrix3::Zero());
            add_stiffness(joint, {joint.halves[kTranslation].law, turn_answer, R_now, arm_now}, from, to, stiffness);
        }
    }
}

/// Moves one half of a joint on by the increment `delta` to `d`; returns the power of its damper at the start of the step.
inline double Network::advance_half(const Half& half, const Vector3& d, const Vector3& delta, HalfState& state) const {
    state.delta[2] = state.delta[1];
    state.delta[1] = state.delta[0];
    state.delta[0] = delta;
    state.d_before = state.d;
    state.d = d;
    recall(half, state);
    if (clock_.steps > 0) state.rate = 0.5 / clock_.step_size * (state.delta[0] + state.delta[1]);
    return state.rate.dot(half.damping.cwiseProduct(state.rate));
}

void Network::refuse_large_rotation(const dttmm_motion* ports) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const Joint& joint = joints_[j];
        if (joint.turn < 0 || joint.halves[kRotation].stiffness.isZero(0)) continue;
        const double angle = rotation_vector(attitude(joint, trial(joint.from, ports), trial(joint.to, ports))).norm();
        if (!(angle <= kLargestRotation))
            throw Error(
                DTTMM_ERROR_NUMERIC,
                fmt::format(
                    "its ends have turned {:.3g} rad against each other; a rotational stiffness holds up to {:g} rad", angle,
                    kLargestRotation),
                static_cast<int>(j));
    }
}

void Network::commit_step(const dttmm_motion* accepted) {
    if (!open_) throw Error(DTTMM_ERROR_PHASE, "commit_step: no step is open");
    if (!turn_states_.empty()) refuse_large_rotation(accepted);
    const double h = clock_.step_size;
    for (size_t j = 0; j < joints_.size(); ++j) {
        const Joint& joint = joints_[j];
        const FrameView from = trial(joint.from, accepted), to = trial(joint.to, accepted);
        JointState& state = joint_states_[j];
        const Vector3 d = translation(joint, from, arm(from, to));
        double power = advance_half(joint.halves[kTranslation], d, d - state.translation.d, state.translation);
        if (joint.turn >= 0) {
            TurnState& turn = turn_states_[static_cast<size_t>(joint.turn)];
            const Matrix3 next = attitude(joint, from, to);
            power += advance_half(joint.halves[kRotation], rotation_vector(next),
                                  rotation_vector(next * turn.attitude.transpose()), turn.rotation);
            turn.attitude = next;
            settle_turn(joint, turn);
        }
        if (clock_.steps > 0) state.dissipated += 0.5 * h * (state.power + power);
        state.power = power;
    }
    for (int p = 0; p < port_count_; ++p) {
        std::copy_n(accepted[p].position, 3, ports_[static_cast<size_t>(p)].position);
        std::copy_n(accepted[p].rotation, 9, ports_[static_cast<size_t>(p)].rotation);
    }
    ++clock_.steps;
    open_ = false;
}

void Network::discard_step() {
    if (!open_) throw Error(DTTMM_ERROR_PHASE, "discard_step: no step is open");
    open_ = false;
}

// ---- State and results --------------------------------------------------------------------------------------------------

/// Everything that changes from step to step, as pieces of memory.
std::vector<std::pair<void*, size_t>> Network::state_parts() {
    return {{&clock_, sizeof clock_},
            {joint_states_.data(), joint_states_.size() * sizeof(JointState)},
            {turn_states_.data(), turn_states_.size() * sizeof(TurnState)},
            {ports_.data(), ports_.size() * sizeof(Frame)}};
}

size_t Network::state_size() const {
    size_t size = 0;
    for (const auto& [data, bytes] : const_cast<Network*>(this)->state_parts()) size += bytes;
    return size;
}

void Network::save_state(void* buffer, size_t size) const {
    if (!started_ || open_) throw Error(DTTMM_ERROR_PHASE, "save_state: only between steps, after start");
    if (size != state_size())
        throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("save_state: the state has {} bytes, not {}", state_size(), size));
    char* out = static_cast<char*>(buffer);
    for (const auto& [data, bytes] : const_cast<Network*>(this)->state_parts()) {
        if (bytes > 0) std::memcpy(out, data, bytes);
        out += bytes;
    }
}

void Network::restore_state(const void* buffer, size_t size) {
    if (!started_ || open_) throw Error(DTTMM_ERROR_PHASE, "restore_state: only between steps, after start");
    if (size != state_size())
        throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("restore_state: the state has {} bytes, not {}", state_size(), size));
    const char* in = static_cast<const char*>(buffer);
    Clock saved;
    std::memcpy(&saved, in, sizeof saved);
    if (saved.step_size != clock_.step_size)
        throw Error(DTTMM_ERROR_ARGUMENT, "restore_state: saved at another step size, or by another network");
    for (const auto& [data, bytes] : state_parts()) {
        if (bytes > 0) std::memcpy(data, in, bytes);
        in += bytes;
    }
}

void Network::outputs(double* values) const {
    if (clock_.steps == 0) throw Error(DTTMM_ERROR_PHASE, "outputs: no step has been committed");
    for (size_t j = 0; j < joints_.size(); ++j) {
        const Joint& joint = joints_[j];
        double* out = values + kChannelsPerJoint * j;
        const Half& slide = joint.halves[kTranslation];
        const HalfState& state = joint_states_[j].translation;  // d_before is that at t_n, the start of the last step
        const Vector3 elastic = slide.stiffness.cwiseProduct(state.d_before);
        vector(out) = elastic + slide.damping.cwiseProduct(state.rate);
        vector(out + 3).setZero();
        vector(out + 6) = state.d_before;
        vector(out + 9).setZero();
        out[12] = 0.5 * elastic.dot(state.d_before);
        out[13] = joint_states_[j].dissipated;
        if (joint.turn < 0) continue;
        const Half& turn = joint.halves[kRotation];
        const HalfState& rotation = turn_states_[static_cast<size_t>(joint.turn)].rotation;
        const Vector3 elastic_turn = turn.stiffness.cwiseProduct(rotation.d_before);
        vector(out + 3) =
            rotation_vector_rate(rotation.d_before).transpose() * elastic_turn + turn.damping.cwiseProduct(rotation.rate);
        vector(out + 9) = rotation.d_before;
        out[12] += 0.5 * elastic_turn.dot(rotation.d_before);
    }
}

}  // namespace dttmm
