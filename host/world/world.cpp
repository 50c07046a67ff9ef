// SPDX-License-Identifier: BSD-3-Clause
#include "world/world.h"

#include <fmt/format.h>
#include <ode/ode.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <mutex>

#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

static_assert(sizeof(dReal) == sizeof(double), "ODE must be the double-precision build");

namespace {

std::atomic<int> complaints{0};

/// CFM of ODE's joints over the largest mobility of a body: enough for redundant joints; JointClosure makes up for it.
constexpr double kSoftness = 1e-10;

/// A force along a joint's coordinate that is a smaller share of the joint's force is rounding.
/// Range 1e-15 or less to 1e-6 or more: no test bounds it.
constexpr double kForceRounding = 1e-12;

std::string format_text(const char* text, va_list arguments) {
    char buffer[512];
    std::vsnprintf(buffer, sizeof buffer, text, arguments);
    return buffer;
}

/// ODE goes on after a message, exits after an error and aborts after a failed assertion, even if the handler returns.
/// Throwing unwinds through it cleanly and ends the run instead; the world is not used again.
void on_message(int, const char*, va_list) { ++complaints; }
void on_failure(int number, const char* text, va_list arguments) {
    throw Error(ExitCode::internal_error, fmt::format("ODE failed (code {}): {}", number, format_text(text, arguments)));
}

dBodyID body_id(void* id) { return static_cast<dBodyID>(id); }

}  // namespace

/// What ODE's joint does to its first body over a step, and where the joint was at its start.
struct World::StopForce {
    dJointFeedback force{};
    Eigen::Vector3d axis, arm;  ///< of the first body: its anchor from its centre of mass [m, world]
};

/// ODE's process-wide state: initialised with the first world, closed with the last.
class World::Library {
public:
    Library() {
        dInitODE2(0);
        dAllocateODEDataForThread(static_cast<unsigned>(dAllocateMaskAll));
        dSetMessageHandler(on_message);
        dSetErrorHandler(on_failure);
        dSetDebugHandler(on_failure);
    }
    ~Library() { dCloseODE(); }
    static std::shared_ptr<Library> acquire() {
        static std::mutex mutex;
        static std::weak_ptr<Library> shared;
        const std::lock_guard lock(mutex);
        std::shared_ptr<Library> library = shared.lock();
        if (!library) shared = library = std::make_shared<Library>();
        return library;
    }
};

/// One world of ODE with its bodies, and the library for as long as it lives.
class World::Owner {
public:
    Owner() : library_(Library::acquire()), id_(dWorldCreate()) {}
    ~Owner() { dWorldDestroy(id_); }
    Owner(const Owner&) = delete;
    Owner& operator=(const Owner&) = delete;
    dWorldID id() const { return id_; }

private:
    std::shared_ptr<Library> library_;
    dWorldID id_;
};

World::World(const std::vector<Body>& bodies, const std::vector<Joint>& joints) : world_(std::make_unique<Owner>()) {
    dWorldSetGravity(world_->id(), 0, 0, 0);
    dWorldSetAutoDisableFlag(world_->id(), 0);
    for (const Body& body : bodies) {
        const dBodyID id = dBodyCreate(world_->id());
        dBodySetFiniteRotationMode(id, 1);
        dBodySetGyroscopicMode(id, 0);
        const Eigen::Matrix3d& J = body.inertia;
        dMass mass;
        dMassSetParameters(&mass, body.mass, 0, 0, 0, J(0, 0), J(1, 1), J(2, 2), J(0, 1), J(0, 2), J(1, 2));
        dBodySetMass(id, &mass);
        bodies_.push_back({id, dBodyGetPosition(id), dBodyGetRotation(id), dBodyGetLinearVel(id), dBodyGetAngularVel(id)});

        const Eigen::Vector3d arm = body.rotation * body.center_of_mass;
        set_state(bodies_.size() - 1, {body.position + arm, body.rotation, body.velocity + body.angular_velocity.cross(arm),
                                       body.angular_velocity});
    }
    if (joints.empty()) return;
    double largest_mobility = 1;
    for (const Joint& joint : joints)
        for (int index : {joint.first, joint.second}) {
            if (index < 0) continue;
            const Body& body = bodies[as_size(index)];
            largest_mobility = std::max({largest_mobility, 1 / body.mass, 1 / body.inertia.diagonal().minCoeff()});
        }
    dWorldSetERP(world_->id(), 1);
    dWorldSetCFM(world_->id(), kSoftness * largest_mobility);  // a hinge's own parameter is that of its stops only
    for (const Joint& joint : joints) create_joint(joint, kSoftness * largest_mobility);
    stops_.resize(joints.size());
    stop_forces_.resize(joints.size());
    for (size_t j = 0; j < joints.size(); ++j)
        if (joints_[j].has_stops) dJointSetFeedback(static_cast<dJointID>(joints_[j].id), &stop_forces_[j].force);
    before_.resize(bodies.size());
    after_.resize(bodies.size());
    closure_ = std::make_unique<JointClosure>(bodies, joints);
}

