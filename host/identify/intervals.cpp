// SPDX-License-Identifier: BSD-3-Clause
#include "identify/intervals.h"

#include <Eigen/QR>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>

#include "identify/forked_map.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

/// Solves J d = r for the columns that are not at `fixed`, in the sense of least squares.
Eigen::VectorXd solve_others(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& right, const std::vector<bool>& fixed) {
    std::vector<Eigen::Index> free;
    for (size_t i = 0; i < fixed.size(); ++i)
        if (!fixed[i]) free.push_back(as_row(i));
    Eigen::VectorXd d = Eigen::VectorXd::Zero(jacobian.cols());
    if (free.empty()) return d;
    Eigen::MatrixXd own(jacobian.rows(), as_row(free.size()));
    for (size_t i = 0; i < free.size(); ++i) own.col(as_row(i)) = jacobian.col(free[i]);
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
    solver.setThreshold(1e-6);
    const Eigen::VectorXd part = solver.compute(own).solve(right);
    for (size_t i = 0; i < free.size(); ++i) d(free[i]) = part(as_row(i));
    return d;
}

/// How far chi2 rises when one unknown is moved and the others follow.
double rise(const Residuals& residuals, const Solution& solution, size_t unknown, double distance, double base) {
    const Unknowns& unknowns = residuals.unknowns();
    const Eigen::MatrixXd& jacobian = solution.slopes;
    constexpr int kRounds = 2;  // the first is exact for a linear model
    std::vector<bool> fixed = solution.at_bound;
    for (size_t i = 0; i < fixed.size(); ++i) fixed[i] = fixed[i] || solution.judged.is_dead[i] || i == unknown;
    Eigen::VectorXd x = solution.x;
    x(as_row(unknown)) += distance;
    Eigen::VectorXd step = distance * jacobian.col(as_row(unknown));
    x -= solve_others(jacobian, step, fixed);
    double least = std::numeric_limits<double>::infinity();
    for (int round = 0; round < kRounds; ++round) {
        x = x.cwiseMax(unknowns.low()).cwiseMin(unknowns.high());
        const Eigen::VectorXd own = residuals.at(x);
        least = std::min(least, own.squaredNorm());
        const Eigen::VectorXd before = x;
        if (round + 1 < kRounds) x -= solve_others(jacobian, own, fixed);
        if (x == before) break;  // there are no others
    }
    return std::max(0.0, least - base);
}

/// Of chi2, at the ends of an interval of 95 %. Where the noise is an estimate, by the fewest differences behind it.
double allowed_rise(const Residuals& residuals) {
    const Comparison& comparison = residuals.comparison();
    Eigen::Index freedom = std::numeric_limits<Eigen::Index>::max();
    for (const DataGroup& group : comparison.groups()) {
        if (group.noise_from == DataGroup::NoiseFrom::residuals)
            freedom = std::min(freedom, comparison.rows() - comparison.scales() - as_row(residuals.unknowns().size()));
        if (group.noise_samples > 0) freedom = std::min(freedom, as_row(group.noise_samples));
    }
    if (freedom <= 0 || freedom == std::numeric_limits<Eigen::Index>::max())
        return boost::math::quantile(boost::math::chi_squared(1), 0.95);
    return boost::math::quantile(boost::math::fisher_f(1, static_cast<double>(freedom)), 0.95);
}

}  // namespace

/// Where chi2 has risen by what 95 % allow: from the curvature first, then by the profile of chi2 itself.
void find_intervals(const Residuals& residuals, Solution& solution, double inflation) {
    const Unknowns& unknowns = residuals.unknowns();
    const double allowed = inflation * inflation * allowed_rise(residuals);
    const double base = residuals.of(solution.predicted, solution.x).squaredNorm();
    const auto limit = [&](size_t unknown, double sign) -> std::optional<double> {
        const Unknown& one = unknowns[unknown];
        const double deviation = solution.judged.deviations(as_row(unknown)), x = solution.x(as_row(unknown));
        const double bound = one.coordinate(sign > 0 ? one.high : one.low), reach = std::abs(bound - x);
        if (solution.judged.is_dead[unknown] || !std::isfinite(deviation)) return std::nullopt;
        double distance = deviation > 0 ? std::sqrt(allowed) * deviation : 0.1 * reach;
        constexpr int kMostTries = 8;
        for (int round = 0; round < kMostTries; ++round) {
            distance = std::min(distance, reach);
            double risen = 0;
            try {
                risen = rise(residuals, solution, unknown, sign * distance, base);
            } catch (const Error&) {
                return std::nullopt;
            }
            constexpr double kEnough = 0.1;  // of what is allowed: 5 % of the interval
            if (std::abs(risen - allowed) < kEnough * allowed) return x + sign * distance;
            if (distance >= reach && risen < allowed) return std::nullopt;
            // chi2 is nearly a parabola; far from one no step is trusted beyond a factor of three
            distance *= std::clamp(std::sqrt(allowed / std::max(risen, 1e-12)), 1.0 / 3, 3.0);
        }
        return x + sign * distance;
    };
    const std::vector<TaskResult> limits = map_in_processes(2 * unknowns.size(), residuals.jobs(), [&](size_t task) {
        const std::optional<double> found = limit(task / 2, task % 2 == 0 ? -1 : 1);
        return found ? std::vector<double>{*found} : std::vector<double>();
    });
    for (size_t i = 0; i < unknowns.size(); ++i) {
        if (!limits[2 * i].numbers.empty()) solution.low[i] = limits[2 * i].numbers.front();
        if (!limits[2 * i + 1].numbers.empty()) solution.high[i] = limits[2 * i + 1].numbers.front();
        if (solution.at_bound[i]) {
            const bool is_low = solution.x(as_row(i)) <= unknowns.low()(as_row(i));
            (is_low ? solution.low : solution.high)[i].reset();
        }
    }
}

/// The scheme is of second order: what halving the step changes is three quarters of the error.
Eigen::VectorXd find_step_bias(const Residuals& residuals, const Solution& solution) {
    Comparison& comparison = residuals.comparison();
    const Eigen::VectorXd finer = comparison.predict(residuals.unknowns(), solution.x, 2);
    Eigen::VectorXd error = Eigen::VectorXd::Zero(residuals.rows());
    error.head(comparison.rows()) = 4.0 / 3 * (finer - solution.predicted).cwiseQuotient(comparison.deviations());
    std::vector<bool> fixed = solution.at_bound;
    for (size_t i = 0; i < fixed.size(); ++i) fixed[i] = fixed[i] || solution.judged.is_dead[i];
    return solve_others(solution.slopes, error, fixed);
}

}  // namespace dttmm::host
