// SPDX-License-Identifier: BSD-3-Clause
#include "identify/verdict.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

constexpr double kStepMatters = 0.5;  // of a standard deviation: a bias that shows in the interval

const char* source_of(DataGroup::NoiseFrom from) {
    switch (from) {
        case DataGroup::NoiseFrom::user:
            return "given";
        case DataGroup::NoiseFrom::data:
            return "data";
        case DataGroup::NoiseFrom::assumed:
            return "assumed";
        default:
            return "residuals";
    }
}

std::vector<std::string> names_where(const Unknowns& unknowns, const std::vector<bool>& is_meant) {
    std::vector<std::string> names;
    for (size_t i = 0; i < unknowns.size(); ++i)
        if (is_meant[i]) names.push_back(unknowns[i].name);
    return names;
}

std::string are(size_t count) { return count == 1 ? "is" : "are"; }

}  // namespace

std::string describe_value(const Solution& solution, const Unknowns& unknowns, size_t i) {
    const Unknown& one = unknowns[i];
    const std::string unit = one.unit == "1" ? "" : " " + one.unit;
    if (solution.judged.is_dead[i])
        return fmt::format("{} is not fixed: nothing that was measured changes with it", one.name);
    const auto& low = solution.low[i];
    const auto& high = solution.high[i];
    const char* doubt = solution.are_limits_converged[i] ? "" : ", limits not converged";
    if (!low && !high) return fmt::format("{} is not fixed by the data{}", one.name, doubt);
    const auto text = [&](const std::optional<double>& limit, const char* none) {
        return limit ? fmt::format("{:.6g}", one.value(*limit)) : std::string(none);
    };
    return fmt::format("{} = {:.6g}{} ({} to {}{})", one.name, one.value(solution.x(as_row(i))), unit,
                       text(low, "no lower limit"), text(high, "no upper limit"), doubt);
}

std::string join_sentences(const std::vector<std::string>& sentences) {
    std::string text;
    for (const std::string& sentence : sentences) text += (text.empty() ? "" : " ") + sentence + ".";
    return text;
}

std::string describe_chi2(const Fit& fit) {
    return fmt::format("chi2 {:.5g} for {} points{}{}", fit.chi2, fit.points,
                       fit.misfit > 0 ? fmt::format(", {:.2g} % of the largest value left", 100 * fit.misfit) : "",
                       fit.whiteness < 1e-3 ? "; the residuals are correlated: a model error, not noise" : "");
}

std::string describe_noise(const Comparison& comparison) {
    std::vector<std::string> parts, assumed;
    for (const DataGroup& group : comparison.groups())
        if (group.noise_from == DataGroup::NoiseFrom::assumed)
            assumed.emplace_back(group.kind == DataGroup::Kind::frequency ? "0.5 % of frequencies" : "3 % of shapes");
    using From = DataGroup::NoiseFrom;
    const std::pair<From, std::string> sources[] = {{From::user, "as given"},
                                                    {From::data, "from the data"},
                                                    {From::assumed, fmt::format("assumed: {}", fmt::join(assumed, ", "))},
                                                    {From::residuals, "estimated from the residuals"}};
    for (const auto& [from, words] : sources)
        if (std::ranges::find(comparison.groups(), from, &DataGroup::noise_from) != comparison.groups().end())
            parts.emplace_back(words);
    std::string text;
    for (const std::string& part : parts) text += (text.empty() ? "" : "; ") + part;
    return "noise of the data: " + text;
}

Json describe_groups(const Comparison& comparison) {
    Json list = Json::array();
    const Eigen::VectorXd deviations = comparison.deviations();
    for (const DataGroup& group : comparison.groups())
        list.push_back({{"name", group.name},
                        {"points", group.count},
                        {"noise", deviations.segment(group.first, group.count).mean()},
                        {"noise_from", source_of(group.noise_from)}});
    return list;
}

Json describe_fit(const Fit& fit) {
    return {{"chi2", fit.chi2},
            {"points", fit.points},
            {"degrees_of_freedom", fit.freedom},
            {"noise_is_independent", fit.is_noise_independent},
            {"misfit", fit.misfit},
            {"chance_of_chi2", fit.chance},
            {"chance_of_correlation", fit.whiteness},
            {"inflation", fit.inflation},
            {"explained", fit.is_explained()}};
}

std::string describe_rough_limits(const std::vector<std::string>& names) {
    return fmt::format("The search for the limits of {} did not converge: the interval is a guess", listed(names));
}

std::vector<std::string> describe_limits(const Fit& fit) {
    std::vector<std::string> limits;
    if (fit.is_noise_assumed && fit.freedom > 0 && fit.is_explained() && fit.chance < 1e-3)
        limits.push_back(
            fmt::format("That holds if the noise is {:.2g} times what is usual ({}); the intervals are as much wider",
                        fit.noise_factor(), describe_chi2(fit)));
    if (!fit.offsets.empty())
        limits.push_back(fmt::format("What is left of {} has a mean that is no noise: an offset of the sensor, or a drift",
                                     listed(fit.offsets)));
    if (!fit.can_be_judged)
        limits.emplace_back(
            "The noise was estimated from the residuals, of which there are too few to see a correlation: a lack of fit "
            "would not show; give --noise");
    else if (!fit.is_noise_independent)
        limits.emplace_back(
            "The noise was estimated from the residuals: so chi2 cannot show a lack of fit, their correlation can");
    if (fit.inflation > 1 && fit.whiteness < 1e-3)
        limits.push_back(
            fmt::format("The intervals are {:.2g} times wider for the correlation of the residuals", fit.inflation));
    return limits;
}

