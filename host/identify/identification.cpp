// SPDX-License-Identifier: BSD-3-Clause
#include "identify/identification.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <numeric>

#include "analysis/stop_signals.h"
#include "identify/forked_map.h"
#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "study/design.h"
#include "study/distribution.h"

namespace dttmm::host {

namespace {

constexpr double kSpread = 1.2;        // of starting points in the logarithm: a factor of 3.3 up and down
constexpr double kAsGood = 10;         // of chi2: solutions nearer than this explain the data as well as the best
constexpr double kSame = 1e-3;         // distance of coordinates: one minimum
constexpr double kNear = 0.01;         // the same, of minima of a short window
constexpr double kFarWorse = 4;        // times the least chi2 of a short window: no minimum of the long one
constexpr double kFirstWindow = 0.25;  // share of a history: a short one has fewer side minima
constexpr int kDescended = 4;          // of the starting points of histories and responses: those with the least residual
constexpr int kNoiseRounds = 2;        // estimates of noise from residuals, each followed by a fit
constexpr double kUnlikely = 1e-3;     // chance below which a statement is rejected
constexpr double kAssumedWithin = 3;   // usual noise may be this many times larger or smaller in a given test

/// Solves J d = r for the columns that are not at `fixed`, in the sense of least squares.
Eigen::VectorXd solve_others(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& right, const std::vector<bool>& fixed) {
    std::vector<Eigen::Index> free;
    for (size_t i = 0; i < fixed.size(); ++i)
        if (!fixed[i]) free.push_back(as_row(i));
    Eigen::VectorXd d = Eigen::VectorXd::Zero(jacobian.cols());
    if (free.empty()) return d;
    Eigen::MatrixXd own(jacobian.rows(), as_row(free.size()));
    for (size_t i = 0; i < free.size(); ++i) own.col(as_row(i)) = jacobian.col(free[i]);
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
    solver.setThreshold(1e-6);
    const Eigen::VectorXd part = solver.compute(own).solve(right);
    for (size_t i = 0; i < free.size(); ++i) d(free[i]) = part(as_row(i));
    return d;
}

/// The residuals of a task that changed an unknown.
Eigen::VectorXd column_of(const TaskResult& result, const Unknown& unknown, Eigen::Index rows) {
    if (!result.reason.empty())
        throw Error(ExitCode::numerical_failure, fmt::format("with {} changed by 1 %: {}", unknown.name, result.reason));
    return Eigen::Map<const Eigen::VectorXd>(result.numbers.data(), rows);
}

/// Autocorrelations at lags 1 … count.
std::vector<double> correlations(const Eigen::VectorXd& values, Eigen::Index count) {
    const Eigen::VectorXd own = values.array() - values.mean();
    const double square = own.squaredNorm();
    std::vector<double> result;
    for (Eigen::Index k = 1; k <= count && square > 0; ++k)
        result.push_back(own.head(own.size() - k).dot(own.tail(own.size() - k)) / square);
    return result;
}

/// The chance that a sum of `freedom` squares of normal numbers is larger. Far from its mean it is 0 or 1 to rounding.
double chance_beyond(double chi2, Eigen::Index freedom) {
    const auto n = static_cast<double>(freedom);
    constexpr double kFar = 40;  // standard deviations
    if (!(std::abs(chi2 - n) < kFar * std::sqrt(2 * n))) return chi2 > n ? 0 : 1;
    return boost::math::cdf(complement(boost::math::chi_squared(n), chi2));
}

}  // namespace

bool Fit::is_explained() const {
    const bool is_small = chance > kUnlikely || (is_noise_assumed && noise_factor() < kAssumedWithin);
    return (!is_noise_independent || is_small) && whiteness > kUnlikely && offsets.empty();
}

std::vector<Prior> read_priors(const std::vector<std::string>& texts, const Unknowns& unknowns,
                               const std::vector<Parameter>& parameters) {
    std::vector<Prior> priors;
    for (const std::string& text : texts) {
        const Variation variation = [&] {
            try {
                return parse_variation(text, parameters);
            } catch (const Error& error) {
                std::string why = error.what();
                if (const size_t at = why.find("--vary"); at != why.npos) why.replace(at, 6, "--prior");
                throw Error(error.code(), why);
            }
        }();
        const Distribution& own = variation.distribution;
        if (own.kind != Distribution::Kind::normal && own.kind != Distribution::Kind::lognormal)
            throw Error(ExitCode::usage,
                        fmt::format("--prior {}: it is normal(mean, deviation) or lognormal(mean, deviation); "
                                    "--bounds has ranges",
                                    quote(text)));
        for (const std::string& name : variation.names) {
            const auto found = std::ranges::find(unknowns.all(), name, &Unknown::name);
            if (found == unknowns.all().end())
                throw Error(ExitCode::usage, fmt::format("--prior {}: {} is not free", quote(text), quote(name)));
            Prior prior{as_size(found - unknowns.all().begin()), own.mean, own.deviation};
            if (own.kind == Distribution::Kind::lognormal) {
                const double share = own.deviation / own.mean;
                prior.deviation = std::sqrt(std::log1p(share * share));
                prior.mean = std::log(own.mean) - 0.5 * prior.deviation * prior.deviation;
                prior.is_of_logarithm = true;
            }
            priors.push_back(prior);
        }
    }
    return priors;
}

Identifier::Identifier(Comparison& comparison, const Unknowns& unknowns, std::vector<Prior> priors, int jobs)
    : comparison_(comparison), unknowns_(unknowns), priors_(std::move(priors)), jobs_(jobs) {}

Eigen::VectorXd Identifier::residual(const Eigen::VectorXd& x, bool are_logarithmic) const {
    return residual_of(comparison_.predict(unknowns_, x), x, are_logarithmic);
}

Eigen::VectorXd Identifier::residual_of(const Eigen::VectorXd& predicted, const Eigen::VectorXd& x,
                                        bool are_logarithmic) const {
    Eigen::VectorXd residual(comparison_.rows() + as_row(priors_.size()));
    residual.head(comparison_.rows()) = comparison_.residual(predicted, are_logarithmic);
    for (size_t i = 0; i < priors_.size(); ++i) {
        const double value = unknowns_[priors_[i].unknown].value(x(as_row(priors_[i].unknown)));
        residual(comparison_.rows() + as_row(i)) =
            ((priors_[i].is_of_logarithm ? std::log(value) : value) - priors_[i].mean) / priors_[i].deviation;
    }
    return residual;
}

/// By central differences of the residuals: one formula for all kinds of data.
Eigen::MatrixXd Identifier::jacobian(const Eigen::VectorXd& x, bool are_logarithmic, int jobs) const {
    const auto point = [&](size_t task) {
        Eigen::VectorXd at = x;
        at(as_row(task / 2)) += task % 2 == 0 ? kDifference : -kDifference;
        return at;
    };
    const std::vector<TaskResult> results = map_in_processes(2 * unknowns_.size(), jobs, [&](size_t task) {
        const Eigen::VectorXd own = residual(point(task), are_logarithmic);
        return std::vector<double>(own.begin(), own.end());
    });
    const auto rows = comparison_.rows() + as_row(priors_.size());
    Eigen::MatrixXd jacobian(rows, x.size());
    for (size_t i = 0; i < unknowns_.size(); ++i)
        jacobian.col(as_row(i)) =
            (column_of(results[2 * i], unknowns_[i], rows) - column_of(results[2 * i + 1], unknowns_[i], rows)) /
            (2 * kDifference);
    return jacobian;
}

LeastSquares Identifier::problem(bool are_logarithmic, int jobs) const {
    return {[this, are_logarithmic](const Eigen::VectorXd& x) { return residual(x, are_logarithmic); },
            [this, are_logarithmic, jobs](const Eigen::VectorXd& x, const Eigen::VectorXd&) {
                return jacobian(x, are_logarithmic, jobs);
            },
            unknowns_.low(), unknowns_.high()};
}

Eigen::MatrixXd Identifier::differentiate_quickly(const Eigen::VectorXd& x, const Eigen::VectorXd& here,
                                                  const std::vector<size_t>& coordinates) const {
    const std::vector<TaskResult> results = map_in_processes(coordinates.size(), jobs_, [&](size_t task) {
        Eigen::VectorXd at = x;
        at(as_row(coordinates[task])) += kDifference;
        const Eigen::VectorXd own = residual(at, false);
        return std::vector<double>(own.begin(), own.end());
    });
    Eigen::MatrixXd jacobian(here.size(), as_row(coordinates.size()));
    for (size_t i = 0; i < coordinates.size(); ++i)
        jacobian.col(as_row(i)) = (column_of(results[i], unknowns_[coordinates[i]], here.size()) - here) / kDifference;
    return jacobian;
}

Minimum Identifier::descend(const Eigen::VectorXd& start, double enough,
                            decltype(LeastSquares::is_hopeless) is_hopeless) const {
    LeastSquares quick = problem(false, jobs_);
    quick.is_hopeless = std::move(is_hopeless);
    std::vector<size_t> all(unknowns_.size());
    std::iota(all.begin(), all.end(), size_t{0});
    quick.jacobian = [this, all](const Eigen::VectorXd& x, const Eigen::VectorXd& here) {
        return differentiate_quickly(x, here, all);
    };
    return minimise(quick, start, {kMostEvaluations, enough});
}

Minimum Identifier::search_from(const Eigen::VectorXd& start, int jobs) const {
    if (!comparison_.has_responses()) return minimise(problem(false, jobs), start, {most_evaluations_});
    const Minimum by_logarithms = minimise(problem(true, jobs), start);
    return minimise(problem(false, jobs), by_logarithms.x);
}

bool Identifier::is_underdetermined(const Identifiability& judged) const {
    const auto live = std::ranges::count(judged.is_dead, false);
    return comparison_.rows() + as_row(priors_.size()) - comparison_.scales() <= live && !judged.flat.empty();
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

/// Of modes every point is descended from; of histories and responses those that come nearest to the data.
std::vector<Minimum> Identifier::search(const std::vector<Start>& points, Identification& found) {
    std::vector<size_t> chosen(points.size());
    std::iota(chosen.begin(), chosen.end(), size_t{0});
    const bool is_by_residual = !comparison_.has_modes();
    if (is_by_residual && points.size() > kDescended) {
        const std::vector<TaskResult> sums = map_in_processes(
            points.size(), jobs_, [&](size_t p) { return std::vector<double>{residual(points[p].x, true).squaredNorm()}; });
        const auto sum_of = [&](size_t p) {
            return sums[p].reason.empty() ? sums[p].numbers.front() : std::numeric_limits<double>::infinity();
        };
        std::stable_sort(chosen.begin() + 1, chosen.end(), [&](size_t a, size_t b) { return sum_of(a) < sum_of(b); });
        chosen.resize(kDescended);
    }
    found.descents = 0;
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
        minima.push_back(std::move(minimum));
    }
    std::ranges::stable_sort(minima, [](const Minimum& a, const Minimum& b) { return a.chi2() < b.chi2(); });
    return minima;
}

/// Near each other, or joined by a straight valley.
bool Identifier::is_same(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
    if ((a - b).cwiseAbs().maxCoeff() < kSame) return true;
    const double highest = std::max(residual(a, false).squaredNorm(), residual(b, false).squaredNorm());
    for (const double share : {0.5, 0.25, 0.75}) {
        try {
            if (residual(a + share * (b - a), false).squaredNorm() > highest + 1) return false;
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
    solution.slopes = jacobian(minimum.x, false, jobs_);
    const Eigen::MatrixXd& slopes = solution.slopes;
    // A combination that the data do not fix may have ended at a bound, which makes none of its unknowns known
    solution.judged = judge_identifiability(slopes, unknowns_, std::vector<bool>(unknowns_.size(), false));
    if (solution.judged.flat.empty()) solution.judged = judge_identifiability(slopes, unknowns_, minimum.at_bound);
    solution.low.resize(unknowns_.size());
    solution.high.resize(unknowns_.size());
    return solution;
}

Solution Identifier::polish(const Eigen::VectorXd& start) const {
    Solution solution = make_solution(minimise(problem(false, jobs_), start));
    find_intervals(solution, 1);
    return solution;
}

/// The direction of the unknowns that the data fix least: derivatives by differences may hide that it is open.
Eigen::VectorXd Identifier::weakest_direction(const Solution& solution, double& share) const {
    const Eigen::MatrixXd slopes = jacobian(solution.x, false, jobs_);
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
            const Minimum there = minimise(problem(false, jobs_), start);
            const Eigen::VectorXd way = there.x - solution.x;
            const double here = residual(solution.x, false).squaredNorm();
            if (way.norm() > kBack && there.chi2() < here + 1) {
                // Half way it must be as good: else there are two minima
                const Minimum middle = minimise(problem(false, jobs_), solution.x + 0.5 * way);
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
    find_intervals(solution, 1);
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
        minima.front() = minimise(problem(false, jobs_), minima.front().x);
        for (size_t m = 1; m < minima.size(); ++m) minima[m].residual = residual(minima[m].x, false);
    }
    std::ranges::stable_sort(minima, [](const Minimum& a, const Minimum& b) { return a.chi2() < b.chi2(); });
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
        const Identifiability judged = judge_identifiability(jacobian(x, false, jobs_), unknowns_, none);
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
    found.fit = judge_fit(found.solutions.front());
    found.is_underdetermined = found.is_underdetermined || is_underdetermined(found.solutions.front().judged);
    for (Solution& solution : found.solutions)
        if (!found.is_underdetermined) find_intervals(solution, found.fit.inflation);
    if (comparison_.has_histories()) found.step_bias = find_step_bias(found.solutions.front());
    return found;
}

namespace {

constexpr Eigen::Index kFewestCorrelated = 20, kMostLags = 20;  // samples; lags

/// Of residuals.
struct Correlation {
    double chance = 1;  ///< that noise has as much
    double memory = 1;  ///< samples that tell no more than one
};

/// Source: Ljung and Box (1978), Biometrika 65, 297-303.
Correlation judge_correlation(const Eigen::VectorXd& residual) {
    const std::vector<double> rho = correlations(residual, std::min(kMostLags, residual.size() / 5));
    const auto n = static_cast<double>(residual.size());
    Correlation found;
    double Q = 0;
    bool is_open = true;
    for (size_t k = 0; k < rho.size(); ++k) {
        Q += n * (n + 2) * rho[k] * rho[k] / (n - static_cast<double>(k + 1));
        is_open = is_open && rho[k] > 2 / std::sqrt(n);
        if (is_open) found.memory += 2 * rho[k];
    }
    if (!rho.empty()) found.chance = chance_beyond(Q, as_row(rho.size()));
    return found;
}

}  // namespace

Fit Identifier::judge_fit(const Solution& solution) const {
    Fit fit;
    fit.chi2 = solution.chi2;
    fit.points = comparison_.rows();
    Eigen::Index sought = comparison_.scales();
    for (size_t i = 0; i < unknowns_.size(); ++i) sought += !solution.judged.is_dead[i] && !solution.at_bound[i];
    sought -= as_row(solution.judged.flat.size());
    fit.freedom = fit.points - sought;
    fit.is_noise_independent = std::ranges::none_of(
        comparison_.groups(), [](const DataGroup& group) { return group.noise_from == DataGroup::NoiseFrom::residuals; });
    fit.is_noise_assumed = std::ranges::any_of(
        comparison_.groups(), [](const DataGroup& group) { return group.noise_from == DataGroup::NoiseFrom::assumed; });
    if (fit.freedom > 0) fit.chance = chance_beyond(fit.chi2, fit.freedom);
    size_t samples = 0;
    for (const DataGroup& group : comparison_.groups()) samples += group.noise_samples;
    if (samples > 0 && fit.freedom > 0)  // the noise itself is an estimate
        fit.chance = boost::math::cdf(
            complement(boost::math::fisher_f(static_cast<double>(fit.freedom), static_cast<double>(samples)),
                       fit.chi2 / static_cast<double>(fit.freedom)));
    const Eigen::VectorXd residual = comparison_.residual(solution.predicted, false);
    for (const DataGroup& group : comparison_.groups()) {
        if (group.kind == DataGroup::Kind::frequency || group.kind == DataGroup::Kind::shape) continue;
        const double squares = (solution.predicted - comparison_.data()).segment(group.first, group.count).squaredNorm();
        fit.misfit = std::max(fit.misfit, std::sqrt(squares / static_cast<double>(group.count)) / group.largest);
    }
    double sum = 0;
    int looked_at = 0;
    for (const DataGroup& group : comparison_.groups()) {
        const bool is_curve = group.kind == DataGroup::Kind::history || group.kind == DataGroup::Kind::response;
        if (!is_curve || group.count < kFewestCorrelated || group.noise <= kLeastNoise * group.largest) continue;
        const Eigen::Index stride = group.kind == DataGroup::Kind::response ? 2 : 1;
        const Eigen::VectorXd own = Eigen::Map<const Eigen::VectorXd, 0, Eigen::InnerStride<>>(
            residual.data() + group.first, group.count / stride, Eigen::InnerStride<>(stride));
        const Correlation found = judge_correlation(own);
        fit.whiteness = std::min(fit.whiteness, found.chance);
        // A mean that noise does not explain is an offset of the sensor
        constexpr double kOffset = 5;  // standard deviations of the mean
        if (group.kind == DataGroup::Kind::history && std::abs(own.sum()) > kOffset * own.norm())
            fit.offsets.push_back(group.name);
        sum += found.memory;
        ++looked_at;
    }
    fit.whiteness = std::min(1.0, fit.whiteness * std::max(1, looked_at));
    constexpr double kExact = 1e-7;  // share of the largest value: data that the model made itself leave rounding
    fit.can_be_judged = fit.is_noise_independent || looked_at > 0 || fit.misfit < kExact;
    if (looked_at > 0 && fit.whiteness < kUnlikely) fit.inflation = std::sqrt(sum / looked_at);
    if (fit.is_noise_assumed && fit.chance < kUnlikely) fit.inflation = std::max(fit.inflation, fit.noise_factor());
    return fit;
}

/// How far chi2 rises when one unknown is moved and the others follow.
double Identifier::rise(const Solution& solution, size_t unknown, double distance, double base) const {
    const Eigen::MatrixXd& jacobian = solution.slopes;
    constexpr int kRounds = 2;  // the first is exact for a linear model
    std::vector<bool> fixed = solution.at_bound;
    for (size_t i = 0; i < fixed.size(); ++i) fixed[i] = fixed[i] || solution.judged.is_dead[i] || i == unknown;
    Eigen::VectorXd x = solution.x;
    x(as_row(unknown)) += distance;
    Eigen::VectorXd step = distance * jacobian.col(as_row(unknown));
    x -= solve_others(jacobian, step, fixed);
    double least = std::numeric_limits<double>::infinity();
    for (int round = 0; round < kRounds; ++round) {
        x = x.cwiseMax(unknowns_.low()).cwiseMin(unknowns_.high());
        const Eigen::VectorXd own = residual(x, false);
        least = std::min(least, own.squaredNorm());
        const Eigen::VectorXd before = x;
        if (round + 1 < kRounds) x -= solve_others(jacobian, own, fixed);
        if (x == before) break;  // there are no others
    }
    return std::max(0.0, least - base);
}

/// Of chi2, at the ends of an interval of 95 %. Where the noise is an estimate, by the fewest differences behind it.
double Identifier::allowed_rise() const {
    Eigen::Index freedom = std::numeric_limits<Eigen::Index>::max();
    for (const DataGroup& group : comparison_.groups()) {
        if (group.noise_from == DataGroup::NoiseFrom::residuals)
            freedom = std::min(freedom, comparison_.rows() - comparison_.scales() - as_row(unknowns_.size()));
        if (group.noise_samples > 0) freedom = std::min(freedom, as_row(group.noise_samples));
    }
    if (freedom <= 0 || freedom == std::numeric_limits<Eigen::Index>::max())
        return boost::math::quantile(boost::math::chi_squared(1), 0.95);
    return boost::math::quantile(boost::math::fisher_f(1, static_cast<double>(freedom)), 0.95);
}

/// Where chi2 has risen by what 95 % allow: from the curvature first, then by the profile of chi2 itself.
void Identifier::find_intervals(Solution& solution, double inflation) const {
    const double allowed = inflation * inflation * allowed_rise();
    const double base = residual_of(solution.predicted, solution.x, false).squaredNorm();
    const auto limit = [&](size_t unknown, double sign) -> std::optional<double> {
        const Unknown& one = unknowns_[unknown];
        const double deviation = solution.judged.deviations(as_row(unknown)), x = solution.x(as_row(unknown));
        const double bound = one.coordinate(sign > 0 ? one.high : one.low), reach = std::abs(bound - x);
        if (solution.judged.is_dead[unknown] || !std::isfinite(deviation)) return std::nullopt;
        double distance = deviation > 0 ? std::sqrt(allowed) * deviation : 0.1 * reach;
        constexpr int kMostTries = 8;
        for (int round = 0; round < kMostTries; ++round) {
            distance = std::min(distance, reach);
            double risen = 0;
            try {
                risen = rise(solution, unknown, sign * distance, base);
            } catch (const Error&) {
                return std::nullopt;
            }
            constexpr double kEnough = 0.1;  // of what is allowed: 5 % of the interval
            if (std::abs(risen - allowed) < kEnough * allowed) return x + sign * distance;
            if (distance >= reach && risen < allowed) return std::nullopt;
            // chi2 is nearly a parabola; far from one no step is trusted beyond a factor of three
            distance *= std::clamp(std::sqrt(allowed / std::max(risen, 1e-12)), 1.0 / 3, 3.0);
        }
        return x + sign * distance;
    };
    const std::vector<TaskResult> limits = map_in_processes(2 * unknowns_.size(), jobs_, [&](size_t task) {
        const std::optional<double> found = limit(task / 2, task % 2 == 0 ? -1 : 1);
        return found ? std::vector<double>{*found} : std::vector<double>();
    });
    for (size_t i = 0; i < unknowns_.size(); ++i) {
        if (!limits[2 * i].numbers.empty()) solution.low[i] = limits[2 * i].numbers.front();
        if (!limits[2 * i + 1].numbers.empty()) solution.high[i] = limits[2 * i + 1].numbers.front();
        if (solution.at_bound[i]) {
            const bool is_low = solution.x(as_row(i)) <= unknowns_.low()(as_row(i));
            (is_low ? solution.low : solution.high)[i].reset();
        }
    }
}

/// The scheme is of second order: what halving the step changes is three quarters of the error.
Eigen::VectorXd Identifier::find_step_bias(const Solution& solution) const {
    const Eigen::VectorXd finer = comparison_.predict(unknowns_, solution.x, 2);
    Eigen::VectorXd error = Eigen::VectorXd::Zero(comparison_.rows() + as_row(priors_.size()));
    error.head(comparison_.rows()) = 4.0 / 3 * (finer - solution.predicted).cwiseQuotient(comparison_.deviations());
    std::vector<bool> fixed = solution.at_bound;
    for (size_t i = 0; i < fixed.size(); ++i) fixed[i] = fixed[i] || solution.judged.is_dead[i];
    return solve_others(solution.slopes, error, fixed);
}

}  // namespace dttmm::host
