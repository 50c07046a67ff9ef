// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_model.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/attachments.h"
#include "model/element_scale.h"
#include "model/expanded_file.h"
#include "model/freed_memory.h"
#include "model/index.h"
#include "model/name_registry.h"
#include "model/read_body.h"
#include "model/read_case.h"
#include "model/read_element.h"
#include "model/read_joint.h"
#include "model/read_load.h"
#include "model/read_measured.h"
#include "model/read_node.h"
#include "model/read_signal.h"
#include "model/read_study.h"
#include "model/text_file.h"
#include "model/vibrations.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

namespace fs = std::filesystem;

/// A run moves in all directions.
void check_dofs(const TableReader& file) {
    if (const TomlMember* dofs = file.find("dofs"))
        file.error(
            dofs->place,
            "dofs is for `dttmm modes`; in a run everything moves as it is held: hold nodes with `fixed`, bodies with "
            "joints");
}

/// What `modes` says is for another command, so that one file serves both.
void check_modes(const TableReader& file) {
    const TomlMember* modes = file.find("modes");
    if (modes && !modes->value.is_table())
        file.error(modes->place, fmt::format("modes must be a table, got {}; write [modes]", kind_text(modes->value.kind)));
}

void check_bodies(const TableReader& file, const Model& model) {
    if (!model.nodes.empty()) return;
    const TomlMember* bodies = file.find("body");
    if (!bodies || (bodies->value.is_array() && model.bodies.empty()))
        file.error(bodies ? bodies->place : file.place(),
                   "no body: at least one [[body]] is needed, or [nodes] with elements on them");
}

/// A node that no element holds would never be heard of again. Of a file with other faults this is not known.
void check_nodes(const TableReader& file, const Model& model) {
    const TomlMember* nodes = file.find("nodes");
    if (!nodes || file.context().diagnostics.has_errors()) return;
    std::vector<bool> is_used(model.nodes.size());
    for (const Element& element : model.elements)
        for (const Attachment& end : element.ends)
            if (end.node >= 0) is_used[as_size(end.node)] = true;
    for (std::size_t i = 0; i < nodes->value.members.size(); ++i)  // behind them those of moving ground ends
        if (!is_used[i])
            file.error(nodes->value.members[i].place,
                       fmt::format("node {} is used nowhere: no element holds it", quote(model.nodes[i].name)));
}

/// A body that nothing holds, drives or pulls stays where it is: most likely something was forgotten.
void warn_free_bodies(const TableReader& file, const Model& model) {
    if (!model.simulation.gravity.isZero(0)) return;
    std::vector<bool> is_touched(model.bodies.size());
    const auto touch = [&](int body) {
        if (body >= 0) is_touched[as_size(body)] = true;
    };
    for (const Load& load : model.loads) touch(load.on.body);
    for (const Element& element : model.elements) {
        for (const Attachment& end : element.ends) touch(end.body);
    }
    for (const Joint& joint : model.joints) {
        touch(joint.first);
        touch(joint.second);
    }
    const std::vector<TomlValue>& entries = read_entries(file, "body");
    for (std::size_t i = 0; i < is_touched.size(); ++i)
        if (!is_touched[i])
            file.warning(entries[i].place, "free-body",
                         fmt::format("body {}: free body: no element, joint, load or gravity acts on it",
                                     quote(model.bodies[i].name)));
}

/// Markers with a rotation of their own that are the axes of no element: most likely the element has others than meant.
void warn_turned_markers(const TableReader& file, const Model& model, const Attachments& attachments) {
    const auto axes_of = [&](const Element& element) {
        if (element.axes) return *element.axes;
        return attachments.axes(element.ends[element.ends[0].is_ground() ? 1 : 0]);
    };
    const std::vector<TomlValue>& entries = read_entries(file, "body");
    for (std::size_t b = 0; b < model.bodies.size() && b < entries.size(); ++b)
        for (std::size_t m = 0; m < model.bodies[b].markers.size(); ++m) {
            const Marker& marker = model.bodies[b].markers[m];
            if (!marker.rotation || marker.rotation->isIdentity(0)) continue;
            const Attachment at{as_int(b), as_int(m), -1};
            bool is_attached = false, is_used = false;
            for (const Element& element : model.elements) {
                if (std::find(element.ends.begin(), element.ends.end(), at) == element.ends.end()) continue;
                is_attached = true;
                is_used = is_used || (axes_of(element) - attachments.axes(at)).norm() < 1e-12;
            }
            if (is_attached && !is_used)
                file.warning(
                    entries[b].place, "unused-rotation",
                    fmt::format("body {}: the rotation of marker {} is used by no element: elements have the axes of "
                                "their `from` end; write `axes = \"to\"` in the element, or begin it at this marker",
                                quote(model.bodies[b].name), quote(marker.name)));
        }
}

