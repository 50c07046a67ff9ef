// SPDX-License-Identifier: BSD-3-Clause
#include "identify/fit.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr double kUnlikely = 1e-3;                              // chance below which a statement is rejected
constexpr double kAssumedWithin = 3;                            // usual noise may be this many times larger or smaller
constexpr Eigen::Index kFewestCorrelated = 20, kMostLags = 20;  // samples; lags

/// Autocorrelations at lags 1 … count.
std::vector<double> correlations(const Eigen::VectorXd& values, Eigen::Index count) {
    const Eigen::VectorXd own = values.array() - values.mean();
    const double square = own.squaredNorm();
    std::vector<double> result;
    for (Eigen::Index k = 1; k <= count && square > 0; ++k)
        result.push_back(own.head(own.size() - k).dot(own.tail(own.size() - k)) / square);
    return result;
}

/// The chance that a sum of `freedom` squares of normal numbers is larger. Far from its mean it is 0 or 1 to rounding.
double chance_beyond(double chi2, Eigen::Index freedom) {
    const auto n = static_cast<double>(freedom);
    constexpr double kFar = 40;  // standard deviations
    if (!(std::abs(chi2 - n) < kFar * std::sqrt(2 * n))) return chi2 > n ? 0 : 1;
    return boost::math::cdf(complement(boost::math::chi_squared(n), chi2));
}

/// Of residuals.
struct Correlation {
    double chance = 1;  ///< that noise has as much
    double memory = 1;  ///< samples that tell no more than one
    double peak = 1;    ///< of the power over frequency, times its mean
};

/// Of a spectrum with these correlations at lags 1, 2 and so on, smoothed by Bartlett's window.
double peak_of_power(const std::vector<double>& rho) {
    const size_t points = 4 * rho.size();  // of half the spectrum: four for the width of the window
    const auto lags = static_cast<double>(rho.size() + 1);
    double peak = 1;
    for (size_t i = 0; i <= points; ++i) {
        double power = 1;
        for (size_t k = 1; k <= rho.size(); ++k)
            power += 2 * (1 - static_cast<double>(k) / lags) * rho[k - 1] *
                     std::cos(std::numbers::pi * static_cast<double>(i * k) / static_cast<double>(points));
        peak = std::max(peak, power);
    }
    return peak;
}

/// Source: Ljung and Box (1978), Biometrika 65, 297-303.
Correlation judge_correlation(const Eigen::VectorXd& residual) {
    const std::vector<double> rho = correlations(residual, std::min(kMostLags, residual.size() / 5));
    const auto n = static_cast<double>(residual.size());
    Correlation found;
    double Q = 0;
    bool is_open = true;
    for (size_t k = 0; k < rho.size(); ++k) {
        Q += n * (n + 2) * rho[k] * rho[k] / (n - static_cast<double>(k + 1));
        is_open = is_open && rho[k] > 2 / std::sqrt(n);
        if (is_open) found.memory += 2 * rho[k];
    }
    if (rho.empty()) return found;
    found.chance = chance_beyond(Q, as_row(rho.size()));
    found.peak = peak_of_power(rho);
    return found;
}

}  // namespace

bool Fit::is_explained() const {
    const bool is_small = chance > kUnlikely || (is_noise_assumed && noise_factor() < kAssumedWithin);
    return (!is_noise_independent || is_small) && whiteness > kUnlikely && offsets.empty();
}

Fit judge_fit(const Comparison& comparison, const Solution& solution) {
    Fit fit;
    fit.chi2 = solution.chi2;
    fit.points = comparison.rows();
    Eigen::Index sought = comparison.scales();
    for (size_t i = 0; i < solution.at_bound.size(); ++i) sought += !solution.judged.is_dead[i] && !solution.at_bound[i];
    sought -= as_row(solution.judged.flat.size());
    fit.freedom = fit.points - sought;
    fit.is_noise_independent = std::ranges::none_of(
        comparison.groups(), [](const DataGroup& group) { return group.noise_from == DataGroup::NoiseFrom::residuals; });
    fit.is_noise_assumed = std::ranges::any_of(
        comparison.groups(), [](const DataGroup& group) { return group.noise_from == DataGroup::NoiseFrom::assumed; });
    if (fit.freedom > 0) fit.chance = chance_beyond(fit.chi2, fit.freedom);
    size_t samples = 0;
    for (const DataGroup& group : comparison.groups()) samples += group.noise_samples;
    if (samples > 0 && fit.freedom > 0)  // the noise itself is an estimate
        fit.chance = boost::math::cdf(
            complement(boost::math::fisher_f(static_cast<double>(fit.freedom), static_cast<double>(samples)),
                       fit.chi2 / static_cast<double>(fit.freedom)));
    const Eigen::VectorXd residual = comparison.residual(solution.predicted, false);
    for (const DataGroup& group : comparison.groups()) {
        if (group.kind == DataGroup::Kind::frequency || group.kind == DataGroup::Kind::shape) continue;
        const double squares = (solution.predicted - comparison.data()).segment(group.first, group.count).squaredNorm();
        fit.misfit = std::max(fit.misfit, std::sqrt(squares / static_cast<double>(group.count)) / group.largest);
    }
    double sum = 0;
    int looked_at = 0;
    for (const DataGroup& group : comparison.groups()) {
        const bool is_curve = group.kind == DataGroup::Kind::history || group.kind == DataGroup::Kind::response;
        if (!is_curve || group.count < kFewestCorrelated || group.noise <= kLeastNoise * group.largest) continue;
        const Eigen::Index stride = group.kind == DataGroup::Kind::response ? 2 : 1;
        const Eigen::VectorXd own = Eigen::Map<const Eigen::VectorXd, 0, Eigen::InnerStride<>>(
            residual.data() + group.first, group.count / stride, Eigen::InnerStride<>(stride));
        const Correlation found = judge_correlation(own);
        // Where noise that is known has more power at every frequency, nothing shows that it would not hide
        const bool is_known = group.noise_from != DataGroup::NoiseFrom::residuals;
        const auto samples_here = static_cast<double>(own.size());
        if (is_known && own.squaredNorm() * found.peak < samples_here) continue;
        fit.whiteness = std::min(fit.whiteness, found.chance);
        // A mean that noise does not explain is an offset of the sensor
        constexpr double kOffset = 5;  // standard deviations of the mean
        if (group.kind == DataGroup::Kind::history && std::abs(own.sum()) > kOffset * own.norm())
            fit.offsets.push_back(group.name);
        sum += found.memory;
        ++looked_at;
    }
    fit.whiteness = std::min(1.0, fit.whiteness * std::max(1, looked_at));
    constexpr double kExact = 1e-7;  // share of the largest value: data that the model made itself leave rounding
    fit.can_be_judged = fit.is_noise_independent || looked_at > 0 || fit.misfit < kExact;
    if (looked_at > 0 && fit.whiteness < kUnlikely) fit.inflation = std::sqrt(sum / looked_at);
    if (fit.is_noise_assumed && fit.chance < kUnlikely) fit.inflation = std::max(fit.inflation, fit.noise_factor());
    return fit;
}

}  // namespace dttmm::host
