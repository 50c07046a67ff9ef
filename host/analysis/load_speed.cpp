// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/load_speed.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <complex>
#include <numbers>
#include <unsupported/Eigen/FFT>

#include "model/index.h"
#include "model/read_modes.h"
#include "model/read_simulation.h"

namespace dttmm::host {

namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;
/// A part at a quarter of the sampling rate still has its amplitude; this is four times what the step itself can show.
constexpr size_t kSamplesPerStep = 16;
/// 2^18 samples of an expression and their spectrum take some 50 ms; they are 2 per step at 131 072 steps.
constexpr size_t kFewestSamples = 1024, kMostSamples = size_t{1} << 18;

/// The part of a step's loss that a share of the load bears.
double error_of(const SignalPart& part, const double weights[3], double step) {
    return part.share * compute_load_error(weights, kTwoPi * part.frequency * step);
}

/// Amplitudes of the mirrored signal at the frequencies k/(2 duration), k = 0 … samples; empty where a value is not finite.
std::vector<double> find_amplitudes(const Signal& signal, double duration, size_t samples) {
    std::vector<double> mirrored(2 * samples);
    for (size_t i = 0; i <= samples; ++i) {
        const double value = signal.value(duration * static_cast<double>(i) / static_cast<double>(samples));
        if (!std::isfinite(value)) return {};
        mirrored[i] = mirrored[(2 * samples - i) % (2 * samples)] = value;
    }
    Eigen::FFT<double> transform;
    transform.SetFlag(Eigen::FFT<double>::HalfSpectrum);
    std::vector<std::complex<double>> spectrum;
    transform.fwd(spectrum, mirrored);
    std::vector<double> amplitudes;
    for (const std::complex<double>& value : spectrum) amplitudes.push_back(std::abs(value));
    return amplitudes;
}

/// A line between two of the frequencies k, or of a sine, whose mirror image is not smooth, stands in several of them: the
/// mean of those two to each side, weighted by energy.
double find_centre(const std::vector<double>& amplitudes, size_t k) {
    double sum = 0, moment = 0;
    for (size_t i = k - std::min<size_t>(k - 1, 2); i <= std::min(k + 2, amplitudes.size() - 1); ++i) {
        sum += amplitudes[i] * amplitudes[i];
        moment += static_cast<double>(i) * amplitudes[i] * amplitudes[i];
    }
    return moment / sum;
}

}  // namespace

double compute_load_error(const double weights[3], double omega_h) {
    const double a = omega_h / 2;
    if (!(a < std::numbers::pi / 2)) return -1;
    if (a == 0) return 0;
    const std::complex<double> turn = std::polar(1.0, omega_h);
    const double effect = std::abs(weights[0] * turn + weights[1] + weights[2] / turn);
    return effect * std::pow(a / std::sin(a), 2) - 1;
}

std::vector<SignalPart> find_parts(const Signal& signal, double duration, double step) {
    if (const auto known = signal.parts()) return *known;
    const double wanted = static_cast<double>(kSamplesPerStep) * duration / step;
    const size_t samples = wanted < static_cast<double>(kMostSamples)
                               ? std::bit_ceil(std::max(kFewestSamples, static_cast<size_t>(wanted)))
                               : kMostSamples;
    const std::vector<double> amplitudes = find_amplitudes(signal, duration, samples);
    std::vector<SignalPart> parts;
    if (amplitudes.empty()) return parts;
    const double largest = *std::max_element(amplitudes.begin() + 1, amplitudes.end());
    // Rounding of the mean is no part of a constant
    if (!(largest > 1e-9 * amplitudes.front())) return parts;
    for (size_t k = 1; k < amplitudes.size(); ++k)
        if (amplitudes[k] > kTolerableLoadError * largest)
            parts.push_back({find_centre(amplitudes, k) / (2 * duration), amplitudes[k] / largest});
    return parts;
}

std::vector<Acting> find_acting(const Model& model, double step) {
    const double duration = model.simulation.duration;
    std::vector<Acting> all;
    for (size_t i = 0; i < model.loads.size(); ++i) {
        const Load& load = model.loads[i];
        all.push_back({load.place, fmt::format("load number {}", i + 1), find_parts(load.signal, duration, step)});
        if (!load.signal_at_to) continue;
        for (const SignalPart& part : find_parts(*load.signal_at_to, duration, step)) all.back().parts.push_back(part);
    }
    for (const Node& node : model.nodes)
        for (size_t d = 0; d < node.motion.size(); ++d)
            if (node.motion[d])
                all.push_back({node.motion_place, fmt::format("the motion of node \"{}\" in {}", node.name, kDirections[d]),
                               find_parts(*node.motion[d], duration, step)});
    for (const Joint& joint : model.joints)
        if (joint.drive)
            all.push_back({joint.drive_place, fmt::format("the motor of joint \"{}\"", joint.name),
                           find_parts(*joint.drive, duration, step)});
    return all;
}

double compute_largest_error(const std::vector<SignalPart>& parts, const double weights[3], double step) {
    double largest = 0;
    for (const SignalPart& part : parts) largest = std::max(largest, std::abs(error_of(part, weights, step)));
    return largest;
}

std::vector<FastLoad> find_fast_loads(const Model& model, const Simulation& simulation, double tolerable) {
    const double* weights = simulation.load_weights();
    const double step = simulation.step_size();
    std::vector<FastLoad> found;
    for (const Acting& acting : find_acting(model, step)) {
        const auto largest_error = [&](double h) { return compute_largest_error(acting.parts, weights, h); };
        if (!(largest_error(step) > tolerable)) continue;
        const auto worst = std::ranges::max_element(
            acting.parts, {}, [&](const SignalPart& part) { return std::abs(error_of(part, weights, step)); });
        const double cure =
            divide_step(step, [&](double h) { return h < kShortestStep || largest_error(h) <= kTolerableLoadError; });
        found.push_back({acting.place, acting.name, worst->frequency, error_of(*worst, weights, step), cure});
    }
    return found;
}

std::string describe(const FastLoad& fast, double step) {
    const double per_period = 1 / (fast.frequency * step);
    const double digits = std::pow(10, std::floor(std::log10(fast.frequency)) - 2);  // three of them, without exponent
    return fmt::format(
        "{}: {} has a part at {:g} Hz, {:.2g} steps per period: at a step of {:g} s its effect is about "
        "{:.2g} "
        "% too {}{}, more near a natural frequency; use --step \"{:.12g} s\" for 1 % away from these",
        fast.place, fast.name, std::round(fast.frequency / digits) * digits, per_period, step, 100 * std::abs(fast.error),
        fast.error < 0 ? "small" : "large", per_period < 2 ? ", or it is lost between two steps" : "", fast.step);
}

double divide_step(double step, const std::function<bool(double)>& is_short_enough) {
    for (double decade = 1;; decade *= 10)
        for (double parts : {1, 2, 4, 5, 8})
            if (is_short_enough(step / (decade * parts))) return step / (decade * parts);
}

double divide_step(double step, double longest) {
    return divide_step(step, [longest](double h) { return !(h > longest); });
}

}  // namespace dttmm::host
