// SPDX-License-Identifier: BSD-3-Clause
#include "cli/completion.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "analysis/help.h"
#include "cli/command.h"
#include "loader/plugins.h"
#include "model/read_modes.h"
#include "model/read_simulation.h"
#include "model/wording.h"
#include "record/history_file.h"
#include "step/simulation.h"

namespace dttmm::host {

namespace {

using Words = std::vector<std::string>;

// A word that the program does not complete is a file.
constexpr const char* kBash = R"sh(_dttmm() {
    local IFS=$'\n'
    COMPREPLY=($(compgen -W "$(dttmm complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null)" -- "${COMP_WORDS[COMP_CWORD]}"))
    [[ ${#COMPREPLY[@]} -eq 1 && $COMPREPLY == *= ]] && compopt -o nospace 2>/dev/null
    return 0
}
complete -o default -F _dttmm dttmm
)sh";

constexpr const char* kZsh = R"sh(#compdef dttmm
_dttmm() {
    local -a found
    found=("${(@f)$(dttmm complete "${(@)words[2,CURRENT]}" 2>/dev/null)}")
    if [[ -n "$found" ]]; then compadd -- $found; else _files; fi
}
if [[ "$funcstack[1]" == _dttmm ]]; then _dttmm; else compdef _dttmm dttmm; fi
)sh";

constexpr const char* kFish = R"sh(function __dttmm_complete
    set -l words (commandline -opc) (commandline -ct)
    dttmm complete $words[2..-1] 2>/dev/null
end
complete -c dttmm -a '(__dttmm_complete)'
)sh";

constexpr struct Shell {
    const char* name;
    const char* script;
} kShells[] = {{"bash", kBash}, {"zsh", kZsh}, {"fish", kFish}};

bool has_value(const Option& option) { return option.kind != Option::Kind::flag; }

bool is_called(const Option& option, const std::string& word) {
    const std::string names = fmt::format(",{},", option.names);
    return names.find(fmt::format(",{},", word)) != std::string::npos;
}

const CommandLine* find_command(const std::string& name) {
    const auto all = commands();
    const auto found = std::ranges::find_if(all, [&](const CommandLine& command) { return command.name == name; });
    return found == all.end() ? nullptr : &*found;
}

/// The option of a command that a word is.
const Option* find_option(const CommandLine& command, const std::string& word) {
    const auto found = std::ranges::find_if(
        options(), [&](const Option& option) { return (option.commands & command.bit) && is_called(option, word); });
    return found == options().end() ? nullptr : &*found;
}

/// What has been typed so far.
struct Typed {
    const CommandLine* command = nullptr;
    Words given;           ///< words that are no options
    Words plugins;         ///< paths
    const Option* awaits;  ///< the option whose value comes next
};

/// A word as the shell hands it on: with its backslashes and quotes.
std::string unquoted(const std::string& word) {
    std::string text;
    for (size_t i = 0; i < word.size(); ++i) {
        if (word[i] == '\\' && i + 1 < word.size())
            text += word[++i];
        else if (word[i] != '"' && word[i] != '\'')
            text += word[i];
    }
    return text;
}

Typed read(const Words& words) {
    Typed typed{find_command(words.front()), {}, {}, nullptr};
    if (!typed.command) return typed;
    for (size_t i = 1; i + 1 < words.size(); ++i) {
        if (typed.awaits) {
            if (typed.awaits->name() == "--plugin") typed.plugins.push_back(unquoted(words[i]));
            typed.awaits = nullptr;
        } else if (words[i].starts_with("-") && words[i] != "-") {
            const Option* option = find_option(*typed.command, words[i]);
            if (option && has_value(*option)) typed.awaits = option;
        } else {
            typed.given.push_back(words[i]);
        }
    }
    return typed;
}

Words topics(const Typed& typed) {
    const Plugins plugins(typed.plugins);
    if (typed.command->bit == kHelp) return help_topics(plugins.catalogue());
    Words found;
    for (const dttmm_element_type* type : plugins.catalogue().types) found.emplace_back(type->name);
    return found;
}

Model read_typed(const Typed& typed, const Plugins& plugins, Purpose purpose) {
    std::filesystem::path file = unquoted(typed.given.front());
    if (file == "-") throw Error(ExitCode::usage, "the standard input is the shell's");
    if (std::filesystem::is_directory(file)) file /= "model.toml";
    ModelOverrides overrides;
    overrides.purpose = purpose;
    return read_model(file, plugins.catalogue(), overrides);
}

Words parameters(const Typed& typed) {
    const Plugins plugins(typed.plugins);
    Words found;
    for (const auto& parameter : read_typed(typed, plugins, Purpose::modes).parameters)
        found.push_back(parameter.name + "=");
    return found;
}

Words channels(const Typed& typed) {
    const Plugins plugins(typed.plugins);
    Model model = read_typed(typed, plugins, Purpose::statics);
    if (model.simulation.step == 0) model.simulation.step = kShortestStep;
    const Simulation simulation(model, plugins);
    Words found;
    for (const Channel& channel : simulation.channels()) found.push_back(channel.name());
    return found;
}

/// The channels of a recorded run.
Words recorded_channels(const Typed& typed) {
    std::filesystem::path file = unquoted(typed.given.front());
    if (std::filesystem::is_directory(file)) file /= "history.csv";
    const HistoryFile history(file);
    Words found;
    for (const Column& column : history.columns())
        if (column.name != "time") found.push_back(column.name);
    return found;
}

/// Places with their directions, as --in and --out want them.
Words places(const Typed& typed) {
    const Plugins plugins(typed.plugins);
    const Model model = read_typed(typed, plugins, Purpose::modes);
    Words names, found;
    for (const Body& body : model.bodies) {
        names.push_back(body.name);
        for (const Marker& marker : body.markers) names.push_back(body.name + "." + marker.name);
    }
    for (const Node& node : model.nodes) names.push_back(node.name);
    for (const std::string& name : names)
        for (const std::string& direction : kDirections) found.push_back(name + "." + direction);
    return found;
}

Words values(const Typed& typed) {
    const std::string name = typed.awaits->name();
    if (name == "--coupling") return words_of(*find_key(key_table("simulation"), "coupling"));
    if (name == "--beams") return words_of(*find_key(key_table("modes"), "beams"));
    if (typed.command->bit == kNew && name == "--from") return {"plate", "mounts", "beam", "modes"};
    if (name == "--as") return {"receptance", "mobility", "accelerance", "transmissibility"};
    if (name == "--window") return {"hann", "rectangular", "flattop"};
    if (typed.given.empty()) return {};
    if ((typed.command->bit & (kSpectrum | kReport)) && (name == "--channels" || name == "--speed"))
        return recorded_channels(typed);
    if (name == "--set" || name == "--sweep") return parameters(typed);
    if (name == "--channels") return channels(typed);
    if (name == "--in" || name == "--out") return places(typed);
    return {};
}

Words candidates(const Words& words) {
    Words found;
    if (words.size() <= 1) {
        for (const CommandLine& command : commands()) found.emplace_back(command.name);
        return found;
    }
    const Typed typed = read(words);
    if (!typed.command) return {};
    if (typed.awaits) return values(typed);
    if (words.back().starts_with("-")) {
        for (const Option& option : options())
            if (option.commands & typed.command->bit) found.push_back(option.name());
        return found;
    }
    if (typed.command->given == Given::topic && typed.given.empty()) return topics(typed);
    if (typed.command->given == Given::shell) return {"bash", "zsh", "fish"};
    if (typed.command->given == Given::model_and_patterns && !typed.given.empty()) return channels(typed);
    if (typed.command->given == Given::results_and_patterns && !typed.given.empty()) return recorded_channels(typed);
    return {};
}

}  // namespace

void print_completion(const Request& request) {
    const std::string& name = request.words.front();
    Words names;
    for (const Shell& shell : kShells) {
        if (shell.name == name) return fmt::print("{}", shell.script);
        names.emplace_back(shell.name);
    }
    throw Error(ExitCode::usage, fmt::format("completion wants one of {}, got {}", listed(names), quote(name)));
}

void complete(const std::vector<std::string>& words) {
    try {
        for (const std::string& word : candidates(words))
            if (words.empty() || word.starts_with(words.back())) fmt::print("{}\n", word);
    } catch (const Error&) {
        // Whoever types has not finished the model: nothing is known to complete
    }
}

}  // namespace dttmm::host
