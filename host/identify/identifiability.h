// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "identify/unknowns.h"

namespace dttmm::host {

/// Cosine between the derivatives by two unknowns from which on the data change alike with both.
inline constexpr double kTied = 0.999;

/// What the data say of the unknowns near a minimum, and what they do not.
struct Identifiability {
    std::vector<bool> is_dead;              ///< nothing that was measured changes with it
    std::vector<Eigen::VectorXd> flat;      ///< combinations (norm 1) that the data do not fix
    std::vector<std::vector<size_t>> tied;  ///< classes: the data change alike with each of them
    Eigen::VectorXd deviations;             ///< of the coordinates; infinite: not fixed
    Eigen::MatrixXd covariance;             ///< of what is fixed
};

/// jacobian: of residuals divided by their deviation, by coordinates. held: unknowns at a bound, which count as known.
Identifiability judge_identifiability(const Eigen::MatrixXd& jacobian, const Unknowns& unknowns,
                                      const std::vector<bool>& held);

/// A combination in words: "k1 - k2", "0.8 k1 + 0.6 c1", of logarithms where the unknowns are.
std::string describe_combination(const Eigen::VectorXd& combination, const Unknowns& unknowns);

}  // namespace dttmm::host
