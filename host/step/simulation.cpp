// SPDX-License-Identifier: BSD-3-Clause
#include "step/simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "coupling/rigid_loop.h"
#include "model/error.h"
#include "model/index.h"
#include "model/read_modes.h"
#include "world/rotation_step.h"

namespace dttmm::host {

namespace {

/// Beyond it, as beyond kFarthest, a machine has flown apart and ODE begins to lose digits.
constexpr double kFastest = 1e8;  // m/s and rad/s

std::vector<BodyState> read_states(const World& world, size_t count) {
    std::vector<BodyState> states(count);
    world.read_states(states);
    return states;
}

/// Moves two states to equal distances from a third.
void centre_body(BodyState& above, BodyState& below, const BodyState& middle) {
    for (Eigen::Vector3d BodyState::*vector : {&BodyState::position, &BodyState::velocity, &BodyState::angular_velocity}) {
        const Eigen::Vector3d half = 0.5 * (above.*vector - below.*vector);
        above.*vector = middle.*vector + half;
        below.*vector = middle.*vector - half;
    }
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(above.rotation * below.rotation.transpose()));
    const Eigen::Vector3d half = 0.5 * turn.angle() * turn.axis();
    above.rotation = RotationStep(half).apply(middle.rotation);
    below.rotation = RotationStep(-half).apply(middle.rotation);
}

}  // namespace

Simulation::Simulation(const Model& model, const Plugins& plugins, For what)
    : model_(model),
      step_size_(model.simulation.step),
      world_(model.bodies, model.joints),
      networks_(model, plugins),
      now_(read_states(world_, model.bodies.size())),
      fastest_(what == For::steps ? find_fastest_mode(model, networks_, now_) : FastestMode{}),
      loads_(model, networks_.load_weights()),
      drives_(model),
      end_of_step_(model, networks_, form_rigid_loop(model, plugins.catalogue())),
      instant_(model),
      after_(model.bodies.size()),
      observer_(model, networks_, end_of_step_.equations().joint_system()) {
    fastest_turning_.held.resize(model.bodies.size());
    for (const Element& element : model.elements)
        for (const Attachment& end : element.ends)
            if (end.body >= 0) fastest_turning_.held[as_size(end.body)] = true;
    if (!networks_.is_implicit()) limit_ = find_explicit_limit(model, networks_, now_, step_size_, model.simulation.scheme);
    const Instant& start = this->start();
    std::vector<BodyState> before = end_of_step_.start(step_size_, now_, start.accelerations);
    if (!networks_.stand()) first_after_ = now_;
    for (size_t b = 0; b < first_after_.size(); ++b) {
        first_after_[b].velocity += first_after_[b].velocity - before[b].velocity;
        first_after_[b].angular_velocity += first_after_[b].angular_velocity - before[b].angular_velocity;
    }
    now_ = std::move(before);
    world_.set_states(now_);
}

/// A support that is elsewhere at the start than the file places its node strains the machine at once.
void Simulation::refuse_jumps_of_supports() const {
    constexpr double kNone = 1e-12;  // m and rad: rounding of an expression
    for (const Node& node : model_.nodes)
        for (size_t d = 0; d < node.motion.size(); ++d)
            if (node.motion[d] && !(std::abs(node.motion[d]->value(0)) <= kNone))
                throw Error(
                    ExitCode::model_invalid,
                    fmt::format("{}: node \"{}\": motion.{} is {:.6g} {} at t = 0 s, but the run starts with the node "
                                "where the file places it: let it begin with 0, as a signal of type \"step\" does, or "
                                "write start = \"equilibrium\" in [simulation]",
                                node.motion_place, node.name, kDirections[d], node.motion[d]->value(0),
                                d < 3 ? "m" : "rad"));
}

/// A motor begins where the file places the bodies of its joint, or at rest with a machine in equilibrium.
void Simulation::refuse_jumps_of_motors() {
    constexpr double kNone = 1e-12;  // m and rad: rounding of an expression
    if (drives_.empty()) return;
    const std::vector<Drive>& drives = drives_.around({0, 0.0, step_size_});
    for (size_t j = 0; j < drives.size(); ++j) {
        const Joint& joint = model_.joints[j];
        if (!joint.drive) continue;
        const bool turns = joint.type == JointType::hinge;
        const double start = joint.drive->value(0);
        const auto refuse = [&](const std::string& fault) {
            throw Error(ExitCode::model_invalid, fmt::format("{}: joint \"{}\": its {} {}", joint.drive_place, joint.name,
                                                             turns ? "angle" : "travel", fault));
        };
        if (!model_.simulation.starts_at_rest && !(std::abs(start) <= kNone))
            refuse(
                fmt::format("is {:.6g} {} at t = 0 s, but the run starts with the joint where the file places its bodies: "
                            "let it begin with 0, or write start = \"equilibrium\" in [simulation]",
                            start, turns ? "rad" : "m"));
        if (model_.simulation.starts_at_rest && std::abs(drives[j].rate) > Drives::rate_error(drives[j], step_size_))
            refuse(
                fmt::format("moves at {:.6g} {} at t = 0 s, but start = \"equilibrium\" begins at rest: let it begin at "
                            "rest, as a signal of type \"step\" does",
                            drives[j].rate, turns ? "rad/s" : "m/s"));
    }
}

