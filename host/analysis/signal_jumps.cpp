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
constexpr double kLeastJump = 0.01;          // of the range: the 1 % to which loads are looked at (load_speed.h)
/// The same of a motor: a millionth of 1 rad within a step of 1 ms is an acceleration of 1 rad/s².
constexpr double kLeastJumpOfMotion = 1e-6;

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
    const double width = duration / kLooks, part = width / kCuts;
    const std::vector<double> looks = look_at(value, 0, width, kLooks), bends = bends_of(looks);
    std::vector<double> steps = looks;
    std::adjacent_difference(steps.begin(), steps.end(), steps.begin());
    steps.erase(steps.begin());
    const double least_jump = kLeastJumpOfMotion * range_of(looks), least_kink = kLeastJump * range_of(steps) / width;
    std::optional<Jump> jump, kink;
    for (size_t i = 3; i + 3 < bends.size(); ++i) {
        // What is smooth bends about as much three looks away
        const double own = std::abs(bends[i]), nearby = std::max(std::abs(bends[i - 3]), std::abs(bends[i + 3]));
        if (!(own > 0.4 * least_jump && own > 2 * nearby)) continue;
        // In a 64th of the time a jump bends as much, a jump of the slope a 64th, and what is smooth a 64th of that
        const double start = static_cast<double>(i - 1) * width;
        const std::vector<double> fine = bends_of(look_at(value, start, part, 2 * kCuts));
        const size_t sharpest = largest_of(fine);
        const double time = start + static_cast<double>(sharpest) * part, bend = std::abs(fine[sharpest]);
        if (bend > 0.4 * own) {
            // It bends up before it and down behind it
            const bool is_before = std::abs(fine[sharpest - 1]) > std::abs(fine[sharpest + 1]);
            const double size = fine[sharpest] * (is_before ? -1 : 1);
            if (std::abs(size) > std::max(least_jump, jump ? std::abs(jump->size) : 0))
                jump = {is_before ? time - part : time, size, false};
        } else if (bend > 0.4 / kCuts * own) {
            // Between two looks it bends both
            const double change = (fine[sharpest - 1] + fine[sharpest] + fine[sharpest + 1]) / part;
            if (std::abs(change) > std::max(least_kink, kink ? std::abs(kink->size) : 0)) kink = {time, change, true};
        }
    }
    return jump ? jump : kink;
}

}  // namespace dttmm::host
