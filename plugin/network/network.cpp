// SPDX-License-Identifier: BSD-3-Clause
#include "network/network.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

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
    port_states_.resize(static_cast<size_t>(port_count_));
}

std::vector<Network::End> Network::place_ends(const dttmm_network& description) {
    std::vector<End> ends;
    for (uint32_t i = 0; i < description.node_count; ++i) {
        const dttmm_node& node = description.nodes[i];
        if (node.kind > DTTMM_NODE_PORT)
            throw Error(DTTMM_ERROR_MODEL, fmt::format("node \"{}\": there is no node kind {}", node.name, node.kind));
        if (!vector(node.position).allFinite() || !is_rotation(matrix(node.rotation)))
            throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("node \"{}\": its position must be finite and its axes orthonormal", node.name));
        const int port = node.kind == DTTMM_NODE_PORT ? port_count_++ : -1;
        ends.push_back({port, vector(node.position), matrix(node.rotation)});
    }
    return ends;
}

void Network::build_joint(const dttmm_network& description, const std::vector<End>& ends, uint32_t index) {
    const dttmm_element& data = description.elements[index];
    const int element = static_cast<int>(index);
    if (data.from >= ends.size() || data.to >= ends.size())
        throw Error(DTTMM_ERROR_MODEL, "an end is no node of the network", element);
    const End& from = ends[data.from];
    const End& to = ends[data.to];
    if (from.port < 0 && to.port < 0) throw Error(DTTMM_ERROR_MODEL, "both ends are on the ground", element);
    if (data.from == data.to) throw Error(DTTMM_ERROR_MODEL, "both ends are the same node", element);

    Joint joint;
    joint.from = from;
    joint.to = to;
    try {
        joint.element = make_element(data.type, data.values);
    } catch (const Error& error) {
        throw Error(error.status(), error.what(), element);
    }
    joint.stiffness = joint.element->stiffness();
    joint.damping = joint.element->damping();
    joint.turns = (joint.element->carried() >> 3).any();
    joint.reference_position = from.ground_rotation.transpose() * (to.ground_position - from.ground_position);
    joint.reference_rotation = from.ground_rotation.transpose() * to.ground_rotation;
    joint.law.setZero();
    joints_.push_back(std::move(joint));
    for (const auto& [name, unit] : kChannels) channels_.push_back({name, unit, index});
}

void Network::load_weights(double weights[3]) const {
    weights[0] = is_implicit() ? centred_.weight_after() : 0;
    weights[1] = is_implicit() ? centred_.weight_now() : 1;
    weights[2] = is_implicit() ? centred_.weight_before() : 0;
}

// ---- Kinematics of a joint ----------------------------------------------------------------------------------------------

Network::EndPose Network::pose_of(const End& end, const dttmm_motion* ports) {
    if (end.port < 0) return {end.ground_position, end.ground_rotation};
    return {vector(ports[end.port].position), matrix(ports[end.port].rotation)};
}

Network::EndPose Network::committed_pose(const End& end) const {
    if (end.port < 0) return {end.ground_position, end.ground_rotation};
    const PortState& port = port_states_[static_cast<size_t>(end.port)];
    return {port.position, port.rotation};
}

Vector6 Network::deformation(const Joint& joint, const EndPose& from, const EndPose& to) {
    Vector6 d;
    d.head<3>() = from.rotation.transpose() * (to.position - from.position) - joint.reference_position;
    if (joint.turns)
        d.tail<3>() = rotation_vector(from.rotation.transpose() * to.rotation * joint.reference_rotation.transpose());
    else
        d.tail<3>().setZero();
    return d;
}

Vector6 Network::deformation_rate(const Joint& joint, const dttmm_motion* ports) {
    // r = R_fromᵀ (p_to − p_from)  =>  r' = R_fromᵀ (v_to − v_from − ω_from × (p_to − p_from))
    const EndPose from = pose_of(joint.from, ports), to = pose_of(joint.to, ports);
    Vector3 v = Vector3::Zero(), w = Vector3::Zero();
    if (joint.to.port >= 0) {
        v += vector(ports[joint.to.port].velocity);
        w += vector(ports[joint.to.port].angular_velocity);
    }
    if (joint.from.port >= 0) {
        const Vector3 w_from = vector(ports[joint.from.port].angular_velocity);
        v -= vector(ports[joint.from.port].velocity) + w_from.cross(to.position - from.position);
        w -= w_from;
    }
    Vector6 rate;
    rate.head<3>() = from.rotation.transpose() * v;
    rate.tail<3>() = joint.turns ? Vector3(from.rotation.transpose() * w) : Vector3::Zero();
    return rate;
}