/// Initial conditions: now_ as the model has it, or at rest.
const Instant& Simulation::start() {
    const dttmm_step first{0, 0.0, step_size_};
    refuse_jumps_of_motors();
    if (!model_.simulation.starts_at_rest) {
        refuse_jumps_of_supports();
        return instant_.start(model_, first, now_, networks_, loads_);
    }
    equilibrium_ = std::make_unique<Equilibrium>(model_, networks_, loads_);
    rest_ = equilibrium_->find(first.time);
    now_ = rest_->at;
    return instant_.start_at_rest(first, now_, networks_, loads_);
}

uint64_t Simulation::step_count() const {
    return static_cast<uint64_t>(std::llround(model_.simulation.duration / step_size_)) + 1;
}

void Simulation::begin_step() {
    const dttmm_step step{index_, time(), step_size_};
    loads_.begin_step(step);
    if (!drives_.empty()) {
        end_of_step_.drive(drives_.around(step));
        world_.drive(drives_.around(step));
    }
    networks_.begin_step(step, loads_.on_networks().data());
    end_of_step_.begin_step(step, now_, loads_);
}

void Simulation::observe_rest() {
    begin_step();
    end_of_step_.solve(now_, networks_);
    after_ = end_of_step_.predicted();
    networks_.commit_step(after_);
    observe();
}

void Simulation::step() {
    equilibrium_.reset();
    begin_step();
    try {
        move_bodies();
    } catch (...) {
        if (sinks_.trace) sinks_.trace(end_of_step_.report());
        throw;
    }
    if (sinks_.trace) sinks_.trace(end_of_step_.report());
    refuse_divergence();
    follow_turning();
    networks_.commit_step(after_);
    if (sinks_.row) observe();
    now_.swap(after_);
    ++index_;
}

void Simulation::centre(Simulation& above, Simulation& below, const Simulation& middle) {
    middle.networks_.centre(above.networks_, below.networks_);
    for (size_t b = 0; b < middle.now_.size(); ++b) centre_body(above.now_[b], below.now_[b], middle.now_[b]);
    for (Simulation* one : {&above, &below})
        if (one->asks_ode_) one->world_.set_states(one->now_);
}

/// Finds the end of the step and has ODE move the bodies there.
void Simulation::move_bodies() {
    const BodyVectors& wrenches = end_of_step_.solve(now_, networks_);  // calls evaluate at will
    if (!asks_ode_) return end_of_step_.write_end(now_, after_);
    world_.apply(wrenches);
    world_.advance(step_size_, end_of_step_.predicted(), end_of_step_.singular_position().let_go());
    world_.read_states(after_);
    end_of_step_.confirm(after_);
}

void Simulation::observe() {
    observer_.advance(loads_, end_of_step_.equations(), now_, after_, step_size_);
    if (index_ % static_cast<uint64_t>(model_.output.every) != 0) return;
    // Where accelerations are the means over two steps, those at the start are by the initial conditions all the same
    const bool is_start = index_ == 0 && !networks_.stand();
    const Instant& instant =
        instant_.solve(time(), end_of_step_.equations(), now_, is_start ? first_after_ : after_, networks_, loads_);
    sinks_.row(observer_.row(time(), networks_, instant));
}

std::string Simulation::describe_speed() const {
    const FastestMode& mode = limit_ ? limit_->mode : fastest_;
    if (mode.body.empty()) return "nothing vibrates";
    std::string text = fmt::format("omega*h = {:.4g} (fastest vibration {})", mode.omega * step_size_, describe(mode));
    if (!limit_) return text;
    if (limit_->damping_share > 0.01)
        text += fmt::format(", {:.4g} with the dampers, which make {:.0f} % of its square", limit_->load,
                            100 * limit_->damping_share);
    return text + fmt::format("; stable below {:g}", kExplicitLimit);
}

void Simulation::follow_turning() {
    for (size_t b = 0; b < after_.size(); ++b) {
        const double squared = after_[b].angular_velocity.squaredNorm();
        if (squared <= fastest_turning_.squared_speed || !fastest_turning_.held[b]) [[likely]]
            continue;
        fastest_turning_.squared_speed = squared;
        fastest_turning_.body = b;
    }
}

Turning Simulation::fastest_turning() const {
    if (fastest_turning_.squared_speed == 0) return {};
    return {std::sqrt(fastest_turning_.squared_speed) * step_size_, model_.bodies[fastest_turning_.body].name};
}

void Simulation::refuse_divergence() const {
    for (size_t b = 0; b < after_.size(); ++b) {
        const BodyState& body = after_[b];
        const bool sane = (body.position.array().abs() <= kFarthest).all() &&
                          (body.velocity.array().abs() <= kFastest).all() &&
                          (body.angular_velocity.array().abs() <= kFastest).all() &&
                          body.angular_velocity.squaredNorm() * step_size_ * step_size_ <= M_PI * M_PI;  // false for NaN
        if (sane) [[likely]]
            continue;
        throw Error(
            ExitCode::numerical_failure,
            fmt::format(
                "t = {:.9g} s: body \"{}\" has diverged, or turns more than half a turn a step: position ({:.4g}, {:.4g}, "
                "{:.4g}) m, velocity ({:.4g}, {:.4g}, {:.4g}) m/s, turning at {:.4g} rad/s. {}",
                time() + step_size_, model_.bodies[b].name, body.position.x(), body.position.y(), body.position.z(),
                body.velocity.x(), body.velocity.y(), body.velocity.z(), body.angular_velocity.norm(), describe_speed()));
    }
}

}  // namespace dttmm::host
