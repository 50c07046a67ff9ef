// SPDX-License-Identifier: BSD-3-Clause
#include "statics/resting_joint.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <memory>
#include <random>
#include <string>

#include "core/rotation.h"

namespace dttmm::plugin {
namespace {

enum class Kind { spring, ball, hinge, rigid_turns, line, axial };

/// A joint between two frames that have moved far from where it is undeformed, and forces along its deformations.
struct Case {
    Assembly assembly;
    std::unique_ptr<Joint> joint;
    Frame from, to;
    Vector6 force, rigid;
};

class Draw {
public:
    explicit Draw(unsigned seed) : engine_(seed) {}
    double number(double size = 1) { return std::uniform_real_distribution<double>(-size, size)(engine_); }
    Vector3 vector(double size = 1) {
        Vector3 v;
        for (int i = 0; i < 3; ++i) v(i) = number(size);
        return v;
    }

private:
    std::mt19937 engine_;
};

Frame moved(const Frame& frame, const Vector3& shift, const Vector3& turn) {
    Frame out = frame;
    Eigen::Map<Vector3>(out.position) += shift;
    Eigen::Map<RowMajor3> axes(out.rotation);
    axes = (rotation_from_vector(turn) * axes).eval();
    return out;
}

std::shared_ptr<const JointLaw> law_of(Kind kind) {
    auto law = std::make_shared<JointLaw>();
    law->stiffness << 3e3, 2e3, 1e3, 50, 40, 30;
    switch (kind) {
        case Kind::spring:
            break;
        case Kind::ball:
            law->stiffness.tail<3>().setZero();
            break;
        case Kind::hinge:
            law->stiffness.head<5>().setZero();
            for (const size_t d : {0u, 1u, 2u, 3u, 4u}) law->rigid[d] = true;
            break;
        case Kind::rigid_turns:
            law->stiffness.tail<3>().setZero();
            for (const size_t d : {3u, 4u, 5u}) law->rigid[d] = true;
            break;
        case Kind::line:
            law->line = {1, 0.07, 2.1, 1.7};
            break;
        case Kind::axial:
            law->stiffness.tail<5>().setZero();
            law->axial = Axial{1.3, 1.1};
            break;
    }
    return law;
}

Case make_case(Kind kind, unsigned seed, double turn) {
    Draw draw(seed);
    Case c;
    Pose poses[3];  // of the frames and of the joint between them
    for (Pose& pose : poses) {
        pose.position = draw.vector();
        pose.rotation = rotation_from_vector(draw.vector());
    }
    for (int f : {0, 1}) {
        c.assembly.frames.emplace_back();
        c.assembly.frames.back().pose = poses[f];
        Frame& frame = f == 0 ? c.from : c.to;
        Eigen::Map<Vector3>(frame.position) = poses[f].position + draw.vector(0.2);
        Eigen::Map<RowMajor3>(frame.rotation) = poses[f].rotation;
        frame = moved(frame, Vector3::Zero(), turn * draw.vector());
    }
    JointSpec spec;
    spec.from = 0;
    spec.to = 1;
    spec.law = law_of(kind);
    spec.pose = poses[2];
    c.joint = std::make_unique<Joint>(spec, c.assembly, std::make_shared<JointKind>(spec.law));
    for (int d = 0; d < 6; ++d) {
        const double number = draw.number(100);
        const bool is_rigid = spec.law->rigid[static_cast<size_t>(d)];
        c.force(d) = !is_rigid && spec.law->carried()[static_cast<size_t>(d)] ? number : 0;
        c.rigid(d) = is_rigid ? number : 0;
    }
    return c;
}

/// Differences by it neglect 1e-10 of third derivatives, some 1e3 for forces of 100 N and 1e5 for springs of 3e3 N/m at
/// arms of a metre; rounding is 1e-16 of the forces over the step: 1e-9 and 1e-7.
constexpr double kStep = 1e-5;

using Wrenches = Eigen::Matrix<double, 12, 1>;

/// What forces of the joint do to its frames, `from` first.
Wrenches wrenches(const PlacedJoint& placed, const Vector6& along, const Vector6& rigid) {
    const JointForce force = carried_force(placed, along, rigid);
    Wrenches all;
    all << force.force, force.on_from, -force.force, -force.on_to;
    return all;
}

/// Their derivatives by the poses of the frames less what K says, by central differences; the largest.
double misfit(const Case& c, const EndBlocks& K, const auto& wrenches_at) {
    double largest = 0;
    for (int end : {0, 1})
        for (int d = 0; d < 6; ++d) {
            const auto at = [&](double sign) {
                const Vector6 step = sign * kStep * Vector6::Unit(d);
                const Frame other = moved(end == 0 ? c.from : c.to, step.head<3>(), step.tail<3>());
                return wrenches_at(PlacedJoint(*c.joint, end == 0 ? Ends{other, c.to} : Ends{c.from, other}));
            };
            const Wrenches slope = (at(1) - at(-1)) / (2 * kStep);
            for (int row : {0, 1})
                largest = std::max(largest, (K.at[row][end].col(d) + slope.segment<6>(6 * row)).cwiseAbs().maxCoeff());
        }
    return largest;
}

// Oracle: differences of the energy that a joint stores, of which its forces are the slope.
class Slopes : public testing::TestWithParam<Kind> {};

TEST_P(Slopes, OfTheEnergyAreTheForces) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
        const Case c = make_case(GetParam(), seed, 0.5);
        const auto energy = [&](Ends ends) {
            const PlacedJoint placed(*c.joint, ends);
            return c.joint->strain_energy(placed.x.head<3>(), placed.x.tail<3>(), nullptr);
        };
        const PlacedJoint placed(*c.joint, Ends{c.from, c.to});
        const Wrenches forces = wrenches(placed, resting_force(*c.joint, placed.x).force, Vector6::Zero());
        for (int end : {0, 1})
            for (int d = 0; d < 6; ++d) {
                const auto at = [&](double sign) {
                    const Vector6 step = sign * kStep * Vector6::Unit(d);
                    const Frame other = moved(end == 0 ? c.from : c.to, step.head<3>(), step.tail<3>());
                    return energy(end == 0 ? Ends{other, c.to} : Ends{c.from, other});
                };
                const double most = 1e-5 + 1e-9 * forces.cwiseAbs().maxCoeff();
                EXPECT_NEAR(forces(6 * end + d), (at(-1) - at(1)) / (2 * kStep), most) << seed << ' ' << end << ' ' << d;
            }
    }
}
INSTANTIATE_TEST_SUITE_P(All, Slopes, testing::Values(Kind::spring, Kind::ball, Kind::line, Kind::axial));

