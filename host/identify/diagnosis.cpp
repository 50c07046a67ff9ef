// SPDX-License-Identifier: BSD-3-Clause
#include "identify/diagnosis.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "identify/forked_map.h"
#include "identify/verdict.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr double kLowestFactor = 0.01, kHighestFactor = 100;  // of a suspect
constexpr size_t kFewestFitted = 3;                           // suspects that promise most
constexpr double kDoubtful = 0.05;  // chance of a chi2 as large with the noise that was assumed: pairs are tried below it
constexpr size_t kMostPaired = 8;   // suspects that pairs are made of
constexpr size_t kMostPairs = 6;    // pairs that are fitted
constexpr double kScreened = 0.25;  // share of a history by which suspects are chosen
// Times the gain that slopes promise: a descent that would need more is given up. Of 981 points of descents on the stack of
// examples/stack 1 % gained more than that; at 2 every tenth.
constexpr double kReach = 20;
// The same where a damping is freed at a minimum of the stiffness: a gain as small as an unknown costs is nearly linear.
constexpr double kReachOfDamping = 2;
constexpr double kUnseen = 1e-6;  // share of the strongest fault's effect

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
        const Eigen::Index counted = comparison_.counted(group);
        const double squares = residual.segment(group.first, counted).squaredNorm();
        const auto count = static_cast<double>(counted);
        if (group.noise_from == DataGroup::NoiseFrom::residuals) {
            const double floor = kLeastNoise * group.largest;  // what is left below it is rounding
            if (counted > 0) score += count * std::log(std::max(squares / count * group.noise * group.noise, floor * floor));
        } else {
            score += squares;
        }
    }
    return score;
}

/// From the coordinates and predictions of a trial what its hypothesis is, and how good.
void Diagnostician::take_factors(Trial& trial) const {
    trial.hypothesis.chi2 = comparison_.residual(trial.predicted, false).squaredNorm();
    trial.hypothesis.score = score(trial.predicted, trial.unknowns.size());
    trial.hypothesis.factors.clear();
    trial.hypothesis.dampings.clear();
    for (size_t i = common_.size(); i < trial.unknowns.size(); ++i) {
        const double value = trial.unknowns[i].value(trial.x(as_row(i)));
        if (trial.unknowns[i].of == Unknown::Of::stiffness)
            trial.hypothesis.factors.push_back(value);
        else
            trial.hypothesis.dampings.push_back(value);
    }
}

/// From a start for the first unknowns; the others begin as the file has them.
Diagnostician::Trial Diagnostician::start_trial(const Hypothesis& hypothesis, bool with_damping,
                                                const Eigen::VectorXd& from) const {
    Trial trial{hypothesis, unknowns_of(hypothesis, with_damping), {}, {}};
    trial.x = trial.unknowns.start();
    trial.x.head(from.size()) = from;
    return trial;
}

void Diagnostician::descend(Trial& trial, int jobs, double enough, double limit) const {
    if (trial.unknowns.size() > 0) {
        const auto is_hopeless = [&](const Eigen::VectorXd& residual, const Eigen::MatrixXd& slopes) {
            return reach(residual, slopes, kReach) > limit;
        };
        const Minimum minimum = Identifier(comparison_, trial.unknowns, {}, jobs).descend(trial.x, enough, is_hopeless);
        trial.x = minimum.x;
        trial.is_given_up = minimum.is_given_up;
        trial.predicted = comparison_.predicted_of(minimum.residual);
    } else if (trial.predicted.size() == 0) {
        trial.predicted = comparison_.predict(trial.unknowns, trial.x);
    }
    take_factors(trial);
}

/// The score that a descent may still come to: `times` as far as the slopes promise.
double Diagnostician::reach(const Eigen::VectorXd& residual, const Eigen::MatrixXd& slopes, double times) const {
    const auto unknowns = as_size(slopes.cols());
    const double here = score(comparison_.predicted_of(residual), unknowns);
    const double promised = score(comparison_.predicted_of(without(residual, slopes)), unknowns);
    return here - times * (here - promised);
}

void Diagnostician::sort_by_score(std::vector<Trial>& trials) {
    std::ranges::stable_sort(trials, {}, [](const Trial& one) { return one.hypothesis.score; });
}

