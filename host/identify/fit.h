// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "identify/comparison.h"
#include "identify/identifiability.h"

namespace dttmm::host {

/// A set of values that explains the data as well as any other.
struct Solution {
    Eigen::VectorXd x;          ///< coordinates
    Eigen::VectorXd predicted;  ///< rows of the comparison
    double chi2 = 0;            ///< of the data, without priors
    std::vector<bool> at_bound;
    Eigen::MatrixXd slopes;  ///< of the residuals by the coordinates
    Identifiability judged;
    std::vector<std::optional<double>> low, high;  ///< coordinates at 95 %; none: the data give no limit
    std::vector<bool> are_limits_converged;        ///< false: the search for low or high did not converge
    size_t starts = 0;                             ///< descents that led here
};

/// How well the best solution explains the data.
struct Fit {
    double chi2 = 0;
    Eigen::Index points = 0, freedom = 0;  ///< rows; rows less what was fitted
    bool is_noise_independent = false;     ///< of the residuals: only then chi2 can tell a lack of fit
    double chance = 1;                     ///< of so large a chi2 with a true model
    double whiteness = 1;                  ///< chance that residuals as correlated as these are noise; 1: not looked at
    double misfit = 0;     ///< largest RMS of what is left of a history or response, share of its largest value
    double inflation = 1;  ///< of deviations: for correlated residuals, or for noise larger than assumed
    std::vector<std::string> offsets = {};  ///< channels whose residuals have a mean
    bool can_be_judged = true;              ///< the noise is known, or there are samples enough to see a correlation
    bool is_noise_assumed = false;          ///< of some group: what is usual, nobody gave it
    /// Noise that would make chi2 what it should be, per noise that counts.
    double noise_factor() const { return freedom > 0 ? std::sqrt(chi2 / static_cast<double>(freedom)) : 1; }
    bool is_explained() const;
    /// Where nothing is left to judge by: chi2 is far beyond what as many data as there are would give.
    bool is_hopeless() const { return freedom <= 0 && is_noise_independent && chi2 > 4 * static_cast<double>(points) + 20; }
};

/// How well the values of a minimum explain the data.
Fit judge_fit(const Comparison& comparison, const Solution& solution);

}  // namespace dttmm::host
