// SPDX-License-Identifier: BSD-3-Clause
//
// Forces per length inside a network: what a row has of it is in balance.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "core/rotation.h"
#include "support/dense_network.h"
#include "support/network_model.h"
#include "time/interior.h"

namespace dttmm::plugin {
namespace {

using test::DenseNetwork;
using test::NetworkModel;

constexpr int kParts = 4;
const Vector3 kRoot(0.2, -0.3, 0.1), kEnd(0.9, 0.5, 0.7), kPull(0.7, -9.81, 2.1);
const NetworkModel::Values kLine = {{"segments", {double{kParts}}},
                                    {"up", {0.2, 0.1, 1}},
                                    {"section.EA", {3e6}},
                                    {"section.EIy", {130}},
                                    {"section.EIz", {70}},
                                    {"section.GJ", {60}},
                                    {"section.GAy", {6e5}},
                                    {"section.GAz", {8e5}},
                                    {"section.mass", {1.7}},
                                    {"section.inertia", {0.004}},
                                    {"section.mass_offset", {0.03, -0.02}}};

/// A beam, its mass off its axis, from the ground or free, under a load in the world's axes and one in its own.
NetworkModel make_line(uint32_t root) {
    NetworkModel model;
    model.node("root", root, kRoot);
    model.node("end", DTTMM_NODE_INNER, kEnd);
    model.element("line", "beam", {"root", "end"}, kLine);
    model.line_load("line", DTTMM_AXES_WORLD);
    model.line_load("line", DTTMM_AXES_ELEMENT);
    model.set_gravity(kPull);
    return model;
}

Vector6 in_world_axes(double t) { return (Vector6() << 30 * std::cos(9 * t), -12, 20, 25, 40 * t, -17).finished(); }
Vector6 in_own_axes(double t) { return (Vector6() << 5, 21, -30 * std::sin(8 * t), -9, 14, 11).finished(); }

std::vector<double> line_values(size_t inner_nodes, double t) {
    std::vector<double> list(6 * inner_nodes, 0.0);
    for (const Vector6& six : {in_world_axes(t), in_own_axes(t)}) list.insert(list.end(), six.begin(), six.end());
    return list;
}

// Oracle: Newton and Euler, about the world's origin. In every row, the first too, the rates of momentum of all segments are
// the loads, integrated over the segments where they are, the weight and what the root is recorded to carry.
TEST(LineLoadsInside, EveryRowIsInBalance) {
    for (uint32_t root : {uint32_t{DTTMM_NODE_GROUND}, uint32_t{DTTMM_NODE_INNER}}) {
        const NetworkModel model = make_line(root);
        const dttmm_network description = model.description();
        DenseNetwork network(description);
        const size_t nodes = root == DTTMM_NODE_INNER ? 2 : 1;
        const double h = 2e-3;
        std::vector<double> now = line_values(nodes, 0), outputs(network.channels().size());
        network.start({0, 0, h}, nullptr, nullptr, now.data());
        const Mechanism& mechanism = network.mechanism();
        const SegmentsSpec line = mechanism.assembly.segments.at(0);
        for (uint64_t n = 0; n < 150; ++n) {
            const double t = static_cast<double>(n) * h;
            const std::vector<double> end = line_values(nodes, t + h);
            network.begin_step({n, t, h}, end.data());
            network.commit_settled(nullptr);
            network.outputs(outputs.data());
            Vector6 left = Vector6::Zero();
            double size = 1;
            for (int i = 0; i < kParts; ++i) {
                const int f = line.first + i;
                const FrameSpec& spec = mechanism.assembly.frames[as_size(f)];
                const FrameView at = mechanism.frame_before(f);
                const Matrix3 R = at.axes();
                const Twist a = network.interior()->instant().acceleration(f, Vector3::Zero());
                const Vector3 w = R.transpose() * network.interior()->instant().velocity(f).angular;
                const Vector3 push = spec.mass * (a.linear - kPull);
                left.head<3>() += push;
                left.tail<3>() +=
                    at.origin().cross(push) + R * (spec.inertia * (R.transpose() * a.angular) + w.cross(spec.inertia * w));
                // Simpson's rule over the segment, whose points go with it; its axes are those of the element
                for (const auto& [part, weight] : {std::pair{0.0, 1.0 / 6}, {0.5, 4.0 / 6}, {1.0, 1.0 / 6}}) {
                    const double share = (i + part) / kParts, l = line.length;
                    const auto along = [&](const Vector6& q) {
                        return Vector3(q.head<3>() + share * (q.tail<3>() - q.head<3>()));
                    };
                    const Vector3 point = at.origin() + R * (line.arm + (part - 0.5) * l * Vector3::UnitX());
                    const Vector3 force = weight * l * (along(in_world_axes(t)) + R * along(in_own_axes(t)));
                    left.head<3>() -= force;
                    left.tail<3>() -= point.cross(force);
                    size += force.norm();
                }
            }
            // The first channels: force at the `from` end in the element's axes there, which on the ground stay. The moment
            // there is that of the undeformed half segment: to first order in what it gives
            if (root == DTTMM_NODE_GROUND) {
                const Matrix3 axes = mechanism.assembly.frames[as_size(line.first)].pose.rotation;
                const Vector3 force = axes * Eigen::Map<const Vector3>(&outputs[0]),
                              moment = axes * Eigen::Map<const Vector3>(&outputs[3]);
                left.head<3>() += force;  // the line is pulled back with what pulls the root
                left.tail<3>() += kRoot.cross(force) + moment;
                size += force.norm() + moment.norm();
                EXPECT_LT(left.tail<3>().norm(), 1e-4 * size) << n;
                left.tail<3>().setZero();
            }
            EXPECT_LT(left.norm(), 1e-9 * size) << "root " << root << " row " << n;
        }
    }
}

// Oracle: the impulse of the loads and of the weight. A free line keeps it to rounding, whatever else it does: loads in the
// world's axes alone, so that the impulse is known.
TEST(LineLoadsInside, AFreeLineTakesUpTheirImpulse) {
    const NetworkModel model = make_line(DTTMM_NODE_INNER);
    DenseNetwork network(model.description());
    const double h = 2e-3, length = (kEnd - kRoot).norm();
    const Vector6 q = (Vector6() << 30, -12, 20, 25, 40, -17).finished();
    std::vector<double> loads(24, 0.0);
    std::copy(q.begin(), q.end(), loads.begin() + 12);
    network.start({0, 0, h}, nullptr, nullptr, loads.data());
    const Vector3 rate = length * (0.5 * (q.head<3>() + q.tail<3>()) + 1.7 * kPull);
    for (uint64_t n = 0; n < 500; ++n) {
        network.begin_step({n, static_cast<double>(n) * h, h}, loads.data());
        network.commit_settled(nullptr);
        const Twist momentum = network.interior()->momentum();  // half a step before the end
        const double t = (static_cast<double>(n) + 0.5) * h;
        EXPECT_LT((momentum.linear - t * rate).norm(), 1e-12 * rate.norm()) << n;
    }
}

}  // namespace
}  // namespace dttmm::plugin
