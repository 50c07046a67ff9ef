// SPDX-License-Identifier: BSD-3-Clause
#include "record/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <ranges>
#include <utility>

#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

std::vector<Column> pick(std::span<const Channel> all, const std::vector<int>& selection) {
    std::vector<Column> picked;
    for (const int index : selection) picked.push_back({all[as_size(index)].name(), all[as_size(index)].unit()});
    return picked;
}

float to_float(double value) {
    constexpr double kMost = std::numeric_limits<float>::max();
    return static_cast<float>(std::clamp(value, -kMost, kMost));
}

}  // namespace

Recorder::Recorder(std::span<const Channel> all, CountsOf counts_of) : channels_(all) { find_counted(counts_of); }

Recorder::Recorder(const ResultsFolder& folder, std::span<const Channel> all, std::vector<int> selection,
                   const Attributes& attributes, Rows rows, CountsOf counts_of)
    : channels_(all), selection_(std::move(selection)) {
    std::vector<Column> picked = pick(channels_, selection_);
    check_columns(picked);
    csv_.emplace(folder.file("history.csv"), picked);
    if (rows == Rows::estimated)
        for (std::size_t i = 1, count = picked.size(); i < count; ++i)
            picked.push_back({picked[i].name + ".error", picked[i].unit});
    selected_values_.resize(picked.size());
    hdf5_.emplace(folder.file("history.h5"), picked, attributes);
    find_counted(counts_of);  // last: HDF5 writes the attributes with several copies of them
}

void Recorder::find_counted(CountsOf counts_of) {
    const auto alternates = [&](int c) {
        const Channel& channel = channels_[as_size(c)];
        return (channel.unit() == "N" || channel.unit() == "m/s^2") && channel.by_default();
    };
    const auto counts = [&](int c) { return counts_of(channels_[as_size(c)]) != Counts::nothing; };
    const auto has_extremes = [&](int c) { return counts_of(channels_[as_size(c)]) == Counts::extremes; };
    const auto all = std::views::iota(0, as_int(channels_.size()));
    counted_.reserve(as_size(std::ranges::count_if(all, counts)));
    for (const bool first : {true, false}) {
        for (const int c : all)
            if (counts(c) && alternates(c) == first) counted_.push_back(c);
        if (first) alternations_.resize(counted_.size());
    }
    extremes_.reserve(as_size(std::ranges::count_if(counted_, has_extremes)));
    for (int i = 0; i < as_int(counted_.size()); ++i)
        if (has_extremes(counted_[as_size(i)])) extremes_.push_back(i);
    for (const int channel : selection_) selected_counted_.push_back(find_statistics(channel));
    statistics_ = Statistics(as_row(counted_.size()), as_row(extremes_.size()));
}

/// Where a channel's statistics stand; −1: it has none.
int Recorder::find_statistics(int channel) const {
    const auto end_of_first = counted_.begin() + as_row(alternations_.size());
    for (const auto& [begin, end] : {std::pair(counted_.begin(), end_of_first), std::pair(end_of_first, counted_.end())})
        if (const auto found = std::lower_bound(begin, end, channel); found != end && *found == channel)
            return as_int(found - counted_.begin());
    return -1;
}

/// Where its minimum and maximum stand; −1: it has none.
int Recorder::find_extremes(int counted) const {
    const auto found = std::ranges::lower_bound(extremes_, counted);
    return found != extremes_.end() && *found == counted ? as_int(found - extremes_.begin()) : -1;
}

void Recorder::close_row(std::span<const double> values) {
    if (values.size() != channels_.size())
        throw Error(ExitCode::internal_error,
                    fmt::format("a row of {} values was closed for {} channels; this is a fault of "
                                "dttmm, please report it",
                                values.size(), channels_.size()));
    bool is_finite = true;
    for (const double value : values) is_finite &= std::abs(value) <= std::numeric_limits<double>::max();
    for (std::size_t i = 0; !is_finite && i < values.size(); ++i) check_finite(as_int(i), values[i], values[0]);
    if (csv_) {
        for (std::size_t i = 0; i < selection_.size(); ++i) selected_values_[i] = values[as_size(selection_[i])];
        csv_->write_row(selected_values_);
        hdf5_->write_row(selected_values_);
    }
    count(
        0, as_int(counted_.size()), [&](int i) { return values[as_size(counted_[as_size(i)])]; }, values[0]);
    ++rows_;
}

