// SPDX-License-Identifier: BSD-3-Clause
#include "world/world.h"

#include <fmt/format.h>
#include <ode/ode.h>

#include <Eigen/Geometry>
#include <atomic>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <mutex>

#include "model/error.h"

namespace dttmm {

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
        dAllocateODEDataForThread(dAllocateMaskAll);
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

World::World(const std::vector<Body>& bodies) : world_(std::make_unique<Owner>()) {
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

void World::advance(double h) {
    const int before = complaints;
    if (dWorldStep(world_->id(), h) == 0)
        throw Error(ExitCode::resource_limit, "ODE could not allocate the memory for a step: nothing has moved");
    if (complaints != before) throw Error(ExitCode::numerical_failure, "ODE reported a numerical problem during the step");
}

}  // namespace dttmm
