// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/modal_session.h"

#include <fmt/format.h>

#include <cmath>

#include "model/index.h"
#include "record/results_folder.h"
#include "record/tell.h"

namespace dttmm::host {

namespace {

/// Whether a load pulls all the time: its mean over the second half of the run is more than a tenth of its largest value
/// there. A vibration and a blow have a small mean. Without a duration the load at the start counts.
bool is_lasting(const Signal& signal, double duration) {
    if (!(duration > 0)) return signal.value(0) != 0;
    constexpr int kSamples = 1000;
    double sum = 0, largest = 0;
    for (int i = 0; i <= kSamples; ++i) {
        const double value = signal.value(duration * (0.5 + 0.5 * i / kSamples));
        sum += value;
        largest = std::max(largest, std::abs(value));
    }
    return std::abs(sum) / (kSamples + 1) > 0.1 * largest;
}

/// Frequencies of springs that are not linear depend on the amplitude.
void note_laws(const Model& model, const ElementCatalogue& catalogue, Warnings& warnings) {
    std::vector<const Element*> with_laws;
    for (const Element& element : model.elements)
        if (has_law(*catalogue.types[as_size(element.type)], element.values)) with_laws.push_back(&element);
    if (with_laws.empty()) return;
    warnings.note(
        "law-linearised",
        fmt::format("{}: element \"{}\"{}: the frequencies are those of small vibrations: its springs that are not "
                    "linear count with their stiffness at the start",
                    with_laws[0]->place, with_laws[0]->name,
                    with_laws.size() > 1 ? fmt::format(" and {} more", with_laws.size() - 1) : ""));
}

/// Springs that have a force at the start stiffen or soften what they act on. What bears that force has one too.
void note_forces(const Model& model, const ModalMachine& machine, Warnings& warnings) {
    std::string first;
    size_t count = 0;
    for (size_t e = 0; e < model.elements.size(); ++e) {
        const double force = machine.force_at_start(e);
        if (force == 0) continue;
        if (++count == 1)
            first = fmt::format("{}: element \"{}\" has a force of {:.6g} N at the start", model.elements[e].place,
                                model.elements[e].name, force);
    }
    if (count == 0) return;
    warnings.note(
        "force-at-start",
        fmt::format("{}{}: its stiffness is in the frequencies, with that of the reaction forces of joints (not of "
                    "their moments), but not that of forces with which other elements hold against it; whether the "
                    "machine rests at the start is not looked at",
                    first, count > 1 ? fmt::format(", and {} more", count - 1) : ""));
}

Model read(const Request& request, const Plugins& plugins, Warnings& warnings) {
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::modes;
    Model model = read_model(request.model, plugins.catalogue(), overrides);
    warnings.add(model.warnings);
    warn_preload(model, warnings);
    note_laws(model, plugins.catalogue(), warnings);
    return model;
}

}  // namespace

/// Gravity and lasting loads change the frequencies of what they tension or press: an inverted pendulum on a spring may have
/// 41 % less.
void warn_preload(const Model& model, Warnings& warnings) {
    if (!model.simulation.gravity.isZero(0))
        warnings.note("gravity-not-in-modes",
                      "the frequencies are those without gravity: its stiffness, as of a pendulum, is not in them");
    std::string place;
    size_t others = 0;
    for (const Load& load : model.loads) {
        if (!is_lasting(load.signal, model.simulation.duration)) continue;
        if (place.empty())
            place = load.place;
        else
            ++others;
    }
    if (!place.empty())
        warnings.note(
            "load-not-in-modes",
            fmt::format("{}: the frequencies are those without this lasting load{}: the stiffness of its tension or "
                        "pressure is not in them",
                        place, others > 0 ? fmt::format(" and {} more", others) : ""));
}

ModalSession::ModalSession(const Request& request, const Plugins& plugins, Warnings& warnings)
    : model(read(request, plugins, warnings)), machine(model, plugins) {
    note_forces(model, machine, warnings);
}

std::vector<ModalInstance::Mode> ModalSession::find_modes() {
    std::vector<ModalInstance::Mode> modes = machine.find_modes();
    // An empty list is an answer: the count proves it
    if (modes.empty() && model.modes.below)
        tell(fmt::format("{}: no natural frequency lies below {:g} Hz", model.modes.below_place, *model.modes.below));
    return modes;
}

std::filesystem::path results_path(const Request& request, const char* suffix) {
    if (request.output) return *request.output;
    std::filesystem::path path = default_results_path(request.model);
    path += suffix;
    return path;
}

}  // namespace dttmm::host
