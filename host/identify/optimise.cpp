// SPDX-License-Identifier: BSD-3-Clause
#include "identify/optimise.h"

#include <fmt/format.h>
#include <nlopt.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <memory>

#include "analysis/json.h"
#include "analysis/modal_session.h"
#include "analysis/stop_signals.h"
#include "identify/figure_function.h"
#include "identify/forked_map.h"
#include "identify/unknowns.h"
#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/csv_table.h"
#include "record/results_folder.h"
#include "record/tell.h"
#include "study/design.h"
#include "study/distribution.h"
#include "study/text_list.h"

namespace dttmm::host {

namespace {

constexpr double kGradientStep = 1e-3;  // of the logarithm of a parameter: central differences
constexpr double kEnoughGain = 1e-9;    // share of the figure: smaller steps down are none
constexpr int kMostSteps = 200;         // evaluations of the figure with its gradient from one point
constexpr double kAtRange = 1e-6;       // share of the range: an end is reached

/// A parameter and where it may be.
struct Range {
    std::string name;
    double low = 0, high = 0;
};

std::vector<Range> read_ranges(const std::vector<std::string>& texts, const Model& model) {
    std::vector<Range> ranges;
    if (texts.empty())
        throw Error(ExitCode::usage, "which parameters change? Name them with --by, e.g. --by \"k1..k4 in 0.5..2\"");
    for (const std::string& text : texts) {
        const size_t in = text.find(" in ");
        if (in == text.npos)
            throw Error(ExitCode::usage, fmt::format("--by {}: to optimise, write NAMES in LOW..HIGH", quote(text)));
        const auto [low, high] = split_range(without_blanks_around(text.substr(in + 4)), "--by");
        for (const std::string& name : parameter_names(text.substr(0, in), model.parameters, "--by")) {
            const Parameter& own = *std::ranges::find(model.parameters, name, &Parameter::name);
            const auto bound = [&, low_text = low, high_text = high](bool is_low) {
                const std::string& one = is_low ? low_text : high_text;
                try {
                    return unit_text(one).empty() ? parse_quantity(one).value * own.value : parse_quantity(one, own.unit);
                } catch (const Error& error) {
                    throw Error(ExitCode::usage, fmt::format("--by {}: {}", quote(text), error.what()));
                }
            };
            Range range{name, bound(true), bound(false)};
            if (range.low > range.high && own.value < 0) std::swap(range.low, range.high);
            if (!(range.low > 0 && range.low < range.high))
                throw Error(ExitCode::usage,
                            fmt::format("--by {}: the range of {} must be above 0 and its ends differ, the lower one first",
                                        quote(text), quote(name)));
            if (std::ranges::find(ranges, name, &Range::name) != ranges.end())
                throw Error(ExitCode::usage, fmt::format("--by names {} twice", quote(name)));
            ranges.push_back(range);
        }
    }
    return ranges;
}

/// What is made least: the figure, its negative, or the square of its share of distance from a value.
class Objective {
public:
    Objective(const FigureFunction& function, const Goal& goal, size_t figure)
        : function_(function), goal_(goal), figure_(as_row(figure)) {
        if (goal.kind == Goal::Kind::value) value_ = parse_quantity(goal.value, function.figures()[figure].unit);
    }

    double of_figure(double figure) const {
        if (goal_.kind == Goal::Kind::least) return figure;
        if (goal_.kind == Goal::Kind::most) return -figure;
        const double scale = value_ != 0 ? value_ : 1;
        return (figure - value_) * (figure - value_) / (scale * scale);
    }

