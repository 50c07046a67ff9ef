// SPDX-License-Identifier: BSD-3-Clause
#include "identify/mode_pairs.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace dttmm::host {
namespace {

ObservedMode measured_mode(double frequency, int number, const Eigen::VectorXd& shape) {
    ObservedMode mode;
    mode.frequency = frequency;
    mode.number = number;
    mode.shape = shape;
    return mode;
}

// Measured modes whose frequencies are in another order than the model's: shapes decide.
TEST(ModePairs, ShapesDecideBeforeFrequencies) {
    Eigen::MatrixXd shapes(3, 4);
    shapes << 1, 1, 0.2, 0.5, 0.6, -0.4, 1, -1, 0.3, 0.2, -0.7, 0.9;
    const std::vector<double> frequencies = {10, 20, 31, 44};
    const auto pairs =
        pair_modes({measured_mode(19, 1, -2 * shapes.col(2)), measured_mode(33, 2, shapes.col(1))}, frequencies, shapes);
    EXPECT_EQ(pairs[0].mode, 3);
    EXPECT_EQ(pairs[0].frequency, 31);
    EXPECT_NEAR(pairs[0].mac, 1, 1e-14);
    EXPECT_EQ(pairs[1].mode, 2);
}

// No mode of the model twice, and a mode without a shape has its number.
TEST(ModePairs, NoModeTwiceAndNumbersWithoutShapes) {
    Eigen::MatrixXd shapes(2, 3);
    shapes << 1, 0.9, 0.1, 0.1, 0.3, 1;
    const std::vector<double> frequencies = {10, 20, 30};
    const Eigen::VectorXd first = shapes.col(0);
    const auto pairs = pair_modes({measured_mode(10, 1, first), measured_mode(21, 2, first), measured_mode(30, 3, {})},
                                  frequencies, shapes);
    EXPECT_EQ(pairs[0].mode, 1);
    EXPECT_EQ(pairs[1].mode, 2) << "the likest that is left";
    EXPECT_EQ(pairs[2].mode, 3);
    EXPECT_TRUE(std::isnan(pairs[2].mac));
    EXPECT_EQ(pair_modes({measured_mode(10, 4, {})}, frequencies, shapes)[0].mode, 0) << "the model has no fourth";
}

// Of a double mode the measured shape is any mixture; a place that was not measured does not count.
TEST(ModePairs, ADoubleModeMixes) {
    Eigen::MatrixXd shapes(3, 3);
    shapes << 1, 0, 0.5, 0, 1, 0.5, 0.3, 0.3, -1;
    Eigen::VectorXd mixture = 0.6 * shapes.col(0) - 0.8 * shapes.col(1);
    mixture(2) = std::numeric_limits<double>::quiet_NaN();
    const auto pairs = pair_modes({measured_mode(50, 1, mixture)}, {50, 50, 80}, shapes);
    EXPECT_NEAR(pairs[0].mac, 1, 1e-14);
    EXPECT_NEAR(pairs[0].shape(2), 0.6 * 0.3 - 0.8 * 0.3, 1e-14);
}

// Oracle: by hand. Mode 2 moves across the measured direction; its components are round-off and happen to have the measured
// form. Mode 1 has the MAC (1 - 0.6)²/(2 · 1.36).
TEST(ModePairs, RoundOffOfAModeThatDoesNotMoveTheSensorsIsNoShape) {
    Eigen::MatrixXd shapes(2, 2);
    shapes << 1, 6e-44, 0.6, -6e-44;
    const auto pairs = pair_modes({measured_mode(20, 1, Eigen::Vector2d(1, -1))}, {11, 20}, shapes);
    EXPECT_EQ(pairs[0].mode, 1);
    EXPECT_NEAR(pairs[0].mac, 0.16 / 2.72, 1e-14);
    const auto second =
        pair_modes({measured_mode(11, 1, shapes.col(0)), measured_mode(20, 2, Eigen::Vector2d(1, -1))}, {11, 20}, shapes)[1];
    EXPECT_EQ(second.mode, 2) << "no other is left";
    EXPECT_EQ(second.mac, 0);
    EXPECT_EQ(second.shape.norm(), 0) << "it predicts no motion of the sensors";
}

// Nothing vibrates at 0 Hz: rigid-body modes are no candidates, by shape or by number.
TEST(ModePairs, AModeAt0HzIsNotMeasured) {
    Eigen::MatrixXd shapes(3, 4);
    shapes << 1, 1, 1, 1, 1, 0, -0.7, 0.1, 1, -1, 1, -1;
    const std::vector<double> frequencies = {0, 0, 60, 170};
    const auto pairs =
        pair_modes({measured_mode(55, 1, shapes.col(2)), measured_mode(160, 2, shapes.col(3))}, frequencies, shapes);
    EXPECT_EQ(pairs[0].mode, 3);
    EXPECT_EQ(pairs[1].mode, 4);
    const auto by_number = pair_modes({measured_mode(55, 1, {}), measured_mode(160, 4, {})}, frequencies, shapes);
    EXPECT_EQ(by_number[0].mode, 0);
    EXPECT_EQ(by_number[1].mode, 4);
}

}  // namespace
}  // namespace dttmm::host