/// What starts in equilibrium has no velocities.
void check_rest(const TableReader& file, const Model& model) {
    const auto refuse = [&](const char* kind, const std::string& name) {
        file.error(file.find("simulation")->value.place,
                   fmt::format("start = \"equilibrium\", but {} {} starts with a velocity: leave one of them out", kind,
                               quote(name)));
    };
    for (const Body& body : model.bodies)
        if (!body.velocity.isZero(0) || !body.angular_velocity.isZero(0)) refuse("body", body.name);
    for (const Node& node : model.nodes)
        if (node.moves && (!node.velocity.isZero(0) || !node.angular_velocity.isZero(0))) refuse("node", node.name);
}

void read_contents(const TableReader& file, const ElementCatalogue& catalogue, const ModelOverrides& overrides,
                   Model& model) {
    // After a fault of a pattern or of an included file its bodies are missing: one message is enough
    const bool has_all_tables = !file.context().diagnostics.has_errors();
    NameRegistry body_names("body"), node_names("node"), element_names("element");
    model.title = file.text("title", "").value_or("");
    const bool has_histories = overrides.purpose == Purpose::histories;
    if (has_histories || file.find("simulation")) {
        model.simulation = read_simulation(file, overrides, has_histories);
        model.output = read_output(file, model.simulation, overrides);
    }
    model.bodies = read_bodies(file, body_names);
    model.nodes = read_nodes(file, {&body_names}, node_names);
    check_modes(file);
    model.modes = read_modes(file, overrides.modes);
    model.damping = read_damping(file);
    model.study = read_study(file);
    model.measured = read_measured(file);
    if (has_histories && !model.damping.place.empty())
        file.error(file.find("damping")->place,
                   "[damping] acts in modes --damped, frf and response only; a run wants damping of elements: of a spring "
                   "that a mode of frequency f strains most, damping = zeta k/(pi f)");
    if (overrides.purpose != Purpose::modes) check_dofs(file);
    if (has_all_tables) check_bodies(file, model);
    const Attachments attachments(model.bodies, model.nodes);
    // An element may be called like the node it stands at: forces are the one's, motions the other's
    model.elements = read_elements(file, catalogue, attachments, {&body_names}, element_names, model.nodes);
    model.loads = read_loads(file, {attachments, model.elements, element_names, catalogue});
    model.cases = read_cases(file, model);
    model.joints = read_joints(file, attachments, model.bodies, {&body_names, &node_names, &element_names});
    check_nodes(file, model);
    if (model.simulation.starts_at_rest) check_rest(file, model);
    if (!file.context().diagnostics.has_errors()) warn_turned_markers(file, model, attachments);
}

/// A loss factor has no form in time.
void refuse_loss_factors(const Model& model, const ElementCatalogue& catalogue) {
    for (const Element& element : model.elements) {
        const dttmm_element_type& type = *catalogue.types[as_size(element.type)];
        size_t first = 0;
        for (uint32_t p = 0; p < type.parameter_count; first += type.parameters[p++].count) {
            const std::string_view name = type.parameters[p].name;
            if (!name.ends_with("loss_factor") || !(element.values[first] > 0)) continue;
            throw Error(ExitCode::model_invalid,
                        fmt::format("{}: element {}: {}: a loss factor acts in modes --damped, frf and response only; a run "
                                    "wants a damping: loss_factor times stiffness over 2 pi f, with the frequency f that "
                                    "matters",
                                    element.place, quote(element.name), name));
        }
    }
}

}  // namespace

Model read_model(const fs::path& file, const ElementCatalogue& catalogue, const ModelOverrides& overrides) {
    Model model = parse_model(read_text_file(file), file, catalogue, overrides);
    give_back_memory();
    return model;
}

Model parse_model(std::string_view text, const fs::path& file, const ElementCatalogue& catalogue,
                  const ModelOverrides& overrides) {
    ExpandedFile expanded(text, file, catalogue, overrides);
    Diagnostics& diagnostics = expanded.diagnostics;
    const Parameters& parameters = *expanded.parameters;
    Model model;
    model.path = file.string();
    model.source = text;
    model.parameters = parameters.all();
    const ReadContext context = expanded.context();
    const TableReader root(context, expanded.document, "", key_table("file"));
    read_contents(root, catalogue, overrides, model);
    for (Body& body : model.bodies)
        for (Marker& marker : body.markers)
            marker.is_probe = std::ranges::find(expanded.probes, body.name + "." + marker.name) != expanded.probes.end();
    diagnostics.throw_if_errors();
    model.files = expanded.inputs.read;
    if (overrides.purpose == Purpose::histories) warn_free_bodies(root, model);
    model.warnings = diagnostics.warnings();
    if (overrides.purpose == Purpose::histories) {
        refuse_loss_factors(model, catalogue);
        check_vibrations(model);
    } else {
        set_vibrations_aside(model);
    }
    model.machine_rests_on_speed = parameters.has_used(kSpeed);
    for (const ElementScale& scale : overrides.scales) scale_element(model, catalogue, scale);
    if (overrides.load_case) {
        const LoadCase asked = find_case(model, *overrides.load_case);
        apply_case(model, asked);
        model.load_case = asked.name;
    }
    return model;
}

}  // namespace dttmm::host
