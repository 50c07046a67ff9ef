// SPDX-License-Identifier: BSD-3-Clause
#include "identify/diagnosis.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>

#include "identify/forked_map.h"
#include "identify/verdict.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr double kLowestFactor = 0.01, kHighestFactor = 100;  // of a suspect
constexpr size_t kFewestFitted = 3;                           // suspects that promise most
constexpr double kPromising = 0.5;                            // share of the best promise: nearer ones are fitted too
constexpr double kDoubtful = 0.05;  // chance of a chi2 as large with the noise that was assumed: pairs are tried below it
constexpr size_t kMostPaired = 8;   // suspects that pairs are made of
constexpr size_t kMostPairs = 6;    // pairs that are fitted
constexpr double kUnseen = 1e-6;    // share of the strongest fault's effect

Unknown factor_of(Unknown::Of of, const std::string& element) {
    Unknown unknown{
        of, element + (of == Unknown::Of::stiffness ? ".stiffness" : ".damping"), "1", 1, kLowestFactor, kHighestFactor};
    unknown.element = element;
    return unknown;
}

/// What of the columns is not a mixture of the basis.
Eigen::MatrixXd without(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& basis) {
    if (basis.cols() == 0) return columns;
    return columns - basis * basis.colPivHouseholderQr().solve(columns);
}

}  // namespace

Diagnostician::Diagnostician(Comparison& comparison, const Unknowns& common, std::vector<std::string> suspects,
                             std::vector<bool> are_damped, int jobs)
    : comparison_(comparison),
      common_(common),
      suspects_(std::move(suspects)),
      are_damped_(std::move(are_damped)),
      jobs_(jobs) {}

/// The common unknowns first. Elements that change alike share a factor.
Unknowns Diagnostician::unknowns_of(const Hypothesis& hypothesis, bool with_damping) const {
    Unknowns unknowns = common_;
    for (const std::string& element : hypothesis.elements) {
        Unknown stiffness = factor_of(Unknown::Of::stiffness, element);
        if (hypothesis.are_alike) stiffness.shared = hypothesis.elements;
        unknowns.add(stiffness);
        if (hypothesis.are_alike) break;
    }
    std::vector<std::string> damped;
    for (const std::string& element : hypothesis.elements)
        if (are_damped_[as_size(std::ranges::find(suspects_, element) - suspects_.begin())]) damped.push_back(element);
    for (const std::string& element : damped) {
        if (!with_damping) break;
        Unknown damping = factor_of(Unknown::Of::damping, element);
        if (hypothesis.are_alike) damping.shared = damped;
        unknowns.add(damping);
        if (hypothesis.are_alike) break;
    }
    return unknowns;
}

/// Schwarz' criterion: chi2 where the noise is known, N ln(sum of squares/N) where it is not.
double Diagnostician::score(const Eigen::VectorXd& predicted, size_t unknowns) const {
    double score = static_cast<double>(unknowns) * std::log(static_cast<double>(comparison_.rows()));
    const Eigen::VectorXd residual = comparison_.residual(predicted, false);
    for (const DataGroup& group : comparison_.groups()) {
        const double squares = residual.segment(group.first, group.count).squaredNorm();
        const auto count = static_cast<double>(group.count);
        constexpr double kLeast = 1e-18;  // of squares per noise: data that the model made itself
        if (group.noise_from == DataGroup::NoiseFrom::residuals)
            score += count * std::log(std::max(squares / count, kLeast) * group.noise * group.noise);
        else
            score += squares;
    }
    return score;
}

/// From the coordinates and predictions of a trial what its hypothesis is, and how good.
void Diagnostician::take_factors(Trial& trial) const {
    trial.hypothesis.chi2 = comparison_.residual(trial.predicted, false).squaredNorm();
    trial.hypothesis.score = score(trial.predicted, trial.unknowns.size());
    for (size_t i = common_.size(); i < trial.unknowns.size(); ++i) {
        const double value = trial.unknowns[i].value(trial.x(as_row(i)));
        if (trial.unknowns[i].of == Unknown::Of::stiffness)
            trial.hypothesis.factors.push_back(value);
        else
            trial.hypothesis.damping = value;
    }
}

