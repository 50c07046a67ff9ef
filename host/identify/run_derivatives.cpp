// SPDX-License-Identifier: BSD-3-Clause
#include "identify/run_derivatives.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <random>
#include <span>
#include <thread>
#include <vector>

#include "analysis/session.h"
#include "analysis/stop_signals.h"
#include "identify/figure_slopes.h"
#include "identify/forked_map.h"
#include "model/error.h"
#include "model/index.h"
#include "study/figures.h"

namespace dttmm::host {

namespace {

/// Pairs in one process, beside one run: that run is a ninth of the work, and memory stays small.
constexpr size_t kPairsAtOnce = 4;

/// Distances of neighbours that are tried, as shares of parameters. The error of a smaller one is smaller by the square,
/// that by rounding is larger: of the examples' models the best are from 3e-4 (stiff bolts) to 3e-7 (a fast linkage).
constexpr std::array kDistances = {1e-3, 1e-4, 1e-5, 1e-6, 1e-7};

/// A run beside another one, and what figures watch of its last row.
class Neighbour {
public:
    Neighbour(Model model, const Plugins& plugins, const std::vector<std::string>& wanted)
        : model_(std::move(model)),
          simulation_(model_, plugins),
          figures_(wanted, simulation_.channels(), std::nullopt),
          watched_(figures_.watched_count()) {
        simulation_.want(figures_.places());
        simulation_.leave_ode();
        simulation_.record_to([this](std::span<const double> row) { figures_.read(row, watched_); });
    }
    Simulation& simulation() { return simulation_; }
    const std::vector<double>& watched() const { return watched_; }

private:
    Model model_;
    Simulation simulation_;
    HistoryFigures figures_;
    std::vector<double> watched_;
};

/// How a pair differs from the run: by these shares of the distance, of every parameter.
struct Direction {
    Eigen::VectorXd shares;
    double distance;
};

class RunWithPairs {
public:
    RunWithPairs(const FigureFunction& function, std::span<const Direction> directions)
        : function_(function),
          session_(function.plan().request),
          figures_(function.plan().figures, session_.simulation.channels(), std::nullopt),
          slopes_(figures_, as_row(directions.size())),
          row_slopes_(as_row(figures_.watched_count()), as_row(directions.size())) {
        if (session_.halving) throw Error(ExitCode::usage, "a run to a tolerance is of several time steps");
        session_.refuse_unstable(function.plan().request.run.force);
        for (const Direction& one : directions)
            pairs_.push_back({make(one.shares * one.distance), make(-one.shares * one.distance), one.distance});
        session_.simulation.record_to([this](std::span<const double> row) {
            row_.assign(row.begin(), row.end());
            has_row_ = true;
        });
    }

    void centre() {
        for (Pair& pair : pairs_)
            Simulation::centre(pair.above->simulation(), pair.below->simulation(), session_.simulation);
    }

    /// Figures of the run, their slopes by every direction, their errors, and of competing extremes slope, reach and
    /// instant, each figure after figure.
    std::vector<double> differentiate() {
        centre();
        const uint64_t count = session_.simulation.step_count();
        while (session_.simulation.index() < count) {
            if (StopSignals::requested()) throw Error(StopSignals::exit_code(), StopSignals::reason());
            session_.simulation.step();
            for (Pair& pair : pairs_)
                for (Neighbour* one : {pair.above.get(), pair.below.get()}) one->simulation().step();
            if (has_row_) take_row();
            centre();
        }
        std::vector<double> numbers;
        const std::vector<double> values = figures_.values();
        for (size_t f = 0; f < values.size(); ++f) {
            const FigureSlopes::Found found = slopes_.find(f);
            numbers.push_back(values[f]);
            numbers.push_back(found.competing_time);
            for (const Eigen::RowVectorXd* list : {&found.slope, &found.error, &found.competing, &found.reach})
                numbers.insert(numbers.end(), list->begin(), list->end());
        }
        return numbers;
    }

private:
    struct Pair {
        std::unique_ptr<Neighbour> above, below;
        double distance;
    };
    std::unique_ptr<Neighbour> make(const Eigen::VectorXd& change) const {
        const Request request =
            function_.request_at(function_.nominal().cwiseProduct(Eigen::VectorXd::Ones(change.size()) + change));
        Model model = read_model(request.model, session_.plugins.catalogue(), request.overrides);
        const SimulationSettings& wanted = session_.model.simulation;
        const bool has_step = model.simulation.step > 0;  // else it is chosen, of each model another one
        if ((has_step && model.simulation.step != wanted.step) || model.simulation.duration != wanted.duration)
            throw Error(ExitCode::usage, "the time step or the duration changes with a parameter");
        model.simulation.step = wanted.step;
        model.output.every = session_.model.output.every;
        auto neighbour = std::make_unique<Neighbour>(std::move(model), session_.plugins, function_.plan().figures);
        refuse_other_equilibrium(neighbour->simulation());
        return neighbour;
    }
    /// A machine may come to rest in several positions: of another one the run beside it says nothing.
    void refuse_other_equilibrium(const Simulation& other) const {
        constexpr double kOther = 1e-2;  // of the size of the machine, and rad: a thousandth of a parameter leads less far
        if (!session_.model.simulation.starts_at_rest) return;
        const std::vector<BodyState>&own = session_.simulation.bodies(), &its = other.bodies();
        double size = 0, shift = 0, turn = 0;
        for (size_t b = 0; b < own.size(); ++b) {
            const Body& body = session_.model.bodies[b];
            size = std::max(size, (own[b].position - own[0].position).norm());
            for (const Marker& marker : body.markers) size = std::max(size, (marker.position - body.center_of_mass).norm());
            shift = std::max(shift, (its[b].position - own[b].position).norm());
            turn = std::max(turn, (its[b].rotation - own[b].rotation).norm());
        }
        if ((size > 0 && shift > kOther * size) || turn > kOther)
            throw Error(ExitCode::numerical_failure,
                        "after a small change of a parameter it starts from another equilibrium");
    }
    void take_row() {
        for (size_t p = 0; p < pairs_.size(); ++p)
            for (size_t w = 0; w < figures_.watched_count(); ++w)
                row_slopes_(as_row(w), as_row(p)) =
                    (pairs_[p].above->watched()[w] - pairs_[p].below->watched()[w]) / (2 * pairs_[p].distance);
        watched_.resize(figures_.watched_count());
        figures_.read(row_, watched_);
        figures_.take_row(row_);
        slopes_.take_row(row_.front(), watched_, row_slopes_);
        has_row_ = false;
    }

