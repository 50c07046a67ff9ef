// SPDX-License-Identifier: BSD-3-Clause
#include "identify/residuals.h"

#include <fmt/format.h>

#include <cmath>

#include "identify/forked_map.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

/// The residuals of a task that changed an unknown.
Eigen::VectorXd column_of(const TaskResult& result, const Unknown& unknown, Eigen::Index rows) {
    if (!result.reason.empty())
        throw Error(ExitCode::numerical_failure, fmt::format("with {} changed by 1 %: {}", unknown.name, result.reason));
    return Eigen::Map<const Eigen::VectorXd>(result.numbers.data(), rows);
}

}  // namespace

Eigen::Index Residuals::rows() const { return comparison_.rows() + as_row(priors_.size()); }

Eigen::VectorXd Residuals::at(const Eigen::VectorXd& x, bool are_logarithmic) const {
    return of(comparison_.predict(unknowns_, x), x, are_logarithmic);
}

Eigen::VectorXd Residuals::of(const Eigen::VectorXd& predicted, const Eigen::VectorXd& x, bool are_logarithmic) const {
    Eigen::VectorXd residual(rows());
    residual.head(comparison_.rows()) = comparison_.residual(predicted, are_logarithmic);
    for (size_t i = 0; i < priors_.size(); ++i) {
        const double value = unknowns_[priors_[i].unknown].value(x(as_row(priors_[i].unknown)));
        residual(comparison_.rows() + as_row(i)) =
            ((priors_[i].is_of_logarithm ? std::log(value) : value) - priors_[i].mean) / priors_[i].deviation;
    }
    return residual;
}

/// By central differences of the residuals: one formula for all kinds of data.
Eigen::MatrixXd Residuals::jacobian(const Eigen::VectorXd& x, bool are_logarithmic, int jobs) const {
    const auto point = [&](size_t task) {
        Eigen::VectorXd moved = x;
        moved(as_row(task / 2)) += task % 2 == 0 ? kDifference : -kDifference;
        return moved;
    };
    const std::vector<TaskResult> results = map_in_processes(2 * unknowns_.size(), jobs, [&](size_t task) {
        const Eigen::VectorXd own = at(point(task), are_logarithmic);
        return std::vector<double>(own.begin(), own.end());
    });
    const Eigen::Index count = rows();
    Eigen::MatrixXd slopes(count, x.size());
    for (size_t i = 0; i < unknowns_.size(); ++i)
        slopes.col(as_row(i)) =
            (column_of(results[2 * i], unknowns_[i], count) - column_of(results[2 * i + 1], unknowns_[i], count)) /
            (2 * kDifference);
    return slopes;
}

LeastSquares Residuals::problem(bool are_logarithmic, int jobs) const {
    return {[this, are_logarithmic](const Eigen::VectorXd& x) { return at(x, are_logarithmic); },
            [this, are_logarithmic, jobs](const Eigen::VectorXd& x, const Eigen::VectorXd&) {
                return jacobian(x, are_logarithmic, jobs);
            },
            unknowns_.low(), unknowns_.high()};
}

Eigen::MatrixXd Residuals::differentiate_quickly(const Eigen::VectorXd& x, const Eigen::VectorXd& here,
                                                 const std::vector<size_t>& coordinates) const {
    const std::vector<TaskResult> results = map_in_processes(coordinates.size(), jobs_, [&](size_t task) {
        Eigen::VectorXd moved = x;
        moved(as_row(coordinates[task])) += kDifference;
        const Eigen::VectorXd own = at(moved, false);
        return std::vector<double>(own.begin(), own.end());
    });
    Eigen::MatrixXd slopes(here.size(), as_row(coordinates.size()));
    for (size_t i = 0; i < coordinates.size(); ++i)
        slopes.col(as_row(i)) = (column_of(results[i], unknowns_[coordinates[i]], here.size()) - here) / kDifference;
    return slopes;
}

}  // namespace dttmm::host
