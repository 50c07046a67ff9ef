// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <utility>
#include <vector>

#include "identify/forked_map.h"

namespace dttmm::host {

/// Slope of a figure from two points as far on either side of the file's value.
struct SlopeAt {
    double mean;  ///< of the slopes towards both sides
    double bend;  ///< the size of their difference
    static SlopeAt of(double above, double middle, double below, double distance) {
        return {(above - below) / (2 * distance), std::abs(above - 2 * middle + below) / distance};
    }
};

constexpr int kSlopeLevels = 3;  // of extrapolation: what they leave is of sixth order in the distance

/// The slope at the file's value and its error, from distances each half the one before. Of Neville's table of even errors
/// each entry with the least change from the one before it counts. Of a smooth figure the
/// change of the mean falls to a quarter, and the bend to a half. Beside a jump or a kink no such table holds: the change
/// grows, or the bend stays.
std::pair<double, double> extrapolate(const std::array<SlopeAt, kSlopeLevels>& level);

/// Slopes from central differences of what changes smoothly with a parameter, as stiffness and mass do.
struct SmallChanges {
    /// Of the parameter. Of a beam's length the stiffness changes by the cube: what three of them leave is 1e-14 of the
    /// derivative, and rounding of the smallest 1e-13 of the stiffness over it.
    static constexpr std::array kShares = {2e-3, 1e-3, 5e-4};
    static_assert(kShares.size() == kSlopeLevels);

    /// results: of every parameter, mean and bend of `count` figures at the first share, then at the others.
    SmallChanges(const std::vector<TaskResult>& results, size_t count);

    Eigen::MatrixXd slopes, errors;  ///< a row per figure, a column per parameter; errors: of the extrapolation
};

}  // namespace dttmm::host
