// SPDX-License-Identifier: BSD-3-Clause
#include "cli/manual.h"

#include <fmt/format.h>

#include "cli/command.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

struct Meaning {
    ExitCode code;
    const char* text;
};

constexpr Meaning kExitCodes[] = {
    {ExitCode::ok, "success"},
    {ExitCode::usage, "usage: an option or its value is wrong"},
    {ExitCode::model_invalid, "the model is invalid: every fault with its line, the rule and the cure"},
    {ExitCode::numerical_failure, "the numbers failed: the rows before it are kept"},
    {ExitCode::input_output, "a file cannot be read or written"},
    {ExitCode::resource_limit, "memory or disk is not enough"},
    {ExitCode::plugin_failure, "a plugin failed; element and time are named"},
    {ExitCode::internal_error, "a fault of dttmm itself"},
    {ExitCode::cases_failed, "some cases of a sweep failed"},
    {ExitCode::stopped_by_user, "stopped by the user: the rows are kept"},
};

/// A text as roff has it: hyphens that are minus signs, and no line that begins with a control character.
std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : text) out += c == '-' ? "\\-" : c == '\\' ? "\\e" : std::string(1, c);
    return out.starts_with('.') || out.starts_with('\'') ? "\\&" + out : out;
}

const char* given_text(Given given) {
    switch (given) {
        case Given::model:
            return " MODEL";
        case Given::models:
            return " MODEL...";
        case Given::model_and_patterns:
            return " MODEL [PATTERN...]";
        case Given::topic:
            return " [TOPIC]";
        case Given::folder:
            return " FOLDER";
        case Given::shell:
            return " SHELL";
        case Given::library:
            return " FILE";
        case Given::results:
            return " RESULTS";
        case Given::study:
            return " MODEL|status FOLDER|collect FOLDER|retry FOLDER|work FOLDER CASES";
        case Given::several_results:
            return " RESULTS...";
        case Given::results_and_patterns:
            return " RESULTS PATTERN...";
        case Given::nothing:
            break;
    }
    return "";
}

void print_command(const CommandLine& command) {
    fmt::print(".SS dttmm {}{}\n{}.\n", command.name, escaped(given_text(command.given)), escaped(command.help));
    for (const Option& option : options())
        if (option.commands & command.bit)
            fmt::print(".TP\n.B {}{}\n{}.\n", escaped(option.names), option.kind == Option::Kind::flag ? "" : " VALUE",
                       escaped(option.help));
}

}  // namespace

void print_manual(const Request&) {
    fmt::print(
        ".TH DTTMM 1 \"\" \"dttmm {}\" \"User Commands\"\n.SH NAME\ndttmm \\- vibration of rigid bodies and what joins "
        "them\n.SH SYNOPSIS\n",
        DTTMM_VERSION);
    for (const CommandLine& command : commands())
        fmt::print(".B dttmm {}\n[OPTION...]{}\n.br\n", command.name, escaped(given_text(command.given)));
    fmt::print(
        ".SH DESCRIPTION\nODE integrates rigid bodies; transfer matrices in discrete time describe everything between "
        "them: bolts, mounts, hinges, beams. A model is one TOML file, its folder with the name model.toml, or \\- for "
        "the standard input.\n.SH COMMANDS\n");
    for (const CommandLine& command : commands()) print_command(command);
    fmt::print(".SH EXIT STATUS\n");
    for (const Meaning& meaning : kExitCodes)
        fmt::print(".TP\n.B {}\n{}.\n", static_cast<int>(meaning.code), escaped(meaning.text));
    fmt::print(
        ".SH EXAMPLES\n.EX\ndttmm new pump\ndttmm check pump\ndttmm run pump \\-\\-set k1=\\(dq90 N/mm\\(dq\n"
        "dttmm modes pump\n.EE\n");
}

}  // namespace dttmm::host
