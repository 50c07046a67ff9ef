// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "analysis/damped_modes.h"
#include "analysis/determinant.h"
#include "analysis/given_shapes.h"
#include "analysis/material_fits.h"
#include "analysis/modal_session.h"
#include "analysis/mode_energies.h"
#include "analysis/stop_signals.h"
#include "analysis/summary.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/csv_table.h"
#include "record/results_folder.h"

namespace dttmm::host {

namespace {

using Vector6 = ModalMachine::Vector6;
using Mode = ModalInstance::Mode;

constexpr uint32_t kStations = 21;
/// Smaller shares of the strain energy are not worth a word.
constexpr double kSmallestShare = 0.05;
constexpr size_t kMostShares = 3;
/// A larger share is what a small difference of large energies, of elements and of forces at rest, is divided by.
constexpr double kLargestShare = 10;

/// Forces at rest, as weight, have an energy beside that of the elements: shares of elements then do not add up to 1.
std::string who_strains(const Model& model, const Mode& mode) {
    if (std::ranges::any_of(mode.shares, [](double share) { return std::abs(share) > kLargestShare; }))
        return "elements and forces at rest cancel";
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
    if (!text.empty()) return text;
    if (mode.numbers.frequency == 0) return "none";
    const double sum = std::accumulate(mode.shares.begin(), mode.shares.end(), 0.0);
    return sum < 0.5 ? "forces at rest" : "spread";
}

/// Sum of the participations of the modes, in the directions that the model has.
Vector6 participation_of(const std::vector<Mode>& modes) {
    Vector6 sum = Vector6::Zero();
    for (const Mode& mode : modes) sum += Eigen::Map<const Vector6>(mode.numbers.participation);
    return sum;
}

/// Their places in the file.
Json places_of_nonconservative(const Model& model, const ModalMachine& machine) {
    Json places = Json::array();
    for (const size_t i : machine.nonconservative()) places.push_back(model.loads[i].place);
    return places;
}

Json describe(const Model& model, const ModalMachine& machine, const std::vector<Mode>& modes,
              const std::vector<ModeEnergies>& energies, const Warnings& warnings) {
    Json frequencies = Json::array(), list = Json::array();
    for (const Mode& mode : modes) {
        const dttmm_mode& numbers = mode.numbers;
        frequencies.push_back(numbers.frequency);
        const ModeEnergies& own = energies[list.size()];
        Json participation, strain, shape, kinetic = Json::object();
        for (size_t b = 0; b < own.bodies.size(); ++b) kinetic[model.bodies[b].name] = own.bodies[b].total;
        if (own.bodies.empty() || own.others != 0) kinetic["others"] = own.others;
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
                        {"kind", kind_of(model, own)},
                        {"kinetic_energy", kinetic},
                        {"strain_energy", strain},
                        {"shape", shape}});
    }
    Json totals = Json::object();
    const Vector6 sum = participation_of(modes);
    for (size_t d = 0; d < 6; ++d)
        if (model.modes.directions[d]) totals[direction_names()[d]] = sum(as_row(d));
    return {{"format", "dttmm-modes/1"},
            {"title", model.title},
            {"warnings", describe_warnings(warnings)},
            {"beams", model.modes.are_beams_lumped ? "lumped" : "exact"},
            {"loads_without_potential", places_of_nonconservative(model, machine)},
            {"frequencies_hz", frequencies},
            {"effective_mass_totals", totals},
            {"modes", list}};
}

/// Columns in front, then a place and how it moves.
std::vector<Column> columns_of_shapes(std::vector<Column> columns) {
    for (const char* axis : {"x", "y", "z"}) columns.push_back({axis, "m"});
    for (const char* axis : {"ux", "uy", "uz"}) columns.push_back({axis, "1"});
    for (const char* axis : {"urx", "ury", "urz"}) columns.push_back({axis, "1/m"});
    return columns;
}

/// A line per mode and place: where it is and how it moves.
std::string modes_table(const ModalMachine& machine, const std::vector<Mode>& modes) {
    CsvTable table(
        columns_of_shapes({{"mode", "1"}, {"frequency", "Hz"}, {"multiplicity", "1"}, {"modal_mass", "kg"}, {"place", ""}}));
    for (size_t m = 0; m < modes.size(); ++m)
        for (const ModalPlace& place : machine.places()) {
            const dttmm_mode& numbers = modes[m].numbers;
            table.add(static_cast<double>(m + 1)).add(numbers.frequency).add(numbers.multiplicity).add(numbers.mass);
            table.add(place.name).add_all(place.position).add_all(machine.motion(place, modes[m])).end_row();
        }
    return table.text();
}

