// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/realisation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "model/error.h"

namespace dttmm::host {
namespace {

using Complex = std::complex<double>;

struct Vibration {
    double frequency, damping;  ///< [Hz], undamped; ratio
    std::vector<Complex> shape;

    Complex rate() const { return 2 * std::numbers::pi * frequency * Complex(-damping, std::sqrt(1 - damping * damping)); }
};

/// Two near each other, a weak one; two channels of different units and offsets.
const std::vector<Vibration> kVibrations = {{7.3, 0.01, {Complex(1, 0.2), Complex(-40, 3)}},
                                            {7.9, 0.013, {Complex(0.5, 0), Complex(70, -8)}},
                                            {31.7, 0.002, {Complex(1e-3, 2e-3), Complex(0.4, 0.9)}}};

std::vector<std::vector<double>> decay(const std::vector<Vibration>& vibrations, size_t rows, double interval,
                                       double noise = 0) {
    std::mt19937 random(3);
    std::normal_distribution<> normal;
    std::vector<std::vector<double>> out(2, std::vector<double>(rows));
    for (size_t c = 0; c < 2; ++c)
        for (size_t n = 0; n < rows; ++n) {
            out[c][n] = c == 0 ? 12 : -3e3;
            for (const Vibration& one : vibrations)
                out[c][n] += (one.shape[c] * std::exp(one.rate() * (static_cast<double>(n) * interval))).real();
            out[c][n] += noise * (c == 0 ? 1 : 80) * normal(random);
        }
    return out;
}

// Oracle: the vibrations that the series is made of. Rounding of the offset and noise of 1e-11 look like more of them, and
// some are confirmed by all orders. A true one a thousand times above the noise stays.
TEST(Realisation, VibrationsBelowWhatIsLeftOutAreDropped) {
    constexpr double kInterval = 0.0017;
    std::vector<Vibration> vibrations = {kVibrations[0], {19.3, 0.01, {Complex(1e-8, 0), Complex(0, 1e-6)}}};
    size_t dropped = 0;
    for (size_t rows = 1300; rows < 1700; rows += 50) {
        const Identification found = identify_modes(decay(vibrations, rows, kInterval, 1e-11), kInterval, 12);
        EXPECT_EQ(found.modes.size(), 2u) << rows;
        dropped += found.faint;
    }
    EXPECT_GT(dropped, 0u);
}

// Oracle: the vibrations that the series is made of. Offsets stand far above them: rounding of 3e3 is 5e-13 of the
// vibration.
TEST(Realisation, ACleanDecayGivesItsModes) {
    constexpr double kInterval = 0.0017;
    const Identification found = identify_modes(decay(kVibrations, 1700, kInterval), kInterval, 3);
    ASSERT_EQ(found.modes.size(), 3u);
    EXPECT_EQ(found.weaker, 0u);
    for (size_t m = 0; m < 3; ++m) {
        const Complex rate = kVibrations[m].rate();
        EXPECT_LT(std::abs(found.modes[m].rate - rate), 1e-8 * std::abs(rate)) << m;
        for (size_t c = 0; c < 2; ++c) {
            const Complex shape = found.modes[m].shape(static_cast<Eigen::Index>(c));
            EXPECT_LT(std::abs(shape - kVibrations[m].shape[c]), 1e-6 * std::abs(kVibrations[m].shape[c])) << m << " " << c;
        }
    }
    EXPECT_LT(found.unexplained, 1e-11);
}

// Oracle: the same with noise of a thousandth: two modes a quarter of a bin over the resolution apart stay told apart, and
// no mode of the noise is taken for one of the machine.
TEST(Realisation, NoiseIsNotTakenForModes) {
    constexpr double kInterval = 0.0017;
    const Identification found = identify_modes(decay(kVibrations, 1700, kInterval, 1e-3), kInterval, 5);
    ASSERT_GE(found.modes.size(), 2u);
    EXPECT_NEAR(found.modes[0].rate.imag() / (2 * std::numbers::pi), 7.3, 0.03);
    EXPECT_NEAR(found.modes[1].rate.imag() / (2 * std::numbers::pi), 7.9, 0.03);
    EXPECT_LE(found.modes.size(), 3u);
    EXPECT_GT(found.spurious, 0u);
}

// Oracle: the strongest is that with the largest sum of squares; the others are counted.
TEST(Realisation, FewerThanThereAreAreTheStrongest) {
    constexpr double kInterval = 0.0023;
    const Identification found = identify_modes(decay(kVibrations, 900, kInterval), kInterval, 1);
    ASSERT_EQ(found.modes.size(), 1u);
    EXPECT_EQ(found.weaker, 2u);
    EXPECT_LT(found.modes[0].rate.imag() / (2 * std::numbers::pi), 8);
}

// Oracle: the number of unknowns. Seven poles of two channels need a 10 x 10 matrix with the neighbours that confirm them.
TEST(Realisation, FewRowsAreEnoughOrAreRefused) {
    constexpr double kInterval = 0.0117;
    size_t rows = 4;
    while (most_modes(2, rows) < 4) ++rows;
    EXPECT_LT(rows, 30u);
    const Identification found = identify_modes(decay(kVibrations, rows, kInterval), kInterval, 3);
    ASSERT_EQ(found.modes.size(), 3u);
    for (size_t m = 0; m < 3; ++m)
        EXPECT_LT(std::abs(found.modes[m].rate - kVibrations[m].rate()), 1e-4 * std::abs(kVibrations[m].rate()));
    EXPECT_THROW(identify_modes(decay(kVibrations, rows, kInterval), kInterval, most_modes(2, rows) + 1), Error);
    EXPECT_EQ(most_modes(2, 2), 0u);
    EXPECT_EQ(most_modes(2, 5), 0u);
    for (size_t many = 2; many < 400; ++many) EXPECT_LE(2 * most_modes(3, many), 3 * many);
}

// Oracle: an undamped and a growing vibration are what they are.
TEST(Realisation, UndampedAndGrowingVibrationsHaveTheirSigns) {
    constexpr double kInterval = 0.004;
    const std::vector<Vibration> two = {{9.1, -0.003, {1, 20}}, {23.7, 0, {0.7, -90}}};
    const Identification found = identify_modes(decay(two, 800, kInterval), kInterval, 2);
    ASSERT_EQ(found.modes.size(), 2u);
    EXPECT_NEAR(-found.modes[0].rate.real() / std::abs(found.modes[0].rate), -0.003, 1e-9);
    EXPECT_NEAR(found.modes[1].rate.real() / std::abs(found.modes[1].rate), 0, 1e-9);
}

}  // namespace
}  // namespace dttmm::host
