// SPDX-License-Identifier: BSD-3-Clause
#include "study/distribution.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <charconv>
#include <cmath>
#include <optional>

#include "model/error.h"
#include "model/index.h"
#include "model/names.h"
#include "model/parameters.h"
#include "model/units.h"
#include "model/wording.h"
#include "study/text_list.h"

namespace dttmm::host {

namespace {

/// A name cut before its last digits.
struct Numbered {
    std::string stem;
    long number = -1;  ///< −1: it does not end with digits
};

Numbered numbered(const std::string& name) {
    size_t begin = name.size();
    while (begin > 0 && name[begin - 1] >= '0' && name[begin - 1] <= '9') --begin;
    Numbered result{name.substr(0, begin)};
    const auto [end, fault] = std::from_chars(name.data() + begin, name.data() + name.size(), result.number);
    if (fault != std::errc() || end != name.data() + name.size()) result.number = -1;
    return result;
}

/// "k1..k4" → k1, k2, k3, k4.
std::vector<std::string> spelt_out(const std::string& range, size_t dots, const std::string& option) {
    const Numbered from = numbered(without_blanks_around(range.substr(0, dots))),
                   to = numbered(without_blanks_around(range.substr(dots + 2)));
    constexpr long kMostNames = 10000;
    const bool is_range = from.number >= 0 && to.number >= from.number && to.number - from.number < kMostNames &&
                          (to.stem == from.stem || to.stem.empty());
    if (!is_range)
        throw Error(ExitCode::usage, fmt::format("{}: {} is no range of names: write k1..k4", option, quote(range)));
    std::vector<std::string> names;
    for (long i = from.number; i <= to.number; ++i) names.push_back(fmt::format("{}{}", from.stem, i));
    return names;
}

/// What --vary says behind "~", in the unit of one parameter.
class DistributionText {
public:
    DistributionText(const std::string& option, const std::string& text, const Parameter& parameter)
        : option_(option), parameter_(parameter) {
        const size_t open = text.find('(');
        if (open == std::string::npos || text.back() != ')') refuse_form(text);
        name_ = without_blanks_around(text.substr(0, open));
        arguments_ = split_list(text.substr(open + 1, text.size() - open - 2));
    }

    Distribution read() const {
        if (name_ == "normal" || name_ == "lognormal") return read_bell();
        if (name_ == "uniform") return read_uniform();
        if (name_ == "list") return read_list();
        refuse(fmt::format("there is no distribution {}{}", quote(name_),
                           suggestion(name_, {"normal", "lognormal", "uniform", "list"})));
    }

private:
    [[noreturn]] void refuse(const std::string& fault) const {
        throw Error(ExitCode::usage, fmt::format("{}: {}", option_, fault));
    }
    [[noreturn]] void refuse_form(const std::string& text) const {
        refuse(
            fmt::format("{} is no distribution: write normal(mean, deviation), lognormal(mean, deviation), "
                        "uniform(low, high) or list(value, value)",
                        quote(text)));
    }

    void expect(size_t count, const char* form) const {
        if (arguments_.size() != count) refuse(fmt::format("write {}", form));
    }

    double value(const std::string& text) const {
        std::optional<std::string> unit;
        try {
            unit = find_missing_unit(parameter_, text);
            if (!unit) return parameter_.unit.empty() ? parse_quantity(text).value : parse_quantity(text, parameter_.unit);
        } catch (const Error& error) {
            refuse(error.what());
        }
        refuse(fmt::format("{} of which unit? the file gives {} in {}: write \"{} {}\"", quote(text), quote(parameter_.name),
                           *unit, text, *unit));
    }

    Distribution read_bell() const {
        expect(2, fmt::format("{}(mean, deviation), e.g. {}(500 N/mm, 10 %)", name_, name_).c_str());
        Distribution result;
        result.kind = name_ == "normal" ? Distribution::Kind::normal : Distribution::Kind::lognormal;
        result.mean = value(arguments_[0]);
        const bool is_share = arguments_[1].ends_with('%');
        result.deviation = is_share ? std::abs(result.mean) * share(arguments_[1]) : value(arguments_[1]);
        if (!(result.deviation > 0)) refuse(fmt::format("the deviation {} must be above 0", quote(arguments_[1])));
        if (name_ == "lognormal" && !(result.mean > 0))
            refuse(fmt::format("the mean {} of a lognormal distribution must be above 0", quote(arguments_[0])));
        if (!(result.deviation <= 1e100 && std::abs(result.mean) <= 1e100 &&
              (name_ == "normal" || (result.mean >= 1e-100 && result.deviation <= 1e6 * result.mean))))
            refuse("the numbers are too large, or the deviation is too large beside the mean");
        return result;
    }

