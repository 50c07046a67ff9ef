// SPDX-License-Identifier: BSD-3-Clause
#include "identify/diagnosis.h"

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/normal.hpp>
#include <cmath>
#include <iterator>
#include <limits>
#include <numeric>

#include "identify/forked_map.h"
#include "identify/intervals.h"
#include "identify/verdict.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr size_t kFewestFitted = 3;  // suspects that promise most
constexpr double kDoubtful = 0.05;   // chance of a chi2 as large with the noise that was assumed: pairs are tried below it
constexpr double kScreened = 0.25;   // share of a history by which suspects are chosen
// Times the gain that slopes promise: a descent that would need more is given up. Of 981 points of descents on the stack of
// examples/stack 1 % gained more than that; at 2 every tenth.
constexpr double kReach = 20;
// The same where a damping is freed at a minimum of the stiffness: a gain as small as an unknown costs is nearly linear.
constexpr double kReachOfDamping = 2;

/// Whether the first is the second with factors that are 1 or equal: what a pair has beside it is worth no second unknown
/// unless the criterion says so.
bool is_part(const Hypothesis& one, const Hypothesis& whole) {
    if (whole.are_alike) return false;
    if (one.are_alike) return one.elements == whole.elements;
    return one.elements.size() < whole.elements.size() && std::ranges::all_of(one.elements, [&](const std::string& name) {
               return std::ranges::find(whole.elements, name) != whole.elements.end();
           });
}

}  // namespace

/// Of several trials of one hypothesis the first stays.
void Diagnostician::keep_first_of_each(std::vector<Trial>& trials) {
    std::vector<Trial> kept;
    for (Trial& one : trials)
        if (std::ranges::none_of(kept, [&](const Trial& other) {
                return other.hypothesis.elements == one.hypothesis.elements &&
                       other.hypothesis.are_alike == one.hypothesis.are_alike;
            }))
            kept.push_back(std::move(one));
    trials = std::move(kept);
}

Diagnostician::Diagnostician(Comparison& comparison, const Unknowns& common, Suspects suspects, int jobs)
    : comparison_(comparison),
      common_(common),
      suspects_(std::move(suspects)),
      jobs_(jobs),
      slopes_(comparison, common, suspects_, jobs) {}

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
    return reach(residual, Residuals(comparison_, damped, {}, 1).differentiate_quickly(x, residual, all), kReachOfDamping);
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
            if (suspects_.names[tied.front()] != one.hypothesis.elements.front()) continue;
            for (size_t t = 1; t < tied.size(); ++t) starts.push_back({{{suspects_.names[tied[t]]}}, start_of(one)});
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

/// The first of every class in the order of what they promise, and all alike. Where no change explains the data too, only
/// those that promise as much as an unknown costs: where none does, slopes say little of what is far away.
std::vector<Hypothesis> Diagnostician::singles(const Trial& null, const std::vector<std::vector<size_t>>& classes,
                                               const Eigen::VectorXd& residual) const {
    const bool is_explained = judge(null).is_explained();
    std::vector<std::pair<double, size_t>> order;
    for (const std::vector<size_t>& tied : classes) order.emplace_back(slopes_.gain({tied.front()}, residual), tied.front());
    std::ranges::stable_sort(order, std::ranges::greater(), &std::pair<double, size_t>::first);
    const double cost = std::log(static_cast<double>(comparison_.rows()));  // of one unknown, by the criterion
    std::vector<Hypothesis> all;
    for (const auto& [gain, suspect] : order)
        if (!is_explained || all.size() < kFewestFitted || gain > cost) all.push_back({{suspects_.names[suspect]}});
    if (suspects_.size() > 1) all.push_back({suspects_.names, true});
    return all;
}

