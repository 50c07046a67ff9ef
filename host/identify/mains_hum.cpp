// SPDX-License-Identifier: BSD-3-Clause
#include "identify/mains_hum.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <complex>
#include <numbers>

#include "analysis/fourier.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr double kBand = 0.05;          // share: no recorder's clock is further off
constexpr double kFloorBand = 0.2;      // share: around the band, what the floor is taken from
constexpr double kPeriods = 25;         // fewest: the band is then wider than a line
constexpr double kByChance = 1e-6;      // that noise alone has such a line
constexpr double kSameInterval = 0.01;  // of an interval
constexpr double kSteady = 2;           // ratio of amplitudes of the halves: mains keep theirs, a vibration decays

[[noreturn]] void refuse(const std::string& text) { throw Error(ExitCode::input_output, text); }

/// A line in samples of equal intervals, seen through Hann's window. Frequencies in periods per sample.
class Record {
public:
    explicit Record(std::vector<double> values) : values_(std::move(values)) {
        double mean = 0;
        for (const double value : values_) mean += value / static_cast<double>(values_.size());
        for (double& value : values_) value -= mean;
    }

    /// Amplitude of a sine in samples `first` to `end`.
    double amplitude(double frequency, size_t first, size_t end) const {
        std::complex<double> sum = 0;
        double weights = 0;
        const double span = static_cast<double>(end - first);
        for (size_t i = first; i < end; ++i) {
            const double weight = hann((static_cast<double>(i - first) + 0.5) / span);
            sum += weight * values_[i] * std::polar(1.0, -2 * std::numbers::pi * frequency * static_cast<double>(i));
            weights += weight;
        }
        return 2 * std::abs(sum) / weights;
    }
    double amplitude(double frequency) const { return amplitude(frequency, 0, size()); }
    size_t size() const { return values_.size(); }

    /// Squares of the transform's bins from 0 on, each 1/size wide.
    std::vector<double> power() const {
        std::vector<double> windowed(size());
        for (size_t i = 0; i < size(); ++i)
            windowed[i] = values_[i] * hann((static_cast<double>(i) + 0.5) / static_cast<double>(size()));
        std::vector<double> power;
        for (const std::complex<double>& bin : fourier_transform(windowed)) power.push_back(std::norm(bin));
        return power;
    }

private:
    static double hann(double at) { return std::pow(std::sin(std::numbers::pi * at), 2); }

    std::vector<double> values_;
};

struct Line {
    size_t bin = 0;
    double height = 0;  ///< power over the mean power of noise
    double chance = 1;  ///< that noise alone has it
};

/// The highest line near `expected`, a bin. Noise has an exponential distribution of power, whose median is ln 2 of its
/// mean.
Line find_line(const std::vector<double>& power, double expected) {
    const auto bin = [&](double share) {
        return std::clamp(static_cast<size_t>(std::lround(share * expected)), size_t{1}, power.size() - 1);
    };
    Line line;
    for (size_t i = bin(1 - kBand); i <= bin(1 + kBand); ++i)
        if (line.bin == 0 || power[i] > power[line.bin]) line.bin = i;
    std::vector<double> around;
    for (size_t i = bin(1 - kFloorBand); i <= bin(1 + kFloorBand); ++i) around.push_back(power[i]);
    const auto middle = around.begin() + as_row(around.size() / 2);
    std::ranges::nth_element(around, middle);
    const double floor = *middle / std::numbers::ln2;
    line.height = floor > 0 ? power[line.bin] / floor : power[line.bin] > 0 ? std::numeric_limits<double>::infinity() : 0;
    line.chance = static_cast<double>(bin(1 + kBand) - bin(1 - kBand) + 1) * std::exp(-line.height);
    return line;
}

}  // namespace

double find_mains_hum(const std::vector<const MeasuredSignal*>& histories, double nominal) {
    const MeasuredSignal* best = nullptr;
    double interval = 0;
    Line highest;
    for (const MeasuredSignal* one : histories) {
        const std::vector<double>& times = one->abscissa;
        if (times.size() < 2) continue;
        const double step = (times.back() - times.front()) / static_cast<double>(times.size() - 1);
        for (size_t i = 0; i < times.size(); ++i)
            if (!(std::abs(times[i] - times.front() - static_cast<double>(i) * step) <= kSameInterval * step))
                refuse(
                    fmt::format("{}: hum is sought in samples of equal intervals; give `clock` in [measured]", one->place));
        const double expected = nominal * step * static_cast<double>(times.size());
        if (expected < kPeriods)
            refuse(fmt::format("{}: {:.3g} periods of hum are too few, {} are wanted; give `clock` in [measured]",
                               one->place, expected, kPeriods));
        if (2 * nominal * (1 + kFloorBand) * step > 1)
            refuse(fmt::format("{}: hum at {:.6g} Hz is not resolved by intervals of {:.4g} s; give `clock` in [measured]",
                               one->place, nominal, step));
        const Line line = find_line(Record(one->values).power(), expected);
        if (line.height <= highest.height) continue;
        highest = line;
        best = one;
        interval = step;
    }
    if (!best) refuse("hum is sought in histories, and there are none: give `clock` in [measured]");
    if (highest.chance > kByChance)
        refuse(
            fmt::format("no hum stands out within {:.0f} % of {:.6g} Hz: give `clock` in [measured]", 100 * kBand, nominal));
    const Record record(best->values);
    const auto size = static_cast<double>(record.size());
    const double at = static_cast<double>(highest.bin) / size;
    const double frequency =
        boost::math::tools::brent_find_minima([&](double f) { return -record.amplitude(f); }, at - 1 / size, at + 1 / size,
                                              std::numeric_limits<double>::digits / 2)
            .first;
    const size_t half = record.size() / 2;
    const double early = record.amplitude(frequency, 0, half), late = record.amplitude(frequency, half, record.size());
    if (!(early <= kSteady * late && late <= kSteady * early))
        refuse(
            fmt::format("{}: the line at {:.6g} Hz changes from {:.3g} to {:.3g}: a vibration, or hum in a part of the "
                        "record; give `clock` in [measured]",
                        best->place, frequency / interval, early, late));
    return frequency / interval;
}

Eigen::VectorXd fit_sine(std::span<const double> times, const Eigen::Ref<const Eigen::VectorXd>& values, double frequency) {
    Eigen::MatrixX2d waves(values.size(), 2);
    for (Eigen::Index i = 0; i < values.size(); ++i) {
        const double phase = 2 * std::numbers::pi * frequency * times[as_size(i)];
        waves.row(i) << std::cos(phase), std::sin(phase);
    }
    return waves * waves.colPivHouseholderQr().solve(values);
}

}  // namespace dttmm::host
