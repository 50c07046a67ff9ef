// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/shape_match.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "model/error.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using Complex = std::complex<double>;

/// Two places and four modes: one along x, a double one in y and z, one that moves neither place.
const char* const kModes = R"({"format": "dttmm-modes/1", "modes": [
 {"frequency_hz": 3, "shape": {"a": [1, 0, 0, 0, 0.2, 0], "b.tip": [-0.5, 0, 0, 0, 0, 0]}},
 {"frequency_hz": 7, "shape": {"a": [0, 1, 0, 0, 0, 0], "b.tip": [0, 0.3, 0, 0, 0, 0]}},
 {"frequency_hz": 7, "shape": {"a": [0, 0, 1, 0, 0, 0], "b.tip": [0, 0, 0.3, 0, 0, 0]}},
 {"frequency_hz": 8, "shape": {"a": [1e-17, 2e-17, 0, 1, 0, 0], "b.tip": [0, -1e-17, 0, 1, 0, 0]}}]})";

class ShapesOfModes : public ::testing::Test {
protected:
    ShapesOfModes() { write_text(folder_ / "summary.json", kModes); }
    ModeMatch match(const std::vector<std::string>& names, const std::vector<Complex>& values, Complex rate) {
        std::vector<Column> channels;
        for (const std::string& name : names) channels.push_back({name, "m"});
        const Eigen::VectorXcd shape =
            Eigen::Map<const Eigen::VectorXcd>(values.data(), static_cast<Eigen::Index>(values.size()));
        return ShapeMatch(folder_.path(), channels).match(shape, rate);
    }
    const TemporaryFolder folder_;
};

// Oracle: by hand. Scale and phase do not matter; (1, -0.2) and (1, -0.5): 1.1^2/(1.25 * 1.04).
TEST_F(ShapesOfModes, TheMacIsTheSquareOfTheCosine) {
    const Complex rate(-0.1, 19), factor(3, -4);
    const ModeMatch same = match({"b.tip.position.x", "a.position.x"}, {-0.5 * factor, factor}, rate);
    EXPECT_EQ(same.mode, 1u);
    EXPECT_EQ(same.frequency, 3);
    EXPECT_NEAR(same.mac, 1, 1e-12);
    const ModeMatch other = match({"a.position.x", "b.tip.position.x"}, {factor, -0.2 * factor}, rate);
    EXPECT_NEAR(other.mac, 1.21 / (1.25 * 1.04), 1e-12);
}

// Oracle: v = s x, a = s^2 x.
TEST_F(ShapesOfModes, VelocitiesAndAccelerationsAreDerivatives) {
    const Complex rate(-0.4, 19);
    const ModeMatch found = match({"a.velocity.x", "b.tip.acceleration.x"}, {rate, -0.5 * rate * rate}, rate);
    EXPECT_EQ(found.mode, 1u);
    EXPECT_NEAR(found.mac, 1, 1e-12);
}

// Oracle: any mixture of the shapes of a double mode is one of its shapes, whirling ones too. The mode that moves no channel
// but by rounding is none of them.
TEST_F(ShapesOfModes, ADoubleModeHasEveryMixture) {
    const Complex i(0, 1);
    const ModeMatch found = match({"a.position.y", "a.position.z", "b.tip.position.y", "b.tip.position.z"},
                                  {0.6, 0.8 * i, 0.3 * 0.6, 0.3 * 0.8 * i}, {0, 50});
    EXPECT_EQ(found.mode, 2u);
    EXPECT_NEAR(found.mac, 1, 1e-12);
}

// Oracle: definitions. Rotations count where there is no displacement; a channel of no place is not compared.
TEST_F(ShapesOfModes, RotationsCountAlone) {
    const ModeMatch found =
        match({"a.rotation.x", "b.tip.angular_velocity.x", "s.force.x"}, {2, Complex(0, 100), 7}, {0, 50});
    EXPECT_EQ(found.mode, 4u);
    EXPECT_NEAR(found.mac, 1, 1e-12);
    EXPECT_THROW(ShapeMatch(folder_.path(), {{"s.force.x", "N"}}), Error);
    EXPECT_THROW(ShapeMatch(folder_ / "nowhere", {{"a.position.x", "m"}}), Error);
}

}  // namespace
}  // namespace dttmm::host