Diagnostician::Trial Diagnostician::fit(Hypothesis hypothesis, bool with_damping, const Eigen::VectorXd& common) const {
    Trial trial{std::move(hypothesis), {}, {}, {}};
    trial.unknowns = unknowns_of(trial.hypothesis, with_damping);
    Eigen::VectorXd start = trial.unknowns.start();
    start.head(common.size()) = common;
    const Identifier identifier(comparison_, trial.unknowns, {}, 1);
    trial.x = trial.unknowns.size() > 0 ? identifier.descend(start).x : start;
    trial.predicted = comparison_.predict(trial.unknowns, trial.x);
    take_factors(trial);
    return trial;
}

/// Each with its stiffness alone, and with its damping too: the better one counts.
std::vector<Diagnostician::Trial> Diagnostician::fit_all(const std::vector<Hypothesis>& hypotheses,
                                                         const Eigen::VectorXd& common) const {
    const auto make = [&](size_t task) { return fit(hypotheses[task / 2], task % 2 == 1, common); };
    const std::vector<TaskResult> results = map_in_processes(2 * hypotheses.size(), jobs_, [&](size_t task) {
        const Trial trial = make(task);
        std::vector<double> numbers = {trial.hypothesis.score};
        numbers.insert(numbers.end(), trial.x.begin(), trial.x.end());
        return numbers;
    });
    std::vector<Trial> trials;
    for (size_t h = 0; h < hypotheses.size(); ++h) {
        const TaskResult &plain = results[2 * h], &damped = results[2 * h + 1];
        if (plain.numbers.empty() && damped.numbers.empty()) continue;
        const bool is_damped = plain.numbers.empty() || (!damped.numbers.empty() && damped.numbers[0] < plain.numbers[0]);
        const std::vector<double>& numbers = is_damped ? damped.numbers : plain.numbers;
        Trial trial{hypotheses[h], unknowns_of(hypotheses[h], is_damped), {}, {}};
        trial.x = Eigen::Map<const Eigen::VectorXd>(numbers.data() + 1, as_row(numbers.size() - 1));
        trial.predicted = comparison_.predict(trial.unknowns, trial.x);
        take_factors(trial);
        trials.push_back(std::move(trial));
    }
    std::ranges::stable_sort(trials, [](const Trial& a, const Trial& b) { return a.hypothesis.score < b.hypothesis.score; });
    return trials;
}

/// What each fault does to the data where nothing has changed, by one-sided differences: as many runs as numbers.
void Diagnostician::find_slopes(const Trial& null) {
    Hypothesis all;
    all.elements = suspects_;
    const Unknowns unknowns = unknowns_of(all, true);
    Eigen::VectorXd x = unknowns.start();
    x.head(null.x.size()) = null.x;
    const std::vector<TaskResult> results = map_in_processes(unknowns.size(), jobs_, [&](size_t task) {
        Eigen::VectorXd at = x;
        at(as_row(task)) += kDifference;
        const Eigen::VectorXd predicted = comparison_.predict(unknowns, at);
        return std::vector<double>(predicted.begin(), predicted.end());
    });
    changes_.resize(comparison_.rows(), as_row(unknowns.size()));
    for (size_t i = 0; i < results.size(); ++i) {
        if (!results[i].reason.empty())
            throw Error(ExitCode::numerical_failure,
                        fmt::format("with {} changed by 1 %: {}", unknowns[i].name, results[i].reason));
        const Eigen::Map<const Eigen::VectorXd> predicted(results[i].numbers.data(), comparison_.rows());
        changes_.col(as_row(i)) = (predicted - null.predicted) / kDifference;
    }
}

/// The same per standard deviation of the data, without what the common unknowns do.
void Diagnostician::scale_slopes() {
    const Eigen::MatrixXd scaled = comparison_.deviations().cwiseInverse().asDiagonal() * changes_;
    const auto count = as_row(common_.size());
    slopes_ = without(scaled.rightCols(scaled.cols() - count), scaled.leftCols(count));
}

