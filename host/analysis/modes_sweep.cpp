// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/modes_sweep.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <string_view>
#include <unordered_map>

#include "analysis/curves.h"
#include "analysis/json.h"
#include "analysis/modal_session.h"
#include "analysis/stop_signals.h"
#include "analysis/sweep_table.h"
#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/results_folder.h"
#include "record/tell.h"

namespace dttmm::host {

namespace {

using Mode = ModalInstance::Mode;

/// Shapes of a case as one column each, six rows per place.
struct CaseShapes {
    std::vector<std::string> places;
    Eigen::MatrixXd values;
};

CaseShapes shapes_of(const ModalMachine& machine, const std::vector<Mode>& modes) {
    const std::vector<ModalPlace>& places = machine.places();
    Eigen::MatrixXd shapes(as_row(6 * places.size()), as_row(modes.size()));
    for (size_t m = 0; m < modes.size(); ++m)
        for (size_t p = 0; p < places.size(); ++p)
            shapes.block<6, 1>(as_row(6 * p), as_row(m)) = machine.motion(places[p], modes[m]);
    std::vector<std::string> names;
    for (const ModalPlace& place : places) names.push_back(place.name);
    return {names, shapes};
}

/// The shapes of all cases over the places of all. A place that a case does not have does not move in it: so a shape of the
/// parts that only one of two cases has is not like any of the other.
std::vector<Eigen::MatrixXd> over_all_places(const std::vector<const CaseShapes*>& cases) {
    std::vector<std::string> all;
    for (const CaseShapes* one : cases) merge_names(all, one->places);
    std::unordered_map<std::string_view, size_t> index;
    for (size_t p = 0; p < all.size(); ++p) index.emplace(all[p], p);
    std::vector<Eigen::MatrixXd> shapes;
    for (const CaseShapes* one : cases) {
        Eigen::MatrixXd& own = shapes.emplace_back(Eigen::MatrixXd::Zero(as_row(6 * all.size()), one->values.cols()));
        for (size_t p = 0; p < one->places.size(); ++p)
            own.middleRows<6>(as_row(6 * index.at(one->places[p]))) = one->values.middleRows<6>(as_row(6 * p));
    }
    return shapes;
}

/// Below this likeness two shapes may be those of different modes.
constexpr double kAlike = 0.8;

/// A case as the sweep keeps it.
struct SweptCase {
    std::vector<Parameter> parameters;
    std::vector<double> swept;        ///< value of every axis [SI]
    std::vector<double> frequencies;  ///< [Hz]
    std::string reason = {};          ///< why it failed
};

double frequency_of(const SweptCase& one, const CaseCurves& curves, size_t curve) {
    return curves.mode_of[curve] == CaseCurves::kNone ? std::nan("") : one.frequencies[curves.mode_of[curve]];
}

/// The least likeness of a case to the one it was compared with; NaN if nothing was compared.
double least_likeness(const CaseCurves& curves) {
    double least = std::nan("");
    for (double likeness : curves.likeness)
        if (!(likeness >= least)) least = std::isnan(likeness) ? least : likeness;
    return least;
}

std::string modes_sweep_table(const std::vector<SweptCase>& cases, const std::vector<CaseCurves>& curves,
                              const std::vector<Parameter>& parameters) {
    std::vector<SweepRow> rows;
    for (size_t c = 0; c < cases.size(); ++c) {
        SweepRow& row = rows.emplace_back(SweepRow{cases[c].parameters, {}});
        for (size_t k = 0; k < curves[c].mode_of.size(); ++k)
            row.cells.push_back({{fmt::format("curve{}", k + 1), "Hz"}, frequency_of(cases[c], curves[c], k)});
        for (size_t k = 0; k < curves[c].likeness.size(); ++k)
            row.cells.push_back({{fmt::format("mac{}", k + 1), "1"}, curves[c].likeness[k]});
    }
    return make_sweep_table(parameters, rows);
}

Json describe_sweep(const std::vector<SweptCase>& cases, const std::vector<CaseCurves>& curves) {
    const auto or_null = [](double value) { return std::isnan(value) ? Json() : Json(value); };
    Json list = Json::array();
    for (size_t c = 0; c < cases.size(); ++c) {
        Json row = {{"case", case_name(c)},
                    {"parameters", Json::object()},
                    {"frequencies_hz", Json::array()},
                    {"likeness", Json::array()},
                    {"nearest", curves[c].nearest == CaseCurves::kNone ? Json() : Json(case_name(curves[c].nearest))}};
        for (const Parameter& parameter : cases[c].parameters) row["parameters"][parameter.name] = parameter.value;
        for (size_t k = 0; k < curves[c].mode_of.size(); ++k) {
            row["frequencies_hz"].push_back(or_null(frequency_of(cases[c], curves[c], k)));
            row["likeness"].push_back(or_null(curves[c].likeness[k]));
        }
        list.push_back(std::move(row));
    }
    return {{"format", "dttmm-modes-sweep/1"}, {"cases", list}};
}

void print_sweep(const std::vector<SweptCase>& cases, const std::vector<CaseCurves>& curves,
                 const std::vector<SweepAxis>& axes, const std::vector<Parameter>& parameters) {
    std::string head = fmt::format("{:<11}", "case");
    for (const SweepAxis& axis : axes) {
        const auto parameter = std::ranges::find(parameters, axis.name, &Parameter::name);
        const std::string unit = parameter == parameters.end() || parameter->unit == "1" ? "" : " [" + parameter->unit + "]";
        head += fmt::format(" {:>13}", axis.name + unit);
    }
    const size_t count = curves.empty() ? 0 : curves.front().mode_of.size();
    for (size_t k = 0; k < count; ++k) head += fmt::format(" {:>11}", fmt::format("curve{} [Hz]", k + 1));
    fmt::print("{} {:>10}\n", head, "lowest mac");
    for (size_t c = 0; c < cases.size(); ++c) {
        std::string line = case_name(c);
        for (double value : cases[c].swept) line += fmt::format(" {:>13.6g}", value);
        for (size_t k = 0; k < count; ++k) {
            const double f = frequency_of(cases[c], curves[c], k);
            line += std::isnan(f) ? fmt::format(" {:>11}", "-") : fmt::format(" {:>11.6g}", f);
        }
        const double least = least_likeness(curves[c]);
        fmt::print("{} {:>10}\n", line, std::isnan(least) ? "-" : fmt::format("{:.3f}", least));
    }
}

/// Curves whose shapes change much from one case to the next may be joined wrongly.
void warn_unlike(const std::vector<CaseCurves>& curves, Warnings& warnings) {
    size_t count = 0, worst_case = 0, worst_curve = 0;
    double least = 1;
    for (size_t c = 0; c < curves.size(); ++c)
        for (size_t k = 0; k < curves[c].likeness.size(); ++k) {
            const double likeness = curves[c].likeness[k];
            if (!(likeness < kAlike)) continue;
            ++count;
            if (likeness >= least) continue;
            least = likeness;
            worst_case = c;
            worst_curve = k;
        }
    if (count > 0)
        warnings.add(
            "unlike-shapes",
            fmt::format("in {} a curve goes on with a shape of a likeness (MAC) below {:g}, lowest {:.2g} of curve{} "
                        "from {} to {}: there it may have changed to another mode; take more cases between",
                        counted(count, "place", "places"), kAlike, least, worst_curve + 1,
                        case_name(curves[worst_case].nearest), case_name(worst_case)));
}

/// A mode may leave those that are looked for.
void note_gaps(const std::vector<SweptCase>& cases, const std::vector<CaseCurves>& curves, Warnings& warnings) {
    const auto completed = as_size(std::ranges::count_if(cases, [](const SweptCase& one) { return one.reason.empty(); }));
    size_t count = 0, first = 0, missing = 0;
    for (size_t k = 0; k < (curves.empty() ? 0 : curves.front().mode_of.size()); ++k) {
        const auto found = as_size(
            std::ranges::count_if(curves, [&](const CaseCurves& one) { return one.mode_of[k] != CaseCurves::kNone; }));
        if (found == completed) continue;
        if (++count == 1) first = k, missing = completed - found;
    }
    if (count > 0)
        warnings.note("curve-gaps",
                      fmt::format("{} no frequency in some cases, curve{} in {} of {}: a mode is not among those looked for "
                                  "there; a larger --count finds more",
                                  counted(count, "curve has", "curves have"), first + 1, missing, completed));
}

/// The curves of the cases that have not failed; the others have no part in them.
std::vector<CaseCurves> follow_completed(const std::vector<SweptCase>& cases, const std::vector<CaseShapes>& shapes) {
    std::vector<size_t> completed;
    std::vector<std::vector<double>> swept;
    std::vector<const CaseShapes*> kept;
    for (size_t c = 0; c < cases.size(); ++c) {
        if (!cases[c].reason.empty()) continue;
        completed.push_back(c);
        swept.push_back(cases[c].swept);
        kept.push_back(&shapes[c]);
    }
    std::vector<CaseCurves> found = follow_curves(swept, over_all_places(kept));
    const size_t count = found.empty() ? 0 : found.front().mode_of.size();
    std::vector<CaseCurves> curves(cases.size(), {std::vector<size_t>(count, CaseCurves::kNone),
                                                  std::vector<double>(count, std::nan("")), CaseCurves::kNone});
    for (size_t k = 0; k < completed.size(); ++k) {
        if (found[k].nearest != CaseCurves::kNone) found[k].nearest = completed[found[k].nearest];
        curves[completed[k]] = std::move(found[k]);
    }
    return curves;
}

/// Tells the cases that failed; returns how many.
size_t tell_failures(const std::vector<SweptCase>& cases, const std::vector<SweepCase>& grid) {
    size_t count = 0;
    for (size_t c = 0; c < cases.size(); ++c) {
        if (cases[c].reason.empty()) continue;
        std::string at;
        for (const auto& [name, value] : grid[c]) at += fmt::format(" {}={}", name, value);
        tell(fmt::format("{}{}: {}", case_name(c), at, cases[c].reason));
        ++count;
    }
    return count;
}

}  // namespace

ExitCode sweep_modes(const Request& request, const std::vector<SweepAxis>& axes) {
    const StopSignals signals;
    const std::vector<SweepCase> grid = make_grid(axes);
    const Plugins plugins(request.plugins);
    Warnings warnings;
    const ModalSession base(request, plugins, warnings);
    refuse_column_names(base.model);
    check_axes(axes, base.model.parameters, request.overrides.parameters);
    std::vector<SweptCase> cases;
    std::vector<CaseShapes> shapes;
    std::exception_ptr fault;
    for (size_t c = 0; c < grid.size() && !StopSignals::requested(); ++c) {
        Request own = request;
        SweptCase& one = cases.emplace_back();
        for (const auto& [name, value] : grid[c]) {
            own.overrides.parameters.emplace_back(name, value);
            one.swept.push_back(parse_quantity(value).value);
            one.parameters.push_back({name, one.swept.back(), "", ""});
        }
        shapes.emplace_back();
        try {
            ModalSession session(own, plugins, warnings);
            one.parameters = session.model.parameters;
            const std::vector<Mode> modes = session.find_modes();
            shapes.back() = shapes_of(session.machine, modes);
            for (const Mode& mode : modes) one.frequencies.push_back(mode.numbers.frequency);
        } catch (const Error& error) {
            if (StopSignals::requested()) {
                cases.pop_back();
                shapes.pop_back();
                break;
            }
            one.reason = error.what();
            if (!fault) fault = std::current_exception();
        }
    }
    // A single case may be at fault; if all are, the fault of the first is the sweep's
    if (fault && std::ranges::none_of(cases, &std::string::empty, &SweptCase::reason)) std::rethrow_exception(fault);
    const std::vector<CaseCurves> curves = follow_completed(cases, shapes);
    const std::vector<Parameter>& parameters = base.model.parameters;
    const ResultsFolder folder(results_path(request, "-modes"), Claim::keep);
    write_atomically(folder.file("sweep.csv"), modes_sweep_table(cases, curves, parameters));
    if (request.modes.as_json) {
        fmt::print("{}", to_text(describe_sweep(cases, curves)));
    } else if (!request.quiet) {
        print_sweep(cases, curves, axes, parameters);
        fmt::print("mac: likeness of a shape to that of its curve in the nearest case; results in {}\n",
                   folder.describe("sweep.csv"));
    }
    const size_t failed = tell_failures(cases, grid);
    warn_unlike(curves, warnings);
    note_gaps(cases, curves, warnings);
    warnings.print_rest("");
    if (cases.size() < grid.size()) {
        tell(fmt::format("{}; {} of {} cases are kept", StopSignals::reason(), cases.size(), grid.size()));
        return StopSignals::exit_code();
    }
    return failed > 0 ? ExitCode::cases_failed : ExitCode::ok;
}

}  // namespace dttmm::host