void World::create_joint(const Joint& joint, double cfm) {
    // ODE wants a body first. Its coordinate is that of its first body seen from its second: so the joint's second body, if
    // there is one, goes first; else the axis is turned round.
    const bool swapped = joint.second >= 0;
    const int body = swapped ? joint.second : joint.first, other = swapped ? joint.first : joint.second;
    const dBodyID first = body_id(bodies_[as_size(body)].id);
    const dBodyID second = other < 0 ? nullptr : body_id(bodies_[as_size(other)].id);
    const Eigen::Vector3d axis = swapped ? joint.axis : Eigen::Vector3d(-joint.axis);
    const Eigen::Vector3d& p = joint.anchor;
    dJointID id = nullptr;
    switch (joint.type) {
        case JointType::ball:
            id = dJointCreateBall(world_->id(), nullptr);
            dJointAttach(id, first, second);
            dJointSetBallAnchor(id, p.x(), p.y(), p.z());
            break;
        case JointType::hinge:
            id = dJointCreateHinge(world_->id(), nullptr);
            dJointAttach(id, first, second);
            dJointSetHingeAnchor(id, p.x(), p.y(), p.z());
            dJointSetHingeAxis(id, axis.x(), axis.y(), axis.z());
            break;
        case JointType::slider:
            id = dJointCreateSlider(world_->id(), nullptr);
            dJointAttach(id, first, second);
            dJointSetSliderAxis(id, axis.x(), axis.y(), axis.z());
            break;
        case JointType::universal: {
            const Eigen::Vector3d &axis1 = swapped ? joint.axis2 : joint.axis, &axis2 = swapped ? joint.axis : joint.axis2;
            id = dJointCreateUniversal(world_->id(), nullptr);
            dJointAttach(id, first, second);
            dJointSetUniversalAnchor(id, p.x(), p.y(), p.z());
            dJointSetUniversalAxis1(id, axis1.x(), axis1.y(), axis1.z());
            dJointSetUniversalAxis2(id, axis2.x(), axis2.y(), axis2.z());
            break;
        }
        case JointType::fixed:
            id = dJointCreateFixed(world_->id(), nullptr);
            dJointAttach(id, first, second);
            dJointSetFixed(id);
            break;
    }
    JointHandle handle{id, false, joint.type == JointType::hinge, joint.drive.has_value(), 0, 0};
    if (joint.drive) (handle.turns ? dJointSetHingeParam : dJointSetSliderParam)(id, dParamFMax, dInfinity);
    if (joint.limits && (joint.type == JointType::hinge || joint.type == JointType::slider)) {
        handle.has_stops = true;
        handle.lower = (*joint.limits)[0];
        handle.upper = (*joint.limits)[1];
        const auto set = handle.turns ? dJointSetHingeParam : dJointSetSliderParam;
        set(id, dParamLoStop, handle.lower);
        set(id, dParamHiStop, handle.upper);
        set(id, dParamStopERP, 1);
        set(id, dParamStopCFM, cfm);
        set(id, dParamBounce, 0);
    }
    joints_.push_back(handle);
}

