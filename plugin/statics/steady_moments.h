// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Dense>
#include <span>
#include <vector>

#include "solve/elimination.h"

namespace dttmm::plugin {

/// Moments that keep their direction while their frame turns. They have no potential: turns about two world axes in turn
/// do work on them that hangs on which comes first. What balances M at a frame has the stiffness
///     K − ½ [M]×   by the turn of the frame,
/// K symmetric, [M]× the matrix of M × …: the second derivative of an energy by turns R ← exp([θ]×) R has the part
/// ½ [its gradient]× beside a symmetric one. Without it Newton's iteration multiplies motions across M by about
/// M L/(2 √(EI GJ)) each time, L the length of the bar at whose end M is: they grow from rounding.
///
/// The symmetric matrix stays factored; three columns per moment are added to its solutions (Sherman, Morrison, Woodbury).
class SteadyMoments {
public:
    using Vector3 = Eigen::Vector3d;

    /// Forgets them all.
    void clear();
    /// On a frame of the matrix, world axes [N m]; zero: none.
    void add(int frame, const Vector3& moment);
    /// Once the matrix is factored.
    void form(const Elimination& matrix, size_t frame_count);
    /// Solves as Elimination::solve, with these moments.
    void solve(const Elimination& matrix, std::span<Vector6> r, std::span<double> g) const;

private:
    struct Column {
        std::vector<Vector6> u;
        std::vector<double> q;
    };
    Eigen::VectorXd turns(std::span<const Vector6> u) const;

    std::vector<int> frames_;
    std::vector<Vector3> moments_;
    std::vector<Column> columns_;  ///< solutions for unit moments on these frames
    Eigen::MatrixXd answer_;       ///< (I + A C)⁻¹ A: A of all these moments, C the turns of the columns
};

}  // namespace dttmm::plugin