/// The same along every beam.
std::string shapes_table(const Model& model, ModalMachine& machine, const std::vector<Mode>& modes) {
    CsvTable table(columns_of_shapes({{"mode", "1"}, {"frequency", "Hz"}, {"element", ""}, {"s", "m"}}));
    for (size_t m = 0; m < modes.size(); ++m)
        for (size_t e = 0; e < model.elements.size(); ++e) {
            double length = 0;
            const auto shape = machine.along(as_whole<uint32_t>(m), as_whole<uint32_t>(e), kStations, length);
            const auto& ends = model.elements[e].ends;
            if (shape.empty() || ends.size() != 2 || ends[0].is_ground() || ends[1].is_ground()) continue;
            const Eigen::Vector3d from = frame_at_start(model, model.elements[e].ends[0]).position;
            const Eigen::Vector3d to = frame_at_start(model, model.elements[e].ends[1]).position;
            for (size_t k = 0; k < shape.size(); ++k) {
                const double part = static_cast<double>(k) / (kStations - 1);
                const Eigen::Vector3d at = from + part * (to - from);
                table.add(static_cast<double>(m + 1)).add(modes[m].numbers.frequency).add(model.elements[e].name);
                table.add(part * length).add_all(at).add_all(shape[k]).end_row();
            }
        }
    return table.text();
}

void print_participation(const Model& model, const std::vector<Mode>& modes) {
    const Vector6 sum = participation_of(modes);
    std::string text;
    for (size_t d = 0; d < 6; ++d)
        if (model.modes.directions[d])
            text += fmt::format("{}{} {:.4g} %", text.empty() ? "" : ", ", direction_names()[d], 100 * sum(as_row(d)));
    fmt::print("effective mass of these modes: {}\n", text);
}

void print_modes(const Model& model, const ModalMachine& machine, const std::vector<Mode>& modes,
                 const std::vector<ModeEnergies>& energies) {
    if (!model.title.empty()) fmt::print("{}\n", model.title);
    fmt::print("{:>4} {:>14} {:>8} {:>13}  {:<30} {}\n", "mode", "frequency", "multiple", "modal mass",
               "kinetic energy, or moves most", "strain energy");
    for (size_t m = 0; m < modes.size(); ++m) {
        const dttmm_mode& numbers = modes[m].numbers;
        fmt::print("{:>4} {:>11} Hz {:>8} {:>10} kg  {:<30} {}\n", m + 1, fmt::format("{:.8g}", numbers.frequency),
                   numbers.multiplicity > 1 ? fmt::format("x{}", numbers.multiplicity) : "",
                   fmt::format("{:.5g}", numbers.mass), motion_in_words(model, machine, modes[m], energies[m]),
                   who_strains(model, modes[m]));
    }
}

/// A negative frequency says nothing certain where a load has no potential.
void warn_growing(const ModalMachine& machine, const std::vector<Mode>& modes, Warnings& warnings) {
    const auto growing = std::ranges::count_if(modes, [](const Mode& mode) { return mode.numbers.frequency < 0; });
    if (growing == 0) return;
    const std::string what = counted(as_size(growing), "motion grows", "motions grow");
    if (!machine.nonconservative().empty())
        warnings.add("stability-undecided", undecided(what));
    else if (machine.rest())
        warnings.note("unstable-equilibrium",
                      fmt::format("the equilibrium is unstable: {} from it after the smallest disturbance, listed with a "
                                  "negative frequency; the others are those of vibrations about a place that is left",
                                  what));
}

void warn_hidden(const std::vector<Mode>& modes, Warnings& warnings) {
    size_t count = 0;
    double fastest = 0;
    for (const Mode& mode : modes)
        if (mode.numbers.frequency == 0 && mode.numbers.bracket > 0)
            ++count, fastest = std::max(fastest, mode.numbers.bracket);
    if (count > 0)
        warnings.add(
            "slow-motion",
            fmt::format("{} listed with 0 Hz may vibrate or grow at up to {:.2g} Hz: rounding of the stiffest parts hides "
                        "what holds them. Near a critical load, change the load a little",
                        counted(count, "motion", "motions"), fastest));
}

