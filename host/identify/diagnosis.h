// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "analysis/request.h"
#include "identify/comparison.h"
#include "identify/fault_slopes.h"
#include "identify/identification.h"
#include "identify/suspects.h"
#include "identify/unknowns.h"

namespace dttmm::host {

/// An explanation of the data: some elements are softer or stiffer and perhaps otherwise damped than the file has them.
struct Hypothesis {
    std::vector<std::string> elements;                       ///< none: nothing has changed
    bool are_alike = false;                                  ///< all by one factor
    std::vector<double> factors = {};                        ///< of stiffness: of each element; one if they are alike
    std::vector<std::optional<double>> low = {}, high = {};  ///< of the factors at 95 %; none: no limit
    std::vector<bool> are_limits_converged = {};             ///< of each: false: the search for low or high did not converge
    std::vector<double> dampings = {};                       ///< factors of damping, in the order of those that have any;
                                                             ///< one if they are alike; none: it is the file's
    double chi2 = 0;
    double score = 0;  ///< Bayesian information criterion: less is better; only differences mean something
};

struct Diagnosis {
    std::vector<Hypothesis> candidates;  ///< within kDistinct of the best, best first; none: no change is seen
    std::vector<Hypothesis> others;      ///< that were fitted
    Hypothesis unchanged;
    double best_score = 0;
    Fit fit;                                     ///< of the best
    std::vector<std::vector<std::string>> ties;  ///< elements whose change the data show alike
    std::vector<std::string> unseen;             ///< elements whose change the data do not show at all
    std::string step = {};                       ///< a sentence on what the time step does to the best; empty: nothing
    /// Where no change is seen: the loss of stiffness that would be, with the chance kSureChance, in any element but the
    /// unseen. None: a change is seen, or no loss of some element would surely be.
    std::optional<double> least_seen = {};
};

/// Difference of the criterion from which on two explanations count as distinct. Source: Kass and Raftery (1995), Journal
/// of the American Statistical Association 90, 773-795: very strong evidence.
inline constexpr double kDistinct = 10;

/// Chance with which the loss that is printed would be seen.
inline constexpr double kSureChance = 0.95;

/// Fits the suspects alone, all suspects with one factor, and pairs where no single one explains the data.
/// Suspects whose effects are proportional are represented by the first; the others are fitted where it is near the best.
/// common: unknowns that every hypothesis has. All must outlive it.
class Diagnostician {
public:
    Diagnostician(Comparison& comparison, const Unknowns& common, Suspects suspects, int jobs);
    Diagnostician(const Diagnostician&) = delete;  // its slopes keep its suspects
    Diagnostician& operator=(const Diagnostician&) = delete;
    Diagnosis diagnose();

private:
    static constexpr double kEnough = 1e-6;  ///< relative change of chi2 and of the coordinates at which a fit ends
    static constexpr double kNoLimit = std::numeric_limits<double>::infinity();
    struct Trial {
        Hypothesis hypothesis;
        Unknowns unknowns;
        Eigen::VectorXd x, predicted;
        bool is_given_up = false;  ///< it cannot come near the best: x is no minimum
    };
    Unknowns unknowns_of(const Hypothesis& hypothesis, bool with_damping) const {
        return suspects_.unknowns(common_, hypothesis.elements, hypothesis.are_alike, with_damping);
    }
    /// What is fitted, from where: the first of its unknowns.
    struct Start {
        Hypothesis hypothesis;
        Eigen::VectorXd from;
    };
    Trial start_trial(const Hypothesis& hypothesis, bool with_damping, const Eigen::VectorXd& from) const;
    /// limit: a score; a descent that cannot come below it is given up.
    void descend(Trial& trial, int jobs, double enough = kEnough, double limit = kNoLimit) const;
    std::vector<bool> descend_each(std::span<Trial> trials, double enough = kEnough, double limit = kNoLimit) const;
    void take_factors(Trial& trial) const;
    std::vector<Trial> fit_each(std::span<const Start> starts, bool with_damping, double enough, double limit) const;
    std::vector<Trial> fit_all(const std::vector<Start>& starts, double enough = kEnough) const;
    double reach(const Eigen::VectorXd& residual, const Eigen::MatrixXd& slopes, double times) const;
    double reach_by_damping(const Trial& plain) const;
    double limit_near_best(const std::vector<Trial>& trials) const;
    std::vector<Trial> fit_singles(const Trial& null, const std::vector<std::vector<size_t>>& classes,
                                   const Eigen::VectorXd& residual) const;
    std::vector<Start> screen(const Trial& null, std::vector<Start> starts) const;
    void choose_factors(const Trial& null, std::vector<Start>& starts) const;
    Eigen::VectorXd start_of(const Trial& trial) const;
    static void keep_first_of_each(std::vector<Trial>& trials);
    static void sort_by_score(std::vector<Trial>& trials);
    double score(const Eigen::VectorXd& predicted, size_t unknowns) const;
    std::vector<Hypothesis> singles(const Trial& null, const std::vector<std::vector<size_t>>& classes,
                                    const Eigen::VectorXd& residual) const;
    std::vector<Trial> fit_pairs(const Trial& null, const Eigen::VectorXd& residual);
    std::vector<Trial> fit_members(std::span<const Trial> pairs) const;
    Fit judge(const Trial& trial) const;
    void judge_best(const Trial& best, Diagnosis& diagnosis) const;
    void find_ties(Diagnosis& diagnosis) const;
    std::optional<double> find_limit(const Trial& null, size_t suspect, double effect) const;
    std::optional<double> least_seen(const Trial& null) const;
    /// Puts those that the data hardly tell from the best, and that no simpler one explains as well, first; returns how
    /// many.
    static size_t put_candidates_first(std::vector<Trial>& trials);
    void add_intervals(std::span<Trial> trials) const;

    Comparison& comparison_;
    const Unknowns& common_;
    Suspects suspects_;
    int jobs_;
    FaultSlopes slopes_;
};

}  // namespace dttmm::host
