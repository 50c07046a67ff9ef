// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <vector>

#include "study/figures.h"

namespace dttmm::host {

/// Derivatives of figures of a history, in some directions, from the derivatives of its rows. Rows come once; memory does
/// not grow with them.
///
/// An extreme has the derivative of the history at the instant of the extreme, which lies between rows: a row stays where it
/// is, and a vibration that becomes faster passes it. So the cubic through four rows finds the instant, and another one the
/// derivative there; a parabola where there are three. A first or last row that is the extreme has its own derivative.
class FigureSlopes {
public:
    /// figures must outlive it.
    FigureSlopes(const HistoryFigures& figures, Eigen::Index directions);

    /// values: of what the figures watch; slopes: their derivatives, a row for each, a column per direction.
    void take_row(double time, std::span<const double> values, const Eigen::MatrixXd& slopes);

    /// Of a figure, a number per direction.
    struct Found {
        Eigen::RowVectorXd slope;
        Eigen::RowVectorXd error;  ///< error of the interpolation between rows, by the next term of its series
        /// Of the second largest extreme: its instant [s], its slope, and how far one has to go in a direction until it is
        /// the largest; infinite where there is none.
        double competing_time = 0;
        Eigen::RowVectorXd competing, reach;
    };
    Found find(size_t figure) const;

private:
    /// Of one channel or formula: a row.
    struct Point {
        double value = 0, time = 0;
        Eigen::RowVectorXd slope;
    };
    /// A row and those about it: an extreme.
    struct Extreme {
        std::array<Point, 4> rows;  ///< two before it, its own, one after it
        int before = 0;             ///< how many of those before there are; at an end only its own row counts
        bool has_after = false;
        double size = -std::numeric_limits<double>::infinity();
        std::optional<double> next = {};  ///< the value two rows after it

        bool is_between() const { return before > 0 && has_after && bend() != 0; }
        double bend() const { return rows[3].value - 2 * rows[2].value + rows[1].value; }
        bool is_kink() const;
        double place() const;  ///< by the parabola, from its own row, in rows
        struct Found {
            Eigen::RowVectorXd slope, of_time, error, error_of_time;
        };
        /// swing: half of what the history goes from its minimum to its maximum.
        Found find(double swing) const;
    };
    static Extreme at_end(const Point& outer, const std::array<Point, 3>& rows, double size);
    struct Two {
        Extreme largest, second;
        void take(const Extreme& extreme);
    };
    enum Kind : unsigned char { kPeak, kMinimum, kMaximum };
    static double size_of(Kind kind, double value);
    struct Watched {
        std::array<Two, 3> extremes;  ///< by Kind; without the last row
        Point second_last, before, last;
        Eigen::RowVectorXd sum, product;  ///< of slopes, and of value times slope; the first row counted half
        double squares = 0;               ///< of values
    };
    Two extremes(const Watched& of, Kind kind) const;

    const HistoryFigures& figures_;
    Eigen::Index directions_;
    std::vector<Watched> watched_;
    long rows_ = 0;
};

}  // namespace dttmm::host