/// A process each. Says which have an answer; the others stay as they are.
std::vector<bool> Diagnostician::descend_each(std::span<Trial> trials, double enough, double limit) const {
    const std::vector<TaskResult> results = map_in_processes(trials.size(), jobs_, [&](size_t task) {
        Trial own = trials[task];
        descend(own, 1, enough, limit);
        std::vector<double> numbers = {own.is_given_up ? 1.0 : 0.0};
        numbers.insert(numbers.end(), own.x.begin(), own.x.end());
        numbers.insert(numbers.end(), own.predicted.begin(), own.predicted.end());
        return numbers;
    });
    std::vector<bool> have_answer;
    for (size_t t = 0; t < trials.size(); ++t) {
        have_answer.push_back(results[t].reason.empty());
        if (!have_answer.back()) continue;
        const Eigen::Map<const Eigen::VectorXd> all(results[t].numbers.data(), as_row(results[t].numbers.size()));
        trials[t].is_given_up = all(0) > 0.5;
        trials[t].x = all.segment(1, all.size() - 1 - comparison_.rows());
        trials[t].predicted = all.tail(comparison_.rows());
        take_factors(trials[t]);
    }
    return have_answer;
}

/// Those that have an answer, in the order of the starts.
std::vector<Diagnostician::Trial> Diagnostician::fit_each(std::span<const Start> starts, bool with_damping, double enough,
                                                          double limit) const {
    std::vector<Trial> trials;
    for (const auto& [hypothesis, from] : starts) trials.push_back(start_trial(hypothesis, with_damping, from));
    const std::vector<bool> have_answer = descend_each(trials, enough, limit);
    std::vector<Trial> found;
    for (size_t t = 0; t < trials.size(); ++t)
        if (have_answer[t]) found.push_back(std::move(trials[t]));
    return found;
}

/// Each with its stiffness alone, then with its damping too where that may bring it near the best: the better one counts.
/// The first ones are fitted to the end; of the others those that cannot come near the best of these are left out.
std::vector<Diagnostician::Trial> Diagnostician::fit_all(const std::vector<Start>& starts, double enough) const {
    const std::span<const Start> all(starts), first = all.first(std::min(kFewestFitted, all.size()));
    std::vector<Trial> trials = fit_each(first, false, enough, kNoLimit);
    for (Trial& one : fit_each(all.subspan(first.size()), false, enough, limit_near_best(trials)))
        trials.push_back(std::move(one));
    std::vector<size_t> with_damping;
    for (size_t t = 0; t < trials.size(); ++t)
        if (unknowns_of(trials[t].hypothesis, true).size() > trials[t].unknowns.size()) with_damping.push_back(t);
    const std::vector<TaskResult> reaches = map_in_processes(with_damping.size(), jobs_, [&](size_t task) {
        return std::vector<double>{reach_by_damping(trials[with_damping[task]])};
    });
    const double limit = limit_near_best(trials);
    std::vector<Start> damped;
    for (size_t i = 0; i < with_damping.size(); ++i) {
        const Trial& plain = trials[with_damping[i]];
        if (reaches[i].reason.empty() && reaches[i].numbers.front() < std::min(limit, plain.hypothesis.score))
            damped.push_back({{plain.hypothesis.elements, plain.hypothesis.are_alike}, plain.x});
    }
    for (Trial& one : fit_each(damped, true, enough, limit)) {
        const auto plain = std::ranges::find_if(trials, [&](const Trial& other) {
            return other.hypothesis.elements == one.hypothesis.elements &&
                   other.hypothesis.are_alike == one.hypothesis.are_alike;
        });
        if (!one.is_given_up && one.hypothesis.score < plain->hypothesis.score) *plain = std::move(one);
    }
    std::erase_if(trials, [](const Trial& one) { return one.is_given_up; });
    sort_by_score(trials);
    return trials;
}

