// SPDX-License-Identifier: BSD-3-Clause
#include "identify/mains_hum.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>

#include "analysis/fourier.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr double kBand = 0.05;          // share: no recorder's clock is further off
constexpr double kFloorBand = 0.5;      // share: around the band, what the floor is taken from
constexpr double kPeriods = 50;         // fewest: 50 bins for the floor
constexpr double kByChance = 1e-6;      // that noise above an exact floor has such a line; the floor's own scatter adds
constexpr double kSameInterval = 0.01;  // of an interval
constexpr double kSteady = 4;           // standard deviations by which the halves may differ, beside
constexpr double kMainsDrift = 2e-3;    // share of the frequency: twice what mains differ by from hour to hour
constexpr double kMainsVary = 0.05;     // share of the amplitude: what mains themselves vary by

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
    size_t size() const { return values_.size(); }
    /// Where the amplitude is largest, within a bin of a bin.
    double refine(size_t bin) const {
        const double width = 1 / static_cast<double>(size()), at = static_cast<double>(bin) * width;
        return boost::math::tools::brent_find_minima([&](double f) { return -amplitude(f, 0, size()); }, at - width,
                                                     at + width, std::numeric_limits<double>::digits / 2)
            .first;
    }

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

double share_of(double value, double whole) {
    return whole > 0 ? value / whole : value > 0 ? std::numeric_limits<double>::infinity() : 0;
}

/// The highest line near `expected`, a bin. Noise has an exponential distribution of power, whose median is ln 2 of its
/// mean.
Line find_line(const std::vector<double>& power, double expected) {
    const auto bin = [&](double share) {
        return std::clamp(static_cast<size_t>(std::lround(share * expected)), size_t{1}, power.size() - 1);
    };
    Line line;
    for (size_t i = bin(1 - kBand); i <= bin(1 + kBand) && i + 1 < power.size(); ++i) {
        const bool is_top = power[i] >= power[i - 1] && power[i] >= power[i + 1];  // no flank of a line outside
        if (is_top && (line.bin == 0 || power[i] > power[line.bin])) line.bin = i;
    }
    if (line.bin == 0) return line;
    std::vector<double> around;
    for (size_t i = bin(1 - kFloorBand); i <= bin(1 + kFloorBand); ++i) around.push_back(power[i]);
    const auto middle = around.begin() + as_row(around.size() / 2);
    std::ranges::nth_element(around, middle);
    const double floor = *middle / std::numbers::ln2;
    line.height = share_of(power[line.bin], floor);
    line.chance = static_cast<double>(bin(1 + kBand) - bin(1 - kBand) + 1) * std::exp(-line.height);
    return line;
}

/// Why hum cannot be found in a record; empty: it can.
std::string describe_unfit(const MeasuredSignal& record, double step, double nominal) {
    const std::vector<double>& times = record.abscissa;
    for (size_t i = 0; i < times.size(); ++i)
        if (!(std::abs(times[i] - times.front() - static_cast<double>(i) * step) <= kSameInterval * step))
            return fmt::format("{}: hum is sought in samples of equal intervals", record.place);
    const double expected = nominal * step * static_cast<double>(times.size());
    if (expected < kPeriods)
        return fmt::format("{}: {:.3g} periods of hum are too few, {} are wanted", record.place, expected, kPeriods);
    if (2 * nominal * (1 + kFloorBand) * step > 1)
        return fmt::format("{}: hum at {:.6g} Hz is not resolved by intervals of {:.4g} s", record.place, nominal, step);
    if (!std::ranges::all_of(record.values, [](double value) { return std::isfinite(value); }))
        return fmt::format("{}: not all values are numbers", record.place);
    return {};
}

}  // namespace

double find_mains_hum(const std::vector<const MeasuredSignal*>& histories, double nominal) {
    constexpr const char* kCure = "give `clock` in [measured]";
    struct Seen {
        const MeasuredSignal* signal;
        Line line;
        double frequency, bin;  ///< of the line; width of a bin [Hz]
    };
    std::vector<Seen> seen;
    std::string reason = "hum is sought in histories, and there are none";
    for (const MeasuredSignal* one : histories) {
        if (one->abscissa.size() < 2) continue;
        const double step = (one->abscissa.back() - one->abscissa.front()) / static_cast<double>(one->abscissa.size() - 1);
        if (const std::string unfit = describe_unfit(*one, step, nominal); !unfit.empty()) {
            if (seen.empty()) reason = unfit;
            continue;
        }
        const Record record(one->values);
        const double bin = 1 / (step * static_cast<double>(record.size()));
        const Line line = find_line(record.power(), nominal / bin);
        const double frequency = line.chance <= kByChance ? record.refine(line.bin) / step : 0;
        if (std::abs(frequency - nominal) <= kBand * nominal) seen.push_back({one, line, frequency, bin});
        reason = fmt::format("no hum stands out within {:.0f} % of {:.6g} Hz", 100 * kBand, nominal);
    }
    if (seen.empty()) refuse(fmt::format("{}: {}", reason, kCure));
    const Seen& best = *std::ranges::max_element(seen, {}, [](const Seen& one) { return one.line.height; });
    for (const Seen& one : seen)
        if (std::abs(one.frequency - best.frequency) > std::max(kMainsDrift * nominal, std::max(one.bin, best.bin)))
            refuse(fmt::format("hum is at {:.6g} Hz in {}, at {:.6g} Hz in {}: two recorders, or a vibration; {}",
                               one.frequency, one.signal->place, best.frequency, best.signal->place, kCure));
    const Record record(best.signal->values);
    const double at = best.frequency / (best.bin * static_cast<double>(record.size()));
    const size_t half = record.size() / 2;
    const double early = record.amplitude(at, 0, half), late = record.amplitude(at, half, record.size());
    // Amplitudes of the halves scatter by 1/sqrt(height) each
    if (!(std::abs(std::log(early / late)) <= kSteady * std::sqrt(2 / best.line.height) + kMainsVary))
        refuse(
            fmt::format("{}: the line at {:.6g} Hz changes from {:.3g} to {:.3g}: a vibration, or hum in a part of the "
                        "record; {}",
                        best.signal->place, best.frequency, early, late, kCure));
    return best.frequency;
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
