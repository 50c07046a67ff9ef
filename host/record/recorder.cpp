// SPDX-License-Identifier: BSD-3-Clause
#include "record/recorder.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/error.h"

namespace dttmm {

namespace {

std::vector<Channel> pick(const std::vector<Channel>& all, const std::vector<int>& selection) {
    std::vector<Channel> picked;
    for (const int index : selection) picked.push_back(all.at(static_cast<std::size_t>(index)));
    return picked;
}

}  // namespace

Recorder::Recorder(std::vector<Channel> all) : channels_(std::move(all)), statistics_(channels_.size()) {
    check_channels(channels_);
}

Recorder::Recorder(const ResultsFolder& folder, std::vector<Channel> all, std::vector<int> selection,
                   const Attributes& attributes)
    : Recorder(std::move(all)) {
    selection_ = std::move(selection);
    selected_values_.resize(selection_.size());
    const std::vector<Channel> picked = pick(channels_, selection_);
    csv_.emplace(folder.file("history.csv"), picked);
    hdf5_.emplace(folder.file("history.h5"), picked, attributes);
}

void Recorder::close_row(std::span<const double> values) {
    check_row(values);
    write_row(values);
    count_row(values);
}

void Recorder::check_row(std::span<const double> values) const {
    if (values.size() != channels_.size())
        throw Error(ExitCode::internal_error,
                    fmt::format("a row of {} values was closed for {} channels; this is a fault of "
                                "dttmm, please report it",
                                values.size(), channels_.size()));
    for (std::size_t i = 0; i < values.size(); ++i)
        if (!std::isfinite(values[i]))
            throw Error(
                ExitCode::internal_error,
                fmt::format("channel \"{}\" is {} at t = {} s; this should have been caught earlier: please report it",
                            channels_[i].name, values[i], values[0]));
}

void Recorder::write_row(std::span<const double> values) {
    if (!csv_) return;
    for (std::size_t i = 0; i < selection_.size(); ++i)
        selected_values_[i] = values[static_cast<std::size_t>(selection_[i])];
    csv_->write_row(selected_values_);
    hdf5_->write_row(selected_values_);
}

void Recorder::count_row(std::span<const double> values) {
    for (std::size_t i = 0; i < values.size(); ++i) {
        const double value = values[i];
        ChannelStatistics& s = statistics_[i];
        if (rows_ == 0) s = {std::abs(value), values[0], value, value, value};
        if (std::abs(value) > s.peak) {
            s.peak = std::abs(value);
            s.peak_time = values[0];
        }
        s.minimum = std::min(s.minimum, value);
        s.maximum = std::max(s.maximum, value);
        s.final = value;
    }
    ++rows_;
}

void Recorder::finish() {
    if (!csv_) return;
    csv_->finish();
    hdf5_->publish();
}

}  // namespace dttmm
