// SPDX-License-Identifier: BSD-3-Clause
#include "cli/command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <new>
#include <sstream>
#include <system_error>

#include "analysis/channel_list.h"
#include "analysis/check.h"
#include "analysis/check_law.h"
#include "analysis/frf.h"
#include "analysis/help.h"
#include "analysis/modal_session.h"
#include "analysis/modes.h"
#include "analysis/modes_sweep.h"
#include "analysis/response.h"
#include "analysis/response_sweep.h"
#include "analysis/run.h"
#include "analysis/spectrum.h"
#include "analysis/statics.h"
#include "analysis/sweep.h"
#include "cli/completion.h"
#include "cli/crash_report.h"
#include "cli/manual.h"
#include "identify/diagnose.h"
#include "identify/identify.h"
#include "identify/local_sensitivity.h"
#include "identify/optimise.h"
#include "model/diagnostics.h"
#include "model/index.h"
#include "model/keys.h"
#include "model/wording.h"
#include "record/hdf5_writer.h"
#include "record/results_folder.h"
#include "record/tell.h"
#include "report/export.h"
#include "report/plot.h"
#include "report/report.h"
#include "report/show.h"
#include "study/study.h"
#include "world/world.h"

namespace dttmm::host {

namespace {

std::vector<SweepAxis> axes_of(const Request& request) {
    std::vector<SweepAxis> axes;
    for (const std::string& text : request.sweeps) axes.push_back(parse_sweep_axis(text));
    return axes;
}

/// Options that say something about one case.
void refuse_with_sweep(const Request& request, std::initializer_list<const char*> names) {
    for (const auto& [option, value] : request.given)
        if (std::ranges::find(names, option->name()) != names.end())
            throw Error(ExitCode::usage, fmt::format("{} is for one case: a sweep has many; ask for the case of interest "
                                                     "with --set",
                                                     option->name()));
}

/// The model of a folder is its model.toml.
std::filesystem::path model_file(const std::filesystem::path& path) {
    std::error_code fault;
    return std::filesystem::is_directory(path, fault) ? path / "model.toml" : path;
}

/// As the terminal shows it. Every line of a model's faults begins with its file:line:column.
std::string describe(const Error& error) {
    return dynamic_cast<const ModelError*>(&error) ? error.what() : fmt::format("dttmm: {}", error.what());
}

/// What prints something and cannot fail otherwise than by an exception.
template <void (*print)(const Request&)>
ExitCode plain(const Request& request) {
    print(request);
    return ExitCode::ok;
}

/// Of several files each is checked, whatever becomes of the others; the code is the largest.
ExitCode check_all(const Request& request) {
    ExitCode worst = ExitCode::ok;
    for (const std::string& model : request.words) {
        Request one = request;
        one.model = model_file(model);
        try {
            check(one);
        } catch (const Error& error) {
            if (request.words.size() == 1) throw;
            tell(describe(error));
            worst = std::max(worst, error.code());
        }
    }
    return worst;
}

// In the order of the help. Columns: bit, name, help, what it is given besides options, what it does.
const CommandLine kCommands[] = {
    {kRun, "run", "run a model and record its histories", Given::model,
     [](const Request& request) {
         if (request.sweeps.empty() && request.jobs > 0)
             throw Error(ExitCode::usage,
                         "--jobs is for the cases of a sweep: one run has one; leave it out, or give --sweep");
         if (request.sweeps.empty()) return run(request);
         if (request.run.trace)
             throw Error(ExitCode::usage, "--trace is for one run: a sweep has many; run the case of interest with --set");
         return run_sweep(request, axes_of(request));
     }},
    {kCheck, "check", "validate a model, print what would be solved", Given::models, check_all},
    {kModes, "modes", "natural frequencies and shapes of a model", Given::model,
     [](const Request& request) {
         if (request.sweeps.empty()) return find_modes(request);
         refuse_with_sweep(request, {"--determinant", "--matrix", "--mac", "--damped"});
         return sweep_modes(request, axes_of(request));
     }},
    {kStatic, "static", "equilibrium of a model under weight and lasting loads", Given::model, find_equilibrium},
    {kFrf, "frf", "frequency response of a model", Given::model, find_response},
    {kResponse, "response", "steady vibration of a model over frequency or speed, under its loads or unit forces",
     Given::model,
     [](const Request& request) {
         return request.sweeps.empty() ? find_steady_response(request) : sweep_response(request, axes_of(request));
     }},
    {kStudy, "study", "many cases of a model: scatter, grids and tables, on all cores or a cluster", Given::study,
     [](const Request& request) {
         Request own = request;
         own.model = model_file(request.words.front());
         return run_study(own);
     }},
    {kIdentify, "identify", "parameters of a model from measured frequencies, responses or histories", Given::model,
     identify},
    {kDiagnose, "diagnose", "which element is loose, how loose and how sure, from measured data", Given::model, diagnose},
    {kSensitivity, "sensitivity", "how figures change with parameters, in % per %", Given::model, find_sensitivities},
    {kOptimise, "optimise", "parameters within ranges that make a figure least, most or a value", Given::model, optimise},
    {kSpectrum, "spectrum", "spectra, levels, modes and orders of a recorded run", Given::results, find_spectrum},
    {kReport, "report", "one HTML file of any results: curves, tables, the machine in 3-D", Given::several_results,
     make_report},
    {kPlot, "plot", "curves of channels as a picture, or in the terminal", Given::results_and_patterns, plot_curves},
    {kShow, "show", "three views of a model as an SVG picture", Given::model, show_model},
    {kExport, "export", "results for other programs: glTF, VTU, MAT, universal files", Given::results, export_results},
    {kChannels, "channels", "list what a run of a model can record", Given::model_and_patterns, plain<print_channels>},
    {kCheckLaw, "check-law", "test the force laws of a library", Given::library, plain<check_law>},
    {kNew, "new", "make a folder with a first model", Given::folder, plain<make_new>},
    {kHelp, "help", "keys of a table or an element type, with a complete model", Given::topic, plain<print_help>},
    {kElements, "elements", "list element types and their parameters", Given::topic, plain<print_elements>},
    {kSchema, "schema", "print a JSON schema of the model file, for editors", Given::nothing, plain<print_schema>},
    {kCompletion, "completion", "print what makes a shell complete words: bash, zsh or fish", Given::shell,
     plain<print_completion>},
    {kManual, "manual", "print the manual page, for man", Given::nothing, plain<print_manual>},
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

/// Makes known to the parser what a command is given besides options.
void add_given(CLI::App& command, Given given, Request& request) {
    switch (given) {
        case Given::model:
        case Given::model_and_patterns:
            command.add_option("MODEL", request.model, "model file (TOML), its folder, or - for the standard input")
                ->required();
            if (given == Given::model_and_patterns)
                command.add_option("PATTERN", request.patterns, "e.g. \"bolt*.force\"; default all");
            break;
        case Given::models:
            command.add_option("MODEL", request.words, "model files (TOML), their folders, or - for the standard input")
                ->required();
            break;
        case Given::topic:
            command.add_option("TOPIC", request.words, "default all")->expected(0, 1);
            break;
        case Given::folder:
            command.add_option("FOLDER", request.words, "that is made")->required()->expected(1);
            break;
        case Given::shell:
            command.add_option("SHELL", request.words, "bash, zsh or fish")->required()->expected(1);
            break;
        case Given::library:
            command.add_option("FILE", request.words, "shared library with laws (dttmm_law.h)")->required()->expected(1);
            break;
        case Given::results:
            command.add_option("RESULTS", request.words, "results folder of a run, or its history.csv")
                ->required()
                ->expected(1);
            break;
        case Given::study:
            command
                .add_option("MODEL", request.words,
                            "model file (TOML), or its folder; or one of: status FOLDER, collect FOLDER, retry FOLDER, work "
                            "FOLDER CASES")
                ->required()
                ->expected(1, 5);
            break;
        case Given::results_and_patterns:
            command
                .add_option("RESULTS PATTERN", request.words,
                            "results folder of any command, or several, then patterns of channels, e.g. \"bolt*.force.z\"")
                ->required()
                ->expected(2, -1);
            break;
        case Given::several_results:
            command.add_option("RESULTS", request.words, "results folders of any command; several are shown together")
                ->required();
            break;
        case Given::nothing:
            break;
    }
}

/// Says what is wrong with the words, under the name of the command that they are for.
[[noreturn]] void refuse_words(const CLI::App& app, const CLI::ParseError& error) {
    const std::vector<CLI::App*> parsed = app.get_subcommands();
    const CLI::App& command = parsed.empty() ? app : *parsed.front();
    const std::vector<std::string> surplus = app.remaining(true);
    std::string text = error.what();
    if (parsed.empty() && !surplus.empty() && !surplus.front().starts_with("-")) {
        std::vector<std::string> known;
        for (const CLI::App* one : app.get_subcommands({})) known.push_back(one->get_name());
        text = fmt::format("there is no subcommand {}{}", quote(surplus.front()), suggestion(surplus.front(), known));
    } else if (!surplus.empty()) {
        std::vector<std::string> known;
        for (const CLI::Option* option : command.get_options()) known.push_back(option->get_name());
        text = fmt::format("{} was not expected{}", surplus.front(),
                           surplus.front().starts_with("-") ? suggestion(surplus.front(), known) : "");
    }
    const std::string name = parsed.empty() ? "" : command.get_name();
    throw Error(ExitCode::usage, fmt::format("{}{}{}; \"dttmm{}{} --help\" says what there is", name,
                                             name.empty() ? "" : ": ", text, name.empty() ? "" : " ", name));
}

/// Of the program and of the libraries that its results rest on.
std::string version_text() {
    return fmt::format("dttmm {}\nODE {}, Eigen {}.{}.{}, HDF5 {}, fmt {}.{}.{}\nBSD-3-Clause", DTTMM_VERSION,
                       World::engine_version(), EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION,
                       Hdf5Writer::version(), FMT_VERSION / 10000, FMT_VERSION / 100 % 100, FMT_VERSION % 100);
}

/// earlier: the results that the command would replace, where it takes their folder at its end only.
ExitCode dispatch(int argc, char** argv, EarlierResults& earlier) {
    if (argc > 1 && argv[1] == std::string_view("complete")) {
        complete({argv + 2, argv + argc});
        return ExitCode::ok;
    }
    CLI::App app{"Rigid bodies by ODE, everything between them by transfer matrices.", "dttmm"};
    app.set_version_flag("-V,--version", version_text());
    app.require_subcommand(1);
    Request request;
    for (int i = 0; i < argc; ++i) request.command_line += (i ? " " : "") + std::string(argv[i]);
    const auto is_a_word = [&](const char* name) {
        return std::find(argv + 1, argv + argc, std::string_view(name)) != argv + argc;
    };
    std::vector<std::pair<CLI::App*, const CommandLine*>> commands;
    for (const CommandLine& command : kCommands) {
        CLI::App* const added = app.add_subcommand(command.name, command.help);
        commands.emplace_back(added, &command);
        if (!is_a_word(command.name)) continue;  // of what is not asked for the name is enough
        add_given(*added, command.given, request);
        for (const Option& option : options())
            if (option.commands & command.bit) add_option(*added, option, request);
    }
    if (argc == 1) {
        fmt::print(stderr, "{}", app.help());
        throw Error(ExitCode::usage, "A subcommand is required");
    }
    // Help on a command is its own, but for `modes`, which is a table too
    std::vector<char*> words(argv, argv + argc);
    char help[] = "--help";
    const auto is_second = [&](const auto& thing) { return words[2] == std::string_view(thing.name); };
    if (argc == 3 && words[1] == std::string_view("help") && std::ranges::any_of(kCommands, is_second) &&
        std::ranges::none_of(key_tables(), is_second))
        words = {words[0], words[2], help};
    try {
        app.parse(as_int(words.size()), words.data());
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() != 0) refuse_words(app, error);
        std::ostringstream text;  // of help or version
        app.exit(error, text);
        fmt::print("{}", text.str());
        return ExitCode::ok;
    }
    for (const auto& [parsed, command] : commands) {
        if (!*parsed) continue;
        request.model = model_file(request.model);
        if (command->given == Given::model)
            earlier = EarlierResults(results_path(request, fmt::format("-{}", command->name).c_str()));
        return command->run(request);
    }
    return ExitCode::ok;
}

/// A reader that has gone away, as in `dttmm run ... | head -1`, is no failure; a full disk is.
ExitCode judge_output_failure(int number) {
    if (number == EPIPE) return ExitCode::ok;
    tell(fmt::format("dttmm: cannot write to the standard output: {}", std::strerror(number)));
    return ExitCode::input_output;
}

/// Dispatches and sees what was printed out of the house.
ExitCode dispatch_and_flush(int argc, char** argv, EarlierResults& earlier) {
    try {
        const ExitCode code = dispatch(argc, argv, earlier);
        if (std::fflush(stdout) == 0 || code != ExitCode::ok) return code;
        return judge_output_failure(errno);
    } catch (const std::system_error& error) {
        if (!std::ferror(stdout)) throw;  // else it is fmt::print's
        return judge_output_failure(error.code().value());
    }
}

}  // namespace

std::span<const CommandLine> commands() { return kCommands; }

int run_command(int argc, char** argv) {
    std::signal(SIGPIPE, SIG_IGN);
    const CrashReport crash_report;
    ExitCode code = ExitCode::internal_error;
    EarlierResults earlier;
    try {
        code = dispatch_and_flush(argc, argv, earlier);
    } catch (const Error& error) {
        tell(describe(error));
        code = error.code();
        const std::string left = code == ExitCode::numerical_failure ? earlier.left() : "";
        if (!left.empty()) tell(left);
    } catch (const std::bad_alloc&) {
        tell("dttmm: out of memory");
        code = ExitCode::resource_limit;
    } catch (const std::exception& error) {
        tell(fmt::format("dttmm: internal error: {}", error.what()));
    }
    return static_cast<int>(code);
}

}  // namespace dttmm::host
