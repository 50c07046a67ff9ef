// SPDX-License-Identifier: BSD-3-Clause
#include "cli/command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <new>
#include <system_error>

#include "analysis/modes.h"
#include "analysis/run.h"
#include "analysis/sweep.h"
#include "cli/crash_report.h"
#include "model/diagnostics.h"
#include "model/wording.h"
#include "record/tell.h"

namespace dttmm {

namespace {

/// What the words ask for.
struct Arguments {
    FrfRequest frf;
    ModesRequest modes;
    std::string count, below, beams;
    RunRequest request;
    std::vector<std::string> sets, sweeps;
    std::string output, step, duration, coupling, tolerance;
    int jobs = 0;
};

void add_model_options(CLI::App& command, Arguments& arguments) {
    command.add_option("MODEL", arguments.request.model, "model file (TOML, format dttmm/1)")->required();
    command.add_option("--set", arguments.sets, "name=value: another value for a parameter of the model")
        ->allow_extra_args(false);
    command.add_option("--step", arguments.step, "time step instead of the model's, e.g. \"0.5 ms\"");
    command.add_option("--tolerance", arguments.tolerance,
                       "halve the step until results are within, e.g. \"0.1 %\", instead of the model's");
    command.add_option("--duration", arguments.duration, "duration instead of the model's");
    command.add_option("--coupling", arguments.coupling, "\"implicit\" or \"explicit\" instead of the model's");
    command.add_option("--plugin", arguments.request.plugins, "shared library with more element types")
        ->allow_extra_args(false);
    command.add_flag("--force", arguments.request.force, "run an explicit coupling beyond its stable step");
}

void add_modes_options(CLI::App& command, Arguments& arguments) {
    command.add_option("MODEL", arguments.request.model, "model file (TOML, format dttmm/1)")->required();
    command.add_option("--set", arguments.sets, "name=value: another value for a parameter of the model")
        ->allow_extra_args(false);
    command.add_option("--plugin", arguments.request.plugins, "shared library with more element types")
        ->allow_extra_args(false);
    command.add_option("-o,--output", arguments.output, "results folder; default results/<model name>-modes, or -frf");
    command.add_option("--beams", arguments.beams, "\"exact\" or \"lumped\" instead of the model's");
    command.add_flag("-q,--quiet", arguments.request.quiet, "no table");
}

void add_modes_only(CLI::App& command, Arguments& arguments) {
    command.add_option("--count", arguments.count, "the first so many frequencies instead of the model's");
    command.add_option("--below", arguments.below, "all frequencies up to this one, e.g. \"500 Hz\"");
    command.add_option("--sweep", arguments.sweeps, "name=from..to:count or name=value,value; several span a grid")
        ->allow_extra_args(false);
    command.add_flag("-v,--verbose", arguments.modes.is_verbose, "print how the overall transfer equation is laid out");
    command.add_flag("--json", arguments.modes.as_json, "print one JSON object instead of the table");
}

void add_frf_only(CLI::App& command, Arguments& arguments) {
    command.add_option("--in", arguments.frf.input, "body, marker or node and direction of the force, e.g. plate.corner1.z")
        ->required();
    command.add_option("--out", arguments.frf.output_place, "the same of the displacement")->required();
    command.add_option("--from", arguments.frf.from, "lowest frequency, e.g. \"1 Hz\"")->required();
    command.add_option("--to", arguments.frf.to, "highest frequency")->required();
    command.add_option("--points", arguments.frf.points, "number of frequencies")
        ->required()
        ->check(CLI::Range(2, 10000000));
    command.add_flag("--log", arguments.frf.is_logarithmic, "spaced by equal factors");
}

void add_run_options(CLI::App& command, Arguments& arguments) {
    command.add_option("-o,--output", arguments.output, "results folder; default results/<model name>");
    command.add_option("--sweep", arguments.sweeps, "name=from..to:count or name=value,value; several span a grid")
        ->allow_extra_args(false);
    command.add_option("-j,--jobs", arguments.jobs, "cases of a sweep at a time; default one per core")
        ->check(CLI::Range(1, 4096));
    command.add_flag("-q,--quiet", arguments.request.quiet, "no table and no progress bar");
}

std::pair<std::string, std::string> parse_set(const std::string& text) {
    const size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
        throw Error(ExitCode::usage, fmt::format("--set {}: write name=value", text));
    return {text.substr(0, equals), text.substr(equals + 1)};
}

/// Moves the plain option texts to where the analyses look for them.
void settle(Arguments& arguments) {
    RunRequest& request = arguments.request;
    for (const std::string& text : arguments.sets) request.overrides.parameters.push_back(parse_set(text));
    if (!arguments.step.empty()) request.overrides.step = arguments.step;
    if (!arguments.duration.empty()) request.overrides.duration = arguments.duration;
    if (!arguments.coupling.empty()) request.overrides.coupling = arguments.coupling;
    if (!arguments.tolerance.empty()) request.overrides.tolerance = arguments.tolerance;
    if (!arguments.output.empty()) request.output = arguments.output;
    if (!arguments.count.empty()) request.overrides.modes.count = arguments.count;
    if (!arguments.beams.empty()) request.overrides.modes.beams = arguments.beams;
    if (!arguments.below.empty()) request.overrides.modes.below = arguments.below;
}

ExitCode modes_or_sweep(Arguments& arguments) {
    static_cast<RunRequest&>(arguments.modes) = arguments.request;
    if (arguments.sweeps.empty()) return find_modes(arguments.modes);
    std::vector<SweepAxis> axes;
    for (const std::string& text : arguments.sweeps) axes.push_back(parse_sweep_axis(text));
    return sweep_modes(arguments.modes, axes);
}

ExitCode response(Arguments& arguments) {
    static_cast<RunRequest&>(arguments.frf) = arguments.request;
    return find_response(arguments.frf);
}

ExitCode run_or_sweep(const Arguments& arguments) {
    if (arguments.sweeps.empty()) return run(arguments.request);
    std::vector<SweepAxis> axes;
    for (const std::string& text : arguments.sweeps) axes.push_back(parse_sweep_axis(text));
    return run_sweep(arguments.request, axes, arguments.jobs);
}

void refuse_unknown_subcommand(const CLI::App& app) {
    const std::vector<std::string> words = app.remaining();
    if (!app.get_subcommands().empty() || words.empty() || words.front().starts_with("-")) return;
    std::vector<std::string> known;
    for (const CLI::App* command : app.get_subcommands({})) known.push_back(command->get_name());
    throw Error(ExitCode::usage,
                fmt::format("there is no subcommand {}{}", quote(words.front()), suggestion(words.front(), known)));
}

ExitCode dispatch(int argc, char** argv) {
    CLI::App app{"Rigid bodies by ODE, everything between them by transfer matrices.", "dttmm"};
    app.set_version_flag("--version", DTTMM_VERSION);
    app.require_subcommand(1);
    Arguments arguments;
    for (int i = 0; i < argc; ++i) arguments.request.command_line += (i ? " " : "") + std::string(argv[i]);

    CLI::App* run_command = app.add_subcommand("run", "run a model and record its histories");
    add_model_options(*run_command, arguments);
    add_run_options(*run_command, arguments);
    CLI::App* check_command = app.add_subcommand("check", "validate a model, print what would be solved");
    add_model_options(*check_command, arguments);
    CLI::App* modes_command = app.add_subcommand("modes", "natural frequencies and shapes of a model");
    add_modes_options(*modes_command, arguments);
    add_modes_only(*modes_command, arguments);
    CLI::App* frf_command = app.add_subcommand("frf", "frequency response of a model");
    add_modes_options(*frf_command, arguments);
    add_frf_only(*frf_command, arguments);
    CLI::App* elements_command = app.add_subcommand("elements", "list element types and their parameters");
    elements_command->add_option("--plugin", arguments.request.plugins, "shared library with more element types")
        ->allow_extra_args(false);

    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        refuse_unknown_subcommand(app);
        return app.exit(error) == 0 ? ExitCode::ok : ExitCode::usage;
    }
    settle(arguments);
    if (*run_command) return run_or_sweep(arguments);
    if (*modes_command) return modes_or_sweep(arguments);
    if (*frf_command) return response(arguments);
    if (*check_command)
        check(arguments.request);
    else
        print_elements(arguments.request.plugins);
    return ExitCode::ok;
}

/// A reader that has gone away, as in `dttmm run ... | head -1`, is no failure; a full disk is.
ExitCode judge_output_failure(int number) {
    if (number == EPIPE) return ExitCode::ok;
    tell(fmt::format("dttmm: cannot write to the standard output: {}", std::strerror(number)));
    return ExitCode::input_output;
}

/// Dispatches and sees what was printed out of the house.
ExitCode dispatch_and_flush(int argc, char** argv) {
    try {
        const ExitCode code = dispatch(argc, argv);
        if (std::fflush(stdout) == 0 || code != ExitCode::ok) return code;
        return judge_output_failure(errno);
    } catch (const std::system_error& error) {
        if (!std::ferror(stdout)) throw;  // else it is fmt::print's
        return judge_output_failure(error.code().value());
    }
}

}  // namespace

int run_command(int argc, char** argv) {
    std::signal(SIGPIPE, SIG_IGN);
    const CrashReport crash_report;
    ExitCode code = ExitCode::internal_error;
    try {
        code = dispatch_and_flush(argc, argv);
    } catch (const ModelError& error) {
        tell(error.what());  // every line begins with its file:line:column
        code = error.code();
    } catch (const Error& error) {
        tell(fmt::format("dttmm: {}", error.what()));
        code = error.code();
    } catch (const std::bad_alloc&) {
        tell("dttmm: out of memory");
        code = ExitCode::resource_limit;
    } catch (const std::exception& error) {
        tell(fmt::format("dttmm: internal error: {}", error.what()));
    }
    return static_cast<int>(code);
}

}  // namespace dttmm
