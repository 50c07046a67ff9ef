// SPDX-License-Identifier: BSD-3-Clause
#include "record/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "model/error.h"

namespace dttmm {

namespace {

std::vector<Channel> pick(std::span<const Channel> all, const std::vector<int>& selection) {
    std::vector<Channel> picked;
    for (const int index : selection) picked.push_back(all[static_cast<std::size_t>(index)]);
    return picked;
}

}  // namespace

Recorder::Recorder(std::span<const Channel> all)
    : channels_(all), statistics_(channels_.size()), alternations_(channels_.size()) {
    check_channels(channels_);
}

Recorder::Recorder(const ResultsFolder& folder, std::span<const Channel> all, std::vector<int> selection,
                   const Attributes& attributes, Rows rows)
    : Recorder(all) {
    selection_ = std::move(selection);
    std::vector<Channel> picked = pick(channels_, selection_);
    csv_.emplace(folder.file("history.csv"), picked);
    if (rows == Rows::estimated)
        for (std::size_t i = 1, count = picked.size(); i < count; ++i)
            picked.push_back({picked[i].name + ".error", picked[i].unit});
    selected_values_.resize(picked.size());
    hdf5_.emplace(folder.file("history.h5"), picked, attributes);
}

void Recorder::close_row(std::span<const double> values) {
    if (values.size() != channels_.size())
        throw Error(ExitCode::internal_error,
                    fmt::format("a row of {} values was closed for {} channels; this is a fault of "
                                "dttmm, please report it",
                                values.size(), channels_.size()));
    for (std::size_t i = 0; i < values.size(); ++i) check_finite(static_cast<int>(i), values[i], values[0]);
    if (csv_) {
        for (std::size_t i = 0; i < selection_.size(); ++i)
            selected_values_[i] = values[static_cast<std::size_t>(selection_[i])];
        csv_->write_row(selected_values_);
        hdf5_->write_row(selected_values_);
    }
    for (std::size_t i = 0; i < values.size(); ++i) count(static_cast<int>(i), values[i], values[0]);
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
    for (std::size_t i = 0; i < values.size(); ++i) count(selection_[i], values[i], values[0]);
    ++rows_;
}

void Recorder::adopt_unselected(const Recorder& other) {
    for (std::size_t i = 0; i < channels_.size(); ++i)
        if (!std::binary_search(selection_.begin(), selection_.end(), static_cast<int>(i)))
            statistics_[i] = other.statistics_[i];
}

void Recorder::check_finite(int channel, double value, double time) const {
    if (!std::isfinite(value))
        throw Error(ExitCode::internal_error,
                    fmt::format("channel \"{}\" is {} at t = {} s; this should have been caught earlier: please report it",
                                channels_[static_cast<std::size_t>(channel)].name, value, time));
}

void Recorder::count(int channel, double value, double time) {
    ChannelStatistics& s = statistics_[static_cast<std::size_t>(channel)];
    if (rows_ == 0) s = {std::abs(value), time, value, value, value, 0};
    if (std::abs(value) > s.peak) {
        s.peak = std::abs(value);
        s.peak_time = time;
    }
    s.minimum = std::min(s.minimum, value);
    s.maximum = std::max(s.maximum, value);
    constexpr double kRows = 10;  // to look back
    Alternation& a = alternations_[static_cast<std::size_t>(channel)];
    const double change = value - s.final;
    const double alternating = change * a.change < 0 ? 0.5 * std::min(std::abs(change), std::abs(a.change)) : 0;
    a = {change, a.mean + (alternating - a.mean) / kRows};
    s.ripple = std::max(s.ripple, a.mean);
    s.final = value;
}

void Recorder::finish() {
    if (!csv_) return;
    csv_->finish();
    hdf5_->publish();
}

}  // namespace dttmm
