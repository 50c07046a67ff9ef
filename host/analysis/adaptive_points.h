// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <functional>
#include <map>
#include <span>
#include <vector>

namespace dttmm::host {

/// Complex curves over one variable at so few points that straight lines between them are good to 1 %: magnitude to 1 % of
/// itself and phase to 1 % of a radian, where the magnitude is more than 1e-4 of the largest of its curve and 1e-7 of what
/// is largest of its kind at the same place, of which smaller values may be rounding; and at the peaks.
class AdaptivePoints {
public:
    using Values = std::vector<std::complex<double>>;
    /// Values of all curves at x.
    using Curves = std::function<Values(double x)>;

    /// What a curve is of.
    struct Kind {
        size_t index = 0;
        double scale = 1;      ///< times the magnitude: comparable with others of the kind
        bool is_curve = true;  ///< else its values only tell how large things of the kind are
    };

    /// kinds: of every curve.
    AdaptivePoints(Curves curves, std::vector<Kind> kinds) : curves_(std::move(curves)), kinds_(std::move(kinds)) {}

    /// Finds points from the first to the last of `start`, which ascend and of which there are two or more.
    /// `is_asked_to_stop` is asked before each point. False: it was stopped, or there would be more than `most` points.
    bool find(std::span<const double> start, size_t most, const std::function<bool()>& is_asked_to_stop);

    const std::map<double, Values>& points() const { return points_; }
    /// Points beside which a curve goes on rising without bound, as where nothing damps a natural frequency.
    const std::vector<double>& unbounded() const { return unbounded_; }

private:
    const Values* take(double x);
    double floor_of(size_t curve, double x) const;
    bool is_straight(double x0, double x1, double x2) const;
    bool is_rising(double x0, double x2) const;
    bool refine(std::vector<std::pair<double, double>> intervals);
    bool close_in(size_t curve, double x);
    bool find_peaks();

    Curves curves_;
    std::vector<Kind> kinds_;
    std::map<double, Values> points_;
    std::map<double, std::vector<double>> sizes_;  ///< by kind, at each point
    std::vector<double> largest_, unbounded_;
    double span_ = 0;  ///< from the first to the last point
    size_t most_ = 0;
    std::function<bool()> is_asked_to_stop_;
};

}  // namespace dttmm::host