    double share(const std::string& text) const {
        try {
            return parse_quantity(text, "1");
        } catch (const Error& error) {
            refuse(error.what());
        }
    }

    Distribution read_uniform() const {
        expect(2, "uniform(low, high), e.g. uniform(400 N/mm, 600 N/mm)");
        Distribution result;
        result.low = value(arguments_[0]);
        result.high = value(arguments_[1]);
        if (!(result.low < result.high))
            refuse(fmt::format("{} must be below {}", quote(arguments_[0]), quote(arguments_[1])));
        return result;
    }

    Distribution read_list() const {
        Distribution result;
        result.kind = Distribution::Kind::list;
        for (const std::string& argument : arguments_) result.values.push_back(value(argument));
        return result;
    }

    const std::string& option_;
    const Parameter& parameter_;
    std::string name_;
    std::vector<std::string> arguments_;
};

const Parameter& find_parameter(const std::string& given, const std::vector<Parameter>& parameters,
                                const std::string& option) {
    const std::string name = normalise_name(given);
    const auto found = std::ranges::find(parameters, name, &Parameter::name);
    if (found != parameters.end()) return *found;
    std::vector<std::string> known;
    for (const Parameter& parameter : parameters) known.push_back(parameter.name);
    throw Error(ExitCode::usage, fmt::format("{}: no such parameter {}{}", option, quote(name), suggestion(name, known)));
}

}  // namespace

double Distribution::quantile(double probability) const {
    switch (kind) {
        case Kind::normal:
            return boost::math::quantile(boost::math::normal(mean, deviation), probability);
        case Kind::lognormal: {
            // ln x is normal with the variance s² = ln(1 + (deviation/mean)²) and the mean ln(mean) − s²/2
            const double s2 = std::log1p(deviation * deviation / (mean * mean));
            const boost::math::normal logarithm(std::log(mean) - 0.5 * s2, std::sqrt(s2));
            return std::exp(boost::math::quantile(logarithm, probability));
        }
        case Kind::uniform:
            return low + probability * (high - low);
        case Kind::list:
            break;
    }
    const auto place = static_cast<size_t>(probability * static_cast<double>(values.size()));
    return values[std::min(place, values.size() - 1)];
}

std::vector<std::string> parameter_names(const std::string& text, const std::vector<Parameter>& parameters,
                                         const std::string& option) {
    std::vector<std::string> names;
    for (const std::string& part : split_list(text)) {
        if (part.empty()) throw Error(ExitCode::usage, fmt::format("{}: a name is missing", option));
        std::vector<std::string> meant;
        if (const size_t dots = part.find(".."); dots != std::string::npos) {
            meant = spelt_out(part, dots, option);
        } else if (part.find_first_of("*?[") != std::string::npos) {
            for (const Parameter& parameter : parameters)
                if (fnmatch(part.c_str(), parameter.name.c_str(), 0) == 0) meant.push_back(parameter.name);
            if (meant.empty())
                throw Error(ExitCode::usage, fmt::format("{}: no parameter is called like {}", option, quote(part)));
        } else {
            meant = {part};
        }
        for (const std::string& name : meant) names.push_back(find_parameter(name, parameters, option).name);
    }
    return names;
}

Variation parse_variation(const std::string& text, const std::vector<Parameter>& parameters) {
    const std::string option = "--vary " + quote(text);
    const size_t tilde = text.find('~');
    if (tilde == std::string::npos)
        throw Error(ExitCode::usage, fmt::format("{}: write \"names ~ distribution\", e.g. \"k1..k4 ~ normal(500 N/mm, 10 "
                                                 "%)\"",
                                                 option));
    Variation variation{parameter_names(text.substr(0, tilde), parameters, option), {}};
    const std::string rest = without_blanks_around(text.substr(tilde + 1));
    if (rest.empty()) throw Error(ExitCode::usage, fmt::format("{}: the distribution is missing", option));
    for (const std::string& name : variation.names)
        variation.distribution = DistributionText(option, rest, find_parameter(name, parameters, option)).read();
    return variation;
}

}  // namespace dttmm::host
