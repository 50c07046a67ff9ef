// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

namespace dttmm::host {

/// How the cases of a study are spread over the ranges of what varies.
enum class Design : unsigned char {
    latin,   ///< latin hypercube: of n cases each has a share of its own, 1/n, of every parameter
    sobol,   ///< Sobol sequence, shifted at random
    random,  ///< independent draws
    single,  ///< the file's values, then one parameter at a time at its 5 % and its 95 % quantile
};

/// By its name on the command line: "latin", "sobol", "random", "one-at-a-time". Throws Error(usage).
Design parse_design(const std::string& text);

/// Probabilities between 0 and 1, a row per case and a column per parameter. The same seed gives the same numbers on every
/// machine. Not for Design::single.
Eigen::MatrixXd make_probabilities(Design design, Eigen::Index cases, Eigen::Index parameters, std::uint64_t seed);

/// Reorders each column so that the ranks of the columns are correlated as `correlation` says, and each keeps its numbers:
/// by the normal scores of the columns, mixed by the factor of `correlation` (Gaussian copula). Source: Iman and Conover
/// (1982), Communications in Statistics, Simulation and Computation 11, 311–334. Throws Error(usage) where `correlation` is
/// not positive definite: its numbers contradict each other.
void correlate(Eigen::MatrixXd& probabilities, const Eigen::MatrixXd& correlation);

}  // namespace dttmm::host