Vector6 Network::deformation_acceleration(const Joint& joint, const dttmm_motion* ports, const double* accelerations) {
    // r'' = R_fromᵀ (a_to − a_from − α × p − ω × (ω × p) − 2 ω × (p' − ω × p)),  p = p_to − p_from, ω and α of the from end
    const EndPose from = pose_of(joint.from, ports), to = pose_of(joint.to, ports);
    Vector3 a = Vector3::Zero(), angular = Vector3::Zero(), p_rate = Vector3::Zero();
    if (joint.to.port >= 0) {
        a += vector(accelerations + 6 * joint.to.port);
        angular += vector(accelerations + 6 * joint.to.port + 3);
        p_rate += vector(ports[joint.to.port].velocity);
    }
    if (joint.from.port >= 0) {
        const Vector3 p = to.position - from.position;
        const Vector3 w = vector(ports[joint.from.port].angular_velocity);
        const Vector3 alpha = vector(accelerations + 6 * joint.from.port + 3);
        p_rate -= vector(ports[joint.from.port].velocity);
        a -= vector(accelerations + 6 * joint.from.port) + alpha.cross(p) + w.cross(w.cross(p)) + 2 * w.cross(p_rate - w.cross(p));
        angular -= alpha;
        if (joint.to.port >= 0) angular -= w.cross(vector(ports[joint.to.port].angular_velocity));
    }
    Vector6 acceleration;
    acceleration.head<3>() = from.rotation.transpose() * a;
    acceleration.tail<3>() = joint.turns ? Vector3(from.rotation.transpose() * angular) : Vector3::Zero();
    return acceleration;
}

// ---- Wrenches on the ports ----------------------------------------------------------------------------------------------

void Network::add_wrench(const Joint& joint, const Matrix3& R_from, const Vector3& arm, const Vector6& f, double* wrench) {
    // to: (−F, −M); from: (F, M + arm × F): forces and moments of the two ends balance about any point
    const Vector3 force = R_from * f.head<3>();
    const Vector3 moment = R_from * f.tail<3>();
    if (joint.to.port >= 0) {
        auto on_to = vector6(wrench + 6 * joint.to.port);
        on_to.head<3>() -= force;
        on_to.tail<3>() -= moment;
    }
    if (joint.from.port >= 0) {
        auto on_from = vector6(wrench + 6 * joint.from.port);
        on_from.head<3>() += force;
        on_from.tail<3>() += moment + arm.cross(force);
    }
}

void Network::add_stiffness(const Joint& joint, const Vector6& gain, const EndPose& from, const EndPose& to,
                            const Matrix3& R_from, const Vector3& arm, double* stiffness) const {
    using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    Eigen::Map<RowMajor> S(stiffness, 6 * port_count_, 6 * port_count_);

    // δd = G_to δ(pose_to) + G_from δ(pose_from)
    const Matrix3 to_local = from.rotation.transpose();
    Matrix6 G_to = Matrix6::Zero(), G_from = Matrix6::Zero();
    G_to.topLeftCorner<3, 3>() = to_local;
    G_from.topLeftCorner<3, 3>() = -to_local;
    G_from.topRightCorner<3, 3>() = to_local * skew(to.position - from.position);
    if (joint.turns) {
        const Vector3 theta = rotation_vector(to_local * to.rotation * joint.reference_rotation.transpose());
        G_to.bottomRightCorner<3, 3>() = rotation_vector_rate(theta) * to_local;
        G_from.bottomRightCorner<3, 3>() = -G_to.bottomRightCorner<3, 3>();
    }

    // δ(wrench_to) = −H δf,  δ(wrench_from) = +H δf plus the lever arm
    Matrix6 H = Matrix6::Zero();
    H.topLeftCorner<3, 3>() = R_from;
    H.bottomRightCorner<3, 3>() = R_from;
    Matrix6 H_from = H;
    H_from.bottomLeftCorner<3, 3>() = skew(arm) * R_from;

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
        const EndPose from = pose_of(joint.from, ports), to = pose_of(joint.to, ports);
        const Vector3 arm = to.position - from.position;
        const Vector6 f = joint.stiffness.cwiseProduct(deformation(joint, from, to)) +
                          joint.damping.cwiseProduct(deformation_rate(joint, ports));
        add_wrench(joint, from.rotation, arm, f, wrench);
        if (stiffness) add_stiffness(joint, joint.stiffness, from, to, from.rotation, arm, stiffness);
        if (damping) add_stiffness(joint, joint.damping, from, to, from.rotation, arm, damping);
    }
}

// ---- Time steps ---------------------------------------------------------------------------------------------------------

