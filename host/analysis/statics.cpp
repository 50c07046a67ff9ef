// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/statics.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "analysis/critical_loads.h"
#include "analysis/free_motions.h"
#include "analysis/law_limits.h"
#include "analysis/line_loads.h"
#include "analysis/modal_session.h"
#include "analysis/stop_signals.h"
#include "analysis/summary.h"
#include "coupling/modal_description.h"
#include "coupling/network_description.h"
#include "loader/modal_instance.h"
#include "loader/plugins.h"
#include "model/index.h"
#include "model/read_case.h"
#include "model/read_simulation.h"
#include "model/units.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/csv_table.h"
#include "record/results_folder.h"
#include "record/tell.h"
#include "step/simulation.h"
#include "world/rotation_step.h"

namespace dttmm::host {

namespace {

constexpr double kDefaultStep = 1e-3;  // the row at rest is the same with any

/// Of a rotation from the assembled machine: beyond it other equilibria are likely [rad].
constexpr double kFar = 0.3;

class Held : public Signal::Shape {
public:
    explicit Held(double value) : value_(value) {}
    double value(double) const override { return value_; }

private:
    double value_;
};

double instant_of(const Request& request) {
    if (request.statics.at.empty()) return 0;
    try {
        const double time = parse_quantity(request.statics.at, "s");
        if (std::isfinite(time) && time >= 0) return time;
        throw Error(ExitCode::usage, "must be zero or more");
    } catch (const Error& error) {
        throw Error(ExitCode::usage, fmt::format("--at {}: {}", quote(request.statics.at), error.what()));
    }
}

/// A signal that is not the same all the time.
bool varies(const Signal& signal, double duration) {
    constexpr int kSamples = 1000;
    const double first = signal.value(0);
    for (int i = 1; i <= kSamples; ++i)
        if (signal.value(duration * i / kSamples) != first) return true;
    return false;
}

Model read(const Request& request, const Plugins& plugins, double time) {
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::statics;
    overrides.instant = time;
    return read_model(request.model, plugins.catalogue(), overrides);
}

/// A word on the loads and the motions of supports that vary: which value counts.
void note_varying(const Model& model, double time, Warnings& warnings) {
    const double duration = model.simulation.duration > 0 ? model.simulation.duration : 1;
    std::string first;
    size_t count = 0;
    for (const Load& load : model.loads) {
        if (!varies(load.signal, duration) && !varies(load.at_to(), duration)) continue;
        if (++count == 1)
            first = fmt::format("{}: this load varies in time; it counts with {:.6g} {}{}, its value at t = {:g} s",
                                load.place, load.signal.value(time), load.unit(),
                                load.signal_at_to ? fmt::format(" to {:.6g} {}", load.at_to().value(time), load.unit()) : "",
                                time);
    }
    for (const Node& node : model.nodes)
        for (size_t d = 0; d < node.motion.size(); ++d)
            if (node.motion[d] && varies(*node.motion[d], duration) && ++count == 1)
                first = fmt::format("{}: this motion varies in time; it counts with {:.6g} {}, its value at t = {:g} s",
                                    node.motion_place, node.motion[d]->value(time), d < 3 ? "m" : "rad", time);
    if (count > 0)
        warnings.note("load-varies", first + (count > 1 ? fmt::format("; {} more vary too", count - 1) : "") +
                                         ". Option --at takes another instant");
}

/// A word on what vibrates for good: nothing of it is in an equilibrium.
void note_vibrations(const Model& model, Warnings& warnings) {
    std::string first;
    size_t count = 0;
    for (const Load& load : model.loads)
        if ((load.vibration || load.vibration_at_to) && ++count == 1) first = load.place + ": this load vibrates";
    for (const Node& node : model.nodes)
        if (std::ranges::any_of(node.vibrations, [](const auto& signal) { return signal.has_value(); }) && ++count == 1)
            first = node.motion_place + ": this motion vibrates";
    if (count > 0)
        warnings.note("vibration-not-in-static",
                      fmt::format("{}{}: it counts with 0, its mean, at every instant of --at; `dttmm response` has it",
                                  first, count > 1 ? fmt::format(", and {} more", count - 1) : ""));
}

/// Makes loads and motions lasting ones, as they are at an instant, and the model one that is at rest.
void hold(Model& model, double time) {
    const auto held = [&](const Signal& signal) { return Signal(std::make_shared<Held>(signal.value(time))); };
    for (Load& load : model.loads) {
        load.signal = held(load.signal);
        if (load.signal_at_to) load.signal_at_to = held(*load.signal_at_to);
    }
    for (Node& node : model.nodes)
        for (auto& signal : node.motion)
            if (signal) signal = held(*signal);
    for (Joint& joint : model.joints)
        if (joint.drive) joint.drive = held(*joint.drive);
    model.simulation.step = model.simulation.step > 0 ? model.simulation.step : kDefaultStep;
    model.simulation.coupling = Coupling::implicit;
    model.simulation.spectral_radius = 1;
    model.simulation.starts_at_rest = true;
    for (Body& body : model.bodies) body.velocity = body.angular_velocity = Eigen::Vector3d::Zero();
    for (Node& node : model.nodes) node.velocity = node.angular_velocity = Eigen::Vector3d::Zero();
}

/// Vectors of the row, "plate.position", with the owner and what it is.
struct Vectors {
    struct Vector {
        double numbers[3] = {0, 0, 0};
    };
    std::map<std::string, Vector> all;
    std::map<std::string, double> others;  ///< what is no part of a vector: "wire.force", "plate.quaternion.w"

