// SPDX-License-Identifier: BSD-3-Clause
#include "study/sensitivity.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "study/design.h"

namespace dttmm::host {
namespace {

using Function = std::function<double(const Eigen::RowVectorXd& u)>;

std::vector<double> evaluate(const Eigen::MatrixXd& u, const Function& f) {
    std::vector<double> values;
    for (Eigen::Index i = 0; i < u.rows(); ++i) values.push_back(f(u.row(i)));
    return values;
}

/// Ishigami and Homma (1990): a = 7, b = 0.1, of numbers between −π and π.
double ishigami(const Eigen::RowVectorXd& u) {
    const Eigen::RowVectorXd x = M_PI * (2 * u.array() - 1);
    return std::sin(x(0)) + 7 * std::pow(std::sin(x(1)), 2) + 0.1 * std::pow(x(2), 4) * std::sin(x(0));
}

// Oracle: the indices in closed form: V = a²/8 + b π⁴/5 + b² π⁸/18 + 1/2, V₁ = (1 + b π⁴/5)²/2, V₂ = a²/8,
// V₁₃ = b² π⁸ (1/18 − 1/50).
TEST(SensitivityOfFigures, SobolIndicesOfIshigamisFunction) {
    const double a = 7, b = 0.1, p4 = std::pow(M_PI, 4), p8 = p4 * p4;
    const double v1 = std::pow(1 + b * p4 / 5, 2) / 2, v2 = a * a / 8, v13 = b * b * p8 * (1.0 / 18 - 1.0 / 50),
                 v = v1 + v2 + v13;
    const double first[] = {v1 / v, v2 / v, 0}, total[] = {(v1 + v13) / v, v2 / v, v13 / v};
    const Eigen::MatrixXd u = make_probabilities(Design::indices, 4096 * 5, 3, 7);
    const auto all = compute_sobol_indices(evaluate(u, ishigami), 3);
    ASSERT_EQ(all.size(), 3u);
    for (size_t p = 0; p < 3; ++p) {
        EXPECT_EQ(all[p].blocks, 4096u);
        EXPECT_NEAR(all[p].first.value, first[p], 0.01) << p;
        EXPECT_NEAR(all[p].total.value, total[p], 0.01) << p;
        EXPECT_LT(all[p].first.low, all[p].first.value);
        EXPECT_GT(all[p].first.high, all[p].first.value);
    }
}

// Oracle: Sobol's g-function: V_i = 1/(3 (1 + a_i)²), V = ∏(1 + V_i) − 1; in 50 of 60 studies at least the intervals of 95 %
// hold the true index.
TEST(SensitivityOfFigures, IntervalsOfTheGFunctionHoldTheIndices) {
    const double a[] = {0, 1, 4.5, 9, 99};
    const Function g = [&](const Eigen::RowVectorXd& u) {
        double product = 1;
        for (int p = 0; p < 5; ++p) product *= (std::abs(4 * u(p) - 2) + a[p]) / (1 + a[p]);
        return product;
    };
    double variance = 1, own[5];
    for (int p = 0; p < 5; ++p) variance *= 1 + (own[p] = 1 / (3 * std::pow(1 + a[p], 2)));
    variance -= 1;
    int held = 0;
    for (std::uint64_t seed = 1; seed <= 60; ++seed) {
        const auto all = compute_sobol_indices(evaluate(make_probabilities(Design::indices, 256 * 7, 5, seed), g), 5);
        const double total = own[0] / (1 + own[0]) * (1 + variance) / variance;
        held += all[0].total.low <= total && total <= all[0].total.high ? 1 : 0;
        EXPECT_NEAR(all[0].first.value, own[0] / variance, 0.15);
        EXPECT_NEAR(all[4].total.value, 0, 0.01);
    }
    EXPECT_GE(held, 50);
}

// Oracle: all cells enumerated: 4³ cells, each parameter moved by two cells.
TEST(SensitivityOfFigures, ElementaryEffectsAreThoseOfTheGrid) {
    double size[3] = {}, mean[3] = {};
    for (int cell = 0; cell < 64; ++cell) {
        const Eigen::RowVectorXd u = (Eigen::RowVector3d(cell % 4, cell / 4 % 4, cell / 16).array() + 0.5) / 4;
        for (int p = 0; p < 3; ++p) {
            Eigen::RowVectorXd moved = u;
            const double by = u(p) < 0.5 ? 0.5 : -0.5;
            moved(p) += by;
            const double effect = std::copysign(1.0, by) * (ishigami(moved) - ishigami(u));
            size[p] += std::abs(effect) / 64;
            mean[p] += effect / 64;
        }
    }
    const Eigen::MatrixXd u = make_probabilities(Design::morris, 4000 * 4, 3, 2);
    const auto all = compute_elementary_effects(evaluate(u, ishigami), u);
    for (size_t p = 0; p < 3; ++p) {
        EXPECT_NEAR(all[p].size.value, size[p], 0.15) << p;
        EXPECT_NEAR(all[p].mean, mean[p], 0.3) << p;
        EXPECT_LE(all[p].size.low, all[p].size.value);
        EXPECT_GE(all[p].size.high, all[p].size.value);
    }
    EXPECT_GT(size[0], 1);
}

TEST(SensitivityOfFigures, BlocksThatDidNotCompleteAreLeftOut) {
    const Eigen::MatrixXd u = make_probabilities(Design::indices, 100 * 5, 3, 7);
    std::vector<double> values = evaluate(u, ishigami);
    std::vector<double> shorter(values.begin() + 10, values.end());
    values[3] = values[8] = std::nan("");
    const auto all = compute_sobol_indices(values, 3), others = compute_sobol_indices(shorter, 3);
    EXPECT_EQ(all[1].blocks, 98u);
    EXPECT_DOUBLE_EQ(all[1].total.value, others[1].total.value);
    EXPECT_TRUE(compute_sobol_indices(std::vector<double>(10, std::nan("")), 3).empty());
}

TEST(SensitivityOfFigures, OneAtATime) {
    Eigen::MatrixXd parameters(3, 2);
    parameters << 1, 5, 2, 5, 1, 7;
    const auto effects = compute_single_effects(std::vector<double>{10, 12, 9}, parameters);
    ASSERT_EQ(effects.size(), 2u);
    EXPECT_EQ(effects[0].change, 2);
    EXPECT_EQ(effects[1].parameter, 1);
    EXPECT_EQ(effects[1].change, -1);
}

}  // namespace
}  // namespace dttmm::host
