// SPDX-License-Identifier: BSD-3-Clause
#include "identify/mains_hum.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "model/error.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

constexpr double kTwoPi = 2 * std::numbers::pi;

MeasuredSignal record(double step, size_t rows, double noise, const std::function<double(double)>& value,
                      unsigned seed = 11) {
    MeasuredSignal one;
    one.kind = MeasuredSignal::Kind::history;
    one.place = "blow.csv: column 2";
    std::mt19937_64 engine(seed);
    std::normal_distribution<double> normal(0, noise > 0 ? noise : 1);
    for (size_t i = 0; i < rows; ++i) {
        one.abscissa.push_back(step * static_cast<double>(i) - 0.3);
        one.values.push_back(value(one.abscissa.back()) + (noise > 0 ? normal(engine) : 0));
    }
    return one;
}

double find(const MeasuredSignal& one, double nominal = 50) { return find_mains_hum({&one}, nominal); }

std::string fault(const MeasuredSignal& one, double nominal = 50) {
    try {
        find(one, nominal);
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

// Oracle: the bound of Cramer and Rao for the frequency of a sine, 6 sigma^2/(pi^2 A^2 N T^2) in the square; Hann's window
// takes a half more. Beside a decaying vibration ten times as large, an offset, at an odd number of rows.
TEST(MainsHum, IsFoundBesideADecayingVibration) {
    const double step = 1.0 / 2048, noise = 0.3, amplitude = 0.2;
    const size_t rows = 20011;
    const MeasuredSignal one = record(step, rows, noise, [&](double t) {
        return 5 + amplitude * std::sin(kTwoPi * 50.953 * t + 1) +
               (t < 0 ? 0 : 2 * std::exp(-8 * t) * std::cos(kTwoPi * 46 * t));
    });
    const double T = step * static_cast<double>(rows);
    const double bound = noise / amplitude / T * std::sqrt(6 / static_cast<double>(rows)) / std::numbers::pi;
    EXPECT_NEAR(find(one), 50.953, 4 * 1.5 * bound);
}

// Without noise only the window's side lobes at the negative frequency disturb: by 1/(2 f T)^3 of a bin.
TEST(MainsHum, IsExactWithoutNoise) {
    const MeasuredSignal one = record(1e-3, 5000, 0, [](double t) { return std::cos(kTwoPi * 58.777 * t); });
    EXPECT_NEAR(find(one, 60), 58.777, 1e-4);
}

TEST(MainsHum, OfTheRecordWhereItStandsOut) {
    const MeasuredSignal noisy = record(1e-3, 8000, 1, [](double t) { return 0.01 * std::cos(kTwoPi * 49.5 * t); });
    const MeasuredSignal clear = record(1e-3, 8000, 0.01, [](double t) { return 0.1 * std::cos(kTwoPi * 49.5 * t); });
    EXPECT_NEAR(find_mains_hum({&noisy, &clear}, 50), 49.5, 1e-3);
}

TEST(MainsHum, OfTwoRecordersIsRefused) {
    std::vector<MeasuredSignal> both;
    for (const double line : {48.5, 51.5}) {
        both.push_back(record(1e-3, 4000, 0.1, [line](double t) { return std::cos(kTwoPi * line * t); }));
        both.back().place = line < 50 ? "a.csv" : "b.csv";
    }
    try {
        find_mains_hum({&both[0], &both[1]}, 50);
        FAIL();
    } catch (const Error& error) {
        EXPECT_THAT(error.what(), HasSubstr("two recorders"));
    }
}

// Noise alone passes about one time in ten thousand, where the record is shortest. A line outside the band is another one,
// also where the band ends on its flank.
TEST(MainsHum, IsNotSeenInNoise) {
    int seen = 0;
    for (unsigned seed = 1; seed <= 2000; ++seed)
        seen += fault(record(
                          5e-3, 210, 1, [](double) { return 0; }, seed))
                    .empty();
    EXPECT_LE(seen, 3);
    for (const auto& [line, rows] : {std::pair(55.0, 30000), {54.0, 1100}, {53.6, 1100}, {53.2, 2000}, {46.5, 1500}})
        EXPECT_THAT(fault(record(1e-3, static_cast<size_t>(rows), 0.1,
                                 [line = line](double t) { return 5 * std::cos(kTwoPi * line * t); })),
                    HasSubstr("no hum stands out"))
            << line;
}

// Records that cannot show it are passed over where others can.
TEST(MainsHum, UnfitRecordsArePassedOver) {
    const auto hum = [](double t) { return std::cos(kTwoPi * 50.3 * t); };
    const MeasuredSignal fit = record(1e-3, 4000, 0.1, hum), brief = record(1e-3, 400, 0.1, hum);
    MeasuredSignal broken = fit;
    broken.values[7] = std::nan("");
    EXPECT_NEAR(find_mains_hum({&brief, &broken, &fit}, 50), 50.3, 1e-3);
    EXPECT_THAT(fault(broken), HasSubstr("not all values are numbers"));
    const MeasuredSignal still = record(1e-3, 4000, 0, [](double) { return 2; });
    EXPECT_THAT(fault(still), HasSubstr("no hum stands out"));
}

TEST(MainsHum, AVibrationIsNoHum) {
    EXPECT_THAT(fault(record(1e-3, 6000, 0.01, [](double t) { return std::exp(-t) * std::cos(kTwoPi * 50.4 * t); })),
                HasSubstr("a vibration, or hum in a part"));
    // A damping ratio of 0.2 % over 100 and 400 periods
    for (const size_t rows : {2000u, 8000u})
        EXPECT_THAT(
            fault(record(1e-3, rows, 0.01,
                         [](double t) { return std::exp(-0.002 * kTwoPi * 48.5 * t) * std::cos(kTwoPi * 48.5 * t); })),
            HasSubstr("a vibration, or hum in a part"));
}

TEST(MainsHum, WantsARecordThatCanShowIt) {
    const auto hum = [](double t) { return std::cos(kTwoPi * 50 * t); };
    EXPECT_THAT(fault(record(1e-3, 980, 0.1, hum)), HasSubstr("49 periods of hum are too few"));
    EXPECT_THAT(fault(record(9e-3, 4000, 0.1, hum)), HasSubstr("not resolved"));
    MeasuredSignal uneven = record(1e-3, 4000, 0.1, hum);
    uneven.abscissa[2000] += 1e-4;
    EXPECT_THAT(fault(uneven), HasSubstr("equal intervals"));
    EXPECT_THROW(find_mains_hum({}, 50), Error);
}

// Oracle: what is left is orthogonal to both waves.
TEST(MainsHum, ASineIsFittedByLeastSquares) {
    std::vector<double> times;
    Eigen::VectorXd values(200);
    for (int i = 0; i < 200; ++i) {
        times.push_back(0.003 * i + 0.001 * std::sin(i));
        values(i) = 0.4 * std::cos(kTwoPi * 20 * times.back()) - 1.1 * std::sin(kTwoPi * 20 * times.back()) + i % 7;
    }
    const Eigen::VectorXd left = values - fit_sine(times, values, 20);
    double with_cosine = 0, with_sine = 0;
    for (int i = 0; i < 200; ++i) {
        with_cosine += left(i) * std::cos(kTwoPi * 20 * times[static_cast<size_t>(i)]);
        with_sine += left(i) * std::sin(kTwoPi * 20 * times[static_cast<size_t>(i)]);
    }
    EXPECT_NEAR(with_cosine, 0, 1e-11);
    EXPECT_NEAR(with_sine, 0, 1e-11);
}

}  // namespace
}  // namespace dttmm::host