/// With its damping free beside its stiffness.
double Diagnostician::reach_by_damping(const Trial& plain) const {
    const Unknowns damped = unknowns_of(plain.hypothesis, true);
    Eigen::VectorXd x = damped.start();
    x.head(plain.x.size()) = plain.x;
    std::vector<size_t> all(damped.size());
    std::iota(all.begin(), all.end(), size_t{0});
    const Eigen::VectorXd residual = comparison_.residual(plain.predicted, false);
    return reach(residual, Identifier(comparison_, damped, {}, 1).differentiate_quickly(x, residual, all), kReachOfDamping);
}

/// Of the score: trials below it are near the best. The margin grows with chi2 per row of the best, where that exceeds 1.
double Diagnostician::limit_near_best(const std::vector<Trial>& trials) const {
    if (trials.empty()) return kNoLimit;
    const Hypothesis& best =
        std::ranges::min_element(trials, {}, [](const Trial& one) { return one.hypothesis.score; })->hypothesis;
    return best.score + kDistinct * std::max(1.0, best.chi2 / static_cast<double>(comparison_.rows()));
}

/// First, one suspect of every tie is fitted to the first part of the histories, with a coarse tolerance. Those near the
/// best are then fitted to all data. Last come the suspects tied to the best of these.
std::vector<Diagnostician::Trial> Diagnostician::fit_singles(const Trial& null,
                                                             const std::vector<std::vector<size_t>>& classes,
                                                             const Eigen::VectorXd& residual) const {
    std::vector<Start> starts;
    for (Hypothesis& one : singles(null, classes, residual)) starts.push_back({std::move(one), null.x});
    starts = screen(null, std::move(starts));
    std::vector<Trial> trials = fit_all(starts);
    if (trials.empty() || trials.front().hypothesis.score > null.hypothesis.score) return trials;  // no change is seen
    starts.clear();
    for (const Trial& one : trials) {
        if (one.hypothesis.elements.size() > 1) continue;
        // A tied suspect may fit better by 1 - kTied² of what this one explains
        const double explained = std::max(0.0, null.hypothesis.chi2 - one.hypothesis.chi2);
        const double margin = kDistinct + 2 * (1 - kTied * kTied) * explained;
        if (one.hypothesis.chi2 > trials.front().hypothesis.chi2 + margin) continue;
        for (const std::vector<size_t>& tied : classes) {
            if (suspects_[tied.front()] != one.hypothesis.elements.front()) continue;
            for (size_t t = 1; t < tied.size(); ++t) starts.push_back({{{suspects_[tied[t]]}}, start_of(one)});
        }
    }
    for (Trial& one : fit_all(starts)) trials.push_back(std::move(one));
    sort_by_score(trials);
    return trials;
}

/// Those of the starts that are near the best of them in the first part of histories, from where they fit that. All of them,
/// as they are, where none fits it.
std::vector<Diagnostician::Start> Diagnostician::screen(const Trial& null, std::vector<Start> starts) const {
    const auto rows = static_cast<double>(comparison_.rows());
    const ShortWindow window(comparison_, kScreened);
    choose_factors(null, starts);
    const std::vector<Trial> screened = fit_all(starts, 1 / rows);
    if (screened.empty()) return starts;
    const double unchanged = score(null.predicted, common_.size());
    const double limit = limit_near_best(screened);
    std::vector<Start> near;
    for (const Trial& one : screened)
        if (near.size() < kFewestFitted || one.hypothesis.score < limit)
            // What shows nothing in the first part says nothing of a start either
            near.push_back({{one.hypothesis.elements, one.hypothesis.are_alike},
                            one.hypothesis.score < unchanged ? start_of(one) : null.x});
    return near;
}

/// Starts of the stiffness at the best of a few factors: a history that has slipped by a period has minima of its own.
void Diagnostician::choose_factors(const Trial& null, std::vector<Start>& starts) const {
    constexpr double kFactors[] = {0.03, 0.3, 3};
    constexpr size_t kCount = std::size(kFactors);
    const auto at = [&](const Start& start, double factor) {
        Eigen::VectorXd x(start.from.size() + 1);
        x << start.from, std::log(factor);
        return x;
    };
    const std::vector<TaskResult> scores = map_in_processes(kCount * starts.size(), jobs_, [&](size_t task) {
        const Start& start = starts[task / kCount];
        const Unknowns unknowns = unknowns_of(start.hypothesis, false);
        return std::vector<double>{
            score(comparison_.predict(unknowns, at(start, kFactors[task % kCount])), unknowns.size())};
    });
    for (size_t i = 0; i < starts.size(); ++i) {
        double least = score(null.predicted, common_.size() + 1);
        for (size_t k = 0; k < kCount; ++k) {
            const TaskResult& one = scores[kCount * i + k];
            if (!one.reason.empty() || !(one.numbers.front() < least)) continue;
            least = one.numbers.front();
            starts[i].from = at({{}, null.x}, kFactors[k]);
        }
    }
}

