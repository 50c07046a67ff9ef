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
Eigen::Map<Vector6> vector6(double* v) { return Eigen::Map<Vector6>(v); }

/// The output channels of every joint, in the order outputs() writes them.
constexpr std::pair<const char*, const char*> kChannels[] = {
    {"force.x", "N"},        {"force.y", "N"},       {"force.z", "N"},
    {"moment.x", "N*m"},     {"moment.y", "N*m"},    {"moment.z", "N*m"},
    {"deflection.x", "m"},   {"deflection.y", "m"},  {"deflection.z", "m"},
    {"rotation.x", "rad"},   {"rotation.y", "rad"},  {"rotation.z", "rad"},
    {"strain_energy", "J"},  {"dissipated_energy", "J"},
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
            throw Error(DTTMM_ERROR_MODEL, fmt::format("node \"{}\": there is no node kind {}", node.name, node.kind));
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
    if (data.from >= ends.size() || data.to >= ends.size())
        throw Error(DTTMM_ERROR_MODEL, "an end is no node of the network", element);
    if (data.from == data.to) throw Error(DTTMM_ERROR_MODEL, "both ends are the same node", element);
    Joint joint{ends[data.from], ends[data.to], {}, 1, {}, {}, nullptr};
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
    joint.half_count = (joint.element->carried() >> 3).any() ? 2 : 1;
    const RowMajor3 R_from = matrix(joint.from.start.rotation);
    joint.rest_position = R_from.transpose() * (vector(joint.to.start.position) - vector(joint.from.start.position));
    joint.rest_rotation = R_from.transpose() * matrix(joint.to.start.rotation);
    joints_.push_back(std::move(joint));
    for (const auto& [name, unit] : kChannels) channels_.push_back({name, unit, index});
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

Vector3 Network::rotation(const Joint& joint, FrameView from, FrameView to) {
    return rotation_vector(matrix(from.rotation).transpose() * matrix(to.rotation) * joint.rest_rotation.transpose());
}

Vector6 Network::deformation(const Joint& joint, FrameView from, FrameView to) {
    Vector6 d = Vector6::Zero();
    d.head<3>() = translation(joint, from, arm(from, to));
    if (joint.half_count > 1) d.tail<3>() = rotation(joint, from, to);
    return d;
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

inline void Network::add_wrench(const Joint& joint, FrameView from, const Vector3& arm, const Vector3* force, double* wrench) {
    // to: (−F, −M); from: (F, M + arm × F): forces and moments of the two ends balance about any point
    const Vector3 F = matrix(from.rotation) * force[kTranslation];
    const Vector3 M = joint.half_count > 1 ? Vector3(matrix(from.rotation) * force[kRotation]) : Vector3(Vector3::Zero());
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

void Network::add_stiffness(const Joint& joint, const Vector6& gain, FrameView from, FrameView to, FrameView from_now,
                            const Vector3& arm_now, double* stiffness) const {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> S(stiffness, 6 * port_count_, 6 * port_count_);

    // δd = G_to δ(pose_to) + G_from δ(pose_from)
    const Matrix3 to_local = matrix(from.rotation).transpose();
    Matrix6 G_to = Matrix6::Zero(), G_from = Matrix6::Zero();
    G_to.topLeftCorner<3, 3>() = to_local;
    G_from.topLeftCorner<3, 3>() = -to_local;
    G_from.topRightCorner<3, 3>() = to_local * skew(arm(from, to));
    if (joint.half_count > 1) {
        G_to.bottomRightCorner<3, 3>() = rotation_vector_rate(rotation(joint, from, to)) * to_local;
        G_from.bottomRightCorner<3, 3>() = -G_to.bottomRightCorner<3, 3>();
    }

    // δ(wrench_to) = −H δf,  δ(wrench_from) = +H δf with the moment of the force over the lever arm
    const Matrix3 R_now = matrix(from_now.rotation);
    Matrix6 H = Matrix6::Zero();
    H.topLeftCorner<3, 3>() = R_now;
    H.bottomRightCorner<3, 3>() = R_now;
    Matrix6 H_from = H;
    H_from.bottomLeftCorner<3, 3>() = skew(arm_now) * R_now;

    const auto add = [&](int row_port, const Matrix6& rows, int column_port, const Matrix6& columns, double sign) {
        if (row_port < 0 || column_port < 0) return;
        S.block<6, 6>(6 * row_port, 6 * column_port) += sign * (rows * gain.asDiagonal() * columns);
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
        const Vector6 &k = joint.element->stiffness(), &c = joint.element->damping();
        const Vector6 f = k.cwiseProduct(deformation(joint, from, to)) + c.cwiseProduct(deformation_rate(joint, ports));
        const Vector3 force[2] = {f.head<3>(), f.tail<3>()};
        add_wrench(joint, from, arm(from, to), force, wrench);
        if (stiffness) add_stiffness(joint, k, from, to, from, arm(from, to), stiffness);
        if (damping) add_stiffness(joint, c, from, to, from, arm(from, to), damping);
    }
}

// ---- Time steps ---------------------------------------------------------------------------------------------------------

void Network::start(const dttmm_step& step, const dttmm_motion* ports, const double* accelerations) {
    if (open_) throw Error(DTTMM_ERROR_PHASE, "start: a step is open");
    if (!(step.size > 0) || !std::isfinite(step.size)) throw Error(DTTMM_ERROR_ARGUMENT, "start: the step size must be positive");
    set_step_size(step.size);
    for (size_t j = 0; j < joints_.size(); ++j) {
        const Joint& joint = joints_[j];
        const Vector6 d = deformation(joint, trial(joint.from, ports), trial(joint.to, ports));
        const Vector6 rate = deformation_rate(joint, ports);
        const Vector6 acceleration = deformation_acceleration(joint, ports, accelerations);
        JointState& state = joint_states_[j];
        state.dissipated = 0;
        state.power = 0;
        for (int half = 0; half < joint.half_count; ++half)
            start_half(joint.halves[half], d.segment<3>(3 * half), rate.segment<3>(3 * half), acceleration.segment<3>(3 * half),
                       state.halves[half]);
    }
    for (int p = 0; p < port_count_; ++p) {
        std::copy_n(ports[p].position, 3, ports_[static_cast<size_t>(p)].position);
        std::copy_n(ports[p].rotation, 9, ports_[static_cast<size_t>(p)].rotation);
    }
    started_ = true;
}

namespace {

/// Velocity formula of an explicit scheme at t_n as weights of x at t_n, t_{n−1}, t_{n−2}, t_{n−3}: one unit history for each
/// of the three old positions. The previous velocity that Fox-Euler wants is the host's, the mean of those over the two steps
/// around t_{n−1}: (x_n − x_{n−2})/2h. Its own recursion would be driven unstable by a leap-frog host.
std::array<double, 4> velocity_weights(uint32_t scheme, double h) {
    const auto rule = [&](const History& past) {
        switch (scheme) {
            case DTTMM_SCHEME_BDF1: return bdf1(past, h);
            case DTTMM_SCHEME_BDF2: return bdf2(past, h);
            case DTTMM_SCHEME_HOUBOLT: return houbolt(past, h);
            case DTTMM_SCHEME_PARK: return park(past, h);
            default: return fox_euler(past, h);
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

/// The past before the start is the parabola through it, which suits every explicit scheme. The first force of the centred
/// scheme is chosen so that its first step is Newmark's from x₀, v₀, a₀: over that step the elastic force before the start
/// counts as that at the start, and the rate is taken from  x₋ = x₀ − h v₀ − h² (β − γ/2)/(1 − γ) a₀.
void Network::start_half(const Half& half, const Vector3& d, const Vector3& rate, const Vector3& acceleration, HalfState& state) const {
    const double h = clock_.step_size;
    for (int back = 0; back < 4; ++back) state.d[back] = d - back * h * rate + 0.5 * back * back * h * h * acceleration;
    recall(half, state);
    if (!is_implicit()) return;
    const double beta = centred_.beta, gamma = centred_.gamma;
    const Vector3 mean_rate = (1 - gamma) * rate + (beta - 0.5 * gamma) * h * acceleration - gamma / h * d;
    state.known = half.stiffness.cwiseProduct((1 - beta) * d) + half.damping.cwiseProduct(mean_rate);
}

Network::PastWeights Network::past_weights(double h) const {
    if (!is_implicit()) return {{1, 0, 0, 0}, velocity_weights(scheme_, h)};
    return {{centred_.weight_now(), centred_.weight_before(), 0, 0}, {(1 - 2 * centred_.gamma) / h, (centred_.gamma - 1) / h, 0, 0}};
}

void Network::set_step_size(double h) {
    clock_ = {h, 0};
    // implicit: f = k (w₊ d₊ + w₀ d + w₋ d₋) + c (C d₊ + D) = k̂ d₊ + known
    // explicit: f = k d + c (C d + D), all of it known: k̂ serves the transfer equations only
    const PastWeights past = past_weights(h);
    const StepCoefficients step = is_implicit() ? StepCoefficients{centred_.weight_after(), centred_.gamma / h}
                                                : StepCoefficients{1, past.rate[0]};
    recalled_ = 4;
    while (recalled_ > 1 && past.elastic[static_cast<size_t>(recalled_ - 1)] == 0 && past.rate[static_cast<size_t>(recalled_ - 1)] == 0) --recalled_;
    for (size_t j = 0; j < joints_.size(); ++j) {
        try {
            solve_law(joints_[j], step);
        } catch (const Error& error) {
            throw Error(error.status(), error.what(), static_cast<int>(j));
        }
        for (Half& half : joints_[j].halves)
            for (size_t i = 0; i < 4; ++i) half.recall[i] = past.elastic[i] * half.stiffness + past.rate[i] * half.damping;
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

/// What of the force over the coming step is known before its end is: everything for an explicit scheme.
inline void Network::recall(const Half& half, HalfState& state) const {
    state.known = half.recall[0].cwiseProduct(state.d[0]);
    for (int i = 1; i < recalled_; ++i) state.known += half.recall[i].cwiseProduct(state.d[i]);
}

void Network::begin_step(const dttmm_step& step) {
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
        const JointState& state = joint_states_[j];
        const FrameView from_now = committed(joint.from);
        const Vector3 arm_now = arm(from_now, committed(joint.to));
        Vector3 force[2] = {state.halves[kTranslation].known, state.halves[kRotation].known};
        if (is_implicit()) {
            const FrameView from = trial(joint.from, motion), to = trial(joint.to, motion);
            force[kTranslation] += joint.halves[kTranslation].law.cwiseProduct(translation(joint, from, arm(from, to)));
            if (joint.half_count > 1) force[kRotation] += joint.halves[kRotation].law.cwiseProduct(rotation(joint, from, to));
            if (stiffness) {
                Vector6 law;
                law << joint.halves[kTranslation].law, joint.halves[kRotation].law;
                add_stiffness(joint, law, from, to, from_now, arm_now, stiffness);
            }
        }
        add_wrench(joint, from_now, arm_now, force, wrench);
    }
}

void Network::commit_step(const dttmm_motion* accepted) {
    if (!open_) throw Error(DTTMM_ERROR_PHASE, "commit_step: no step is open");
    const double h = clock_.step_size, per_two_steps = 1 / (2 * h);
    for (size_t j = 0; j < joints_.size(); ++j) {
        const Joint& joint = joints_[j];
        const FrameView from = trial(joint.from, accepted), to = trial(joint.to, accepted);
        JointState& state = joint_states_[j];
        double power = 0;
        for (int half = 0; half < joint.half_count; ++half) {
            HalfState& memory = state.halves[half];
            memory.d[3] = memory.d[2];
            memory.d[2] = memory.d[1];
            memory.d[1] = memory.d[0];
            memory.d[0] = half == kTranslation ? translation(joint, from, arm(from, to)) : rotation(joint, from, to);
            const Vector3 rate = per_two_steps * (memory.d[0] - memory.d[2]);
            power += rate.dot(joint.halves[half].damping.cwiseProduct(rate));
            recall(joint.halves[half], memory);
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

size_t Network::state_size() const {
    return sizeof(Clock) + joint_states_.size() * sizeof(JointState) + ports_.size() * sizeof(Frame);
}

void Network::save_state(void* buffer, size_t size) const {
    if (!started_ || open_) throw Error(DTTMM_ERROR_PHASE, "save_state: only between steps, after start");
    if (size != state_size())
        throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("save_state: the state has {} bytes, not {}", state_size(), size));
    char* out = static_cast<char*>(buffer);
    const size_t joints = joint_states_.size() * sizeof(JointState);
    std::memcpy(out, &clock_, sizeof clock_);
    std::memcpy(out + sizeof clock_, joint_states_.data(), joints);
    std::memcpy(out + sizeof clock_ + joints, ports_.data(), ports_.size() * sizeof(Frame));
}

void Network::restore_state(const void* buffer, size_t size) {
    if (!started_ || open_) throw Error(DTTMM_ERROR_PHASE, "restore_state: only between steps, after start");
    if (size != state_size())
        throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("restore_state: the state has {} bytes, not {}", state_size(), size));
    const char* in = static_cast<const char*>(buffer);
    const size_t joints = joint_states_.size() * sizeof(JointState);
    Clock saved;
    std::memcpy(&saved, in, sizeof saved);
    if (saved.step_size != clock_.step_size)
        throw Error(DTTMM_ERROR_ARGUMENT, "restore_state: saved at another step size, or by another network");
    clock_ = saved;
    std::memcpy(static_cast<void*>(joint_states_.data()), in + sizeof saved, joints);
    std::memcpy(static_cast<void*>(ports_.data()), in + sizeof saved + joints, ports_.size() * sizeof(Frame));
}

void Network::outputs(double* values) const {
    if (clock_.steps == 0) throw Error(DTTMM_ERROR_PHASE, "outputs: no step has been committed");
    for (size_t j = 0; j < joints_.size(); ++j) {
        const Joint& joint = joints_[j];
        double* out = values + kChannelsPerJoint * j;
        vector6(out).setZero();
        vector6(out + 6).setZero();
        out[12] = 0;
        for (int half = 0; half < joint.half_count; ++half) {
            const Vector3* d = joint_states_[j].halves[half].d;  // d[1] is that at t_n, the start of the last step
            const Vector3 rate = (d[0] - d[2]) / (2 * clock_.step_size);
            const Vector3 elastic = joint.halves[half].stiffness.cwiseProduct(d[1]);
            vector(out + 3 * half) = elastic + joint.halves[half].damping.cwiseProduct(rate);
            vector(out + 6 + 3 * half) = d[1];
            out[12] += 0.5 * elastic.dot(d[1]);
        }
        out[13] = joint_states_[j].dissipated;
    }
}

}  // namespace dttmm
