// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "identify/forked_map.h"

namespace dttmm::host {

/// Slopes from central differences of what changes smoothly with a parameter, as stiffness and mass do: at three distances,
/// each twice the one before, extrapolated to none (Neville's table of even errors).
struct SmallChanges {
    /// Of the parameter. Of a beam's length the stiffness changes by the cube: what three of them leave is 1e-14 of the
    /// derivative, and rounding of the smallest 1e-13 of the stiffness over it.
    static constexpr std::array kShares = {5e-4, 1e-3, 2e-3};

    /// results: of every parameter, the slopes of `count` figures at the first share, then at the others.
    SmallChanges(const std::vector<TaskResult>& results, size_t count);

    Eigen::MatrixXd slopes, errors;  ///< a row per figure, a column per parameter; errors: of the extrapolation
};

}  // namespace dttmm::host
