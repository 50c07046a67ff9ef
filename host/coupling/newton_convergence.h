// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "dttmm_plugin.h"
#include "world/inertia.h"
#include "world/iteration.h"

namespace dttmm::host {

/// How fast the passes of an iteration come to rest, in one measure: θ/(1 − θ), θ the ratio of two corrections in
/// succession. A larger correction than the one after which it was measured contracts less in proportion.
class Contraction {
public:
    /// What remains after a correction.
    double left(double correction) const;
    void measure(double rate, double previous);
    /// A kept rate is trusted half as much with every step that did not measure it anew, and never below `least`.
    void forget(double least);

private:
    double share_ = 1;        ///< of the correction
    double measured_at_ = 0;  ///< correction after which it was measured; 0: not yet
};

/// Judges whether Newton's iteration has found the motion over a step: of connected bodies, or inside a part of a plugin.
/// What remains of the motion and of the momentum is estimated from their contraction, in this step or in those before. It
/// is to be below rounding, or a small share of the motion, and of the largest impulse. A first pass of a step may be enough
/// where passes are known to contract.
/// Source of the rule: Hairer and Wanner, Solving Ordinary Differential Equations II, section IV.8.
class NewtonConvergence {
public:
    /// What may remain.
    struct Limits {
        double motion;   ///< share of it
        double first;    ///< share of the first correction of the step
        double impulse;  ///< share of the largest
    };
    /// Bodies are found to rounding: their momentum is exact, and forces grow with stiffness.
    static constexpr Limits kBodies{kNearRounding * kRounding, 1, 1};
    /// Inside, what is lacking is made up for in the next step. The last way of the bodies is answered linearly, and errs in
    /// the same sense step after step.
    static constexpr double kLeftInside = 1e-6;
    static constexpr Limits kInside{kLeftInside, kLeftInside, kAgreement};

    /// Slower than this, as kTooSlow of what is inside a network, the matrix is to be formed anew, unless the correction is
    /// near rounding already.
    static constexpr double kSlow = 0.1;

    explicit NewtonConvergence(const Limits& limits) : limits_(limits) {}

    /// Opens a step. least: θ/(1 − θ) that is trusted at best.
    void open(double least = 0);
    /// Takes a pass.
    void take(const dttmm_progress& progress);
    /// After the last pass: whether it is enough; whether another matrix is wanted.
    bool is_done() const { return is_done_; }
    bool is_slow() const { return is_slow_; }
    /// So many passes of the step, from the first on, were not enough.
    int passes_not_done() const { return not_done_; }
    /// Of the last pass; `enough`: with what former passes have shown of rounding.
    const dttmm_progress& progress() const { return last_; }

private:
    void measure(const dttmm_progress& progress);
    bool judge(double rounding);

    Limits limits_;
    Contraction motion_, momentum_;
    dttmm_progress last_{};
    double first_ = 0;               ///< first correction of the step, with the move of the bodies that follows it [m/s]
    double noise_ = 0;               ///< corrections that no longer fell, slowly forgetting [m/s]
    int passes_ = 0, not_done_ = 0;  ///< of the step
    bool is_done_ = false, is_slow_ = false;
};

}  // namespace dttmm::host
