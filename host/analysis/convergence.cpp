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
constexpr double kOfT = 4;           // 3.1 bounds the errors of jumps
constexpr double kLeastOfR = 15;     // of the estimate; 15 bounds the error of kinks to 2.2 times the estimate, 30 to 4.3

}  // namespace

double observed_order(double difference_before, double difference) {
    return difference_before > 0 && difference > 0 ? std::log2(difference_before / difference)
                                                   : std::numeric_limits<double>::quiet_NaN();
}

Convergence::Rule Convergence::rule_for(double difference_before, double difference) {
    const double p = observed_order(difference_before, difference);
    if (p >= kLeastSmooth && p <= kMostSmooth) return {.share = {1.0 / 3}, .error = {4, -1}};
    const double factor = kRoom / (std::exp2(p < 1 ? std::max(p, kLeastOrder) : 1) - 1);
    return {.error = {factor}, .least = {0, factor / 4}};
}

void Convergence::add(std::vector<double> history, double allowance) {
    assert(history.size() % channels_ == 0 && (count_ == 0 || history.size() == newest().size()));
    std::shift_left(std::begin(histories_), std::end(histories_), 1);
    histories_[kKept - 1] = std::move(history);
    if (++count_ < 2) return;

    const std::vector<double> before = std::move(differences_);
    measure_differences();
    rules_.assign(channels_, {.share = {1.0 / 3}, .error = {kRoom}});
    for (std::size_t c = 0; c < channels_ && count_ > 2; ++c) rules_[c] = rule_for(before[c], differences_[c]);
    estimates_ = largest_estimates(rules_);
    if (count_ > 3) extrapolate_twice();
    for (std::size_t c = 0; c < channels_; ++c) {
        for (double* list : {rules_[c].error, rules_[c].least})
            for (int back : {0, 1, 2}) list[back] *= allowance;
        estimates_[c] *= allowance;
    }
}

/// Wherever extrapolation is allowed and that promises less.
void Convergence::extrapolate_twice() {
    constexpr double kError = kOfT / 45, kLeast = 1 / kLeastOfR;
    std::vector<Rule> twice = rules_;
    for (Rule& rule : twice)
        if (rule.share[0] > 0)
            rule = {.share = {19.0 / 45, -1.0 / 45},
                    .error = {64 * kError, -20 * kError, kError},
                    .least = {4 * kLeast, -kLeast}};
    const std::vector<double> estimates = largest_estimates(twice);
    for (std::size_t c = 0; c < channels_; ++c) {
        if (estimates[c] >= estimates_[c]) continue;
        rules_[c] = twice[c];
        estimates_[c] = estimates[c];
    }
}

double Convergence::sum(const double (&factors)[3], std::size_t i) const {
    double sum = 0;
    for (std::size_t back = 0; back < std::min<std::size_t>(3, count_ - 1); ++back)
        sum += factors[back] * (histories_[kKept - 1 - back][i] - histories_[kKept - 2 - back][i]);
    return sum;
}

double Convergence::estimate(const Rule& rule, std::size_t i) const {
    return std::max(std::abs(sum(rule.error, i)), std::abs(sum(rule.least, i)));
}

std::vector<double> Convergence::largest_estimates(const std::vector<Rule>& rules) const {
    std::vector<double> largest(channels_, 0);
    for (std::size_t i = 0; i < newest().size(); ++i)
        largest[i % channels_] = std::max(largest[i % channels_], estimate(rules[i % channels_], i));
    return largest;
}

void Convergence::measure_differences() {
    differences_.assign(channels_, 0);
    for (std::size_t i = 0; i < newest().size(); ++i)
        differences_[i % channels_] =
            std::max(differences_[i % channels_], std::abs(newest()[i] - histories_[kKept - 2][i]));
}

std::span<const double> Convergence::newest_row(std::size_t row) const {
    return std::span(newest()).subspan(row * channels_, channels_);
}

void Convergence::evaluate_row(std::size_t row, std::span<double> values, std::span<double> estimates) const {
    for (std::size_t c = 0; c < channels_; ++c) {
        const std::size_t i = row * channels_ + c;
        const Rule& rule = rules_[c];
        values[c] = newest()[i] + sum(rule.share, i);
        estimates[c] = std::max(estimates[c], estimate(rule, i));
    }
}

}  // namespace dttmm::host
