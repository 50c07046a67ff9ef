// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Dense>
#include <span>
#include <vector>

#include "solve/elimination.h"

namespace dttmm::plugin {

/// Moments that keep their direction while their frame turns. They have no potential: their work in two turns about
/// different axes depends on the order of the turns. What balances such a moment M has the stiffness, by turns of the frame,
///     K − ½ [M]×,   [M]× v = M × v,
/// K symmetric. For turns R ← exp([θ]×) R the second derivative of an energy has a symmetric part and −½ [g]×, g its
/// gradient, here M: exp([a]×) exp([θ]×) = exp([a + θ + ½ a × θ + …]×). Without that part each iteration multiplies motions
/// across M by about M L/(2 √(EI GJ)), L the length of the bar that M bends: they grow from rounding.
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