/// How far chi2 would fall by stiffness and damping of these suspects if all were linear.
double Diagnostician::gain(const std::vector<size_t>& suspects, const Eigen::VectorXd& residual) const {
    std::vector<Eigen::Index> columns;
    for (const size_t s : suspects) {
        columns.push_back(as_row(s));
        if (!are_damped_[s]) continue;
        columns.push_back(as_row(suspects_.size()) + std::count(are_damped_.begin(), are_damped_.begin() + as_row(s), true));
    }
    Eigen::MatrixXd own(slopes_.rows(), as_row(columns.size()));
    for (size_t c = 0; c < columns.size(); ++c) own.col(as_row(c)) = slopes_.col(columns[c]);
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
    qr.setThreshold(kUnseen);
    qr.compute(own);
    return residual.squaredNorm() - (residual - own * qr.solve(residual)).squaredNorm();
}

std::vector<Hypothesis> Diagnostician::promising_singles(const Eigen::VectorXd& residual) const {
    std::vector<size_t> order(suspects_.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::vector<double> gains;
    for (size_t s = 0; s < suspects_.size(); ++s) gains.push_back(gain({s}, residual));
    std::ranges::stable_sort(order, [&](size_t a, size_t b) { return gains[a] > gains[b]; });
    std::vector<Hypothesis> chosen;
    for (size_t i = 0; i < order.size(); ++i)
        if (i < kFewestFitted || gains[order[i]] > kPromising * gains[order[0]]) chosen.push_back({{suspects_[order[i]]}});
    if (suspects_.size() > 1) {
        Hypothesis alike;
        alike.elements = suspects_;
        alike.are_alike = true;
        chosen.push_back(alike);
    }
    return chosen;
}

std::vector<Hypothesis> Diagnostician::promising_pairs(const Eigen::VectorXd& residual) const {
    std::vector<size_t> order(suspects_.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::vector<double> gains;
    for (size_t s = 0; s < suspects_.size(); ++s) gains.push_back(gain({s}, residual));
    std::ranges::stable_sort(order, [&](size_t a, size_t b) { return gains[a] > gains[b]; });
    order.resize(std::min(order.size(), kMostPaired));
    struct Pair {
        size_t a, b;
        double gain;
    };
    std::vector<Pair> pairs;
    for (size_t i = 0; i < order.size(); ++i)
        for (size_t j = i + 1; j < order.size(); ++j)
            pairs.push_back(
                {std::min(order[i], order[j]), std::max(order[i], order[j]), gain({order[i], order[j]}, residual)});
    std::ranges::stable_sort(pairs, std::ranges::greater(), &Pair::gain);
    pairs.resize(std::min(pairs.size(), kMostPairs));
    std::vector<Hypothesis> chosen;
    for (const Pair& pair : pairs) chosen.push_back({{suspects_[pair.a], suspects_[pair.b]}});
    return chosen;
}

void Diagnostician::find_limits(Diagnosis& diagnosis) const {
    const auto count = as_row(suspects_.size());
    double strongest = 0;
    for (Eigen::Index s = 0; s < count; ++s) strongest = std::max(strongest, slopes_.col(s).norm());
    const double needed = kDistinct + std::log(static_cast<double>(comparison_.rows()));
    std::vector<bool> is_done(suspects_.size(), false);
    for (Eigen::Index s = 0; s < count; ++s) {
        const double norm = slopes_.col(s).norm();
        if (!(norm > kUnseen * strongest)) {
            diagnosis.unseen.push_back(suspects_[as_size(s)]);
            continue;
        }
        diagnosis.least_seen = std::max(diagnosis.least_seen, 1 - std::exp(-std::sqrt(needed) / norm));
        if (is_done[as_size(s)]) continue;
        std::vector<std::string> alike = {suspects_[as_size(s)]};
        for (Eigen::Index t = s + 1; t < count; ++t) {
            const double other = slopes_.col(t).norm();
            if (!(other > kUnseen * strongest) || is_done[as_size(t)]) continue;
            if (std::abs(slopes_.col(s).dot(slopes_.col(t))) < kTied * norm * other) continue;
            is_done[as_size(t)] = true;
            alike.push_back(suspects_[as_size(t)]);
        }
        if (alike.size() > 1) diagnosis.ties.push_back(alike);
    }
}

void Diagnostician::add_intervals(Trial& trial) const {
    const Identifier identifier(comparison_, trial.unknowns, {}, jobs_);
    const Solution solution = identifier.polish(trial.x);
    Hypothesis& own = trial.hypothesis;
    own.factors.clear();
    for (size_t i = common_.size(); i < trial.unknowns.size(); ++i) {
        const Unknown& one = trial.unknowns[i];
        if (one.of != Unknown::Of::stiffness) continue;
        own.factors.push_back(one.value(solution.x(as_row(i))));
        const auto limit = [&](const std::optional<double>& at) {
            return at ? std::optional(one.value(*at)) : std::nullopt;
        };
        own.low.push_back(limit(solution.low[i]));
        own.high.push_back(limit(solution.high[i]));
    }
}

/// Again, where the noise is known better now.
void Diagnostician::refit(Trial& trial) const {
    if (trial.unknowns.size() > 0) trial.x = Identifier(comparison_, trial.unknowns, {}, jobs_).descend(trial.x).x;
    trial.predicted = comparison_.predict(trial.unknowns, trial.x);
    trial.hypothesis.factors.clear();
    take_factors(trial);
}

Diagnosis Diagnostician::diagnose() {
    Diagnosis diagnosis;
    const auto by_score = [](const Trial& a, const Trial& b) { return a.hypothesis.score < b.hypothesis.score; };
    Trial null = fit({}, false, common_.start());
    comparison_.estimate_noise(null.predicted, common_.size());
    find_slopes(null);
    scale_slopes();
    const auto residual_of_null = [&] { return Eigen::VectorXd(-comparison_.residual(null.predicted, false)); };
    std::vector<Trial> trials = fit_all(promising_singles(residual_of_null()), null.x);
    if (trials.empty()) throw Error(ExitCode::numerical_failure, "the model has no answer with any of the suspects changed");
    const auto judge_best = [&] {
        return Identifier(comparison_, trials.front().unknowns, {}, jobs_).judge(trials.front().x);
    };
    // With the noise that the best explanation leaves, those near it are fitted again
    const auto sharpen = [&] {
        const Trial& best = trials.front().hypothesis.score < null.hypothesis.score ? trials.front() : null;
        comparison_.estimate_noise(best.predicted, best.unknowns.size());
        refit(null);
        for (size_t i = 0; i < std::min(kFewestFitted, trials.size()); ++i) refit(trials[i]);
        for (Trial& one : trials) one.hypothesis.score = score(one.predicted, one.unknowns.size());
        std::ranges::stable_sort(trials, by_score);
        scale_slopes();
    };
    sharpen();
    const Fit single = judge_best();
    const bool is_doubtful = !single.is_explained() || (single.is_noise_assumed && single.chance < kDoubtful);
    if (suspects_.size() > 1 && (is_doubtful || suspects_.size() == 2)) {
        for (Trial& pair : fit_all(promising_pairs(residual_of_null()), null.x)) trials.push_back(std::move(pair));
        std::ranges::stable_sort(trials, by_score);
        sharpen();
    }
    const auto rejudge = [&](Trial& one) {
        one.hypothesis.chi2 = comparison_.residual(one.predicted, false).squaredNorm();
        one.hypothesis.score = score(one.predicted, one.unknowns.size());
    };
    rejudge(null);
    std::ranges::for_each(trials, rejudge);
    diagnosis.unchanged = null.hypothesis;
    std::ranges::stable_sort(trials, by_score);
    find_limits(diagnosis);
    diagnosis.best_score = std::min(trials.front().hypothesis.score, diagnosis.unchanged.score);
    const bool is_seen = diagnosis.unchanged.score - trials.front().hypothesis.score > kDistinct;
    diagnosis.fit = is_seen ? judge_best() : Identifier(comparison_, null.unknowns, {}, jobs_).judge(null.x);
    if (comparison_.has_histories()) {
        const Trial& best = is_seen ? trials.front() : null;
        Solution at;
        const Identifier identifier(comparison_, best.unknowns, {}, jobs_);
        if (best.unknowns.size() > 0) {
            at = identifier.describe(best.x);
            diagnosis.step = describe_step(identifier.find_step_bias(at), at, best.unknowns, comparison_.time_step());
        }
    }
    for (Trial& one : trials) {
        const bool is_candidate = is_seen && one.hypothesis.score - trials.front().hypothesis.score < kDistinct;
        if (is_candidate) add_intervals(one);
        (is_candidate ? diagnosis.candidates : diagnosis.others).push_back(one.hypothesis);
    }
    return diagnosis;
}

}  // namespace dttmm::host
