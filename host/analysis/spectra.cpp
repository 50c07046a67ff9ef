// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/spectra.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "analysis/fourier.h"
#include "model/error.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

constexpr double kCircle = 2 * std::numbers::pi;

struct NamedTaper {
    const char* name;
    Taper taper;
};
constexpr NamedTaper kTapers[] = {{"hann", Taper::hann}, {"rectangular", Taper::rectangular}, {"flattop", Taper::flattop}};

/// Of a sine alone that stands a share of a bin beside the larger of two bins: that share, and its height over that bin.
std::pair<double, double> beside(Taper taper, double ratio) {
    if (taper == Taper::flattop) return {0, 1};
    const double share = taper == Taper::hann ? (2 * ratio - 1) / (1 + ratio) : ratio / (1 + ratio);
    const double x = std::numbers::pi * share;
    if (std::abs(x) < 1e-8) return {share, 1};
    return {share, x / std::sin(x) * (taper == Taper::hann ? 1 - share * share : 1)};
}

}  // namespace

Taper parse_taper(const std::string& name) {
    std::vector<std::string> names;
    for (const NamedTaper& one : kTapers) {
        if (name == one.name) return one.taper;
        names.emplace_back(one.name);
    }
    throw Error(ExitCode::usage,
                fmt::format("--window {}: there is no such window{}", quote(name), suggestion(name, names)));
}

const char* taper_name(Taper taper) { return std::ranges::find(kTapers, taper, &NamedTaper::taper)->name; }

std::vector<double> taper_samples(Taper taper, std::size_t size) {
    std::vector<double> terms = {1};
    if (taper == Taper::hann) terms = {0.5, -0.5};
    if (taper == Taper::flattop) terms = {0.21557895, -0.41663158, 0.277263158, -0.083578947, 0.006947368};
    std::vector<double> samples(size, 0);
    for (std::size_t n = 0; n < size; ++n)
        for (std::size_t k = 0; k < terms.size(); ++k)
            samples[n] += terms[k] * std::cos(kCircle * static_cast<double>(k * n % size) / static_cast<double>(size));
    return samples;
}

Levels levels_of(const std::vector<double>& x) {
    Levels levels;
    if (x.empty()) return levels;
    const auto count = static_cast<double>(x.size());
    levels.mean = std::accumulate(x.begin(), x.end(), 0.0) / count;
    double square = 0, about_mean = 0;
    for (std::size_t n = 0; n < x.size(); ++n) {
        square += x[n] * x[n];
        about_mean += (x[n] - levels.mean) * (x[n] - levels.mean);
        if (std::abs(x[n]) > levels.peak) {
            levels.peak = std::abs(x[n]);
            levels.peak_at = n;
        }
        levels.is_constant = levels.is_constant && x[n] == x[0];
    }
    levels.rms = std::sqrt(square / count);
    levels.deviation = levels.is_constant ? 0 : std::sqrt(about_mean / count);
    return levels;
}

Spectrum spectrum_of(const std::vector<double>& x, double interval, double start, Taper taper, std::size_t size) {
    const std::vector<double> window = taper_samples(taper, size);
    double sum = 0, squares = 0;
    for (const double w : window) {
        sum += w;
        squares += w * w;
    }
    const double mean = levels_of(x).mean;
    const std::size_t segments = segment_count(x.size(), size), hop = size - size / 2, bins = size / 2 + 1;
    std::vector<double> power(bins, 0), segment(size);
    Spectrum out;
    for (std::size_t s = 0; s < segments; ++s) {
        for (std::size_t n = 0; n < size; ++n) segment[n] = window[n] * (x[s * hop + n] - mean);
        const auto transformed = fourier_transform(segment);
        for (std::size_t k = 0; k < bins; ++k) power[k] += std::norm(transformed[k]) / static_cast<double>(segments);
        for (std::size_t k = 0; segments == 1 && k < bins; ++k) {
            const double frequency = static_cast<double>(k) / (static_cast<double>(size) * interval);
            const double phase = std::arg(transformed[k]) - kCircle * std::fmod(frequency * start, 1.0);
            out.phase.push_back(std::remainder(phase, kCircle) * 360 / kCircle);
        }
    }
    for (std::size_t k = 0; k < bins; ++k) {
        const double sides = k == 0 || 2 * k == size ? 1 : 2;  // of a real series the other half mirrors
        out.amplitude.push_back(sides * std::sqrt(power[k]) / sum);
        out.density.push_back(sides * power[k] * interval / squares);
    }
    return out;
}

std::size_t segment_size(std::size_t samples, std::size_t segments) {
    return segments < 2 ? samples : samples / (segments + 1) * 2;  // even: the overlap is half of it
}

std::size_t segment_count(std::size_t samples, std::size_t size) {
    return samples < size ? 0 : 1 + (samples - size) / (size - size / 2);
}

std::vector<Peak> peaks_of(const std::vector<double>& amplitude, double resolution, Taper taper, std::size_t most,
                           double least) {
    std::vector<Peak> peaks;
    const double largest = amplitude.empty() ? 0 : *std::ranges::max_element(amplitude);
    for (std::size_t k = 1; k + 1 < amplitude.size(); ++k) {
        const double before = amplitude[k - 1], here = amplitude[k], after = amplitude[k + 1];
        if (here < least * largest || !(here > before && here >= after)) continue;
        const auto [share, height] = beside(taper, std::max(before, after) / here);
        const double place = static_cast<double>(k) + (after > before ? share : -share);
        peaks.push_back({k, place * resolution, here * height});
    }
    std::ranges::stable_sort(peaks, std::greater{}, &Peak::amplitude);
    if (peaks.size() > most) peaks.resize(most);
    return peaks;
}

}  // namespace dttmm::host
