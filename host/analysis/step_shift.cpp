// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/step_shift.h"

#include <fmt/format.h>

#include <Eigen/Dense>

namespace dttmm::host {

namespace {

using Complex = std::complex<double>;

/// h V(z) of the explicit schemes. Fox-Euler has its previous velocity from the host and coincides with BDF2.
Complex backward_velocity(const std::string& scheme, Complex z) {
    const Complex q = 1.0 / z;
    if (scheme == "bdf1") return 1.0 - q;
    if (scheme == "houbolt") return (11.0 - 18.0 * q + 9.0 * q * q - 2.0 * q * q * q) / 6.0;
    if (scheme == "park") return (10.0 - 15.0 * q + 6.0 * q * q - q * q * q) / 6.0;
    return (3.0 - 4.0 * q + q * q) / 2.0;
}

}  // namespace

std::vector<StepShift> StepShift::of_run(const Json& summary) {
    if (!summary.is_object() || !summary.contains("model")) return {};
    const Json simulation = summary["model"].value("simulation", Json::object());
    const bool is_extrapolated = summary.contains("tolerance");
    const Json step = is_extrapolated ? summary["tolerance"].value("step", Json()) : simulation.value("step", Json());
    if (!step.is_number()) return {};
    const std::string scheme = simulation.value("scheme", "centred");
    const double radius = simulation.value("spectral_radius", 1.0);
    std::vector<StepShift> shifts = {StepShift(step.get<double>(), scheme, radius)};
    if (is_extrapolated) shifts.emplace_back(2 * step.get<double>(), scheme, radius);
    return shifts;
}

StepShift::StepShift(double step, std::string scheme, double radius)
    : step_(step),
      scheme_(std::move(scheme)),
      beta_(1 / ((1 + radius) * (1 + radius))),
      gamma_((3 - radius) / (2 * (1 + radius))) {}

std::complex<double> StepShift::true_rate(Complex recorded) const {
    const Complex z = std::exp(recorded * step_);
    // As (e^x - 1)^2 the small difference of a slow vibration keeps its digits
    const Complex half = std::sinh(0.5 * recorded * step_);
    const Complex acceleration = 4.0 * half * half;  // h^2 A
    const bool is_centred = scheme_ == "centred";
    const Complex velocity = is_centred
                                 ? 2.0 * half * std::cosh(0.5 * recorded * step_) + (2 * gamma_ - 1) * 0.5 * acceleration
                                 : backward_velocity(scheme_, z);
    const Complex position = is_centred ? beta_ * z + (0.5 + gamma_ - 2 * beta_) + (0.5 - gamma_ + beta_) / z : 1.0;
    Eigen::Matrix2d parts;
    parts << velocity.real(), position.real(), velocity.imag(), position.imag();
    const Eigen::Vector2d found = parts.fullPivLu().solve(-Eigen::Vector2d(acceleration.real(), acceleration.imag()));
    const double damping = 0.5 * found(0) / step_, square = found(1) / (step_ * step_);  // zeta omega, omega^2
    return {-damping, std::sqrt(std::max(0.0, square - damping * damping))};
}

std::string StepShift::describe() const {
    if (scheme_ != "centred")
        return fmt::format("explicit coupling ({}), step {:g} s: frequencies of the history are too high by (omega h)^2/24",
                           scheme_, step_);
    return fmt::format(
        "implicit coupling, step {:g} s: frequencies of the history are too low by {}", step_,
        gamma_ == 0.5 ? "(omega h)^2/12" : "(omega h)^2/12 and more, and damping is too high, by spectral_radius");
}

}  // namespace dttmm::host
