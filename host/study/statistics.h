// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <span>
#include <vector>

namespace dttmm::host {

/// What a figure did over the cases that have it.
struct FigureStatistics {
    static constexpr std::array<double, 7> kShares = {0.01, 0.05, 0.25, 0.5, 0.75, 0.95, 0.99};
    size_t count = 0;
    // NaN where there is no number, the deviation where there is one only
    double mean = 0, deviation = 0;  ///< the latter of n − 1
    double minimum = 0, maximum = 0;
    std::array<double, 7> quantiles{};  ///< at kShares, linear between the numbers in order (Hyndman and Fan's type 7)
};

/// Numbers that are NaN do not count.
FigureStatistics compute_statistics(std::span<const double> values);

/// Pearson's coefficient of the pairs of which both are numbers; NaN where one of the two does not vary.
double compute_correlation(std::span<const double> x, std::span<const double> y);

/// Spearman's coefficient: that of the ranks among the pairs of which both are numbers.
double compute_rank_correlation(std::span<const double> x, std::span<const double> y);

/// The rank of each number among all, equal ones their mean; NaN has none.
std::vector<double> compute_ranks(std::span<const double> values);

}  // namespace dttmm::host
