// SPDX-License-Identifier: BSD-3-Clause
#include "study/figures.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cmath>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/channels.h"

namespace dttmm::host {

namespace {

std::vector<std::string> split_list(const std::string& text) {
    std::vector<std::string> parts;
    for (size_t begin = 0; begin <= text.size();) {
        const size_t comma = std::min(text.find(',', begin), text.size());
        parts.push_back(text.substr(begin, comma - begin));
        std::erase(parts.back(), ' ');
        begin = comma + 1;
    }
    return parts;
}

/// In the order of HistoryFigures::Statistic.
const std::vector<std::string> kStatistics = {"peak", "time", "minimum", "maximum", "final", "mean", "rms"};

size_t find_statistic(const std::string& name, const std::string& request) {
    const auto found = std::ranges::find(kStatistics, name);
    if (found == kStatistics.end())
        throw Error(ExitCode::usage, fmt::format("--figures {}: there is no statistic {}{}", quote(request), quote(name),
                                                 suggestion(name, kStatistics)));
    return as_size(found - kStatistics.begin());
}

}  // namespace

HistoryFigures::HistoryFigures(const std::vector<std::string>& requests, std::span<const Channel> channels,
                               const std::optional<std::vector<int>>& selection)
    : channels_(channels) {
    const std::vector<Channel> all(channels.begin(), channels.end());
    for (const std::string& request : requests) {
        const size_t colon = request.rfind(':');
        const std::string names = colon == std::string::npos ? "peak,final" : request.substr(colon + 1);
        std::vector<Statistic> statistics;
        for (const std::string& name : split_list(names))
            statistics.push_back(static_cast<Statistic>(find_statistic(name, request)));
        for (const int channel : select_channels(all, {request.substr(0, colon)}))
            if (channel > 0)
                for (const Statistic statistic : statistics) add(channel, statistic, selection);
    }
    if (!requests.empty()) return;
    for (int c = 1; c < as_int(channels.size()); ++c) {
        const Channel& channel = channels[as_size(c)];
        if (channel.of() != Channel::Of::element || channel.quantity() != "force" || !channel.by_default()) continue;
        add(c, Statistic::peak, selection);
        add(c, Statistic::final, selection);
    }
}

void HistoryFigures::add(int channel, Statistic statistic, const std::optional<std::vector<int>>& selection) {
    const Channel& of = channels_[as_size(channel)];
    const auto known = std::ranges::find(watched_, channel, &Watched::channel);
    const size_t watched = as_size(known - watched_.begin());
    if (known == watched_.end()) {
        size_t place = as_size(channel);
        if (selection) {
            const auto found = std::ranges::find(*selection, channel);
            if (found == selection->end())
                throw Error(
                    ExitCode::model_invalid,
                    fmt::format("--figures: a run to a tolerance has rows of the channels that it records, and {} is "
                                "none of them: add it to channels of [output], or give a step",
                                quote(of.name())));
            place = as_size(found - selection->begin());
        }
        watched_.push_back({channel, place});
    }
    const auto is_same = [&](const Figure& one) { return one.watched == watched && one.statistic == statistic; };
    if (std::ranges::any_of(figures_, is_same)) return;
    figures_.push_back({watched, statistic});
    columns_.push_back({fmt::format("{}.{}", of.name(), kStatistics[static_cast<size_t>(statistic)]),
                        statistic == Statistic::time ? "s" : of.unit()});
}

void HistoryFigures::take_row(std::span<const double> row) {
    const bool is_first = rows_++ == 0;
    for (Watched& one : watched_) {
        const double value = row[one.place];
        if (is_first || std::abs(value) > one.peak) {
            one.peak = std::abs(value);
            one.time = row[0];
        }
        one.minimum = is_first ? value : std::min(one.minimum, value);
        one.maximum = is_first ? value : std::max(one.maximum, value);
        one.final = value;
        one.sum += (is_first ? 0.5 : 1) * value;
        one.squares += (is_first ? 0.5 : 1) * value * value;
    }
}

double HistoryFigures::value(const Figure& figure) const {
    const Watched& one = watched_[figure.watched];
    // The last row counts half as the first does
    const auto mean = [&](double sum, double last) {
        return rows_ > 1 ? (sum - 0.5 * last) / static_cast<double>(rows_ - 1) : 2 * sum;
    };
    switch (figure.statistic) {
        case Statistic::peak:
            return one.peak;
        case Statistic::time:
            return one.time;
        case Statistic::minimum:
            return one.minimum;
        case Statistic::maximum:
            return one.maximum;
        case Statistic::final:
            return one.final;
        case Statistic::mean:
            return mean(one.sum, one.final);
        case Statistic::rms:
            break;
    }
    return std::sqrt(mean(one.squares, one.final * one.final));
}

std::vector<double> HistoryFigures::values() const {
    std::vector<double> all;
    for (const Figure& figure : figures_) all.push_back(value(figure));
    return all;
}

std::vector<size_t> choose_figures(const std::vector<std::string>& patterns, const std::vector<Column>& columns) {
    std::vector<size_t> chosen;
    std::vector<bool> is_chosen(columns.size(), patterns.empty());
    for (const std::string& pattern : patterns) {
        bool is_met = false;
        for (size_t c = 0; c < columns.size(); ++c)
            if (fnmatch(pattern.c_str(), columns[c].name.c_str(), 0) == 0) is_chosen[c] = is_met = true;
        if (is_met) continue;
        std::vector<std::string> names;
        for (const Column& column : columns) names.push_back(column.name);
        throw Error(ExitCode::usage, fmt::format("--figures {}: no figure is called like this{}", quote(pattern),
                                                 suggestion(pattern, names)));
    }
    for (size_t c = 0; c < columns.size(); ++c)
        if (is_chosen[c]) chosen.push_back(c);
    return chosen;
}

}  // namespace dttmm::host