class HeldForces : public testing::TestWithParam<Kind> {};

// Oracle: central differences of the wrenches that the forces are, by the poses of both frames. Turned by up to 2 rad.
TEST_P(HeldForces, TurningStiffnessIsTheDerivativeOfTheWrenches) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
        const Case c = make_case(GetParam(), seed, 0.1 * (seed % 7));
        const PlacedJoint placed(*c.joint, {c.from, c.to});
        const EndBlocks K = turning_stiffness(placed, c.force, c.rigid, spread_tangent(placed, c.force, c.rigid));
        EXPECT_LT(misfit(c, K, [&](const PlacedJoint& there) { return wrenches(there, c.force, c.rigid); }), 2e-6)
            << "seed " << seed;
    }
}

// Oracle: the same of the forces of its springs, which grow with the deformation: of some 3e3 N/m, 1e4 N m.
TEST_P(HeldForces, WithTheStiffnessOfTheSpringsTheyAreTheWholeDerivative) {
    for (unsigned seed = 1; seed <= 20; ++seed) {
        const Case c = make_case(GetParam(), seed, 0.1 * (seed % 7));
        const PlacedJoint placed(*c.joint, {c.from, c.to});
        const auto [force, tangent] = resting_force(*c.joint, placed.x);
        EndBlocks K = turning_stiffness(placed, force, c.rigid, spread_tangent(placed, force, c.rigid));
        const EndBlocks own = c.joint->stiffness(placed.pose, c.joint->along(placed.x, tangent));
        for (int row : {0, 1})
            for (int column : {0, 1}) K.at[row][column] += own.at[row][column];
        const auto wrenches_at = [&](const PlacedJoint& there) {
            return wrenches(there, resting_force(*c.joint, there.x).force, c.rigid);
        };
        EXPECT_LT(misfit(c, K, wrenches_at), 1e-4) << "seed " << seed;
    }
}

// Oracle: central differences of force and moment in the joint's axes, by motions of the `to` end there.
TEST_P(HeldForces, SpreadTangentIsTheDerivativeInTheAxesOfTheJoint) {
    if (GetParam() == Kind::axial) return;  // its axes follow its line
    for (unsigned seed = 1; seed <= 20; ++seed) {
        const Case c = make_case(GetParam(), seed, 0.1 * (seed % 7));
        const PlacedJoint placed(*c.joint, {c.from, c.to});
        const Matrix6 spread = spread_tangent(placed, c.force, c.rigid);
        const Matrix3 R = placed.pose.axes;
        for (int d = 0; d < 6; ++d) {
            const auto at = [&](double sign) {
                // About the joint's point, so that a turn does not shift it
                const Vector3 shift = d < 3 ? Vector3(sign * kStep * R.col(d)) : Vector3(Vector3::Zero()),
                              turn = d < 3 ? Vector3(Vector3::Zero()) : Vector3(sign * kStep * R.col(d - 3));
                const Vector3 back = placed.pose.lever - rotation_from_vector(turn) * placed.pose.lever;
                const Frame to = moved(c.to, shift + back, turn);
                const PlacedJoint there(*c.joint, {c.from, to});
                const JointForce force = carried_force(there, c.force, c.rigid);
                Vector6 own;
                own << R.transpose() * force.force, R.transpose() * (force.on_to - there.pose.lever.cross(force.force));
                return own;
            };
            const Vector6 slope = (at(1) - at(-1)) / (2 * kStep);
            EXPECT_LT((spread.col(d) - slope).cwiseAbs().maxCoeff(), 1e-6) << "seed " << seed << " direction " << d;
        }
    }
}

std::string name_of_kind(const testing::TestParamInfo<Kind>& info) {
    const char* const names[] = {"Spring", "Ball", "Hinge", "RigidTurns", "Line", "Axial"};
    return names[static_cast<size_t>(info.param)];
}

INSTANTIATE_TEST_SUITE_P(Kinds, HeldForces,
                         testing::Values(Kind::spring, Kind::ball, Kind::hinge, Kind::rigid_turns, Kind::line, Kind::axial),
                         name_of_kind);

}  // namespace
}  // namespace dttmm::plugin
