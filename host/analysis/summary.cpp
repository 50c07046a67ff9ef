// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/summary.h"

#include <fmt/format.h>
#include <algorithm>
#include <array>
#include <bit>

#include <cmath>
#include <fstream>
#include <functional>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "coupling/newton_convergence.h"
#include "loader/build_id.h"
#include "loader/plugin_library.h"
#include "model/index.h"
#include "model/read_joint.h"
#include "record/results_folder.h"

namespace dttmm::host {

namespace {

Json vector_json(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json matrix_json(const Eigen::Matrix3d& m) { return {vector_json(m.row(0)), vector_json(m.row(1)), vector_json(m.row(2))}; }

std::string name_of(const Model& model, const Attachment& at) {
    if (at.is_ground()) return "ground";
    if (at.node >= 0) return model.nodes[as_size(at.node)].name;
    const Body& body = model.bodies[as_size(at.body)];
    return at.marker < 0 ? body.name : fmt::format("{}.{}", body.name, body.markers[as_size(at.marker)].name);
}

/// A number as the model may write it: a word for what is not finite, null for what is not given.
Json value_json(double value, const dttmm_parameter& parameter) {
    for (uint32_t w = 0; w < parameter.word_count; ++w)
        if (parameter.words[w].value == value && (!std::isfinite(value) || parameter.flags & DTTMM_PARAMETER_WORDS_ONLY))
            return parameter.words[w].name;
    return std::isfinite(value) ? Json(value) : Json();
}

Json describe_element(const Model& model, const Element& element, const dttmm_element_type& type) {
    Json out = {{"type", type.name}};
    if (type.ends == DTTMM_ENDS_AT)
        for (const Attachment& end : element.ends) out["at"].push_back(name_of(model, end));
    else
        for (size_t i = 0; i < 2; ++i) out[i == 0 ? "from" : "to"] = name_of(model, element.ends[i]);
    auto value = element.values.begin();
    for (uint32_t p = 0; p < type.parameter_count; ++p) {
        const dttmm_parameter& parameter = type.parameters[p];
        const std::string name = parameter.name;
        const size_t dot = name.find('.');
        Json& values = dot == name.npos ? out[name] : out[name.substr(0, dot)][name.substr(dot + 1)];
        values = Json::array();
        for (uint32_t i = 0; i < parameter.count; ++i, ++value)
            if (!(parameter.flags & DTTMM_PARAMETER_TABLE) || std::isfinite(*value))
                values.push_back(value_json(*value, parameter));
    }
    return out;
}

Json describe_body(const Body& body) {
    Json markers = Json::object();
    for (const Marker& marker : body.markers) markers[marker.name] = vector_json(marker.position);
    return {{"mass", body.mass},
            {"center_of_mass", vector_json(body.center_of_mass)},
            {"inertia", matrix_json(body.inertia)},
            {"position", vector_json(body.position)},
            {"rotation", matrix_json(body.rotation)},
            {"velocity", vector_json(body.velocity)},
            {"angular_velocity", vector_json(body.angular_velocity)},
            {"markers", markers}};
}

Json describe_node(const Node& node) {
    constexpr const char* kDirections[] = {"x", "y", "z", "rx", "ry", "rz"};
    Json fixed = Json::array();
    for (size_t d = 0; d < 6; ++d)
        if (node.fixed[d]) fixed.push_back(kDirections[d]);
    Json out = {{"position", vector_json(node.position)}, {"rotation", matrix_json(node.rotation)}, {"fixed", fixed}};
    if (node.moves) {
        out["velocity"] = vector_json(node.velocity);
        out["angular_velocity"] = vector_json(node.angular_velocity);
    }
    return out;
}

Json describe_statistics(const ChannelStatistics& statistics) {
    return {{"peak", statistics.peak}, {"peak_time", statistics.peak_time}, {"final", statistics.final}};
}

using Wanted = std::function<bool(const Channel&)>;

/// Peak, time of peak and final value of the channels wanted, as owner → quantity → axis. tell(owner, its quantities) is
/// called for every owner: all of them together may be too large for the memory.
template <class Tell>
void describe_channels(const Recorder& recorder, const Wanted& wanted, const Tell& tell) {
    const std::span<const Channel> all = recorder.channels();
    std::vector<int> chosen;
    chosen.reserve(as_size(std::ranges::count_if(all, wanted)));
    for (int c = 1; c < as_int(all.size()); ++c)
        if (wanted(all[as_size(c)])) chosen.push_back(c);
    const auto owner = [&](int c) { return &all[as_size(c)].owner(); };
    std::ranges::sort(chosen, {}, [&](int c) { return std::pair(owner(c), c); });
    std::vector<std::span<const int>> owners;
    size_t count = 0;
    for (size_t i = 0; i < chosen.size(); ++i) count += i == 0 || owner(chosen[i]) != owner(chosen[i - 1]);
    owners.reserve(count);
    for (auto rest = std::span<const int>(chosen); !rest.empty(); rest = rest.subspan(owners.back().size())) {
        const auto end = std::ranges::find_if(rest, [&](int c) { return owner(c) != owner(rest.front()); });
        owners.emplace_back(rest.begin(), end);
    }
    std::ranges::sort(owners, {}, [](std::span<const int> channels) { return channels.front(); });
    for (const std::span<const int> channels : owners) {
        Json quantities;
        for (const int c : channels) {
            const Channel& channel = all[as_size(c)];
            Json& quantity = quantities[channel.quantity()];
            (channel.axis().empty() ? quantity : quantity[channel.axis()]) = describe_statistics(recorder.statistics(c));
        }
        tell(*owner(channels.front()), std::move(quantities));
    }
}

void write_channels(JsonWriter& out, const char* section, const Recorder& recorder, const Wanted& wanted) {
    out.object(section, [&] {
        describe_channels(recorder, wanted,
                          [&](std::string_view owner, const Json& quantities) { out.member(owner, quantities); });
    });
}

/// A force or moment, of an element or joint above all; an angle, travel or length of one.
bool tells_of_link(const Channel& channel) {
    const std::string& quantity = channel.quantity();
    return quantity == "force" || quantity == "moment" || quantity == "angle" || quantity == "travel" ||
           quantity == "length";
}

Wanted is_of(Channel::Of of) {
    return [of](const Channel& channel) { return channel.of() == of && tells_of_link(channel); };
}

bool is_position(const Channel& channel) { return channel.quantity() == "position"; }
bool is_acceleration(const Channel& channel) { return channel.quantity() == "acceleration"; }

/// NaN, which JSON does not know, is null.
Json number_json(double value) { return std::isnan(value) ? Json() : Json(value); }

/// Channels of the summary that a run to a tolerance knows at its shortest step alone.
Json list_unselected(const Halving& halving, std::span<const Channel> channels) {
    Json names = Json::array();
    for (int c = 1; c < as_int(channels.size()); ++c)
        if (counts_in_summary(channels[as_size(c)]) != Recorder::Counts::nothing && !halving.is_selected(c))
            names.push_back(channels[as_size(c)].name());
    return names;
}

Json describe_tolerance(const Halving& halving, std::span<const Channel> channels) {
    Json levels = Json::array(), estimates = Json::object();
    for (const Level& level : halving.levels())
        levels.push_back({{"step", level.step},
                          {"steps", level.steps},
                          {"relative_error", number_json(level.error)},
                          {"worst_channel", level.worst},
                          {"observed_order", number_json(level.order)}});
    for (size_t i = 1; i < halving.estimates().size(); ++i) estimates[halving.channel(i)] = halving.estimates()[i];
    const bool finished = !halving.levels().empty();
    return {{"tolerance", halving.tolerance()},
            {"reached", halving.reached()},
            {"first_step", halving.first_step()},
            {"step", halving.simulation().step_size()},
            {"relative_error", finished ? number_json(halving.levels().back().error) : Json()},
            {"observed_order", finished ? number_json(halving.levels().back().order) : Json()},
            {"levels", levels},
            {"error_estimate", estimates},
            {"at_shortest_step", list_unselected(halving, channels)}};
}

Json describe_energy(const Recorder& recorder) {
    Json energy = Json::object();
    for (size_t c = 1; c < recorder.channels().size(); ++c) {
        const Channel& channel = recorder.channels()[c];
        if (channel.of() != Channel::Of::energy) continue;
        const ChannelStatistics& statistics = recorder.statistics(as_int(c));
        energy[channel.quantity()] = {{"peak", statistics.peak}, {"final", statistics.final}};
    }
    return energy;
}

}  // namespace

std::string digest_of(const std::filesystem::path& path) {
    std::ifstream file(from_start(path), std::ios::binary);
    std::array<char, 1 << 16> block;  // plugins are large
    uint64_t digest = 0, size = 0;
    while (file.read(block.data(), block.size()), file.gcount() > 0) {
        const std::string_view text(block.data(), as_size(file.gcount()));
        digest = std::rotl(digest, 1) * 0x9e3779b97f4a7c15ULL ^ std::hash<std::string_view>{}(text);
        size += text.size();
    }
    return fmt::format("{:016x}-{}", digest, size);
}

namespace {

Json describe_shares(const FastestMode& mode) {
    Json shares = Json::object();
    for (const ElementShare& element : mode.elements) shares[element.element] = element.share;
    return shares;
}

/// Why the step with the most passes took them.
std::string why_worst(const StepReport& worst) {
    if (worst.passes <= 1) return "no step took more than one pass";
    if (worst.stops > 0) return fmt::format("joint stops were active: {}", worst.stops);
    if (worst.rate > NewtonConvergence::kSlow)
        return fmt::format("each correction was up to {:.2g} times the one before", worst.rate);
    return "the corrections fell fast, but the first one was large";
}

/// Of an explicit coupling that something limits; null else.
Json describe_limit(const Simulation& simulation) {
    const auto& limit = simulation.explicit_limit();
    if (!limit || limit->load == 0) return nullptr;
    return {{"omega_h", limit->load},
            {"stable_below", kExplicitLimit},
            {"longest_step", limit->longest_step},
            {"damping_share", limit->damping_share},
            {"frequency_hz", limit->mode.omega / (2 * M_PI)},
            {"body", limit->mode.body},
            {"elements", describe_shares(limit->mode)}};
}

Json describe_load(const Model& model, const Load& load) {
    Json out = {{"on", load.is_per_length() ? model.elements[as_size(load.element)].name : name_of(model, load.on)},
                {"quantity", load.quantity()},
                {"direction", vector_json(load.direction)}};
    if (load.turns) out["axes"] = load.is_per_length() ? "element" : "body";
    const double end = model.simulation.duration;
    if (!load.is_per_length()) {
        out["at_start"] = load.signal.value(0);
        out["at_end"] = load.signal.value(end);
        return out;
    }
    if (!load.turns) out["axes"] = "world";
    out["at_start"] = {load.signal.value(0), load.at_to().value(0)};  // at the ends `from` and `to`
    out["at_end"] = {load.signal.value(end), load.at_to().value(end)};
    return out;
}

}  // namespace

void write_model(JsonWriter& out, const Model& model, const ElementCatalogue& catalogue) {
    const bool is_implicit = model.simulation.coupling == Coupling::implicit;
    Json joints = Json::object(), parameters = Json::object();
    for (const Joint& joint : model.joints) {
        Json& entry =
            joints[joint.name] = {{"type", joint_type_name(joint.type)},
                                  {"between", {name_of(model, {joint.first, -1}), name_of(model, {joint.second, -1})}},
                                  {"anchor", vector_json(joint.anchor)},
                                  {"axis", vector_json(joint.axis)}};
        if (joint.type == JointType::universal) entry["axis2"] = vector_json(joint.axis2);
        if (joint.limits) entry["limits"] = *joint.limits;
    }
    for (const Parameter& parameter : model.parameters) parameters[parameter.name] = parameter.value;
    out.object("model", [&] {
        out.member("title", model.title);
        out.member("parameters", parameters);
        if (model.simulation.step > 0)  // natural frequencies need none
            out.member("simulation", {{"duration", model.simulation.duration},
                                      {"step", model.simulation.step},
                                      {"coupling", is_implicit ? "implicit" : "explicit"},
                                      {"scheme", is_implicit ? "centred" : scheme_name(model.simulation.scheme)},
                                      {"spectral_radius", model.simulation.spectral_radius},
                                      {"gravity", vector_json(model.simulation.gravity)}});
        out.object("bodies", [&] {
            for (const Body& body : model.bodies) out.member(body.name, describe_body(body));
        });
        out.object("nodes", [&] {
            for (const Node& node : model.nodes) out.member(node.name, describe_node(node));
        });
        out.array("loads", model.loads, [&](const Load& load) { return describe_load(model, load); });
        out.member("joints", joints);
        out.object("elements", [&] {
            for (const Element& element : model.elements)
                out.member(element.name, describe_element(model, element, *catalogue.types[as_size(element.type)]));
        });
    });
}

namespace {

/// The program and the plugin that comes with it: another build may give other results under the same version.
const std::string& describe_build() {
    static const std::string build =
        fmt::format("{} {}", build_id_at(reinterpret_cast<const void*>(&describe_build)), PluginLibrary::built_in_build());
    return build;
}

}  // namespace

namespace {

constexpr const char* kModelText = "model_text";

/// All inputs but the text of the model.
Json describe_other_inputs(const Model& model, const Request& request) {
    Json given = Json::object(), files = Json::object(), plugins = Json::object();
    for (const Option& one : options())  // in the order of the table, however they were given
        for (const auto& [option, value] : request.given)
            if (option == &one && one.changes_results) given[one.name()].push_back(value);
    for (const std::filesystem::path& file : model.files) files[file.string()] = digest_of(file);
    for (const std::string& plugin : request.plugins) plugins[plugin] = digest_of(plugin);
    return {
        {"options", given}, {"files", files}, {"plugins", plugins}, {"version", DTTMM_VERSION}, {"build", describe_build()}};
}

}  // namespace

Json describe_inputs(const Model& model, const Request& request) {
    Json inputs = {{kModelText, model.source}};
    inputs.update(describe_other_inputs(model, request));
    return inputs;
}

void write_inputs(JsonWriter& out, const Model& model, const Request& request) {
    const Json others = describe_other_inputs(model, request);
    out.object("inputs", [&] {
        out.text(kModelText, model.source);
        for (const auto& [name, value] : others.items()) out.member(name, value);
    });
}

Json describe_warnings(const Warnings& warnings) {
    Json list = Json::array();
    for (const Warning& warning : warnings.all()) list.push_back({{"code", warning.code}, {"text", warning.text}});
    return list;
}

Recorder::Counts counts_in_summary(const Channel& channel) {
    if (channel.of() == Channel::Of::energy) return Recorder::Counts::extremes;
    const bool is_printed = tells_of_link(channel) || is_position(channel) || is_acceleration(channel);
    return is_printed ? Recorder::Counts::peak : Recorder::Counts::nothing;
}

void write_run(JsonWriter& out, const Model& model, const Request& request, const Plugins& plugins,
               const Simulation& simulation, const Recorder& recorder, const Outcome& outcome, const Halving* halving,
               const Warnings& warnings) {
    const auto steps = static_cast<double>(std::max<uint64_t>(simulation.index(), 1));
    Json versions = {{"dttmm", DTTMM_VERSION}, {"ode", World::engine_version()}};
    for (const PluginLibrary& library : plugins.libraries())
        versions["plugins"][library.name()] = fmt::format("{} {}", library.table().name, library.table().version);
    out.member("format", "dttmm-summary/1");
    out.member("status", outcome.status);
    out.member("reason", outcome.reason);
    out.member("warnings", describe_warnings(warnings));
    out.member("title", model.title);
    out.member("command_line", request.command_line);
    out.member("versions", versions);
    out.member("steps", outcome.steps);
    out.member("rows", recorder.rows());
    out.member("wall_time", outcome.wall_time);
    out.member("wall_time_per_step", outcome.wall_time / static_cast<double>(std::max<uint64_t>(outcome.steps, 1)));
    const StepReport& worst = simulation.end_of_step().worst();
    out.member("worst_step", {{"step", worst.step},
                              {"time", worst.time},
                              {"passes", worst.passes},
                              {"factorisations", worst.factorisations},
                              {"inside_factorisations", worst.inside_factorisations},
                              {"rate", worst.rate},
                              {"stops", worst.stops},
                              {"waited_for", simulation.waited_for(worst)},
                              {"why", why_worst(worst)}});
    out.member("coupling", {{"passes", simulation.end_of_step().passes()},
                            {"passes_per_step", static_cast<double>(simulation.end_of_step().passes()) / steps},
                            {"factorisations", simulation.end_of_step().factorisations()}});
    const FastestMode& fastest = simulation.fastest_mode();
    out.object("fastest_vibration", [&] {
        out.member("omega_h", fastest.omega * simulation.step_size());
        out.member("frequency_hz", fastest.omega / (2 * M_PI));
        out.member("body", fastest.body);
        out.object("elements", [&] {
            for (const ElementShare& element : fastest.elements) out.member(element.element, element.share);
        });
        out.member("explicit_limit", describe_limit(simulation));
    });
    out.member("energy", describe_energy(recorder));
    write_channels(out, "elements", recorder, is_of(Channel::Of::element));
    write_channels(out, "joints", recorder, is_of(Channel::Of::joint));
    write_channels(out, "positions", recorder, is_position);
    write_channels(out, "accelerations", recorder, is_acceleration);
    write_inputs(out, model, request);
    write_model(out, model, plugins.catalogue());
    if (halving) out.member("tolerance", describe_tolerance(*halving, recorder.channels()));
}

}  // namespace dttmm::host
