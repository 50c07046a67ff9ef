// SPDX-License-Identifier: BSD-3-Clause
#include "identify/figure_slopes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "model/index.h"

namespace dttmm::host {

namespace {

/// Third difference over the second at an extreme: 1 at a kink, as where a stop is hit, which no parabola follows; at most
/// 0.4 of a vibration with a dozen rows a period. The row's own derivative is then the answer, and a doubtful one.
constexpr double kKink = 0.6;

}  // namespace

FigureSlopes::FigureSlopes(const HistoryFigures& figures, Eigen::Index directions)
    : figures_(figures), directions_(directions), watched_(figures.watched_count()) {
    for (Watched& one : watched_) one.sum = one.product = Eigen::RowVectorXd::Zero(directions);
}

double FigureSlopes::Extreme::place() const { return -0.5 * (rows[3].value - rows[1].value) / bend(); }

/// By the third difference on either side.
bool FigureSlopes::Extreme::is_kink() const {
    const auto is_large = [&](double third) { return std::abs(third) > kKink * std::abs(bend()); };
    const double rise = rows[3].value - rows[2].value, before_it = rows[2].value - rows[1].value;
    return (before > 1 && is_large(bend() - (before_it - (rows[1].value - rows[0].value)))) ||
           (next && is_large(*next - rows[3].value - rise - bend()));
}

FigureSlopes::Extreme::Found FigureSlopes::Extreme::find(double swing) const {
    const Eigen::RowVectorXd none = Eigen::RowVectorXd::Zero(rows[2].slope.size());
    if (!is_between()) return {rows[2].slope, none, none, none};
    // The parabola about the row: y(x) = y + x rise + x²/2 bend, x in rows
    const double x = place(), row_step = rows[3].time - rows[2].time;
    const Eigen::RowVectorXd rise = 0.5 * (rows[3].slope - rows[1].slope),
                             slope_bend = rows[3].slope - 2 * rows[2].slope + rows[1].slope,
                             way = rise + x * slope_bend;  // ∂(slope)/∂x there
    // The cubic adds x (x² − 1)/6 of the third difference, which moves the extreme
    const double bent = std::abs(bend()), turn = std::sqrt(bent / std::max(bent, swing));  // ω row_step
    const double cube = x * (x * x - 1) / 6, moves = -(3 * x * x - 1) / (6 * bend());
    Eigen::RowVectorXd correction = none;
    const double third = before > 1 ? rows[3].value - 3 * rows[2].value + 3 * rows[1].value - rows[0].value : turn * bent;
    if (before > 1) {
        const Eigen::RowVectorXd of_slope = rows[3].slope - 3 * rows[2].slope + 3 * rows[1].slope - rows[0].slope;
        correction = cube * of_slope + moves * third * way;
    }
    // As large as the cubic's part, where there is one, and the fourth difference, which is turn² of the second
    Eigen::RowVectorXd error = turn * turn * (way.cwiseAbs() / 12 + slope_bend.cwiseAbs() / 24);
    error += before > 1 ? Eigen::RowVectorXd(correction.cwiseAbs())
                        : Eigen::RowVectorXd(turn * (std::abs(cube) * slope_bend.cwiseAbs() + way.cwiseAbs() / 6));
    const Eigen::RowVectorXd slope = rows[2].slope + x * rise + 0.5 * x * x * slope_bend + correction;
    const Eigen::RowVectorXd of_time = -row_step / bend() * way;
    if (is_kink()) return {rows[2].slope, none, (slope - rows[2].slope).cwiseAbs(), of_time.cwiseAbs()};
    return {slope, of_time, error, (turn * turn + std::abs(third) / bent) * of_time.cwiseAbs()};
}

/// Of three rows at an end of the history, whose outer row is the largest: with the middle one where the parabola has its
/// extreme between the two, else with the outer one, which stays where it is.
FigureSlopes::Extreme FigureSlopes::at_end(const Point& outer, const std::array<Point, 3>& rows, double size) {
    Extreme extreme{{Point{}, rows[0], rows[1], rows[2]}, 1, true, size};
    const double x = extreme.is_between() ? extreme.place() : 1;
    if (x * (outer.time - rows[1].time) > 0 && std::abs(x) < 1) return extreme;
    return {{Point{}, Point{}, outer, Point{}}, 0, false, size};
}

void FigureSlopes::Two::take(const Extreme& extreme) {
    if (extreme.size > largest.size)
        second = std::exchange(largest, extreme);
    else if (extreme.size > second.size)
        second = extreme;
}

double FigureSlopes::size_of(Kind kind, double value) {
    return kind == kPeak ? std::abs(value) : kind == kMinimum ? -value : value;
}

void FigureSlopes::take_row(double time, std::span<const double> values, const Eigen::MatrixXd& slopes) {
    const double weight = rows_ == 0 ? 0.5 : 1;
    for (size_t w = 0; w < watched_.size(); ++w) {
        Watched& one = watched_[w];
        const Point row{values[w], time, slopes.row(as_row(w))};
        for (const Kind kind : {kPeak, kMinimum, kMaximum}) {
            const double before = size_of(kind, one.before.value), size = size_of(kind, one.last.value);
            for (Extreme* extreme : {&one.extremes[kind].largest, &one.extremes[kind].second})
                if (rows_ > 2 && extreme->is_between() && extreme->rows[3].time == one.last.time) extreme->next = row.value;
            if (rows_ == 2 && before > size)
                one.extremes[kind].take(at_end(one.before, {one.before, one.last, row}, before));
            if (rows_ > 1 && size > size_of(kind, row.value) && size >= before)
                one.extremes[kind].take(
                    {{one.second_last, one.before, one.last, row}, as_int(std::min(rows_ - 1, 2L)), true, size});
        }
        one.sum += weight * row.slope;
        one.product += weight * row.value * row.slope;
        one.squares += weight * row.value * row.value;
        one.second_last = std::exchange(one.before, std::exchange(one.last, row));
    }
    ++rows_;
}

/// With the last row, if that is one; of a history of one or two rows with all of them.
FigureSlopes::Two FigureSlopes::extremes(const Watched& of, Kind kind) const {
    Two two = of.extremes[kind];
    const double size = size_of(kind, of.last.value), before = size_of(kind, of.before.value);
    const auto alone = [](const Point& row, double of_row) {
        return Extreme{{Point{}, Point{}, row, Point{}}, 0, false, of_row};
    };
    if (rows_ > 2 && size >= before) two.take(at_end(of.last, {of.second_last, of.before, of.last}, size));
    if (rows_ == 2 && before > size) two.take(alone(of.before, before));
    if (rows_ == 1 || (rows_ == 2 && size >= before)) two.take(alone(of.last, size));
    return two;
}

FigureSlopes::Found FigureSlopes::find(size_t figure) const {
    using Statistic = HistoryFigures::Statistic;
    const auto& [watched, statistic] = figures_.figures()[figure];
    const Watched& one = watched_[watched];
    Found found;
    found.error = found.competing = Eigen::RowVectorXd::Zero(directions_);
    found.reach = Eigen::RowVectorXd::Constant(directions_, std::numeric_limits<double>::infinity());
    if (statistic == Statistic::final) {
        found.slope = one.last.slope;
    } else if (statistic == Statistic::mean) {
        found.slope = HistoryFigures::mean(one.sum, one.last.slope, rows_);
    } else if (statistic == Statistic::rms) {
        const double last = one.last.value, square = HistoryFigures::mean(one.squares, last * last, rows_);
        found.slope = HistoryFigures::mean(one.product, Eigen::RowVectorXd(last * one.last.slope), rows_);
        found.slope /= std::sqrt(square);  // of nothing at all there is none: not a number
    } else {
        const Kind kind = statistic == Statistic::minimum ? kMinimum : statistic == Statistic::maximum ? kMaximum : kPeak;
        const auto [largest, second] = extremes(one, kind);
        const bool is_time = statistic == Statistic::time;
        const double sign = kind == kPeak && largest.rows[2].value < 0 ? -1 : 1,
                     other_sign = kind == kPeak && second.rows[2].value < 0 ? -1 : 1;
        const double swing = 0.5 * (extremes(one, kMaximum).largest.size + extremes(one, kMinimum).largest.size);
        const Extreme::Found own = largest.find(swing);
        found.slope = is_time ? own.of_time : Eigen::RowVectorXd(sign * own.slope);
        if (kind == kPeak && largest.size == 0) found.slope.setConstant(std::numeric_limits<double>::quiet_NaN());
        found.error = is_time ? own.error_of_time : own.error;
        if (std::isfinite(second.size)) {
            const Extreme::Found other = second.find(swing);
            found.competing_time = second.rows[2].time;
            found.competing = is_time ? other.of_time : Eigen::RowVectorXd(other_sign * other.slope);
            const Eigen::RowVectorXd nearer = (other_sign * other.slope - sign * own.slope).cwiseAbs();
            for (Eigen::Index d = 0; d < directions_; ++d)
                if (nearer(d) > 0) found.reach(d) = (largest.size - second.size) / nearer(d);
        }
    }
    return found;
}

}  // namespace dttmm::host
