// SPDX-License-Identifier: BSD-3-Clause
#include "model/vibrations.h"

#include <fmt/format.h>

#include <utility>

#include "model/error.h"
#include "model/signal_shapes.h"

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

}  // namespace dttmm::host
