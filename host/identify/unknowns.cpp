// SPDX-License-Identifier: BSD-3-Clause
#include "identify/unknowns.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cmath>

#include "model/element_scale.h"
#include "model/error.h"
#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"
#include "study/distribution.h"
#include "study/text_list.h"

namespace dttmm::host {

namespace {

constexpr double kLowest = 0.05, kHighest = 20;  // times the file's value, unless --bounds says otherwise
constexpr double kGainRange = 10;                // times 1, of a gain
constexpr double kLongestDelay = 0.01;           // [s], of a sensor's chain
constexpr double kClockRange = 0.05;             // share by which a clock may be wrong

[[noreturn]] void refuse_usage(const std::string& text) { throw Error(ExitCode::usage, text); }

/// A bound: a plain number is a factor of the file's value, a quantity stands for itself.
double read_bound(const std::string& text, const Unknown& unknown) {
    try {
        if (unit_text(text).empty()) return parse_quantity(text).value * unknown.start;
        return parse_quantity(text, unknown.unit);
    } catch (const Error& error) {
        refuse_usage(fmt::format("--bounds of {}: {}: {}", quote(unknown.name), quote(text), error.what()));
    }
}

}  // namespace

double Unknown::coordinate(double value) const {
    return is_logarithmic() ? std::log(value) : (value - start) / (0.5 * (high - low));
}

double Unknown::value(double coordinate) const {
    return is_logarithmic() ? std::exp(coordinate) : start + coordinate * 0.5 * (high - low);
}

std::pair<std::string, std::string> split_range(const std::string& text, const std::string& option) {
    const size_t dots = text.find("..");
    if (dots == text.npos || dots == 0 || dots + 2 == text.size())
        refuse_usage(fmt::format("{} {}: write LOW..HIGH", option, quote(text)));
    return {without_blanks_around(text.substr(0, dots)), without_blanks_around(text.substr(dots + 2))};
}

Unknowns::Unknowns(const Request& request, const Model& model, const ElementCatalogue& catalogue,
                   const std::vector<std::string>& channels) {
    for (const std::string& text : request.fit.free)
        for (const std::string& item : split_list(text)) add_free(item, model, catalogue);
    for (const std::string& text : request.fit.nuisances)
        for (const std::string& item : split_list(text)) add_nuisance(item, channels);
    for (const std::string& text : request.fit.bounds) set_bounds(text, model.parameters);
    for (const Unknown& one : all_)
        if (!(one.start >= one.low && one.start <= one.high))
            refuse_usage(fmt::format("--bounds of {} leave out the value of the file, {} {}", quote(one.name),
                                     number_text(one.start), one.unit));
}

void Unknowns::add_once(Unknown unknown) {
    if (std::ranges::find(all_, unknown.name, &Unknown::name) != all_.end())
        refuse_usage(fmt::format("--free names {} twice", quote(unknown.name)));
    all_.push_back(std::move(unknown));
}

void Unknowns::add_free(const std::string& text, const Model& model, const ElementCatalogue& catalogue) {
    for (const auto& [ending, of] : {std::pair<std::string, Unknown::Of>(".stiffness", Unknown::Of::stiffness),
                                     std::pair<std::string, Unknown::Of>(".damping", Unknown::Of::damping)})
        if (text.ends_with(ending)) return add_element(text.substr(0, text.size() - ending.size()), of, model, catalogue);
    for (const std::string& name : parameter_names(text, model.parameters, "--free"))
        add_parameter(*std::ranges::find(model.parameters, name, &Parameter::name));
}

void Unknowns::add_parameter(const Parameter& parameter) {
    if (parameter.unit.empty())
        refuse_usage(fmt::format("--free {}: it is the result of an expression; free what the expression rests on",
                                 quote(parameter.name)));
    Unknown unknown{Unknown::Of::parameter, parameter.name, parameter.unit, parameter.value};
    if (parameter.value == 0)
        refuse_usage(fmt::format("--free {}: its value in the file is 0, which gives no scale; give it one with --set",
                                 quote(parameter.name)));
    const double far = kHighest * parameter.value;
    unknown.low = parameter.value > 0 ? kLowest * parameter.value : far;
    unknown.high = parameter.value > 0 ? far : kLowest * parameter.value;
    add_once(unknown);
}

void Unknowns::add_element(const std::string& pattern, Unknown::Of of, const Model& model,
                           const ElementCatalogue& catalogue) {
    const bool is_stiffness = of == Unknown::Of::stiffness;
    bool is_found = false, is_empty = false;
    std::vector<std::string> names;
    for (const Element& element : model.elements) {
        names.push_back(element.name);
        if (fnmatch(pattern.c_str(), element.name.c_str(), 0) != 0) continue;
        is_empty = !has_part(element, catalogue, is_stiffness ? ScaledPart::stiffness : ScaledPart::damping);
        if (is_empty) continue;
        is_found = true;
        Unknown unknown{of, element.name + (is_stiffness ? ".stiffness" : ".damping"), "1", 1, kLowest, kHighest};
        unknown.element = element.name;
        add_once(unknown);
    }
    if (!is_found)
        refuse_usage(
            is_empty ? fmt::format("--free: element {} has no {}", quote(pattern), is_stiffness ? "stiffness" : "damping")
                     : fmt::format("--free: no element {}{}", quote(pattern), suggestion(pattern, names)));
}

void Unknowns::add_nuisance(const std::string& text, const std::vector<std::string>& channels) {
    if (text == "gain")
        add_once({Unknown::Of::gain, "gain", "1", 1, 1 / kGainRange, kGainRange});
    else if (text == "delay")
        add_once({Unknown::Of::delay, "delay", "s", 0, -kLongestDelay, kLongestDelay});
    else if (text == "clock")
        add_once({Unknown::Of::clock, "clock", "1", 1, 1 - kClockRange, 1 + kClockRange});
    else if (text == "gains")
        for (size_t c = 0; c < channels.size(); ++c) {
            Unknown unknown{
                Unknown::Of::channel_gain, fmt::format("gain({})", channels[c]), "1", 1, 1 / kGainRange, kGainRange};
            unknown.channel = c;
            add_once(unknown);
        }
    else
        refuse_usage(fmt::format("--nuisance {}: it is one of gain, gains, delay, clock", quote(text)));
}

void Unknowns::set_bounds(const std::string& text, const std::vector<Parameter>& parameters) {
    const size_t equals = text.find('=');
    const auto [low, high] =
        split_range(without_blanks_around(equals == text.npos ? text : text.substr(equals + 1)), "--bounds");
    std::vector<std::string> names;
    if (equals != text.npos) {
        const std::string own = without_blanks_around(text.substr(0, equals));
        for (const std::string& item : split_list(own)) {
            if (std::ranges::find(all_, item, &Unknown::name) != all_.end())
                names.push_back(item);
            else
                for (const std::string& name : parameter_names(item, parameters, "--bounds")) names.push_back(name);
        }
    }
    bool is_any = false;
    for (Unknown& one : all_) {
        const bool is_meant = equals == text.npos ? one.of == Unknown::Of::parameter || one.of == Unknown::Of::stiffness ||
                                                        one.of == Unknown::Of::damping
                                                  : std::ranges::find(names, one.name) != names.end();
        if (!is_meant) continue;
        is_any = true;
        one.low = read_bound(low, one);
        one.high = read_bound(high, one);
        if (one.start < 0 && unit_text(low).empty() && unit_text(high).empty()) std::swap(one.low, one.high);
        if (!(one.low < one.high))
            refuse_usage(
                fmt::format("--bounds {}: the bounds of {} must differ, the lower one first", quote(text), quote(one.name)));
    }
    if (!is_any) refuse_usage(fmt::format("--bounds {}: nothing of that name is free", quote(text)));
}

Eigen::VectorXd Unknowns::start() const {
    Eigen::VectorXd x(as_row(size()));
    for (size_t i = 0; i < size(); ++i) x(as_row(i)) = all_[i].coordinate(all_[i].start);
    return x;
}

Eigen::VectorXd Unknowns::low() const {
    Eigen::VectorXd x(as_row(size()));
    for (size_t i = 0; i < size(); ++i) x(as_row(i)) = all_[i].coordinate(all_[i].low);
    return x;
}

Eigen::VectorXd Unknowns::high() const {
    Eigen::VectorXd x(as_row(size()));
    for (size_t i = 0; i < size(); ++i) x(as_row(i)) = all_[i].coordinate(all_[i].high);
    return x;
}

void Unknowns::apply(const Eigen::VectorXd& x, ModelOverrides& overrides) const {
    for (size_t i = 0; i < size(); ++i) {
        const Unknown& one = all_[i];
        const double value = one.value(x(as_row(i)));
        if (one.of == Unknown::Of::parameter)
            overrides.parameters.emplace_back(one.name,
                                              one.unit == "1" ? number_text(value) : number_text(value) + " " + one.unit);
        const bool is_stiffness = one.of == Unknown::Of::stiffness;
        if (!is_stiffness && one.of != Unknown::Of::damping) continue;
        for (const std::string& element : one.shared.empty() ? std::vector{one.element} : one.shared)
            overrides.scales.push_back({element, is_stiffness ? value : 1, is_stiffness ? 1 : value});
    }
}

MeasurementFactors Unknowns::factors(const Eigen::VectorXd& x) const {
    MeasurementFactors factors;
    for (size_t i = 0; i < size(); ++i) {
        const double value = all_[i].value(x(as_row(i)));
        switch (all_[i].of) {
            case Unknown::Of::gain:
                factors.gain = value;
                break;
            case Unknown::Of::delay:
                factors.delay = value;
                break;
            case Unknown::Of::clock:
                factors.clock = value;
                break;
            case Unknown::Of::channel_gain:
                if (factors.gains.size() <= all_[i].channel) factors.gains.resize(all_[i].channel + 1, 1);
                factors.gains[all_[i].channel] = value;
                break;
            default:
                break;
        }
    }
    return factors;
}

std::string Unknowns::describe(size_t i, double coordinate) const {
    return fmt::format("{} = {:.6g}{}", all_[i].name, all_[i].value(coordinate),
                       all_[i].unit == "1" ? "" : " " + all_[i].unit);
}

}  // namespace dttmm::host