World::~World() = default;

const char* World::engine_version() { return dODE_VERSION; }

void World::read_states(std::vector<BodyState>& states) const {
    using Rows = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>;
    for (size_t b = 0; b < bodies_.size(); ++b) {
        const Handle& at = bodies_[b];
        states[b].position = Eigen::Map<const Eigen::Vector3d>(at.position);
        states[b].rotation = Rows(at.rotation).leftCols<3>();
        states[b].velocity = Eigen::Map<const Eigen::Vector3d>(at.velocity);
        states[b].angular_velocity = Eigen::Map<const Eigen::Vector3d>(at.angular_velocity);
    }
}

void World::set_states(const std::vector<BodyState>& states) {
    for (size_t b = 0; b < bodies_.size(); ++b) set_state(b, states[b]);
}

void World::set_state(size_t body, const BodyState& state) {
    if (!state.position.allFinite() || !state.rotation.allFinite() || !state.velocity.allFinite() ||
        !state.angular_velocity.allFinite())
        throw Error(ExitCode::numerical_failure, fmt::format("body {}: its state is not finite", body + 1));
    const dBodyID id = body_id(bodies_[body].id);
    const Eigen::Quaterniond q(state.rotation);
    const dQuaternion quaternion = {q.w(), q.x(), q.y(), q.z()};
    dBodySetPosition(id, state.position.x(), state.position.y(), state.position.z());
    dBodySetQuaternion(id, quaternion);
    dBodySetLinearVel(id, state.velocity.x(), state.velocity.y(), state.velocity.z());
    dBodySetAngularVel(id, state.angular_velocity.x(), state.angular_velocity.y(), state.angular_velocity.z());
}

void World::apply(const std::vector<Eigen::Matrix<double, 6, 1>>& wrenches) {
    for (size_t b = 0; b < bodies_.size(); ++b) {
        const Eigen::Matrix<double, 6, 1>& w = wrenches[b];
        for (int i = 0; i < 6; ++i)
            if (!(std::abs(w(i)) <= kLargestWrench)) [[unlikely]]
                throw Error(ExitCode::numerical_failure,
                            fmt::format("body {}: the wrench over the step is not finite or beyond {:.0e} N", b + 1,
                                        kLargestWrench));
        const dBodyID id = body_id(bodies_[b].id);
        dBodySetForce(id, w(0), w(1), w(2));
        dBodySetTorque(id, w(3), w(4), w(5));
    }
}

void World::drive(const std::vector<Drive>& drives) {
    for (size_t j = 0; j < joints_.size(); ++j)
        if (joints_[j].is_driven)
            (joints_[j].turns ? dJointSetHingeParam : dJointSetSliderParam)(static_cast<dJointID>(joints_[j].id), dParamVel,
                                                                            drives[j].speed);
}

void World::find_stops(double h, std::vector<Stop>& stops) const {
    for (size_t j = 0; j < joints_.size(); ++j) {
        const JointHandle& joint = joints_[j];
        stops[j] = {};
        if (!joint.has_stops) continue;
        const auto id = static_cast<dJointID>(joint.id);
        const double coordinate = joint.turns ? dJointGetHingeAngle(id) : dJointGetSliderPosition(id);
        if (coordinate <= joint.lower)
            stops[j] = {true, (joint.lower - Stop::kPlay - coordinate) / h, 1};
        else if (coordinate >= joint.upper)
            stops[j] = {true, (joint.upper + Stop::kPlay - coordinate) / h, -1};
    }
}

