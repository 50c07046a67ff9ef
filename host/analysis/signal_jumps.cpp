// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/signal_jumps.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <vector>

#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr int kLooks = 1 << 14, kCuts = 64;  // 2^20 parts of the duration
constexpr double kLeastJump = 0.01;          // of the range

std::vector<double> look_at(const std::function<double(double)>& value, double from, double width, int count) {
    std::vector<double> looks(as_size(count) + 1);
    for (int i = 0; i <= count; ++i) looks[as_size(i)] = value(from + i * width);
    return looks;
}

double range_of(const std::vector<double>& values) {
    const auto [least, most] = std::ranges::minmax(values);
    return most - least;
}

/// By how much the differences change at each inner value.
std::vector<double> bends_of(const std::vector<double>& values) {
    std::vector<double> bends(values.size(), 0.0);
    for (size_t i = 1; i + 1 < values.size(); ++i) bends[i] = values[i - 1] - 2 * values[i] + values[i + 1];
    return bends;
}

size_t largest_of(const std::vector<double>& values) {
    return as_size(as_int(std::ranges::max_element(values, {}, [](double x) { return std::abs(x); }) - values.begin()));
}

}  // namespace

std::optional<Jump> find_jump(const std::function<double(double)>& value, double duration) {
    const double width = duration / kLooks;
    const std::vector<double> looks = look_at(value, 0, width, kLooks);
    const double range = range_of(looks);
    std::optional<Jump> largest;
    for (size_t i = 0; i < kLooks; ++i) {
        const double change = looks[i + 1] - looks[i];
        // Written so that a value that is not a number has none
        if (!(std::abs(change) > kLeastJump * range) || (largest && std::abs(change) <= std::abs(largest->size))) continue;
        // What is smooth has a 64th of the change in a 64th of the time
        const double start = static_cast<double>(i) * width, part = width / kCuts;
        std::vector<double> parts = look_at(value, start, part, kCuts);
        std::adjacent_difference(parts.begin(), parts.end(), parts.begin());
        parts.front() = 0;
        const size_t steepest = largest_of(parts);
        if (std::abs(parts[steepest]) > 0.5 * std::abs(change))
            largest = {start + (static_cast<double>(steepest) - 1) * part, parts[steepest], false};
    }
    return largest;
}

std::optional<Jump> find_jump_of_speed(const std::function<double(double)>& value, double duration) {
    constexpr int kCandidates = 32;
    const double width = duration / kLooks, part = width / kCuts;
    const std::vector<double> looks = look_at(value, 0, width, kLooks), bends = bends_of(looks);
    std::vector<double> steps = looks;
    std::adjacent_difference(steps.begin(), steps.end(), steps.begin());
    steps.erase(steps.begin());
    const double range = range_of(looks), range_of_slope = range_of(steps) / width;
    std::vector<size_t> order(bends.size());
    std::iota(order.begin(), order.end(), size_t{0});
    const auto half = order.begin() + kCandidates;
    std::ranges::partial_sort(order, half, std::greater(), [&](size_t i) { return std::abs(bends[i]); });
    std::optional<Jump> jump, kink;
    for (auto candidate = order.begin(); candidate != half; ++candidate) {
        const size_t i = *candidate;
        if (i == 0 || i + 1 >= looks.size() || !(std::abs(bends[i]) > 1e-6 * range)) continue;
        // In a 64th of the time a jump bends as much, a jump of the slope a 64th, and what is smooth a 64th of that
        const double start = static_cast<double>(i - 1) * width;
        const std::vector<double> fine = bends_of(look_at(value, start, part, 2 * kCuts));
        const size_t sharpest = largest_of(fine);
        const double share = std::abs(fine[sharpest] / bends[i]), time = start + static_cast<double>(sharpest) * part;
        if (share > 0.4) {
            if (!jump || std::abs(fine[sharpest]) > std::abs(jump->size)) jump = {time, fine[sharpest], false};
        } else if (share > 0.4 / kCuts && std::abs(fine[sharpest]) > kLeastJump * range_of_slope * part &&
                   (!kink || std::abs(fine[sharpest]) / part > std::abs(kink->size))) {
            // Between two looks it bends both
            kink = {time, (fine[sharpest - 1] + fine[sharpest] + fine[sharpest + 1]) / part, true};
        }
    }
    return jump ? jump : kink;
}

}  // namespace dttmm::host
