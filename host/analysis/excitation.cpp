// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/excitation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/error.h"
#include "model/index.h"
#include "model/signal_shapes.h"
#include "world/world.h"

namespace dttmm::host {

namespace {

const HarmonicSignal& harmonic(const Signal& signal) { return *signal.as<HarmonicSignal>(); }

void scale(dttmm_harmonic& load, std::complex<double> factor) {
    for (size_t d = 0; d < 6; ++d) {
        const std::complex<double> value = factor * std::complex<double>(load.wrench[2 * d], load.wrench[2 * d + 1]);
        load.wrench[2 * d] = value.real();
        load.wrench[2 * d + 1] = value.imag();
    }
}

/// Rotation vector of a support at rest [rad], world axes, without vibrations.
Eigen::Vector3d rotation_at_rest(const Node& node) {
    Eigen::Vector3d turn;
    for (size_t d = 0; d < 3; ++d) turn(as_row(d)) = node.motion[3 + d] ? node.motion[3 + d]->value(0) : 0;
    return turn;
}

/// Left Jacobian J of a rotation vector θ: δφ = J δθ, δφ the small rotation in world axes.
Eigen::Matrix3d turn_by_vector(const Eigen::Vector3d& theta) {
    const double angle = theta.norm();
    if (angle == 0) return Eigen::Matrix3d::Identity();
    const Eigen::Vector3d a = theta / angle;
    Eigen::Matrix3d cross;
    cross << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0;
    const double along = std::sin(angle) / angle, half = std::sin(0.5 * angle);
    return along * Eigen::Matrix3d::Identity() + (1 - along) * a * a.transpose() + 2 * half * half / angle * cross;
}

}  // namespace

/// Its speed as the model has it [rad/s]; 0 where its amplitude does not rest on one.
double Excitation::speed_of(const Placed& placed) {
    const HarmonicSignal& signal = harmonic(*placed.signal);
    if (!signal.needs_speed()) return 0;
    if (signal.speed()) return *signal.speed();
    throw Error(
        ExitCode::model_invalid,
        fmt::format("{}: {} which speed? ask with --rpm, as --rpm 800..6000, or add a parameter, Omega = \"3000 rpm\"",
                    placed.name, signal.is_order() ? fmt::format("order {:g} of", signal.order()) : "an amplitude of"));
}

void Excitation::add(const Signal& signal, const dttmm_harmonic& unit, const std::string& name) {
    (signal.as<PsdSignal>() ? randoms_ : harmonics_).push_back({&signal, unit, name});
}

Excitation::Excitation(const Model& model, const ModalMachine& machine) {
    for (const Load& load : model.loads) {
        if (load.vibration_at_to || (load.vibration && load.is_per_length()))
            throw Error(
                ExitCode::model_invalid,
                fmt::format("{}: a force_per_length that vibrates acts in a run only; for `dttmm response` replace it "
                            "by forces on nodes along the line",
                            load.place));
        if (!load.vibration || load.vibration_factor == 0) continue;
        ModalPlace place;
        Eigen::Vector3d direction = load.direction;
        if (load.on.body >= 0) {
            const Body& body = model.bodies[as_size(load.on.body)];
            const ModalPlace& on =
                *machine.find(load.on.marker < 0 ? body.name : body.name + "." + body.markers[as_size(load.on.marker)].name);
            place = on;
            if (load.turns) direction = machine.axes_of_body(as_size(load.on.body)) * load.direction;
        } else {
            place = *machine.find(model.nodes[as_size(load.on.node)].name);
        }
        ModalMachine::Complex6 unit = ModalMachine::Complex6::Zero();
        for (int d = 0; d < 3; ++d) unit((load.is_moment ? 3 : 0) + d) = direction(d) * load.vibration_factor;
        add(*load.vibration, ModalMachine::load_at(place, unit), load.place + ": load");
    }
    for (const Node& node : model.nodes)
        for (int d = 0; d < 6; ++d) {
            const auto& signal = node.vibrations[as_size(d)];
            const ModalPlace* place = machine.find(node.name);
            if (!signal || node.vibration_factor == 0 || !place) continue;
            ModalMachine::Complex6 unit = node.vibration_factor * ModalMachine::Complex6::Unit(d);
            if (machine.rest()) unit.tail<3>() = (turn_by_vector(rotation_at_rest(node)) * unit.tail<3>()).eval();
            add(*signal, ModalMachine::motion_at(*place, unit),
                fmt::format("{}: node \"{}\": motion", node.motion_place, node.name));
        }
}

bool Excitation::acts_everywhere() const {
    return is_by_inputs() || std::ranges::any_of(harmonics_, [](const Placed& placed) {
               const HarmonicSignal& signal = harmonic(*placed.signal);
               return !signal.is_order() && !signal.frequency();
           });
}

std::vector<double> Excitation::own_frequencies() const {
    std::vector<double> frequencies;
    for (const Placed& placed : harmonics_) {
        speed_of(placed);
        if (const auto own = harmonic(*placed.signal).frequency()) frequencies.push_back(*own);
    }
    std::ranges::sort(frequencies);
    frequencies.erase(std::unique(frequencies.begin(), frequencies.end()), frequencies.end());
    return frequencies;
}

std::vector<double> Excitation::orders() const {
    std::vector<double> orders;
    for (const Placed& placed : harmonics_)
        if (harmonic(*placed.signal).is_order()) orders.push_back(harmonic(*placed.signal).order());
    std::ranges::sort(orders);
    orders.erase(std::unique(orders.begin(), orders.end()), orders.end());
    return orders;
}

double Excitation::density(size_t random, double frequency, double inside) const {
    const PsdSignal& signal = *randoms_[random].signal->as<PsdSignal>();
    return signal.density(inside) > 0 ? signal.density(frequency) : 0;
}

std::vector<double> Excitation::random_corners() const {
    std::vector<double> corners;
    for (const Placed& placed : randoms_) {
        const std::vector<double>& own = placed.signal->as<PsdSignal>()->frequencies();
        corners.insert(corners.end(), own.begin(), own.end());
    }
    return corners;
}

bool Excitation::has_others_than_orders() const {
    return random_count() > 0 ||
           std::ranges::any_of(harmonics_, [](const Placed& placed) { return !harmonic(*placed.signal).is_order(); });
}

std::pair<double, double> Excitation::random_range() const {
    double low = std::numeric_limits<double>::infinity(), high = 0;
    for (const Placed& placed : randoms_) {
        const std::vector<double>& frequencies = placed.signal->as<PsdSignal>()->frequencies();
        low = std::min(low, frequencies.front());
        high = std::max(high, frequencies.back());
    }
    return {low, high};
}

std::vector<ModalInstance::Loads> Excitation::cases(const OperatingPoint& at) const {
    std::vector<ModalInstance::Loads> cases;
    for (const Input& input : inputs_) {
        const auto unit = ModalMachine::Complex6::Unit(input.direction);
        cases.push_back(
            {input.is_motion() ? ModalMachine::motion_at(*input.place, unit) : ModalMachine::load_at(*input.place, unit)});
    }
    if (is_by_inputs()) return cases;
    if (has_harmonics()) {
        ModalInstance::Loads& together = cases.emplace_back();
        for (const Placed& placed : harmonics_) {
            const HarmonicSignal& signal = harmonic(*placed.signal);
            const auto own = signal.frequency();
            const bool acts = at.speed ? signal.is_order() && signal.order() == at.order
                              : own    ? at.has_own && *own == at.frequency
                                       : !signal.is_order();
            if (!acts) continue;
            const std::complex<double> amplitude = signal.amplitude(at.speed ? *at.speed : speed_of(placed), at.frequency);
            if (!(std::abs(amplitude) <= World::kLargestWrench))
                throw Error(
                    ExitCode::numerical_failure,
                    fmt::format("{}: its amplitude is {}{} at {:g} Hz, not a finite number up to {:.0e}", placed.name,
                                amplitude.real(), amplitude.imag() == 0 ? "" : fmt::format(" {:+}i", amplitude.imag()),
                                at.frequency, World::kLargestWrench));
            together.push_back(placed.unit);
            scale(together.back(), amplitude);
        }
    }
    for (const Placed& placed : randoms_) cases.push_back({placed.unit});
    return cases;
}

}  // namespace dttmm::host