/// Takes where joints are that have reached a stop.
void World::watch_stops() {
    for (size_t j = 0; j < joints_.size(); ++j) {
        if (!stops_[j].acts) continue;
        const auto id = static_cast<dJointID>(joints_[j].id);
        StopForce& watched = stop_forces_[j];
        watched.arm.setZero();
        dVector3 axis, anchor;
        if (joints_[j].turns) {
            dJointGetHingeAxis(id, axis);
            dJointGetHingeAnchor(id, anchor);
            watched.arm = Eigen::Map<Eigen::Vector3d>(anchor) -
                          Eigen::Map<const Eigen::Vector3d>(dBodyGetPosition(dJointGetBody(id, 0)));
        } else {
            dJointGetSliderAxis(id, axis);
        }
        watched.axis = Eigen::Map<Eigen::Vector3d>(axis);
    }
}

/// Whether ODE's joint had a force along its coordinate over the step: only its stop has one. Of the others rounding is
/// left.
bool World::pushes(size_t joint) const {
    const StopForce& watched = stop_forces_[joint];
    const Eigen::Map<const Eigen::Vector3d> force(watched.force.f1), moment(watched.force.t1);
    if (!joints_[joint].turns) return std::abs(watched.axis.dot(force)) > kForceRounding * force.norm();
    const double along = watched.axis.dot(moment - watched.arm.cross(force));
    return std::abs(along) > kForceRounding * (moment.norm() + watched.arm.norm() * force.norm());
}

/// ODE's own, with or without its joints; 0 if it ran out of memory.
int World::step(double h, bool with_joints) {
    if (with_joints) return dWorldStep(world_->id(), h);
    for (const JointHandle& joint : joints_) dJointDisable(static_cast<dJointID>(joint.id));
    const int done = dWorldStep(world_->id(), h);
    for (const JointHandle& joint : joints_) dJointEnable(static_cast<dJointID>(joint.id));
    return done;
}

void World::advance(double h, const std::vector<BodyState>& predicted, const LetGo& let_go) {
    const int before = complaints;
    if (closure_) {
        read_states(before_);
        find_stops(h, stops_);
        watch_stops();
    }
    int done = 0;
    try {
        done = step(h, let_go.empty());
    } catch (...) {
        (void)world_.release();  // of a world that was left in the middle of a step nothing can be freed
        throw;
    }
    if (done == 0) throw Error(ExitCode::resource_limit, "ODE could not allocate the memory for a step: nothing has moved");
    if (complaints != before) throw Error(ExitCode::numerical_failure, "ODE reported a numerical problem during the step");
    if (!closure_) return;
    read_states(after_);
    if (let_go.empty())
        for (size_t j = 0; j < stops_.size(); ++j) stops_[j].acts = stops_[j].acts && pushes(j);
    closure_->close(before_, h, let_go, predicted, stops_, after_);
    set_states(after_);
}

void World::save(Saved& saved) {
    saved.bodies.resize(bodies_.size());
    saved.stops = stops_;
    for (size_t b = 0; b < bodies_.size(); ++b) {
        Saved::Body& body = saved.bodies[b];
        std::copy_n(bodies_[b].position, 3, body.position);
        std::copy_n(dBodyGetQuaternion(body_id(bodies_[b].id)), 4, body.quaternion);
        std::copy_n(bodies_[b].velocity, 3, body.velocity);
        std::copy_n(bodies_[b].angular_velocity, 3, body.angular_velocity);
        set_saved(b, body);
    }
}

void World::restore(const Saved& saved) {
    for (size_t b = 0; b < bodies_.size(); ++b) set_saved(b, saved.bodies[b]);
    stops_ = saved.stops;
}

void World::set_saved(size_t body, const Saved::Body& saved) {
    const dBodyID id = body_id(bodies_[body].id);
    dBodySetPosition(id, saved.position[0], saved.position[1], saved.position[2]);
    dBodySetQuaternion(id, saved.quaternion);
    dBodySetLinearVel(id, saved.velocity[0], saved.velocity[1], saved.velocity[2]);
    dBodySetAngularVel(id, saved.angular_velocity[0], saved.angular_velocity[1], saved.angular_velocity[2]);
}

}  // namespace dttmm::host
