// SPDX-License-Identifier: BSD-3-Clause
#include "identify/intervals.h"

#include <Eigen/QR>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <limits>

#include "identify/forked_map.h"
#include "identify/limit_search.h"
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

/// chi2 of a solution as one unknown is moved and the others follow.
class Profile {
public:
    Profile(const Residuals& residuals, const Solution& solution, size_t unknown, double allowed)
        : residuals_(residuals), solution_(solution), unknown_(unknown) {
        base_ = residuals.of(solution.predicted, solution.x).squaredNorm();
        end_.most_evaluations = 50;
        end_.enough = std::min(1e-5, 0.01 * allowed / (base_ + allowed));
        for (size_t i = 0; i < solution.at_bound.size(); ++i)
            if (i != unknown && !solution.judged.is_dead[i]) others_.push_back(as_row(i));
        fixed_ = solution.at_bound;
        for (size_t i = 0; i < fixed_.size(); ++i) fixed_[i] = fixed_[i] || solution.judged.is_dead[i] || i == unknown;
    }

    /// How far chi2 rises. The others begin as a linear model has them, or in line with the last point that was nearer,
    /// whichever is better, and go down from there: near a second solution they follow on a curve.
    Rise rise(double distance) {
        Eigen::VectorXd x = linear(distance);
        if (last_.size() > 0 && std::abs(last_distance_) < std::abs(distance)) {
            const Eigen::VectorXd ahead = within(solution_.x + distance / last_distance_ * (last_ - solution_.x));
            if (residuals_.at(ahead).squaredNorm() < residuals_.at(x).squaredNorm()) x = ahead;
        }
        const Minimum minimum = minimise(problem(x), x(others_), end_);
        x(others_) = minimum.x;
        last_ = x;
        last_distance_ = distance;
        return {std::max(0.0, minimum.chi2() - base_), minimum.is_converged};
    }

private:
    Eigen::VectorXd within(const Eigen::VectorXd& x) const {
        return x.cwiseMax(residuals_.unknowns().low()).cwiseMin(residuals_.unknowns().high());
    }
    /// Exact for a linear model.
    Eigen::VectorXd linear(double distance) const {
        Eigen::VectorXd x = solution_.x;
        x(as_row(unknown_)) += distance;
        return within(x - solve_others(solution_.slopes, distance * solution_.slopes.col(as_row(unknown_)), fixed_));
    }
    /// Of the others, with the rest as in x.
    LeastSquares problem(const Eigen::VectorXd& x) const {
        const auto all = [this, x](const Eigen::VectorXd& part) {
            Eigen::VectorXd point = x;
            point(others_) = part;
            return point;
        };
        return {[this, all](const Eigen::VectorXd& part) { return residuals_.at(all(part)); },
                [this, all](const Eigen::VectorXd& part, const Eigen::VectorXd& here) {
                    return residuals_.differentiate_quickly(all(part), here, {others_.begin(), others_.end()});
                },
                residuals_.unknowns().low()(others_), residuals_.unknowns().high()(others_)};
    }

    const Residuals& residuals_;
    const Solution& solution_;
    size_t unknown_;
    double base_;
    SearchEnd end_;
    std::vector<Eigen::Index> others_;
    std::vector<bool> fixed_;
    Eigen::VectorXd last_;
    double last_distance_ = 0;
};

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
    const auto limit = [&](size_t unknown, double sign) -> LimitFound {
        const Unknown& one = unknowns[unknown];
        const double deviation = solution.judged.deviations(as_row(unknown)), x = solution.x(as_row(unknown));
        if (solution.judged.is_dead[unknown] || !std::isfinite(deviation)) return {};
        const double reach = std::abs(one.coordinate(sign > 0 ? one.high : one.low) - x);
        Profile profile(residuals, solution, unknown, allowed);
        const double first = deviation > 0 ? std::sqrt(allowed) * deviation : 0.1 * reach;
        return find_limit([&](double distance) { return profile.rise(sign * distance); }, first, reach, allowed);
    };
    const std::vector<TaskResult> limits = map_in_processes(2 * unknowns.size(), residuals.jobs(), [&](size_t task) {
        const double sign = task % 2 == 0 ? -1 : 1;
        const LimitFound found = limit(task / 2, sign);
        std::vector<double> numbers = {found.is_converged ? 1.0 : 0.0};
        if (found.distance) numbers.push_back(solution.x(as_row(task / 2)) + sign * *found.distance);
        return numbers;
    });
    for (size_t i = 0; i < unknowns.size(); ++i) {
        const bool is_at_low = solution.at_bound[i] && solution.x(as_row(i)) <= unknowns.low()(as_row(i));
        solution.are_limits_converged[i] = true;
        for (const bool is_high : {false, true}) {
            if (solution.at_bound[i] && is_at_low != is_high) continue;  // there is no limit beyond a bound that holds
            const std::vector<double>& numbers = limits[2 * i + (is_high ? 1 : 0)].numbers;
            solution.are_limits_converged[i] = solution.are_limits_converged[i] && !numbers.empty() && numbers.front() == 1;
            if (numbers.size() > 1) (is_high ? solution.high : solution.low)[i] = numbers[1];
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
