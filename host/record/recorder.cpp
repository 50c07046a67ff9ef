// SPDX-License-Identifier: BSD-3-Clause
#include "record/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
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

Recorder::Recorder(std::span<const Channel> all, HasStatistics has_statistics) : channels_(all) {
    find_counted(has_statistics);
}

Recorder::Recorder(const ResultsFolder& folder, std::span<const Channel> all, std::vector<int> selection,
                   const Attributes& attributes, Rows rows, HasStatistics has_statistics)
    : channels_(all), selection_(std::move(selection)) {
    std::vector<Column> picked = pick(channels_, selection_);
    check_columns(picked);
    csv_.emplace(folder.file("history.csv"), picked);
    if (rows == Rows::estimated)
        for (std::size_t i = 1, count = picked.size(); i < count; ++i)
            picked.push_back({picked[i].name + ".error", picked[i].unit});
    selected_values_.resize(picked.size());
    hdf5_.emplace(folder.file("history.h5"), picked, attributes);
    find_counted(has_statistics);  // last: HDF5 writes the attributes with several copies of them
}

void Recorder::find_counted(HasStatistics has_statistics) {
    const auto alternates = [&](int c) {
        const Channel& channel = channels_[as_size(c)];
        return (channel.unit() == "N" || channel.unit() == "m/s^2") && channel.by_default();
    };
    counted_.reserve(as_size(std::ranges::count_if(channels_, has_statistics)));
    for (int c = 0; c < as_int(channels_.size()); ++c)
        if (has_statistics(channels_[as_size(c)])) counted_.push_back(c);
    alternations_.reserve(as_size(std::ranges::count_if(counted_, alternates)));
    for (int i = 0; i < as_int(counted_.size()); ++i)
        if (alternates(counted_[as_size(i)])) alternations_.push_back({i});
    for (const int channel : selection_) selected_counted_.push_back(find_statistics(channel));
    statistics_ = Statistics(as_row(counted_.size()));
}

/// Where a channel's statistics stand; −1: it has none.
int Recorder::find_statistics(int channel) const {
    const auto found = std::ranges::lower_bound(counted_, channel);
    return found != counted_.end() && *found == channel ? as_int(found - counted_.begin()) : -1;
}

/// Those among the counted channels first … end − 1.
std::span<Recorder::Alternation> Recorder::alternations(int first, int end) {
    const auto begin = std::ranges::lower_bound(alternations_, first, {}, &Alternation::counted);
    return {begin, std::ranges::lower_bound(begin, alternations_.end(), end, {}, &Alternation::counted)};
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
    assert(counted_ == other.counted_);
    for (int i = 0; i < as_int(counted_.size()); ++i) {
        if (std::ranges::binary_search(selection_, counted_[as_size(i)])) continue;
        for (const auto kind : {&Statistics::peak_time, &Statistics::minimum, &Statistics::maximum, &Statistics::final})
            (statistics_.*kind)[i] = (other.statistics_.*kind)[i];
        for (Alternation& one : alternations(i, i + 1)) one = other.alternations_[as_size(&one - alternations_.data())];
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
    const auto one = std::ranges::lower_bound(alternations_, i, {}, &Alternation::counted);
    const bool is_followed = one != alternations_.end() && one->counted == i;
    return {std::max(std::abs(s.minimum[i]), std::abs(s.maximum[i])),
            s.peak_time[i],
            s.minimum[i],
            s.maximum[i],
            s.final[i],
            is_followed ? one->ripple : 0,
            is_followed ? one->mean : 0,
            is_followed ? one->bend : 0};
}

/// What a value does to the ripple and bend of its channel, before it is in the statistics.
inline void Recorder::count_alternation(Alternation& one, double value) const {
    if (rows_ == 0) return;
    const double before = statistics_.final[one.counted];
    const double peak = std::max(-statistics_.minimum[one.counted], statistics_.maximum[one.counted]);
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
    for (Alternation& one : alternations(first, end)) count_alternation(one, value_of(one.counted));
    double *__restrict value = statistics_.final.data(), *__restrict peak_time = statistics_.peak_time.data(),
           *__restrict minimum = statistics_.minimum.data(), *__restrict maximum = statistics_.maximum.data();
    for (int i = first; i < end; ++i) value[i] = value_of(i);
    if (rows_ == 0) {
        std::fill(peak_time + first, peak_time + end, time);
        std::copy(value + first, value + end, minimum + first);
        std::copy(value + first, value + end, maximum + first);
    }
    for (int i = first; i < end; ++i) {                         // without a branch: several at a time
        const double peak = std::max(-minimum[i], maximum[i]);  // up to the row before
        peak_time[i] = std::abs(value[i]) > peak ? time : peak_time[i];
        minimum[i] = value[i] < minimum[i] ? value[i] : minimum[i];
        maximum[i] = value[i] > maximum[i] ? value[i] : maximum[i];
    }
}

void Recorder::finish() {
    if (!csv_) return;
    csv_->finish();
    hdf5_->publish();
}

}  // namespace dttmm::host
