// SPDX-License-Identifier: BSD-3-Clause
#include "study/figures.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/channels.h"
#include "study/text_list.h"

namespace dttmm::host {

namespace {

/// In the order of HistoryFigures::Statistic.
const std::vector<std::string> kStatistics = {"peak", "time", "minimum", "maximum", "final", "mean", "rms"};

/// Nothing where `name` is no statistic.
std::optional<size_t> find_statistic(const std::string& name) {
    const auto found = std::ranges::find(kStatistics, name);
    return found == kStatistics.end() ? std::nullopt : std::optional(as_size(found - kStatistics.begin()));
}

/// What --figures asks for: a pattern or a formula, and its statistics.
struct FigureRequest {
    std::string name;  ///< of a formula; empty: a pattern
    std::string text;
    std::vector<size_t> statistics;
};

FigureRequest parse_request(const std::string& request) {
    FigureRequest result;
    const size_t colon = request.rfind(':'), equals = request.find('=');
    result.text = request.substr(0, colon);
    bool is_known = true;
    for (const std::string& name : split_list(colon == request.npos ? "peak,final" : request.substr(colon + 1))) {
        const std::optional<size_t> statistic = find_statistic(name);
        is_known = is_known && statistic;
        if (statistic) result.statistics.push_back(*statistic);
        if (!statistic && equals == request.npos)
            throw Error(ExitCode::usage, fmt::format("--figures {}: there is no statistic {}{}", quote(request), quote(name),
                                                     suggestion(name, kStatistics)));
    }
    if (equals == request.npos) return result;
    if (!is_known) {  // the colon is that of a ? b : c
        result.statistics = {0, 4};
        result.text = request;
    }
    result.name = bare_name(result.text.substr(0, equals));
    result.text = result.text.substr(equals + 1);
    if (result.name.empty())
        throw Error(ExitCode::usage,
                    fmt::format("--figures {}: the name before \"=\" is made of letters, digits and '_'", quote(request)));
    return result;
}

bool is_part_of_channel(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.' || (static_cast<unsigned char>(c) & 0x80);
}

}  // namespace

HistoryFigures::Formula::Formula(const std::string& text, std::span<const Channel> channels,
                                 const std::function<size_t(int channel)>& place_of) {
    std::string formula;
    std::vector<int> used;
    bool is_linear = text.find_first_of("*/^?") == text.npos;
    for (size_t at = 0; at < text.size();) {
        size_t end = at;
        while (end < text.size() && is_part_of_channel(text[end])) ++end;
        const std::string word = text.substr(at, std::max(end, at + 1) - at);
        at += word.size();
        const auto channel =
            std::ranges::find_if(channels, [&](const Channel& one) { return one.name() == word && &one != &channels[0]; });
        if (channel == channels.end()) {
            const bool is_name =
                word.find('.') != word.npos && !std::isdigit(static_cast<unsigned char>(word[0])) && word[0] != '.';
            if (is_name) {
                std::vector<std::string> known;
                for (const Channel& one : channels.subspan(1)) known.push_back(one.name());
                throw Error(ExitCode::usage, fmt::format("--figures {}: there is no channel {}{}", quote(text), quote(word),
                                                         suggestion(word, known)));
            }
            formula += word;
            is_linear = is_linear && (word.size() == 1 || word == "abs" || word == "min" || word == "max");
            continue;
        }
        const int index = as_int(channel - channels.begin());
        const auto known = std::ranges::find(used, index);
        formula += fmt::format("channel_{}", known - used.begin());
        if (known == used.end()) used.push_back(index);
    }
    if (used.empty())
        throw Error(ExitCode::usage,
                    fmt::format("--figures: there is no channel in {}; dttmm channels lists them", quote(text)));
    arguments.resize(used.size());
    Expression::Variables variables;
    unit = channels[as_size(used.front())].unit();
    for (size_t i = 0; i < used.size(); ++i) {
        places.push_back(place_of(used[i]));
        variables.emplace(fmt::format("channel_{}", i), &arguments[i]);
        is_linear = is_linear && channels[as_size(used[i])].unit() == unit;
    }
    if (!is_linear) unit = "SI";
    expression.emplace(formula, variables);
}

double HistoryFigures::Formula::value(std::span<const double> row) {
    for (size_t i = 0; i < places.size(); ++i) arguments[i] = row[places[i]];
    return expression->value();
}

HistoryFigures::HistoryFigures(const std::vector<std::string>& requests, std::span<const Channel> channels,
                               const std::optional<std::vector<int>>& selection)
    : channels_(channels), selection_(selection) {
    for (const std::string& request : requests) add_request(request);
    if (!requests.empty()) return;
    for (int c = 1; c < as_int(channels.size()); ++c) {
        const Channel& channel = channels[as_size(c)];
        if (channel.of() != Channel::Of::element || channel.quantity() != "force" || !channel.by_default()) continue;
        const size_t watched = watch_channel(c);
        add(watched, Statistic::peak);
        add(watched, Statistic::final);
    }
}

void HistoryFigures::add_request(const std::string& request) {
    const FigureRequest asked = parse_request(request);
    std::vector<size_t> watched;
    if (!asked.name.empty()) {
        auto formula = std::make_unique<Formula>(asked.text, channels_, [&](int channel) { return place_of(channel); });
        const std::string unit = formula->unit;
        watched_.push_back({asked.name, unit, 0, std::move(formula)});
        watched.push_back(watched_.size() - 1);
    } else {
        for (const int channel : select_channels({channels_.begin(), channels_.end()}, {asked.text}))
            if (channel > 0) watched.push_back(watch_channel(channel));
    }
    for (const size_t one : watched)
        for (const size_t statistic : asked.statistics) add(one, static_cast<Statistic>(statistic));
}

size_t HistoryFigures::place_of(int channel) const {
    if (!selection_) return as_size(channel);
    const auto found = std::ranges::find(*selection_, channel);
    if (found != selection_->end()) return as_size(found - selection_->begin());
    throw Error(ExitCode::model_invalid,
                fmt::format("--figures: a run to a tolerance has rows of the channels that it records, and {} is none of "
                            "them: add it to channels of [output], or give a step",
                            quote(channels_[as_size(channel)].name())));
}

size_t HistoryFigures::watch_channel(int channel) {
    const Channel& of = channels_[as_size(channel)];
    const auto known = std::ranges::find(watched_, of.name(), &Watched::name);
    if (known == watched_.end()) {
        watched_.push_back({of.name(), of.unit(), place_of(channel)});
        return watched_.size() - 1;
    }
    return as_size(known - watched_.begin());
}

void HistoryFigures::add(size_t watched, Statistic statistic) {
    const auto is_same = [&](const Figure& one) { return one.watched == watched && one.statistic == statistic; };
    if (std::ranges::any_of(figures_, is_same)) return;
    const Watched& of = watched_[watched];
    const std::string name = fmt::format("{}.{}", of.name, kStatistics[static_cast<size_t>(statistic)]);
    if (std::ranges::find(columns_, name, &Column::name) != columns_.end())
        throw Error(ExitCode::usage, fmt::format("--figures: two figures are called {}", quote(name)));
    figures_.push_back({watched, statistic});
    columns_.push_back({name, statistic == Statistic::time ? "s" : of.unit});
}

std::vector<int> HistoryFigures::places() const {
    std::vector<int> places;
    for (const Watched& one : watched_)
        if (one.formula)
            for (const size_t place : one.formula->places) places.push_back(as_int(place));
        else
            places.push_back(as_int(one.place));
    return places;
}

void HistoryFigures::read(std::span<const double> row, std::span<double> values) {
    for (size_t w = 0; w < watched_.size(); ++w) values[w] = watched_[w].value(row);
}

void HistoryFigures::take_row(std::span<const double> row) {
    const bool is_first = rows_++ == 0;
    for (Watched& one : watched_) {
        const double value = one.value(row);
        if (!std::isfinite(value)) one.is_broken = true;
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
    if (one.is_broken) return std::numeric_limits<double>::quiet_NaN();
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
            return mean(one.sum, one.final, rows_);
        case Statistic::rms:
            break;
    }
    return std::sqrt(mean(one.squares, one.final * one.final, rows_));
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
