// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/statics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "analysis/modal_session.h"
#include "analysis/summary.h"
#include "coupling/modal_description.h"
#include "loader/modal_instance.h"
#include "loader/plugins.h"
#include "model/index.h"
#include "model/read_simulation.h"
#include "model/units.h"
#include "model/wording.h"
#include "record/csv_writer.h"
#include "record/results_folder.h"
#include "step/simulation.h"

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
    if (request.at.empty()) return 0;
    try {
        const double time = parse_quantity(request.at, "s");
        if (std::isfinite(time) && time >= 0) return time;
        throw Error(ExitCode::usage, "must be zero or more");
    } catch (const Error& error) {
        throw Error(ExitCode::usage, fmt::format("--at {}: {}", quote(request.at), error.what()));
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

/// The model with all loads as they are at an instant; a word on those that vary.
Model read(const Request& request, const Plugins& plugins, double time, Warnings& warnings) {
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::statics;
    Model model = read_model(request.model, plugins.catalogue(), overrides);
    warnings.add(model.warnings);
    std::string first;
    size_t count = 0;
    for (Load& load : model.loads) {
        const double value = load.signal.value(time), at_to = load.at_to().value(time);
        const double duration = model.simulation.duration > 0 ? model.simulation.duration : 1;
        if ((varies(load.signal, duration) || varies(load.at_to(), duration)) && ++count == 1)
            first = fmt::format("{}: this load varies in time; it counts with {:.6g} {}{}, its value at t = {:g} s",
                                load.place, value, load.unit(),
                                load.signal_at_to ? fmt::format(" to {:.6g} {}", at_to, load.unit()) : "", time);
        load.signal = Signal(std::make_shared<Held>(value));
        if (load.signal_at_to) load.signal_at_to = Signal(std::make_shared<Held>(at_to));
    }
    if (count > 0)
        warnings.note("load-varies", first + (count > 1 ? fmt::format("; {} more vary too", count - 1) : "") +
                                         ". Option --at takes another instant");
    model.simulation.step = model.simulation.step > 0 ? model.simulation.step : kDefaultStep;
    model.simulation.coupling = Coupling::implicit;
    model.simulation.spectral_radius = 1;
    model.simulation.starts_at_rest = true;
    for (Body& body : model.bodies) body.velocity = body.angular_velocity = Eigen::Vector3d::Zero();
    for (Node& node : model.nodes) node.velocity = node.angular_velocity = Eigen::Vector3d::Zero();
    return model;
}

/// Vectors of the row, "plate.position", with the owner and what it is.
struct Vectors {
    struct Vector {
        double numbers[3] = {0, 0, 0};
    };
    std::map<std::string, Vector> all;

    Vectors(const std::vector<Channel>& channels, std::span<const double> row) {
        for (size_t c = 0; c < channels.size(); ++c) {
            const std::string& axis = channels[c].axis();
            if (axis != "x" && axis != "y" && axis != "z") continue;
            all[channels[c].without_axis()].numbers[axis[0] - 'x'] = row[c];
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
            if (name.ends_with(".force")) strong = std::max(strong, std::abs(number));
        }
    const auto print_place = [&](const std::string& name, const Eigen::Vector3d& start) {
        const Vectors::Vector* position = vectors.find(name + ".position");
        if (!position) return;
        Vectors::Vector moved = *position;
        for (int i = 0; i < 3; ++i) moved.numbers[i] -= start(i);
        print_row(name, width, "moved [m]", moved, far);
        if (const Vectors::Vector* turn = vectors.find(name + ".rotation")) print_row("", width, "turned [rad]", *turn, 1);
    };
    for (const Body& body : model.bodies) print_place(body.name, body.position);
    for (const Node& node : model.nodes) print_place(node.name, node.position);
    const auto print_force = [&](const std::string& name) {
        if (const Vectors::Vector* force = vectors.find(name + ".force"))
            print_row(name, width, "force [N]", *force, strong);
        if (const Vectors::Vector* moment = vectors.find(name + ".moment"))
            print_row("", width, "moment [N*m]", *moment, strong);
    };
    for (const Element& element : model.elements) print_force(element.name);
    for (const Joint& joint : model.joints) print_force(joint.name);
}

/// Load factors at which motions begin to grow, ascending: all forces of the machine at rest count so many times, with the
/// places and the stiffness that it has there. Motions that grow are counted, and each factor is enclosed by two counts.
class Buckling {
public:
    Buckling(const Model& model, const Plugins& plugins) : description_(model, plugins, true) {
        description_.scale_forces(0);
        ModalInstance instance(description_.plugin(), description_.model());
        is_held_ = instance.find_modes(1, 0) == 0 || instance.mode(0).numbers.frequency != 0;
    }

    std::vector<double> find(int wanted) {
        constexpr double kLargest = 1e9, kSmallest = 1e-9, kNear = 1e-12;
        double high = 1;
        while (count(high) < wanted && high < kLargest) high *= 4;
        std::vector<double> factors;
        for (int k = 1; k <= std::min(wanted, count(high)); ++k) {
            double below = factors.empty() ? 0 : factors.back() * (1 - 1e-9), above = high;
            while (above - below > kNear * above && above > kSmallest) {
                const double middle =
                    below > above / 4 ? 0.5 * (below + above) : std::max(0.25 * above, below + 1e-3 * above);
                (count(middle) >= k ? above : below) = middle;
            }
            factors.push_back(above);
        }
        return factors;
    }

private:
    int count(double factor) {
        description_.scale_forces(factor);
        return as_int(ModalInstance(description_.plugin(), description_.model()).count_growing(is_held_));
    }

    ModalDescription description_;
    bool is_held_ = true;
};

void print_buckling(const std::vector<double>& factors, int wanted) {
    if (factors.empty()) {
        fmt::print("no critical load factor: no motion grows up to 1e9 times its forces\n");
        return;
    }
    std::string list;
    for (const double factor : factors) list += fmt::format("{}{:.8g}", list.empty() ? "" : ", ", factor);
    fmt::print("critical load {}: {}{}\n", factors.size() == 1 ? "factor" : "factors", list,
               as_int(factors.size()) < wanted ? " (there are no more)" : "");
}

}  // namespace

ExitCode find_equilibrium(const Request& request) {
    const double time = instant_of(request);
    const Plugins plugins(request.plugins);
    Warnings warnings;
    const Model model = read(request, plugins, time, warnings);
    Simulation simulation(model, plugins);
    std::vector<double> row;
    simulation.record_to([&](std::span<const double> numbers) {
        if (row.empty()) row.assign(numbers.begin(), numbers.end());
    });
    simulation.step();
    const RestState& rest = *simulation.rest();
    if (rest.turn > kFar)
        warnings.note("moved-far", fmt::format("a body has turned by {:.3g} rad: there may be other equilibria; this is the "
                                               "one reached from the assembled machine",
                                               rest.turn));
    std::vector<double> factors;
    if (request.buckling > 0) factors = Buckling(model, plugins).find(request.buckling);
    const ResultsFolder folder(results_path(request, "-static"));
    std::vector<Column> columns;
    for (const Channel& channel : simulation.channels()) columns.push_back({channel.name(), channel.unit()});
    columns.erase(columns.begin());
    CsvWriter rows(folder.file("static.csv"), columns);
    rows.write_row(std::span<const double>(row).subspan(1));
    rows.finish();
    warnings.print_rest("; summary.json has all of them");
    write_json(folder.file("summary.json"), [&](JsonWriter& json) {
        json.member("format", "dttmm-static/1");
        json.member("warnings", describe_warnings(warnings));
        json.member("title", model.title);
        json.member("status", "completed");
        json.member("loads_at_s", time);
        json.member("iterations", rest.iterations);
        json.member("load_steps", rest.load_steps);
        json.member("largest_force_n", rest.force);
        json.member("largest_unbalanced_force_n", rest.residual);
        if (request.buckling > 0) json.member("critical_load_factors", factors);
        json.member("command_line", request.command_line);
        json.member("inputs", describe_inputs(model, request));
        write_model(json, model, plugins.catalogue());
    });
    if (request.quiet) return ExitCode::ok;
    if (!model.title.empty()) fmt::print("{}\n", model.title);
    print_table(model, Vectors(simulation.channels(), row));
    if (request.buckling > 0) print_buckling(factors, request.buckling);
    fmt::print("forces balance to {:.2g} N (the largest is {:.4g} N) after {} in {}\nresults in {}\n", rest.residual,
               rest.force, counted(as_size(rest.iterations), "iteration", "iterations"),
               counted(as_size(rest.load_steps), "load step", "load steps"), folder.describe("static.csv"));
    return ExitCode::ok;
}

}  // namespace dttmm::host
