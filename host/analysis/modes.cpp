// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "analysis/curves.h"
#include "analysis/modal_machine.h"
#include "analysis/stop_signals.h"
#include "analysis/summary.h"
#include "analysis/sweep_table.h"
#include "model/units.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/csv_writer.h"
#include "record/results_folder.h"
#include "record/tell.h"
#include "record/warnings.h"

namespace dttmm::host {

namespace {

using Vector6 = ModalMachine::Vector6;
using Mode = ModalInstance::Mode;

constexpr uint32_t kStations = 21;
/// Smaller shares of the strain energy are not worth a word.
constexpr double kSmallestShare = 0.05;
constexpr size_t kMostShares = 3;

std::filesystem::path modes_folder(const Request& request) {
    if (request.output) return *request.output;
    std::filesystem::path folder = default_results_path(request.model);
    folder += "-modes";
    return folder;
}

/// Whether a load pulls all the time: its mean over the second half of the run is more than a tenth of its largest value
/// there. A vibration and a blow have a small mean. Without a duration the load at the start counts.
bool is_lasting(const Signal& signal, double duration) {
    if (!(duration > 0)) return signal.value(0) != 0;
    constexpr int kSamples = 1000;
    double sum = 0, largest = 0;
    for (int i = 0; i <= kSamples; ++i) {
        const double value = signal.value(duration * (0.5 + 0.5 * i / kSamples));
        sum += value;
        largest = std::max(largest, std::abs(value));
    }
    return std::abs(sum) / (kSamples + 1) > 0.1 * largest;
}

Model read(const Request& request, const Plugins& plugins, Warnings& warnings) {
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::modes;
    Model model = read_model(request.model, plugins.catalogue(), overrides);
    warnings.add(model.warnings);
    warn_preload(model, warnings);
    return model;
}

/// An empty list is an answer: the count proves it.
void tell_empty(const Model& model, const std::vector<Mode>& modes) {
    if (modes.empty() && model.modes.below)
        tell(fmt::format("{}: no natural frequency lies below {:g} Hz", model.modes.below_place, *model.modes.below));
}

/// The place and direction that move most; of a mode in which nothing is displaced, that turn most.
std::string where_most(const ModalMachine& machine, const Mode& mode) {
    std::string where = "inside";
    for (const int first : {0, 3}) {
        double largest = 1e-6;
        for (const ModalPlace& place : machine.places()) {
            const Vector6 u = machine.motion(place, mode);
            for (int d = first; d < first + 3; ++d) {
                if (std::abs(u(d)) <= largest * (1 + 1e-6)) continue;
                largest = std::abs(u(d));
                where = fmt::format("{}.{}", place.name, direction_names()[static_cast<size_t>(d)]);
            }
        }
        if (largest > 1e-6) break;
    }
    return where;
}

std::string who_strains(const Model& model, const Mode& mode) {
    std::vector<size_t> order(mode.shares.size());
    std::iota(order.begin(), order.end(), size_t{0});
    const auto rank = [&](size_t e) { return std::round(1e6 * mode.shares[e]); };  // equal to rounding: as in the model
    std::ranges::stable_sort(order, std::ranges::greater{}, rank);
    std::string text;
    size_t others = 0;
    for (size_t k = 0; k < order.size() && mode.shares[order[k]] >= kSmallestShare; ++k)
        if (k >= kMostShares)
            ++others;
        else
            text += fmt::format("{}{} {:.0f} %", text.empty() ? "" : ", ", model.elements[order[k]].name,
                                100 * mode.shares[order[k]]);
    if (others > 0) text += fmt::format(" and {} more", others);
    return text.empty() ? (mode.numbers.frequency > 0 ? "spread" : "none") : text;
}

Json describe(const Model& model, const ModalMachine& machine, const std::vector<Mode>& modes, const Warnings& warnings) {
    Json frequencies = Json::array(), list = Json::array();
    for (const Mode& mode : modes) {
        const dttmm_mode& numbers = mode.numbers;
        frequencies.push_back(numbers.frequency);
        Json participation, strain, shape;
        for (size_t d = 0; d < 6; ++d)
            if (model.modes.directions[d]) participation[direction_names()[d]] = numbers.participation[d];
        for (size_t e = 0; e < mode.shares.size(); ++e) strain[model.elements[e].name] = mode.shares[e];
        for (const ModalPlace& place : machine.places()) {
            const Vector6 u = machine.motion(place, mode);
            shape[place.name] = std::vector<double>(u.begin(), u.end());
        }
        list.push_back({{"frequency_hz", numbers.frequency},
                        {"multiplicity", numbers.multiplicity},
                        {"bracket", numbers.bracket},
                        {"residual", numbers.residual},
                        {"modal_mass", numbers.mass},
                        {"participation", participation},
                        {"strain_energy", strain},
                        {"shape", shape}});
    }
    return {{"format", "dttmm-modes/1"},
            {"title", model.title},
            {"warnings", describe_warnings(warnings)},
            {"beams", model.modes.are_beams_lumped ? "lumped" : "exact"},
            {"frequencies_hz", frequencies},
            {"modes", list}};
}

/// A line per mode and place: where it is and how it moves.
std::string modes_table(const ModalMachine& machine, const std::vector<Mode>& modes) {
    std::string text =
        "mode,frequency,multiplicity,modal_mass,place,x,y,z,ux,uy,uz,urx,ury,urz\n1,Hz,1,kg,,m,m,m,1,1,1,1/m,1/m,1/m\n";
    for (size_t m = 0; m < modes.size(); ++m)
        for (const ModalPlace& place : machine.places()) {
            text += fmt::format("{},{},{},{},{}", m + 1, number_text(modes[m].numbers.frequency),
                                modes[m].numbers.multiplicity, number_text(modes[m].numbers.mass), csv_field(place.name));
            for (double x : place.position) text += "," + number_text(x);
            for (double u : machine.motion(place, modes[m])) text += "," + number_text(u);
            text += "\n";
        }
    return text;
}

/// The same along every beam.
std::string shapes_table(const Model& model, ModalMachine& machine, const std::vector<Mode>& modes) {
    std::string text = "mode,frequency,element,s,x,y,z,ux,uy,uz,urx,ury,urz\n1,Hz,,m,m,m,m,1,1,1,1/m,1/m,1/m\n";
    for (size_t m = 0; m < modes.size(); ++m)
        for (size_t e = 0; e < model.elements.size(); ++e) {
            double length = 0;
            const auto shape = machine.along(static_cast<uint32_t>(m), static_cast<uint32_t>(e), kStations, length);
            if (shape.empty()) continue;
            const Eigen::Vector3d from = frame_at_start(model, model.elements[e].ends[0]).position;
            const Eigen::Vector3d to = frame_at_start(model, model.elements[e].ends[1]).position;
            for (size_t k = 0; k < shape.size(); ++k) {
                const double part = static_cast<double>(k) / (kStations - 1);
                text += fmt::format("{},{},{},{}", m + 1, number_text(modes[m].numbers.frequency),
                                    csv_field(model.elements[e].name), number_text(part * length));
                for (double x : Eigen::Vector3d(from + part * (to - from))) text += "," + number_text(x);
                for (double u : shape[k]) text += "," + number_text(u);
                text += "\n";
            }
        }
    return text;
}

void print_modes(const Model& model, const ModalMachine& machine, const std::vector<Mode>& modes) {
    if (!model.title.empty()) fmt::print("{}\n", model.title);
    fmt::print("{:>4} {:>14} {:>8} {:>13}  {:<22} {}\n", "mode", "frequency", "multiple", "modal mass", "moves most",
               "strain energy");
    for (size_t m = 0; m < modes.size(); ++m) {
        const dttmm_mode& numbers = modes[m].numbers;
        fmt::print("{:>4} {:>11} Hz {:>8} {:>10} kg  {:<22} {}\n", m + 1, fmt::format("{:.8g}", numbers.frequency),
                   numbers.multiplicity > 1 ? fmt::format("x{}", numbers.multiplicity) : "",
                   fmt::format("{:.5g}", numbers.mass), where_most(machine, modes[m]), who_strains(model, modes[m]));
    }
}

std::string to_text(const Json& json) { return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n"; }

}  // namespace

/// Gravity and lasting loads change the frequencies of what they tension or press: an inverted pendulum on a spring may have
/// 41 % less.
void warn_preload(const Model& model, Warnings& warnings) {
    if (!model.simulation.gravity.isZero(0))
        warnings.note("gravity-not-in-modes",
                      "the frequencies are those without gravity: its stiffness, as of a pendulum, is not in them");
    std::string place;
    size_t others = 0;
    for (const Load& load : model.loads) {
        if (!is_lasting(load.signal, model.simulation.duration)) continue;
        if (place.empty())
            place = load.place;
        else
            ++others;
    }
    if (!place.empty())
        warnings.note(
            "load-not-in-modes",
            fmt::format("{}: the frequencies are those without this lasting load{}: the stiffness of its tension or "
                        "pressure is not in them",
                        place, others > 0 ? fmt::format(" and {} more", others) : ""));
}

ExitCode find_modes(const Request& request) {
    const StopSignals signals(StopSignals::First::ends);
    const Plugins plugins(request.plugins);
    Warnings warnings;
    const Model model = read(request, plugins, warnings);
    ModalMachine machine(model, plugins);
    if (request.is_verbose) fmt::print(request.as_json ? stderr : stdout, "{}", machine.layout());
    const std::vector<Mode> modes = machine.find_modes();
    tell_empty(model, modes);

    const ResultsFolder folder(modes_folder(request));
    const Json json = describe(model, machine, modes, warnings);
    write_atomically(folder.file("modes.csv"), modes_table(machine, modes));
    write_atomically(folder.file("shapes.csv"), shapes_table(model, machine, modes));
    warnings.print_rest("; summary.json has all of them");
    write_json(folder.file("summary.json"), [&](JsonWriter& out) {
        for (const auto& [name, value] : json.items()) out.member(name, value);
        out.member("command_line", request.command_line);
        out.member("inputs", describe_inputs(model, request));
        write_model(out, model, plugins.catalogue());
    });
    if (request.as_json) {
        fmt::print("{}", to_text(json));
    } else if (!request.quiet) {
        print_modes(model, machine, modes);
        double widest = 0;
        for (const Mode& mode : modes) widest = std::max(widest, mode.numbers.bracket);
        if (modes.empty())
            fmt::print("counted and complete; results in {}\n", folder.describe());
        else
            fmt::print("counted and complete, each within {:.1e} of itself; results in {}\n", widest, folder.describe());
    }
    return ExitCode::ok;
}

// ---- Frequencies against a parameter ------------------------------------------------------------------------------------

namespace {

/// Shapes of a case as one column each, displacements of all places.
Eigen::MatrixXd shapes_of(const ModalMachine& machine, const std::vector<Mode>& modes) {
    const std::vector<ModalPlace>& places = machine.places();
    Eigen::MatrixXd shapes(static_cast<Eigen::Index>(6 * places.size()), static_cast<Eigen::Index>(modes.size()));
    for (size_t m = 0; m < modes.size(); ++m)
        for (size_t p = 0; p < places.size(); ++p)
            shapes.block<6, 1>(static_cast<Eigen::Index>(6 * p), static_cast<Eigen::Index>(m)) =
                machine.motion(places[p], modes[m]);
    return shapes;
}

/// Below this likeness two shapes may be those of different modes.
constexpr double kAlike = 0.8;

/// A case as the sweep keeps it.
struct SweptCase {
    std::vector<Parameter> parameters;
    std::vector<double> swept;        ///< value of every axis [SI]
    std::vector<double> frequencies;  ///< [Hz]
};

std::string cell(double value) { return std::isnan(value) ? std::string() : number_text(value); }

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
    const size_t count = curves.empty() ? 0 : curves.front().mode_of.size();
    std::vector<Channel> columns;
    for (size_t k = 0; k < count; ++k) columns.push_back({fmt::format("curve{}", k + 1), "Hz"});
    for (size_t k = 0; k < count; ++k) columns.push_back({fmt::format("mac{}", k + 1), "1"});
    std::vector<SweepRow> rows;
    for (size_t c = 0; c < cases.size(); ++c) {
        rows.push_back({cases[c].parameters, {}});
        for (size_t k = 0; k < count; ++k) rows.back().cells.push_back(cell(frequency_of(cases[c], curves[c], k)));
        for (double likeness : curves[c].likeness) rows.back().cells.push_back(cell(likeness));
    }
    return make_sweep_table(parameters, columns, rows);
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

}  // namespace

ExitCode sweep_modes(const Request& request, const std::vector<SweepAxis>& axes) {
    const StopSignals signals;
    const Plugins plugins(request.plugins);
    const std::vector<SweepCase> grid = make_grid(axes);
    Warnings warnings;
    const Model base = read(request, plugins, warnings);
    refuse_column_names(base);
    check_axes(axes, base.parameters);
    std::vector<SweptCase> cases;
    std::vector<std::vector<double>> swept;
    std::vector<Eigen::MatrixXd> shapes;
    for (size_t c = 0; c < grid.size() && !StopSignals::requested(); ++c) {
        Request own = request;
        for (const auto& parameter : grid[c]) own.overrides.parameters.push_back(parameter);
        const Model model = read(own, plugins, warnings);
        ModalMachine machine(model, plugins);
        const std::vector<Mode> modes = machine.find_modes();
        tell_empty(model, modes);
        shapes.push_back(shapes_of(machine, modes));
        swept.emplace_back();
        for (const auto& [name, value] : grid[c]) swept.back().push_back(parse_quantity(value).value);
        cases.push_back({model.parameters, swept.back(), {}});
        for (const Mode& mode : modes) cases.back().frequencies.push_back(mode.numbers.frequency);
    }
    const std::vector<CaseCurves> curves = follow_curves(swept, shapes);
    const std::vector<Parameter> parameters = cases.empty() ? std::vector<Parameter>() : cases.front().parameters;
    const ResultsFolder folder(modes_folder(request), Claim::keep);
    write_atomically(folder.file("sweep.csv"), modes_sweep_table(cases, curves, parameters));
    if (request.as_json) {
        fmt::print("{}", to_text(describe_sweep(cases, curves)));
    } else if (!request.quiet) {
        print_sweep(cases, curves, axes, parameters);
        fmt::print("mac: likeness of a shape to that of its curve in the nearest case; results in {}\n",
                   folder.describe("sweep.csv"));
    }
    warn_unlike(curves, warnings);
    warnings.print_rest("");
    if (cases.size() < grid.size()) {
        tell(fmt::format("{}; {} of {} cases are kept", StopSignals::reason(), cases.size(), grid.size()));
        return StopSignals::exit_code();
    }
    return ExitCode::ok;
}

// ---- Frequency response -------------------------------------------------------------------------------------------------

namespace {

/// "plate.corner1.z" as a place and a direction.
std::pair<const ModalPlace*, int> place_and_direction(const Model& model, const ModalMachine& machine,
                                                      const std::string& option, const std::string& text) {
    const size_t dot = text.rfind('.');
    std::vector<std::string> known;
    for (const ModalPlace& place : machine.places()) known.push_back(place.name);
    if (dot == std::string::npos)
        throw Error(ExitCode::usage,
                    fmt::format("{} {}: write place.direction, e.g. {}.z", option, quote(text), known.front()));
    const std::string name = text.substr(0, dot), direction = text.substr(dot + 1);
    const auto d = std::ranges::find(direction_names(), direction);
    if (d == direction_names().end())
        throw Error(ExitCode::usage, fmt::format("{} {}: {} is none of the directions {}", option, quote(text),
                                                 quote(direction), listed(direction_names())));
    const ModalPlace* place = machine.find(name);
    if (!place)
        throw Error(ExitCode::usage, fmt::format("{} {}: no body, marker or node {}{}", option, quote(text), quote(name),
                                                 suggestion(name, known)));
    const auto index = static_cast<size_t>(d - direction_names().begin());
    if (!model.modes.directions[index])
        throw Error(ExitCode::usage,
                    fmt::format("{} {}: nothing moves in {}: the model's dofs leave it out", option, quote(text), *d));
    return {place, static_cast<int>(index)};
}

double frequency(const std::string& option, const std::string& text) {
    try {
        const double value = parse_quantity(text, "Hz");
        if (value >= 0 && std::isfinite(value)) return value;
        throw Error(ExitCode::usage, "must be zero or more");
    } catch (const Error& error) {
        throw Error(ExitCode::usage, fmt::format("{} {}: {}", option, quote(text), error.what()));
    }
}

}  // namespace

ExitCode find_response(const Request& request) {
    const StopSignals signals;
    const Plugins plugins(request.plugins);
    const double from = frequency("--from", request.from), to = frequency("--to", request.to);
    if (!(to > from)) throw Error(ExitCode::usage, "--to must be more than --from");
    if (request.is_logarithmic && from == 0) throw Error(ExitCode::usage, "--log: --from must be more than zero");
    Warnings warnings;
    const Model model = read(request, plugins, warnings);
    ModalMachine machine(model, plugins);
    const auto [in, in_direction] = place_and_direction(model, machine, "--in", request.input);
    const auto [out, out_direction] = place_and_direction(model, machine, "--out", request.response);

    const char* input = in_direction < 3 ? "N" : "(N*m)";
    const char* unit = out_direction < 3 ? "m" : "rad";
    const auto frequency_at = [&](int i) {
        const double part = static_cast<double>(i) / (request.points - 1);
        return request.is_logarithmic ? from * std::pow(to / from, part) : from + part * (to - from);
    };
    const auto respond = [&](double f) { return machine.respond(f, *in, in_direction, *out, out_direction); };
    std::complex<double> H = respond(frequency_at(0));  // before the folder is touched: it may be refused

    std::filesystem::path path = default_results_path(request.model);
    path += "-frf";
    const ResultsFolder folder(request.output.value_or(path));
    const std::string per_input = fmt::format("{}/{}", unit, input), velocity = fmt::format("{}/s/{}", unit, input),
                      acceleration = fmt::format("{}/s^2/{}", unit, input);
    CsvWriter rows(folder.file("frf.csv"), {{"frequency", "Hz"},
                                            {"receptance.re", per_input},
                                            {"receptance.im", per_input},
                                            {"receptance", per_input},
                                            {"phase", "deg"},
                                            {"mobility.re", velocity},
                                            {"mobility.im", velocity},
                                            {"accelerance.re", acceleration},
                                            {"accelerance.im", acceleration}});
    double largest = 0, at = 0;
    int done = 0;
    for (; done < request.points && !StopSignals::requested(); ++done) {
        const double f = frequency_at(done);
        if (done > 0) H = respond(f);
        const std::complex<double> iw(0, 2 * std::numbers::pi * f), V = iw * H, A = iw * V;
        const double row[] = {f,        H.real(), H.imag(), std::abs(H), std::arg(H) * 180 / std::numbers::pi,
                              V.real(), V.imag(), A.real(), A.imag()};
        rows.write_row(row);
        if (std::abs(H) > largest) {
            largest = std::abs(H);
            at = f;
        }
    }
    rows.finish();
    const bool is_stopped = done < request.points;
    if (largest == 0 && !is_stopped)
        warnings.add("no-response", fmt::format("{} does not move under {}: {}", request.response, request.input,
                                                machine.why_still(*in, in_direction, *out, out_direction)));
    warnings.print_rest("; summary.json has all of them");
    write_json(folder.file("summary.json"), [&](JsonWriter& json) {
        json.member("format", "dttmm-frf/1");
        json.member("warnings", describe_warnings(warnings));
        json.member("title", model.title);
        json.member("status", is_stopped ? "stopped" : "completed");
        json.member("in", request.input);
        json.member("out", request.response);
        json.member("rows", done);
        json.member("largest_receptance", largest);
        json.member("largest_at_hz", at);
        json.member("command_line", request.command_line);
        json.member("inputs", describe_inputs(model, request));
        write_model(json, model, plugins.catalogue());
    });
    if (is_stopped) {
        tell(fmt::format("{} at {:g} Hz; {} of {} rows are kept", StopSignals::reason(), frequency_at(done), done,
                         request.points));
        return StopSignals::exit_code();
    }
    if (!request.quiet)
        fmt::print("{} points from {:g} to {:g} Hz, {} per {}; largest {:.6g} {}/{} at {:.6g} Hz\nresults in {}\n",
                   request.points, from, to, request.response, request.input, largest, unit, input, at,
                   folder.describe("frf.csv"));
    return ExitCode::ok;
}

}  // namespace dttmm::host
