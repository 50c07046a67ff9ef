// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/convergence.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace dttmm::host {

namespace {

// Orders that count as two: 1.6 is a first-order part as large as the second-order one, δ_{k−1}/δ_k = (4 + 2)/(1 + 1) = 3.
constexpr double kLeastSmooth = 1.6, kMostSmooth = 2.5;
constexpr double kLeastOrder = 0.5;  // of what does not seem to converge: 2^p − 1 must not vanish
constexpr double kRoom = 1.5;        // for motion that answers more than linearly
// Of |T_k − T_{k−1}| and of E_R, in the estimate of T: with 3.1 and 1/7 the errors of jumps and kinks just reach it
constexpr double kOfChange = 4, kOfEstimate = 1 / 6.5;

}  // namespace

double observed_order(double difference_before, double difference) {
    return difference_before > 0 && difference > 0 ? std::log2(difference_before / difference)
                                                   : std::numeric_limits<double>::quiet_NaN();
}

Convergence::Rule Convergence::rule_for(double difference_before, double difference) const {
    if (count_ == 2) return {.share = {1.0 / 3}, .error = {kRoom}};
    const double p = observed_order(difference_before, difference);
    if (!(p >= kLeastSmooth && p <= kMostSmooth)) {
        const double factor = kRoom / (std::exp2(p < 1 ? std::max(p, kLeastOrder) : 1) - 1);
        return {.error = {factor}, .least = {0, factor / 4}};
    }
    if (count_ == 3) return {.share = {1.0 / 3}, .error = {4, -1}};
    // T_k − T_{k−1} = (64 δ_k − 20 δ_{k−1} + δ_{k−2})/45
    constexpr double kError = kOfChange / 45;
    return {.share = {19.0 / 45, -1.0 / 45},
            .error = {64 * kError, -20 * kError, kError},
            .least = {4 * kOfEstimate, -kOfEstimate}};
}

void Convergence::add(std::vector<double> history, double allowance) {
    assert(history.size() % channels_ == 0 && (count_ == 0 || history.size() == newest().size()));
    std::shift_left(std::begin(histories_), std::end(histories_), 1);
    histories_[kDifferences] = std::move(history);
    if (++count_ < 2) return;

    const std::vector<double> before = std::move(differences_);
    measure_differences();
    rules_.resize(channels_);
    for (std::size_t c = 0; c < channels_; ++c) {
        rules_[c] = rule_for(count_ > 2 ? before[c] : 0, differences_[c]);
        for (double* list : {rules_[c].error, rules_[c].least})
            for (std::size_t back = 0; back < kDifferences; ++back) list[back] *= allowance;
    }
    estimates_.assign(channels_, 0);
    for (std::size_t i = 0; i < newest().size(); ++i)
        estimates_[i % channels_] = std::max(estimates_[i % channels_], estimate(rules_[i % channels_], i));
}

double Convergence::weighted_differences(const Factors& factors, std::size_t i) const {
    double sum = 0;
    for (std::size_t back = 0; back < std::min(kDifferences, count_ - 1); ++back)
        sum += factors[back] * (histories_[kDifferences - back][i] - histories_[kDifferences - back - 1][i]);
    return sum;
}

double Convergence::estimate(const Rule& rule, std::size_t i) const {
    return std::max(std::abs(weighted_differences(rule.error, i)), std::abs(weighted_differences(rule.least, i)));
}

void Convergence::measure_differences() {
    differences_.assign(channels_, 0);
    for (std::size_t i = 0; i < newest().size(); ++i)
        differences_[i % channels_] =
            std::max(differences_[i % channels_], std::abs(newest()[i] - histories_[kDifferences - 1][i]));
}

std::span<const double> Convergence::newest_row(std::size_t row) const {
    return std::span(newest()).subspan(row * channels_, channels_);
}

void Convergence::evaluate_row(std::size_t row, std::span<double> values, std::span<double> estimates) const {
    for (std::size_t c = 0; c < channels_; ++c) {
        const std::size_t i = row * channels_ + c;
        const Rule& rule = rules_[c];
        values[c] = newest()[i] + weighted_differences(rule.share, i);
        estimates[c] = std::max(estimates[c], estimate(rule, i));
    }
}

}  // namespace dttmm::host
