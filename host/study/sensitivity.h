// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace dttmm::host {

/// A number with what 95 % of the resampled sets of blocks lie between (percentiles of 500 bootstrap samples).
struct WithErrors {
    double value = 0, low = 0, high = 0;
};

/// Shares of the variance of a figure that a parameter is behind: alone, and with all that it does together with others.
struct SobolIndices {
    WithErrors first, total;
    size_t blocks = 0;  ///< that count: all cases of them completed
};

/// One per parameter. values: of the cases of Design::indices; NaN: it did not complete.
/// Source: Jansen (1999), Computer Physics Communications 117, 35–43; estimators (b) and (f) of Saltelli et al. (2010).
std::vector<SobolIndices> compute_sobol_indices(std::span<const double> values, Eigen::Index parameters);

/// What half of a parameter's range does to a figure, in the figure's unit.
struct ElementaryEffects {
    WithErrors size;       ///< mean of the magnitudes (μ*)
    double mean = 0;       ///< with sign (μ)
    double deviation = 0;  ///< large against the size where the effect depends on the others or bends (σ)
    size_t walks = 0;
};

/// One per parameter. probabilities: of Design::morris, or any numbers that grow with them.
std::vector<ElementaryEffects> compute_elementary_effects(std::span<const double> values,
                                                          const Eigen::MatrixXd& probabilities);

/// A case of Design::single against the first one: what its one other parameter does.
struct SingleEffect {
    size_t row;
    Eigen::Index parameter;
    double change;  ///< of the figure; NaN: one of the two did not complete
};
std::vector<SingleEffect> compute_single_effects(std::span<const double> values, const Eigen::MatrixXd& parameters);

}  // namespace dttmm::host
