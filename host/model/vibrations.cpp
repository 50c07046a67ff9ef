// SPDX-License-Identifier: BSD-3-Clause
#include "model/vibrations.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "model/error.h"
#include "model/index.h"
#include "model/signal_shapes.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

/// `text`: "load", "node "a""
void check(const Signal& signal, const std::string& place, const std::string& text, Model& model) {
    if (signal.as<PsdSignal>())
        model.warnings.push_back(
            {"psd-in-time",
             fmt::format("{}: {}: a power spectral density acts in `dttmm response` only, it is zero in a run; "
                         "give a run a table of the vibration over time",
                         place, text)});
    const auto* harmonic = signal.as<HarmonicSignal>();
    if (!harmonic || harmonic->frequency()) {
        if (!harmonic || !harmonic->needs_speed() || harmonic->speed()) return;
        throw Error(ExitCode::model_invalid,
                    fmt::format("{}: {}: its amplitude rests on the speed, and the model has none; add a parameter, Omega = "
                                "\"3000 rpm\", or ask `dttmm response` with --rpm",
                                place, text));
    }
    throw Error(ExitCode::model_invalid,
                harmonic->is_order()
                    ? fmt::format("{}: {}: order {:g} of which speed? add a parameter, Omega = \"3000 rpm\", or ask `dttmm "
                                  "response` with --rpm",
                                  place, text, harmonic->order())
                    : fmt::format("{}: {}: in a run a harmonic wants a frequency or an order; without one it acts in `dttmm "
                                  "response`, at all frequencies asked for",
                                  place, text));
}

bool vibrates(const Signal& signal) { return signal.as<HarmonicSignal>() || signal.as<PsdSignal>(); }

}  // namespace

void check_vibrations(Model& model) {
    for (const Load& load : model.loads) {
        check(load.signal, load.place, "load", model);
        if (load.signal_at_to) check(*load.signal_at_to, load.place, "load", model);
    }
    for (const Node& node : model.nodes)
        for (const auto& signal : node.motion)
            if (signal) check(*signal, node.motion_place, fmt::format("node \"{}\": motion", node.name), model);
    for (const Joint& joint : model.joints)
        if (joint.drive) check(*joint.drive, joint.drive_place, fmt::format("joint \"{}\"", joint.name), model);
}

void set_vibrations_aside(Model& model) {
    for (Load& load : model.loads) {
        const bool vibrates_at_to = load.signal_at_to && vibrates(*load.signal_at_to);
        if (vibrates(load.signal)) load.vibration = std::exchange(load.signal, Signal());
        if (vibrates_at_to) load.vibration_at_to = std::exchange(*load.signal_at_to, Signal());
    }
    for (Node& node : model.nodes)
        for (size_t d = 0; d < 6; ++d)
            if (node.motion[d] && vibrates(*node.motion[d])) {
                node.vibrations[d] = std::exchange(*node.motion[d], Signal());
            }
    for (Joint& joint : model.joints) {
        if (!joint.drive || !vibrates(*joint.drive)) continue;
        joint.drive = Signal();
        model.warnings.push_back(
            {"driven-joint-held", fmt::format("{}: joint \"{}\": a motor vibrates in a run only; here it holds the joint",
                                              joint.drive_place, joint.name)});
    }
}

std::string describe_left_out(const Model& model) {
    std::vector<std::string> all;
    const auto add = [&](const std::string& what, const auto& factor_of) {
        std::vector<std::string> cases;
        for (const LoadCase& one : model.cases)
            if (factor_of(one) != 0) cases.push_back(quote(one.name));
        all.push_back(fmt::format("{} vibrates in {}", what, cases.empty() ? "no case" : "case " + listed(cases)));
    };
    for (size_t i = 0; i < model.loads.size(); ++i) {
        const Load& load = model.loads[i];
        if (!load.vibration || load.vibration_factor != 0) continue;
        add(fmt::format("load {}({})", load.name.empty() ? "" : quote(load.name) + " ", load.place),
            [&](const LoadCase& one) { return one.load_factors[i]; });
    }
    for (size_t n = 0; n < model.nodes.size(); ++n) {
        const Node& node = model.nodes[n];
        const bool is_moved = std::ranges::any_of(node.vibrations, [](const auto& signal) { return signal.has_value(); });
        if (!is_moved || node.vibration_factor != 0) continue;
        add(fmt::format("node {} ({})", quote(node.name), node.motion_place),
            [&](const LoadCase& one) { return one.motion_factors[n]; });
    }
    return all.empty() ? "" : fmt::format("; {}; choose a case with it, or leave --case out", fmt::join(all, ", "));
}

}  // namespace dttmm::host