void Network::start(const dttmm_step& step, const dttmm_motion* ports, const double* accelerations) {
    if (open_) throw Error(DTTMM_ERROR_PHASE, "start: a step is open");
    if (!(step.size > 0) || !std::isfinite(step.size)) throw Error(DTTMM_ERROR_ARGUMENT, "start: the step size must be positive");
    clock_ = {step.size, 0};
    solve_laws();
    for (int p = 0; p < port_count_; ++p)
        port_states_[static_cast<size_t>(p)] = {vector(ports[p].position), matrix(ports[p].rotation)};
    for (size_t j = 0; j < joints_.size(); ++j) {
        // The past before the start is the parabola through it: every scheme then starts without a rule of its own.
        const Joint& joint = joints_[j];
        const Vector6 d = deformation(joint, pose_of(joint.from, ports), pose_of(joint.to, ports));
        const Vector6 rate = deformation_rate(joint, ports);
        const Vector6 acceleration = deformation_acceleration(joint, ports, accelerations);
        JointState& state = joint_states_[j];
        for (int back = 0; back < 4; ++back) {
            const double t = -back * step.size;
            state.d[back] = d + t * rate + 0.5 * t * t * acceleration;
        }
        state.dissipated = 0;
        state.power = 0;
        recall(state, joint);
    }
    started_ = true;
}

void Network::solve_laws() {
    StepCoefficients step;
    if (is_implicit()) {
        step = {centred_.weight_after(), centred_.gamma / clock_.step_size};
    } else {
        step = {1, explicit_motion(JointState{}).C};
    }
    for (size_t j = 0; j < joints_.size(); ++j) {
        Joint& joint = joints_[j];
        try {
            const Directions carried = joint.element->carried();
            const EndForces ends = solve_driven_ends(joint.element->transfer(step, Vector6::Zero()), carried);
            // f = [−q; m] of the input end against d = x_O − x_I: −∂q/∂x_O for forces, ∂m/∂θ_O for moments
            for (int i = 0; i < 6; ++i) joint.law(i) = (i < 3 ? -1 : 1) * ends.S(i, 6 + i);
        } catch (const Error& error) {
            throw Error(error.status(), error.what(), static_cast<int>(j));
        }
    }
}

/// Velocity formula of the explicit schemes at t_n. The previous velocity that Fox-Euler wants is the host's: the mean of
/// those over the two steps around t_{n−1}. Its own recursion would be driven unstable by a leap-frog host.
AffineMotion Network::explicit_motion(const JointState& state) const {
    const double h = clock_.step_size;
    History past;
    past.x = {state.d[1], state.d[2], state.d[3]};
    past.v = {(state.d[0] - state.d[2]) / (2 * h), (state.d[1] - state.d[3]) / (2 * h), Vector6::Zero()};
    switch (scheme_) {
        case DTTMM_SCHEME_BDF1: return bdf1(past, h);
        case DTTMM_SCHEME_BDF2: return bdf2(past, h);
        case DTTMM_SCHEME_HOUBOLT: return houbolt(past, h);
        case DTTMM_SCHEME_PARK: return park(past, h);
        default: return fox_euler(past, h);
    }
}

/// Works out what of the force over the coming step is known before its end is: everything for an explicit scheme.
void Network::recall(JointState& state, const Joint& joint) const {
    if (is_implicit()) {
        // f = k (w₊ d₊ + w₀ d + w₋ d₋) + c (C d₊ + D) = k̂ d₊ + known
        const double h = clock_.step_size;
        const double C_now = (1 - 2 * centred_.gamma) / h, C_before = (centred_.gamma - 1) / h;
        state.known =
            joint.stiffness.cwiseProduct(centred_.weight_now() * state.d[0] + centred_.weight_before() * state.d[1]) +
            joint.damping.cwiseProduct(C_now * state.d[0] + C_before * state.d[1]);
    } else {
        // f = k d + c (C d + D) = k̂ d + c D
        state.known = joint.law.cwiseProduct(state.d[0]) + joint.damping.cwiseProduct(explicit_motion(state).D);
    }
}

void Network::begin_step(const dttmm_step& step) {
    if (!started_) throw Error(DTTMM_ERROR_PHASE, "begin_step: start has not been called");
    if (open_) throw Error(DTTMM_ERROR_PHASE, "begin_step: the step before is still open");
    if (step.size != clock_.step_size) throw Error(DTTMM_ERROR_ARGUMENT, "begin_step: a new step size wants a new start");
    open_ = true;
}

