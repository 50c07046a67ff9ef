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
    largest_mobility_ = 1;
    for (const Joint& joint : joints)
        for (int index : {joint.first, joint.second}) {
            if (index < 0) continue;
            const Body& body = bodies[as_size(index)];
            largest_mobility_ = std::max({largest_mobility_, 1 / body.mass, 1 / body.inertia.diagonal().minCoeff()});
        }
    dWorldSetERP(world_->id(), 1);
    for (const Joint& joint : joints) create_joint(joint);
    before_.resize(bodies.size());
    after_.resize(bodies.size());
    closure_ = std::make_unique<JointClosure>(bodies, joints);
}

void World::create_joint(const Joint& joint) {
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
    const JointHandle handle{id, joint.type == JointType::hinge, joint.drive.has_value()};
    if (handle.is_driven) (handle.turns ? dJointSetHingeParam : dJointSetSliderParam)(id, dParamFMax, dInfinity);
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

/// ODE's own, with or without its joints; 0 if it ran out of memory.
int World::step(double h, bool with_joints) {
    // Redundant joints need it; JointClosure makes up for it. ODE divides it by h
    dWorldSetCFM(world_->id(), h * JointSystem::kProximal * largest_mobility_);
    if (with_joints) return dWorldStep(world_->id(), h);
    for (const JointHandle& joint : joints_) dJointDisable(static_cast<dJointID>(joint.id));
    const int done = dWorldStep(world_->id(), h);
    for (const JointHandle& joint : joints_) dJointEnable(static_cast<dJointID>(joint.id));
    return done;
}

void World::advance(double h, const std::vector<BodyState>& predicted, const LetGo& let_go) {
    const int before = complaints;
    if (closure_) read_states(before_);
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
    closure_->close(before_, h, let_go, predicted, after_);
    set_states(after_);
}

}  // namespace dttmm::host
