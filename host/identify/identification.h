// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "identify/fit.h"
#include "identify/residuals.h"

namespace dttmm::host {

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
    /// What the data say of the unknowns at the values of a minimum, without intervals.
    Solution describe(const Eigen::VectorXd& x) const;
    /// The same with intervals.
    Solution estimate(const Eigen::VectorXd& x) const;
    const Residuals& residuals() const { return residuals_; }

private:
    Eigen::VectorXd by_logarithms(const Eigen::VectorXd& start, int jobs, const SearchEnd& end) const;
    Minimum search_from(const Eigen::VectorXd& start, int jobs) const;
    /// A point to go down from, and how many descents led to it.
    struct Start {
        Eigen::VectorXd x;
        size_t count = 1;
    };
    std::vector<Start> starting_points(int starts, int seed) const;
    bool is_underdetermined(const Identifiability& judged) const;
    bool is_explained_by(const Minimum& minimum) const;
    std::vector<Minimum> descend_from(const std::vector<Start>& points, std::span<const size_t> chosen,
                                      Identification& found) const;
    std::vector<Minimum> search(const std::vector<Start>& points, Identification& found);
    std::vector<Minimum> search_in_stages(std::vector<Start> points, Identification& found);
    void settle_noise(std::vector<Minimum>& minima) const;
    std::vector<Solution> solutions_of(const std::vector<Minimum>& minima) const;
    Solution make_solution(const Minimum& minimum) const;
    Eigen::VectorXd weakest_direction(const Solution& solution, double& share) const;
    bool is_nearly_flat(const Solution& solution) const;
    std::optional<Eigen::VectorXd> find_valley(const Solution& solution) const;
    bool is_same(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const;

    Residuals residuals_;
    Comparison& comparison_;  ///< of these, as the unknowns
    const Unknowns& unknowns_;
    int jobs_;
    int most_evaluations_ = kMostEvaluations;  ///< of one descent
};

}  // namespace dttmm::host
