// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/check.h"

#include <fmt/format.h>

#include <exception>
#include <optional>

#include "analysis/free_motions.h"
#include "analysis/machine_table.h"
#include "analysis/modal_machine.h"
#include "analysis/modal_session.h"
#include "analysis/session.h"
#include "coupling/stability.h"
#include "model/expanded_file.h"
#include "model/read_simulation.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

/// Frequencies of a larger model take `dttmm modes` longer than a check should.
constexpr size_t kMostChecked = 1000;

/// A file without [simulation], with dofs, or with elements that only the modes can have is no fault: it is not for a run.
bool is_for_modes_only(const Request& request, const Plugins& plugins) {
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::modes;
    read_model(request.model, plugins.catalogue(), overrides);
    try {
        Model model = read_model(request.model, plugins.catalogue(), request.overrides);
        if (model.simulation.step == 0) model.simulation.step = kShortestStep;  // networks want one, whichever
        const Networks networks(model, plugins);
    } catch (const Error&) {
        return true;
    }
    return false;
}

/// None where they cannot be counted: the search for modes then says why.
uint32_t count_free(ModalMachine& machine) {
    try {
        return machine.count_free().value_or(0);
    } catch (const Error&) {
        return 0;
    }
}

/// The lowest natural frequency above zero, in words. Throws Error where there are no modes.
std::string describe_lowest(const Model& model, const Plugins& plugins, Warnings& warnings) {
    if (model.bodies.size() + model.nodes.size() > kMostChecked)
        return fmt::format("natural frequencies not looked for, as there are more than {} bodies and nodes", kMostChecked);
    ModalMachine machine = make_machine(model, plugins, warnings);
    if (const uint32_t free = count_free(machine); free > FreeMotions::kMostQuick)
        return fmt::format("natural frequencies not looked for, as {}", FreeMotions{free, {}, false}.text());
    const std::vector<ModalInstance::Mode> modes = machine.find_modes();
    if (!modes.empty() && modes.front().numbers.frequency < 0 && !machine.nonconservative().empty())
        return undecided("a motion grows");
    if (!modes.empty() && modes.front().numbers.frequency < 0)
        return fmt::format("it does not rest there for long: a motion grows by a factor of e in {:.4g} s",
                           -1 / (2 * M_PI * modes.front().numbers.frequency));
    for (const ModalInstance::Mode& mode : modes)
        if (mode.numbers.frequency > 0) return fmt::format("lowest natural frequency {:.6g} Hz", mode.numbers.frequency);
    return fmt::format("no natural frequency above 0 Hz among the first {}", modes.size());
}

std::string indented(std::string text) {
    for (size_t at = text.find('\n'); at != std::string::npos; at = text.find('\n', at + 1)) text.insert(at + 1, "    ");
    return text;
}

void print_parts(const Model& model) {
    fmt::print("  {}, {}, {}, {}, {}\n", counted(model.bodies.size(), "body", "bodies"),
               counted(model.nodes.size(), "node", "nodes"), counted(model.elements.size(), "element", "elements"),
               counted(model.joints.size(), "joint", "joints"), counted(model.loads.size(), "load", "loads"));
}

void print_run(const Session& session) {
    const Model& model = session.model;
    const Simulation& simulation = session.simulation;
    const FastestMode& fastest = simulation.fastest_mode();
    const bool implicit = model.simulation.coupling == Coupling::implicit;
    int equations = 0;
    for (const JointEquations& joint : simulation.end_of_step().equations().joint_system().joints())
        equations += joint.lasting();
    fmt::print(
        "  {} ({} unknowns per step), {}{}, {} ({} equations), {}, {}\n", counted(model.bodies.size(), "body", "bodies"),
        6 * model.bodies.size(), model.nodes.empty() ? "" : counted(model.nodes.size(), "node", "nodes") + ", ",
        counted(model.elements.size(), "element", "elements"), counted(model.joints.size(), "joint", "joints"), equations,
        counted(model.loads.size(), "load", "loads"), counted(simulation.channels().size(), "channel", "channels"));
    const std::string damping =
        implicit && model.simulation.spectral_radius < 1
            ? fmt::format(" with numerical damping (spectral_radius = {:g})", model.simulation.spectral_radius)
            : "";
    fmt::print("  {} coupling{}, {} of {:g} s{}, a row every {}\n", implicit ? "implicit" : "explicit", damping,
               counted(simulation.step_count() - 1, "step", "steps"), model.simulation.step,
               session.has_chosen_step ? " (chosen, as no step is given)" : "",
               model.output.every == 1 ? "step" : fmt::format("{} steps", model.output.every));
    if (model.simulation.tolerance)
        fmt::print("  repeated at half the step until the results are within {:g} %\n", 100 * *model.simulation.tolerance);
    if (fastest.omega > 0)
        fmt::print("  fastest vibration {}: omega*h = {:.4g}, {:.3g} steps per period{}\n", describe(fastest),
                   fastest.omega * simulation.step_size(), 2 * M_PI / (fastest.omega * simulation.step_size()),
                   simulation.explicit_limit() ? ""
                   : model.nodes.empty()       ? " (the implicit coupling is stable at any)"
                                         : " (the implicit coupling is stable at any; masses inside networks not counted)");
    if (simulation.explicit_limit() && simulation.explicit_limit()->load > 0)
        fmt::print("  the explicit coupling is stable up to a step of {:.4g} s; at {:g} s: {}\n",
                   simulation.explicit_limit()->longest_step, simulation.step_size(), simulation.describe_speed());
}

}  // namespace

void check(const Request& request) {
    const Plugins plugins(request.plugins);
    std::optional<Session> session;
    std::string no_run, no_modes, lowest;
    std::exception_ptr run_fault;
    try {
        session.emplace(request);
    } catch (const Error& error) {
        if (!is_for_modes_only(request, plugins)) throw;
        no_run = error.what();
        run_fault = std::current_exception();
    }
    if (request.is_expanded) return fmt::print("{}", write_expanded(request.model, plugins.catalogue(), request.overrides));
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::modes;
    const Model for_modes = read_model(request.model, plugins.catalogue(), overrides);
    Warnings own;
    Warnings& warnings = session ? session->warnings : own;
    try {
        lowest = describe_lowest(for_modes, plugins, warnings);
    } catch (const Error& error) {
        if (!session) std::rethrow_exception(run_fault);
        no_modes = error.what();
    }
    const Model& model = session ? session->model : for_modes;
    warnings.add(model.warnings);

    fmt::print("{}: valid\n  good for {}\n", request.model.string(),
               !session           ? "modes and frf"
               : no_modes.empty() ? "run, modes and frf"
                                  : "run");
    if (!session) fmt::print("  not for run: {}\n", indented(no_run));
    if (!no_modes.empty()) fmt::print("  not for modes and frf: {}\n", indented(no_modes));
    if (session)
        print_run(*session);
    else
        print_parts(model);
    if (!lowest.empty()) fmt::print("  {}\n", lowest);
    fmt::print("{}", describe_machine(model, plugins.catalogue()));
    if (session) session->refuse_unstable(request.run.force);
    warnings.print_rest("");
}

}  // namespace dttmm::host
