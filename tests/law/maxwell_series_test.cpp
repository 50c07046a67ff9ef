// SPDX-License-Identifier: BSD-3-Clause
#include "law/maxwell_series.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace dttmm::plugin {
namespace {

using Complex = std::complex<double>;

std::vector<DynamicStiffnessRow> sampled(double low, double high, int count, Complex (*stiffness)(double omega)) {
    std::vector<DynamicStiffnessRow> rows;
    for (int i = 0; i < count; ++i) {
        const double omega = low * std::pow(high / low, static_cast<double>(i) / (count - 1));
        const Complex K = stiffness(omega);
        rows.push_back({omega, std::abs(K), std::arg(K)});
    }
    return rows;
}

// Oracle: the formula, term by term.
TEST(MaxwellSeries, IsASpringBesideSpringsWithDampers) {
    const MaxwellSeries series{700, {{300, 0.02}, {150, 0.7}}};
    const Complex s(0, 31), a = 300.0 / (1.0 + 1.0 / (s * 0.02)), b = 150.0 / (1.0 + 1.0 / (s * 0.7));
    EXPECT_LT(std::abs(series.at(31) - (700.0 + a + b)), 1e-12 * 700);
}

// Oracle: rows made by a series with one term and by a spring alone. Two terms a decade leave 2 % of a term between them.
TEST(MaxwellSeries, FitsRowsOfItsOwnKind) {
    const auto one = sampled(3, 900, 23, [](double omega) { return MaxwellSeries{700, {{300, 0.02}}}.at(omega); });
    EXPECT_LT(fit_maxwell(one).misfit(one).share, 0.02);
    const auto spring = sampled(3, 900, 7, [](double) { return Complex(450); });
    const MaxwellSeries found = fit_maxwell(spring);
    EXPECT_NEAR(found.spring, 450, 1e-6);
    EXPECT_LT(found.misfit(spring).share, 1e-9);
}

// Oracle: K = k (iωτ)^α, a fractional element, has one loss angle απ/2 everywhere, as rubber nearly has. The fit is within 2
// % of it over three decades, and has no negative stiffness.
TEST(MaxwellSeries, FitsRubber) {
    const auto rubber = sampled(5, 5000, 19, [](double omega) { return 1200.0 * std::pow(Complex(0, omega), 0.07); });
    const MaxwellSeries found = fit_maxwell(rubber);
    EXPECT_LT(found.misfit(rubber).share, 0.02);
    EXPECT_GE(found.spring, 0);
    EXPECT_GT(found.terms.size(), 3u);
    for (const auto& term : found.terms) EXPECT_GT(term.stiffness, 0);
}

// Oracle: the optimum itself. A change of any stiffness makes the sum of squares larger.
TEST(MaxwellSeries, HasTheLeastSumOfSquares) {
    const auto rows = sampled(5, 800, 9, [](double omega) { return Complex(900 + 0.4 * omega, 40 + 2 * std::sqrt(omega)); });
    const auto sum = [&](const MaxwellSeries& series) {
        double squares = 0;
        for (const auto& row : rows) squares += std::norm((series.at(row.omega) - row.value()) / row.stiffness);
        return squares;
    };
    const MaxwellSeries best = fit_maxwell(rows);
    ASSERT_FALSE(best.terms.empty());
    for (size_t j = 0; j <= best.terms.size(); ++j)
        for (const double change : {-0.5, 0.5}) {
            MaxwellSeries other = best;
            (j == 0 ? other.spring : other.terms[j - 1].stiffness) += change;
            EXPECT_GT(sum(other), sum(best)) << j;
        }
}

// Oracle: what no material does. A loss angle with a stiffness that falls with the frequency is not fitted, and that shows.
TEST(MaxwellSeries, SaysHowFarItIsOff) {
    const auto wrong = sampled(5, 800, 9, [](double omega) { return std::polar(2000 - omega, 0.3); });
    const auto misfit = fit_maxwell(wrong).misfit(wrong);
    EXPECT_GT(misfit.share, 0.1);
    EXPECT_GE(misfit.omega, 5);
    EXPECT_LE(misfit.omega, 800.001);
}

}  // namespace
}  // namespace dttmm::plugin
