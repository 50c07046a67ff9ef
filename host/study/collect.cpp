// SPDX-License-Identifier: BSD-3-Clause
#include "study/collect.h"

#include <fmt/format.h>
#include <sys/file.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <limits>

#include "analysis/json.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/csv_table.h"
#include "record/csv_writer.h"
#include "record/file.h"
#include "record/hdf5_writer.h"
#include "record/tell.h"
#include "study/sensitivity.h"
#include "study/statistics.h"

namespace dttmm::host {

namespace {

/// The numbers of one figure, a case each; NaN where the case did not complete.
std::vector<double> values_of_figure(const std::vector<CaseOutcome>& outcomes, size_t figure) {
    std::vector<double> values(outcomes.size(), std::numeric_limits<double>::quiet_NaN());
    for (size_t i = 0; i < outcomes.size(); ++i)
        if (outcomes[i].status == "completed" && figure < outcomes[i].figures.size())
            values[i] = outcomes[i].figures[figure];
    return values;
}

std::vector<double> values_of_parameter(const CaseTable& cases, size_t parameter) {
    const Eigen::VectorXd column = cases.values.col(as_row(parameter));
    return {column.begin(), column.end()};
}

Column with_unit(const Column& column) { return {column.name, column.unit.empty() ? "1" : column.unit}; }

void write_results(std::ostream& out, const StudyFolder& study, const std::vector<CaseOutcome>& outcomes) {
    const CaseTable& cases = study.plan().cases;
    std::vector<Column> heads = {{"case", "1"}, {"status", ""}, {"warnings", "1"}};
    for (const Column& column : cases.parameters) heads.push_back(with_unit(column));
    for (const Column& column : study.plan().columns) heads.push_back(column);
    out << csv_header(heads);
    std::string line;
    for (size_t i = 0; i < outcomes.size(); ++i) {
        const CaseOutcome& one = outcomes[i];
        const bool is_completed = one.status == "completed";
        line = fmt::format("{},{},{}", i + 1, one.status, is_completed ? std::to_string(one.warnings) : "");
        for (size_t p = 0; p < cases.parameters.size(); ++p) line += "," + number_text(cases.values(as_row(i), as_row(p)));
        for (size_t f = 0; f < study.plan().columns.size(); ++f) {
            line += ',';
            if (is_completed && f < one.figures.size() && !std::isnan(one.figures[f])) line += number_text(one.figures[f]);
        }
        out << line << '\n';
    }
}

/// Data sets of HDF5 have no slash in their names.
std::string dataset_name(std::string name) {
    for (size_t at = name.find('/'); at != name.npos; at = name.find('/', at)) name.replace(at, 1, " per ");
    return name;
}

void write_hdf5(const std::filesystem::path& file, const StudyFolder& study, const std::vector<CaseOutcome>& outcomes) {
    const CaseTable& cases = study.plan().cases;
    std::vector<Column> heads = {{"case", "1"}, {"status", "1"}, {"warnings", "1"}};
    for (const Column& column : cases.parameters) heads.push_back(with_unit(column));
    for (const Column& column : study.plan().columns) heads.push_back({dataset_name(column.name), column.unit});
    const std::string command_line = study.command_line();
    Hdf5Writer writer(file, heads,
                      {{"title", "study"},
                       {"version", DTTMM_VERSION},
                       {"command_line", command_line.c_str()},
                       {"status", "1: completed, 0: failed, -1: missing; figures of those that did not complete are NaN"}});
    std::vector<double> row(heads.size());
    for (size_t i = 0; i < outcomes.size(); ++i) {
        const CaseOutcome& one = outcomes[i];
        const bool is_completed = one.status == "completed";
        row[0] = static_cast<double>(i + 1);
        row[1] = is_completed ? 1 : one.status == "failed" ? 0 : -1;
        row[2] = static_cast<double>(one.warnings);
        size_t c = 3;
        for (size_t p = 0; p < cases.parameters.size(); ++p) row[c++] = cases.values(as_row(i), as_row(p));
        for (size_t f = 0; f < study.plan().columns.size(); ++f)
            row[c++] = is_completed && f < one.figures.size() ? one.figures[f] : std::numeric_limits<double>::quiet_NaN();
        writer.write_row(row);
    }
    writer.publish();
}

std::string statistics_table(const StudyFolder& study, const std::vector<CaseOutcome>& outcomes, const StudyCount& count) {
    std::vector<Column> heads = {{"figure", ""},   {"unit", ""}, {"counted", "1"},  {"without", "1"}, {"failed", "1"},
                                 {"missing", "1"}, {"mean", ""}, {"deviation", ""}, {"minimum", ""}};
    for (const double share : FigureStatistics::kShares) heads.push_back({fmt::format("q{:02.0f}", 100 * share), ""});
    heads.push_back({"maximum", ""});
    CsvTable table(heads);
    for (size_t f = 0; f < study.plan().columns.size(); ++f) {
        const FigureStatistics of = compute_statistics(values_of_figure(outcomes, f));
        table.add(study.plan().columns[f].name).add(study.plan().columns[f].unit);
        table.add(static_cast<double>(of.count))
            .add(static_cast<double>(count.completed - of.count))
            .add(static_cast<double>(count.failed))
            .add(static_cast<double>(count.missing));
        table.add(of.mean).add(of.deviation).add(of.minimum).add_all(of.quantiles).add(of.maximum).end_row();
    }
    return table.text();
}

std::string correlation_table(const StudyFolder& study, const std::vector<CaseOutcome>& outcomes) {
    const CaseTable& cases = study.plan().cases;
    std::vector<Column> heads = {{"figure", ""}};
    for (const Column& column : cases.parameters) heads.push_back({column.name, "1"});
    for (const Column& column : cases.parameters) heads.push_back({column.name + ".rank", "1"});
    CsvTable table(heads);
    std::vector<std::vector<double>> parameters;
    for (size_t p = 0; p < cases.parameters.size(); ++p) parameters.push_back(values_of_parameter(cases, p));
    for (size_t f = 0; f < study.plan().columns.size(); ++f) {
        const std::vector<double> values = values_of_figure(outcomes, f);
        table.add(study.plan().columns[f].name);
        for (const auto& parameter : parameters) table.add(compute_correlation(parameter, values));
        for (const auto& parameter : parameters) table.add(compute_rank_correlation(parameter, values));
        table.end_row();
    }
    return table.text();
}

/// What each parameter does to each figure, by the design of the study; empty for a design that tells nothing of it.
std::string sensitivity_table(const StudyFolder& study, const std::vector<CaseOutcome>& outcomes) {
    const StudyPlan& plan = study.plan();
    const std::vector<Column>& parameters = plan.cases.parameters;
    const auto fill = [&](const std::vector<Column>& heads, const auto& add) {
        std::vector<Column> all = {{"figure", ""}, {"unit", ""}, {"parameter", ""}};
        all.insert(all.end(), heads.begin(), heads.end());
        CsvTable table(all);
        for (size_t f = 0; f < plan.columns.size(); ++f)
            add(values_of_figure(outcomes, f), [&](size_t parameter, std::initializer_list<double> numbers) {
                table.add(plan.columns[f].name).add(plan.columns[f].unit).add(parameters[parameter].name);
                table.add_all(numbers).end_row();
            });
        return table.text();
    };
    if (plan.design == "sobol-indices")
        return fill({{"first", "1"},
                     {"first.low", "1"},
                     {"first.high", "1"},
                     {"total", "1"},
                     {"total.low", "1"},
                     {"total.high", "1"},
                     {"blocks", "1"}},
                    [&](const std::vector<double>& values, const auto& row) {
                        const auto all = compute_sobol_indices(values, as_row(parameters.size()));
                        for (size_t p = 0; p < all.size(); ++p)
                            row(p, {all[p].first.value, all[p].first.low, all[p].first.high, all[p].total.value,
                                    all[p].total.low, all[p].total.high, static_cast<double>(all[p].blocks)});
                    });
    if (plan.design == "morris")
        return fill({{"size", ""}, {"size.low", ""}, {"size.high", ""}, {"mean", ""}, {"deviation", ""}, {"walks", "1"}},
                    [&](const std::vector<double>& values, const auto& row) {
                        const auto all = compute_elementary_effects(values, plan.cases.values);
                        for (size_t p = 0; p < all.size(); ++p)
                            row(p, {all[p].size.value, all[p].size.low, all[p].size.high, all[p].mean, all[p].deviation,
                                    static_cast<double>(all[p].walks)});
                    });
    if (plan.design == "one-at-a-time")
        return fill({{"value", ""}, {"change", ""}}, [&](const std::vector<double>& values, const auto& row) {
            for (const SingleEffect& effect : compute_single_effects(values, plan.cases.values))
                row(as_size(effect.parameter), {plan.cases.values(as_row(effect.row), effect.parameter), effect.change});
        });
    return {};
}

std::string failure_table(const std::vector<CaseOutcome>& outcomes) {
    CsvTable table({{"case", "1"}, {"reason", ""}});
    for (size_t i = 0; i < outcomes.size(); ++i)
        if (outcomes[i].status == "failed") table.add(static_cast<double>(i + 1)).add(outcomes[i].reason).end_row();
    return table.text();
}

Json describe_statistics(const StudyFolder& study, const std::vector<CaseOutcome>& outcomes) {
    const auto or_null = [](double value) { return std::isnan(value) ? Json() : Json(value); };
    Json all = Json::object();
    for (size_t f = 0; f < study.plan().columns.size(); ++f) {
        const FigureStatistics of = compute_statistics(values_of_figure(outcomes, f));
        Json one = {{"unit", study.plan().columns[f].unit},
                    {"count", of.count},
                    {"without", count_cases(outcomes).completed - of.count},
                    {"mean", or_null(of.mean)},
                    {"deviation", or_null(of.deviation)},
                    {"minimum", or_null(of.minimum)},
                    {"maximum", or_null(of.maximum)}};
        for (size_t q = 0; q < of.quantiles.size(); ++q)
            one[fmt::format("q{:02.0f}", 100 * FigureStatistics::kShares[q])] = or_null(of.quantiles[q]);
        all[study.plan().columns[f].name] = one;
    }
    return all;
}

/// Of few figures; sensitivities.csv has all.
void print_sensitivities(const StudyFolder& study, const std::vector<CaseOutcome>& outcomes) {
    constexpr size_t kMostShown = 8;
    const StudyPlan& plan = study.plan();
    const bool has_indices = plan.design == "sobol-indices";
    if (!has_indices && plan.design != "morris") return;
    const size_t shown = std::min(plan.columns.size(), kMostShown);
    for (size_t f = 0; f < shown; ++f) {
        const std::vector<double> values = values_of_figure(outcomes, f);
        fmt::print("{}\n", plan.columns[f].name);
        if (has_indices) {
            const auto all = compute_sobol_indices(values, as_row(plan.cases.parameters.size()));
            const size_t blocks = plan.cases.cases() / (plan.cases.parameters.size() + 2);
            if (all.empty()) fmt::print("  no indices: fewer than two blocks of cases have completed\n");
            if (!all.empty() && all.front().blocks < blocks)
                fmt::print("  of {} of {} blocks: the others have cases without this number\n", all.front().blocks, blocks);
            for (size_t p = 0; p < all.size(); ++p)
                fmt::print("  {:<20} alone {:6.3f} ({:.3f} to {:.3f}), in all {:6.3f} ({:.3f} to {:.3f}) of the variance\n",
                           plan.cases.parameters[p].name, all[p].first.value, all[p].first.low, all[p].first.high,
                           all[p].total.value, all[p].total.low, all[p].total.high);
        } else {
            const auto all = compute_elementary_effects(values, plan.cases.values);
            if (all.empty()) fmt::print("  no effects: fewer than two walks have completed, or a parameter does not vary\n");
            for (size_t p = 0; p < all.size(); ++p)
                fmt::print("  {:<20} {:.4g} ({:.4g} to {:.4g}) {} by half of its range, deviation {:.4g}\n",
                           plan.cases.parameters[p].name, all[p].size.value, all[p].size.low, all[p].size.high,
                           plan.columns[f].unit, all[p].deviation);
        }
    }
    fmt::print("sensitivities.csv has {}\n", shown < plan.columns.size() ? "all figures" : "these numbers");
}

/// Numbers that completed cases do not have, and numbers of theirs that are in no table.
void print_gaps(const std::vector<Column>& columns, const std::vector<CaseOutcome>& outcomes) {
    constexpr size_t kMostGaps = 10;
    const StudyCount count = count_cases(outcomes);
    size_t gaps = 0;
    for (size_t f = 0; f < columns.size(); ++f) {
        const size_t has = compute_statistics(values_of_figure(outcomes, f)).count;
        if (has < count.completed && ++gaps <= kMostGaps)
            fmt::print("{}: {} of {} completed cases have no such number; they do not count\n", columns[f].name,
                       count.completed - has, count.completed);
    }
    if (gaps > kMostGaps)
        fmt::print("and {} more figures that not all cases have; statistics.csv counts them\n", gaps - kMostGaps);
    if (count.unlisted > 0)
        fmt::print("{} with figures that the model as the file has it lacks: these are in no table\n",
                   counted(count.unlisted, "case", "cases"));
}

/// Two that collect at once take turns. Where the file system has no locks, they go without.
File wait_for_turn(const StudyFolder& study) {
    File file = File::open(study.path() / ".collecting");
    while (::flock(file.descriptor(), LOCK_EX) != 0 && errno == EINTR) {
    }
    return file;
}

}  // namespace

StudyCount count_cases(const std::vector<CaseOutcome>& outcomes) {
    StudyCount count;
    for (const CaseOutcome& one : outcomes) {
        ++(one.status == "completed" ? count.completed : one.status == "failed" ? count.failed : count.missing);
        if (one.status == "completed" && one.warnings > 0) ++count.warned;
        if (one.status == "completed" && one.unlisted) ++count.unlisted;
    }
    return count;
}

std::string describe_count(const StudyCount& count) {
    return fmt::format("{} of {} completed, {} failed, {} not run{}", count.completed,
                       counted(count.completed + count.failed + count.missing, "case", "cases"), count.failed, count.missing,
                       count.warned > 0 ? fmt::format(", {} with warnings", count.warned) : "");
}

std::vector<CaseOutcome> collect(const StudyFolder& study) {
    const File turn = wait_for_turn(study);
    std::vector<CaseOutcome> outcomes = study.outcomes();  // no older than the tables of who had the turn before
    const StudyCount count = count_cases(outcomes);
    write_atomically(study.path() / "results.csv", [&](std::ostream& out) { write_results(out, study, outcomes); });
    write_hdf5(study.path() / "results.h5", study, outcomes);
    write_atomically(study.path() / "statistics.csv", statistics_table(study, outcomes, count));
    write_atomically(study.path() / "correlations.csv", correlation_table(study, outcomes));
    if (const std::string table = sensitivity_table(study, outcomes); !table.empty())
        write_atomically(study.path() / "sensitivities.csv", table);
    write_atomically(study.path() / "failures.csv", failure_table(outcomes));
    const Json summary = {{"format", "dttmm-study-results/1"},
                          {"title", study.title()},
                          {"status", count.missing > 0 ? "incomplete" : "completed"},
                          {"command_line", study.command_line()},
                          {"cases", outcomes.size()},
                          {"completed", count.completed},
                          {"failed", count.failed},
                          {"missing", count.missing},
                          {"with_warnings", count.warned},
                          {"with_more_figures", count.unlisted},
                          {"statistics", describe_statistics(study, outcomes)}};
    write_atomically(study.path() / "summary.json", summary.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
    return outcomes;
}

void print_statistics(const StudyFolder& study, const std::vector<CaseOutcome>& outcomes) {
    constexpr size_t kMostFigures = 40, kMostFailures = 10;
    const std::vector<Column>& columns = study.plan().columns;
    size_t width = 6;
    for (const Column& column : columns) width = std::max(width, column.name.size());
    fmt::print("{:<{}}  {:>12}  {:>12}  {:>12}  {:>12}  {:>12}  {:>12}\n", "figure", width, "mean", "deviation", "5 %",
               "50 %", "95 %", "maximum");
    for (size_t f = 0; f < std::min(columns.size(), kMostFigures); ++f) {
        const FigureStatistics of = compute_statistics(values_of_figure(outcomes, f));
        fmt::print("{:<{}}  {:>12.6g}  {:>12.6g}  {:>12.6g}  {:>12.6g}  {:>12.6g}  {:>12.6g}  {}\n", columns[f].name, width,
                   of.mean, of.deviation, of.quantiles[1], of.quantiles[3], of.quantiles[5], of.maximum, columns[f].unit);
    }
    if (columns.size() > kMostFigures) fmt::print("and {} more in statistics.csv\n", columns.size() - kMostFigures);
    print_gaps(columns, outcomes);
    print_sensitivities(study, outcomes);
    size_t failures = 0;
    for (size_t i = 0; i < outcomes.size(); ++i)
        if (outcomes[i].status == "failed" && ++failures <= kMostFailures)
            tell(fmt::format("case {}: {}", i + 1, outcomes[i].reason));
    if (failures > kMostFailures) tell(fmt::format("and {} more failures in failures.csv", failures - kMostFailures));
}

}  // namespace dttmm::host