    Vectors(const std::vector<Channel>& channels, std::span<const double> row) {
        for (size_t c = 0; c < channels.size(); ++c) {
            const std::string& axis = channels[c].axis();
            if (axis == "x" || axis == "y" || axis == "z")
                all[channels[c].without_axis()].numbers[axis[0] - 'x'] = row[c];
            else
                others[channels[c].name()] = row[c];
        }
    }
    const Vector* find(const std::string& name) const {
        const auto found = all.find(name);
        return found == all.end() ? nullptr : &found->second;
    }
};

std::string cell(double value, double scale) {
    return fmt::format("{:>12.5g}", std::abs(value) < 1e-12 * scale ? 0 : value);
}

void print_row(const std::string& name, size_t width, const char* what, const Vectors::Vector& v, double scale) {
    fmt::print("{:<{}}  {:<14}{}{}{}\n", name, width, what, cell(v.numbers[0], scale), cell(v.numbers[1], scale),
               cell(v.numbers[2], scale));
}

/// Rotation vector of a body from the start, world axes [rad]; none where its quaternion is not among the channels.
std::optional<Vectors::Vector> turn_of(const Body& body, const Vectors& vectors) {
    const Vectors::Vector* q = vectors.find(body.name + ".quaternion");
    const auto w = vectors.others.find(body.name + ".quaternion.w");
    if (!q || w == vectors.others.end()) return std::nullopt;
    const Eigen::Quaterniond now(w->second, q->numbers[0], q->numbers[1], q->numbers[2]);
    const Eigen::AngleAxisd turn(now.toRotationMatrix() * body.rotation.transpose());
    Vectors::Vector vector;
    for (int i = 0; i < 3; ++i) vector.numbers[i] = turn.angle() * turn.axis()(i);
    return vector;
}

void print_table(const Model& model, const Vectors& vectors) {
    size_t width = 4;
    const auto widen = [&](const auto& list) {
        for (const auto& one : list) width = std::max(width, one.name.size());
    };
    widen(model.bodies);
    widen(model.nodes);
    widen(model.elements);
    widen(model.joints);
    fmt::print("{:<{}}  {:<14}{:>12}{:>12}{:>12}\n", "", width, "", "x", "y", "z");
    double far = 0, strong = 0;
    for (const auto& [name, v] : vectors.all)
        for (const double number : v.numbers) {
            if (name.ends_with(".position")) far = std::max(far, std::abs(number));
            if (name.ends_with(".force") || name.ends_with(".reaction")) strong = std::max(strong, std::abs(number));
        }
    for (const auto& [name, value] : vectors.others)
        if (name.ends_with(".force")) strong = std::max(strong, std::abs(value));
    const auto print_place = [&](const std::string& name, const Eigen::Vector3d& start) {
        const Vectors::Vector* position = vectors.find(name + ".position");
        if (!position) return;
        Vectors::Vector moved = *position;
        for (int i = 0; i < 3; ++i) moved.numbers[i] -= start(i);
        print_row(name, width, "moved [m]", moved, far);
        if (const Vectors::Vector* turn = vectors.find(name + ".rotation")) print_row("", width, "turned [rad]", *turn, 1);
    };
    for (const Body& body : model.bodies) {
        print_place(body.name, body.position);
        if (const auto turn = turn_of(body, vectors)) print_row("", width, "turned [rad]", *turn, 1);
    }
    for (const Node& node : model.nodes) print_place(node.name, node.position);
    const auto print_force = [&](const std::string& name) {
        if (const Vectors::Vector* force = vectors.find(name + ".force"))
            print_row(name, width, "force [N]", *force, strong);
        if (const auto along = vectors.others.find(name + ".force"); along != vectors.others.end())
            fmt::print("{:<{}}  {:<14}{}\n", name, width, "along it [N]", cell(along->second, strong));
        if (const Vectors::Vector* moment = vectors.find(name + ".moment"))
            print_row("", width, "moment [N*m]", *moment, strong);
    };
    for (const Node& node : model.nodes) {
        if (const Vectors::Vector* force = vectors.find(node.name + ".reaction"))
            print_row(node.name, width, "reaction [N]", *force, strong);
        if (const Vectors::Vector* moment = vectors.find(node.name + ".reaction_moment"))
            print_row(node.name, width, "moment [N*m]", *moment, strong);
    }
    for (const Element& element : model.elements) print_force(element.name);
    for (const Joint& joint : model.joints) print_force(joint.name);
}

void print_buckling(const CriticalLoads& loads, int wanted) {
    const std::vector<CriticalLoad>& factors = loads.factors;
    const bool are_all = loads.why_not_beyond.empty();
    const std::string up_to = are_all ? "1e9" : fmt::format("{:.3g}; beyond, {}", loads.up_to, loads.why_not_beyond);
    if (factors.empty()) {
        fmt::print("no critical load factor up to {}\n", up_to);
        return;
    }
    std::string list;
    for (const CriticalLoad& load : factors)
        list += fmt::format("{}{:.8g}{}", list.empty() ? "" : ", ", load.factor,
                            load.factor > 0    ? ""
                            : load.uncertainty ? " (unstable under any load)"
                                               : " (unstable under any load, or rounding hides it)");
    fmt::print("critical load {}: {}{}\n", factors.size() == 1 ? "factor" : "factors", list,
               as_int(factors.size()) >= wanted ? ""
               : are_all                        ? " (there are no more)"
                                                : fmt::format(" (there are no more up to {})", up_to));
}

/// Where there are fewer segments, a half and a third of them are as coarse and may tell nothing.
constexpr double kFewSegments = 4;

/// Changes the segments of the elements that have few, or of the others; false: there are none.
bool change_segments(Model& model, const ElementCatalogue& catalogue, bool few, double times) {
    bool changes = false;
    for (Element& element : model.elements)
        if (const auto at = segments_at(*catalogue.types[as_size(element.type)]);
            at && (element.values[*at] < kFewSegments) == few) {
            double& segments = element.values.change()[*at];
            segments = std::max(std::floor(times * segments + 0.5), 1.0);
            changes = true;
        }
    return changes;
}

/// A machine at rest under the loads of one case, or under all.
struct Found {
    std::string load_case;    ///< empty: the model has none
    std::vector<double> row;  ///< by the channels, without the time
    RestState rest;
    std::optional<int> growing;                  ///< motions; none: they cannot be counted
    std::string why_not_counted;                 ///< why they cannot
    std::vector<std::string> without_potential;  ///< places of loads: growing is then that of a symmetric part
    std::optional<FreeMotions> free;             ///< none: not known
    std::string why_free_unknown;                ///< empty: the plugin does not tell
    CriticalLoads critical;
    std::vector<Limit> limits;
    std::map<size_t, LineLoads> line_loads;  ///< by element
};

/// A load case without an equilibrium.
struct Failure {
    std::string load_case, reason;
};

/// The equilibria found; the channels of their rows.
struct Results {
    std::vector<Channel> channels;
    std::vector<Found> cases;
    std::vector<Failure> failures;
};

/// A critical load factor is where a symmetric stiffness is singular.
void refuse_nonconservative(const Model& model, const ModalMachine& machine) {
    const std::vector<size_t> loads = machine.nonconservative();
    if (loads.empty()) return;
    const Load& load = model.loads[loads.front()];
    throw Error(ExitCode::model_invalid,
                fmt::format("{}: this load {} and has no potential: --buckling finds where the symmetric part of the "
                            "stiffness is singular, which is no critical load then; the machine may begin to flutter far "
                            "below it. `dttmm run` with a load that grows slowly shows where motions grow",
                            load.place,
                            load.turns ? "turns with its part of the machine"
                                       : "is a moment that keeps its direction where its point can turn about other axes"));
}

/// A critical load is that of the machine whose forces and turns grow in proportion to its loads.
void note_beyond_limit(const Found& found, const std::vector<Channel>& channels, Warnings& warnings) {
    const Limit* worst = nullptr;
    for (const Limit& limit : found.limits)
        if (!worst || limit.most > worst->most) worst = &limit;
    for (const CriticalLoad& load : found.critical.factors)
        if (worst && worst->most <= 1 && worst->most * std::abs(load.factor) > 1)
            return warnings.note(
                "critical-load-beyond-limit",
                fmt::format(
                    "at {:.4g} times the loads \"{}\" would be about {:.2g}: beyond 1 the law of element \"{}\" does "
                    "not hold. A critical load so far from the loads is a guess; look at it under larger loads, or "
                    "with more segments",
                    load.factor, channels[worst->channel + 1].name(), worst->most * std::abs(load.factor), worst->element));
}

/// What moves freely where the forces have bent the machine does so under more of them, too, for they bend it more; but its
/// places stay those at rest. A round bar between ball joints that spins about its bent axis has a factor of 1 so.
void note_free_at_one(const Found& found, Warnings& warnings) {
    constexpr double kNear = 0.1;  // of it: by 0.4/n² the factor of a bar of n segments was off, by 0.09 that of two
    if (!found.free || found.free->count == 0) return;
    for (const CriticalLoad& load : found.critical.factors)
        if (std::abs(load.factor - 1) < kNear)
            return warnings.note("critical-load-of-free-motion",
                                 fmt::format("the critical load factor {:.6g} may be that of a motion that nothing holds at "
                                             "rest, as of a bent shaft that spins: such a motion never grows",
                                             load.factor));
}

/// What nothing holds in the machine as it is assembled, behind a reason why it does not come to rest.
std::string free_at_start(const Model& model, const Plugins& plugins, std::string_view reason) {
    try {
        ModalMachine machine(model, plugins);
        const std::optional<FreeMotions> free = find_free(model, machine);
        if (!free || free->count == 0) return "";
        return fmt::format("{} In the assembled machine {}", reason.ends_with('?') ? "" : ".", free->text());
    } catch (const Error&) {
        return "";  // the reason stands without it
    }
}

std::unique_ptr<Simulation> bring_to_rest(const Model& model, const Plugins& plugins) {
    try {
        return std::make_unique<Simulation>(model, plugins, Simulation::For::rest);
    } catch (const Error& error) {
        if (error.code() != ExitCode::numerical_failure) throw;
        throw Error(error.code(), error.what() + free_at_start(model, plugins, error.what()));
    }
}

/// By how much so many times the segments change each factor, the most of several, as share of it; none: not known.
std::vector<std::optional<double>> changes_by_segments(const Model& model, const Plugins& plugins,
                                                       const std::vector<CriticalLoad>& factors, bool few,
                                                       std::initializer_list<double> all_times) {
    std::vector<std::optional<double>> changes(factors.size());
    for (const double times : all_times) try {
            Model other = model;
            if (!change_segments(other, plugins.catalogue(), few, times))
                return std::vector(factors.size(), std::optional(0.0));
            const std::unique_ptr<Simulation> resting = bring_to_rest(other, plugins);
            ModalDescription description(other, plugins, {&resting->networks(), &resting->equilibrium(), *resting->rest()});
            const CriticalLoads found = find_critical_loads(std::move(description), as_int(factors.size()));
            for (size_t k = 0; k < std::min(factors.size(), found.factors.size()); ++k) {
                if (factors[k].factor == 0) continue;
                const double change = std::abs(found.factors[k].factor / factors[k].factor - 1),
                             left = times > 1 ? change / (1 - 1 / times) : change;
                changes[k] = std::max(changes[k].value_or(0), left);
            }
        } catch (const Error& error) {
            if (error.code() == ExitCode::plugin_failure || error.code() == ExitCode::internal_error) throw;
        }
    return changes;
}

/// Moments and torsion along beams count by their segments, and the enclosure of a factor does not know it. The error falls
/// with the square of their number, of few at least as their number. Two numbers may agree by chance: hence two.
void find_segment_errors(const Model& model, const Plugins& plugins, std::vector<CriticalLoad>& factors) {
    const bool are_there = std::ranges::any_of(model.elements, [&](const Element& element) {
        return segments_at(*plugins.catalogue().types[as_size(element.type)]).has_value();
    });
    if (factors.empty() || !are_there) return;
    const auto of_many = changes_by_segments(model, plugins, factors, false, {1. / 2, 1. / 3}),
               of_few = changes_by_segments(model, plugins, factors, true, {1 / kFewSegments, 4});
    for (size_t k = 0; k < factors.size(); ++k)
        if (of_many[k] && of_few[k]) factors[k].segment_error = *of_many[k] + *of_few[k];
}

/// Counts motions that grow, names those that nothing holds, and finds load factors where they are asked for.
void look_at_stability(const Request& request, const Model& model, const Plugins& plugins, Simulation& resting, Found& found,
                       Warnings& warnings) {
    const auto describe = [&] {
        return ModalDescription(model, plugins, {&resting.networks(), &resting.equilibrium(), *resting.rest()});
    };
    std::optional<ModalMachine> machine;
    try {
        machine.emplace(model, describe());
        if (request.statics.buckling > 0) refuse_nonconservative(model, *machine);
        warn_nonconservative(model, *machine, warnings);
        for (const size_t i : machine->nonconservative()) found.without_potential.push_back(model.loads[i].place);
        try {
            found.free = find_free(model, *machine);
        } catch (const Error& error) {
            found.why_free_unknown = error.what();
        }
    } catch (const Error& error) {
        if (request.statics.buckling > 0) throw;  // asked for; otherwise the equilibrium stands without it
        found.why_not_counted = error.what();
        return;
    }
    try {
        found.growing = as_int(machine->count_growing());
    } catch (const Error& error) {
        if (error.code() != ExitCode::numerical_failure && request.statics.buckling > 0) throw;
        found.why_not_counted = error.what();
        found.why_free_unknown.clear();  // for the same reason
    }
    if (request.statics.buckling > 0) found.critical = find_critical_loads(describe(), request.statics.buckling);
    for (CriticalLoad& load : found.critical.factors)
        if (load.uncertainty) *load.uncertainty += found.rest.unbalanced();
    find_segment_errors(model, plugins, found.critical.factors);
    note_free_at_one(found, warnings);
    note_beyond_limit(found, resting.channels(), warnings);
}

/// At rest there are no velocities and accelerations. Of a node with next to no mass a run records rounding of its forces
/// over its mass: up to 1e12 m/s^2 have been seen.
void forget_motion(const std::vector<Channel>& channels, std::vector<double>& row) {
    constexpr std::string_view kUnits[] = {"m/s", "rad/s", "m/s^2", "rad/s^2"};
    for (size_t c = 0; c < channels.size(); ++c)
        if (std::ranges::find(kUnits, std::string_view(channels[c].unit())) != std::end(kUnits)) row[c] = 0;
}

/// load_case: one of the model; null: all loads act.
Found find_one(const Request& request, const Model& model, const Plugins& plugins, double time, const LoadCase* load_case,
               Results& results, Warnings& warnings) {
    Model held = model;
    Found found;
    found.load_case = model.load_case;
    if (load_case) {
        apply_case(held, *load_case);
        found.load_case = load_case->name;
    }
    hold(held, time);
    found.line_loads = find_line_loads(held, plugins.catalogue(), time);
    const std::unique_ptr<Simulation> resting = bring_to_rest(held, plugins);
    Simulation& simulation = *resting;
    simulation.record_to([&](std::span<const double> numbers) {
        if (found.row.empty()) found.row.assign(numbers.begin() + 1, numbers.end());
    });
    simulation.observe_rest();
    found.rest = *simulation.rest();
    if (results.channels.empty()) results.channels.assign(simulation.channels().begin() + 1, simulation.channels().end());
    forget_motion(results.channels, found.row);
    found.limits = simulation.limits();
    for (Limit& limit : found.limits) --limit.channel;  // as without the time
    look_at_stability(request, held, plugins, simulation, found, warnings);
    return found;
}

Results find_all(const Request& request, const Model& model, const Plugins& plugins, double time, Warnings& warnings) {
    Results results;
    if (!model.load_case.empty() || model.cases.empty()) {
        results.cases.push_back(find_one(request, model, plugins, time, nullptr, results, warnings));
        return results;
    }
    for (const LoadCase& load_case : model.cases) try {
            results.cases.push_back(find_one(request, model, plugins, time, &load_case, results, warnings));
        } catch (const Error& error) {
            const std::string reason = fmt::format("case {}: {}", quote(load_case.name), error.what());
            if (error.code() != ExitCode::numerical_failure) throw Error(error.code(), reason);
            results.failures.push_back({load_case.name, reason});
        }
    if (results.cases.empty()) throw Error(ExitCode::numerical_failure, results.failures.front().reason);
    return results;
}

/// static.csv: a row per case; a column for its name, if the model has cases.
std::string rows_of(const Results& results) {
    const bool are_named = !results.cases.front().load_case.empty();
    std::vector<Column> columns;
    if (are_named) columns.push_back({"case", ""});
    CsvTable table(columns, results.channels);
    for (const Found& found : results.cases) {
        if (are_named) table.add(found.load_case);
        table.add_all(found.row);
        table.end_row();
    }
    return table.text();
}

/// Where the sections of a beam or rod stand among the channels: force and moment of each, then its stress if it is known.
/// Before them the motion of the `to` end against the `from` end, in its axes.
struct Sections {
    size_t first = 0, count = 0, stride = 6, deflection = 0, rotation = 0;
};

/// Of the elements that have sections.
using SectionsOf = std::unordered_map<std::string_view, Sections>;
SectionsOf find_sections(const std::vector<Channel>& channels) {
    SectionsOf all;
    size_t deflection = 0, rotation = 0;  // of the last element
    for (size_t c = 0; c < channels.size(); ++c) {
        if (channels[c].of() != Channel::Of::element) continue;
        const std::string& quantity = channels[c].quantity();
        if (quantity == "deflection" && channels[c].axis() == "x") deflection = c;
        if (quantity == "rotation" && channels[c].axis() == "x") rotation = c;
        if (quantity != "section0.force") continue;
        const std::string& owner = channels[c].owner();
        Sections own{c, 0, 6, deflection, rotation};
        if (c + 6 < channels.size() && channels[c + 6].unit() == "Pa") own.stride = 7;
        for (; c < channels.size() && channels[c].owner() == owner && !channels[c].by_default(); c += own.stride)
            ++own.count;
        all[owner] = own;
        --c;
    }
    return all;
}

/// members.csv: what every section of beams and rods carries, a row per case, element and section.
std::string members_of(const Results& results, const Model& model, const SectionsOf& all) {
    const bool are_named = !results.cases.front().load_case.empty();
    std::vector<Column> columns;
    if (are_named) columns.push_back({"case", ""});
    for (const auto& [name, unit] : {std::pair("element", ""), std::pair("position", "m"), std::pair("N", "N"),
                                     std::pair("Vy", "N"), std::pair("Vz", "N"), std::pair("T", "N*m"),
                                     std::pair("My", "N*m"), std::pair("Mz", "N*m"), std::pair("stress", "Pa")})
        columns.push_back({name, unit});
    CsvTable table(columns);
    for (const Found& found : results.cases)
        for (const Element& element : model.elements) {
            const auto own = all.find(element.name);
            if (own == all.end()) continue;
            const size_t first = own->second.first, count = own->second.count, stride = own->second.stride;
            const double length = way_along(model, element).norm();
            for (size_t k = 0; k < count; ++k) {
                if (are_named) table.add(found.load_case);
                table.add(element.name).add(length * static_cast<double>(k) / static_cast<double>(count - 1));
                for (size_t i = 0; i < 7; ++i)
                    table.add(i < stride ? found.row[first + k * stride + i] : std::numeric_limits<double>::quiet_NaN());
                table.end_row();
            }
        }
    return all.empty() ? std::string() : table.text();
}

/// What loads along an element of that length and its weight do across it, by the forces at both its ends [N].
double load_across(const std::vector<double>& row, const Sections& sections, double length) {
    const auto vector_at = [&](size_t c) { return Eigen::Vector3d(row[c], row[c + 1], row[c + 2]); };
    const Eigen::Vector3d to = vector_at(sections.first + (sections.count - 1) * sections.stride),
                          turned = RotationStep(vector_at(sections.rotation)).apply(to),
                          way = (vector_at(sections.deflection) + length * Eigen::Vector3d::UnitX()).normalized();
    return (turned - vector_at(sections.first)).cross(way).norm();
}

/// Loads along a beam act at the middles of its segments, of length h: moments err by up to q h²/24, q where it is largest.
void note_line_loads(const Results& results, const Model& model, const SectionsOf& all, const ElementCatalogue& catalogue,
                     Warnings& warnings) {
    constexpr double kShown = 1e-3;  // of the largest along the element
    struct Worst {
        double error = 0, largest = 0, segments = 0;
        const Element* element = nullptr;
        const Found* found = nullptr;
        size_t count = 0;               ///< elements
        const Element* last = nullptr;  ///< of them

        /// Case by case of one element after the other.
        void take(const Worst& other) {
            if (other.error <= kShown * other.largest) return;
            const size_t number = count + (last != other.element);
            if (other.error > error) *this = other;
            count = number;
            last = other.element;
        }
        std::string text(const char* what, const char* unit, const char* where) const {
            return fmt::format(
                "{}element {}: loads along it act at {}, and {} err by up to about {:.2g} {}, {} its largest, where {}{}. "
                "With twice as many it is a fourth",
                found->load_case.empty() ? "" : fmt::format("case {}: ", quote(found->load_case)), quote(element->name),
                segments > 1 ? fmt::format("the middles of its {:g} segments", segments) : "the middle of its only segment",
                what, error, unit, error < largest ? fmt::format("{:.1g} of", error / largest) : "more than", where,
                count > 1 ? fmt::format(", and in {} more less", count - 1) : "");
        }
    } moments, forces;
    for (size_t e = 0; e < model.elements.size(); ++e) {
        const Element& element = model.elements[e];
        const auto value = segments_at(*catalogue.types[as_size(element.type)]);
        const auto own = all.find(element.name);
        if (!value || own == all.end() || own->second.count < 2) continue;
        const double segments = element.values[*value];
        const Sections& sections = own->second;
        const double length = way_along(model, element).norm();
        for (const Found& found : results.cases) {
            const auto at = [&](size_t section, size_t i) {
                return found.row[sections.first + section * sections.stride + i];
            };
            double moment = 0, force = 0;
            for (size_t k = 0; k < sections.count; ++k) {
                moment = std::max(moment, std::hypot(at(k, 4), at(k, 5)));
                force = std::max(force, std::abs(at(k, 0)));
            }
            const auto loads = found.line_loads.find(e);
            const LineLoads along = loads == found.line_loads.end() ? LineLoads{} : loads->second;
            const double carried = load_across(found.row, sections, length),
                         weight = carried > found.rest.residual ? std::max(carried / length - along.mean, 0.0) : 0,
                         error = (along.across + weight) * length * length / (24 * segments * segments);
            moments.take({error, moment, segments, &element, &found});
            if (along.rise > 0) forces.take({along.error_of_force(), force, segments, &element, &found});
        }
    }
    if (moments.count > 0)
        warnings.note("line-load-segments", moments.text("moments", "N*m", "it is not held statically determinately"));
    if (forces.count > 0)
        warnings.note("line-load-segments", forces.text("axial forces", "N", "both its ends are held along it"));
}

/// A section that is given by stiffnesses has no outermost fibre.
void note_no_stress(const Model& model, const SectionsOf& all, Warnings& warnings) {
    std::vector<std::string> without;
    for (const Element& element : model.elements)
        if (const auto own = all.find(element.name); own != all.end() && own->second.stride == 6)
            without.push_back(element.name);
    if (!without.empty())
        warnings.note("no-stress",
                      fmt::format("element {}: its section is given by stiffnesses, which have no outermost fibre: "
                                  "members.csv has no stress of it{}; give the shape of the section for one",
                                  quote(without.front()),
                                  without.size() > 1 ? fmt::format(", nor of {} more", without.size() - 1) : ""));
}

void write_summary(JsonWriter& json, const Results& results, const Model& model, const Request& request, double time,
                   const Warnings& warnings, const Plugins& plugins) {
    const auto describe = [&](const Found& found, const auto& member) {
        member("iterations", found.rest.iterations);
        member("load_steps", found.rest.load_steps);
        if (found.rest.path_ends_at) member("load_path_ends_at", *found.rest.path_ends_at);
        member("largest_force_n", found.rest.force);
        member("largest_unbalanced_force_n", found.rest.residual);
        if (!found.without_potential.empty()) {
            member("growing_motions", Json());
            member("loads_without_potential", found.without_potential);
            if (found.growing) member("growing_motions_of_symmetric_part", *found.growing);
        } else if (found.growing) {
            member("growing_motions", *found.growing);
        }
        const bool are_free = found.free && !found.free->may_be_held();
        if (are_free) member("free_motions", found.free->count);
        if (are_free && !found.free->names.empty()) member("what_is_free", found.free->names);
        if (request.statics.buckling == 0) return;
        std::vector<double> factors;
        Json uncertainties = Json::array(), segment_errors = Json::array();
        const auto or_null = [](const std::optional<double>& share) { return share ? Json(*share) : Json(); };
        for (const CriticalLoad& load : found.critical.factors) {
            factors.push_back(load.factor);
            uncertainties.push_back(or_null(load.uncertainty));
            segment_errors.push_back(or_null(load.segment_error));
        }
        member("critical_load_factors", factors);
        member("critical_load_uncertainties", uncertainties);
        member("critical_load_segment_errors", segment_errors);
        if (as_int(factors.size()) < request.statics.buckling)
            member("critical_loads_looked_for_up_to", found.critical.up_to);
    };
    json.member("format", "dttmm-static/1");
    json.member("warnings", describe_warnings(warnings));
    json.member("title", model.title);
    json.member("status", results.failures.empty() ? "completed" : "cases_failed");
    json.member("loads_at_s", time);
    if (results.cases.front().load_case.empty())
        describe(results.cases.front(), [&](const char* name, const auto& value) { json.member(name, value); });
    else
        json.object("cases", [&] {
            for (const Found& found : results.cases)
                json.object(found.load_case, [&] {
                    describe(found, [&](const char* name, const auto& value) { json.member(name, value); });
                });
            for (const Failure& failure : results.failures)
                json.object(failure.load_case, [&] {
                    json.member("status", "failed");
                    json.member("reason", failure.reason);
                });
        });
    json.member("command_line", request.command_line);
    write_inputs(json, model, request);
    write_model(json, model, plugins.catalogue());
}

/// Says which critical load rounding may change most.
void warn_of_rounding(const std::vector<CriticalLoad>& factors, const std::string& place, Warnings& warnings) {
    constexpr double kShown = 1e-6,
                     kLarge = 0.1;  // loads are hardly known better than the one; the other makes them useless
    const auto of = [](const CriticalLoad& load) {
        return load.uncertainty.value_or(std::numeric_limits<double>::infinity());
    };
    const auto worst = std::ranges::max_element(factors, {}, of);
    if (worst == factors.end() || of(*worst) <= kShown) return;
    const std::string text =
        worst->uncertainty
            ? fmt::format(
                  "{}rounding of the largest stiffness may change the critical load factor {:.8g} by up to {:.2g} of it",
                  place, worst->factor, *worst->uncertainty)
        : worst->factor == 0
            ? fmt::format("{}a critical load factor is 0, or so small that rounding of the largest stiffness hides it",
                          place)
            : fmt::format(
                  "{}it is not known how much rounding of the largest stiffness changes the critical load factor {:.8g}",
                  place, worst->factor);
    if (of(*worst) > kLarge)
        warnings.add("critical-load-uncertain", text);
    else
        warnings.note("critical-load-uncertain", text);
}

/// Says which critical load the segments of beams change most.
void note_segments(const std::vector<CriticalLoad>& factors, const std::string& place, Warnings& warnings) {
    constexpr double kShown = 1e-6;
    const auto error = [](const CriticalLoad& load) { return load.segment_error.value_or(0); };
    const auto worst = std::ranges::max_element(factors, {}, error);
    if (worst == factors.end() || error(*worst) <= kShown) return;
    warnings.note(
        "critical-load-segments",
        fmt::format("{}the segments of its beams leave an error of less than about {:.1g} of the critical load factor "
                    "{:.6g}, as other numbers of them show; more of them come nearer",
                    place, error(*worst), worst->factor));
}

std::string growing_of(const Found& found) {
    return counted(as_size(found.growing.value_or(0)), "motion grows", "motions grow");
}

/// What an equilibrium tells against itself.
void warn_of(const Found& found, const Results& results, Warnings& warnings) {
    const std::string place = found.load_case.empty() ? "" : fmt::format("case {}: ", quote(found.load_case));
    if (found.rest.turn > kFar)
        warnings.note("moved-far", fmt::format("{}a part has turned by {:.3g} rad: there may be other equilibria; this is "
                                               "the one reached from the assembled machine",
                                               place, found.rest.turn));
    note_path_end(found.rest, found.without_potential.empty(), place, warnings);
    if (!found.rest.open.empty())
        warnings.add("joint-open", fmt::format("{}{} where the machine rests: joints do not quite agree with each other",
                                               place, found.rest.open));
    warn_unbalanced(found.rest, place, warnings);
    if (found.growing.value_or(0) > 0 && !found.without_potential.empty())
        warnings.add("stability-undecided", place + undecided(growing_of(found)));
    else if (found.growing.value_or(0) > 0)
        warnings.add("unstable-equilibrium",
                     fmt::format("{}the equilibrium is unstable: {} from it after the smallest disturbance; \"dttmm modes\" "
                                 "lists them with negative frequencies",
                                 place, growing_of(found)));
    if (found.free && found.free->count > 0)
        warnings.note(found.free->may_be_held() ? "free-motion-unknown" : "free-motion",
                      fmt::format("{}{}: small motions there meet {} force, so that there may be other equilibria nearby",
                                  place, found.free->text(), found.free->may_be_held() ? "little or no" : "no"));
    if (!found.why_free_unknown.empty())
        warnings.note("free-motion-unknown",
                      fmt::format("{}it is not known what nothing holds: {}", place, found.why_free_unknown));
    warn_of_rounding(found.critical.factors, place, warnings);
    note_segments(found.critical.factors, place, warnings);
    if (!found.why_not_counted.empty())
        warnings.note("stability-unknown",
                      fmt::format("{}it is not known whether the equilibrium is stable: {}", place, found.why_not_counted));
    warn_limits(found.limits, results.channels,
                found.load_case.empty() ? "at rest" : fmt::format("at rest in case {}", quote(found.load_case)), warnings);
}

/// Before what the last line says; empty: nothing grows.
std::string verdict_of(const Found& found) {
    if (found.growing.value_or(0) == 0) return "";
    if (found.without_potential.empty()) return fmt::format("unstable: {}; ", growing_of(found));
    return fmt::format("stability not decided, {} with the symmetric part of loads; ", growing_of(found));
}

void print_case(const Request& request, const Model& model, const Results& results, const Found& found) {
    if (!found.load_case.empty())
        fmt::print("{}case {}\n", &found == &results.cases.front() ? "" : "\n", quote(found.load_case));
    print_table(model, Vectors(results.channels, found.row));
    if (request.statics.buckling > 0) print_buckling(found.critical, request.statics.buckling);
    fmt::print("{}forces balance to {:.2g} N (the largest is {:.4g} N) after {} in {}\n", verdict_of(found),
               found.rest.residual, found.rest.force, counted(as_size(found.rest.iterations), "iteration", "iterations"),
               counted(as_size(found.rest.load_steps), "load step", "load steps"));
}

/// Says which cases have none.
ExitCode conclude(const Results& results) {
    if (results.failures.empty()) return ExitCode::ok;
    for (const Failure& failure : results.failures) tell(failure.reason);
    tell(fmt::format("{} of {} cases failed; the results of the others are kept", results.failures.size(),
                     results.failures.size() + results.cases.size()));
    return ExitCode::cases_failed;
}

}  // namespace

ExitCode find_equilibrium(const Request& request) {
    const StopSignals signals(StopSignals::First::ends);
    const double time = instant_of(request);
    const Plugins plugins(request.plugins);
    Warnings warnings;
    Model model = read(request, plugins, time);
    warnings.add(model.warnings);
    note_varying(model, time, warnings);
    note_vibrations(model, warnings);
    note_velocities(model, "velocities-not-in-static",
                    "everything is at rest here, and centrifugal forces and gyroscopic moments are not in the equilibrium",
                    warnings);
    const Results results = find_all(request, model, plugins, time, warnings);
    hold(model, time);  // as the summary has it
    for (const Found& found : results.cases) warn_of(found, results, warnings);
    const SectionsOf sections = find_sections(results.channels);
    note_no_stress(model, sections, warnings);
    note_line_loads(results, model, sections, plugins.catalogue(), warnings);
    const ResultsFolder folder(results_path(request, "-static"));
    write_atomically(folder.file("static.csv"), rows_of(results));
    if (const std::string members = members_of(results, model, sections); !members.empty())
        write_atomically(folder.file("members.csv"), members);
    warnings.print_rest("; summary.json has all of them");
    write_json(folder.file("summary.json"),
               [&](JsonWriter& json) { write_summary(json, results, model, request, time, warnings, plugins); });
    if (!request.quiet) {
        if (!model.title.empty()) fmt::print("{}\n", model.title);
        for (const Found& found : results.cases) print_case(request, model, results, found);
        fmt::print("results in {}\n", folder.describe("static.csv"));
    }
    return conclude(results);
}

}  // namespace dttmm::host
