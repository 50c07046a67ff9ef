// SPDX-License-Identifier: BSD-3-Clause
#include "identify/identification.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "analysis/stop_signals.h"
#include "identify/forked_map.h"
#include "identify/intervals.h"
#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "study/design.h"

namespace dttmm::host {

namespace {

constexpr double kSpread = 1.2;        // of starting points in the logarithm: a factor of 3.3 up and down
constexpr double kAsGood = 10;         // of chi2: solutions nearer than this explain the data as well as the best
constexpr double kSame = 1e-3;         // distance of coordinates: one minimum
constexpr double kNear = 0.01;         // the same, of minima of a short window
constexpr double kFarWorse = 4;        // times the least chi2 of a short window: no minimum of the long one
constexpr double kFirstWindow = 0.25;  // share of a history: a short one has fewer side minima
constexpr int kDescended =
    4;  // starting points of histories and responses that are descended from together, the nearest first
constexpr int kNoiseRounds = 2;  // estimates of noise from residuals, each followed by a fit

void sort_by_chi2(std::vector<Minimum>& minima) {
    std::ranges::stable_sort(minima, [](const Minimum& a, const Minimum& b) { return a.chi2() < b.chi2(); });
}

}  // namespace

Identifier::Identifier(Comparison& comparison, const Unknowns& unknowns, std::vector<Prior> priors, int jobs)
    : residuals_(comparison, unknowns, std::move(priors), jobs), comparison_(comparison), unknowns_(unknowns), jobs_(jobs) {}

Minimum Identifier::descend(const Eigen::VectorXd& start, double enough,
                            decltype(LeastSquares::is_hopeless) is_hopeless) const {
    LeastSquares quick = residuals_.problem();
    quick.is_hopeless = std::move(is_hopeless);
    std::vector<size_t> all(unknowns_.size());
    std::iota(all.begin(), all.end(), size_t{0});
    quick.jacobian = [this, all](const Eigen::VectorXd& x, const Eigen::VectorXd& here) {
        return residuals_.differentiate_quickly(x, here, all);
    };
    const SearchEnd end = {kMostEvaluations, enough};
    return minimise(quick, by_logarithms(start, jobs_, end), end);
}

/// Where responses are near the data in their logarithms; of other data the start. Resonances that do not overlap with the
/// measured ones leave the difference a minimum of its own for almost every stiffness, and the logarithm hardly any.
Eigen::VectorXd Identifier::by_logarithms(const Eigen::VectorXd& start, int jobs, const SearchEnd& end) const {
    return comparison_.has_responses() ? minimise(residuals_.problem(true, jobs), start, end).x : start;
}

Minimum Identifier::search_from(const Eigen::VectorXd& start, int jobs) const {
    const SearchEnd end = {most_evaluations_};
    return minimise(residuals_.problem(false, jobs), by_logarithms(start, jobs, end), end);
}

bool Identifier::is_underdetermined(const Identifiability& judged) const {
    const auto live = std::ranges::count(judged.is_dead, false);
    return residuals_.rows() - comparison_.scales() <= live && !judged.flat.empty();
}

/// The file's values first.
std::vector<Identifier::Start> Identifier::starting_points(int starts, int seed) const {
    const auto count = as_row(unknowns_.size());
    std::vector<Start> points = {{unknowns_.start()}};
    if (starts < 2) return points;
    const Eigen::MatrixXd shares = make_probabilities(Design::sobol, starts - 1, count, static_cast<std::uint64_t>(seed));
    for (Eigen::Index s = 0; s < shares.rows(); ++s) {
        Eigen::VectorXd x = unknowns_.start();
        for (Eigen::Index i = 0; i < count; ++i) {
            const Unknown& one = unknowns_[as_size(i)];
            const bool is_of_model =
                one.of == Unknown::Of::parameter || one.of == Unknown::Of::stiffness || one.of == Unknown::Of::damping;
            const double reach =
                is_of_model && one.is_logarithmic() ? kSpread : 0.1;  // a gain is nearly known, a clock more so
            x(i) = std::clamp(x(i) + reach * (2 * shares(s, i) - 1), one.coordinate(one.low), one.coordinate(one.high));
        }
        points.push_back({x});
    }
    return points;
}

/// Of modes every point is descended from; of histories and responses those that come nearest to the data. Of responses the
/// next nearest follow as long as no minimum explains the data.
std::vector<Minimum> Identifier::search(const std::vector<Start>& points, Identification& found) {
    std::vector<size_t> chosen(points.size());
    std::iota(chosen.begin(), chosen.end(), size_t{0});
    const bool is_by_residual = !comparison_.has_modes();
    const bool are_ordered = is_by_residual && points.size() > kDescended;
    if (are_ordered) {
        const std::vector<TaskResult> sums = map_in_processes(points.size(), jobs_, [&](size_t p) {
            return std::vector<double>{residuals_.at(points[p].x, true).squaredNorm()};
        });
        const auto sum_of = [&](size_t p) {
            return sums[p].reason.empty() ? sums[p].numbers.front() : std::numeric_limits<double>::infinity();
        };
        std::stable_sort(chosen.begin() + 1, chosen.end(), [&](size_t a, size_t b) { return sum_of(a) < sum_of(b); });
    }
    found.descents = 0;
    if (!are_ordered) return descend_from(points, chosen, found);
    std::vector<Minimum> minima;
    const std::span<const size_t> all(chosen);
    for (size_t first = 0; first < all.size(); first += kDescended) {
        for (Minimum& one :
             descend_from(points, all.subspan(first, std::min<size_t>(kDescended, all.size() - first)), found))
            minima.push_back(std::move(one));
        sort_by_chi2(minima);
        if (!comparison_.has_responses() || (!minima.empty() && is_explained_by(minima.front()))) break;
    }
    return minima;
}

bool Identifier::is_explained_by(const Minimum& minimum) const {
    return judge_fit(comparison_, make_solution(minimum)).is_explained();
}

/// A process each, where there are several.
std::vector<Minimum> Identifier::descend_from(const std::vector<Start>& points, std::span<const size_t> chosen,
                                              Identification& found) const {
    for (const size_t p : chosen) found.descents += points[p].count;
    const auto size = as_row(unknowns_.size());
    const bool is_apart = chosen.size() > 1;
    const std::vector<TaskResult> results = map_in_processes(chosen.size(), is_apart ? jobs_ : 1, [&](size_t task) {
        const Minimum minimum = search_from(points[chosen[task]].x, is_apart ? 1 : jobs_);
        std::vector<double> numbers(minimum.x.begin(), minimum.x.end());
        for (const bool is_held : minimum.at_bound) numbers.push_back(is_held ? 1 : 0);
        numbers.insert(numbers.end(), minimum.residual.begin(), minimum.residual.end());
        return numbers;
    });
    std::vector<Minimum> minima;
    for (size_t r = 0; r < results.size(); ++r) {
        const TaskResult& result = results[r];
        if (!result.reason.empty()) {
            if (found.failed++ == 0) found.first_failure = result.reason;
            continue;
        }
        Minimum minimum;
        minimum.starts = points[chosen[r]].count;
        const Eigen::Map<const Eigen::VectorXd> all(result.numbers.data(), as_row(result.numbers.size()));
        minimum.x = all.head(size);
        for (Eigen::Index i = 0; i < size; ++i) minimum.at_bound.push_back(all(size + i) > 0.5);
        minimum.residual = all.tail(all.size() - 2 * size);
        if (!std::isfinite(minimum.chi2())) {
            if (found.failed++ == 0) found.first_failure = "the model predicts a number that is not finite";
            continue;
        }
        minima.push_back(std::move(minimum));
    }
    sort_by_chi2(minima);
    return minima;
}

/// Near each other, or joined by a straight valley.
bool Identifier::is_same(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
    if ((a - b).cwiseAbs().maxCoeff() < kSame) return true;
    const double highest = std::max(residuals_.at(a).squaredNorm(), residuals_.at(b).squaredNorm());
    for (const double share : {0.5, 0.25, 0.75}) {
        try {
            if (residuals_.at(a + share * (b - a)).squaredNorm() > highest + 1) return false;
        } catch (const Error&) {
            return false;
        }
    }
    return true;
}

Solution Identifier::make_solution(const Minimum& minimum) const {
    Solution solution;
    solution.x = minimum.x;
    solution.at_bound = minimum.at_bound;
    solution.predicted = comparison_.predict(unknowns_, minimum.x);
    solution.chi2 = comparison_.residual(solution.predicted, false).squaredNorm();
    solution.slopes = residuals_.jacobian(minimum.x);
    const Eigen::MatrixXd& slopes = solution.slopes;
    // A combination that the data do not fix may have ended at a bound, which makes none of its unknowns known
    solution.judged = judge_identifiability(slopes, unknowns_, std::vector<bool>(unknowns_.size(), false));
    if (solution.judged.flat.empty()) solution.judged = judge_identifiability(slopes, unknowns_, minimum.at_bound);
    solution.low.resize(unknowns_.size());
    solution.high.resize(unknowns_.size());
    solution.are_limits_converged.assign(unknowns_.size(), true);
    return solution;
}

Solution Identifier::polish(const Eigen::VectorXd& start) const {
    Solution solution = make_solution(minimise(residuals_.problem(), start));
    find_intervals(residuals_, solution, 1);
    return solution;
}

/// The direction of the unknowns that the data fix least: derivatives by differences may hide that it is open.
Eigen::VectorXd Identifier::weakest_direction(const Solution& solution, double& share) const {
    const Eigen::MatrixXd slopes = residuals_.jacobian(solution.x);
    std::vector<Eigen::Index> live;
    for (size_t i = 0; i < unknowns_.size(); ++i)
        if (!solution.judged.is_dead[i]) live.push_back(as_row(i));
    Eigen::VectorXd direction = Eigen::VectorXd::Zero(slopes.cols());
    share = 1;
    if (live.empty()) return direction;
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(slopes(Eigen::all, live), Eigen::ComputeThinV);
    const auto last = svd.singularValues().size() - 1;
    share = svd.singularValues()(last) / svd.singularValues()(0);
    direction(live) = svd.matrixV().col(last);
    return direction;
}

bool Identifier::is_nearly_flat(const Solution& solution) const {
    constexpr double kWeak = 0.02;  // of the largest singular value
    double share = 0;
    weakest_direction(solution, share);
    return solution.judged.flat.empty() && share < kWeak;
}

/// Goes some way along the weakest direction and down again: whoever does not come back, and fits as well, is in a valley
/// without end. Returns the direction from the solution, of norm 1.
std::optional<Eigen::VectorXd> Identifier::find_valley(const Solution& solution) const {
    constexpr double kAway = 0.3, kBack = 0.1;  // of coordinates: gone, and still away afterwards
    double share = 0;
    const Eigen::VectorXd direction = weakest_direction(solution, share);
    for (const double sign : {1.0, -1.0}) {
        Eigen::VectorXd start = solution.x + sign * kAway * direction;
        start = start.cwiseMax(unknowns_.low()).cwiseMin(unknowns_.high());
        if ((start - solution.x).norm() < kBack) continue;
        try {
            const Minimum there = minimise(residuals_.problem(), start);
            const Eigen::VectorXd way = there.x - solution.x;
            const double here = residuals_.at(solution.x).squaredNorm();
            if (way.norm() > kBack && there.chi2() < here + 1) {
                // Half way it must be as good: else there are two minima
                const Minimum middle = minimise(residuals_.problem(), solution.x + 0.5 * way);
                const double gone = (middle.x - solution.x).norm() / way.norm();
                if (middle.chi2() < here + 1 && gone > 0.25 && gone < 0.75) return way.normalized();
            }
        } catch (const Error&) {
            if (StopSignals::requested()) throw;
        }
    }
    return std::nullopt;
}

Solution Identifier::describe(const Eigen::VectorXd& x) const {
    Minimum minimum;
    minimum.x = x;
    const Eigen::VectorXd low = unknowns_.low(), high = unknowns_.high();
    for (Eigen::Index i = 0; i < x.size(); ++i) minimum.at_bound.push_back(x(i) <= low(i) || x(i) >= high(i));
    return make_solution(minimum);
}

Solution Identifier::estimate(const Eigen::VectorXd& x) const {
    Solution solution = describe(x);
    find_intervals(residuals_, solution, 1);
    return solution;
}

/// Histories are fitted over the first part of their duration, then from the minima found there over all of it.
std::vector<Minimum> Identifier::search_in_stages(std::vector<Start> points, Identification& found) {
    if (!comparison_.has_histories() || comparison_.has_modes() || points.size() < 2) return search(points, found);
    std::vector<Minimum> minima;
    {
        const ShortWindow window(comparison_, kFirstWindow);
        minima = search(points, found);
    }
    points.clear();
    for (const Minimum& one : minima) {
        if (one.chi2() > kFarWorse * minima.front().chi2() + 1) continue;
        const auto known = std::ranges::find_if(
            points, [&](const Start& start) { return (start.x - one.x).cwiseAbs().maxCoeff() < kNear; });
        if (known == points.end())
            points.push_back({one.x});
        else
            ++known->count;
    }
    return search(points, found);
}

/// Where nobody gives the noise: from what the best minimum leaves, which moves with it.
void Identifier::settle_noise(std::vector<Minimum>& minima) const {
    for (int round = 0; round < kNoiseRounds; ++round) {
        const bool is_known = std::ranges::none_of(comparison_.groups(), [](const DataGroup& group) {
            return group.noise_from == DataGroup::NoiseFrom::residuals;
        });
        if (is_known) break;
        comparison_.estimate_noise(comparison_.predict(unknowns_, minima.front().x), unknowns_.size());
        minima.front() = minimise(residuals_.problem(), minima.front().x);
        for (size_t m = 1; m < minima.size(); ++m) minima[m].residual = residuals_.at(minima[m].x);
    }
    sort_by_chi2(minima);
}

/// Those within kAsGood of the best, each once.
std::vector<Solution> Identifier::solutions_of(const std::vector<Minimum>& minima) const {
    std::vector<Solution> solutions;
    for (const Minimum& one : minima) {
        if (one.chi2() > minima.front().chi2() + kAsGood) break;
        const auto known = std::ranges::find_if(solutions, [&](const Solution& s) { return is_same(s.x, one.x); });
        const bool is_valley = !solutions.empty() && !solutions.front().judged.flat.empty();
        if (known != solutions.end() || is_valley) {
            (known != solutions.end() ? *known : solutions.front()).starts += one.starts;
            continue;
        }
        Solution solution = make_solution(one);
        solution.starts = one.starts;
        // Where the best is regular, a singular minimum is a fold beside solutions, none of them
        if (solutions.empty() || solution.judged.flat.empty()) solutions.push_back(std::move(solution));
    }
    return solutions;
}

Identification Identifier::identify(int starts, int seed) {
    const int count = as_int(unknowns_.size());
    if (starts == 0) starts = count == 0 ? 1 : comparison_.has_modes() ? std::min(400, 20 * count) : std::min(64, 8 * count);
    Identification found;
    if (count > 0) {
        const std::vector<bool> none(as_size(count), false);
        const Eigen::VectorXd x = unknowns_.start();
        const Identifiability judged = judge_identifiability(residuals_.jacobian(x), unknowns_, none);
        found.is_underdetermined = is_underdetermined(judged);
        found.flat_in_file = judged.flat;
    }
    if (found.is_underdetermined) {  // there is no end of solutions
        constexpr int kFew = 12;
        starts = 1;
        most_evaluations_ = kFew;
    }
    found.starts = as_size(starts);
    std::vector<Minimum> minima = search_in_stages(starting_points(starts, seed), found);
    if (minima.empty())
        throw Error(ExitCode::numerical_failure,
                    fmt::format("the model has no answer from any of {}: {}",
                                counted(found.starts, "starting point", "starting points"), found.first_failure));
    settle_noise(minima);
    found.solutions = solutions_of(minima);
    if (found.solutions.size() > 1 || (count > 1 && is_nearly_flat(found.solutions.front()))) {
        if (const auto open = find_valley(found.solutions.front())) {
            Solution& best = found.solutions.front();
            best.judged.flat.push_back(*open);
            constexpr double kTakesPart = 0.1;
            for (Eigen::Index i = 0; i < open->size(); ++i)
                if (std::abs((*open)(i)) > kTakesPart) best.judged.deviations(i) = std::numeric_limits<double>::infinity();
            found.solutions.resize(1);
        }
    }
    found.fit = judge_fit(comparison_, found.solutions.front());
    found.is_underdetermined = found.is_underdetermined || is_underdetermined(found.solutions.front().judged);
    for (Solution& solution : found.solutions)
        if (!found.is_underdetermined) find_intervals(residuals_, solution, found.fit.inflation);
    if (comparison_.has_histories()) found.step_bias = find_step_bias(residuals_, found.solutions.front());
    return found;
}

}  // namespace dttmm::host