void Recorder::close_selected_row(std::span<const double> values, std::span<const double> errors) {
    assert(values.size() == selection_.size());
    for (std::size_t i = 0; i < values.size(); ++i) check_finite(selection_[i], values[i], values[0]);
    for (std::size_t i = 0; i < errors.size(); ++i) check_finite(selection_[i], errors[i], values[0]);
    const auto rest = std::copy(values.begin(), values.end(), selected_values_.begin());
    if (!errors.empty()) std::copy(errors.begin() + 1, errors.end(), rest);
    assert(selected_values_.size() == values.size() + (errors.empty() ? 0 : errors.size() - 1));
    csv_->write_row(values);
    hdf5_->write_row(selected_values_);
    for (std::size_t i = 0; i < values.size(); ++i)
        if (const int at = selected_counted_[i]; at >= 0)
            count(
                at, at + 1, [&](int) { return values[i]; }, values[0]);
    ++rows_;
}

void Recorder::adopt_unselected(const Recorder& other) {
    assert(counted_ == other.counted_ && extremes_ == other.extremes_);
    for (int i = 0; i < as_int(counted_.size()); ++i) {
        if (std::ranges::binary_search(selection_, counted_[as_size(i)])) continue;
        for (const auto kind : {&Statistics::peak, &Statistics::peak_time, &Statistics::final})
            (statistics_.*kind)[i] = (other.statistics_.*kind)[i];
        if (const int at = find_extremes(i); at >= 0)
            for (const auto kind : {&Statistics::minimum, &Statistics::maximum})
                (statistics_.*kind)[at] = (other.statistics_.*kind)[at];
        if (alternates(i)) alternations_[as_size(i)] = other.alternations_[as_size(i)];
    }
}

void Recorder::check_finite(int channel, double value, double time) const {
    if (!std::isfinite(value))
        throw Error(ExitCode::internal_error,
                    fmt::format("channel \"{}\" is {} at t = {} s; this should have been caught earlier: please report it",
                                channels_[as_size(channel)].name(), value, time));
}

ChannelStatistics Recorder::statistics(int channel) const {
    const Statistics& s = statistics_;
    const int i = find_statistics(channel);
    if (i < 0)
        throw Error(ExitCode::internal_error,
                    fmt::format("channel \"{}\" has no statistics; this is a fault of dttmm, please report it",
                                channels_[as_size(channel)].name()));
    ChannelStatistics statistics{s.peak[i], s.peak_time[i], 0, 0, s.final[i]};
    if (const int at = find_extremes(i); at >= 0) statistics.minimum = s.minimum[at], statistics.maximum = s.maximum[at];
    if (alternates(i)) {
        const Alternation& one = alternations_[as_size(i)];
        statistics.ripple = one.ripple, statistics.ripple_final = one.mean, statistics.bend = one.bend;
    }
    return statistics;
}

/// What a value does to the ripple and bend of its channel, before it is in the statistics.
inline void Recorder::count_alternation(int counted, double value) {
    if (rows_ == 0) return;
    Alternation& one = alternations_[as_size(counted)];
    const double before = statistics_.final[counted], peak = statistics_.peak[counted];
    const float change = to_float(value - before);
    if (rows_ >= 2 && std::abs(before) == peak) one.bend = std::abs(change - one.change);
    if (std::abs(value) > peak) one.bend = 0;
    constexpr float kRows = 10;  // to look back
    // The smaller of the last two changes where they are opposite, else 0
    const float opposite = change * one.change < 0 ? std::min(std::abs(change), std::abs(one.change)) : 0.0F;
    one.mean += (0.5F * opposite - one.mean) * (1 / kRows);
    one.ripple = std::max(one.ripple, one.mean);
    one.change = change;
}

/// What the values of the counted channels first … end − 1 do to the statistics.
template <class ValueOf>
void Recorder::count(int first, int end, const ValueOf& value_of, double time) {
    for (int i = first; i < std::min(end, as_int(alternations_.size())); ++i) count_alternation(i, value_of(i));
    double *__restrict value = statistics_.final.data(), *__restrict peak_time = statistics_.peak_time.data(),
           *__restrict peak = statistics_.peak.data();
    for (int i = first; i < end; ++i) value[i] = value_of(i);
    if (rows_ == 0) {
        std::fill(peak_time + first, peak_time + end, time);
        for (int i = first; i < end; ++i) peak[i] = std::abs(value[i]);
    }
    for (int i = first; i < end; ++i) {  // without a branch: several at a time
        const double size = std::abs(value[i]);
        peak_time[i] = size > peak[i] ? time : peak_time[i];
        peak[i] = size > peak[i] ? size : peak[i];
    }
    const auto from = std::ranges::lower_bound(extremes_, first), to = std::lower_bound(from, extremes_.end(), end);
    for (auto at = from; at != to; ++at) {
        double &least = statistics_.minimum[at - extremes_.begin()], &most = statistics_.maximum[at - extremes_.begin()];
        least = rows_ == 0 ? value[*at] : std::min(least, value[*at]);
        most = rows_ == 0 ? value[*at] : std::max(most, value[*at]);
    }
}

void Recorder::finish() {
    if (!csv_) return;
    csv_->finish();
    hdf5_->publish();
}

}  // namespace dttmm::host
