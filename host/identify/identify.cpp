// SPDX-License-Identifier: BSD-3-Clause
#include "identify/identify.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "analysis/json.h"
#include "analysis/modal_session.h"
#include "analysis/stop_signals.h"
#include "analysis/summary.h"
#include "identify/fit_curves.h"
#include "identify/identification.h"
#include "identify/verdict.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/results_folder.h"

namespace dttmm::host {

namespace {

Json names_of(const Unknowns& unknowns, const std::vector<bool>& is_meant) {
    Json names = Json::array();
    for (size_t i = 0; i < unknowns.size(); ++i)
        if (is_meant[i]) names.push_back(unknowns[i].name);
    return names;
}

Json describe_solution(const Solution& solution, const Unknowns& unknowns, const Fit& fit) {
    Json parameters = Json::object();
    for (size_t i = 0; i < unknowns.size(); ++i) {
        const Unknown& one = unknowns[i];
        const double x = solution.x(as_row(i)), deviation = solution.judged.deviations(as_row(i));
        const auto limit = [&](const std::optional<double>& at) { return at ? Json(one.value(*at)) : Json(); };
        parameters[one.name] = {
            {"value", one.value(x)},
            {"low", limit(solution.low[i])},
            {"high", limit(solution.high[i])},
            {"limits_converged", static_cast<bool>(solution.are_limits_converged[i])},
            {"deviation",
             std::isfinite(deviation) && !solution.judged.is_dead[i] ? Json(deviation * std::abs(one.slope(x))) : Json()},
            {"unit", one.unit},
            {"in_file", one.start}};
    }
    return {{"parameters", parameters}, {"chi2", solution.chi2}, {"points", fit.points}, {"starts", solution.starts}};
}

Json describe(const Identification& found, const Comparison& comparison, const Unknowns& unknowns,
              const std::vector<std::string>& verdict) {
    const Solution& best = found.solutions.front();
    // What the time step does to each unknown of the best solution, as share of a logarithmic one, else in its unit
    Json shifts = Json::object();
    for (Eigen::Index i = 0; i < found.step_bias.size(); ++i) {
        const Unknown& one = unknowns[as_size(i)];
        shifts[one.name] = one.is_logarithmic() ? found.step_bias(i) : one.slope(0) * found.step_bias(i);
    }
    Json solutions = Json::array(), flat = Json::array(), tied = Json::array(), flat_in_file = Json::array();
    for (const Eigen::VectorXd& one : found.flat_in_file) flat_in_file.push_back(describe_combination(one, unknowns));
    for (const Solution& one : found.solutions) solutions.push_back(describe_solution(one, unknowns, found.fit));
    for (const Eigen::VectorXd& one : best.judged.flat) flat.push_back(describe_combination(one, unknowns));
    for (const std::vector<size_t>& alike : best.judged.tied) {
        Json names = Json::array();
        for (const size_t i : alike) names.push_back(unknowns[i].name);
        tied.push_back(names);
    }
    return {{"format", "dttmm-identify/1"},
            {"verdict", join_sentences(verdict)},
            {"solutions", solutions},
            {"dead", names_of(unknowns, best.judged.is_dead)},
            {"flat", flat},
            {"flat_in_file", flat_in_file},
            {"tied", tied},
            {"at_bound", names_of(unknowns, best.at_bound)},
            {"fit", describe_fit(found.fit)},
            {"data", describe_groups(comparison)},
            {"underdetermined", found.is_underdetermined},
            {"shift_by_time_step", shifts},
            {"starting_points", found.starts},
            {"descents", found.descents},
            {"descents_failed", found.failed}};
}

void print(const Identification& found, const Comparison& comparison, const Unknowns& unknowns,
           const std::vector<std::string>& verdict) {
    for (const std::string& sentence : verdict) fmt::print("{}\n", printable(sentence + "."));
    constexpr size_t kMost = 10;
    for (size_t s = 0; s < std::min(kMost, found.solutions.size()); ++s) {
        const Solution& solution = found.solutions[s];
        fmt::print("\n{}chi2 {:.5g}, found from {} of {} descents\n",
                   found.solutions.size() > 1 ? fmt::format("solution {}: ", s + 1) : "", solution.chi2, solution.starts,
                   found.descents);
        for (size_t i = 0; i < unknowns.size() && !found.is_underdetermined; ++i) {
            const Unknown& one = unknowns[i];
            const bool is_known = solution.low[i] || solution.high[i];
            const double share = one.start != 0 ? one.value(solution.x(as_row(i))) / one.start : 0;
            fmt::print("    {}{}\n", describe_value(solution, unknowns, i),
                       is_known && one.of == Unknown::Of::parameter ? fmt::format(", {:.4g} times the file's", share) : "");
        }
    }
    if (found.solutions.size() > kMost) fmt::print("\nand {} more in identify.json\n", found.solutions.size() - kMost);
    fmt::print("\n95 % intervals; {}\n", describe_noise(comparison));
}

}  // namespace

ExitCode identify(const Request& request) {
    const StopSignals signals;
    const Plugins plugins(request.plugins);
    Warnings warnings;
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::modes;  // a model of modes needs no [simulation]
    const Model model = read_model(request.model, plugins.catalogue(), overrides);
    if (request.fit.free.empty() && request.fit.nuisances.empty())
        throw Error(ExitCode::usage,
                    fmt::format("what is sought? Give it with --free, e.g. --free {}",
                                model.parameters.empty() ? "bolt1.stiffness" : model.parameters.front().name));
    const Observations observations = read_observations(request, model, plugins, warnings);
    const Unknowns unknowns(request, model, plugins.catalogue(), observations.channel_names());
    Comparison comparison(request, observations, plugins);
    Identifier identifier(comparison, unknowns, read_priors(request.fit.priors, unknowns, model.parameters), request.jobs);
    const Identification found = identifier.identify(request.fit.starts, request.study.seed);
    const std::vector<std::string> verdict = make_verdict(found, comparison, unknowns);

    const ResultsFolder folder(results_path(request, "-identify"));
    Json json = describe(found, comparison, unknowns, verdict);
    const std::vector<ModePair> pairs = comparison.pairs(unknowns, found.solutions.front().x);
    json["modes"] = describe_pairs(observations, pairs);
    write_fit_curves(folder, observations, comparison, found.solutions.front().predicted);
    json["measured"] = observations.files;
    json["clock"] = observations.clock;
    json["warnings"] = describe_warnings(warnings);
    json["command_line"] = request.command_line;
    write_json(folder.file("identify.json"), json);
    if (!request.quiet) {
        print(found, comparison, unknowns, verdict);
        print_pairs(observations, pairs);
        fmt::print("results in {}\n", folder.describe("identify.json"));
    }
    return ExitCode::ok;
}

}  // namespace dttmm::host