/// Those of the strongest suspects that promise most.
std::vector<Diagnostician::Trial> Diagnostician::fit_pairs(const Trial& null, const Eigen::VectorXd& residual) {
    std::vector<size_t> dampings(suspects_.damped_count());
    std::iota(dampings.begin(), dampings.end(), common_.size() + suspects_.size());
    slopes_.find(null.x, null.predicted, dampings);
    std::vector<Start> starts;
    for (const auto& [a, b] : slopes_.promising_pairs(residual))
        starts.push_back({{{suspects_.names[a], suspects_.names[b]}}, null.x});
    return fit_all(starts);
}

/// Each member of the best pairs alone, from its factor in the pair: a single one may have ended in a minimum of its own.
std::vector<Diagnostician::Trial> Diagnostician::fit_members(std::span<const Trial> pairs) const {
    const Eigen::Index common = as_row(common_.size());
    std::vector<Start> starts;
    for (const Trial& pair : pairs.first(std::min(kFewestFitted, pairs.size())))
        for (size_t member = 0; member < pair.hypothesis.elements.size(); ++member) {
            Eigen::VectorXd from = pair.x.head(common + 1);
            from(common) = pair.x(common + as_row(member));
            starts.push_back({{{pair.hypothesis.elements[member]}}, from});
        }
    return fit_all(starts);
}

/// Loss of a suspect at which its change in the data, without what the common unknowns can do, is seen with the chance
/// kSureChance. Its size in standard deviations and noise of 1 are added: their square is the gain. effect: the size per
/// logarithm of stiffness near the file's value. It falls as a suspect gets softer, so the limit is looked for outwards from
/// there.
std::optional<double> Diagnostician::find_limit(const Trial& null, size_t suspect, double effect) const {
    constexpr double kFarther = 1.25;  // steps between which the effect is nearly linear. 1.05 to 2.5 serve
    const double needed = std::sqrt(kDistinct + std::log(static_cast<double>(comparison_.rows()))) +
                          boost::math::quantile(boost::math::normal(), kSureChance);
    const Unknowns unknowns = unknowns_of({{suspects_.names[suspect]}}, false);
    const Eigen::Index own = null.x.size();
    Eigen::VectorXd x(own + 1);
    x << null.x, 0;
    const double farthest = -unknowns.low()(own);
    double before = 0, effect_before = 0;
    for (double gone = std::min(needed / effect, farthest);; gone = std::min(kFarther * gone, farthest)) {
        x(own) = -gone;
        const Eigen::VectorXd change =
            (comparison_.predict(unknowns, x) - null.predicted).cwiseQuotient(comparison_.deviations());
        const double here = slopes_.beyond_common(change).norm();
        if (here >= needed)
            return 1 - std::exp(-(before + (gone - before) * (needed - effect_before) / (here - effect_before)));
        if (gone >= farthest) return std::nullopt;
        before = gone;
        effect_before = here;
    }
}

/// The largest limit of those that the data show.
std::optional<double> Diagnostician::least_seen(const Trial& null) const {
    const std::vector<double> effects = slopes_.effects();
    if (std::ranges::none_of(effects, [](double effect) { return effect > 0; })) return std::nullopt;
    const std::vector<TaskResult> limits = map_in_processes(effects.size(), jobs_, [&](size_t suspect) {
        const std::optional<double> limit =
            effects[suspect] > 0 ? find_limit(null, suspect, effects[suspect]) : std::optional(0.0);
        return limit ? std::vector<double>{*limit} : std::vector<double>();
    });
    double largest = 0;
    for (const TaskResult& limit : limits) {
        if (!limit.reason.empty() || limit.numbers.empty()) return std::nullopt;
        largest = std::max(largest, limit.numbers.front());
    }
    return largest;
}

