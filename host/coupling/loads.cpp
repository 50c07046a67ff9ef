// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/loads.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

Eigen::Vector3d arm_of(const Model& model, const Attachment& on) {
    if (on.marker < 0) return Eigen::Vector3d::Zero();
    const Body& body = model.bodies[as_size(on.body)];
    return body.markers[as_size(on.marker)].position - body.center_of_mass;
}

}  // namespace

Loads::Loads(const Model& model, const double weights[3])
    : weights_{weights[0], weights[1], weights[2]}, node_count_(model.nodes.size()) {
    for (const Body& body : model.bodies) weight_forces_.push_back(body.mass * model.simulation.gravity);
    for (const Load& load : model.loads) loads_.push_back({load, arm_of(model, load.on)});
    magnitudes_.resize(loads_.size());
    network_loads_.resize(6 * (node_count_ + loads_.size()));
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

void Loads::start(double t0) {
    for (size_t i = 0; i < loads_.size(); ++i) {
        find_after(i, t0);
        magnitudes_[i].now = magnitudes_[i].after;
    }
    gather_network_loads();
}

void Loads::begin_step(const dttmm_step& step) {
    const double end = step.time + step.size;
    for (size_t i = 0; i < loads_.size(); ++i) {
        Magnitude& m = magnitudes_[i];
        m.before = m.now;
        m.now = m.after;
        find_after(i, end);
        m.mean = 0.5 * (m.now + m.after);
        m.over_step = weights_[0] * m.after + weights_[1] * m.now + weights_[2] * m.before;
    }
    gather_network_loads();
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
        const Eigen::Vector3d value = magnitudes_[i].*magnitude * load.direction;
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
        work += magnitudes_[i].mean * load.direction.dot(way);
    }
    return work;
}

}  // namespace dttmm::host
