// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "identify/comparison.h"
#include "identify/suspects.h"

namespace dttmm::host {

/// What of the columns is not a mixture of the basis.
Eigen::MatrixXd without(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& basis);

/// What faults of suspects do to the data where nothing has changed, to first order, and what that promises.
class FaultSlopes {
public:
    /// common: unknowns that every hypothesis has. Keeps all.
    FaultSlopes(Comparison& comparison, const Unknowns& common, const Suspects& suspects, int jobs)
        : comparison_(comparison), common_(common), suspects_(suspects), jobs_(jobs) {}

    /// By one-sided differences: as many runs as columns that are not known yet. common_at: coordinates of the common
    /// unknowns where nothing has changed; predicted: what they predict. columns: the common unknowns, the stiffness of
    /// every suspect, the damping of those that have one.
    void find(const Eigen::VectorXd& common_at, const Eigen::VectorXd& predicted, std::vector<size_t> columns);
    /// The same per standard deviation of the data, without what the common unknowns do: after these have changed.
    void scale();

    /// How far chi2 would fall by stiffness and damping of these suspects if all were linear.
    double gain(const std::vector<size_t>& suspects, const Eigen::VectorXd& residual) const;
    /// Pairs of the strongest suspects that promise most, that first.
    std::vector<std::array<size_t, 2>> promising_pairs(const Eigen::VectorXd& residual) const;
    /// What of a change of the residuals is no mixture of what the common unknowns do.
    Eigen::VectorXd beyond_common(const Eigen::VectorXd& change) const;
    /// Suspects in classes whose faults the data show alike.
    std::vector<std::vector<size_t>> ties() const;
    /// What the logarithm of each suspect's stiffness does, in standard deviations; 0: the data do not show it.
    std::vector<double> effects() const;

private:
    std::optional<size_t> damping_column(size_t suspect) const;
    std::vector<size_t> strongest(const Eigen::VectorXd& residual) const;

    Comparison& comparison_;
    const Unknowns& common_;
    const Suspects& suspects_;
    int jobs_;
    Eigen::MatrixXd
        changes_;  ///< of predictions by the common unknowns, the logarithms of the suspects' stiffness, of damping
    std::vector<bool> is_found_;  ///< of the columns of changes_
    Eigen::MatrixXd slopes_;      ///< the suspects' columns per standard deviation, without what the common unknowns do
};

}  // namespace dttmm::host
