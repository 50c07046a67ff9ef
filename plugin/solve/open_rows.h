// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/index.h"
#include "solve/elimination_order.h"

namespace dttmm::plugin {

/// Rows of J, of rigid directions, in the hands of a pivot, as what has been eliminated before leaves them.
struct OpenRows {
    /// Rigid directions to look at in one block at most; the largest block with them.
    static constexpr int kMost = 18, kLargestBlock = 6 + kMost;
    using ByMotion = Eigen::Matrix<double, Eigen::Dynamic, 6, 0, kLargestBlock, 6>;
    using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kLargestBlock, 1>;
    using Among = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMost, kMost>;

    std::vector<int> rows;
    std::vector<ByMotion> by;  ///< motion of the frame at hand, or of each neighbour
    Among among;               ///< −(compliance between them)
    Column among_size;  ///< square root of the compliance each would have if nothing rigid were there: what of a row is
                        ///< far below it is rounding

    /// Collects the rows first met at this pivot and those its children passed on. Fills `by` for its frame and its
    /// neighbours.
    /// derivatives(row, end): by the motion of either end. passed_by(pivot): what one before has passed on. False if they
    /// are too many.
    template <class Derivatives, class PassedBy>
    bool gather(const EliminationOrder& order, const EliminationOrder::Pivot& pivot, const Derivatives& derivatives,
                const PassedBy& passed_by) {
        rows.assign(pivot.rigid.begin(), pivot.rigid.end());
        const auto own = as_row(pivot.rigid.size());
        Eigen::Index count = own;
        for (int child : pivot.children) {
            const OpenRows& passed = passed_by(order.pivots()[as_size(child)]);
            count += as_row(passed.rows.size());
            if (count > kMost) return false;
            rows.insert(rows.end(), passed.rows.begin(), passed.rows.end());
        }
        if (count > kMost) return false;
        among.setZero(count, count);
        among_size.setZero(count);
        for (size_t i = 0; i <= pivot.neighbours.size(); ++i) {
            const int frame = i == 0 ? pivot.frame : pivot.neighbours[i - 1].frame;
            by[i].setZero(count, 6);
            for (Eigen::Index k = 0; k < own; ++k) {
                const auto row = as_size(rows[as_size(k)]);
                for (int end : {0, 1})
                    if (order.rows()[row].frames[end] == frame) by[i].row(k) = derivatives(row, end).transpose();
            }
            Eigen::Index at = own;
            for (int c : pivot.children) {
                const EliminationOrder::Pivot& child = order.pivots()[as_size(c)];
                const OpenRows& passed = passed_by(child);
                const auto more = as_row(passed.rows.size());
                for (size_t k = 0; k < child.neighbours.size(); ++k) {
                    if (child.neighbours[k].frame == frame) by[i].middleRows(at, more) = passed.by[k];
                }
                if (i == 0) {
                    among.block(at, at, more, more) = passed.among;
                    among_size.segment(at, more) = passed.among_size;
                }
                at += more;
            }
        }
        return true;
    }
};

}  // namespace dttmm::plugin