void Network::evaluate(const dttmm_motion* trial, double* wrench, double* stiffness) const {
    if (!open_) throw Error(DTTMM_ERROR_PHASE, "evaluate: no step is open");
    const size_t n = 6 * static_cast<size_t>(port_count_);
    std::fill_n(wrench, n, 0.0);
    if (stiffness) std::fill_n(stiffness, n * n, 0.0);
    for (size_t j = 0; j < joints_.size(); ++j) {
        const Joint& joint = joints_[j];
        const EndPose now_from = committed_pose(joint.from), now_to = committed_pose(joint.to);
        const Vector3 arm = now_to.position - now_from.position;
        Vector6 f = joint_states_[j].known;
        if (is_implicit()) {
            const EndPose from = pose_of(joint.from, trial), to = pose_of(joint.to, trial);
            f += joint.law.cwiseProduct(deformation(joint, from, to));
            if (stiffness) add_stiffness(joint, joint.law, from, to, now_from.rotation, arm, stiffness);
        }
        add_wrench(joint, now_from.rotation, arm, f, wrench);
    }
}

void Network::commit_step(const dttmm_motion* accepted) {
    if (!open_) throw Error(DTTMM_ERROR_PHASE, "commit_step: no step is open");
    const double h = clock_.step_size;
    for (size_t j = 0; j < joints_.size(); ++j) {
        const Joint& joint = joints_[j];
        JointState& state = joint_states_[j];
        state.d[3] = state.d[2];
        state.d[2] = state.d[1];
        state.d[1] = state.d[0];
        state.d[0] = deformation(joint, pose_of(joint.from, accepted), pose_of(joint.to, accepted));

        const Vector6 rate = (state.d[0] - state.d[2]) / (2 * h);
        const double power = rate.dot(joint.damping.cwiseProduct(rate));
        if (clock_.steps > 0) state.dissipated += 0.5 * h * (state.power + power);
        state.power = power;
        recall(state, joint);
    }
    for (int p = 0; p < port_count_; ++p)
        port_states_[static_cast<size_t>(p)] = {vector(accepted[p].position), matrix(accepted[p].rotation)};
    ++clock_.steps;
    open_ = false;
}

void Network::discard_step() {
    if (!open_) throw Error(DTTMM_ERROR_PHASE, "discard_step: no step is open");
    open_ = false;
}

// ---- State and results --------------------------------------------------------------------------------------------------

size_t Network::state_size() const {
    return sizeof(Clock) + joint_states_.size() * sizeof(JointState) + port_states_.size() * sizeof(PortState);
}

void Network::save_state(void* buffer, size_t size) const {
    if (!started_ || open_) throw Error(DTTMM_ERROR_PHASE, "save_state: only between steps, after start");
    if (size != state_size()) throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("save_state: the state has {} bytes, not {}", state_size(), size));
    char* out = static_cast<char*>(buffer);
    std::memcpy(out, &clock_, sizeof clock_);
    std::memcpy(out + sizeof clock_, joint_states_.data(), joint_states_.size() * sizeof(JointState));
    std::memcpy(out + sizeof clock_ + joint_states_.size() * sizeof(JointState), port_states_.data(),
                port_states_.size() * sizeof(PortState));
}

void Network::restore_state(const void* buffer, size_t size) {
    if (!started_ || open_) throw Error(DTTMM_ERROR_PHASE, "restore_state: only between steps, after start");
    if (size != state_size()) throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("restore_state: the state has {} bytes, not {}", state_size(), size));
    const char* in = static_cast<const char*>(buffer);
    Clock saved;
    std::memcpy(&saved, in, sizeof saved);
    if (saved.step_size != clock_.step_size)
        throw Error(DTTMM_ERROR_ARGUMENT, "restore_state: saved at another step size, or by another network");
    clock_ = saved;
    std::memcpy(static_cast<void*>(joint_states_.data()), in + sizeof saved, joint_states_.size() * sizeof(JointState));
    std::memcpy(static_cast<void*>(port_states_.data()), in + sizeof saved + joint_states_.size() * sizeof(JointState),
                port_states_.size() * sizeof(PortState));
}

void Network::outputs(double* values) const {
    if (clock_.steps == 0) throw Error(DTTMM_ERROR_PHASE, "outputs: no step has been committed");
    for (size_t j = 0; j < joints_.size(); ++j) {
        const Joint& joint = joints_[j];
        const JointState& state = joint_states_[j];
        const Vector6& d = state.d[1];
        const Vector6 rate = (state.d[0] - state.d[2]) / (2 * clock_.step_size);
        const Vector6 elastic = joint.stiffness.cwiseProduct(d);
        double* out = values + kChannelsPerJoint * j;
        vector6(out) = elastic + joint.damping.cwiseProduct(rate);
        vector6(out + 6) = d;
        out[12] = 0.5 * elastic.dot(d);
        out[13] = state.dissipated;
    }
}

}  // namespace dttmm
