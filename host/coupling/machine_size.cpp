// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/machine_size.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "model/index.h"

namespace dttmm::host {

namespace {

/// Size of a machine that stands at one point, as a mass on a spring of no length: it has no other length to go by [m].
constexpr double kSizeOfPoint = 1;

}  // namespace

std::vector<BodyState> states_at_start(const Model& model) {
    std::vector<BodyState> states;
    for (const Body& body : model.bodies)
        states.push_back({body.position + body.rotation * body.center_of_mass, body.rotation, Eigen::Vector3d::Zero(),
                          Eigen::Vector3d::Zero()});
    return states;
}

MachineSize::MachineSize(const Model& model, const std::vector<JointEquations>& joints)
    : inertias(model.bodies.begin(), model.bodies.end()) {
    for (const Inertia& inertia : inertias) {
        reach.push_back(inertia.gyration_bound());
        mass += inertia.mass;
    }
    for (const JointEquations& joint : joints)
        for (const auto side : JointEquations::kSides)
            if (const int body = joint.bodies()[side]; body >= 0)
                reach[as_size(body)] = std::max(reach[as_size(body)], joint.arm(side));
    Eigen::AlignedBox3d box;
    for (const BodyState& body : states_at_start(model)) box.extend(body.position);
    for (const Node& node : model.nodes) box.extend(node.position);
    if (!box.isEmpty()) {
        span = box.diagonal().norm();
        extent = std::max(box.min().cwiseAbs().norm(), box.max().cwiseAbs().norm());
    }
    for (const double length : reach) span = std::max(span, length);
    for (const JointEquations& joint : joints)
        if (joint.has_stops() && !joint.turns())
            for (int side : {1, -1}) span = std::max(span, std::abs(joint.stop(side)));
    if (span == 0) span = kSizeOfPoint;
    extent = std::max(extent, span);
}

}  // namespace dttmm::host
