// SPDX-License-Identifier: BSD-3-Clause
#include "model/signal_shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/index.h"

namespace dttmm::host {
namespace {
constexpr double kTwoPi = 2 * std::numbers::pi;
}

double ConstantSignal::value(double) const { return value_; }

double StepSignal::value(double time) const {
    if (time < start_) return from_;
    if (time >= end_) return to_;
    const double s = (time - start_) / (end_ - start_);
    return from_ + (to_ - from_) * s * s * (3 - 2 * s);
}

std::optional<std::vector<SignalPart>> StepSignal::parts() const {
    if (end_ == start_ || from_ == to_) return std::vector<SignalPart>();
    return std::vector<SignalPart>{{0.5 / (end_ - start_), 6 / (std::numbers::pi * std::numbers::pi)}};
}

double PulseSignal::value(double time) const {
    const double since_start = time - start_;
    if (since_start < 0) return 0;
    const double pulse = period_ > 0 ? std::min(std::floor(since_start / period_), count_ - 1) : 0;
    const double u = since_start - pulse * period_;
    return u < width_ ? 0.5 * peak_ * (1 - std::cos(kTwoPi * u / width_)) : 0;
}

std::optional<std::vector<SignalPart>> PulseSignal::parts() const {
    if (peak_ == 0) return std::vector<SignalPart>();
    return std::vector<SignalPart>{{1 / width_, 0.5}};
}

double SineSignal::value(double time) const {
    if (time < start_) return offset_;
    return offset_ + amplitude_ * std::sin(kTwoPi * frequency_ * (time - start_) + phase_);
}

std::optional<std::vector<SignalPart>> SineSignal::parts() const {
    if (amplitude_ == 0 || frequency_ == 0) return std::vector<SignalPart>();
    return std::vector<SignalPart>{{frequency_, 1}};
}

HarmonicSignal::HarmonicSignal(Numbers numbers) : numbers_(std::move(numbers)) {
    if (const auto f = frequency()) amplitude_ = amplitude(numbers_.speed.value_or(0), *f);
}

std::optional<double> HarmonicSignal::frequency() const {
    if (!numbers_.order) return numbers_.frequency;
    return numbers_.speed ? std::optional(std::abs(*numbers_.order * *numbers_.speed / kTwoPi)) : std::nullopt;
}

double HarmonicSignal::value(double time) const {
    const auto f = frequency();
    return f ? (amplitude_ * std::polar(1.0, kTwoPi * *f * time)).real() : 0;
}

std::optional<std::vector<SignalPart>> HarmonicSignal::parts() const {
    const auto f = frequency();
    if (!f || *f == 0 || amplitude_ == 0.0) return std::vector<SignalPart>();
    return std::vector<SignalPart>{{*f, 1}};
}

std::complex<double> HarmonicSignal::amplitude(double speed, double frequency) const {
    const double size = numbers_.formula ? numbers_.formula->value(speed) : numbers_.amplitude;
    const std::complex<double> whole = size * std::polar(1.0, numbers_.phase), rate(0, kTwoPi * frequency);
    return numbers_.derivative == 0 ? whole : numbers_.derivative == 1 ? whole / rate : whole / (rate * rate);
}

double PsdSignal::density(double frequency) const {
    return given(frequency) * std::pow(kTwoPi * frequency, -2 * derivative_);
}

double PsdSignal::given(double frequency) const {
    if (frequency < frequencies_.front() || frequency > frequencies_.back()) return 0;
    const auto after = std::upper_bound(frequencies_.begin(), frequencies_.end(), frequency);
    if (after == frequencies_.end()) return values_.back();
    const auto i = as_size(after - frequencies_.begin());
    const double f0 = frequencies_[i - 1], f1 = frequencies_[i], v0 = values_[i - 1], v1 = values_[i];
    if (is_logarithmic_) return v0 * std::pow(v1 / v0, std::log(frequency / f0) / std::log(f1 / f0));
    const double s = (frequency - f0) / (f1 - f0);
    return (1 - s) * v0 + s * v1;
}

double TableSignal::value(double time) const {
    const auto after = std::upper_bound(times_.begin(), times_.end(), time);
    if (after == times_.begin()) return values_.front();
    if (after == times_.end()) return values_.back();
    const auto i = as_size(after - times_.begin());
    const double s = (time - times_[i - 1]) / (times_[i] - times_[i - 1]);
    return (1 - s) * values_[i - 1] + s * values_[i];
}

IntegratedTableSignal::IntegratedTableSignal(std::vector<double> times, std::vector<double> rates, int order)
    : times_(std::move(times)), rates_(std::move(rates)), order_(order), displacements_(1, 0.0), velocities_(1, 0.0) {
    if (order_ == 1) velocities_.front() = rates_.front();
    for (size_t i = 1; i < times_.size(); ++i) {
        double velocity = 0;
        displacements_.push_back(advance(i - 1, times_[i], velocity));
        velocities_.push_back(velocity);
    }
}

/// The displacement and the velocity at a time between point i and the next.
double IntegratedTableSignal::advance(size_t i, double time, double& velocity) const {
    const double t = time - times_[i], slope = (rates_[i + 1] - rates_[i]) / (times_[i + 1] - times_[i]), rate = rates_[i];
    if (order_ == 1) {
        velocity = rate + slope * t;
        return displacements_[i] + t * (rate + slope * t / 2);
    }
    velocity = velocities_[i] + t * (rate + slope * t / 2);
    return displacements_[i] + t * (velocities_[i] + t * (rate / 2 + slope * t / 6));
}

double IntegratedTableSignal::value(double time) const {
    const auto after = std::upper_bound(times_.begin(), times_.end(), time);
    if (after == times_.begin()) return 0;
    if (after == times_.end()) return displacements_.back() + last_velocity() * (time - times_.back());
    double velocity = 0;
    return advance(as_size(after - times_.begin()) - 1, time, velocity);
}

double IntegratedTableSignal::largest_velocity() const {
    double largest = 0;
    for (const double velocity : velocities_) largest = std::max(largest, std::abs(velocity));
    return largest;
}

double ExpressionSignal::value(double time) const { return expression_.value(time); }

}  // namespace dttmm::host
