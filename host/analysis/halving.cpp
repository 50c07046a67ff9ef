// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/halving.h"

#include <fmt/format.h>
#include <bit>
#include <functional>

#include <algorithm>
#include <cmath>
#include <utility>

#include "analysis/error_scale.h"
#include "analysis/stop_signals.h"
#include "model/index.h"
#include "model/read_simulation.h"

namespace dttmm::host {

namespace {

constexpr size_t kMostHalvings = 12, kMostSkipped = 4;
constexpr double kMostBytes = 2.0 * 1024 * 1024 * 1024;
constexpr double kHistoriesHeld = 5;  // four that are judged and the one that is running

/// The model k halvings on; its rows stay where they were.
Model at_level(const Model& model, size_t k) {
    Model finer = model;
    finer.simulation.step = std::ldexp(model.simulation.step, -as_int(k));
    finer.output.every = model.output.every << k;
    return finer;
}

double rows_of(const Model& model) {
    return std::round(model.simulation.duration / model.simulation.step / model.output.every) + 1;
}

size_t digest_of(std::span<const Channel> channels) {
    size_t digest = channels.size();
    for (const Channel& channel : channels) digest = std::rotl(digest, 1) ^ std::hash<std::string>{}(channel.name());
    return digest;
}

}  // namespace

Halving::Halving(const Model& model, const Plugins& plugins, std::span<const Channel> channels, std::vector<int> selection)
    : model_(model),
      plugins_(plugins),
      selection_(std::move(selection)),
      channels_(digest_of(channels)),
      convergence_(selection_.size()) {
    const double bytes = kHistoriesHeld * rows_of(model) * static_cast<double>(selection_.size()) * sizeof(double);
    if (bytes > kMostBytes)
        throw Error(ExitCode::resource_limit,
                    fmt::format("a run to a tolerance holds {:g} histories in memory: {:.3g} rows of {} channels are {:.3g} "
                                "GiB, more than 2 GiB; give [output] a longer step or fewer channels",
                                kHistoriesHeld, rows_of(model), selection_.size(), bytes / kMostBytes * 2));
}

Ending Halving::run(bool quiet) {
    Outcome total;
    const auto advance = [&](Run& run) {
        Ending ending = advance_to_end(run.simulation, quiet);
        ending.outcome.wall_time = total.wall_time += ending.outcome.wall_time;
        ending.outcome.steps = total.steps += ending.outcome.steps;
        if (ending.code != ExitCode::ok)
            ending.outcome.reason += fmt::format(" (in the run at a step of {:g} s)", run.simulation.step_size());
        return ending;
    };
    std::unique_ptr<Run> run = make_run();
    Ending ending = advance(*run);
    // A step too long for its motion to be found; if no shorter one does better, the first failure is the one to tell
    while (ending.code == ExitCode::numerical_failure && skipped_ < kMostSkipped && may_halve()) {
        ++skipped_;
        std::unique_ptr<Run> shorter = make_run();
        const Ending next = advance(*shorter);
        if (next.code == ExitCode::numerical_failure) continue;
        run = std::move(shorter);
        ending = next;
    }
    if (ending.code == ExitCode::numerical_failure) skipped_ = 0;
    while (ending.code == ExitCode::ok) {
        keep(std::move(run));
        judge();
        if (reached()) return ending;
        if (!may_halve()) {
            ending.outcome.status = "failed";
            ending.outcome.reason = describe_shortfall();
            ending.code = ExitCode::numerical_failure;
            return ending;
        }
        try {
            run = make_run();
        } catch (const Error& error) {
            if (!StopSignals::requested()) throw;
            ending.outcome.status = "stopped";
            ending.outcome.reason = error.what();
            ending.code = error.code();
            break;
        }
        ending = advance(*run);
    }
    ending.outcome.wall_time = total.wall_time;
    ending.outcome.steps = total.steps;
    if (!kept_) keep(std::move(run));
    return ending;
}

std::unique_ptr<Halving::Run> Halving::make_run() const {
    auto run = std::make_unique<Run>(at_level(model_, skipped_ + levels_.size()), plugins_);
    if (digest_of(run->simulation.channels()) != channels_)
        throw Error(ExitCode::plugin_failure, "a plugin declares other channels when it is given the same model again");
    prepare_(run->simulation);
    run->history.reserve(static_cast<size_t>(rows_of(model_)) * selection_.size());
    run->simulation.record_to([this, &to = *run](std::span<const double> row) { take_row(to, row); });
    return run;
}

void Halving::take_row(Run& run, std::span<const double> row) const {
    run.statistics.close_row(row);
    const size_t begin = run.history.size();
    for (const int channel : selection_) run.history.push_back(row[as_size(channel)]);
    if (!kept_) return;
    // q and −q are one rotation; which of them a row has may change from run to run, and then their difference means
    // nothing.
    const std::span<const double> before = convergence_.newest_row(begin / selection_.size());
    for (const auto& [first, end] : quaternions_) {
        double product = 0;
        for (size_t i = first; i < end; ++i) product += before[i] * run.history[begin + i];
        for (size_t i = first; i < end && product < 0; ++i) run.history[begin + i] *= -1;
    }
}

void Halving::keep(std::unique_ptr<Run> run) {
    kept_ = std::move(run);
    const Simulation& simulation = kept_->simulation;
    const bool resolved = simulation.fastest_mode().omega * simulation.step_size() <= kUnresolved;
    convergence_.add(std::move(kept_->history), resolved ? 1 : kUnresolvedAllowance);
    if (!quaternions_.empty() || convergence_.histories() > 1) return;
    constexpr std::string_view kQuaternion = ".quaternion.";
    const auto owner = [&](size_t i) {
        const size_t at = channel(i).find(kQuaternion);
        return at == std::string::npos ? std::string() : channel(i).substr(0, at);
    };
    for (size_t i = 0, end; i < selection_.size(); i = end) {
        for (end = i + 1; end < selection_.size() && owner(end) == owner(i);) ++end;
        if (!owner(i).empty()) quaternions_.emplace_back(i, end);
    }
}

void Halving::judge() {
    Level level;
    level.step = kept_->simulation.step_size();
    level.steps = std::max<uint64_t>(kept_->simulation.index(), 1) - 1;
    if (convergence_.histories() > 1) {
        const std::vector<double> scales =
            error_scales(model_, kept_->simulation.fastest_mode(), kept_->statistics, level.step);
        const double difference_before = std::exchange(difference_, 0);
        level.error = 0;
        for (size_t i = 1; i < selection_.size(); ++i) {
            const double estimate = convergence_.estimates()[i];
            if (estimate == 0) continue;  // its kind may be zero altogether
            const double scale = scales[as_size(selection_[i])];
            difference_ = std::max(difference_, convergence_.differences()[i] / scale);
            if (estimate / scale < level.error) continue;
            level.error = estimate / scale;
            level.worst = channel(i);
        }
        level.order = observed_order(difference_before, difference_);
    }
    levels_.push_back(level);
}

bool Halving::may_halve() const {
    const auto next = as_int(skipped_ + std::max<size_t>(levels_.size(), 1));
    const double halvings = std::ldexp(1, next);
    const double step = model_.simulation.step / halvings;
    return levels_.size() <= kMostHalvings && step >= kShortestStep && model_.simulation.duration / step <= kMostSteps &&
           model_.output.every * halvings < std::numeric_limits<int>::max();
}

std::string Halving::describe_shortfall() const {
    const Level& last = levels_.back();
    const std::string reached =
        std::isnan(last.error)
            ? ""
            : fmt::format(
                  ": the error of channel \"{}\" is estimated at {:.3g} % of the largest value of its kind, observed "
                  "order {:.2f}",
                  last.worst, 100 * last.error, last.order);
    return fmt::format(
        "the tolerance of {:g} % is not reached after {} halvings, at a step of {:g} s{}; ask for less, or for the channels "
        "that matter only (--channels); give stiff parts damping, make the loads smoother, or begin with a shorter step",
        100 * tolerance(), levels_.size() - 1, last.step, reached);
}

void Halving::write_to(const TakeSelected& take) const {
    std::vector<double> values(selection_.size()), estimates(has_estimates() ? selection_.size() : 0);
    for (size_t row = 0; row < convergence_.rows(); ++row) {
        if (has_estimates())
            convergence_.evaluate_row(row, values, estimates);
        else
            std::ranges::copy(convergence_.newest_row(row), values.begin());
        take(values, estimates);
    }
}

std::string Halving::channel(size_t selected) const {
    return kept_->simulation.channels()[as_size(selection_[selected])].name();
}

}  // namespace dttmm::host
