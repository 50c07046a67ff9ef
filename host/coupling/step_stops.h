// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

#include "coupling/step_equations.h"
#include "world/body_state.h"
#include "world/joint_system.h"

namespace dttmm::host {

/// The stops of all joints over a step, one per joint: those that act, and what becomes of them while the motion is found.
class StepStops {
public:
    explicit StepStops(size_t joints) : now_(joints), before_(joints), reached_(joints) {}

    /// At t0: the step before the first one begins with the coordinates that these bodies have.
    void start(const StepEquations& equations, const std::vector<BodyState>& at) { equations.place_before_start(at, now_); }
    /// Opens a step: the stops of the step at hand become those of the step before.
    void begin_step();
    /// Takes those reached at t_n. Of those foreseen in the step before, the free motion decides whether they are left.
    void find(const JointSystem& joints, const std::vector<BodyState>& now);
    /// Lets all go; false if none acts.
    bool let_go();
    /// Takes the motion that the stops at hand lead to; end: poses at its end, velocities over it. True if a stop lets go,
    /// is left or is added, so that the motion is another one.
    bool change(const StepEquations& equations, const std::vector<BodyState>& end);
    /// Takes the step, whose motion is found, into the counts. time: of its start [s].
    void count(double time);

    const std::vector<Stop>& now() const { return now_; }
    const std::vector<Stop>& before() const { return before_; }
    long number() const { return std::ranges::count_if(now_, &Stop::acts); }

    /// Steps in which a stop was struck and so made another one let go that had been struck less than two steps before. What
    /// that one had still to take is lost. Of the first: its time [s], and the joint that was struck last.
    struct LostImpacts {
        long steps = 0;
        double time = 0;
        size_t joint = 0;
    };
    const LostImpacts& lost_impacts() const { return lost_; }
    /// Steps in which a stop is struck, and another one in the same step or in the one before.
    long close_impacts() const { return close_impacts_; }

private:
    bool release_pulling(const StepEquations& equations);
    bool leave(const StepEquations& equations, const std::vector<BodyState>& end);
    long struck() const { return std::ranges::count_if(now_, &Stop::is_struck); }

    std::vector<Stop> now_;        ///< that act over the open step
    std::vector<Stop> before_;     ///< that acted over the step before
    std::vector<Stop> reached_;    ///< at t_n
    bool may_leave_ = true;        ///< over the open step
    bool lets_go_struck_ = false;  ///< over the open step: a stop that was reached within it
    LostImpacts lost_;
    long close_impacts_ = 0;
};

}  // namespace dttmm::host
