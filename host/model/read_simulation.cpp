// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_simulation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

constexpr double kWholeTolerance = 1e-6;  // of a step
constexpr double kLargestGravity = 100;   // [m/s²] more looks like another unit
constexpr double kMostGravity = 1e7;      // [m/s²] that of an ultracentrifuge, a million g

std::vector<std::string> words_of(const char* key) { return words_of(*find_key(key_table("simulation"), key)); }

bool is_whole(double ratio) { return std::abs(ratio - std::round(ratio)) <= kWholeTolerance; }

/// A number of the file as messages name it: at most 12 digits, so that 0.0010000000000000002 s reads 0.001 s.
std::string seconds(double value) { return fmt::format("{:.12g} s", value); }

/// A value of [simulation], or the option that stands for it.
struct Setting {
    TomlValue value;
    std::string what;
};

/// Reads the settings that an option of the command line can replace.
class SettingsReader {
public:
    SettingsReader(const TableReader& file, const TableReader* table, const KeyTable& keys)
        : file_(file), table_(table), keys_(keys) {}

    /// name: of the option, if it is not called like the key.
    std::optional<Setting> find(const std::string& key, const std::optional<std::string>& option,
                                const std::string& name = "") const {
        if (option || !table_) return of_option(name.empty() ? key : name, option);
        const TomlMember* member = table_->find(key);
        return member ? std::optional(Setting{member->value, table_->what(key)}) : std::nullopt;
    }
    /// The same; reports the key if it is missing.
    std::optional<Setting> require(const std::string& key, const std::optional<std::string>& option) const {
        if (!option && table_) table_->require(key);
        return find(key, option);
    }

    std::optional<double> read(const std::optional<Setting>& setting, const char* name) const {
        const Key& key = *find_key(keys_, name);
        return setting ? read_number(file_.context(), setting->value, setting->what, key.unit, key.bounds) : std::nullopt;
    }

private:
    std::optional<Setting> of_option(const std::string& key, const std::optional<std::string>& option) const {
        if (!option) return std::nullopt;
        TomlValue value;
        value.kind = TomlValue::Kind::text;
        value.place = file_.context().diagnostics.option_place("--" + key);
        value.string = *option;
        return Setting{value, key};
    }

    const TableReader& file_;
    const TableReader* table_;
    const KeyTable& keys_;
};

void check_duration(Diagnostics& diagnostics, const Setting& setting, double duration, double step) {
    const auto fail = [&](const std::string& text) { diagnostics.error(setting.value.place, setting.what + " " + text); };
    if (duration < step)
        return fail(fmt::format("must be at least one step ({}), got {}", seconds(step), seconds(duration)));
    const double steps = duration / step;
    if (steps > kMostSteps) return fail(fmt::format("is {:.3g} steps; at most {:g} are allowed", steps, kMostSteps));
    if (is_whole(steps)) return;
    const double below = std::floor(steps), above = std::ceil(steps);
    fail(fmt::format(
        "must be a whole number of steps, got {} / {} = {:.9g}; a duration of {} or {} would fit, or a step of {} or {}",
        seconds(duration), seconds(step), steps, seconds(below * step), seconds(above * step), seconds(duration / above),
        seconds(duration / below)));
}

Coupling read_coupling(const TableReader& file, const TableReader* table, const std::optional<std::string>& option) {
    int choice = 0;
    if (option) {
        const std::vector<std::string> words = words_of("coupling");
        const auto found = std::find(words.begin(), words.end(), *option);
        if (found == words.end()) {
            Diagnostics& diagnostics = file.context().diagnostics;
            diagnostics.error(diagnostics.option_place("--coupling"),
                              fmt::format("must be one of: {}; got {}", listed(words), quote(*option)));
        } else {
            choice = as_int(found - words.begin());
        }
    } else if (table) {
        choice = table->choice("coupling", 0).value_or(0);
    }
    return choice == 0 ? Coupling::implicit : Coupling::explicit_;
}

ExplicitScheme read_scheme(const TableReader& table, Coupling coupling, bool is_coupling_overridden) {
    const int scheme = table.choice("scheme", 0).value_or(0);
    if (table.find("scheme") && coupling == Coupling::implicit && !is_coupling_overridden)
        table.error(table.find("scheme")->place,
                    "scheme belongs to coupling = \"explicit\"; the implicit coupling has none to choose");
    return static_cast<ExplicitScheme>(scheme);
}

double read_spectral_radius(const TableReader& table, Coupling coupling, bool is_coupling_overridden) {
    const TomlMember* member = table.find("spectral_radius");
    if (member && coupling == Coupling::explicit_ && !is_coupling_overridden)
        table.error(member->place,
                    "spectral_radius belongs to coupling = \"implicit\"; the explicit coupling has no numerical damping");
    return table.number("spectral_radius", 1).value_or(1);
}

