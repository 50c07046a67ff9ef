// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/modal_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "analysis/law_limits.h"
#include "analysis/line_loads.h"
#include "analysis/machine_geometry.h"
#include "analysis/material_fits.h"
#include "analysis/stop_signals.h"
#include "model/index.h"
#include "model/read_modes.h"
#include "model/read_simulation.h"
#include "model/wording.h"
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
                    "linear count with the tangent of their force at the equilibrium, or where the file places the machine",
                    with_laws[0]->place, with_laws[0]->name,
                    with_laws.size() > 1 ? fmt::format(" and {} more", with_laws.size() - 1) : ""));
}

/// Without damping, materials have the stiffness that their Maxwell series has at rest.
void note_materials(const Model& model, const ElementCatalogue& catalogue, Warnings& warnings) {
    std::vector<const Element*> with_rows;
    for (const Element& element : model.elements)
        if (has_rows(*catalogue.types[as_size(element.type)], element.values)) with_rows.push_back(&element);
    if (with_rows.empty()) return;
    warnings.note(
        "stiffness-at-rest",
        fmt::format("{}: element \"{}\"{}: natural frequencies without damping have the stiffness of its rows at rest; "
                    "`modes --damped` and `response` have that of every frequency",
                    with_rows[0]->place, with_rows[0]->name,
                    with_rows.size() > 1 ? fmt::format(" and {} more", with_rows.size() - 1) : ""));
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
    note_laws(model, plugins.catalogue(), warnings);
    note_materials(model, plugins.catalogue(), warnings);
    note_velocities(model, "velocities-not-in-modes",
                    "gyroscopic moments and centrifugal forces are not in the frequencies and responses", warnings);
    return model;
}

bool acts_at_start(const Load& load) { return load.signal.value(0) != 0 || load.at_to().value(0) != 0; }

/// A node that a support has moved at the start.
bool is_moved_at_start(const Node& node) {
    return std::ranges::any_of(node.motion, [](const auto& signal) { return signal && signal->value(0) != 0; });
}

/// A joint that a motor keeps where the file does not place it.
bool is_driven_at_start(const Joint& joint) { return joint.drive && joint.drive->value(0) != 0; }

/// Whether something pulls at the start: gravity, a load, or a support that has moved.
bool is_loaded(const Model& model) {
    return model.modes.directions.all() &&
           (!model.simulation.gravity.isZero(0) || std::ranges::any_of(model.loads, acts_at_start) ||
            std::ranges::any_of(model.nodes, is_moved_at_start) || std::ranges::any_of(model.joints, is_driven_at_start));
}

/// Names the beam whose axial force errs most by the segments that carry a load along it.
void note_rising_loads(const Model& model, const ElementCatalogue& catalogue, Warnings& warnings) {
    constexpr double kShown = 1e-3;  // of what the force has beside a linear one
    size_t count = 0, worst = 0;
    double most = 0;
    for (const auto& [e, loads] : find_line_loads(model, catalogue, 0)) {
        const double error = loads.error_of_force();
        if (error <= kShown * loads.rise * loads.length / 8) continue;
        ++count;
        if (error > most) most = error, worst = e;
    }
    if (count == 0) return;
    warnings.note(
        "line-load-segments",
        fmt::format("{}: element \"{}\": the load along it rises. Where both its ends are held along it, its axial "
                    "force errs by up to about {:.2g} N in the frequencies{}. With twice as many segments it is a "
                    "fourth",
                    model.elements[worst].place, model.elements[worst].name, most,
                    count > 1 ? fmt::format(", and that of {} more less", count - 1) : ""));
}

