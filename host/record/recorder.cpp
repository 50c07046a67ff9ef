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

}  // namespace

Recorder::Recorder(std::span<const Channel> all) : channels_(all), statistics_(as_row(channels_.size())) { find_forces(); }

Recorder::Recorder(const ResultsFolder& folder, std::span<const Channel> all, std::vector<int> selection,
                   const Attributes& attributes, Rows rows)
    : channels_(all), selection_(std::move(selection)) {
    std::vector<Column> picked = pick(channels_, selection_);
    check_columns(picked);
    csv_.emplace(folder.file("history.csv"), picked);
    if (rows == Rows::estimated)
        for (std::size_t i = 1, count = picked.size(); i < count; ++i)
            picked.push_back({picked[i].name + ".error", picked[i].unit});
    selected_values_.resize(picked.size());
    hdf5_.emplace(folder.file("history.h5"), picked, attributes);
    statistics_ = Statistics(as_row(channels_.size()));  // last: HDF5 writes the attributes with several copies of them
    find_forces();
}

void Recorder::find_forces() {
    const auto is_force = [](const Channel& channel) { return channel.unit() == "N" && channel.by_default(); };
    forces_.reserve(as_size(std::ranges::count_if(channels_, is_force)));
    for (std::size_t c = 0; c < channels_.size(); ++c)
        if (is_force(channels_[c])) forces_.push_back({as_int(c)});
}

/// Those among the channels first … end − 1.
std::span<Recorder::Force> Recorder::forces(int first, int end) {
    const auto begin = std::ranges::lower_bound(forces_, first, {}, &Force::channel);
    return {begin, std::ranges::lower_bound(begin, forces_.end(), end, {}, &Force::channel)};
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
    count(0, values, values[0]);
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
    for (std::size_t i = 0; i < values.size(); ++i) count(as_size(selection_[i]), values.subspan(i, 1), values[0]);
    ++rows_;
}

void Recorder::adopt_unselected(const Recorder& other) {
    for (int i = 0; i < as_int(channels_.size()); ++i) {
        if (std::binary_search(selection_.begin(), selection_.end(), i)) continue;
        for (const auto kind : {&Statistics::peak_time, &Statistics::minimum, &Statistics::maximum, &Statistics::final})
            (statistics_.*kind)[i] = (other.statistics_.*kind)[i];
        for (Force& force : forces(i, i + 1)) {
            const Force& others = other.forces_[as_size(&force - forces_.data())];
            force.ripple = others.ripple;
            force.bend = others.bend;
        }
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
    const auto force = std::ranges::lower_bound(forces_, channel, {}, &Force::channel);
    const bool is_force = force != forces_.end() && force->channel == channel;
    return {std::max(std::abs(s.minimum[channel]), std::abs(s.maximum[channel])),
            s.peak_time[channel],
            s.minimum[channel],
            s.maximum[channel],
            s.final[channel],
            is_force ? force->ripple : 0,
            is_force ? force->bend : 0};
}

/// What the value of a force does to its ripple and bend, before it is in the statistics.
void Recorder::count_force(Force& force, double value) const {
    const double before = rows_ == 0 ? value : statistics_.final[force.channel];
    const double peak = std::max(-statistics_.minimum[force.channel], statistics_.maximum[force.channel]);
    if (rows_ >= 2 && std::abs(before) == peak)
        force.bend = static_cast<float>(std::abs(value - before - static_cast<double>(force.change)));
    if (std::abs(value) > peak) force.bend = 0;
    constexpr float kRows = 10;  // to look back
    // The smaller of the last two changes where they are opposite, else 0
    const auto now = static_cast<float>(value - before);
    const float opposite = std::max({std::min(now, -force.change), std::min(-now, force.change), 0.0F});
    force.alternation += (0.5F * opposite - force.alternation) * (1 / kRows);
    force.ripple = std::max(force.ripple, force.alternation);
    force.change = now;
}

/// What the values of channels from `first` on do to the statistics.
void Recorder::count(std::size_t first, std::span<const double> row, double time) {
    for (Force& force : forces(as_int(first), as_int(first + row.size())))
        count_force(force, row[as_size(force.channel) - first]);
    const auto of = [&](Eigen::ArrayXd& numbers) { return numbers.data() + first; };
    double *__restrict peak_time = of(statistics_.peak_time), *__restrict minimum = of(statistics_.minimum),
           *__restrict maximum = of(statistics_.maximum);
    const double* __restrict value = row.data();
    const std::size_t size = row.size();
    if (rows_ == 0) {
        std::fill_n(peak_time, size, time);
        std::copy_n(value, size, minimum);
        std::copy_n(value, size, maximum);
    }
    for (std::size_t i = 0; i < size; ++i) {                    // without a branch: several at a time
        const double peak = std::max(-minimum[i], maximum[i]);  // up to the row before
        peak_time[i] = std::abs(value[i]) > peak ? time : peak_time[i];
        minimum[i] = value[i] < minimum[i] ? value[i] : minimum[i];
        maximum[i] = value[i] > maximum[i] ? value[i] : maximum[i];
    }
    std::copy_n(value, size, of(statistics_.final));
}

void Recorder::finish() {
    if (!csv_) return;
    csv_->finish();
    hdf5_->publish();
}

}  // namespace dttmm::host
