// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/adaptive_points.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace dttmm::host {

namespace {

/// Of magnitude, and of phase [rad]: what users are promised (README). It sets the number of points, by its inverse root.
constexpr double kTolerance = 0.01;
/// Of the largest magnitude of the curve: below it, 80 dB, a curve need not be straight.
constexpr double kSmall = 1e-4;
/// Of the largest magnitude of its kind at the same place: below it a curve may be rounding. Zero channels of a turned
/// machine have 1e-12 or less.
constexpr double kRoundingOfKind = 1e-7;
/// Of a peak: parabolas through its points add points until they promise less. What is printed is the peak to twice this.
constexpr double kPeakTolerance = 1e-5;
/// Share of x: narrower intervals are not parted, as beside a peak that nothing damps. The half-power width of ζ = 5e-8.
constexpr double kNarrow = 1e-7;

}  // namespace

const AdaptivePoints::Values* AdaptivePoints::take(double x) {
    if (const auto found = points_.find(x); found != points_.end()) return &found->second;
    if (points_.size() >= most_ || is_asked_to_stop_()) return nullptr;
    Values values = curves_(x);
    largest_.resize(values.size());
    std::vector<double>& sizes = sizes_[x];
    for (size_t c = 0; c < values.size(); ++c) {
        const double size = std::abs(values[c]);
        const size_t kind = kinds_[c].index;
        largest_[c] = std::max(largest_[c], size);
        if (kind >= sizes.size()) sizes.resize(kind + 1);
        sizes[kind] = std::max(sizes[kind], kinds_[c].scale * size);
    }
    return &points_.emplace(x, std::move(values)).first->second;
}

/// Smaller magnitudes of a curve at x need not be straight.
double AdaptivePoints::floor_of(size_t c, double x) const {
    return std::max(kSmall * largest_[c], kRoundingOfKind * sizes_.at(x)[kinds_[c].index] / kinds_[c].scale);
}

/// Whether the values at x1, between x0 and x2, are where a straight line has them.
bool AdaptivePoints::is_straight(double x0, double x1, double x2) const {
    const Values &v0 = points_.at(x0), &v1 = points_.at(x1), &v2 = points_.at(x2);
    const double s = (x1 - x0) / (x2 - x0);
    for (size_t c = 0; c < v1.size(); ++c) {
        if (!kinds_[c].is_curve) continue;
        const double size = std::abs(v1[c]), floor = floor_of(c, x1);
        const double straight = (1 - s) * std::abs(v0[c]) + s * std::abs(v2[c]);
        if (std::max({size, std::abs(v0[c]), std::abs(v2[c])}) <= floor) continue;
        if (std::abs(straight - size) > kTolerance * std::max(size, floor)) return false;
        if (size <= floor || std::abs(v0[c]) <= floor || std::abs(v2[c]) <= floor) continue;
        const double turn = std::arg(v2[c] / v0[c]);
        if (std::abs(std::arg(v1[c] / (v0[c] * std::polar(1.0, s * turn)))) > kTolerance) return false;
    }
    return true;
}

/// Whether a curve is larger at an end of the interval than at the points beside the interval, as beside a pole. The root of
/// a density that begins at 0 also bends within any interval, but it falls to 0 there.
bool AdaptivePoints::is_rising(double x0, double x2) const {
    const auto left = points_.find(x0), right = points_.find(x2);
    for (size_t c = 0; c < kinds_.size(); ++c) {
        if (!kinds_[c].is_curve) continue;
        const auto size = [&](const auto& point) { return std::abs(point->second[c]); };
        const double here = std::max(size(left), size(right)) / (1 + kTolerance);
        if (here <= floor_of(c, x0) && here <= floor_of(c, x2)) continue;
        const bool is_above_left = left == points_.begin() || here > size(std::prev(left));
        if (is_above_left && (std::next(right) == points_.end() || here > size(std::next(right)))) return true;
    }
    return false;
}

bool AdaptivePoints::refine(std::vector<std::pair<double, double>> intervals) {
    while (!intervals.empty()) {
        const auto [x0, x2] = intervals.back();
        intervals.pop_back();
        const double x1 = 0.5 * (x0 + x2);
        if (x0 == 0 && !(x2 > kNarrow * span_)) continue;  // what is free at 0 has no curve there
        if (!(x2 - x0 > kNarrow * x2)) {
            const bool is_known = !unbounded_.empty() && std::abs(unbounded_.back() - x1) <= 1e-5 * std::abs(x1);
            if (!is_known && is_rising(x0, x2)) unbounded_.push_back(x1);
            continue;
        }
        if (!take(x1)) return false;
        if (is_straight(x0, x1, x2)) continue;
        intervals.emplace_back(x0, x1);
        intervals.emplace_back(x1, x2);
    }
    return true;
}

/// Closes in on a peak of a curve by parabolas through three points, from the point x. False: as find().
bool AdaptivePoints::close_in(size_t c, double x) {
    const auto magnitude = [&](const auto& point) { return std::abs(point->second[c]); };
    for (int pass = 0; pass < 8; ++pass) {
        auto top = points_.find(x);
        const auto left = std::prev(top), right = std::next(top);
        const double x0 = left->first - x, x2 = right->first - x;
        const double size = magnitude(top), y0 = magnitude(left) - size, y2 = magnitude(right) - size;
        // y = a x² + b x through both
        const double a = (y0 / x0 - y2 / x2) / (x0 - x2), b = y0 / x0 - a * x0;
        if (!(a < 0)) break;
        const double rise = -b * b / (4 * a), to = -b / (2 * a);
        if (!(rise > kPeakTolerance * size) || !(to > x0) || !(to < x2)) break;
        if (!(std::abs(to) > kNarrow * std::abs(x))) break;
        const Values* values = take(x + to);
        if (!values) return false;
        if (std::abs((*values)[c]) > size) x += to;
    }
    return true;
}

/// Closes in on the largest magnitude of every curve, and on all peaks that may be it, for points may miss their tops by
/// kTolerance.
bool AdaptivePoints::find_peaks() {
    for (size_t c = 0; c < largest_.size(); ++c) {
        if (!kinds_[c].is_curve) continue;
        std::vector<double> tops;
        for (auto point = std::next(points_.begin()); std::next(point) != points_.end(); ++point) {
            const auto size = [&](const auto& at) { return std::abs(at->second[c]); };
            if (size(point) >= (1 - kTolerance) * largest_[c] && size(point) > floor_of(c, point->first) &&
                size(point) > size(std::prev(point)) && size(point) >= size(std::next(point)))
                tops.push_back(point->first);
        }
        if (!std::ranges::all_of(tops, [&](double top) { return close_in(c, top); })) return false;
    }
    return true;
}

bool AdaptivePoints::find(std::span<const double> start, size_t most, const std::function<bool()>& is_asked_to_stop) {
    most_ = most;
    span_ = start.back() - start.front();
    is_asked_to_stop_ = is_asked_to_stop;
    for (const double x : start)
        if (!take(x)) return false;
    std::vector<std::pair<double, double>> intervals;
    double last = start.front();
    for (const double x : start) {  // of natural frequencies, some may be equal but for rounding
        if (!(x - last > kNarrow * x)) continue;
        intervals.emplace_back(last, x);
        last = x;
    }
    return refine(std::move(intervals)) && find_peaks();
}

}  // namespace dttmm::host