    const FigureFunction& function_;
    Session session_;
    HistoryFigures figures_;
    FigureSlopes slopes_;
    std::vector<Pair> pairs_;
    std::vector<double> row_, watched_;
    Eigen::MatrixXd row_slopes_;
    bool has_row_ = false;
};

/// Figures of a run and how they change in some directions, a column each.
struct Slopes {
    Eigen::VectorXd figures, competing_at;
    Eigen::MatrixXd slopes, error, competing, reach;
};

/// Nothing where a neighbour fails, with the reason.
std::optional<Slopes> differentiate(const FigureFunction& function, std::span<const Direction> directions, int jobs,
                                    std::string& reason) {
    const auto divided = [](size_t whole, size_t by) { return (whole + by - 1) / by; };
    const size_t workers = jobs > 0 ? as_size(jobs) : std::max(1u, std::thread::hardware_concurrency());
    const size_t at_once = std::min(kPairsAtOnce, divided(directions.size(), workers));
    const std::vector<TaskResult> results = map_in_processes(divided(directions.size(), at_once), jobs, [&](size_t task) {
        const size_t first = task * at_once;
        const auto own = directions.subspan(first, std::min(at_once, directions.size() - first));
        return RunWithPairs(function, own).differentiate();
    });
    reason = first_reason(results);
    if (!reason.empty()) return std::nullopt;
    const auto count = as_row(function.figures().size());
    Slopes all;
    for (Eigen::MatrixXd* list : {&all.slopes, &all.error, &all.competing, &all.reach})
        list->resize(count, as_row(directions.size()));
    Eigen::Index column = 0;
    for (const TaskResult& result : results) {
        const Eigen::Index numbers = as_row(result.numbers.size()) / count, own = (numbers - 2) / 4;
        const Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> table(
            result.numbers.data(), count, numbers);
        all.figures = table.col(0);
        all.competing_at = table.col(1);
        Eigen::Index from = 2;
        for (Eigen::MatrixXd* list : {&all.slopes, &all.error, &all.competing, &all.reach}) {
            list->middleCols(column, own) = table.middleCols(from, own);
            from += own;
        }
        column += own;
    }
    return all;
}

/// By slopes at all distances, a column each: the two next to each other whose slopes differ least, the first of them. A
/// figure that is nothing but rounding, or not a number, differs wholly at all of them.
Eigen::Index find_best(const Eigen::MatrixXd& slopes) {
    Eigen::Index best = 0;
    double least = std::numeric_limits<double>::infinity();
    for (Eigen::Index k = 0; k + 1 < slopes.cols(); ++k) {
        double sum = 0;
        for (Eigen::Index f = 0; f < slopes.rows(); ++f) {
            const double size = std::max(std::abs(slopes(f, k)), std::abs(slopes(f, k + 1)));
            const double difference = std::abs(slopes(f, k) - slopes(f, k + 1));
            if (!(difference == 0)) sum += difference <= size ? difference / size : 1;
        }
        if (sum >= least) continue;
        least = sum;
        best = k;
    }
    return best;
}

/// All parameters at once, up or down by chance, so that what is symmetric does not cancel.
Eigen::VectorXd choose_signs(Eigen::Index count) {
    std::mt19937 chance(1);
    Eigen::VectorXd signs(count);
    for (double& sign : signs) sign = chance() % 2 ? 1 : -1;
    return signs;
}

}  // namespace

bool differentiate_run(const FigureFunction& function, int jobs, LocalSensitivity& found, std::string& reason) {
    const Eigen::Index count = function.nominal().size();
    const Eigen::VectorXd signs = choose_signs(count);
    std::vector<Direction> directions;
    for (const double distance : kDistances) directions.push_back({signs, distance});
    try {  // what the networks refuse shows before the first step
        RunWithPairs(function, std::span(directions).first(1)).centre();
    } catch (const Error& error) {
        reason = error.what();
        return false;
    }
    const std::optional<Slopes> together = differentiate(function, directions, jobs, reason);
    if (!together) return false;
    const Eigen::Index best = find_best(together->slopes);
    const double distance = std::sqrt(kDistances[as_size(best)] * kDistances[as_size(best) + 1]);
    directions.clear();
    for (Eigen::Index p = 0; p < count; ++p) directions.push_back({Eigen::VectorXd::Unit(count, p), distance});
    const std::optional<Slopes> own = differentiate(function, directions, jobs, reason);
    if (!own) return false;
    const Eigen::VectorXd sum = own->slopes * signs;
    const Eigen::VectorXd mismatch = (together->slopes.middleCols(best, 2).colwise() - sum).cwiseAbs().rowwise().maxCoeff();
    found = {own->figures,      own->slopes,    own->error + mismatch.replicate(1, count),
             own->competing_at, own->competing, own->reach};
    return true;
}

}  // namespace dttmm::host
