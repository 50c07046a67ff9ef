// SPDX-License-Identifier: BSD-3-Clause
#include "identify/diagnose.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cmath>

#include "analysis/json.h"
#include "analysis/modal_session.h"
#include "analysis/stop_signals.h"
#include "analysis/summary.h"
#include "identify/diagnosis.h"
#include "identify/fit_curves.h"
#include "identify/test_plan.h"
#include "identify/verdict.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/results_folder.h"
#include "study/text_list.h"

namespace dttmm::host {

namespace {

/// Elements that --suspects names.
Suspects find_suspects(const Request& request, const Model& model, const ElementCatalogue& catalogue) {
    if (request.fit.suspects.empty())
        throw Error(ExitCode::usage, "which elements may be loose? Name them with --suspects, e.g. --suspects 'bolt*'");
    Suspects suspects;
    std::vector<std::string> names;
    for (const Element& element : model.elements) names.push_back(element.name);
    for (const std::string& text : request.fit.suspects)
        for (const std::string& pattern : split_list(text)) {
            bool is_any = false, is_stiff = false;
            for (const Element& element : model.elements) {
                if (fnmatch(pattern.c_str(), element.name.c_str(), 0) != 0) continue;
                is_any = true;
                if (!has_part(element, catalogue, ScaledPart::stiffness)) continue;
                is_stiff = true;
                if (std::ranges::find(suspects.names, element.name) != suspects.names.end()) continue;
                suspects.names.push_back(element.name);
                suspects.are_damped.push_back(has_part(element, catalogue, ScaledPart::damping));
            }
            if (!is_any)
                throw Error(ExitCode::usage,
                            fmt::format("--suspects: no element {}{}", quote(pattern), suggestion(pattern, names)));
            if (!is_stiff)
                throw Error(ExitCode::usage,
                            fmt::format("--suspects: {} has no stiffness that could be lost", quote(pattern)));
        }
    return suspects;
}

/// "20 % softer (19.6 to 20.4)".
std::string describe_factor(double factor, const std::optional<double>& low, const std::optional<double>& high) {
    const bool is_softer = factor < 1;
    const auto percent = [&](double value) {
        return fmt::format("{:.3g}", is_softer ? 100 * (1 - value) : 100 * (value - 1));
    };
    const auto& least = is_softer ? high : low;
    const auto& most = is_softer ? low : high;
    return fmt::format("{} % {} ({} to {})", percent(factor), is_softer ? "softer" : "stiffer",
                       least ? percent(*least) : "no lower limit", most ? percent(*most) : "no upper limit");
}

std::string describe_hypothesis(const Hypothesis& one) {
    std::string text;
    if (one.are_alike) {
        text = fmt::format("all {} alike, {}", counted(one.elements.size(), "suspect", "suspects"),
                           describe_factor(one.factors[0], one.low[0], one.high[0]));
    } else {
        for (size_t i = 0; i < one.elements.size(); ++i)
            text += fmt::format("{}{}, {}", i > 0 ? " and " : "", one.elements[i],
                                describe_factor(one.factors[i], one.low[i], one.high[i]));
    }
    for (size_t i = 0; i < one.dampings.size(); ++i)
        text += fmt::format("{} {:.3g}", i == 0 ? ", damping" : " and", one.dampings[i]);
    if (!one.dampings.empty()) text += " times";
    return text;
}

bool is_pair(const Hypothesis& one) { return !one.are_alike && one.elements.size() > 1; }

std::string name_of(const Hypothesis& one) {
    if (one.are_alike) return "all alike";
    std::string text;
    for (const std::string& element : one.elements) text += (text.empty() ? "" : " with ") + element;
    return text;
}

/// As an alternative to others: "bolt1 alone or bolt1 and bolt2 together".
std::string name_beside(const std::vector<Hypothesis>& others, const Hypothesis& one) {
    if (is_pair(one)) return fmt::format("{} together", fmt::join(one.elements, " and "));
    const auto has_it = [&](const Hypothesis& other) {
        return is_pair(other) && std::ranges::find(other.elements, one.elements.front()) != other.elements.end();
    };
    return name_of(one) + (!one.are_alike && std::ranges::any_of(others, has_it) ? " alone" : "");
}

/// Whether pairs were fitted.
bool has_pairs(const Diagnosis& found) {
    return std::ranges::any_of(found.candidates, is_pair) || std::ranges::any_of(found.others, is_pair);
}

/// suspects: how many there are.
std::vector<std::string> make_verdict(const Diagnosis& found, size_t suspects) {
    std::vector<std::string> verdict;
    const auto say = [&](std::string text) { verdict.push_back(std::move(text)); };
    const bool is_wrong = found.fit.freedom > 0 && !found.fit.is_explained();
    if (found.candidates.empty()) {
        say(is_wrong ? fmt::format("No change of the suspects explains the data ({}): the model is wrong in something else",
                                   describe_chi2(found.fit))
                     : "No change is seen");
        const char* others = found.unseen.empty() ? "suspect" : "other suspect";
        if (!is_wrong && found.least_seen)
            say(fmt::format("A loss of stiffness above {:.2g} % in any {} would have been, with a chance of {:g} %",
                            100 * *found.least_seen, others, 100 * kSureChance));
        else if (!is_wrong && found.unseen.size() < suspects)
            say(fmt::format("These data do not show every loss: of some {} even that of nearly all stiffness may be missed",
                            others));
    } else if (is_wrong) {
        say(fmt::format("No single element{} explains the data ({}): what comes nearest is {}",
                        has_pairs(found) ? " and no pair of the likeliest elements" : "", describe_chi2(found.fit),
                        describe_hypothesis(found.candidates.front())));
    } else if (found.candidates.size() == 1) {
        say(describe_hypothesis(found.candidates.front()));
    } else {
        std::vector<std::string> names;
        for (const Hypothesis& one : found.candidates) names.push_back(name_beside(found.candidates, one));
        say(fmt::format("{}: these sensors cannot tell", fmt::join(names, " or ")));
        for (const Hypothesis& one : found.candidates) say(describe_hypothesis(one));
    }
    for (const auto& alike : found.ties)
        say(fmt::format("Small changes of {} do the same to these data: these data cannot distinguish them", listed(alike)));
    if (!found.unseen.empty()) say(fmt::format("A change of {} does nothing to these data", listed(found.unseen)));
    for (const Hypothesis& one : found.candidates)
        if (std::ranges::count(one.are_limits_converged, false) > 0) say(describe_rough_limits({name_of(one)}));
    for (const std::string& sentence : describe_limits(found.fit)) say(sentence);
    if (!found.step.empty()) say(found.step);
    return verdict;
}

Json describe(const Hypothesis& one, double best) {
    const auto number = [](const std::optional<double>& value) { return value ? Json(*value) : Json(); };
    Json factors = Json::array(), low = Json::array(), high = Json::array();
    for (const double factor : one.factors) factors.push_back(factor);
    for (const auto& limit : one.low) low.push_back(number(limit));
    for (const auto& limit : one.high) high.push_back(number(limit));
    const bool is_one = one.factors.size() == 1;
    Json json = {{"elements", one.elements}, {"alike", one.are_alike}};
    json["factor"] = is_one ? factors[0] : factors;
    if (!one.low.empty()) {
        json["low"] = is_one ? low[0] : low;
        json["high"] = is_one ? high[0] : high;
        json["limits_converged"] = std::ranges::count(one.are_limits_converged, false) == 0;
    }
    json["damping_factor"] = one.dampings.empty()       ? Json()
                             : one.dampings.size() == 1 ? Json(one.dampings[0])
                                                        : Json(one.dampings);
    json["chi2"] = one.chi2;
    json["delta_bic"] = one.score - best;
    return json;
}

void print(const Diagnosis& found, const std::vector<std::string>& verdict, const Comparison& comparison) {
    for (const std::string& sentence : verdict) fmt::print("{}.\n", printable(sentence));
    fmt::print("\n{:<30} {:>12} {:>12} {:>12}\n", "explanation", "factor", "chi2", "BIC more");
    const auto line = [&](const std::string& name, const std::string& factor, const Hypothesis& one) {
        fmt::print("{:<30} {:>12} {:>12.6g} {:>12.4g}\n", name, factor, one.chi2, one.score - found.best_score);
    };
    constexpr size_t kShown = 10;
    size_t shown = 0;
    for (const auto* list : {&found.candidates, &found.others})
        for (const Hypothesis& one : *list) {
            if (shown++ >= kShown) continue;
            std::string factors;
            for (const double factor : one.factors) factors += fmt::format("{}{:.5g}", factors.empty() ? "" : ", ", factor);
            line(name_of(one), factors, one);
        }
    line("no change", "", found.unchanged);
    fmt::print("\n{}; {} points\n", describe_noise(comparison), comparison.rows());
}

/// A plan has no measured data and no run: options about these would not count.
void refuse_options_of_data(const Request& request) {
    for (const auto& [option, value] : request.given) {
        const std::string name = option->name();
        const bool is_of_data = option->commands == (kIdentify | kDiagnose) && name != "--channels";
        if (is_of_data || name == "--step" || name == "--coupling" || name == "--in")
            throw Error(ExitCode::usage, fmt::format("{} does not go with --plan, which has no measured data", name));
    }
}

}  // namespace

ExitCode diagnose(const Request& request) {
    const StopSignals signals;
    const Plugins plugins(request.plugins);
    Warnings warnings;
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::modes;
    const Model model = read_model(request.model, plugins.catalogue(), overrides);
    const Suspects suspects = find_suspects(request, model, plugins.catalogue());
    if (request.fit.is_plan) {
        refuse_options_of_data(request);
        return plan_test(request, plugins, suspects.names);
    }
    const Observations observations = read_observations(request, model, plugins, warnings);
    const Unknowns common(request, model, plugins.catalogue(), observations.channel_names());
    Comparison comparison(request, observations, plugins);
    const Diagnosis found = Diagnostician(comparison, common, suspects, request.jobs).diagnose();
    const std::vector<std::string> verdict = make_verdict(found, suspects.size());

    const ResultsFolder folder(results_path(request, "-diagnose"));
    Json candidates = Json::array(), others = Json::array();
    for (const Hypothesis& one : found.candidates) candidates.push_back(describe(one, found.best_score));
    for (const Hypothesis& one : found.others) others.push_back(describe(one, found.best_score));
    const Json json = {
        {"format", "dttmm-diagnose/1"},
        {"verdict", join_sentences(verdict)},
        {"candidates", candidates},
        {"others", others},
        {"no_change", {{"chi2", found.unchanged.chi2}, {"delta_bic", found.unchanged.score - found.best_score}}},
        {"ties", found.ties},
        {"unseen", found.unseen},
        {"least_loss_seen", found.least_seen ? Json(*found.least_seen) : Json()},
        {"suspects", suspects.names},
        {"fit", describe_fit(found.fit)},
        {"data", describe_groups(comparison)},
        {"measured", observations.files},
        {"warnings", describe_warnings(warnings)},
        {"command_line", request.command_line}};
    write_json(folder.file("diagnose.json"), json);
    if (!request.quiet) {
        print(found, verdict, comparison);
        fmt::print("results in {}\n", folder.describe("diagnose.json"));
    }
    return ExitCode::ok;
}

}  // namespace dttmm::host
