// SPDX-License-Identifier: BSD-3-Clause
#include "cli/command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <new>
#include <system_error>

#include "analysis/channel_list.h"
#include "analysis/modes.h"
#include "analysis/run.h"
#include "analysis/sweep.h"
#include "cli/crash_report.h"
#include "model/diagnostics.h"
#include "model/wording.h"
#include "record/tell.h"

namespace dttmm {

namespace {

/// A command: its bit among those of the options, and what it does.
struct CommandLine {
    Command bit;
    const char* name;
    const char* help;
    ExitCode (*run)(const Request& request);
};

std::vector<SweepAxis> axes_of(const Request& request) {
    std::vector<SweepAxis> axes;
    for (const std::string& text : request.sweeps) axes.push_back(parse_sweep_axis(text));
    return axes;
}

const CommandLine kCommands[] = {
    {kRun, "run", "run a model and record its histories",
     [](const Request& request) { return request.sweeps.empty() ? run(request) : run_sweep(request, axes_of(request)); }},
    {kCheck, "check", "validate a model, print what would be solved",
     [](const Request& request) {
         check(request);
         return ExitCode::ok;
     }},
    {kModes, "modes", "natural frequencies and shapes of a model",
     [](const Request& request) {
         return request.sweeps.empty() ? find_modes(request) : sweep_modes(request, axes_of(request));
     }},
    {kFrf, "frf", "frequency response of a model", find_response},
    {kChannels, "channels", "list what a run of a model can record",
     [](const Request& request) {
         print_channels(request);
         return ExitCode::ok;
     }},
    {kElements, "elements", "list element types and their parameters",
     [](const Request& request) {
         print_elements(request.plugins);
         return ExitCode::ok;
     }},
};

/// Makes the words of a command known to the parser, which hands what it meets to the request.
void add_option(CLI::App& command, const Option& option, Request& request) {
    const auto take = [&](const std::string& value) { give(request, option, value); };
    CLI::Option* added = nullptr;
    switch (option.kind) {
        case Option::Kind::flag:
            added = command.add_flag_callback(
                option.names, [take] { take(""); }, option.help);
            break;
        case Option::Kind::number:
            added = command.add_option_function<int>(
                option.names, [take](int value) { take(std::to_string(value)); }, option.help);
            added->check(CLI::Range(option.least, option.most));
            break;
        case Option::Kind::list:
            added = command.add_option_function<std::vector<std::string>>(
                option.names, [take](const std::vector<std::string>& values) { std::ranges::for_each(values, take); },
                option.help);
            added->allow_extra_args(false);
            break;
        case Option::Kind::text:
            added = command.add_option_function<std::string>(option.names, take, option.help);
            break;
    }
    added->required(option.is_required);
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
    Request request;
    for (int i = 0; i < argc; ++i) request.command_line += (i ? " " : "") + std::string(argv[i]);
    std::vector<std::pair<CLI::App*, const CommandLine*>> commands;
    for (const CommandLine& command : kCommands) {
        CLI::App* const added = app.add_subcommand(command.name, command.help);
        commands.emplace_back(added, &command);
        if (command.bit != kElements)
            added->add_option("MODEL", request.model, "model file (TOML, format dttmm/1)")->required();
        if (command.bit == kChannels) added->add_option("PATTERN", request.patterns, "e.g. \"bolt*.force\"; default all");
        for (const Option& option : options())
            if (option.commands & command.bit) add_option(*added, option, request);
    }
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        refuse_unknown_subcommand(app);
        return app.exit(error) == 0 ? ExitCode::ok : ExitCode::usage;
    }
    for (const auto& [parsed, command] : commands)
        if (*parsed) return command->run(request);
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