void Diagnostician::find_ties(Diagnosis& diagnosis) const {
    const std::vector<double> effects = slopes_.effects();
    for (size_t s = 0; s < effects.size(); ++s)
        if (!(effects[s] > 0)) diagnosis.unseen.push_back(suspects_.names[s]);
    for (const std::vector<size_t>& tied : slopes_.ties()) {
        if (tied.size() < 2) continue;
        std::vector<std::string>& names = diagnosis.ties.emplace_back();
        for (const size_t suspect : tied) names.push_back(suspects_.names[suspect]);
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
            numbers.push_back(solution.are_limits_converged[i] ? 1 : 0);
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
        for (size_t i = 0; i < results[t].numbers.size(); i += 4) {
            own.factors.push_back(results[t].numbers[i]);
            own.low.push_back(limit(results[t].numbers[i + 1]));
            own.high.push_back(limit(results[t].numbers[i + 2]));
            own.are_limits_converged.push_back(results[t].numbers[i + 3] == 1);
        }
    }
}

Fit Diagnostician::judge(const Trial& trial) const {
    const Identifier identifier(comparison_, trial.unknowns, {}, jobs_);
    return judge_fit(comparison_, identifier.describe(trial.x));
}

/// How well it explains the data, and what the time step does to it.
void Diagnostician::judge_best(const Trial& best, Diagnosis& diagnosis) const {
    const Identifier identifier(comparison_, best.unknowns, {}, jobs_);
    const Solution at = identifier.describe(best.x);
    diagnosis.fit = judge_fit(comparison_, at);
    if (!comparison_.has_histories() || best.unknowns.size() == 0) return;
    diagnosis.step = describe_step(find_step_bias(identifier.residuals(), at), at, best.unknowns, comparison_.time_step());
}

size_t Diagnostician::put_candidates_first(std::vector<Trial>& trials) {
    const double least = trials.front().hypothesis.score;
    const auto has_simpler = [&](const Trial& one) {
        return std::ranges::any_of(trials, [&](const Trial& other) {
            return other.hypothesis.score <= one.hypothesis.score && is_part(other.hypothesis, one.hypothesis);
        });
    };
    std::vector<Trial> candidates, others;
    for (const Trial& one : trials)
        (one.hypothesis.score - least < kDistinct && !has_simpler(one) ? candidates : others).push_back(one);
    const size_t count = candidates.size();
    candidates.insert(candidates.end(), others.begin(), others.end());
    trials = std::move(candidates);
    return count;
}

Diagnosis Diagnostician::diagnose() {
    Diagnosis diagnosis;
    Trial null = start_trial({}, false, common_.start());
    descend(null, jobs_);
    comparison_.estimate_noise(null.predicted, common_.size());
    take_factors(null);
    std::vector<size_t> columns(common_.size() + suspects_.size());
    std::iota(columns.begin(), columns.end(), size_t{0});
    slopes_.find(null.x, null.predicted, columns);
    const std::vector<std::vector<size_t>> classes = slopes_.ties();
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
        slopes_.scale();
    };
    sharpen();
    const Fit single = judge(trials.front());
    const bool is_doubtful = !single.is_explained() || (single.is_noise_assumed && single.chance < kDoubtful);
    if (suspects_.size() > 1 && (is_doubtful || suspects_.size() == 2)) {
        const std::vector<Trial> pairs = fit_pairs(null, residual_of_null());
        std::vector<Trial> members = fit_members(pairs);
        trials.insert(trials.end(), pairs.begin(), pairs.end());
        for (Trial& one : members) trials.push_back(std::move(one));
        sort_by_score(trials);
        keep_first_of_each(trials);
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
    find_ties(diagnosis);
    diagnosis.best_score = std::min(trials.front().hypothesis.score, diagnosis.unchanged.score);
    const bool is_seen = diagnosis.unchanged.score - trials.front().hypothesis.score > kDistinct;
    judge_best(is_seen ? trials.front() : null, diagnosis);
    if (!is_seen) diagnosis.least_seen = least_seen(null);
    const size_t count = is_seen ? put_candidates_first(trials) : 0;
    const auto candidates = std::span(trials).first(count);
    add_intervals(candidates);
    for (size_t t = 0; t < trials.size(); ++t)
        (t < candidates.size() ? diagnosis.candidates : diagnosis.others).push_back(trials[t].hypothesis);
    return diagnosis;
}

}  // namespace dttmm::host
