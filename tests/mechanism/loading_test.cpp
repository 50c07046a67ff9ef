// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/loading.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/rotation.h"
#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

using test::NetworkModel;
using ::testing::HasSubstr;

const Vector3 kFrom(0.3, -0.2, 0.7), kTo(1.1, 0.9, 0.1);
constexpr int kSegments = 5;
constexpr double kLength = 1.4866068747318506;  // √(0.8² + 1.1² + 0.6²)

/// A beam, its mass off its axis, from a body to a node that is held in one direction, so that a frame of the ground comes
/// between; a spring and a rigid body with a node off its centre. Loads along the beam in both kinds of axes.
NetworkModel make_loaded() {
    NetworkModel model;
    model.node("body", DTTMM_NODE_ON_BODY, kFrom, rotation_from_vector(Vector3(0.2, 0.1, -0.4)), {0.1, 0.2, -0.3});
    model.node("end", DTTMM_NODE_INNER, kTo);
    model.node("mass", DTTMM_NODE_INNER, {2, 0, 1}, rotation_from_vector(Vector3(0.9, -0.3, 0.2)));
    model.node("wall", DTTMM_NODE_INNER, {3, 0, 0});
    model.fix("end", 1);
    model.fix("wall", 0x3f);
    model.element("spring", "spring_damper", {"end", "mass"}, {{"stiffness", {1e3}}, {"rotational_stiffness", {50}}});
    model.element("tie", "spring_damper", {"wall", "mass"}, {{"stiffness", {1e3}}});
    model.element("girder", "beam", {"body", "end"},
                  {{"segments", {double{kSegments}}},
                   {"up", {0.3, 0.1, 1}},
                   {"section.EA", {3e8}},
                   {"section.EIy", {5e4}},
                   {"section.EIz", {7e3}},
                   {"section.GJ", {1.9e4}},
                   {"section.GAy", {6e6}},
                   {"section.GAz", {8e7}},
                   {"section.mass", {13.7}},
                   {"section.inertia", {0.2}},
                   {"section.mass_offset", {0.03, -0.02}}});
    model.element("lump", "rigid_body", {"mass"},
                  {{"mass", {3}},
                   {"center_of_mass", {0.1, -0.2, 0.05}},
                   {"inertia.xx", {0.1}},
                   {"inertia.yy", {0.2}},
                   {"inertia.zz", {0.15}}});
    model.line_load("girder", DTTMM_AXES_ELEMENT);
    model.line_load("girder", DTTMM_AXES_WORLD);
    return model;
}

/// Values of the loads on the nodes end, mass and wall, and on the lines.
std::vector<double> values(const Vector6& on_mass, const Vector6& turning, const Vector6& fixed) {
    std::vector<double> list(6, 0.0);
    for (const Vector6& six : {on_mass, Vector6(Vector6::Constant(1e9)), turning, fixed})
        list.insert(list.end(), six.begin(), six.end());
    return list;
}

/// Every frame where it starts, and then turned and moved, each otherwise.
std::vector<Frame> moved_frames(const Assembly& assembly, double size) {
    std::vector<Frame> frames;
    for (size_t f = 0; f < assembly.frames.size(); ++f) {
        const double n = static_cast<double>(f) + 1;
        Pose pose = assembly.frames[f].pose;
        pose.position += size * Vector3(0.1 * n, -0.05, 0.02 * n * n);
        pose.rotation = rotation_from_vector(size * Vector3(0.1, 0.2 - 0.03 * n, 0.05 * n)) * pose.rotation;
        frames.push_back(make_frame(pose));
    }
    return frames;
}

// Oracle: the integral over each segment of the linear force at its points, which are part of the segment's frame: Simpson's
// rule, exact for a parabola, which the moment of a linear force is.
TEST(Loading, IsTheIntegralOfTheForceOverEverySegment) {
    const NetworkModel model = make_loaded();
    const dttmm_network network = model.description();
    const Assembly assembly = assemble(network);
    const Loading loading(assembly, network);
    const Vector6 turning = (Vector6() << 100, -230, 70, 400, 150, -310).finished(),
                  fixed = (Vector6() << -50, 20, 170, 90, -250, 110).finished();
    const std::vector<double> load = values(Vector6::Zero(), turning, fixed);
    ASSERT_EQ(loading.value_count(), load.size());
    const Matrix3 axes = assembly.frames[as_size(assembly.segments.at(0).first)].pose.rotation;
    for (double size : {0.0, 1.0}) {
        const std::vector<Frame> frames = moved_frames(assembly, size);
        std::vector<Vector6> wrenches(frames.size(), Vector6::Zero()), expected = wrenches;
        loading.add_wrenches(frames, load.data(), wrenches);
        for (int i = 0; i < kSegments; ++i) {
            const auto f = as_size(assembly.segments[0].first + i);
            ASSERT_EQ(assembly.frames[f].segment, i + 1);
            const Pose& start = assembly.frames[f].pose;
            for (const auto& [part, weight] : {std::pair{0.0, 1.0 / 6}, {0.5, 4.0 / 6}, {1.0, 1.0 / 6}}) {
                const double share = (i + part) / kSegments;
                const Vector3 at = kFrom + share * (kTo - kFrom);  // at the start
                const Vector3 arm = frames[f].axes() * (start.rotation.transpose() * (at - start.position));
                const auto along = [&](const Vector6& q) {
                    return Vector3(q.head<3>() + share * (q.tail<3>() - q.head<3>()));
                };
                const Vector3 force =
                    weight * kLength / kSegments *
                    (along(fixed) + frames[f].axes() * (start.rotation.transpose() * axes * along(turning)));
                expected[f].head<3>() += force;
                expected[f].tail<3>() += arm.cross(force);
            }
        }
        for (size_t f = 0; f < frames.size(); ++f) {
            EXPECT_LT((wrenches[f] - expected[f]).norm(), 1e-12 * 150) << size << " frame " << f;
            EXPECT_EQ(wrenches[f], loading.wrench(static_cast<int>(f), frames[f], load.data()));
        }
    }
}