Eigen::Vector3d read_gravity(const TableReader& table) {
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    const Eigen::Vector3d gravity = table.vector("gravity", zero).value_or(zero);
    if (gravity.cwiseAbs().maxCoeff() > kMostGravity)
        table.error(table.find("gravity")->value.place, fmt::format("gravity must be {:g} m/s² at most, got {:g} m/s²",
                                                                    kMostGravity, gravity.cwiseAbs().maxCoeff()));
    else if (gravity.cwiseAbs().maxCoeff() > kLargestGravity)
        table.warning(
            table.find("gravity")->value.place, "gravity-unit",
            fmt::format("gravity of {} m/s² looks like mm/s²; write \"9.81 m/s^2\"", gravity.cwiseAbs().maxCoeff()));
    return gravity;
}

/// The patterns of [output] channels, with their place.
void read_channels(const TableReader& table, OutputSettings& settings) {
    const TomlMember* channels = table.find("channels");
    if (!channels) return;
    const bool is_list =
        channels->value.is_array() && std::all_of(channels->value.items.begin(), channels->value.items.end(),
                                                  [](const auto& item) { return item.is_text(); });
    if (!is_list)
        table.error(channels->value.place, "channels must be a list of texts, e.g. [\"bolt*.force\", \"plate.position\"]");
    for (const TomlValue& item : channels->value.items) settings.channels.push_back(item.string);
    settings.channels_place = table.context().diagnostics.place_text(channels->value.place);
}

}  // namespace

const std::string& scheme_name(ExplicitScheme scheme) {
    static const std::vector<std::string> names = words_of("scheme");  // in the order of ExplicitScheme
    return names[static_cast<size_t>(scheme)];
}

SimulationSettings read_simulation(const TableReader& file, const SimulationOverrides& overrides, bool is_for_run) {
    const TomlMember* member = file.find("simulation");
    std::optional<TableReader> table;
    if (member) table.emplace(file.context(), member->value, "simulation", key_table("simulation"));
    const bool is_valid = table && table->is_valid();
    const SettingsReader reader(file, is_valid ? &*table : nullptr, key_table("simulation"));
    if (is_for_run && !member && !overrides.duration)
        file.error(file.place(), "missing table [simulation] with a duration, which a run wants (or option --duration)");

    SimulationSettings settings;
    const auto step_setting = reader.find("step", overrides.step);
    const auto duration_setting =
        is_for_run ? reader.require("duration", overrides.duration) : reader.find("duration", overrides.duration);
    const auto step = reader.read(step_setting, "step");
    const auto duration = reader.read(duration_setting, "duration");
    settings.tolerance = reader.read(reader.find("tolerance", overrides.tolerance), "tolerance");
    if (!step_setting && !settings.tolerance) settings.tolerance = kDefaultTolerance;
    settings.step = step.value_or(0);
    settings.duration = duration.value_or(0);
    if (step && duration) check_duration(file.context().diagnostics, *duration_setting, *duration, *step);
    settings.coupling = read_coupling(file, is_valid ? &*table : nullptr, overrides.coupling);
    if (!is_valid) return settings;
    settings.scheme = read_scheme(*table, settings.coupling, overrides.coupling.has_value());
    settings.spectral_radius = read_spectral_radius(*table, settings.coupling, overrides.coupling.has_value());
    settings.gravity = read_gravity(*table);
    settings.starts_at_rest = table->choice("start", 0).value_or(0) == 1;
    if (settings.starts_at_rest && settings.coupling == Coupling::explicit_)
        table->error(table->find("start")->place, "start = \"equilibrium\" wants coupling = \"implicit\"");
    return settings;
}

OutputSettings read_output(const TableReader& file, const SimulationSettings& simulation,
                           const SimulationOverrides& overrides) {
    OutputSettings settings;
    const TomlMember* member = file.find("output");
    std::optional<TableReader> table;
    if (member) {
        table.emplace(file.context(), member->value, "output", key_table("output"));
        read_channels(*table, settings);
    }
    if (!overrides.channels.empty()) {
        settings.channels = overrides.channels;
        settings.channels_place = "--channels";
    }
    const SettingsReader reader(file, table && table->is_valid() ? &*table : nullptr, key_table("output"));
    const auto setting = reader.find("step", overrides.output_step, "output-step");
    const auto step = reader.read(setting, "step");
    if (!step) return settings;
    settings.step = *step;
    const auto fail = [&](const std::string& text) {
        file.context().diagnostics.error(setting->value.place, setting->what + " " + text);
    };
    if (simulation.step > 0) {
        const double every = *step / simulation.step;
        if (!is_whole(every) || every < 0.5) {
            const double below = std::max(std::floor(every), 1.0) * simulation.step;
            fail(
                fmt::format("must be a whole multiple of the time step ({}), got {}; {} or {} would fit, "
                            "or leave it out to record every step",
                            seconds(simulation.step), seconds(*step), seconds(below), seconds(below + simulation.step)));
            return settings;
        }
        if (every > 1e9) {
            fail(fmt::format("is {:.3g} time steps; at most 1e9 are allowed", every));
            return settings;
        }
        settings.every = as_int(std::lround(every));
    }
    const double rows = simulation.duration / *step;
    if (simulation.duration > 0 && (!is_whole(rows) || rows < 0.5))
        file.context().diagnostics.error(
            setting->value.place,
            fmt::format("{}: the duration ({}) must be a whole multiple of the output step ({}): the end is a row",
                        setting->what, seconds(simulation.duration), seconds(*step)));
    return settings;
}

}  // namespace dttmm::host