/// What the frequencies about an equilibrium are of, and which beams are not exact in them.
void note_rest(const Model& model, const ModalMachine& machine, const ElementCatalogue& catalogue, Warnings& warnings) {
    warnings.note("about-equilibrium",
                  "the frequencies are about the equilibrium under gravity, preloads, the loads and the supports as "
                  "they are at the start (about = \"start\": about the machine as the file places it)");
    for (const Load& load : model.loads) {
        const double duration = model.simulation.duration;
        if (!acts_at_start(load) && (is_lasting(load.signal, duration) || is_lasting(load.at_to(), duration)))
            warnings.note("load-not-in-modes",
                          fmt::format("{}: this lasting load is zero at the start: its stiffness is not in the frequencies",
                                      load.place));
    }
    warn_nonconservative(model, machine, warnings);
    if (machine.rest()) {
        note_path_end(*machine.rest(), machine.nonconservative().empty(), "", warnings);
        warn_unbalanced(*machine.rest(), "", warnings);
    }
    for (const RestLimit& limit : machine.limits_at_rest())
        if (limit.most > 1) warn_limit(limit.channel, limit.element, limit.most, "at rest", warnings);
    note_rising_loads(model, catalogue, warnings);
    // Measured of bars and cantilevers: up to 0.12 between clamps, 0.24 between pins that stay apart, 1.5 where the load
    // changes its sign, for bends of 0.006 to 1.7 and 5 to 80 segments
    constexpr double kOfBend = 0.24;
    struct Bent {
        size_t count = 0, worst = 0;
        double share = 0;
        void take(size_t element, double own) {
            if (++count == 1 || own > share) std::tie(worst, share) = std::pair(element, own);
        }
    };
    Bent exact, lumped;
    for (size_t e = 0; e < model.elements.size(); ++e) {
        bool is_lumped = false;
        const double share = machine.bent_at_rest(e, is_lumped);
        if (is_lumped)
            lumped.take(e, share);
        else if (share > 0.05)  // less is 1e-6 of a frequency with the usual ten segments
            exact.take(e, share);
    }
    const auto how = [&](const Bent& bent) {
        return fmt::format("{}: element \"{}\" is bent at rest by {:.2g} of its radius of gyration",
                           model.elements[bent.worst].place, model.elements[bent.worst].name, bent.share);
    };
    const auto more = [](const Bent& bent) {
        return bent.count > 1 ? fmt::format(", and {} more less", bent.count - 1) : "";
    };
    if (exact.count > 0)
        warnings.note(
            "bent-beam",
            fmt::format("{}{}, which is in the frequencies with a relative error of the order of {:.1g}/n^2 for n segments",
                        how(exact), more(exact), kOfBend * exact.share * exact.share));
    if (lumped.count > 0)
        warnings.note("bent-beam", fmt::format("{}{}: it counts by its segments, as in a run; n of them leave an error of "
                                               "about 0.4/n^2 of its first frequency, and more of higher ones",
                                               how(lumped), more(lumped)));
}

/// Where a rotation that `dofs` keep moves a point of a body, seen from another one, in a direction that they leave out:
/// that motion is in no state.
void note_directions(const Model& model, Warnings& warnings) {
    const std::bitset<6>& kept = model.modes.directions;
    std::vector<std::vector<Eigen::Vector3d>> points(model.bodies.size());  // of elements, then the centre of mass
    for (const Element& element : model.elements)
        for (const Attachment& end : element.ends)
            if (end.body >= 0) points[as_size(end.body)].push_back(position_at_start(model, end));
    for (size_t b = 0; b < points.size(); ++b) {
        const Body& body = model.bodies[b];
        points[b].push_back(body.position + body.rotation * body.center_of_mass);
        const double radius = std::sqrt(body.inertia.trace() / body.mass);  // of gyration: of the body's size
        for (size_t i = 0; i < 9; ++i) {
            const size_t rotation = i / 3, direction = i % 3;
            if (!kept[3 + rotation] || kept[direction] || rotation == direction) continue;
            const auto lever = as_row(3 - rotation - direction);
            const auto differs = [&](const Eigen::Vector3d& p) {
                return std::abs((p - points[b][0])(lever)) > 1e-9 * std::max(p.norm(), radius);
            };
            if (std::ranges::none_of(points[b], differs)) continue;
            warnings.note("dofs-lever",
                          fmt::format("dofs keep {0} and leave out {1}, in which {0} moves points of body \"{2}\" beside "
                                      "each other: elements do not feel that, and its inertia counts about the point that "
                                      "an element holds first. Keep {1} too, and hold the body by an elastic_hinge if it "
                                      "cannot move there",
                                      kDirections[3 + rotation], kDirections[direction], body.name));
            return;
        }
    }
}

/// Whether springs have forces at the start although nothing loads the machine, or a run starts at its equilibrium.
bool is_strained(const Model& model, const ModalMachine& machine) {
    if (!model.modes.directions.all()) return false;
    for (size_t e = 0; e < model.elements.size(); ++e)
        if (machine.force_at_start(e) != 0) return true;
    return model.simulation.starts_at_rest;
}

}  // namespace

void note_path_end(const RestState& rest, bool has_potential, const std::string& place, Warnings& warnings) {
    if (!rest.has_path)
        warnings.note(
            "load-path-unknown",
            fmt::format("{}from where the machine rests without loads it could not be followed as they grow: this is "
                        "one equilibrium under them, and there may be others",
                        place));
    if (!rest.path_ends_at) return;
    const std::string share = fmt::format("{:.4g} of them", *rest.path_ends_at),
                      what = has_potential ? fmt::format(
                                                 "the machine becomes unstable at {}, or before, and moves on to another "
                                                 "equilibrium",
                                                 share)
                                           : fmt::format(
                                                 "the machine was followed up to {}, where motions begin to grow with "
                                                 "the symmetric part of the stiffness of loads. A load has no "
                                                 "potential, and it is not decided whether the machine moves on there",
                                                 share);
    warnings.note(
        "load-path-ends",
        fmt::format("{}as the loads grow from zero {}; this is one equilibrium under the full loads, and there may be "
                    "others",
                    place, what));
}

