// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <string>

namespace dttmm::host {

/// How the cases of a study are spread over the ranges of what varies.
enum class Design : unsigned char {
    latin,    ///< latin hypercube: of n cases each has a share of its own, 1/n, of every parameter
    sobol,    ///< Sobol sequence, shifted at random
    random,   ///< independent draws
    single,   ///< the file's values, then one parameter at a time at its 5 % and its 95 % quantile
    morris,   ///< walks in which one parameter after the other goes up or down by half of its range: elementary effects
    indices,  ///< blocks for Sobol' indices of the variance
};

/// By its name on the command line: "latin", "sobol", "random", "one-at-a-time", "morris", "sobol-indices". Throws
/// Error(usage).
Design parse_design(const std::string& text);

/// Cases that belong together, next to each other: parameters + 1 of a walk of Morris, parameters + 2 of a block for Sobol'
/// indices (A, B, and A with one column of B after the other), else 1.
Eigen::Index block_size(Design design, Eigen::Index parameters);

/// Probabilities between 0 and 1, a row per case and a column per parameter; as many whole blocks as fit into `cases`. The
/// same seed gives the same numbers on every machine. Not for Design::single.
/// Sources: Morris (1991), Technometrics 33, 161–174, on the middles of four equal cells of each range. Saltelli et al.
/// (2010), Computer Physics Communications 181, 259–270.
Eigen::MatrixXd make_probabilities(Design design, Eigen::Index cases, Eigen::Index parameters, std::uint64_t seed);

/// Reorders each column so that the ranks of the columns are correlated as `correlation` says (Spearman's coefficient), and
/// each keeps its numbers: by the normal scores of the columns, mixed by the factor of their correlation 2 sin(π ρ/6)
/// (Gaussian copula). Sources: Iman and Conover (1982), Communications in Statistics, Simulation and Computation 11,
/// 311–334; Pearson (1907), On Further Methods of Determining Correlation. Throws Error(usage) where the matrix of the
/// normal scores is not positive definite: the numbers contradict each other.
void correlate(Eigen::MatrixXd& probabilities, const Eigen::MatrixXd& correlation);

}  // namespace dttmm::host
