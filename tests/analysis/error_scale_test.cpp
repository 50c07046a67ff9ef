// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/error_scale.h"

#include <gtest/gtest.h>

#include <map>

#include "support/models.h"

namespace dttmm::host {
namespace {

const std::vector<Channel> kChannels = {{"time", "s"},
                                        {"bolt.force.z", "N"},
                                        {"bolt.moment.x", "N*m"},
                                        {"bolt.deflection.z", "m"},
                                        {"bolt.rotation.x", "rad"},
                                        {"plate.position.z", "m"},
                                        {"plate.velocity.z", "m/s"},
                                        {"plate.acceleration.z", "m/s^2"},
                                        {"plate.angular_velocity.x", "rad/s"},
                                        Channel(Channel::Of::body, "plate", "quaternion", "x", "1"),
                                        {"other.slip", "1"},
                                        {"energy.kinetic", "J"},
                                        {"energy.residual", "J"}};

/// A plate with markers 3 m and 4 m apart along x and y: L = 5 m.
Model plate() {
    Model model;
    model.bodies = {test::box("plate", 2, {3, 4, 0.1}, {0, 0, 7})};
    Marker low, high;
    low.position = {-1.5, -2, 0};
    high.position = {1.5, 2, 0};
    model.bodies[0].markers = {low, high};
    return model;
}

std::map<std::string, double> scales(const std::vector<std::vector<double>>& rows, double h, double omega = 0) {
    Recorder seen(kChannels);
    for (const auto& row : rows) seen.close_row(row);
    FastestMode fastest;
    fastest.omega = omega;
    const std::vector<double> all = error_scales(plate(), fastest, seen, h);
    std::map<std::string, double> named;
    for (size_t c = 0; c < kChannels.size(); ++c) named[kChannels[c].name()] = all[c];
    return named;
}

// Oracle: by hand. Each kind takes its largest, through L = 5 m: 6 N against 40 N m / 5 m = 8 N; 0.02 m and 0.001 rad x 5 m
// against the range 7.03 − 7 m; 0.2 m/s against 0.1 rad/s x 5 m; the energies share, the residual too.
TEST(ErrorScale, KindsShareTheLargestThroughALength) {
    const auto scale = scales(
        {{0, 0, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0}, {1, 6, -40, -0.02, 0.001, 7.03, 0.2, -30, 0.1, 0.0004, 0.9, 12, 1e-9}},
        1e-3);
    EXPECT_DOUBLE_EQ(scale.at("bolt.force.z"), 8);
    EXPECT_DOUBLE_EQ(scale.at("bolt.moment.x"), 40);
    EXPECT_NEAR(scale.at("bolt.deflection.z"), 0.03, 1e-15);
    EXPECT_NEAR(scale.at("plate.position.z"), 0.03, 1e-15);
    EXPECT_NEAR(scale.at("bolt.rotation.x"), 0.006, 1e-15);
    EXPECT_NEAR(scale.at("plate.quaternion.x"), 0.006, 1e-15);
    EXPECT_DOUBLE_EQ(scale.at("plate.velocity.z"), 0.5);
    EXPECT_DOUBLE_EQ(scale.at("plate.angular_velocity.x"), 0.1);
    EXPECT_DOUBLE_EQ(scale.at("plate.acceleration.z"), 30);
    EXPECT_DOUBLE_EQ(scale.at("other.slip"), 0.9);
    EXPECT_DOUBLE_EQ(scale.at("energy.kinetic"), 12);
    EXPECT_DOUBLE_EQ(scale.at("energy.residual"), 12);
}

// Oracle: by hand: nothing moves at 7 m from the origin, ρ = 7e-12 m, h = 2 ms, m ω² = 2 kg (100/s)².
TEST(ErrorScale, AMachineAtRestIsMeasuredByWhatRoundingMayDo) {
    const auto scale = scales({{0, 0, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0}}, 2e-3, 100);
    EXPECT_NEAR(scale.at("bolt.deflection.z"), 7e-12, 1e-24);
    EXPECT_NEAR(scale.at("plate.velocity.z"), 3.5e-9, 1e-21);
    EXPECT_NEAR(scale.at("plate.acceleration.z"), 1.75e-6, 1e-18);
    EXPECT_NEAR(scale.at("bolt.force.z"), 1.4e-7, 1e-19);
    EXPECT_NEAR(scale.at("energy.kinetic"), 2 * (1e4 + 2.5e5) * 49e-24, 1e-30);
}

// Oracle: by hand: a range of 6e-11 m at 7 m is rounding, and ρ = 7e-11 m/1 %; one of 8e-11 m is a motion.
TEST(ErrorScale, RoundingAtRestIsNoErrorAtAnyTolerance) {
    const auto with_range = [](double range) {
        Model model = plate();
        model.simulation.tolerance = 0.01;
        Recorder seen(kChannels);
        seen.close_row(std::vector<double>{0, 0, 0, 0, 0, 7, 0, 0, 0, 0, 0, 0, 0});
        seen.close_row(std::vector<double>{1, 3, 0, 0, 0, 7 - range, 0, 0, 0, 0, 0, 0, 0});
        FastestMode fastest;
        fastest.omega = 100;
        const std::vector<double> all = error_scales(model, fastest, seen, 2e-3);
        return std::pair(all[5], all[1]);
    };
    EXPECT_NEAR(with_range(6e-11).first, 7e-9, 1e-13);
    EXPECT_NEAR(with_range(6e-11).second, 3, 0) << "a force that changes by itself";
    EXPECT_NEAR(with_range(8e-11).first, 8e-11, 1e-14);
}

// Oracle: by hand: a range of 20 m makes ρ = 2e-8 m.
TEST(ErrorScale, AWideMotionRaisesTheFloors) {
    const auto scale = scales({{0, 0, 0, 0, 0, -10, 0, 0, 0, 0, 0, 0, 0}, {1, 0, 0, 0, 0, 10, 0, 0, 0, 0, 0, 0, 0}}, 1e-2);
    EXPECT_NEAR(scale.at("plate.velocity.z"), 2e-6, 1e-18);
}

}  // namespace
}  // namespace dttmm::host
