// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "identify/comparison.h"
#include "identify/least_squares.h"
#include "identify/priors.h"
#include "identify/unknowns.h"

namespace dttmm::host {

/// What predictions of data lack, per standard deviation, with a row for every prior behind; a function of the coordinates
/// of the unknowns.
class Residuals {
public:
    /// Keeps comparison and unknowns. jobs: processes at a time; 0: one per core.
    Residuals(Comparison& comparison, const Unknowns& unknowns, std::vector<Prior> priors, int jobs)
        : comparison_(comparison), unknowns_(unknowns), priors_(std::move(priors)), jobs_(jobs) {}

    Comparison& comparison() const { return comparison_; }
    const Unknowns& unknowns() const { return unknowns_; }
    int jobs() const { return jobs_; }
    Eigen::Index rows() const;
    /// are_logarithmic: of responses, the logarithms are compared.
    Eigen::VectorXd at(const Eigen::VectorXd& x, bool are_logarithmic = false) const;
    /// The same of what is predicted there.
    Eigen::VectorXd of(const Eigen::VectorXd& predicted, const Eigen::VectorXd& x, bool are_logarithmic = false) const;
    Eigen::MatrixXd jacobian(const Eigen::VectorXd& x, bool are_logarithmic, int jobs) const;
    Eigen::MatrixXd jacobian(const Eigen::VectorXd& x) const { return jacobian(x, false, jobs_); }
    /// By some coordinates, at a point where they are known: one-sided differences, a run per coordinate.
    Eigen::MatrixXd differentiate_quickly(const Eigen::VectorXd& x, const Eigen::VectorXd& here,
                                          const std::vector<size_t>& coordinates) const;
    LeastSquares problem(bool are_logarithmic, int jobs) const;
    LeastSquares problem() const { return problem(false, jobs_); }

private:
    Comparison& comparison_;
    const Unknowns& unknowns_;
    std::vector<Prior> priors_;
    int jobs_;
};

}  // namespace dttmm::host
