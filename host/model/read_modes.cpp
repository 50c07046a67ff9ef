// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

[[noreturn]] void refuse(const std::string& fault) { throw Error(ExitCode::usage, fault); }

int count_of(const std::string& text) {
    long count = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), count);
    if (fault != std::errc{} || end != text.data() + text.size() || count < 1 || count > kMostModes)
        refuse(fmt::format("--count wants a whole number from 1 to {}, got {}", kMostModes, quote(text)));
    return as_int(count);
}

double frequency_of(const std::string& text) {
    double below = 0;
    try {
        below = parse_quantity(text, "Hz");
    } catch (const Error& error) {
        refuse(fmt::format("--below: {}", error.what()));
    }
    if (!(below > 0)) refuse(fmt::format("--below wants a frequency of more than zero, got {}", quote(text)));
    return below;
}

/// The index of an option's word among those of its key.
int choice_of(const char* key, const std::string& text) {
    const std::vector<std::string> words = words_of(*find_key(key_table("modes"), key));
    const auto found = std::ranges::find(words, text);
    if (found == words.end()) refuse(fmt::format("--{} must be one of {}, got {}", key, listed(words), quote(text)));
    return as_int(found - words.begin());
}

About about_of(int choice) { return choice == 0 ? About::start : About::equilibrium; }

}  // namespace

const std::vector<std::string> kDirections = {"x", "y", "z", "rx", "ry", "rz"};

std::bitset<6> read_directions(const TableReader& table, const std::string& key) {
    std::bitset<6> directions;
    const TomlMember* member = table.find(key);
    if (!member) return directions;
    if (!member->value.is_array()) {
        table.error(member->value.place, fmt::format("{} must be a list of directions out of {}; got {}", key,
                                                     listed(kDirections), kind_text(member->value.kind)));
        return directions;
    }
    for (const TomlValue& item : member->value.items) {
        const auto found = std::find(kDirections.begin(), kDirections.end(), item.string);
        const std::string got = item.is_text() ? quote(item.string) : std::string(kind_text(item.kind));
        const auto d = as_size(found - kDirections.begin());
        if (!item.is_text() || found == kDirections.end())
            table.error(item.place, fmt::format("{}: {} is none of the directions {}", key, got, listed(kDirections)));
        else if (directions[d])
            table.error(item.place, fmt::format("{} names {} twice", key, got));
        else
            directions[d] = true;
    }
    return directions;
}

DampingSettings read_damping(const TableReader& file) {
    DampingSettings settings;
    const TomlMember* member = file.find("damping");
    if (!member) return settings;
    const TableReader table(file.context(), member->value, "damping", key_table("damping"));
    settings.place = file.context().diagnostics.place_text(member->place);
    if (!table.is_valid()) return settings;
    if (const TomlMember* modal = table.find("modal")) {
        settings.ratios = table.numbers("modal").value_or(std::vector<double>());
        settings.is_of_all = !modal->value.is_array();
    }
    settings.mass_rate = table.number("mass_rate", 0).value_or(0);
    return settings;
}

ModesSettings read_modes(const TableReader& file, const ModesOverrides& overrides) {
    ModesSettings settings;
    if (const TomlMember* dofs = file.find("dofs")) {
        settings.directions = read_directions(file, "dofs");
        if (dofs->value.is_array() && dofs->value.items.empty())
            file.error(dofs->place, "dofs names no direction: nothing moves");
    }
    if (const TomlMember* member = file.find("modes"); member && member->value.is_table()) {
        const TableReader table(file.context(), member->value, "modes", key_table("modes"));
        const TomlMember* count = table.find("count");
        const TomlMember* below = table.find("below");
        if (count && below) table.error(below->place, "count and below are two ways to say how many: give one");
        if (count) {
            const double number = table.number("count").value_or(1);
            if (number != static_cast<int>(number)) table.error(count->value.place, "count must be a whole number");
            settings.count = static_cast<int>(number);
        }
        if (below) {
            settings.below = table.number("below").value_or(0);
            settings.below_place = file.context().diagnostics.place_text(below->value.place);
        }
        settings.are_beams_lumped = table.choice("beams", 0).value_or(0) == 1;
        if (table.find("about")) settings.about = about_of(table.choice("about", 0).value_or(0));
    }
    if (overrides.count && overrides.below) refuse("--count and --below are two ways to say how many: give one");
    if (overrides.beams) settings.are_beams_lumped = choice_of("beams", *overrides.beams) == 1;
    if (overrides.about) settings.about = about_of(choice_of("about", *overrides.about));
    if (overrides.count) {
        settings.count = count_of(*overrides.count);
        settings.below.reset();
    }
    if (overrides.below) {
        settings.below = frequency_of(*overrides.below);
        settings.below_place = "--below";
    }
    if (settings.about == About::equilibrium && !settings.directions.all())
        file.error(file.find("dofs")->place,
                   "dofs leaves directions out, about = \"equilibrium\" wants them all: leave dofs away, or write about = "
                   "\"start\" in [modes] (--about start)");
    return settings;
}

}  // namespace dttmm::host
