// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace dttmm::host {

/// Histories y_0, y_1, … of one motion at the steps h, h/2, h/4, …, on the same output times, and what they tell about the
/// error of the last. With δ_k = y_k − y_{k−1}, per channel:
///
///     observed order   p = log2(max|δ_{k−1}| / max|δ_k|)    maxima over time; needs three histories
///
///     histories           value                             estimate E of its error
///     two                 y_1 + δ_1/3                       3/2 |δ_1|: the order is not known yet
///     three, p near 2     R = y_k + δ_k/3                   E_R = |4 δ_k − δ_{k−1}|: smooth, Richardson
///     four, p near 2      T = y_k + (19 δ_k − δ_{k−1})/45   E_T = max(4 |T_k − T_{k−1}|, E_R/6.5): the same twice
///     three, other p      y_k                               3/2 max(|δ_k|, |δ_{k−1}|/4)/(2^p − 1), p within ½ … 1
///
/// Why they bound the error: the integration is of second order where the motion is smooth, error A/4^k + C/16^k + O(64^−k),
/// and of first where a load jumps within a step: an error B_k with |B_k| ≤ |δ_k| whose sign depends on where in the step
/// the jump falls (halving gives δ_{k+1} = ± δ_k/2). R has lost A; of B it keeps at most 4/3 |B_k| + 1/3 |B_{k−1}| ≤ 2
/// |δ_k|, while 4 δ_k − δ_{k−1}, free of A as well, holds at least 2 |δ_k|. Of a smooth motion it is three times the error
/// of the extrapolation before, 45 times that of R. T has lost C, too, and |T_k − T_{k−1}| is 63 times what it keeps.
///
/// A load that jumps, or whose slope or curvature does, at the share θ of the first step has an error h_k^n b_n({2^k θ}),
/// b_n the Bernoulli polynomial of n = 1, 2, 3. That of R is then at most 2/3 of E_R; that of T is at most 0.78, 0.94 and
/// 0.25 of E_T. At n = 2 |T_k − T_{k−1}| vanishes at some θ while T is off, and E_R/6.5 stands in.
///
/// At any other order p, y_k itself is off by |δ_k|/(2^p − 1); p above one is a mixture, so one is used. The 3/2 is for
/// motion that answers more than linearly.
///
/// What all histories miss alike no estimate sees: a pulse between their steps; the acceleration in a row less than a step
/// from a jump, which in every one of them lies between those before and after; and a vibration too fast for their steps.
/// For the last there is an allowance: a factor on all estimates.
///
/// An error passes through zero and says nothing there: estimates are maxima over time, up to and including a row, or of the
/// whole history.
/// Source: Richardson (1911), Phil. Trans. R. Soc. A 210, 307–357.
class Convergence {
public:
    explicit Convergence(std::size_t channels) : channels_(channels) {}

    /// The next history, row by row, `channels` values each; as many rows as the others, all finite. Keeps four.
    /// allowance: factor on the estimates, until the next history.
    void add(std::vector<double> history, double allowance = 1);

    std::size_t histories() const { return count_; }
    std::size_t rows() const { return count_ > 0 ? newest().size() / channels_ : 0; }
    /// The last history given.
    std::span<const double> newest_row(std::size_t row) const;

    /// Per channel: largest |δ_k| of the last pair; estimate over the whole history. Both empty before the second history.
    const std::vector<double>& differences() const { return differences_; }
    const std::vector<double>& estimates() const { return estimates_; }

    /// values: of the row, per channel. estimates: in, those of the row before (zero at first); out, those up to this row.
    /// Needs two histories.
    void evaluate_row(std::size_t row, std::span<double> values, std::span<double> estimates) const;

private:
    static constexpr std::size_t kDifferences = 3;  ///< δ_k, δ_{k−1}, δ_{k−2} of the histories kept
    using Factors = double[kDifferences];
    /// What a channel's value and estimate are made of: y_k + Σ share δ, and the larger of |Σ error δ| and |Σ least δ|.
    struct Rule {
        Factors share = {}, error = {}, least = {};
    };
    Rule rule_for(double difference_before, double difference) const;
    double weighted_differences(const Factors& factors, std::size_t i) const;
    double estimate(const Rule& rule, std::size_t i) const;
    const std::vector<double>& newest() const { return histories_[kDifferences]; }
    void measure_differences();

    std::size_t channels_, count_ = 0;
    std::vector<double> histories_[kDifferences + 1];  ///< y_{k−3} … y_k
    std::vector<double> differences_, estimates_;
    std::vector<Rule> rules_;
};

/// log2(before/now); NaN where one of them is not positive.
double observed_order(double difference_before, double difference);

}  // namespace dttmm::host
