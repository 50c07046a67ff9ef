// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/spectra.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

#include "model/error.h"

namespace dttmm::host {
namespace {

constexpr double kTurn = 2 * std::numbers::pi;

std::vector<double> noise(size_t size, double deviation, unsigned seed = 7) {
    std::mt19937 random(seed);
    std::normal_distribution<> normal(0, deviation);
    std::vector<double> x(size);
    for (double& value : x) value = normal(random);
    return x;
}

// Oracle: Parseval's identity. One-sided density times resolution adds up to the mean square about the mean, odd and even.
TEST(Spectra, DensityAddsUpToTheMeanSquare) {
    for (const size_t size : {512u, 701u, 1500u}) {
        std::vector<double> x = noise(size, 3.7);
        for (double& value : x) value += 11;
        const double interval = 0.0013;
        const Spectrum spectrum = spectrum_of(x, interval, 0, Taper::rectangular, size);
        const double sum = std::accumulate(spectrum.density.begin(), spectrum.density.end(), 0.0);
        const double expected = std::pow(levels_of(x).deviation, 2);
        EXPECT_NEAR(sum / (static_cast<double>(size) * interval), expected, 1e-12 * expected) << size;
    }
}

// Oracle: white noise of variance v has the one-sided density 2 v dt. Averages of n independent segments scatter by
// 1/sqrt(n); over all bins by far less: 400 segments of 128 bins, overlap, within 1 %.
TEST(Spectra, WhiteNoiseHasItsLevelUnderEveryTaper) {
    constexpr double kInterval = 0.002, kDeviation = 1.7;
    const std::vector<double> x = noise(512'000, kDeviation);
    for (const Taper taper : {Taper::hann, Taper::rectangular, Taper::flattop}) {
        const Spectrum spectrum = spectrum_of(x, kInterval, 0, taper, 256);
        EXPECT_TRUE(spectrum.phase.empty());
        ASSERT_EQ(spectrum.density.size(), 129u);
        const double mean = std::accumulate(spectrum.density.begin() + 3, spectrum.density.end() - 3, 0.0) / 123;
        EXPECT_NEAR(mean, 2 * kDeviation * kDeviation * kInterval, 0.01 * mean) << taper_name(taper);
    }
}

// Oracle: amplitude and phase of a sine at a bin, of cos(2 pi f t + phase) with t of the run, not of the window.
TEST(Spectra, ASineAtABinHasItsAmplitudeAndPhase) {
    constexpr size_t kSize = 900;
    constexpr double kInterval = 0.0017, kStart = 0.731, kAmplitude = 2.3, kPhase = 0.7;
    const double frequency = 37 / (kSize * kInterval);
    std::vector<double> x(kSize);
    for (size_t n = 0; n < kSize; ++n)
        x[n] = 5 + kAmplitude * std::cos(kTurn * frequency * (kStart + static_cast<double>(n) * kInterval) + kPhase);
    for (const Taper taper : {Taper::hann, Taper::rectangular, Taper::flattop}) {
        const Spectrum spectrum = spectrum_of(x, kInterval, kStart, taper, kSize);
        EXPECT_NEAR(spectrum.amplitude[37], kAmplitude, 1e-8) << taper_name(taper);
        EXPECT_NEAR(spectrum.phase[37], kPhase * 360 / kTurn, 1e-9);
        EXPECT_LT(spectrum.amplitude[0], 1e-12) << "the mean is taken off";
        EXPECT_LT(spectrum.amplitude[60], 1e-8);
    }
}

// Oracle: a sine between bins. The flat top shows it within 0.01 dB, 1.2e-3, at the bin; the others find place and
// height from two bins. What is left is the image at the negative frequency, about 1/(pi (2 bin)^3) for Hann.
TEST(Spectra, ASineBetweenBinsIsFound) {
    constexpr size_t kSize = 1100;
    constexpr double kInterval = 0.001, kAmplitude = 0.37;
    const double resolution = 1 / (kSize * kInterval);
    for (const double bin : {71.13, 71.5, 71.83, 72.0}) {
        std::vector<double> x(kSize);
        for (size_t n = 0; n < kSize; ++n)
            x[n] = kAmplitude * std::sin(kTurn * bin * resolution * static_cast<double>(n) * kInterval + 0.4);
        for (const auto& [taper, height, place] :
             {std::tuple(Taper::hann, 1e-5, 1e-5), {Taper::rectangular, 1e-2, 1e-2}, {Taper::flattop, 1.2e-3, 0.51}}) {
            const Spectrum spectrum = spectrum_of(x, kInterval, 0, taper, kSize);
            const std::vector<Peak> peaks = peaks_of(spectrum.amplitude, resolution, taper, 4, 0.4);
            ASSERT_EQ(peaks.size(), 1u) << taper_name(taper) << " " << bin;
            EXPECT_NEAR(peaks[0].amplitude, kAmplitude, height * kAmplitude) << taper_name(taper) << " " << bin;
            EXPECT_NEAR(peaks[0].frequency / resolution, bin, place) << taper_name(taper) << " " << bin;
        }
    }
}

// Oracle: definitions, by hand.
TEST(Spectra, LevelsAreThoseOfTheRows) {
    const Levels levels = levels_of({1, -5, 3, 2, 4});
    EXPECT_DOUBLE_EQ(levels.mean, 1);
    EXPECT_DOUBLE_EQ(levels.rms, std::sqrt(11.0));
    EXPECT_DOUBLE_EQ(levels.deviation, std::sqrt(10.0));
    EXPECT_EQ(levels.peak, 5);
    EXPECT_EQ(levels.peak_at, 1u);
    EXPECT_FALSE(levels.is_constant);
    EXPECT_TRUE(levels_of({0.1, 0.1, 0.1}).is_constant);
    EXPECT_EQ(levels_of({0.1, 0.1, 0.1}).deviation, 0);
}

// Oracle: counting. So many segments as were asked for fit, each half over its neighbour.
TEST(Spectra, SegmentsAreAsManyAsAskedFor) {
    for (const size_t samples : {1000u, 1001u, 2003u})
        for (const size_t segments : {1u, 2u, 3u, 7u, 20u}) {
            const size_t size = segment_size(samples, segments);
            EXPECT_EQ(segment_count(samples, size), segments) << samples << " " << segments << " " << size;
        }
    EXPECT_EQ(segment_count(5, 6), 0u);
    EXPECT_THROW(parse_taper("hamm"), Error);
}

}  // namespace
}  // namespace dttmm::host
