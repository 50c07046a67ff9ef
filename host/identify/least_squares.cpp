// SPDX-License-Identifier: BSD-3-Clause
#include "identify/least_squares.h"

#include <Eigen/Dense>
#include <algorithm>
#include <unsupported/Eigen/LevenbergMarquardt>

#include "analysis/stop_signals.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr double kRefused = 1e3;  // times the residual at the start: a step to where the model has no answer

/// The problem in those unknowns that are not held, as Eigen's solver wants it: with as many residuals as unknowns or more.
/// Where there are fewer, zeros are added.
class FreeProblem : public Eigen::DenseFunctor<double> {
public:
    FreeProblem(const LeastSquares& problem, Eigen::VectorXd x, Eigen::VectorXd at_start, std::vector<Eigen::Index> free)
        : DenseFunctor<double>(as_int(free.size()), std::max(as_int(free.size()), as_int(at_start.size()))),
          problem_(problem),
          x_(std::move(x)),
          refused_(kRefused * (1 + at_start.norm())),
          free_(std::move(free)) {}

    int operator()(const Eigen::VectorXd& part, Eigen::VectorXd& residual) {
        if (StopSignals::requested()) return -1;
        ++evaluations;
        try {
            last_x_ = whole(part);
            last_ = problem_.residual(last_x_);
            residual.setZero(values());
            residual.head(last_.size()) = last_;
            if (residual.allFinite()) return 0;
        } catch (const Error&) {
            if (StopSignals::requested()) return -1;
        }
        last_.resize(0);
        residual.setConstant(values(), refused_);
        return 0;
    }

    /// The residual there: that of the last call, where it was of the same point.
    Eigen::VectorXd residual_at(const Eigen::VectorXd& x) const {
        return last_.size() > 0 && last_x_ == x ? last_ : problem_.residual(x);
    }

    int df(const Eigen::VectorXd& part, Eigen::MatrixXd& jacobian) {
        const Eigen::VectorXd x = whole(part);
        const Eigen::VectorXd here = residual_at(x);
        const Eigen::MatrixXd all = problem_.jacobian(x, here);
        is_given_up = problem_.is_hopeless && problem_.is_hopeless(here, all);
        if (is_given_up) return -1;
        jacobian.setZero(values(), inputs());
        jacobian.topRows(all.rows()) = all(Eigen::all, free_);
        return 0;
    }

    /// All unknowns, within their bounds.
    Eigen::VectorXd whole(const Eigen::VectorXd& part) const {
        Eigen::VectorXd x = x_;
        for (size_t i = 0; i < free_.size(); ++i)
            x(free_[i]) = std::clamp(part(as_row(i)), problem_.low(free_[i]), problem_.high(free_[i]));
        return x;
    }

    int evaluations = 0;
    bool is_given_up = false;

private:
    const LeastSquares& problem_;
    Eigen::VectorXd x_;
    double refused_;
    std::vector<Eigen::Index> free_;
    Eigen::VectorXd last_x_, last_;  ///< of the last call; none: the model had no answer
};

/// Goes down from minimum.x in the unknowns that are not at a bound.
void descend(const LeastSquares& problem, Minimum& minimum, const SearchEnd& end) {
    std::vector<Eigen::Index> free;
    for (size_t i = 0; i < minimum.at_bound.size(); ++i)
        if (!minimum.at_bound[i]) free.push_back(as_row(i));
    minimum.is_converged = free.empty();
    if (free.empty()) return;
    FreeProblem own(problem, minimum.x, minimum.residual, free);
    Eigen::LevenbergMarquardt<FreeProblem> solver(own);
    solver.setFtol(end.enough);
    solver.setXtol(end.enough);
    solver.setGtol(0);
    solver.setMaxfev(end.most_evaluations);
    Eigen::VectorXd part(as_row(free.size()));
    for (size_t i = 0; i < free.size(); ++i) part(as_row(i)) = minimum.x(free[i]);
    const auto status = solver.minimize(part);
    if (StopSignals::requested()) throw Error(StopSignals::exit_code(), StopSignals::reason());
    minimum.evaluations += own.evaluations;
    minimum.is_given_up = own.is_given_up;
    minimum.is_converged = !own.is_given_up && status != Eigen::LevenbergMarquardtSpace::TooManyFunctionEvaluation &&
                           status != Eigen::LevenbergMarquardtSpace::ImproperInputParameters;
    minimum.x = own.whole(part);
    minimum.residual = own.residual_at(minimum.x);
}

/// Whether an unknown is at a bound, or is fixed at one.
bool is_bounded(const LeastSquares& problem, const Minimum& minimum) {
    return (minimum.x.array() <= problem.low.array()).any() || (minimum.x.array() >= problem.high.array()).any() ||
           std::ranges::count(minimum.at_bound, true) > 0;
}

}  // namespace

Minimum minimise(const LeastSquares& problem, const Eigen::VectorXd& start, const SearchEnd& end) {
    Minimum minimum;
    minimum.x = start.cwiseMax(problem.low).cwiseMin(problem.high);
    minimum.residual = problem.residual(minimum.x);
    minimum.at_bound.assign(as_size(start.size()), false);
    constexpr int kMostRounds = 6;  // in which unknowns are taken to bounds and from them
    for (int round = 0; round < kMostRounds; ++round) {
        descend(problem, minimum, end);
        if (minimum.is_given_up || !is_bounded(problem, minimum)) break;
        // Beyond a bound the sum falls where its slope says so
        const Eigen::VectorXd slope = problem.jacobian(minimum.x, minimum.residual).transpose() * minimum.residual;
        bool has_changed = false;
        for (Eigen::Index i = 0; i < start.size(); ++i) {
            const bool is_low = minimum.x(i) <= problem.low(i), is_high = minimum.x(i) >= problem.high(i);
            const bool holds = (is_low && slope(i) > 0) || (is_high && slope(i) < 0);
            if (holds == minimum.at_bound[as_size(i)]) continue;
            minimum.at_bound[as_size(i)] = holds;
            has_changed = true;
        }
        if (!has_changed) break;
    }
    return minimum;
}

}  // namespace dttmm::host
