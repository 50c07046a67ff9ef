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

MeasuredSignal record(double step, size_t rows, double noise, const std::function<double(double)>& value) {
    MeasuredSignal one;
    one.kind = MeasuredSignal::Kind::history;
    one.place = "blow.csv: column 2";
    std::mt19937_64 engine(11);
    std::normal_distribution<double> normal(0, noise);
    for (size_t i = 0; i < rows; ++i) {
        one.abscissa.push_back(step * static_cast<double>(i) - 0.3);
        one.values.push_back(value(one.abscissa.back()) + normal(engine));
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

// Without noise nothing but the shape of the window is in the way.
TEST(MainsHum, IsExactWithoutNoise) {
    const MeasuredSignal one = record(1e-3, 5000, 0, [](double t) { return std::cos(kTwoPi * 58.777 * t); });
    EXPECT_NEAR(find(one, 60), 58.777, 1e-4);
}

TEST(MainsHum, OfTheRecordWhereItStandsOut) {
    const MeasuredSignal noisy = record(1e-3, 8000, 1, [](double t) { return 0.01 * std::cos(kTwoPi * 49.5 * t); });
    const MeasuredSignal clear = record(1e-3, 8000, 0.01, [](double t) { return 0.1 * std::cos(kTwoPi * 49.5 * t); });
    EXPECT_NEAR(find_mains_hum({&noisy, &clear}, 50), 49.5, 1e-3);
}

// Noise alone passes one time in a million.
TEST(MainsHum, IsNotSeenInNoise) {
    EXPECT_THAT(fault(record(1e-3, 30000, 1, [](double) { return 0; })), HasSubstr("no hum stands out"));
    EXPECT_THAT(fault(record(1e-3, 30000, 1, [](double t) { return 0.5 * std::cos(kTwoPi * 55 * t); })),
                HasSubstr("no hum stands out"))
        << "ten percent off: another line";
}

TEST(MainsHum, AVibrationIsNoHum) {
    EXPECT_THAT(fault(record(1e-3, 6000, 0.01, [](double t) { return std::exp(-t) * std::cos(kTwoPi * 50.4 * t); })),
                HasSubstr("a vibration, or hum in a part"));
}

TEST(MainsHum, WantsARecordThatCanShowIt) {
    const auto hum = [](double t) { return std::cos(kTwoPi * 50 * t); };
    EXPECT_THAT(fault(record(1e-3, 480, 0.1, hum)), HasSubstr("24 periods of hum are too few"));
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
