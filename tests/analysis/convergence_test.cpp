// SPDX-License-Identifier: BSD-3-Clause
//
// Extrapolation and estimates on histories made by hand, y_k = exact + a known error.
#include "analysis/convergence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <utility>

namespace dttmm::host {
namespace {

constexpr int kRows = 7;

double exact(int row) { return 3 + std::sin(0.9 * row); }

/// What is left after histories k = 0, 1, … of one channel whose errors are given, beside a channel without error.
struct Left {
    double error = 0, estimate = 0, newest_error = 0;
};

using ErrorOf = std::function<double(int k, int row)>;

Convergence convergence_of(const ErrorOf& error, int histories) {
    Convergence convergence(2);
    for (int k = 0; k < histories; ++k) {
        std::vector<double> history;
        for (int row = 0; row < kRows; ++row) {
            history.push_back(row);
            history.push_back(exact(row) + error(k, row));
        }
        convergence.add(history);
    }
    return convergence;
}

Left left_by(const ErrorOf& error, int histories) {
    const Convergence convergence = convergence_of(error, histories);
    Left left;
    std::vector<double> values(2), estimates(2);
    for (int row = 0; row < kRows; ++row) {
        convergence.evaluate_row(static_cast<size_t>(row), values, estimates);
        EXPECT_EQ(values[0], row);
        EXPECT_EQ(estimates[0], 0) << "no difference, no error";
        left.error = std::max(left.error, std::abs(values[1] - exact(row)));
        left.newest_error = std::max(left.newest_error, std::abs(error(histories - 1, row)));
    }
    left.estimate = estimates[1];
    EXPECT_EQ(convergence.estimates()[1], left.estimate) << "the last row's is the history's";
    return left;
}

double shape(int row) { return std::cos(1.3 * row) - 0.2; }
const double kShapePeak = 0.2 - std::cos(1.3 * 2);  // in row 2

// Oracle: closed form. An error C/4^k is gone after extrapolation, of 1/16^k a quarter remains, with the other sign:
// (4 a_1 − a_0)/3 = a_0 (4/16 − 1)/3 = −a_0/4.
TEST(Convergence, TwoHistoriesExtrapolateSecondOrder) {
    const Left pure = left_by([](int k, int row) { return 0.1 * shape(row) / std::pow(4, k); }, 2);
    EXPECT_LT(pure.error, 1e-15);
    const Left fourth = left_by([](int k, int row) { return 0.1 * shape(row) / std::pow(16, k); }, 2);
    EXPECT_NEAR(fourth.error, 0.25 * 0.1 * kShapePeak, 1e-12);
}

// Oracle: closed form: 3/2 max |δ_1|, as little is known yet.
TEST(Convergence, TwoHistoriesTakeTheirDifferenceForTheError) {
    const Left left = left_by([](int k, int row) { return 0.1 * shape(row) / std::pow(2, k); }, 2);
    EXPECT_NEAR(left.estimate, 1.5 * 0.05 * kShapePeak, 1e-12);
    EXPECT_GT(left.estimate, left.error);
}

/// a/4^k + b/16^k + c/64^k, as of the integration where the motion is smooth.
ErrorOf smooth_error(double a, double b, double c) {
    return [=](int k, int row) {
        return a * shape(row) / std::pow(4, k) + b * std::sin(row + 1.0) / std::pow(16, k) + c / std::pow(64, k);
    };
}
const double kLargestSine = -std::sin(5.0);

// Oracle: closed form: of b/16^k the value keeps −b/4/16^(k−1), and the estimate |4 δ_k − δ_{k−1}| is 45 times that.
TEST(Convergence, OfASmoothMotionTheEstimateIsFortyFiveTimesTheError) {
    const Left left = left_by(smooth_error(0.1, 0.01, 0), 3);
    EXPECT_NEAR(left.error, 0.01 * kLargestSine / 4 / 16, 1e-13);
    EXPECT_NEAR(left.estimate, 45 * left.error, 1e-12);
}

// Oracle: closed form: four histories lose b/16^k too. Of c/64^k the value keeps 64 c/64^k; its estimate is 252 times that.
TEST(Convergence, OfFourSmoothHistoriesTheFourthOrderIsExtrapolatedToo) {
    for (int histories : {4, 5, 6}) {
        const Left left = left_by(smooth_error(0.1, 0.5 / std::pow(4, histories), 1e-3), histories);
        EXPECT_NEAR(left.error, 1e-3 / std::pow(64, histories - 2), 1e-15);
        EXPECT_NEAR(left.estimate, 252 * left.error, 1e-12);
    }
}

// Oracle: closed form: what T takes away from R, b/4/16^(k−1), is a 45th of E_R, and the estimate E_R/6.5 at least.
TEST(Convergence, TheEstimateIsAtLeastSevenTimesTheLastExtrapolation) {
    for (int histories : {4, 5, 6}) {
        const Left left = left_by(smooth_error(0.1, 0.01, 1e-9), histories);
        EXPECT_NEAR(left.estimate, 45 / 6.5 * 0.01 * kLargestSine / 4 / std::pow(16, histories - 2), 1e-9);
        EXPECT_LT(left.error, 1e-3 * left.estimate);
    }
}

/// Error of a load of which the derivative number n − 1 jumps at the share θ of the first step: h^n times the Bernoulli
/// polynomial of the place in the step.
double kink_error(int n, double theta, int k) {
    const double place = theta * std::pow(2, k), x = place - std::floor(place);
    const double polynomials[] = {x - 0.5, x * x - x + 1.0 / 6, x * x * x - 1.5 * x * x + 0.5 * x};
    return polynomials[n - 1] / std::pow(2, n * k);
}

// Oracle: the true errors, over all places; the bounds of the header, beside a smooth motion of which nothing is left.
TEST(Convergence, TheEstimateKnowsKinksOfLoads) {
    const double most[] = {0.78, 0.94, 0.26};
    for (int n : {1, 2, 3}) {
        double worst = 0;
        for (int place = 0; place < 2000; ++place) {
            const double theta = (place + 0.31) / 2000;
            const auto error = [=](int k, int row) {
                return 30 * shape(row) / std::pow(4, k) + (row < 3 ? 0 : kink_error(n, theta, k));
            };
            const Left left = left_by(error, 4);
            worst = std::max(worst, left.error / left.estimate);
        }
        EXPECT_LT(worst, most[n - 1]) << n;
        EXPECT_GT(worst, 0.9 * most[n - 1]) << n;
    }
}

/// Error of a load that jumps at the share θ_k of a step, h (θ_k − ½) with θ_{k+1} the fraction of 2 θ_k, beside a smooth
/// one of `smooth` at the first step.
ErrorOf jump_error(double theta, double smooth) {
    return [=](int k, int row) {
        const double ratio = std::pow(2, k), scaled = theta * ratio;
        const double jump = row < 3 ? 0 : std::sin(2.1 * row) / ratio * (scaled - std::floor(scaled) - 0.5);
        return jump + smooth * shape(row) / (ratio * ratio);
    };
}

// Oracle: the true errors. Wherever the jump falls and however large the smooth part, at two to eight histories.
TEST(Convergence, TheEstimateBoundsTheErrorOfJumpsWhereverTheyFall) {
    int extrapolated = 0, kept = 0;
    for (int place = 1; place < 40; ++place)
        for (double smooth : {0.0, 0.03, 0.3, 1.0, 3.0, 30.0})
            for (int histories = 2; histories <= 8; ++histories) {
                const Left left = left_by(jump_error(place / 40.3, smooth), histories);
                EXPECT_LE(left.error, left.estimate * 1.0001) << place << " " << smooth << " " << histories;
                ++(std::abs(left.error - left.newest_error) < 1e-12 ? kept : extrapolated);
            }
    EXPECT_GT(extrapolated, 100) << "both rules must have been met";
    EXPECT_GT(kept, 100);
}

// Oracle: closed form: of first order the newest history is the value, and its error |δ|, times 3/2.
TEST(Convergence, OfFirstOrderTheNewestHistoryIsKept) {
    const Left left = left_by([](int k, int row) { return 0.1 * shape(row) / std::pow(2, k); }, 4);
    EXPECT_NEAR(left.error, left.newest_error, 1e-12);
    EXPECT_NEAR(left.estimate, 1.5 * left.error, 1e-12);
    const Left half = left_by([](int k, int row) { return 0.1 * shape(row) / std::pow(2, 0.7 * k); }, 4);
    EXPECT_NEAR(half.estimate, 1.5 * half.error, 1e-12) << "below one the observed order is used";
}

// Oracle: closed form: what falls sixteenfold by itself, extrapolation by a third of the difference would spoil.
TEST(Convergence, OfHigherOrderTheNewestHistoryIsKept) {
    const Left left = left_by([](int k, int row) { return 0.1 * shape(row) / std::pow(16, k); }, 3);
    EXPECT_NEAR(left.error, 0.1 * kShapePeak / 256, 1e-12);
    EXPECT_GT(left.estimate, left.error);
}

// What does not converge has a large estimate, not a small one: noise of one size at every step.
TEST(Convergence, NoiseIsNotTakenForConvergence) {
    const auto noise = [](int k, int row) { return 1e-9 * std::sin(100.0 * (k + 1) * (row + 1) * (row + 3)); };
    for (int histories = 2; histories <= 9; ++histories) {
        const Left left = left_by(noise, histories);
        EXPECT_GT(left.estimate, left.error) << histories;
    }
}

// A difference that happens to vanish must not hide the one before: a quarter of that is the least that is believed.
TEST(Convergence, AVanishingDifferenceIsNotBelieved) {
    const Left left = left_by([](int k, int row) { return k == 0 ? 0.1 * shape(row) : 0.01 * shape(row); }, 3);
    EXPECT_GE(left.estimate, 1.5 * 0.25 * 0.09);
    EXPECT_GT(left.estimate, left.error);
}

// The estimate of a row covers the rows up to it: it never falls, however small the difference of the row.
TEST(Convergence, RowsCarryTheLargestEstimateSoFar) {
    const Convergence convergence = convergence_of(
        [](int k, int row) {
            return (row == 2 ? 0.1 : row == 5 ? 0.3 : 0) / std::pow(2, k);
        },
        4);
    std::vector<double> values(2), estimates(2), seen;
    for (size_t row = 0; row < convergence.rows(); ++row) {
        convergence.evaluate_row(row, values, estimates);
        seen.push_back(estimates[1]);
    }
    EXPECT_EQ(seen[1], 0);
    EXPECT_GT(seen[2], 0);
    EXPECT_EQ(seen[4], seen[2]);
    EXPECT_NEAR(seen[6], 3 * seen[2], 1e-12);
}

TEST(Convergence, ObservedOrderIsTheLogarithmOfTheRatio) {
    EXPECT_DOUBLE_EQ(observed_order(8, 2), 2);
    EXPECT_DOUBLE_EQ(observed_order(2, 4), -1);
    EXPECT_TRUE(std::isnan(observed_order(0, 1)));
    EXPECT_TRUE(std::isnan(observed_order(1, 0)));
}

// Oracle: the numbers given.
TEST(Convergence, OneHistoryIsThereAsItIs) {
    const Convergence convergence = convergence_of([](int, int) { return 0.5; }, 1);
    EXPECT_EQ(convergence.rows(), static_cast<size_t>(kRows));
    EXPECT_EQ(convergence.newest_row(4)[1], exact(4) + 0.5);
    EXPECT_TRUE(convergence.estimates().empty());
}

}  // namespace
}  // namespace dttmm::host
