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
///     histories             value               estimate of its error
///     two                   y_1 + δ_1/3         3/2 |δ_1|                                    the order is not known yet
///     three, p near 2       y_k + δ_k/3         |4 δ_k − δ_{k−1}|                            smooth: Richardson
///     three, any other p    y_k                 3/2 max(|δ_k|, |δ_{k−1}|/4)/(2^p − 1)        p taken within ½ … 1
///
/// Why they bound the error: the integration is of second order where the motion is smooth, error A/4^k + O(16^−k), and of
/// first where a load jumps within a step: an error B_k with |B_k| ≤ |δ_k| whose sign depends on where in the step the jump
/// falls (halving gives δ_{k+1} = ± δ_k/2). The value y_k + δ_k/3 has lost A; of B it keeps at most 4/3 |B_k| + 1/3
/// |B_{k−1}| ≤ 2 |δ_k|, while 4 δ_k − δ_{k−1}, free of A as well, holds at least 2 |δ_k|. Of a smooth motion it is three
/// times the error of the extrapolation before, 45 times that of the value. At any other order p, y_k itself is off by
/// |δ_k|/(2^p − 1); p above one is a mixture, so one is used. The 3/2 is for motion that answers more than linearly.
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

    /// The next history, row by row, `channels` values each; as many rows as the others, all finite. Keeps three.
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
    /// What a channel's value and estimate are made of: y + share δ_k, and the largest of |now δ_k + before δ_{k−1}|,
    /// |alone δ_{k−1}|.
    struct Rule {
        double share, now, before, alone;
    };
    static Rule rule_for(double difference_before, double difference);

    const std::vector<double>& newest() const { return histories_[2]; }
    void measure_differences();

    std::size_t channels_, count_ = 0;
    std::vector<double> histories_[3];  ///< y_{k−2}, y_{k−1}, y_k
    std::vector<double> differences_, estimates_;
    std::vector<Rule> rules_;
};

/// log2(before/now); NaN where one of them is not positive.
double observed_order(double difference_before, double difference);

}  // namespace dttmm::host
