// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <memory>
#include <optional>
#include <vector>

#include "model/expression.h"
#include "model/signal.h"

namespace dttmm::host {

/// The shapes a signal can have; t is the time, all of it in [s], the value in whatever unit the signal has.

/// f(t) = value
class ConstantSignal : public Signal::Shape {
public:
    explicit ConstantSignal(double value) : value_(value) {}
    double value(double time) const override;
    std::optional<std::vector<SignalPart>> parts() const override { return std::vector<SignalPart>(); }

private:
    double value_;
};

/// f(t) = from + (to - from) (3 s² - 2 s³),  s = (t - start)/(end - start) held within 0 and 1. A jump at `start` if end =
/// start.
class StepSignal : public Signal::Shape {
public:
    StepSignal(double from, double to, double start, double end) : from_(from), to_(to), start_(start), end_(end) {}
    double value(double time) const override;
    /// Its largest curvature, 6 (to - from)/T² over the rise time T, is that of a cosine of the frequency 1/(2T), half a
    /// period in T, with the amplitude 6/pi² (to - from). A jump (T = 0) has no time that a step could resolve: no part.
    std::optional<std::vector<SignalPart>> parts() const override;

private:
    double from_, to_, start_, end_;
};

/// `count` haversines, `period` apart: f(t) = peak/2 (1 - cos(2 pi u/width)) where 0 <= u <= width, else 0;
/// u = t - start - i period, i the number of the pulse. One haversine is a pulse with count 1.
class PulseSignal : public Signal::Shape {
public:
    PulseSignal(double peak, double start, double width, double period = 0, double count = 1)
        : peak_(peak), start_(start), width_(width), period_(period), count_(count) {}
    double value(double time) const override;
    /// A haversine is a constant and a cosine of the frequency 1/width with half the peak as amplitude.
    std::optional<std::vector<SignalPart>> parts() const override;

private:
    double peak_, start_, width_, period_, count_;
};

/// f(t) = offset + amplitude sin(2 pi frequency (t - start) + phase) from `start` on, `offset` before. Frequency in [Hz],
/// phase in [rad].
class SineSignal : public Signal::Shape {
public:
    SineSignal(double amplitude, double frequency, double phase, double offset, double start)
        : amplitude_(amplitude), frequency_(frequency), phase_(phase), offset_(offset), start_(start) {}
    double value(double time) const override;
    std::optional<std::vector<SignalPart>> parts() const override;

private:
    double amplitude_, frequency_, phase_, offset_, start_;
};

/// A vibration of one frequency, f(t) = amplitude cos(2 pi f t + phase) = Re(amplitude e^(i phase) e^(2 pi i f t)). Its
/// frequency is fixed, or an order of the speed, f = order Omega/(2 pi), or left to `dttmm response`.
class HarmonicSignal : public Signal::Shape {
public:
    struct Numbers {
        double amplitude = 0;                       ///< in the unit of the signal, where `formula` is empty
        std::shared_ptr<const Expression> formula;  ///< the amplitude as an expression of Omega [rad/s]
        double phase = 0;                           ///< [rad]
        std::optional<double> frequency;            ///< [Hz]
        std::optional<double> order;
        int derivative = 0;           ///< the amplitude is that of the first or second derivative of the signal
        std::optional<double> speed;  ///< Omega of the model [rad/s]
    };
    explicit HarmonicSignal(Numbers numbers);

    /// At the model's speed; zero where it has no frequency of its own.
    double value(double time) const override;
    std::optional<std::vector<SignalPart>> parts() const override;

    bool is_order() const { return numbers_.order.has_value(); }
    double order() const { return *numbers_.order; }
    /// Its own, by the speed of the model if it is an order; none: it has none.
    std::optional<double> frequency() const;
    /// Its amplitude rests on the speed.
    bool needs_speed() const { return is_order() || numbers_.formula; }
    /// Of the model.
    std::optional<double> speed() const { return numbers_.speed; }
    /// Complex amplitude at a speed [rad/s] and a frequency [Hz]; may be non-finite for an expression, or at 0 Hz.
    std::complex<double> amplitude(double speed, double frequency) const;

private:
    Numbers numbers_;
    std::complex<double> amplitude_;  ///< at the model's speed and its own frequency
};

/// A random vibration by its one-sided power spectral density [unit²/Hz] over frequency, zero outside. In time it is zero.
class PsdSignal : public Signal::Shape {
public:
    /// is_logarithmic: straight between the points on double logarithmic paper, else linear.
    /// derivative: the values are of the first or second derivative of the signal.
    PsdSignal(std::vector<double> frequencies, std::vector<double> values, bool is_logarithmic, int derivative = 0)
        : frequencies_(std::move(frequencies)),
          values_(std::move(values)),
          is_logarithmic_(is_logarithmic),
          derivative_(derivative) {}
    double value(double) const override { return 0; }
    double density(double frequency) const;
    const std::vector<double>& frequencies() const { return frequencies_; }

private:
    double given(double frequency) const;

    std::vector<double> frequencies_, values_;
    bool is_logarithmic_;
    int derivative_;
};

/// Linear between the given points, the first and last value held outside. `times` increase strictly; at least one point.
class TableSignal : public Signal::Shape {
public:
    TableSignal(std::vector<double> times, std::vector<double> values)
        : times_(std::move(times)), values_(std::move(values)) {}
    double value(double time) const override;

private:
    std::vector<double> times_, values_;
};

/// A displacement whose velocity or acceleration is linear between the given points and zero outside; zero and at rest
/// before the first. `times` increase strictly; at least one point.
class IntegratedTableSignal : public Signal::Shape {
public:
    /// order: 1 of a velocity, 2 of an acceleration.
    IntegratedTableSignal(std::vector<double> times, std::vector<double> rates, int order);
    double value(double time) const override;
    /// With which it goes on for ever behind the last point.
    double last_velocity() const { return order_ == 2 ? velocities_.back() : 0; }
    double largest_velocity() const;

private:
    double advance(size_t i, double time, double& velocity) const;

    std::vector<double> times_, rates_;
    int order_;
    std::vector<double> displacements_, velocities_;  ///< at the points
};

/// f(t) = the value of an expression of t. One thread at a time.
class ExpressionSignal : public Signal::Shape {
public:
    explicit ExpressionSignal(Expression expression) : expression_(std::move(expression)) {}
    double value(double time) const override;

private:
    Expression expression_;
};

}  // namespace dttmm::host