/// The common unknowns and the stiffness.
Eigen::VectorXd Diagnostician::start_of(const Trial& trial) const { return trial.x.head(as_row(common_.size() + 1)); }

/// What faults do to the data where nothing has changed, by one-sided differences: as many runs as columns that are not
/// known yet. columns: the common unknowns, the stiffness of every suspect, the damping of those that have one.
void Diagnostician::find_slopes(const Trial& null, std::vector<size_t> columns) {
    Hypothesis all;
    all.elements = suspects_;
    const Unknowns unknowns = unknowns_of(all, true);
    if (is_found_.empty()) {
        is_found_.assign(unknowns.size(), false);
        changes_.setZero(comparison_.rows(), as_row(unknowns.size()));
    }
    std::erase_if(columns, [&](size_t column) { return is_found_[column]; });
    Eigen::VectorXd x = unknowns.start();
    x.head(null.x.size()) = null.x;
    const Eigen::MatrixXd slopes = Identifier(comparison_, unknowns, {}, jobs_)
                                       .differentiate_quickly(x, comparison_.residual(null.predicted, false), columns);
    for (size_t i = 0; i < columns.size(); ++i) {
        changes_.col(as_row(columns[i])) = slopes.col(as_row(i)).cwiseProduct(comparison_.deviations());
        is_found_[columns[i]] = true;
    }
    scale_slopes();
}

/// Of its damping among slopes_.
std::optional<size_t> Diagnostician::damping_column(size_t suspect) const {
    if (!are_damped_[suspect]) return std::nullopt;
    return suspects_.size() + as_size(std::count(are_damped_.begin(), are_damped_.begin() + as_row(suspect), true));
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
        const auto damping = damping_column(s);
        if (damping && is_found_[common_.size() + *damping]) columns.push_back(as_row(*damping));
    }
    Eigen::MatrixXd own(slopes_.rows(), as_row(columns.size()));
    for (size_t c = 0; c < columns.size(); ++c) own.col(as_row(c)) = slopes_.col(columns[c]);
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
    qr.setThreshold(kUnseen);
    qr.compute(own);
    return residual.squaredNorm() - (residual - own * qr.solve(residual)).squaredNorm();
}

/// Suspects in classes whose faults the data show alike to first order.
std::vector<std::vector<size_t>> Diagnostician::tied_suspects() const {
    const double strongest = slopes_.leftCols(as_row(suspects_.size())).colwise().norm().maxCoeff();
    std::vector<std::vector<size_t>> classes;
    for (size_t s = 0; s < suspects_.size(); ++s) {
        const auto own = slopes_.col(as_row(s));
        const double norm = own.norm();
        const auto is_like = [&](const std::vector<size_t>& one) {
            const auto first = slopes_.col(as_row(one.front()));
            return first.norm() > kUnseen * strongest && std::abs(own.dot(first)) >= kTied * norm * first.norm();
        };
        const auto found = norm > kUnseen * strongest ? std::ranges::find_if(classes, is_like) : classes.end();
        if (found != classes.end())
            found->push_back(s);
        else
            classes.push_back({s});
    }
    return classes;
}

