// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/loads.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "model/error.h"
#include "model/index.h"
#include "model/keys.h"
#include "model/step_time.h"

namespace dttmm::host {

namespace {

Eigen::Vector3d arm_of(const Model& model, const Attachment& on) {
    if (on.marker < 0) return Eigen::Vector3d::Zero();
    const Body& body = model.bodies[as_size(on.body)];
    return body.markers[as_size(on.marker)].position - body.center_of_mass;
}

/// World axes.
Eigen::Vector3d direction_of(const Load& load, const BodyState& body) {
    return load.turns ? Eigen::Vector3d(body.rotation * load.direction) : load.direction;
}

}  // namespace

Loads::Loads(const Model& model, const double weights[3])
    : weights_{weights[0], weights[1], weights[2]}, node_count_(model.nodes.size()) {
    for (const Body& body : model.bodies) weight_forces_.push_back(body.mass * model.simulation.gravity);
    for (const Load& load : model.loads) loads_.push_back({load, arm_of(model, load.on)});
    magnitudes_.resize(loads_.size());
    for (size_t n = 0; n < node_count_; ++n)
        if (const Node& node = model.nodes[n]; node.is_support())
            supports_.push_back({n, node.name, node.motion, node.motion_place});
    const size_t for_supports = supports_.empty() ? 0 : kSupportNumbers * node_count_;
    network_loads_.resize(6 * (node_count_ + loads_.size()) + for_supports);
}

/// [displacement; rotation vector] of a support.
Loads::Vector6 Loads::motion_of(size_t s, double time) const {
    Vector6 motion = Vector6::Zero();
    for (size_t d = 0; d < 6; ++d) {
        const auto& signal = supports_[s].motion[d];
        if (!signal) continue;
        const double value = signal->value(time);
        if (!(std::abs(value) <= kFarthest))
            throw Error(ExitCode::numerical_failure,
                        fmt::format("{}: node \"{}\": motion at t = {} s: its value is {}, not a finite number up to {:.0e}",
                                    supports_[s].place, supports_[s].name, time, value, kFarthest));
        motion(as_row(d)) = value;
    }
    return motion;
}

void Loads::move_supports(double time) {
    double* const first = &network_loads_[6 * (node_count_ + loads_.size())];
    for (size_t s = 0; s < supports_.size(); ++s)
        Eigen::Map<Vector6>{first + kSupportNumbers * supports_[s].node} = motion_of(s, time);
}

/// Velocity and acceleration at t0 by one-sided differences of second order. Rotations are taken from where the support is
/// at t0: the first and second derivative of that rotation vector r are ω and its rate there, for r is zero.
void Loads::add_rates_of_supports(double t0, double h) {
    double* const first = &network_loads_[6 * (node_count_ + loads_.size())];
    const auto rotation = [](const Vector6& motion) {
        const Eigen::Vector3d r = motion.tail<3>();
        return r.isZero(0) ? Eigen::Matrix3d(Eigen::Matrix3d::Identity())
                           : Eigen::AngleAxisd(r.norm(), r.normalized()).toRotationMatrix();
    };
    for (size_t s = 0; s < supports_.size(); ++s) {
        const Vector6 start = motion_of(s, t0);
        Vector6 way[4] = {Vector6::Zero()};
        for (int k = 1; k < 4; ++k) {
            way[k] = motion_of(s, t0 + k * h) - start;
            const Eigen::AngleAxisd turn(rotation(way[k] + start) * rotation(start).transpose());
            way[k].tail<3>() = turn.angle() * turn.axis();
        }
        double* const numbers = first + kSupportNumbers * supports_[s].node;
        Eigen::Map<Vector6>{numbers + 6} = (4 * way[1] - way[2]) / (2 * h);
        Eigen::Map<Vector6>{numbers + 12} = (-5 * way[1] + 4 * way[2] - way[3]) / (h * h);
    }
}

double Loads::magnitude(const Load& load, const Signal& signal, double time) const {
    const double value = signal.value(time);
    if (!(std::abs(value) <= World::kLargestWrench))
        throw Error(ExitCode::numerical_failure,
                    fmt::format("{}: load at t = {} s: its value is {}, not a finite number up to {:.0e}", load.place, time,
                                value, World::kLargestWrench));
    return value;
}

void Loads::find_after(size_t i, double time) {
    const Load& load = loads_[i].load;
    magnitudes_[i].after = magnitude(load, load.signal, time);
    if (load.is_per_length()) magnitudes_[i].after_at_to = magnitude(load, load.at_to(), time);
}

void Loads::start(double t0, double h) {
    for (size_t i = 0; i < loads_.size(); ++i) {
        find_after(i, t0);
        magnitudes_[i].now = magnitudes_[i].after;
    }
    gather_network_loads();
    move_supports(t0);
    if (h > 0) add_rates_of_supports(t0, h);
}

void Loads::begin_step(const dttmm_step& step) {
    const double end = rounded_time(step.time + step.size);
    for (size_t i = 0; i < loads_.size(); ++i) {
        Magnitude& m = magnitudes_[i];
        m.before = m.now;
        m.now = m.after;
        find_after(i, end);
        m.mean = 0.5 * (m.now + m.after);
        m.over_step = weights_[0] * m.after + weights_[1] * m.now + weights_[2] * m.before;
    }
    gather_network_loads();
    move_supports(end);
}

void Loads::gather_network_loads() {
    std::fill(network_loads_.begin(), network_loads_.end(), 0.0);
    for (size_t i = 0; i < loads_.size(); ++i) {
        const Load& load = loads_[i].load;
        if (load.is_per_length()) {
            double* along = &network_loads_[6 * (node_count_ + i)];
            Eigen::Map<Eigen::Vector3d>{along} = magnitudes_[i].after * load.direction;
            Eigen::Map<Eigen::Vector3d>{along + 3} = magnitudes_[i].after_at_to * load.direction;
        }
        if (load.on.node < 0) continue;
        double* wrench = &network_loads_[6 * as_size(load.on.node)];
        Eigen::Map<Eigen::Vector3d>(wrench + (load.is_moment ? 3 : 0)) += magnitudes_[i].after * load.direction;
    }
}

void Loads::add(const std::vector<BodyState>& now, double Magnitude::*magnitude, double* wrenches) const {
    for (size_t b = 0; b < weight_forces_.size(); ++b) Eigen::Map<Eigen::Vector3d>(wrenches + 6 * b) += weight_forces_[b];
    for (size_t i = 0; i < loads_.size(); ++i) {
        const Load& load = loads_[i].load;
        if (load.on.body < 0) continue;  // on a node or an element
        const auto body = as_size(load.on.body);
        const Eigen::Vector3d value = magnitudes_[i].*magnitude * direction_of(load, now[body]);
        Eigen::Map<Eigen::Vector3d> force(wrenches + 6 * body), moment(wrenches + 6 * body + 3);
        if (load.is_moment) {
            moment += value;
        } else {
            force += value;
            moment += (now[body].rotation * loads_[i].arm).cross(value);
        }
    }
}

double Loads::work_over_step(const std::vector<BodyState>& now, const std::vector<BodyState>& after, double h) const {
    double work = 0;
    for (size_t i = 0; i < loads_.size(); ++i) {
        const Load& load = loads_[i].load;
        if (load.on.body < 0) continue;  // its work is the network's
        const BodyState &from = now[as_size(load.on.body)], &to = after[as_size(load.on.body)];
        const Eigen::Vector3d way =
            load.is_moment
                ? Eigen::Vector3d(h * to.angular_velocity)
                : Eigen::Vector3d(to.position + to.rotation * loads_[i].arm - from.position - from.rotation * loads_[i].arm);
        // The mean direction: it turns by a small angle only
        const Eigen::Vector3d direction = 0.5 * (direction_of(load, from) + direction_of(load, to));
        work += magnitudes_[i].mean * direction.dot(way);
    }
    return work;
}

}  // namespace dttmm::host
