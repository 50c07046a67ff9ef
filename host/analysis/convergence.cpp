// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/convergence.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <utility>

namespace dttmm::host {

namespace {

// Orders that count as two: 1.6 is a first-order part as large as the second-order one, δ_{k−1}/δ_k = (4 + 2)/(1 + 1) = 3.
constexpr double kLeastSmooth = 1.6, kMostSmooth = 2.5;
constexpr double kLeastOrder = 0.5;  // of what does not seem to converge: 2^p − 1 must not vanish
constexpr double kRoom = 1.5;        // for motion that answers more than linearly

}  // namespace

double observed_order(double difference_before, double difference) {
    return difference_before > 0 && difference > 0 ? std::log2(difference_before / difference)
                                                   : std::numeric_limits<double>::quiet_NaN();
}

Convergence::Rule Convergence::rule_for(double difference_before, double difference) {
    const double p = observed_order(difference_before, difference);
    if (p >= kLeastSmooth && p <= kMostSmooth) return {1.0 / 3, 4, -1, 0};
    const double factor = kRoom / (std::exp2(p < 1 ? std::max(p, kLeastOrder) : 1) - 1);
    return {0, factor, 0, factor / 4};
}

void Convergence::add(std::vector<double> history, double allowance) {
    assert(history.size() % channels_ == 0 && (count_ == 0 || history.size() == newest().size()));
    histories_[0] = std::move(histories_[1]);
    histories_[1] = std::move(histories_[2]);
    histories_[2] = std::move(history);
    if (++count_ < 2) return;

    const std::vector<double> before = std::move(differences_);
    measure_differences();
    rules_.assign(channels_, {1.0 / 3, kRoom, 0, 0});
    for (std::size_t c = 0; c < channels_ && count_ > 2; ++c) rules_[c] = rule_for(before[c], differences_[c]);

    for (Rule& rule : rules_) rule = {rule.share, allowance * rule.now, allowance * rule.before, allowance * rule.alone};

    estimates_.assign(channels_, 0);
    std::vector<double> values(channels_);
    for (std::size_t row = 0; row < rows(); ++row) evaluate_row(row, values, estimates_);
}

void Convergence::measure_differences() {
    differences_.assign(channels_, 0);
    for (std::size_t i = 0; i < newest().size(); ++i)
        differences_[i % channels_] = std::max(differences_[i % channels_], std::abs(newest()[i] - histories_[1][i]));
}

std::span<const double> Convergence::newest_row(std::size_t row) const {
    return std::span(newest()).subspan(row * channels_, channels_);
}

void Convergence::evaluate_row(std::size_t row, std::span<double> values, std::span<double> estimates) const {
    for (std::size_t c = 0; c < channels_; ++c) {
        const std::size_t i = row * channels_ + c;
        const Rule& rule = rules_[c];
        const double y = histories_[2][i], delta = y - histories_[1][i];
        const double delta_before = count_ > 2 ? histories_[1][i] - histories_[0][i] : 0;
        values[c] = y + rule.share * delta;
        estimates[c] = std::max(
            {estimates[c], std::abs(rule.now * delta + rule.before * delta_before), std::abs(rule.alone * delta_before)});
    }
}

}  // namespace dttmm::host
