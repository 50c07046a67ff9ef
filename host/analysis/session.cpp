// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string_view>

#include "analysis/first_step.h"
#include "analysis/signal_jumps.h"
#include "coupling/stability.h"
#include "model/diagnostics.h"
#include "model/index.h"
#include "model/read_simulation.h"

namespace dttmm::host {

namespace {

/// Whether an element has a damper: a parameter called so that is not zero.
bool is_damped(const Element& element, const dttmm_element_type& type) {
    auto value = element.values.begin();
    for (uint32_t p = 0; p < type.parameter_count; ++p)
        for (uint32_t i = 0; i < type.parameters[p].count; ++i, ++value)
            if (std::string_view(type.parameters[p].name).find("damping") != std::string_view::npos && *value > 0)
                return true;
    return false;
}

/// A node without mass and damper takes its place under a load at once. Where the load is there from the start the node
/// jumps within the first step, and what the first rows say of its motion is by the length of that step.
void warn_jumps(const Model& model, const ElementCatalogue& catalogue, Warnings& warnings) {
    std::vector<bool> is_held(model.nodes.size());
    for (const Element& element : model.elements) {
        const dttmm_element_type& type = *catalogue.types[as_size(element.type)];
        if (type.ends != DTTMM_ENDS_AT && !is_damped(element, type)) continue;
        for (const Attachment& end : element.ends)
            if (end.node >= 0) is_held[as_size(end.node)] = true;
    }
    for (const Load& load : model.loads) {
        if (load.on.node < 0 || is_held[as_size(load.on.node)] || load.signal.value(0) == 0) continue;
        const Node& node = model.nodes[as_size(load.on.node)];
        if (node.fixed.all()) continue;
        warnings.add(
            "load-jumps",
            fmt::format("{}: at the start this load is {:g} {} on node \"{}\", which has neither mass nor damper: it "
                        "jumps within the first step, and its first velocities and accelerations depend on the step. "
                        "Let the load rise, or give the node a mass or its elements damping",
                        load.place, load.signal.value(0), load.is_moment ? "N m" : "N", node.name));
    }
}

/// Motors that jump or whose speed does, and supports that jump, act like a blow at any step.
void warn_blows(const Model& model, Warnings& warnings) {
    const double duration = model.simulation.duration;
    const auto warn = [&](const Jump& jump, const std::string& place, const std::string& name, bool turns) {
        warnings.add(
            "motion-jumps",
            fmt::format("{}: {} jumps{} by {:.3g} {}{} at t = {:.4g} s. It does that within one step: forces grow as "
                        "the step is shortened, and energy is not accounted for. Let it rise gradually, as with "
                        "type = \"step\"",
                        place, name, jump.is_slope ? " in speed" : "", jump.size, turns ? "rad" : "m",
                        jump.is_slope ? "/s" : "", jump.time));
    };
    for (const Joint& joint : model.joints) {
        if (!joint.drive) continue;
        if (const auto jump = find_jump_of_speed([&](double t) { return joint.drive->value(t); }, duration))
            warn(*jump, joint.drive_place, fmt::format("the motor of joint \"{}\"", joint.name),
                 joint.type == JointType::hinge);
    }
    for (const Node& node : model.nodes)
        for (size_t d = 0; d < node.motion.size(); ++d) {
            if (!node.motion[d]) continue;
            if (const auto jump = find_jump([&](double t) { return node.motion[d]->value(t); }, duration))
                warn(*jump, node.motion_place, fmt::format("the motion of node \"{}\"", node.name), d >= 3);
        }
}

/// What a fixed step makes of loads that jump while it lasts.
void note_jumps(const Model& model, double step, Warnings& warnings) {
    const double end = model.simulation.duration;
    for (size_t i = 0; i < model.loads.size(); ++i) {
        const Load& load = model.loads[i];
        for (const Signal* signal : {&load.signal, load.signal_at_to ? &*load.signal_at_to : nullptr}) {
            if (!signal) continue;
            const auto parts = signal->parts();
            if (parts && parts->empty() && signal->value(0) == signal->value(end)) continue;  // constant
            const auto jump = find_jump([&](double t) { return signal->value(t); }, end);
            if (!jump || jump->time > end - step) continue;
            warnings.note(
                "load-jumps-between-steps",
                fmt::format("{}: load number {} jumps by {:.3g} {} at t = {:.4g} s. It acts up to half a step early "
                            "or late: a vibration of f Hz that it makes errs by up to {:.2g} f, of first order in "
                            "the step. A run to a tolerance bounds that",
                            load.place, i + 1, jump->size,
                            load.is_per_length() ? "N/m"
                            : load.is_moment     ? "N m"
                                                 : "N",
                            jump->time, M_PI * step));
            return;
        }
    }
}

/// Whether pictures of the machine need it: where a body, a node or a point of a beam is, the force of an element.
bool shows_motion(const Channel& channel) {
    const std::string& quantity = channel.quantity();
    switch (channel.of()) {
        case Channel::Of::body:
            return quantity == "position" || quantity == "quaternion";
        case Channel::Of::node:
            return quantity == "position" || quantity == "rotation";
        case Channel::Of::element:
            return quantity == "force" || (quantity.starts_with("station") && quantity.ends_with(".position"));
        default:
            return false;
    }
}

/// The channels the model asks for, and those that pictures of the machine need. Throws Error(model_invalid) with the place
/// of the list.
std::vector<int> selected_channels(const Model& model, const Simulation& simulation, bool records_motion) {
    const std::vector<Channel>& all = simulation.channels();
    std::vector<int> selected;
    try {
        selected = select_channels(all, model.output.channels);
    } catch (const Error& error) {
        throw ModelError(fmt::format("{}: {}", model.output.channels_place, error.what()));
    }
    if (!records_motion) return selected;
    for (int c = 0; c < as_int(all.size()); ++c)
        if (shows_motion(all[as_size(c)])) selected.push_back(c);
    std::ranges::sort(selected);
    selected.erase(std::ranges::unique(selected).begin(), selected.end());
    return selected;
}

/// A run to a tolerance needs no stable step from the user: it starts from one, its rows where they were.
Model start_stable(Model model, const Plugins& plugins, Warnings& warnings) {
    if (model.simulation.coupling != Coupling::explicit_) return model;
    const auto limit = Simulation(model, plugins).explicit_limit();
    if (!limit || limit->load < kExplicitLimit) return model;
    const double step = divide_step(model.simulation.step, 0.9 * limit->longest_step);
    const double every = model.output.every * std::round(model.simulation.step / step);
    if (step < kShortestStep || every > std::numeric_limits<int>::max()) return model;
    warnings.note("stable-first-step",
                  fmt::format("the explicit coupling would diverge at a step of {:g} s; beginning with {:.12g} s",
                              model.simulation.step, step));
    model.simulation.step = step;
    model.output.every = static_cast<int>(every);
    return model;
}

}  // namespace

Session::Session(const Request& request)
    : plugins(request.plugins),
      model(prepare(request)),
      simulation(model, plugins),
      selection(selected_channels(model, simulation, request.run.records_motion)) {
    if (!model.simulation.starts_at_rest) warn_jumps(model, plugins.catalogue(), warnings);
    warn_blows(model, warnings);
    if (!model.simulation.tolerance) note_jumps(model, simulation.step_size(), warnings);
    if (model.simulation.tolerance)
        halving.emplace(model, plugins, simulation.channels(), selection);
    else
        look_at_loads(simulation);
}

Model Session::prepare(const Request& request) {
    Model read = read_model(request.model, plugins.catalogue(), request.overrides);
    read.output.has_lines = request.run.records_motion;
    has_chosen_step = read.simulation.step == 0;
    read = choose_step(std::move(read), plugins);
    if (read.simulation.tolerance && !request.run.force) read = start_stable(std::move(read), plugins, warnings);
    warnings.add(read.warnings);
    return read;
}

void Session::look_at_loads(const Simulation& at) {
    const double tolerable = model.simulation.tolerance ? kTolerableExtrapolatedError : kTolerableLoadError;
    fast_loads = find_fast_loads(model, at, tolerable);
    for (const FastLoad& load : fast_loads) warnings.add("load-too-fast", describe(load, at.step_size()));
}

void Session::refuse_unstable(bool force) {
    if (!simulation.explicit_limit()) return;
    const ExplicitLimit& limit = *simulation.explicit_limit();
    if (limit.load >= kExplicitLimit && !force)
        throw Error(ExitCode::numerical_failure,
                    fmt::format("the explicit coupling would diverge at a step of {:.6g} s: {}; use --step \"{:.12g} s\", "
                                "--coupling implicit, or --force to run anyway",
                                simulation.step_size(), simulation.describe_speed(),
                                divide_step(simulation.step_size(), 0.9 * limit.longest_step)));
    if (limit.load > 0.8 * kExplicitLimit)
        warnings.add("near-explicit-limit",
                     fmt::format("{}: {} the limit of the explicit coupling", simulation.describe_speed(),
                                 limit.load < kExplicitLimit ? "near" : "beyond"));
}

}  // namespace dttmm::host
