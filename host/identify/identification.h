// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "identify/comparison.h"
#include "identify/identifiability.h"
#include "identify/least_squares.h"
#include "identify/unknowns.h"
#include "record/warnings.h"

namespace dttmm::host {

/// A set of values that explains the data as well as any other.
struct Solution {
    Eigen::VectorXd x;          ///< coordinates
    Eigen::VectorXd predicted;  ///< rows of the comparison
    double chi2 = 0;            ///< of the data, without priors
    std::vector<bool> at_bound;
    Eigen::MatrixXd slopes;  ///< of the residuals by the coordinates
    Identifiability judged;
    std::vector<std::optional<double>> low, high;  ///< coordinates at 95 %; none: the data give no limit
    size_t starts = 0;                             ///< descents that led here
};

/// How well the best solution explains the data.
struct Fit {
    double chi2 = 0;
    Eigen::Index points = 0, freedom = 0;  ///< rows; rows less what was fitted
    bool is_noise_independent = false;     ///< of the residuals: only then chi2 can tell a lack of fit
    double chance = 1;                     ///< of so large a chi2 with a true model
    double whiteness = 1;                  ///< chance that residuals as correlated as these are noise; 1: not looked at
    double misfit = 0;     ///< largest RMS of what is left of a history or response, share of its largest value
    double inflation = 1;  ///< of deviations: for correlated residuals, or for noise larger than assumed
    std::vector<std::string> offsets = {};  ///< channels whose residuals have a mean
    bool can_be_judged = true;              ///< the noise is known, or there are samples enough to see a correlation
    bool is_noise_assumed = false;          ///< of some group: what is usual, nobody gave it
    /// Noise that would make chi2 what it should be, per noise that counts.
    double noise_factor() const { return freedom > 0 ? std::sqrt(chi2 / static_cast<double>(freedom)) : 1; }
    bool is_explained() const;
    /// Where nothing is left to judge by: chi2 is far beyond what as many data as there are would give.
    bool is_hopeless() const { return freedom <= 0 && is_noise_independent && chi2 > 4 * static_cast<double>(points) + 20; }
};

struct Identification {
    std::vector<Solution> solutions;  ///< best first
    Fit fit;                          ///< of the best
    size_t starts = 0, descents = 0;  ///< points that were looked at, and those gone down from
    size_t failed = 0;                ///< descents that found nothing
    std::string first_failure;        ///< why
    bool is_underdetermined = false;  ///< there are no more data than unknowns, and they leave some open: none is known
    std::vector<Eigen::VectorXd> flat_in_file;  ///< combinations that the data do not fix at the file's values
    Eigen::VectorXd step_bias;                  ///< of coordinates, by the time step; empty: no histories
};

/// What is known of unknowns before: rows that are added to those of the data.
struct Prior {
    size_t unknown;
    double mean = 0, deviation = 0;  ///< of the value, or where it is lognormal of its logarithm
    bool is_of_logarithm = false;
};

/// Priors as --prior gives them. Throws Error(usage).
std::vector<Prior> read_priors(const std::vector<std::string>& texts, const Unknowns& unknowns,
                               const std::vector<Parameter>& parameters);

/// Finds the sets of values that explain the data, from many starting points (a Sobol sequence within the bounds), and how
/// far each value may be from them.
class Identifier {
public:
    /// All must outlive it. jobs: processes at a time; 0: one per core.
    Identifier(Comparison& comparison, const Unknowns& unknowns, std::vector<Prior> priors, int jobs);

    /// starts: 0: by the kind of the data and the number of unknowns. Throws Error(numerical_failure) if the model has an
    /// answer from none of them.
    Identification identify(int starts, int seed);
    /// From one point, near the minimum; noise as the comparison has it. For bootstraps and tests.
    Solution polish(const Eigen::VectorXd& start) const;
    /// From one point down to the minimum, quickly, to what a comparison of explanations needs: with one-sided differences.
    /// is_hopeless: as in LeastSquares.
    Minimum descend(const Eigen::VectorXd& start, double enough, decltype(LeastSquares::is_hopeless) is_hopeless) const;
    /// Of residuals by some coordinates, at a point where they are known: one-sided differences, a run per coordinate.
    Eigen::MatrixXd differentiate_quickly(const Eigen::VectorXd& x, const Eigen::VectorXd& here,
                                          const std::vector<size_t>& coordinates) const;
    /// Of residuals by coordinates, at a point.
    Eigen::MatrixXd differentiate(const Eigen::VectorXd& x) const { return jacobian(x, false, jobs_); }
    /// What the data say of the unknowns at the values of a minimum, without intervals.
    Solution describe(const Eigen::VectorXd& x) const;
    /// The same with intervals.
    Solution estimate(const Eigen::VectorXd& x) const;
    /// By how much the time step shifts the coordinates of a minimum from what exact motion would give.
    Eigen::VectorXd find_step_bias(const Solution& solution) const;
    /// How well the values of a minimum explain the data.
    Fit judge(const Solution& solution) const { return judge_fit(solution); }

private:
    Eigen::VectorXd residual(const Eigen::VectorXd& x, bool are_logarithmic) const;
    Eigen::VectorXd residual_of(const Eigen::VectorXd& predicted, const Eigen::VectorXd& x, bool are_logarithmic) const;
    Eigen::MatrixXd jacobian(const Eigen::VectorXd& x, bool are_logarithmic, int jobs) const;
    LeastSquares problem(bool are_logarithmic, int jobs) const;
    Minimum search_from(const Eigen::VectorXd& start, int jobs) const;
    /// A point to go down from, and how many descents led to it.
    struct Start {
        Eigen::VectorXd x;
        size_t count = 1;
    };
    std::vector<Start> starting_points(int starts, int seed) const;
    bool is_underdetermined(const Identifiability& judged) const;
    std::vector<Minimum> search(const std::vector<Start>& points, Identification& found);
    std::vector<Minimum> search_in_stages(std::vector<Start> points, Identification& found);
    void settle_noise(std::vector<Minimum>& minima) const;
    std::vector<Solution> solutions_of(const std::vector<Minimum>& minima) const;
    Solution make_solution(const Minimum& minimum) const;
    Eigen::VectorXd weakest_direction(const Solution& solution, double& share) const;
    bool is_nearly_flat(const Solution& solution) const;
    std::optional<Eigen::VectorXd> find_valley(const Solution& solution) const;
    bool is_same(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const;
    Fit judge_fit(const Solution& solution) const;
    double allowed_rise() const;
    void find_intervals(Solution& solution, double inflation) const;
    double rise(const Solution& solution, size_t unknown, double distance, double base) const;

    Comparison& comparison_;
    const Unknowns& unknowns_;
    std::vector<Prior> priors_;
    int jobs_;
    int most_evaluations_ = kMostEvaluations;  ///< of one descent
};

}  // namespace dttmm::host