std::string describe_step(const Eigen::VectorXd& bias, const Solution& solution, const Unknowns& unknowns, double step) {
    std::vector<std::string> shifted;
    for (Eigen::Index i = 0; i < bias.size(); ++i) {
        const double deviation = solution.judged.deviations(i);
        if (!std::isfinite(deviation) || !(std::abs(bias(i)) > kStepMatters * deviation)) continue;
        const Unknown& one = unknowns[as_size(i)];
        shifted.push_back(one.is_logarithmic() ? fmt::format("{} by {:.2g} %", one.name, 100 * bias(i))
                                               : fmt::format("{} by {:.2g} {}", one.name, one.slope(0) * bias(i), one.unit));
    }
    if (shifted.empty()) return {};
    return fmt::format(
        "The time step of {:.4g} s shifts {} from what exact motion would give: measured data want a smaller --step", step,
        listed(shifted));
}

namespace {

/// Whether the data are explained, and by how much of what is sought.
std::string describe_answer(const Identification& found, const Comparison& comparison, const Unknowns& unknowns) {
    const Solution& best = found.solutions.front();
    const Fit& fit = found.fit;
    size_t open = 0;
    for (size_t i = 0; i < unknowns.size(); ++i) open += !best.judged.is_dead[i] && !best.low[i] && !best.high[i];
    if (found.is_underdetermined && fit.is_hopeless())
        return fmt::format(
            "No set of values that was found explains the data ({}), though there are no fewer unknowns than data",
            describe_chi2(fit));
    if (found.is_underdetermined)
        return fmt::format(
            "Under-determined: {} data for {} unknowns, and many sets of values explain them: no value is known. Free "
            "fewer, say with --prior what is known before, or measure more",
            fit.points - comparison.scales(), unknowns.size());
    if (fit.freedom > 0 && !fit.is_explained())
        return fmt::format(
            "No set of values explains the data ({}): the values below are the best guess of a model that is wrong",
            describe_chi2(fit));
    if (found.solutions.size() > 1)
        return fmt::format(
            "{} sets of values explain the data about equally well (chi2 within 10): the data cannot tell which is true",
            found.solutions.size());
    if (!best.judged.flat.empty() || open > 0)
        return fmt::format("The data do not fix all that is sought: {} of {} are not known", open, unknowns.size());
    if (!fit.can_be_judged)
        return fmt::format("How well the model explains the data cannot be judged ({})", describe_chi2(fit));
    return fmt::format("The model explains the data ({})", describe_chi2(fit));
}

}  // namespace

std::vector<std::string> make_verdict(const Identification& found, const Comparison& comparison, const Unknowns& unknowns) {
    const Solution& best = found.solutions.front();
    const Fit& fit = found.fit;
    std::vector<std::string> verdict;
    const auto say = [&](std::string text) { verdict.push_back(std::move(text)); };
    say(describe_answer(found, comparison, unknowns));
    if (fit.freedom > 0 && !fit.is_explained() && found.solutions.size() > 1)
        say(fmt::format("{} sets of values come equally near to the data", found.solutions.size()));
    if (fit.freedom <= 0 && !found.is_underdetermined)
        say(fmt::format(
            "There are no more data ({} points) than numbers sought: the fit cannot show whether the model is right",
            fit.points));
    if (const auto dead = names_where(unknowns, best.judged.is_dead); !dead.empty())
        say(fmt::format("Nothing that was measured changes with {}", listed(dead)));
    for (const std::vector<size_t>& alike : best.judged.tied) {
        std::vector<std::string> names;
        for (const size_t i : alike) names.push_back(unknowns[i].name);
        say(fmt::format("{} change the data alike: the data cannot tell them apart", listed(names)));
    }
    if (found.is_underdetermined) return verdict;
    constexpr size_t kSpelt = 5;
    for (size_t k = 0; k < std::min(kSpelt, best.judged.flat.size()); ++k)
        say(fmt::format("The data do not fix the combination {}", describe_combination(best.judged.flat[k], unknowns)));
    if (best.judged.flat.size() > kSpelt)
        say(fmt::format("The data do not fix {} combinations more", best.judged.flat.size() - kSpelt));
    if (best.judged.flat.empty())
        for (size_t k = 0; k < std::min(kSpelt, found.flat_in_file.size()); ++k)
            say(fmt::format(
                "At the file's values the data do not fix the combination {}: away from them it shows at second order only, "
                "and its intervals are approximate",
                describe_combination(found.flat_in_file[k], unknowns)));
    if (const auto held = names_where(unknowns, best.at_bound); !held.empty())
        say(fmt::format("{} {} at a bound: the data want it beyond", listed(held), are(held.size())));
    std::vector<bool> are_rough = best.are_limits_converged;
    are_rough.flip();
    if (const auto rough = names_where(unknowns, are_rough); !rough.empty()) say(describe_rough_limits(rough));
    for (const std::string& sentence : describe_limits(fit)) say(sentence);
    if (const std::string shift = describe_step(found.step_bias, best, unknowns, comparison.time_step()); !shift.empty())
        say(shift);
    if (found.failed > 0)
        say(fmt::format("From {} of the starting points the model had no answer, as: {}", found.failed,
                        found.first_failure));
    return verdict;
}

}  // namespace dttmm::host
