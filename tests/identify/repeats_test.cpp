// SPDX-License-Identifier: BSD-3-Clause
#include "identify/repeats.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "model/error.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

class Repeats : public testing::Test {
protected:
    std::string fault(Observations observations) {
        try {
            join_repeats(observations, warnings_);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }

    ObservedHistory history(int repeat, size_t rows, double noise, double size = 1) {
        ObservedHistory one{"plate.position.z", "m", {}, {}};
        one.place = "blow" + std::to_string(repeat);
        for (size_t i = 0; i < rows; ++i) {
            const double t = 1e-3 * static_cast<double>(i);
            one.times.push_back(t);
            one.values.push_back(size * truth(t) + noise * normal_(engine_));
        }
        return one;
    }
    static double truth(double t) { return 3 * std::exp(-2 * t) * std::cos(70 * t); }

    std::mt19937_64 engine_{5};
    std::normal_distribution<double> normal_;
    Warnings warnings_{Warnings::Silent::yes};
};

// Oracle: noise that was drawn. The deviation of the mean of 5 is sigma/sqrt(5), known to 1/sqrt(2 * 4 * 1000) = 1.1 %.
TEST_F(Repeats, OfAHistoryGiveTheNoiseOfTheirMean) {
    Observations all;
    for (int r = 0; r < 5; ++r) all.histories.push_back(history(r, 1000, 0.2));
    ObservedHistory other = history(9, 30, 0.1);
    other.channel = "plate.position.x";
    all.histories.insert(all.histories.begin() + 2, other);
    join_repeats(all, warnings_);
    ASSERT_EQ(all.histories.size(), 2u);
    const ObservedHistory& mean = all.histories[0];
    EXPECT_EQ(all.histories[1].values, other.values) << "one alone stays as it is";
    EXPECT_EQ(all.histories[1].noise, 0);
    EXPECT_NEAR(mean.noise, 0.2 / std::sqrt(5), 0.03 * 0.2 / std::sqrt(5));
    EXPECT_EQ(mean.noise_samples, 4000u);
    double squares = 0;
    for (size_t i = 0; i < 1000; ++i) squares += std::pow((mean.values[i] - truth(mean.times[i])) / mean.noise, 2);
    EXPECT_NEAR(squares / 1000, 1, 4 * std::sqrt(2.0 / 1000));
    EXPECT_FALSE(warnings_.has("unequal-repeats"));
    EXPECT_FALSE(warnings_.has("unlike-repeats"));
}

// A trigger that comes half a sample late, or a sign, is no noise.
TEST_F(Repeats, OfAnotherTriggerOrSignAreTold) {
    for (const bool is_reversed : {false, true}) {
        Observations all;
        Warnings own{Warnings::Silent::yes};
        for (int r = 0; r < 2; ++r) all.histories.push_back(history(r, 1000, 0.02));
        for (size_t i = 0; i < 1000; ++i) {
            const double t = all.histories[1].times[i];
            if (is_reversed)
                all.histories[1].values[i] *= -1;
            else
                all.histories[1].values[i] += truth(t + 5e-4) - truth(t);
        }
        join_repeats(all, own);
        EXPECT_TRUE(own.has("unlike-repeats")) << is_reversed;
    }
}

// What a user says is the noise of one; the mean has less.
TEST_F(Repeats, KeepTheNoiseThatAUserGives) {
    Observations all;
    for (int r = 0; r < 4; ++r) {
        all.histories.push_back(history(r, 50, 0.2));
        all.histories.back().noise = 0.3;
        all.histories.back().is_noise_of_user = true;
    }
    join_repeats(all, warnings_);
    EXPECT_NEAR(all.histories[0].noise, 0.15, 1e-15);
    EXPECT_EQ(all.histories[0].noise_samples, 0u);
}

// Oracle: noise that grows eightfold along the lines, as a driver's does: squares over the squared deviation are 1 in the
// mean, at both ends of the band, for any number of repeats. Real parts alone have half the differences.
TEST_F(Repeats, OfResponsesGiveTheNoiseOfEveryLine) {
    for (const int repeats : {2, 3, 8})
        for (const bool is_real : {false, true}) {
            constexpr size_t kLines = 4000;
            const auto noise = [](size_t i) { return 0.01 * std::pow(8, static_cast<double>(i) / kLines); };
            const auto exact = [&](size_t i) {
                const double f = 1e-3 * static_cast<double>(i + 1);
                const std::complex<double> H = 1.0 / std::complex<double>(1 - f * f, 0.02 * f);
                return is_real ? std::complex<double>(H.real()) : H;
            };
            Observations all;
            for (int r = 0; r < repeats; ++r) {
                ObservedResponse one{"plate.position.z", "plate.z", "m/N", {}, {}, {}};
                one.place = "blow" + std::to_string(r);
                one.is_real = is_real;
                for (size_t i = 0; i < kLines; ++i) {
                    one.frequencies.push_back(1e-3 * static_cast<double>(i + 1));
                    const double re = normal_(engine_), im = is_real ? 0 : normal_(engine_);
                    one.values.push_back(exact(i) + noise(i) * std::complex<double>(re, im));
                }
                all.responses.push_back(one);
            }
            join_repeats(all, warnings_);
            ASSERT_EQ(all.responses.size(), 1u);
            const ObservedResponse& mean = all.responses[0];
            EXPECT_EQ(mean.noise_samples, kLines * static_cast<size_t>(repeats - 1) * (is_real ? 1 : 2));
            for (const size_t first : {size_t{0}, kLines / 2}) {
                double squares = 0;
                for (size_t i = first; i < first + kLines / 2; ++i)
                    squares += std::norm((mean.values[i] - exact(i)) / mean.deviations[i]);
                const double parts = kLines / 2.0 * (is_real ? 1 : 2);
                // The variances of the mean and of its estimate add up
                EXPECT_NEAR(squares / parts, 1, 4 * std::sqrt(2 / parts * (1 + 1.0 / (repeats - 1))))
                    << repeats << " from " << first;
            }
        }
}

// Oracle: mean and scatter by hand.
TEST_F(Repeats, OfModesGiveTheNoiseOfFrequencies) {
    Observations all;
    all.freedoms = {{"floor1", 0}, {"floor2", 0}};
    const auto add = [&](int number, double frequency, double second, double deviation) {
        ObservedMode mode;
        mode.number = number;
        mode.frequency = frequency;
        mode.place = "modes";
        mode.deviation = deviation;
        mode.shape = Eigen::Vector2d(0.3, second);
        if (second < -2) mode.shape *= -1;
        all.modes.push_back(mode);
    };
    for (const double deviation : {0.0, 0.004}) {
        all.modes.clear();
        all.frequency_samples = 0;
        add(1, 10, 0.5, deviation);
        add(2, 30, -3, deviation);
        add(1, 10 * std::exp(0.01), 0.7, 2 * deviation);
        add(2, 30 * std::exp(-0.03), -2, 2 * deviation);
        join_repeats(all, warnings_);
        ASSERT_EQ(all.modes.size(), 2u);
        EXPECT_NEAR(all.modes[0].frequency, 10 * std::exp(0.005), 1e-12);
        EXPECT_NEAR(all.modes[1].frequency, 30 * std::exp(-0.015), 1e-12);
        EXPECT_NEAR(all.modes[0].shape(0), 0.5, 1e-15) << "largest 1";
        EXPECT_NEAR(all.modes[1].shape(0) / all.modes[1].shape(1), -0.12, 1e-15) << "signs of a shape are arbitrary";
        const double scatter = std::sqrt((2 * 0.005 * 0.005 + 2 * 0.015 * 0.015) / 2);
        EXPECT_NEAR(all.modes[1].deviation, deviation > 0 ? 0.002 * std::sqrt(5) : scatter / std::sqrt(2), 1e-12);
        EXPECT_EQ(all.frequency_samples, deviation > 0 ? 0u : 2u);
    }
}

// Hum has another phase in every blow, and is taken off in the fit: it is no noise. Oracle: the noise that was drawn.
TEST_F(Repeats, HumIsNoNoise) {
    Observations all;
    for (int r = 0; r < 3; ++r) {
        all.histories.push_back(history(r, 1000, 0.1));
        ObservedHistory& one = all.histories.back();
        one.hum = 50;
        for (size_t i = 0; i < 1000; ++i) one.values[i] += 0.8 * std::sin(2 * M_PI * 50 * one.times[i] + 2.1 * r);
    }
    join_repeats(all, warnings_);
    EXPECT_NEAR(all.histories[0].noise, 0.1 / std::sqrt(3), 0.07 * 0.1 / std::sqrt(3));
    EXPECT_EQ(all.histories[0].noise_samples, 998u * 2);
}

// One set in 16 000 has a repeat beyond four standard deviations by chance; a deviation taken too small would warn in many.
TEST_F(Repeats, OfOneSizeAreNotWarnedOf) {
    size_t warned = 0;
    for (int set = 0; set < 1500; ++set) {
        Observations all;
        Warnings own{Warnings::Silent::yes};
        for (int r = 0; r < 2; ++r) all.histories.push_back(history(r, 60, 0.2));
        join_repeats(all, own);
        warned += own.has("unequal-repeats");
    }
    EXPECT_LE(warned, 1u);
}

// Lines that rounding made equal in all files have no deviation of 0.
TEST_F(Repeats, OfRoundedResponsesKeepADeviation) {
    Observations all;
    for (const double last : {5.0, 5.1}) {
        ObservedResponse one{"plate.position.z", "plate.z", "m/N", {}, {}, {}};
        for (int i = 1; i <= 60; ++i) {
            one.frequencies.push_back(i);
            one.values.emplace_back(i < 60 ? 1 : last, 0.5);
        }
        all.responses.push_back(one);
    }
    join_repeats(all, warnings_);
    EXPECT_NEAR(all.responses[0].deviations[10], 0.1 / std::sqrt(24), 1e-9) << "by the last digit";
    EXPECT_GT(all.responses[0].deviations[59], 0.01);
}

TEST_F(Repeats, OfAnotherSizeAreTold) {
    Observations all;
    for (int r = 0; r < 3; ++r) all.histories.push_back(history(r, 1000, 0.05, r == 1 ? 1.08 : 1));
    join_repeats(all, warnings_);
    ASSERT_TRUE(warnings_.has("unequal-repeats"));
    EXPECT_THAT(warnings_.all()[0].text, HasSubstr("blow0: 2.")) << "smaller than the mean";
    EXPECT_THAT(warnings_.all()[1].text, HasSubstr("blow1: 5."));
}

TEST_F(Repeats, ThatCannotBeAreRefused) {
    Observations copied;
    copied.histories = {history(0, 100, 0.1)};
    copied.histories.push_back(copied.histories[0]);
    EXPECT_THAT(fault(copied), HasSubstr("a copy is no repeat"));
    for (double& value : copied.histories[1].values) value = std::round(1e5 * value) / 1e5;
    EXPECT_THAT(fault(copied), HasSubstr("a copy is no repeat")) << "rounded";
    Observations shorter;
    shorter.histories = {history(0, 100, 0.1), history(1, 99, 0.1)};
    EXPECT_THAT(fault(shorter), HasSubstr("blow0, blow1: repeats of one channel must have the same times"));
    Observations shifted;
    shifted.histories = {history(0, 100, 0.1), history(1, 100, 0.1)};
    for (double& t : shifted.histories[1].times) t += 2e-6;
    EXPECT_THAT(fault(shifted), HasSubstr("the same times"));
    for (double& t : shifted.histories[1].times) t -= 1.5e-6;
    EXPECT_EQ(fault(shifted), "");
    Observations parts;
    for (const double missing : {1.0, 2.0}) {
        ObservedMode mode;
        mode.number = 1;
        mode.shape = Eigen::Vector2d(1, 1);
        mode.shape(missing > 1) = std::nan("");
        mode.frequency = 10 + 0.1 * missing;
        parts.modes.push_back(mode);
    }
    EXPECT_THAT(fault(parts), HasSubstr("belongs into one file"));
    Observations others;
    for (const double frequency : {4.0, 9.8}) {
        ObservedMode mode;
        mode.frequency = frequency;
        mode.number = 1;
        others.modes.push_back(mode);
    }
    EXPECT_THAT(fault(others), HasSubstr("4 Hz in one file and 9.8 Hz in another"));
    for (const double second : {0.5, -0.9}) {
        others.modes[second < 0].frequency = 10 + 0.1 * second;
        others.modes[second < 0].shape = Eigen::Vector2d(1, second);
    }
    EXPECT_THAT(fault(others), HasSubstr("MAC"));
    others.modes[1].frequency = others.modes[0].frequency;
    others.modes[1].shape = others.modes[0].shape;
    EXPECT_THAT(fault(others), HasSubstr("do not differ"));
    others.modes[0].deviation = others.modes[1].deviation = 0.01;
    EXPECT_EQ(fault(others), "") << "the noise is known";
}

}  // namespace
}  // namespace dttmm::host
