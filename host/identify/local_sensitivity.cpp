// SPDX-License-Identifier: BSD-3-Clause
#include "identify/local_sensitivity.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "analysis/json.h"
#include "analysis/modal_session.h"
#include "analysis/stop_signals.h"
#include "identify/mode_derivatives.h"
#include "identify/response_derivatives.h"
#include "identify/run_derivatives.h"
#include "identify/small_changes.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/csv_table.h"
#include "record/results_folder.h"
#include "study/design.h"
#include "study/distribution.h"
#include "study/text_list.h"

namespace dttmm::host {

namespace {

constexpr int kLevels = kSlopeLevels;
constexpr double kFarthestPoint = 0.02;  // of the logarithm of a parameter; halved from level to level
constexpr double kFiner = 0.1;           // times the distances, where errors say that figures bend more than that
constexpr int kMostFiner = 3;
constexpr double kBent = 1e-4;         // error that says so, share of the largest slope of the figure
constexpr double kOneMode = 1e-6;      // share: frequencies this near are one multiple frequency
constexpr int kCheckCases = 200;       // that check a linear estimate of scatter
constexpr double kUncertain = 0.01;    // error of a slope, share of the largest of its figure: worth a word
constexpr double kNothing = 1e-9;      // of the figure: what nothing depends on has no slope but that of rounding
constexpr double kSmallChange = 0.01;  // change of a logarithm that makes another extreme the largest: worth a word

bool is_frequency(const Column& column) { return column.name.starts_with("mode") && column.name.ends_with(".frequency"); }

/// Values of the branches of one multiple frequency on both sides of the file's values, each ascending.
struct Branches {
    Eigen::VectorXd above, below;
};

/// Which of the values below goes on as which above: a right pair lies on a line through the file's value up to its
/// curvature, which falls fourfold when the distance is halved; of a wrong one it falls twofold. Fewest exchanges first:
/// branches with one slope keep their order.
std::vector<Eigen::Index> pair_branches(const Branches& far, const Branches& near, double at) {
    constexpr double kFalls = 3;         // between two- and fourfold
    constexpr double kRounding = 1e-11;  // share of the frequency
    std::vector<Eigen::Index> order(as_size(far.above.size())), best;
    std::iota(order.begin(), order.end(), Eigen::Index{0});
    const auto bend = [&](const Branches& own) {
        double sum = 0;
        for (size_t i = 0; i < order.size(); ++i) sum += std::abs(own.above(as_row(i)) + own.below(order[i]) - 2 * at);
        return sum;
    };
    size_t fewest = std::numeric_limits<size_t>::max();
    double least = std::numeric_limits<double>::infinity();
    do {
        size_t exchanges = 0;
        for (size_t i = 0; i < order.size(); ++i)
            for (size_t j = i + 1; j < order.size(); ++j) exchanges += order[i] > order[j];
        const double wide = bend(far);
        const bool is_line = wide < kRounding * std::abs(at) || wide > kFalls * bend(near);
        if (is_line ? exchanges >= fewest : fewest < std::numeric_limits<size_t>::max() || wide >= least) continue;
        if (is_line) fewest = exchanges;
        least = wide;
        best = order;
    } while (std::ranges::next_permutation(order).found);
    return best;
}

/// Puts the figures below the file's values, a row per distance, into the order of the branches above them.
void join_branches(const std::vector<Column>& figures, const Eigen::VectorXd& nominal, const Eigen::MatrixXd& above,
                   Eigen::MatrixXd& below) {
    constexpr Eigen::Index kMost = 6;  // branches: their orders are counted out
    for (Eigen::Index first = 0, end = 0; first < nominal.size(); first = end) {
        end = first + 1;
        if (!is_frequency(figures[as_size(first)])) continue;
        while (end < nominal.size() && is_frequency(figures[as_size(end)]) &&
               std::abs(nominal(end) - nominal(first)) <= kOneMode * std::abs(nominal(first)))
            ++end;
        const Eigen::Index count = end - first;
        if (count < 2 || count > kMost) continue;
        const auto branches = [&](Eigen::Index level) {
            return Branches{above.row(level).segment(first, count), below.row(level).segment(first, count)};
        };
        const std::vector<Eigen::Index> order = pair_branches(branches(0), branches(1), nominal(first));
        const Eigen::MatrixXd own = below.middleCols(first, count);
        for (Eigen::Index i = 0; i < count; ++i) below.col(first + i) = own.col(order[as_size(i)]);
    }
}

LocalSensitivity differentiate_from(double farthest, const FigureFunction& function, int jobs) {
    const Eigen::VectorXd& nominal = function.nominal();
    const auto count = nominal.size();
    Eigen::MatrixXd points(1 + 2 * kLevels * count, count);
    points.rowwise() = nominal.transpose();
    const auto row_of = [&](Eigen::Index p, int level, int side) { return 1 + (p * kLevels + level) * 2 + side; };
    for (Eigen::Index p = 0; p < count; ++p)
        for (int level = 0; level < kLevels; ++level)
            for (int side = 0; side < 2; ++side)
                points(row_of(p, level, side), p) *= std::exp((side == 0 ? 1 : -1) * farthest / (1 << level));
    std::string failure;
    const Eigen::MatrixXd figures = function.evaluate(points, jobs, failure);
    if (!failure.empty())
        throw Error(ExitCode::numerical_failure, fmt::format("near the file's values the model has no answer: {}", failure));
    LocalSensitivity found;
    found.figures = figures.row(0);
    found.slopes.resize(figures.cols(), count);
    found.errors.resize(figures.cols(), count);
    for (Eigen::Index p = 0; p < count; ++p) {
        Eigen::MatrixXd above(kLevels, figures.cols()), below(kLevels, figures.cols());
        for (int l = 0; l < kLevels; ++l) {
            above.row(l) = figures.row(row_of(p, l, 0));
            below.row(l) = figures.row(row_of(p, l, 1));
        }
        join_branches(function.figures(), found.figures, above, below);
        for (Eigen::Index f = 0; f < figures.cols(); ++f) {
            std::array<SlopeAt, kLevels> level;
            for (int l = 0; l < kLevels; ++l)
                level[as_size(l)] = SlopeAt::of(above(l, f), found.figures(f), below(l, f), farthest / (1 << l));
            std::tie(found.slopes(f, p), found.errors(f, p)) = extrapolate(level);
        }
    }
    return found;
}

bool is_bent(const LocalSensitivity& local) {
    for (Eigen::Index f = 0; f < local.slopes.rows(); ++f) {
        const double error = local.errors.row(f).maxCoeff();
        if (error > kBent * local.slopes.row(f).cwiseAbs().maxCoeff() && error > kNothing * std::abs(local.figures(f)))
            return true;
    }
    return false;
}

/// An extreme of a history: it has its peaks at rows, and near by that is another figure than the one between them.
bool is_extreme(const FigureFunction& function, Eigen::Index figure) {
    const std::string& name = function.figures()[as_size(figure)].name;
    return function.command() == "run" && std::ranges::any_of(std::array{".peak", ".time", ".minimum", ".maximum"},
                                                              [&](const char* end) { return name.ends_with(end); });
}

}  // namespace

LocalSensitivity differentiate_figures(const FigureFunction& function, int jobs) {
    LocalSensitivity found = differentiate_from(kFarthestPoint, function, jobs);
    double farthest = kFarthestPoint;
    for (int n = 0; n < kMostFiner && is_bent(found); ++n) {
        farthest *= kFiner;
        const LocalSensitivity next = differentiate_from(farthest, function, jobs);
        // A figure has all of its slopes from one of the distances. Beside a jump the nearest is worst until it is nearer
        for (Eigen::Index f = 0; f < found.slopes.rows(); ++f) {
            if (is_extreme(function, f) || !(next.errors.row(f).maxCoeff() < found.errors.row(f).maxCoeff())) continue;
            found.slopes.row(f) = next.slopes.row(f);
            found.errors.row(f) = next.errors.row(f);
        }
    }
    // A row near an extreme has another slope than the extreme; how far off is not known
    for (Eigen::Index f = 0; f < found.slopes.rows(); ++f)
        if (is_extreme(function, f)) found.errors.row(f).setConstant(std::nan(""));
    return found;
}

namespace {

/// Names that --by or --vary means.
std::vector<std::string> parameters_of(const Request& request, const Model& model) {
    std::vector<std::string> names;
    const auto add = [&](const std::string& name) {
        if (std::ranges::find(names, name) == names.end()) names.push_back(name);
    };
    for (const std::string& text : request.fit.by)
        for (const std::string& name : parameter_names(text, model.parameters, "--by")) add(name);
    for (const std::string& text : request.study.variations)
        for (const std::string& name : parse_variation(text, model.parameters).names) add(name);
    if (names.empty()) throw Error(ExitCode::usage, "which parameters change? Name them with --by, e.g. --by k1..k4");
    for (const std::string& name : names)
        if (std::ranges::find(model.parameters, name, &Parameter::name)->value == 0)
            throw Error(ExitCode::usage,
                        fmt::format("--by {}: its value in the file is 0, of which there is no per cent", quote(name)));
    return names;
}

/// How far figures scatter with parameters that scatter as --vary says.
struct Scatter {
    Eigen::VectorXd linear;   ///< standard deviations by the slopes
    Eigen::VectorXd sampled;  ///< by cases, without what so few draws make of a linear figure's
    Eigen::VectorXd mean;
    Eigen::Index cases = 0, failed = 0;
};

double mean_of(const std::vector<double>& values) {
    double mean = 0;
    for (const double value : values) mean += value / static_cast<double>(values.size());
    return mean;
}

double standard_deviation(const std::vector<double>& values) {
    const double mean = mean_of(values);
    double squares = 0;
    for (const double value : values) squares += (value - mean) * (value - mean) / static_cast<double>(values.size());
    return std::sqrt(squares);
}

double deviation_of(const Distribution& one) {
    if (one.kind == Distribution::Kind::uniform) return (one.high - one.low) / std::sqrt(12.0);
    return one.kind == Distribution::Kind::list ? standard_deviation(one.values) : one.deviation;
}

Scatter find_scatter(const Request& request, const Model& model, const FigureFunction& function,
                     const LocalSensitivity& local) {
    std::vector<Distribution> distributions(function.parameters().size());
    std::vector<bool> varies(distributions.size(), false);
    for (const std::string& text : request.study.variations) {
        const Variation variation = parse_variation(text, model.parameters);
        for (const std::string& name : variation.names)
            for (size_t p = 0; p < distributions.size(); ++p)
                if (function.parameters()[p].name == name) {
                    distributions[p] = variation.distribution;
                    varies[p] = true;
                }
    }
    const auto count = as_row(distributions.size());
    const Eigen::MatrixXd shares = make_probabilities(Design::latin, kCheckCases, count, 1);
    Eigen::MatrixXd points(kCheckCases, count);
    points.rowwise() = function.nominal().transpose();
    Scatter scatter;
    scatter.linear = Eigen::VectorXd::Zero(local.figures.size());
    const Eigen::MatrixXd slopes = local.slopes * function.nominal().cwiseInverse().asDiagonal();
    for (Eigen::Index p = 0; p < count; ++p) {
        if (!varies[as_size(p)]) continue;
        for (Eigen::Index i = 0; i < kCheckCases; ++i) points(i, p) = distributions[as_size(p)].quantile(shares(i, p));
        const double deviation = deviation_of(distributions[as_size(p)]);
        scatter.linear += (slopes.col(p) * deviation).cwiseAbs2();
    }
    scatter.linear = scatter.linear.cwiseSqrt();
    std::string failure;
    const Eigen::MatrixXd figures = function.evaluate(points, request.jobs, failure);
    scatter.sampled = scatter.mean = Eigen::VectorXd::Zero(figures.cols());
    for (Eigen::Index f = 0; f < figures.cols(); ++f) {
        std::vector<double> own, by_slopes;  // of each case
        for (Eigen::Index i = 0; i < kCheckCases; ++i) {
            if (std::isnan(figures(i, f))) continue;
            own.push_back(figures(i, f));
            by_slopes.push_back(slopes.row(f).dot(points.row(i) - function.nominal().transpose()));
        }
        scatter.mean(f) = mean_of(own);
        const double drawn = standard_deviation(by_slopes);
        scatter.sampled(f) = standard_deviation(own) * (drawn > 0 ? scatter.linear(f) / drawn : 1);
        scatter.cases = kCheckCases;
        scatter.failed = std::max(scatter.failed, kCheckCases - as_row(own.size()));
    }
    return scatter;
}

/// % per %; of a figure that is zero there is none.
double per_cent(const LocalSensitivity& local, Eigen::Index f, Eigen::Index p) {
    return local.figures(f) != 0 ? local.slopes(f, p) / local.figures(f) : std::nan("");
}

/// Whether another extreme, with another slope, is the largest after a small change of the parameter.
bool has_competing(const LocalSensitivity& local, Eigen::Index f, Eigen::Index p) {
    if (local.competing.size() == 0 || local.reach(f, p) > kSmallChange) return false;
    const double apart = std::abs(local.competing(f, p) - local.slopes(f, p));
    return apart > kUncertain * local.slopes.row(f).cwiseAbs().maxCoeff() && apart > local.errors(f, p);
}

/// How the derivatives were found; why not directly, where that was wanted.
struct Method {
    std::string name = "differences", reason = {};
};

/// Whether figures of a command are differentiated directly.
bool is_direct(const FigureFunction& function, const Column& figure) {
    if (function.command() == "run") return true;
    return function.command() == "modes" ? is_natural_frequency(figure) : is_largest(figure);
}

/// Directly where that can be done, else by differences.
LocalSensitivity differentiate(const FigureFunction& function, int jobs, Method& method) {
    const auto& figures = function.figures();
    const auto direct = [&](const Column& figure) { return is_direct(function, figure); };
    LocalSensitivity found;
    found.figures.setZero(as_row(figures.size()));
    found.slopes = found.errors = found.competing = Eigen::MatrixXd::Zero(found.figures.size(), function.nominal().size());
    found.reach.setConstant(found.slopes.rows(), found.slopes.cols(), std::numeric_limits<double>::infinity());
    const auto way = function.command() == "run"     ? differentiate_run
                     : function.command() == "modes" ? differentiate_modes
                                                     : differentiate_responses;
    const bool is_found = std::ranges::any_of(figures, direct) && way(function, jobs, found, method.reason);
    const bool are_all = std::ranges::all_of(figures, direct);
    if (is_found) method.name = are_all ? "direct differentiation" : "direct differentiation and differences";
    if (is_found && are_all) return found;
    const LocalSensitivity others = differentiate_figures(function, jobs);
    for (Eigen::Index f = 0; f < found.slopes.rows(); ++f) {
        if (is_found && direct(figures[as_size(f)])) continue;
        found.figures(f) = others.figures(f);
        found.slopes.row(f) = others.slopes.row(f);
        found.errors.row(f) = others.errors.row(f);
    }
    return found;
}

void write_tables(const ResultsFolder& folder, const Request& request, const FigureFunction& function,
                  const LocalSensitivity& local, const std::optional<Scatter>& scatter, const Method& method) {
    CsvTable csv({{"figure", ""},
                  {"unit", ""},
                  {"parameter", ""},
                  {"value", "SI"},
                  {"percent_per_percent", "1"},
                  {"per_logarithm", "SI"},
                  {"error", "SI"}});
    Json list = Json::array();
    const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(); };
    for (Eigen::Index f = 0; f < local.figures.size(); ++f) {
        const Column& figure = function.figures()[as_size(f)];
        Json by = Json::object();
        for (Eigen::Index p = 0; p < local.slopes.cols(); ++p) {
            const std::string& name = function.parameters()[as_size(p)].name;
            csv.add(figure.name)
                .add(figure.unit)
                .add(name)
                .add(local.figures(f))
                .add(per_cent(local, f, p))
                .add(local.slopes(f, p))
                .add(local.errors(f, p))
                .end_row();
            by[name] = {{"percent_per_percent", number(per_cent(local, f, p))},
                        {"per_logarithm", number(local.slopes(f, p))},
                        {"error", number(local.errors(f, p))}};
            if (has_competing(local, f, p)) {
                by[name]["competing"] = {{"change_of_logarithm", local.reach(f, p)},
                                         {"per_logarithm", number(local.competing(f, p))}};
                if (local.competing_at.size() > 0)
                    by[name]["competing"][function.command() == "run" ? "time" : "frequency_hz"] =
                        number(local.competing_at(f));
            }
        }
        Json one = {{"figure", figure.name}, {"unit", figure.unit}, {"value", number(local.figures(f))}, {"by", by}};
        if (scatter)
            one["scatter"] = {{"linear", number(scatter->linear(f))},
                              {"sampled", number(scatter->sampled(f))},
                              {"mean", number(scatter->mean(f))}};
        list.push_back(one);
    }
    write_atomically(folder.file("sensitivity.csv"), csv.text());
    write_json(folder.file("sensitivity.json"), Json{{"format", "dttmm-sensitivity/1"},
                                                     {"command", function.command()},
                                                     {"method", method.name},
                                                     {"reason", method.reason.empty() ? Json() : Json(method.reason)},
                                                     {"figures", list},
                                                     {"command_line", request.command_line}});
}

void print_scatter(const FigureFunction& function, const Scatter& scatter, size_t width) {
    fmt::print("\n{:<{}} {:>14} {:>14} {:>14}\n", "scatter", width, "deviation", "by cases", "not linear");
    for (Eigen::Index f = 0; f < scatter.linear.size(); ++f)
        fmt::print("{:<{}} {:>14.6g} {:>14.6g} {:>13.2g}%\n", function.figures()[as_size(f)].name, width, scatter.linear(f),
                   scatter.sampled(f), scatter.sampled(f) > 0 ? 100 * (scatter.sampled(f) / scatter.linear(f) - 1) : 0.0);
    fmt::print("deviation: by the slopes above; by cases: of {} cases, {} of which failed\n", scatter.cases, scatter.failed);
}

void print(const FigureFunction& function, const LocalSensitivity& local, const std::optional<Scatter>& scatter,
           const Method& method) {
    size_t width = 8;
    for (const Column& one : function.figures()) width = std::max(width, one.name.size());
    std::string head = fmt::format("{:<{}} {:>14} {:<8}", "% per %", width, "value", "");
    for (const Column& one : function.parameters()) head += fmt::format(" {:>11}", one.name);
    fmt::print("{}\n", head);
    const bool is_run = function.command() == "run";
    std::vector<std::string> uncertain, of_rows, doubtful;
    for (Eigen::Index f = 0; f < local.figures.size(); ++f) {
        const Column& one = function.figures()[as_size(f)];
        std::string line = fmt::format("{:<{}} {:>14.7g} {:<8}", one.name, width, local.figures(f), one.unit);
        const double largest = local.slopes.row(f).cwiseAbs().maxCoeff();
        bool is_uncertain = false;
        for (Eigen::Index p = 0; p < local.slopes.cols(); ++p) {
            const double value = per_cent(local, f, p);
            line += std::isnan(value) ? fmt::format(" {:>11}", "-") : fmt::format(" {:>+11.4f}", value);
            is_uncertain = is_uncertain || (local.errors(f, p) > kUncertain * largest &&
                                            local.errors(f, p) > kNothing * std::abs(local.figures(f)));
        }
        if (is_uncertain) uncertain.push_back(one.name);
        if (local.errors.row(f).hasNaN()) of_rows.push_back(one.name);
        bool is_doubtful = false;
        for (Eigen::Index p = 0; p < local.slopes.cols(); ++p) is_doubtful = is_doubtful || has_competing(local, f, p);
        const bool has_place = local.competing_at.size() > 0;
        if (is_doubtful)
            doubtful.push_back(has_place
                                   ? fmt::format("{} (at {:.6g} {})", one.name, local.competing_at(f), is_run ? "s" : "Hz")
                                   : one.name);
        fmt::print("{}\n", line);
    }
    if (!uncertain.empty())
        fmt::print("known to worse than 1 % only{}: {}\n",
                   is_run && !method.reason.empty() ? ", as where a peak moves from one instant to another" : "",
                   listed(uncertain));
    if (!of_rows.empty())
        fmt::print(
            "with an unknown error, for they are slopes at the row that is largest, not at the extreme between rows: {}; "
            "closer rows ([output] step) bring them together\n",
            listed(of_rows));
    if (!doubtful.empty())
        fmt::print("after a change of a parameter by less than 1 % {}, and other slopes hold: {}\n",
                   is_run                          ? "another extreme is the largest"
                   : function.command() == "modes" ? "two frequencies come together"
                                                   : "another peak is the largest",
                   listed(doubtful));
    if (!method.reason.empty())
        fmt::print("by differences of {}: {}\n",
                   is_run                          ? "whole runs"
                   : function.command() == "modes" ? "frequencies"
                                                   : "responses",
                   method.reason);
    if (scatter) print_scatter(function, *scatter, width);
}

}  // namespace

ExitCode find_sensitivities(const Request& request) {
    const StopSignals signals;
    const Plugins plugins(request.plugins);
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::modes;
    const Model model = read_model(request.model, plugins.catalogue(), overrides);
    const FigureFunction function(request, model, plugins, parameters_of(request, model), request.study.figures);
    Method method;
    const LocalSensitivity local = differentiate(function, request.jobs, method);
    std::optional<Scatter> scatter;
    if (!request.study.variations.empty()) scatter = find_scatter(request, model, function, local);
    const ResultsFolder folder(results_path(request, "-sensitivity"));
    write_tables(folder, request, function, local, scatter, method);
    if (!request.quiet) {
        print(function, local, scatter, method);
        fmt::print("results in {}\n", folder.describe("sensitivity.csv"));
    }
    return ExitCode::ok;
}

}  // namespace dttmm::host
