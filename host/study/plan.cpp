// SPDX-License-Identifier: BSD-3-Clause
#include "study/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "analysis/sweep_plan.h"
#include "model/error.h"
#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"
#include "study/case_runner.h"
#include "study/design.h"
#include "study/distribution.h"

namespace dttmm::host {

namespace {

const Parameter& parameter_called(const std::string& name, const Model& model) {
    return *std::ranges::find(model.parameters, name, &Parameter::name);
}

/// A parameter that varies, with its own distribution.
struct Varied {
    std::string name;
    Distribution distribution;
};

std::vector<Varied> find_varied(const Request& request, const Model& model) {
    std::vector<Varied> varied;
    for (const std::string& text : request.study.variations) {
        const Variation variation = parse_variation(text, model.parameters);
        for (const std::string& name : variation.names) {
            if (std::ranges::find(varied, name, &Varied::name) != varied.end())
                throw Error(ExitCode::usage, fmt::format("--vary names the parameter {} twice", quote(name)));
            varied.push_back({name, variation.distribution});
        }
    }
    return varied;
}

/// "k1..k4 = 0.5": what stands before and behind the equals sign.
std::pair<std::string, double> split_correlation(const std::string& text) {
    const size_t equals = text.find('=');
    double value = 0;
    const char* const end = text.data() + text.size();
    const char* begin = equals == text.npos ? end : text.data() + equals + 1;
    while (begin != end && *begin == ' ') ++begin;
    if (begin != end && *begin == '+') ++begin;
    const auto [next, fault] = std::from_chars(begin, end, value);
    if (fault != std::errc() || next != end || !(value > -1 && value < 1))
        throw Error(ExitCode::usage, fmt::format("--correlate {}: write names = number, the number between -1 and 1, e.g. "
                                                 "\"k1..k4 = 0.5\"",
                                                 quote(text)));
    return {text.substr(0, equals), value};
}

Eigen::MatrixXd read_correlations(const Request& request, const Model& model, const std::vector<Varied>& varied) {
    Eigen::MatrixXd all = Eigen::MatrixXd::Identity(as_row(varied.size()), as_row(varied.size()));
    for (const std::string& text : request.study.correlations) {
        const auto [names, value] = split_correlation(text);
        std::vector<Eigen::Index> places;
        for (const std::string& name : parameter_names(names, model.parameters, "--correlate " + quote(text))) {
            const auto found = std::ranges::find(varied, name, &Varied::name);
            if (found == varied.end())
                throw Error(ExitCode::usage,
                            fmt::format("--correlate {}: --vary does not vary {}", quote(text), quote(name)));
            if (std::ranges::find(places, found - varied.begin()) != places.end())
                throw Error(ExitCode::usage, fmt::format("--correlate {}: {} is named twice", quote(text), quote(name)));
            places.push_back(found - varied.begin());
        }
        if (places.size() < 2)
            throw Error(ExitCode::usage, fmt::format("--correlate {}: it takes two parameters or more", quote(text)));
        for (const Eigen::Index a : places)
            for (const Eigen::Index b : places)
                if (a != b) {
                    if (all(a, b) != 0 && all(a, b) != value)
                        throw Error(
                            ExitCode::usage,
                            fmt::format("--correlate {}: {} and {} have another correlation already, {:g}", quote(text),
                                        quote(varied[as_size(a)].name), quote(varied[as_size(b)].name), all(a, b)));
                    all(a, b) = value;
                }
    }
    return all;
}

/// The file's values, then one parameter after the other at its 5 % and 95 % quantiles, or at each value of its list.
Eigen::MatrixXd one_at_a_time(const std::vector<Varied>& varied, const Model& model) {
    std::vector<std::pair<Eigen::Index, double>> changes;
    Eigen::RowVectorXd nominal(as_row(varied.size()));
    for (size_t p = 0; p < varied.size(); ++p) {
        const Distribution& distribution = varied[p].distribution;
        nominal(as_row(p)) = parameter_called(varied[p].name, model).value;
        if (distribution.kind == Distribution::Kind::list)
            for (const double value : distribution.values) changes.emplace_back(as_row(p), value);
        else
            for (const double share : {0.05, 0.95}) changes.emplace_back(as_row(p), distribution.quantile(share));
    }
    Eigen::MatrixXd values(as_row(changes.size()) + 1, nominal.size());
    values.rowwise() = nominal;
    for (size_t i = 0; i < changes.size(); ++i) values(as_row(i) + 1, changes[i].first) = changes[i].second;
    return values;
}

CaseTable draw_cases(const Request& request, const Model& model) {
    const std::vector<Varied> varied = find_varied(request, model);
    CaseTable table;
    for (const Varied& one : varied) table.parameters.push_back({one.name, parameter_called(one.name, model).unit});
    const Design design = request.study.design.empty() ? Design::latin : parse_design(request.study.design);
    if (design == Design::single) {
        if (request.study.cases > 0 || !request.study.correlations.empty())
            throw Error(ExitCode::usage,
                        "--design one-at-a-time has its own number of cases and no correlation: leave --cases "
                        "and --correlate out");
        table.values = one_at_a_time(varied, model);
        return table;
    }
    for (const Varied& one : varied) refuse_set_beside("--vary", one.name, request.overrides.parameters);
    if (request.study.cases == 0) throw Error(ExitCode::usage, "how many cases? --vary wants --cases, e.g. --cases 1000");
    const Eigen::Index block = block_size(design, as_row(varied.size()));
    if (block > 1 && !request.study.correlations.empty())
        throw Error(ExitCode::usage, fmt::format("--correlate: the design {} is of parameters that are independent of each "
                                                 "other",
                                                 request.study.design));
    if (block > 1 && request.study.cases < 10 * block)
        throw Error(ExitCode::usage,
                    fmt::format("--cases {}: the design {} of {} takes {} cases at least, ten blocks of {}; "
                                "some hundred blocks tell more",
                                request.study.cases, request.study.design, counted(varied.size(), "parameter", "parameters"),
                                10 * block, block));
    Eigen::MatrixXd u = make_probabilities(design, request.study.cases, as_row(varied.size()),
                                           static_cast<std::uint64_t>(request.study.seed));
    if (!request.study.correlations.empty()) correlate(u, read_correlations(request, model, varied));
    table.values.resize(u.rows(), u.cols());
    for (Eigen::Index p = 0; p < u.cols(); ++p)
        for (Eigen::Index i = 0; i < u.rows(); ++i) table.values(i, p) = varied[as_size(p)].distribution.quantile(u(i, p));
    return table;
}

CaseTable listed_cases(const Request& request, const Model& model) {
    CaseTable table = read_case_table(request.study.table, model.parameters);
    for (const Column& column : table.parameters) refuse_set_beside("--table", column.name, request.overrides.parameters);
    return table;
}

CaseTable grid_cases(const Request& request, const Model& model) {
    std::vector<SweepAxis> axes;
    for (const std::string& text : request.sweeps) axes.push_back(parse_sweep_axis(text));
    check_axes(axes, model.parameters, request.overrides.parameters);
    const std::vector<SweepCase> grid = make_grid(axes);
    CaseTable table;
    for (const SweepAxis& axis : axes) table.parameters.push_back({axis.name, parameter_called(axis.name, model).unit});
    table.values.resize(as_row(grid.size()), as_row(axes.size()));
    for (size_t i = 0; i < grid.size(); ++i)
        for (size_t p = 0; p < axes.size(); ++p) {
            const std::string& unit = table.parameters[p].unit;
            table.values(as_row(i), as_row(p)) =
                unit.empty() ? parse_quantity(grid[i][p].second).value : parse_quantity(grid[i][p].second, unit);
        }
    return table;
}

unsigned bit_of(const std::string& command) {
    if (command == "run") return kRun;
    if (command == "modes") return kModes;
    if (command == "response") return kResponse;
    throw Error(ExitCode::usage, fmt::format("--command {}: a study has no such command{}", quote(command),
                                             suggestion(command, {"run", "modes", "response"})));
}

}  // namespace

void refuse_options_beside(const Request& request, const std::string& command, const std::string& what) {
    constexpr unsigned kEvery = kRun | kModes | kResponse;
    const unsigned bit = bit_of(command);
    for (const auto& [option, value] : request.given)
        if (option->changes_results && (option->commands & kEvery) && !(option->commands & bit))
            throw Error(ExitCode::usage, fmt::format("{} is no option of {}, which {}", option->name(), command, what));
}

CaseTable make_cases(const Request& request, const Model& model) {
    const int ways = !request.study.variations.empty() + !request.sweeps.empty() + !request.study.table.empty();
    if (ways == 0)
        throw Error(ExitCode::usage,
                    "nothing varies: give --vary \"k1..k4 ~ normal(500 N/mm, 10 %)\" with --cases, --sweep "
                    "k1=300N/mm..500N/mm:9 or --table cases.csv");
    if (ways > 1) throw Error(ExitCode::usage, "--vary, --sweep and --table exclude each other: give one of them");
    if (request.study.variations.empty() &&
        (request.study.cases > 0 || !request.study.design.empty() || !request.study.correlations.empty()))
        throw Error(ExitCode::usage, "--cases, --design and --correlate go with --vary only");
    CaseTable table = !request.study.variations.empty() ? draw_cases(request, model)
                      : !request.sweeps.empty()         ? grid_cases(request, model)
                                                        : listed_cases(request, model);
    for (Column& column : table.parameters) {
        if (column.unit.empty()) column.unit = "1";
        if (column.name == "case" || column.name == "status" || column.name == "warnings")
            throw Error(ExitCode::usage,
                        fmt::format("the results of a study have a column {} of their own: give the parameter another name",
                                    quote(column.name)));
    }
    if (!table.values.allFinite())
        throw Error(ExitCode::usage, "a distribution has values beyond the largest number; give a narrower one");
    return table;
}

StudyPlan make_plan(const Request& request, const Model& model, const Plugins& plugins) {
    StudyPlan plan;
    plan.command = request.study.work.empty() ? "run" : request.study.work;
    refuse_options_beside(request, plan.command, "every case of this study does");
    plan.request = request;
    plan.figures = request.study.figures;
    plan.parameters = model.parameters;
    plan.keeps = request.study.keeps;
    if (plan.keeps && plan.command == "modes")
        throw Error(ExitCode::usage,
                    "--keep: a study of modes keeps no results of its cases; run the case of interest with "
                    "dttmm modes and --set");
    plan.limit = request.study.limit.empty() ? 0 : parse_quantity(request.study.limit, "s");
    if (!request.study.limit.empty() && !(plan.limit >= 0.001 && plan.limit <= 1e8))
        throw Error(ExitCode::usage, fmt::format("--limit {}: it must be 1 ms to 1e8 s", quote(request.study.limit)));
    plan.cases = make_cases(request, model);
    if (!request.study.variations.empty()) plan.design = request.study.design.empty() ? "latin" : request.study.design;
    plan.columns = find_figures(plan, plugins);
    if (plan.columns.empty())
        throw Error(ExitCode::usage, "the cases have no figures: ask for some with --figures, e.g. \"*.position.z:peak\"");
    return plan;
}

}  // namespace dttmm::host
