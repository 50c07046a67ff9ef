// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/channel.h"
#include "model/expression.h"
#include "record/column.h"

namespace dttmm::host {

/// Numbers that a run of a case leaves: "bolt*.force.z:peak,final" is the peak and the last value of channels.
///     peak       largest size                     time    instant of the peak [s]
///     minimum    maximum     final (last row)     mean    rms    over the rows, the first and the last counted half
/// Each is called <channel>.<statistic>. "lift = bolt1.force.z + bolt3.force.z: peak" is the same of a formula over
/// channels, called lift.peak. Rows come once; memory does not grow with them.
class HistoryFigures {
public:
    /// requests: as given to --figures; none: peak and final value of the forces of all elements. selection: the channels
    /// that rows have, ascending; none: all. Throws Error(usage) for a statistic that does not exist, Error(model_invalid)
    /// for a pattern without a channel and for a channel that rows do not have. `channels` must outlive this.
    HistoryFigures(const std::vector<std::string>& requests, std::span<const Channel> channels,
                   const std::optional<std::vector<int>>& selection);

    const std::vector<Column>& columns() const { return columns_; }
    enum class Statistic : unsigned char { peak, time, minimum, maximum, final, mean, rms };
    struct Figure {
        size_t watched;  ///< a channel or a formula, by its number
        Statistic statistic;
    };
    /// In the order of columns().
    const std::vector<Figure>& figures() const { return figures_; }
    /// Values of all channels and formulas that are watched, of one row.
    size_t watched_count() const { return watched_.size(); }
    void read(std::span<const double> row, std::span<double> values);
    /// Of the rows, the numbers that they are made of; with repetitions.
    std::vector<int> places() const;
    /// The first number is the time.
    void take_row(std::span<const double> row);
    /// In the order of columns().
    std::vector<double> values() const;
    /// The mean of so many rows, the first and the last counted half, from a sum to which the first has come half.
    template <class Sum>
    static Sum mean(const Sum& sum, const Sum& last, long rows) {
        if (rows < 2) return 2 * sum;
        return (sum - 0.5 * last) / static_cast<double>(rows - 1);
    }

private:
    /// A formula over numbers of a row.
    struct Formula {
        Formula(const std::string& text, std::span<const Channel> channels,
                const std::function<size_t(int channel)>& place_of);
        double value(std::span<const double> row);
        std::vector<size_t> places;
        std::vector<double> arguments;
        std::optional<Expression> expression;
        std::string unit;  ///< of the channels if they have one and are only added up or compared, else "SI"
    };
    /// A channel, or a formula, and what its rows were.
    struct Watched {
        std::string name, unit;
        size_t place = 0;  ///< in a row, of a channel
        std::unique_ptr<Formula> formula = nullptr;
        double value(std::span<const double> row) { return formula ? formula->value(row) : row[place]; }
        double peak = 0, time = 0, minimum = 0, maximum = 0, final = 0;
        double sum = 0, squares = 0;  ///< the first row counted half
        bool is_broken = false;       ///< a row had no finite number: then none of its figures has
    };
    void add_request(const std::string& request);
    size_t watch_channel(int channel);
    size_t place_of(int channel) const;
    void add(size_t watched, Statistic statistic);
    double value(const Figure& figure) const;

    std::span<const Channel> channels_;
    std::optional<std::vector<int>> selection_;
    std::vector<Figure> figures_;
    std::vector<Column> columns_;
    std::vector<Watched> watched_;
    long rows_ = 0;
};

/// Names that match one of the patterns; all where there is none. Throws Error(usage) for a pattern that matches nothing.
std::vector<size_t> choose_figures(const std::vector<std::string>& patterns, const std::vector<Column>& columns);

}  // namespace dttmm::host
