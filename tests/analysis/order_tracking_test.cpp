// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/order_tracking.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "model/error.h"

namespace dttmm::host {
namespace {

using Complex = std::complex<double>;
constexpr double kRevolution = 2 * std::numbers::pi;
constexpr double kInterval = 0.0011, kFirst = 60, kRate = 35;  // [s], [rad/s], [rad/s^2]

double angle_at(double t) { return kFirst * t + kRate * t * t / 2; }

/// Order 1 grows with the square of the speed, order 3.5 is constant; an offset.
std::vector<double> run_up(size_t rows) {
    std::vector<double> x;
    for (size_t n = 0; n < rows; ++n) {
        const double t = static_cast<double>(n) * kInterval, speed = kFirst + kRate * t;
        x.push_back(4 + 1e-4 * speed * speed * std::cos(angle_at(t) + 0.4) + 0.3 * std::cos(3.5 * angle_at(t) - 1.1));
    }
    return x;
}

std::vector<double> speeds(size_t rows) {
    std::vector<double> x;
    for (size_t n = 0; n < rows; ++n) x.push_back(kFirst + kRate * static_cast<double>(n) * kInterval);
    return x;
}

// Oracle: the orders that the series is made of. The amplitude of order 1 changes by g = 2e-4 kRate per radian, evenly. Of
// it leaks the derivative of the transform of the window, sinc(u)/(1 - u^2) at u = 2 per order of distance: g/3 into order
// 2, g/30 through the image at order -1 into itself, g/60 into order 3.5.
TEST(OrderTracking, ARunUpHasItsOrders) {
    constexpr size_t kRows = 6000;
    const std::vector<double> x = run_up(kRows);
    const ShaftAngle shaft = shaft_angle(speeds(kRows), "rotor", "rad/s", kInterval);
    EXPECT_NEAR(shaft.angle.back(), angle_at((kRows - 1) * kInterval), 1e-9 * shaft.angle.back());
    const auto rows = track_orders({&x}, shaft, {1, 2, 3.5}, kInterval);
    ASSERT_GT(rows.size(), 50u);
    constexpr double change = 2e-4 * kRate;
    for (const OrderRow& row : rows) {
        EXPECT_NEAR(row.speed, kFirst + kRate * row.time, 1e-9 * row.speed);
        const Complex first = std::polar(1e-4 * row.speed * row.speed, 0.4), third = std::polar(0.3, -1.1);
        EXPECT_LT(std::abs(row.amplitudes[0] - first), 1.5 * change / 30) << row.speed;
        EXPECT_NEAR(std::abs(row.amplitudes[1]), change / 3, 0.15 * change / 3) << "an order that is not there";
        EXPECT_LT(std::abs(row.amplitudes[2] - third), 1.5 * change / 60) << row.speed;
    }
}

// Oracle: an angle that jumps after half a turn, and a shaft that turns backwards, are the same shaft.
TEST(OrderTracking, AnAngleThatJumpsIsUnwound) {
    constexpr size_t kRows = 3000;
    const std::vector<double> x = run_up(kRows);
    std::vector<double> wrapped;
    for (size_t n = 0; n < kRows; ++n)
        wrapped.push_back(-std::remainder(angle_at(static_cast<double>(n) * kInterval), kRevolution));
    const auto by_angle = track_orders({&x}, shaft_angle(wrapped, "hinge", "rad", kInterval), {1, 3.5}, kInterval);
    const auto by_speed = track_orders({&x}, shaft_angle(speeds(kRows), "rotor", "rad/s", kInterval), {1, 3.5}, kInterval);
    ASSERT_EQ(by_angle.size(), by_speed.size());
    for (size_t r = 0; r < by_angle.size(); ++r)
        for (size_t o = 0; o < 2; ++o)
            EXPECT_LT(std::abs(by_angle[r].amplitudes[o] - by_speed[r].amplitudes[o]), 1e-8) << r << " " << o;
}

// Oracle: definitions. Orders beyond the band are not there, but the others of the block are.
TEST(OrderTracking, WhatRowsDoNotResolveIsNotANumber) {
    constexpr size_t kRows = 6000;
    const std::vector<double> x = run_up(kRows);
    const ShaftAngle shaft = shaft_angle(speeds(kRows), "rotor", "rad/s", kInterval);
    const auto rows = track_orders({&x}, shaft, {1, 16}, kInterval);  // 0.45/kInterval/16 = 25.6 Hz
    EXPECT_FALSE(std::isnan(rows.front().amplitudes[1].real()));
    EXPECT_TRUE(std::isnan(rows.back().amplitudes[1].real()));
    EXPECT_NEAR(std::abs(rows.back().amplitudes[0]), 1e-4 * rows.back().speed * rows.back().speed, 1e-2 * 9);
}

TEST(OrderTracking, AShaftThatDoesNotTurnIsRefused) {
    EXPECT_EQ(revolutions_per_block({3.5, 1, 2}), 2);
    EXPECT_EQ(revolutions_per_block({0.5, 2}), 4);
    const std::vector<double> x = run_up(40);  // half a turn
    EXPECT_THROW(track_orders({&x}, shaft_angle(speeds(40), "rotor", "rad/s", kInterval), {1}, kInterval), Error);
    EXPECT_THROW(shaft_angle({3, 2, 1, 0, -1, -2}, "rotor", "rad/s", kInterval), Error);
    EXPECT_THROW(shaft_angle({0, 0, 0}, "rotor", "rad/s", kInterval), Error);
    EXPECT_THROW(shaft_angle({1, 2, 3}, "rotor", "m/s", kInterval), Error);
}

}  // namespace
}  // namespace dttmm::host