void note_velocities(const Model& model, const char* code, const char* what, Warnings& warnings) {
    std::string first;
    size_t count = 0;
    for (const Body& body : model.bodies)
        if (!body.angular_velocity.isZero(0) && ++count == 1)
            first =
                fmt::format("body {} turns at {:.6g} rad/s at the start", quote(body.name), body.angular_velocity.norm());
    for (const Node& node : model.nodes)
        if (node.moves && !(node.velocity.isZero(0) && node.angular_velocity.isZero(0)) && ++count == 1)
            first = fmt::format("node {} moves at the start", quote(node.name));
    if (count == 0) return;
    warnings.note(code, fmt::format("{}{}: {}; a run has them", first,
                                    count > 1 ? fmt::format(", and {} more", count - 1) : "", what));
}

void warn_unbalanced(const RestState& rest, const std::string& place, Warnings& warnings) {
    constexpr double kShown = 1e-6;
    if (rest.unbalanced() <= kShown) return;
    warnings.add(
        "unbalanced",
        fmt::format("{}at rest the forces balance to {:.2g} N only, and the largest is {:.4g} N. Rounding of places "
                    "makes such forces in the stiffest parts. Forces, and what follows from them, are known no "
                    "better. Larger loads help, or rigid parts in place of the stiffest",
                    place, rest.residual, rest.force));
}

void warn_nonconservative(const Model& model, const ModalMachine& machine, Warnings& warnings) {
    constexpr const char* kOfSymmetricPart =
        "only the symmetric part of its stiffness counts. Frequencies and the number of motions that grow are those of that "
        "part: they do not decide whether the machine is stable (it may flutter). A run shows it";
    for (const size_t i : machine.nonconservative()) {
        const Load& load = model.loads[i];
        if (load.turns)
            warnings.add("follower-load",
                         fmt::format("{}: this load turns with its part of the machine and has no potential: {}", load.place,
                                     kOfSymmetricPart));
        else
            warnings.note("moment-load",
                          fmt::format("{}: this moment keeps its direction, its point can turn about other axes, and it has "
                                      "no potential there: {}",
                                      load.place, kOfSymmetricPart));
    }
}

std::string undecided(const std::string& what_grows) {
    return fmt::format(
        "it is not decided whether the equilibrium is stable: {} with the symmetric part of the stiffness of "
        "loads, but a load has no potential. A run shows what grows",
        what_grows);
}

void note_damping(const Model& model, Warnings& warnings) {
    const DampingSettings& damping = model.damping;
    if (!damping.ratios.empty() && !damping.is_of_all)
        warnings.note("modal-damping",
                      fmt::format("{}: modal damping acts on the first {} vibrations only; those above have that of the "
                                  "elements",
                                  damping.place, damping.ratios.size()));
}

void note_forces_of_damping(const Model& model, Warnings& warnings) {
    const DampingSettings& damping = model.damping;
    if (damping.ratios.empty() && damping.mass_rate == 0) return;
    warnings.note(
        "damping-in-no-element",
        fmt::format("{}: the forces of this damping act on the masses and are in no element: what elements carry to "
                    "the ground lacks them",
                    damping.place));
}

void warn_preload(const Model& model, Warnings& warnings) {
    if (!model.simulation.gravity.isZero(0))
        warnings.note("gravity-not-in-modes",
                      "the frequencies are those without gravity: its stiffness, as of a pendulum, is not in them");
    std::string place;
    size_t others = 0;
    for (const Load& load : model.loads) {
        const double duration = model.simulation.duration;
        if (!is_lasting(load.signal, duration) && !(load.signal_at_to && is_lasting(*load.signal_at_to, duration))) continue;
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

ModalMachine make_machine(const Model& model, const Plugins& plugins, Warnings& warnings) {
    const auto about_start = [&](ModalMachine machine) {
        if (!model.modes.directions.all()) note_directions(model, warnings);
        warn_preload(model, warnings);
        note_forces(model, machine, warnings);
        return machine;
    };
    if (model.modes.about == About::start) return about_start(ModalMachine(model, plugins));
    if (model.modes.about == About::automatic && !is_loaded(model))
        if (ModalMachine machine(model, plugins); !is_strained(model, machine)) return about_start(std::move(machine));
    try {
        Model resting = model;
        if (resting.simulation.step == 0) resting.simulation.step = kShortestStep;  // networks want one, whichever
        resting.simulation.coupling = Coupling::implicit;
        ModalMachine machine(model, resting, plugins);
        note_rest(model, machine, plugins.catalogue(), warnings);
        return machine;
    } catch (const Error& error) {
        if (model.modes.about == About::equilibrium || StopSignals::requested()) throw;
        warnings.add(
            "no-equilibrium",
            fmt::format("the frequencies are not about an equilibrium, but about the machine as the file places it: "
                        "{}",
                        error.what()));
        return about_start(ModalMachine(model, plugins));
    }
}

ModalSession::ModalSession(const Request& request, const Plugins& plugins, Warnings& warnings)
    : model(read(request, plugins, warnings)), machine(make_machine(model, plugins, warnings)) {}

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
