// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "coupling/end_of_step.h"
#include "coupling/equilibrium.h"
#include "coupling/instant.h"
#include "coupling/loads.h"
#include "coupling/networks.h"
#include "coupling/stability.h"
#include "loader/plugins.h"
#include "model/model.h"
#include "model/step_time.h"
#include "record/channels.h"
#include "step/observer.h"
#include "world/world.h"

namespace dttmm::host {

/// How far a body that an element holds has turned in one step.
struct Turning {
    double per_step = 0;  ///< largest so far [rad]
    std::string body;
};

/// A model in motion: the bodies in ODE, the networks in their plugins, and the coupling of both, step by step from t = 0.
/// A row at t_n is known when the step from t_n is done; N rows apart by h take N steps, the last of which ends beyond the
/// last row. The model and the plugins must outlive it.
class Simulation {
public:
    /// What it is for: a machine that only rests has no fastest_mode().
    enum class For : unsigned char { steps, rest };
    /// Throws Error(model_invalid) with the place in the file when a plugin refuses a network.
    Simulation(const Model& model, const Plugins& plugins, For what = For::steps);

    /// Takes one row of numbers, one per channel.
    using RowSink = std::function<void(std::span<const double>)>;
    /// Where rows go; without one nothing is observed.
    void record_to(RowSink sink) {
        sinks_.row = std::move(sink);
        observer_.make_room();
    }
    /// Only these channels of the rows count from now on, by their indices; others may be 0.
    void want(std::span<const int> channels) { observer_.want(channels); }
    /// Takes the report of a step: after it, or when it has failed.
    using TraceSink = std::function<void(const StepReport& report)>;
    void trace_to(TraceSink sink) { sinks_.trace = std::move(sink); }
    std::string waited_for(const StepReport& report) const { return end_of_step_.waited_for(report, networks_); }
    const std::vector<Channel>& channels() const { return observer_.channels(); }
    const std::vector<Limit>& limits() const { return observer_.limits(); }

    /// One time step. Throws Error(numerical_failure) when the motion diverges, naming time, body and ω h.
    void step();

    /// From now on bodies move as predicted and ODE is not asked: for a run whose difference from another counts.
    void leave_ode() { asks_ode_ = false; }
    /// Moves the states of two runs, of models that differ from that of `middle` in numbers only, to equal distances from
    /// its own. All three are at the start of the same step. Throws as Networks::centre() does.
    static void centre(Simulation& above, Simulation& below, const Simulation& middle);

    /// Instead of steps, once: hands on the row of a machine that starts at rest. Nothing moves and ODE is not asked, whose
    /// work grows with the cube of the number of joints in a chain.
    void observe_rest();

    /// Start of the coming step [s], computed from the index, never accumulated.
    double time() const { return time_after(index_, step_size_); }
    uint64_t index() const { return index_; }
    double step_size() const { return step_size_; }
    /// Steps that give a row at the end of the model's duration.
    uint64_t step_count() const;

    /// Bodies at time(), velocities over the step before.
    const std::vector<BodyState>& bodies() const { return now_; }
    const EndOfStep& end_of_step() const { return end_of_step_; }
    /// Of the loads over a step: at its end, its start and one step earlier.
    const double* load_weights() const { return networks_.load_weights(); }
    const FastestMode& fastest_mode() const { return fastest_; }
    /// The fastest turning of a body that elements hold.
    Turning fastest_turning() const;
    /// ω h and what makes it, as messages say it; of an explicit coupling with the part of the dampers in its limit.
    std::string describe_speed() const;
    /// Where it started, if in equilibrium.
    const std::optional<RestState>& rest() const { return rest_; }
    /// Of one that starts in equilibrium, until its first step: what found that.
    Networks& networks() { return networks_; }
    Equilibrium& equilibrium() { return *equilibrium_; }
    /// Of an explicit coupling.
    const std::optional<ExplicitLimit>& explicit_limit() const { return limit_; }

private:
    const Instant& start();
    void refuse_jumps_of_supports() const;
    void refuse_jumps_of_motors();
    void begin_step();
    void move_bodies();
    void observe();
    void refuse_divergence() const;
    void follow_turning();

    const Model& model_;
    double step_size_;
    uint64_t index_ = 0;
    World world_;
    Networks networks_;
    std::vector<BodyState> now_;  ///< at the start of the step
    FastestMode fastest_;         ///< before what the steps need: finding it takes much memory
    Loads loads_;
    Drives drives_;
    EndOfStep end_of_step_;
    InstantSolver instant_;
    std::vector<BodyState> after_;  ///< at the end of the step
    std::optional<RestState> rest_;
    std::unique_ptr<Equilibrium> equilibrium_;  ///< until the first step: it takes memory
    std::optional<ExplicitLimit> limit_;
    Observer observer_;
    struct Sinks {
        RowSink row;
        TraceSink trace;
    };
    Sinks sinks_;
    bool asks_ode_ = true;
    std::vector<BodyState> first_after_;  ///< velocities half a step after the start that have the initial ones as their
                                          ///< mean; where networks do not stand

    /// Of the bodies that an element holds.
    struct FastestTurning {
        std::vector<bool> held;    ///< by an element
        double squared_speed = 0;  ///< [rad²/s²]
        size_t body = 0;
    };
    FastestTurning fastest_turning_;
};

}  // namespace dttmm::host