/// Where they are asked for.
std::optional<DampedModes> damped_of(const Request& request, const Plugins& plugins, const Model& model,
                                     ModalMachine& machine, const std::vector<Mode>& modes, Warnings& warnings) {
    if (!request.modes.is_damped) return std::nullopt;
    const double below = range_of_damped(model, modes);
    if (!(below > 0))
        throw Error(ExitCode::usage, "--damped: up to which frequency? nothing vibrates among these modes; give --below");
    note_damping(model, warnings);
    report_fits(model, plugins, warnings);
    return find_damped_modes(machine, modes, below, warnings);
}

void print_proof(const std::vector<Mode>& modes, const ResultsFolder& folder) {
    double widest = 0;
    bool are_slow = false;  // some that are listed with 0 Hz
    for (const Mode& mode : modes)
        if (mode.numbers.frequency != 0)
            widest = std::max(widest, mode.numbers.bracket);
        else
            are_slow = are_slow || mode.numbers.bracket > 0;
    fmt::print("counted and complete{}{}; results in {}\n",
               widest > 0 ? fmt::format(", each within {:.1e} of itself", widest) : "",
               are_slow ? ", but for what 0 Hz stands for" : "", folder.describe());
}

}  // namespace

ExitCode find_modes(const Request& request) {
    const StopSignals signals(StopSignals::First::ends);
    const Plugins plugins(request.plugins);
    Warnings warnings;
    ModalSession session(request, plugins, warnings);
    const Model& model = session.model;
    ModalMachine& machine = session.machine;
    if (request.modes.is_verbose) fmt::print(request.modes.as_json ? stderr : stdout, "{}", machine.layout());
    const std::vector<Mode> modes = session.find_modes();
    warn_growing(machine, modes, warnings);
    warn_hidden(modes, warnings);

    std::vector<ModeEnergies> energies;
    for (const Mode& mode : modes)
        energies.push_back(energies_of(model, machine, mode, as_whole<uint32_t>(energies.size())));

    std::string determinant, matrix;
    if (!request.modes.determinant.empty()) determinant = determinant_table(machine, request.modes.determinant);
    if (!request.modes.matrix.empty()) matrix = overall_matrix_table(machine, request.modes.matrix);
    std::optional<GivenShapes> given;
    if (!request.modes.shapes.empty()) given.emplace(request.modes.shapes, machine, warnings);
    if (given) given->compare(model, machine, modes);
    const std::optional<DampedModes> damped = damped_of(request, plugins, model, machine, modes, warnings);

    const ResultsFolder folder(results_path(request, "-modes"));
    Json json = describe(model, machine, modes, energies, warnings);
    if (!determinant.empty()) write_atomically(folder.file("determinant.csv"), determinant);
    if (!matrix.empty()) write_atomically(folder.file("overall_matrix.csv"), matrix);
    if (given) {
        json["mac"] = given->describe();
        write_atomically(folder.file("mac.csv"), given->table());
    }
    if (damped) {
        json["damped"] = describe(*damped);
        write_atomically(folder.file("damped.csv"), damped_table(*damped));
        write_atomically(folder.file("damped_shapes.csv"), damped_shapes(machine, *damped));
    }
    write_atomically(folder.file("modes.csv"), modes_table(machine, modes));
    write_atomically(folder.file("energies.csv"), energies_table(model, modes, energies));
    write_atomically(folder.file("shapes.csv"), shapes_table(model, machine, modes));
    warnings.print_rest("; summary.json has all of them");
    write_json(folder.file("summary.json"), [&](JsonWriter& out) {
        for (const auto& [name, value] : json.items()) out.member(name, value);
        out.member("command_line", request.command_line);
        write_inputs(out, model, request);
        write_model(out, model, plugins.catalogue());
    });
    if (request.modes.as_json) {
        fmt::print("{}", to_text(json));
    } else if (!request.quiet) {
        print_modes(model, machine, modes, energies);
        if (!modes.empty()) print_participation(model, modes);
        if (damped) print_damped(*damped);
        if (given) given->print();
        print_proof(modes, folder);
    }
    return ExitCode::ok;
}

}  // namespace dttmm::host