    /// x: logarithms. gradient: may be null. Infinite where the model has no answer.
    double evaluate(const Eigen::VectorXd& x, double* gradient) {
        const auto count = x.size();
        Eigen::MatrixXd rows(gradient ? 1 + 2 * count : 1, count);
        rows.rowwise() = x.transpose();
        for (Eigen::Index i = 0; gradient && i < count; ++i) {
            rows(1 + 2 * i, i) += kGradientStep;
            rows(2 + 2 * i, i) -= kGradientStep;
        }
        std::string failure;
        const Eigen::VectorXd figures = function_.evaluate(rows.array().exp().matrix(), 1, failure).col(figure_);
        last_ = figures(0);
        for (Eigen::Index i = 0; gradient && i < count; ++i)
            gradient[i] = (of_figure(figures(1 + 2 * i)) - of_figure(figures(2 + 2 * i))) / (2 * kGradientStep);
        if (!failure.empty() || StopSignals::requested()) has_failed_ = true;
        return of_figure(last_);
    }
    bool has_failed() const { return has_failed_; }
    double last() const { return last_; }

private:
    const FigureFunction& function_;
    const Goal& goal_;
    Eigen::Index figure_;
    double value_ = 0, last_ = 0;
    bool has_failed_ = false;
};

double call_objective(unsigned count, const double* x, double* gradient, void* data) {
    return static_cast<Objective*>(data)->evaluate(Eigen::Map<const Eigen::VectorXd>(x, count), gradient);
}

/// From one point: its coordinates, then the figure.
std::vector<double> descend_from(Eigen::VectorXd x, const Eigen::VectorXd& low, const Eigen::VectorXd& high,
                                 Objective objective) {
    const std::unique_ptr<std::remove_pointer_t<nlopt_opt>, void (*)(nlopt_opt)> solver(
        nlopt_create(NLOPT_LD_SLSQP, as_whole<unsigned>(x.size())), nlopt_destroy);
    const double before = objective.evaluate(x, nullptr), figure_before = objective.last();
    const Eigen::VectorXd start = x;
    nlopt_set_min_objective(solver.get(), call_objective, &objective);
    nlopt_set_lower_bounds(solver.get(), low.data());
    nlopt_set_upper_bounds(solver.get(), high.data());
    nlopt_set_ftol_rel(solver.get(), kEnoughGain);
    nlopt_set_xtol_rel(solver.get(), kEnoughGain);
    nlopt_set_maxeval(solver.get(), kMostSteps);
    double least = before;
    nlopt_optimize(solver.get(), x.data(), &least);
    if (objective.has_failed())
        throw Error(ExitCode::numerical_failure, "the model has no answer between the start and the optimum");
    double figure = figure_before;
    if (objective.evaluate(x, nullptr) <= before)
        figure = objective.last();
    else
        x = start;
    std::vector<double> numbers(x.begin(), x.end());
    numbers.push_back(figure);
    return numbers;
}

/// Where a descent ended.
struct Optimum {
    Eigen::VectorXd x;
    double figure = 0, objective = 0;
};

void report(const Request& request, const FigureFunction& function, const std::vector<Range>& ranges, const Column& figure,
            double at_file, const std::vector<Optimum>& optima, size_t starts, size_t failed,
            const std::vector<bool>& idle) {
    const ResultsFolder folder(results_path(request, "-optimise"));
    const Optimum& best = optima.front();
    std::vector<Column> columns = {{figure.name, figure.unit.empty() ? "1" : figure.unit}};
    for (const Column& one : function.parameters()) columns.push_back(one);
    CsvTable csv(columns);
    for (const Optimum& one : optima) csv.add(one.figure).add_all(Eigen::VectorXd(one.x.array().exp())).end_row();
    write_atomically(folder.file("optimise.csv"), csv.text());
    Json parameters = Json::object();
    std::vector<std::string> lines;
    constexpr double kSameFigure = 1e-4, kSameValues = 0.01;  // share; of logarithms
    size_t same = 0;
    std::vector<const Optimum*> sets;  // of values, among the equally good
    for (const Optimum& one : optima) {
        if (std::abs(one.figure - best.figure) > kSameFigure * std::abs(best.figure)) continue;
        ++same;
        const bool is_known = std::ranges::any_of(
            sets, [&](const Optimum* other) { return (other->x - one.x).cwiseAbs().maxCoeff() < kSameValues; });
        if (!is_known) sets.push_back(&one);
    }
    const Goal goal = parse_goal(request.fit.goal);
    const double wanted = goal.kind == Goal::Kind::value ? parse_quantity(goal.value, figure.unit) : best.figure;
    const bool is_reached =
        std::abs(best.figure - wanted) <= kSameFigure * std::max(std::abs(wanted), std::abs(best.figure));
    for (size_t i = 0; i < ranges.size(); ++i) {
        const double x = best.x(as_row(i)), low = std::log(ranges[i].low), high = std::log(ranges[i].high);
        const bool is_low = x - low < kAtRange * (high - low), is_high = high - x < kAtRange * (high - low);
        parameters[ranges[i].name] = {
            {"value", std::exp(x)}, {"in_file", function.nominal()(as_row(i))}, {"at_end_of_range", is_low || is_high}};
        lines.push_back(fmt::format("    {} = {:.6g} {}, {:.4g} times the file's{}", ranges[i].name, std::exp(x),
                                    function.parameters()[i].unit, std::exp(x) / function.nominal()(as_row(i)),
                                    is_low    ? ", the lower end of its range"
                                    : is_high ? ", the upper end of its range"
                                              : ""));
    }
    write_json(folder.file("optimise.json"), Json{{"format", "dttmm-optimise/1"},
                                                  {"goal", request.fit.goal},
                                                  {"figure", figure.name},
                                                  {"unit", figure.unit},
                                                  {"value", best.figure},
                                                  {"value_in_file", at_file},
                                                  {"parameters", parameters},
                                                  {"starts", starts},
                                                  {"failed", failed},
                                                  {"reached", is_reached},
                                                  {"ended_there", same},
                                                  {"sets_of_values", sets.size()},
                                                  {"command_line", request.command_line}});
    if (!is_reached) tell(fmt::format("warning: the goal {} is not reached within these ranges", quote(request.fit.goal)));
    if (request.quiet) return;
    fmt::print("{} = {:.7g} {}; with the file's values {:.7g}\n", figure.name, best.figure, figure.unit, at_file);
    for (const std::string& line : lines) fmt::print("{}\n", line);
    if (sets.size() > 1) fmt::print("{} different sets of values are as good: optimise.csv has them\n", sets.size());
    for (size_t i = 0; i < ranges.size(); ++i)
        if (idle[i]) fmt::print("{} changes nothing of it\n", ranges[i].name);
    fmt::print("{} of {} ended there{}; results in {}\n", same, counted(starts, "starting point", "starting points"),
               failed > 0 ? fmt::format(", {} failed", failed) : "", folder.describe("optimise.json"));
}

/// Parameters that the figure does not notice when they go from the best to their farther bound.
std::vector<bool> find_idle(const FigureFunction& function, const Eigen::VectorXd& best, const Eigen::VectorXd& low,
                            const Eigen::VectorXd& high, int jobs) {
    std::vector<bool> idle;
    std::string ignored;
    for (Eigen::Index i = 0; i < best.size(); ++i) {
        Eigen::MatrixXd rows(2, best.size());
        rows.row(0) = best.array().exp();
        rows.row(1) = rows.row(0);
        rows(1, i) = std::exp(std::abs(best(i) - low(i)) > 0.5 * (high(i) - low(i)) ? low(i) : high(i));
        const Eigen::MatrixXd figures = function.evaluate(rows, jobs, ignored);
        idle.push_back(figures(0, 0) == figures(1, 0));
    }
    return idle;
}

}  // namespace

Goal parse_goal(const std::string& text) {
    Goal goal;
    const size_t equals = text.find('=');
    if (text.starts_with("min ") || text.starts_with("max ")) {
        goal.kind = text.starts_with("min") ? Goal::Kind::least : Goal::Kind::most;
        goal.figure = without_blanks_around(text.substr(4));
    } else if (equals != text.npos) {
        goal.kind = Goal::Kind::value;
        goal.figure = without_blanks_around(text.substr(0, equals));
        goal.value = without_blanks_around(text.substr(equals + 1));
    }
    if (goal.figure.empty() || (goal.kind == Goal::Kind::value && goal.value.empty()))
        throw Error(ExitCode::usage,
                    fmt::format("--goal {}: write \"min FIGURE\", \"max FIGURE\" or \"FIGURE = VALUE\"", quote(text)));
    return goal;
}

ExitCode optimise(const Request& request) {
    const StopSignals signals;
    const Plugins plugins(request.plugins);
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::modes;
    const Model model = read_model(request.model, plugins.catalogue(), overrides);
    const Goal goal = parse_goal(request.fit.goal);
    const std::vector<Range> ranges = read_ranges(request.fit.by, model);
    std::vector<std::string> names;
    for (const Range& range : ranges) names.push_back(range.name);
    const FigureFunction function(request, model, plugins, names, {goal.figure});
    if (function.figures().size() != 1) {
        std::vector<std::string> all;
        for (const Column& one : function.figures()) all.push_back(one.name);
        throw Error(ExitCode::usage, fmt::format("--goal {}: that are {} figures ({}); name one", quote(request.fit.goal),
                                                 all.size(), listed(all)));
    }
    const auto count = as_row(ranges.size());
    Eigen::VectorXd low(count), high(count), first(count);
    for (Eigen::Index i = 0; i < count; ++i) {
        low(i) = std::log(ranges[as_size(i)].low);
        high(i) = std::log(ranges[as_size(i)].high);
        first(i) = std::clamp(std::log(std::abs(function.nominal()(i))), low(i), high(i));
    }
    const size_t starts = request.fit.starts > 0 ? as_size(request.fit.starts) : 4 + 4 * ranges.size();
    const Eigen::MatrixXd shares =
        make_probabilities(Design::sobol, as_row(starts), count, static_cast<std::uint64_t>(request.study.seed));
    const Objective objective(function, goal, 0);
    const std::vector<TaskResult> results = map_in_processes(starts, request.jobs, [&](size_t s) {
        const Eigen::VectorXd start =
            s == 0 ? first : Eigen::VectorXd(low.array() + shares.row(as_row(s)).transpose().array() * (high - low).array());
        return descend_from(start, low, high, objective);
    });
    std::vector<Optimum> optima;
    std::string failure;
    for (const TaskResult& result : results) {
        if (!result.reason.empty()) {
            if (failure.empty()) failure = result.reason;
            continue;
        }
        Optimum one{Eigen::Map<const Eigen::VectorXd>(result.numbers.data(), count), result.numbers.back(),
                    objective.of_figure(result.numbers.back())};
        if (std::isfinite(one.figure)) optima.push_back(std::move(one));
    }
    if (optima.empty()) throw Error(ExitCode::numerical_failure, fmt::format("no starting point led anywhere: {}", failure));
    std::ranges::stable_sort(optima, [](const Optimum& a, const Optimum& b) { return a.objective < b.objective; });
    std::string ignored;
    const double at_file = function.evaluate(function.nominal().transpose(), 1, ignored)(0, 0);
    const std::vector<bool> idle = find_idle(function, optima.front().x, low, high, request.jobs);
    report(request, function, ranges, function.figures().front(), at_file, optima, starts, starts - optima.size(), idle);
    return ExitCode::ok;
}

}  // namespace dttmm::host