/// The first of every class in the order of what they promise, and all alike. Where no change explains the data too, only
/// those that promise as much as an unknown costs: where none does, slopes say little of what is far away.
std::vector<Hypothesis> Diagnostician::singles(const Trial& null, const std::vector<std::vector<size_t>>& classes,
                                               const Eigen::VectorXd& residual) const {
    const bool is_explained = judge(null).is_explained();
    std::vector<std::pair<double, size_t>> order;
    for (const std::vector<size_t>& tied : classes) order.emplace_back(gain({tied.front()}, residual), tied.front());
    std::ranges::stable_sort(order, std::ranges::greater(), &std::pair<double, size_t>::first);
    const double cost = std::log(static_cast<double>(comparison_.rows()));  // of one unknown, by the criterion
    std::vector<Hypothesis> all;
    for (const auto& [gain, suspect] : order)
        if (!is_explained || all.size() < kFewestFitted || gain > cost) all.push_back({{suspects_[suspect]}});
    if (suspects_.size() > 1) all.push_back({suspects_, true});
    return all;
}

/// Those that promise most.
std::vector<size_t> Diagnostician::strongest(const Eigen::VectorXd& residual) const {
    std::vector<size_t> order(suspects_.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::vector<double> gains;
    for (size_t s = 0; s < suspects_.size(); ++s) gains.push_back(gain({s}, residual));
    std::ranges::stable_sort(order, [&](size_t a, size_t b) { return gains[a] > gains[b]; });
    order.resize(std::min(order.size(), kMostPaired));
    return order;
}

std::vector<Hypothesis> Diagnostician::promising_pairs(const std::vector<size_t>& order,
                                                       const Eigen::VectorXd& residual) const {
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

/// Those of the strongest suspects that promise most.
std::vector<Diagnostician::Trial> Diagnostician::fit_pairs(const Trial& null, const Eigen::VectorXd& residual) {
    std::vector<size_t> dampings(as_size(std::ranges::count(are_damped_, true)));
    std::iota(dampings.begin(), dampings.end(), common_.size() + suspects_.size());
    find_slopes(null, dampings);
    std::vector<Start> starts;
    for (Hypothesis& one : promising_pairs(strongest(residual), residual)) starts.push_back({std::move(one), null.x});
    return fit_all(starts);
}

void Diagnostician::find_limits(Diagnosis& diagnosis) const {
    const auto count = as_row(suspects_.size());
    double strongest = 0;
    for (Eigen::Index s = 0; s < count; ++s) strongest = std::max(strongest, slopes_.col(s).norm());
    const double needed = kDistinct + std::log(static_cast<double>(comparison_.rows()));
    for (Eigen::Index s = 0; s < count; ++s) {
        const double norm = slopes_.col(s).norm();
        if (norm > kUnseen * strongest)
            diagnosis.least_seen = std::max(diagnosis.least_seen, 1 - std::exp(-std::sqrt(needed) / norm));
        else
            diagnosis.unseen.push_back(suspects_[as_size(s)]);
    }
    for (const std::vector<size_t>& tied : tied_suspects()) {
        if (tied.size() < 2) continue;
        std::vector<std::string>& names = diagnosis.ties.emplace_back();
        for (const size_t suspect : tied) names.push_back(suspects_[suspect]);
    }
}

/// Factors of stiffness and their limits, a process for each trial; of one trial its runs have processes of their own.
void Diagnostician::add_intervals(std::span<Trial> trials) const {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    const auto find = [&](const Trial& trial, int jobs) {
        const Solution solution = Identifier(comparison_, trial.unknowns, {}, jobs).estimate(trial.x);
        std::vector<double> numbers;
        for (size_t i = common_.size(); i < trial.unknowns.size(); ++i) {
            const Unknown& one = trial.unknowns[i];
            if (one.of != Unknown::Of::stiffness) continue;
            for (const std::optional<double>& at : {std::optional(solution.x(as_row(i))), solution.low[i], solution.high[i]})
                numbers.push_back(at ? one.value(*at) : kNone);
        }
        return numbers;
    };
    std::vector<TaskResult> results;
    if (trials.size() == 1)
        results.push_back({find(trials.front(), jobs_)});
    else
        results = map_in_processes(trials.size(), jobs_, [&](size_t task) { return find(trials[task], 1); });
    for (size_t t = 0; t < trials.size(); ++t) {
        if (!results[t].reason.empty()) throw Error(ExitCode::numerical_failure, results[t].reason);
        Hypothesis& own = trials[t].hypothesis;
        own.factors.clear();
        const auto limit = [&](double number) { return std::isnan(number) ? std::nullopt : std::optional(number); };
        for (size_t i = 0; i < results[t].numbers.size(); i += 3) {
            own.factors.push_back(results[t].numbers[i]);
            own.low.push_back(limit(results[t].numbers[i + 1]));
            own.high.push_back(limit(results[t].numbers[i + 2]));
        }
    }
}

Fit Diagnostician::judge(const Trial& trial) const {
    const Identifier identifier(comparison_, trial.unknowns, {}, jobs_);
    return identifier.judge(identifier.describe(trial.x));
}

/// How well it explains the data, and what the time step does to it.
void Diagnostician::judge_best(const Trial& best, Diagnosis& diagnosis) const {
    const Identifier identifier(comparison_, best.unknowns, {}, jobs_);
    const Solution at = identifier.describe(best.x);
    diagnosis.fit = identifier.judge(at);
    if (!comparison_.has_histories() || best.unknowns.size() == 0) return;
    diagnosis.step = describe_step(identifier.find_step_bias(at), at, best.unknowns, comparison_.time_step());
}

Diagnosis Diagnostician::diagnose() {
    Diagnosis diagnosis;
    Trial null = start_trial({}, false, common_.start());
    descend(null, jobs_);
    comparison_.estimate_noise(null.predicted, common_.size());
    take_factors(null);
    std::vector<size_t> columns(common_.size() + suspects_.size());
    std::iota(columns.begin(), columns.end(), size_t{0});
    find_slopes(null, columns);
    const std::vector<std::vector<size_t>> classes = tied_suspects();
    const auto residual_of_null = [&] { return Eigen::VectorXd(-comparison_.residual(null.predicted, false)); };
    std::vector<Trial> trials = fit_singles(null, classes, residual_of_null());
    if (trials.empty())
        throw Error(ExitCode::numerical_failure, "the model has no answer with any of the most likely suspects changed");
    // With the noise that the best explanation leaves, those near it are fitted again
    const auto sharpen = [&] {
        const Trial& best = trials.front().hypothesis.score < null.hypothesis.score ? trials.front() : null;
        comparison_.estimate_noise(best.predicted, best.unknowns.size());
        descend(null, jobs_);
        descend_each(std::span(trials).first(std::min(kFewestFitted, trials.size())));
        for (Trial& one : trials) one.hypothesis.score = score(one.predicted, one.unknowns.size());
        sort_by_score(trials);
        scale_slopes();
    };
    sharpen();
    const Fit single = judge(trials.front());
    const bool is_doubtful = !single.is_explained() || (single.is_noise_assumed && single.chance < kDoubtful);
    if (suspects_.size() > 1 && (is_doubtful || suspects_.size() == 2)) {
        for (Trial& pair : fit_pairs(null, residual_of_null())) trials.push_back(std::move(pair));
        sort_by_score(trials);
        sharpen();
    }
    const auto rejudge = [&](Trial& one) {
        one.hypothesis.chi2 = comparison_.residual(one.predicted, false).squaredNorm();
        one.hypothesis.score = score(one.predicted, one.unknowns.size());
    };
    rejudge(null);
    std::ranges::for_each(trials, rejudge);
    diagnosis.unchanged = null.hypothesis;
    sort_by_score(trials);
    find_limits(diagnosis);
    diagnosis.best_score = std::min(trials.front().hypothesis.score, diagnosis.unchanged.score);
    const bool is_seen = diagnosis.unchanged.score - trials.front().hypothesis.score > kDistinct;
    judge_best(is_seen ? trials.front() : null, diagnosis);
    const double least = trials.front().hypothesis.score;
    const auto end = std::ranges::find_if(
        trials, [&](const Trial& one) { return !is_seen || one.hypothesis.score - least >= kDistinct; });
    const auto candidates = std::span(trials).first(as_size(end - trials.begin()));
    add_intervals(candidates);
    for (size_t t = 0; t < trials.size(); ++t)
        (t < candidates.size() ? diagnosis.candidates : diagnosis.others).push_back(trials[t].hypothesis);
    return diagnosis;
}

}  // namespace dttmm::host
