// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "model/channel.h"
#include "record/column.h"

namespace dttmm::host {

/// Numbers that a run of a case leaves: "bolt*.force.z:peak,final" is the peak and the last value of channels.
///     peak       largest size                     time    instant of the peak [s]
///     minimum    maximum     final (last row)     mean    rms    over the rows, the first and the last counted half
/// Each is called <channel>.<statistic>. Rows come once; memory does not grow with them.
class HistoryFigures {
public:
    /// requests: as given to --figures; none: peak and final value of the forces of all elements. selection: the channels
    /// that rows have, ascending; none: all. Throws Error(usage) for a statistic that does not exist, Error(model_invalid)
    /// for a pattern without a channel and for a channel that rows do not have. `channels` must outlive this.
    HistoryFigures(const std::vector<std::string>& requests, std::span<const Channel> channels,
                   const std::optional<std::vector<int>>& selection);

    const std::vector<Column>& columns() const { return columns_; }
    /// The first number is the time.
    void take_row(std::span<const double> row);
    /// In the order of columns().
    std::vector<double> values() const;

private:
    enum class Statistic : unsigned char { peak, time, minimum, maximum, final, mean, rms };
    struct Figure {
        size_t watched;
        Statistic statistic;
    };
    /// A channel and what its rows were.
    struct Watched {
        int channel;
        size_t place;  ///< in a row
        double peak = 0, time = 0, minimum = 0, maximum = 0, final = 0;
        double sum = 0, squares = 0;  ///< the first row counted half
    };
    void add(int channel, Statistic statistic, const std::optional<std::vector<int>>& selection);
    double value(const Figure& figure) const;

    std::span<const Channel> channels_;
    std::vector<Figure> figures_;
    std::vector<Column> columns_;
    std::vector<Watched> watched_;
    long rows_ = 0;
};

/// Names that match one of the patterns; all where there is none. Throws Error(usage) for a pattern that matches nothing.
std::vector<size_t> choose_figures(const std::vector<std::string>& patterns, const std::vector<Column>& columns);

}  // namespace dttmm::host