// Oracle: by hand: the wrench at the node, about the centre of mass that its frame stands at. What is fixed takes none.
TEST(Loading, OfANodeHasItsLever) {
    const NetworkModel model = make_loaded();
    const dttmm_network network = model.description();
    const Assembly assembly = assemble(network);
    const Loading loading(assembly, network);
    const Vector6 wrench = (Vector6() << 1, -2, 3, 0.4, 0.5, -0.6).finished();
    const std::vector<double> load = values(wrench, Vector6::Zero(), Vector6::Zero());
    const std::vector<Frame> frames = moved_frames(assembly, 0.7);
    std::vector<Vector6> wrenches(frames.size(), Vector6::Zero());
    loading.add_wrenches(frames, load.data(), wrenches);
    const auto on = as_size(assembly.nodes[2].frame);
    const Vector3 arm = frames[on].axes() * -Vector3(0.1, -0.2, 0.05);
    Vector6 expected = wrench;
    expected.tail<3>() += arm.cross(Vector3(wrench.head<3>()));
    for (size_t f = 0; f < frames.size(); ++f)
        EXPECT_LT((wrenches[f] - (f == on ? expected : Vector6(Vector6::Zero()))).norm(), 1e-14) << f;
    EXPECT_TRUE(loading.is_on(assembly.nodes[2].frame));
    EXPECT_FALSE(loading.is_on(assembly.nodes[3].frame)) << "fixed in all directions";
    EXPECT_FALSE(loading.is_on(0)) << "a body";
}

// Oracle: central differences of the wrench about a point that goes with the frame as it turns about that. The unsymmetric
// part, about the frame's origin, is that of the differences less ½ [M]×, which what balances the moment M makes up for.
TEST(Loading, StiffnessIsTheDerivativeOfTheWrench) {
    const NetworkModel model = make_loaded();
    const dttmm_network network = model.description();
    const Assembly assembly = assemble(network);
    const Loading loading(assembly, network);
    const std::vector<double> load = values((Vector6() << 31, -42, 73, 1.4, 2.5, -3.6).finished(),
                                            (Vector6() << 100, -230, 70, 400, 150, -310).finished(),
                                            (Vector6() << -50, 20, 170, 90, -250, 110).finished());
    const std::vector<Frame> frames = moved_frames(assembly, 0.8);
    constexpr double kTurn = 1e-4;
    int loaded = 0;
    for (size_t f = 0; f < frames.size(); ++f) {
        if (!loading.is_on(as_int(f))) continue;
        ++loaded;
        const FrameView at = frames[f];
        const auto slope_about = [&](const Vector3& aside) {
            const Vector3 origin = at.origin() + aside;
            Matrix6 slope = Matrix6::Zero();
            for (int c = 0; c < 3; ++c)
                for (const double sign : {1.0, -1.0}) {
                    const Matrix3 turn = rotation_from_vector(Vector3(sign * kTurn * Vector3::Unit(c)));
                    const Frame turned = make_frame({origin - turn * aside, turn * at.axes()});
                    Vector6 wrench = loading.wrench(as_int(f), turned, load.data());
                    wrench.tail<3>() -= (turn * aside).cross(Vector3(wrench.head<3>()));
                    slope.col(3 + c) -= sign / (2 * kTurn) * wrench;
                }
            return slope;
        };
        const Vector3 aside(0.2, -0.1, 0.3);
        const Matrix6 slope = slope_about(aside), expected = 0.5 * (slope + slope.transpose());
        EXPECT_LE((loading.stiffness(as_int(f), at, at.origin() + aside, load.data()) - expected).norm(),
                  1e-7 * expected.norm())
            << f;
        const Matrix6 own = slope_about(Vector3::Zero());
        Matrix6 unsymmetric = 0.5 * (own - own.transpose());
        unsymmetric.bottomRightCorner<3, 3>() -= 0.5 * skew(loading.wrench(as_int(f), at, load.data()).tail<3>());
        EXPECT_LE((loading.unsymmetric_stiffness(as_int(f), at, load.data()) - unsymmetric).norm(), 1e-7 * own.norm()) << f;
    }
    EXPECT_EQ(loaded, kSegments + 2) << "two nodes";
}

TEST(Loading, AForcePerLengthOnWhatIsNoLineIsRefused) {
    const auto message = [](const char* element, uint32_t axes) {
        NetworkModel model = make_loaded();
        model.line_load(element, axes);
        try {
            assemble(model.description());
        } catch (const Error& error) {
            return std::pair(std::string(error.what()), error.element());
        }
        return std::pair(std::string("none"), -2);
    };
    EXPECT_EQ(message("girder", DTTMM_AXES_WORLD).second, -2);
    EXPECT_THAT(message("tie", DTTMM_AXES_WORLD).first, HasSubstr("a spring_damper is no line; put a beam or a rod there"));
    EXPECT_EQ(message("tie", DTTMM_AXES_WORLD).second, 1);
    EXPECT_THAT(message("lump", DTTMM_AXES_ELEMENT).first, HasSubstr("a rigid_body is no line"));
    EXPECT_THAT(message("no such", 0).first, HasSubstr("line load 2 is on no element"));
    EXPECT_THAT(message("girder", 2).first, HasSubstr("line load 2: there are no axes 2"));
}

}  // namespace
}  // namespace dttmm::plugin
