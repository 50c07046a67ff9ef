// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "analysis/advance.h"
#include "analysis/convergence.h"
#include "loader/plugins.h"
#include "model/index.h"
#include "model/model.h"
#include "record/recorder.h"
#include "step/simulation.h"

namespace dttmm::host {

/// One finished run of the sequence and what it is worth. NaN: not known yet.
struct Level {
    double step = 0;  ///< [s]
    uint64_t steps = 0;
    double error = std::numeric_limits<double>::quiet_NaN();  ///< largest estimate over scale of all channels judged
    double order = std::numeric_limits<double>::quiet_NaN();  ///< of the largest difference over scale
    std::string worst;                                        ///< the channel `error` belongs to
};

/// From this ω h on a step does not resolve the fastest vibration: its runs miss it alike, and their difference, small as it
/// is, says little. Estimates are then taken eightfold; the plate on stiff bolts, run at ω h = 2 to 21, needs six
/// (accelerations).
inline constexpr double kUnresolved = 1, kUnresolvedAllowance = 8;

/// A run to a tolerance: the model at its step h, at h/2, h/4, … until the estimated error (convergence.h) of every selected
/// channel, as a share of its scale (error_scale.h), is at most the tolerance. Histories are kept in memory.
class Halving {
public:
    /// channels: of the model; selection: as select_channels gives it. The model must have a tolerance. Model and plugins
    /// must outlive this. Throws Error(resource_limit) when the histories would take more than 2 GiB.
    Halving(const Model& model, const Plugins& plugins, std::span<const Channel> channels, std::vector<int> selection);

    /// What is done with the simulation of every run before it begins.
    void prepare_with(std::function<void(Simulation&)> prepare) { prepare_ = std::move(prepare); }

    /// Runs until the tolerance is reached, and gives up (numerical_failure) after 12 halvings or where the step or the
    /// number of steps would leave the bounds of the model file. A first step at which the run fails (numerical_failure) is
    /// halved up to 4 times. Stopped or failing on the way, it keeps the last finished run, or what the first one has
    /// recorded.
    Ending run(bool quiet);

    /// Takes a row: the values of the selected channels, and as many estimates of their errors, or none.
    using TakeSelected = std::function<void(std::span<const double> values, std::span<const double> errors)>;
    /// All rows, extrapolated where there are estimates.
    void write_to(const TakeSelected& take) const;
    /// Of all channels at the shortest step, those that are not selected too.
    const Recorder& statistics() const { return kept_->statistics; }
    bool has_estimates() const { return convergence_.histories() > 1; }

    double tolerance() const { return *model_.simulation.tolerance; }
    double asked_step() const { return model_.simulation.step; }  ///< the model's [s]
    /// Of the first run that got to its end; the model's where none did [s].
    double first_step() const { return std::ldexp(model_.simulation.step, -as_int(skipped_)); }
    bool reached() const { return !levels_.empty() && levels_.back().error <= tolerance(); }
    const std::vector<Level>& levels() const { return levels_; }
    /// Estimated error per selected channel, the first the time's; empty before two runs have finished.
    const std::vector<double>& estimates() const { return convergence_.estimates(); }
    /// Whether a channel is selected: all others are known at the shortest step alone.
    bool is_selected(int channel) const { return std::ranges::binary_search(selection_, channel); }
    /// Name of a selected channel.
    std::string channel(size_t selected) const;
    /// The run with the shortest step of those kept. After run() only.
    const Simulation& simulation() const { return kept_->simulation; }

private:
    /// One run, in memory.
    struct Run {
        Run(const Model& at_its_step, const Plugins& plugins)
            : model(at_its_step), simulation(model, plugins), statistics(simulation.channels()) {}
        Model model;
        Simulation simulation;
        Recorder statistics;          ///< of all channels
        std::vector<double> history;  ///< of the selected ones
    };
    std::unique_ptr<Run> make_run() const;
    void take_row(Run& run, std::span<const double> row) const;
    void keep(std::unique_ptr<Run> run);
    std::function<void(Simulation&)> prepare_ = [](Simulation&) {};
    void judge();
    bool may_halve() const;
    std::string describe_shortfall() const;

    const Model& model_;
    const Plugins& plugins_;
    std::vector<int> selection_;
    size_t channels_;                                     ///< a digest: every run must have the same
    std::vector<std::pair<size_t, size_t>> quaternions_;  ///< begin and end, in the selection, of each one's components
    Convergence convergence_;
    std::unique_ptr<Run> kept_;
    std::vector<Level> levels_;
    size_t skipped_ = 0;     ///< halvings of the model's step before a run got to its end
    double difference_ = 0;  ///< largest over scale, of the last two runs
};

}  // namespace dttmm::host
