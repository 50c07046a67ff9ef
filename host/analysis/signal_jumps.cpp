// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/signal_jumps.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace dttmm::host {

namespace {

constexpr int kLooks = 1 << 14, kCuts = 6;  // 2^20 parts of the duration
constexpr double kLeastJump = 0.01;         // of the range

/// Half of [from, to] again and again, the half across which the value changes more.
Jump narrow(const std::function<double(double)>& value, double from, double to) {
    double before = value(from), after = value(to);
    for (int cut = 0; cut < kCuts; ++cut) {
        const double middle = 0.5 * (from + to), there = value(middle);
        if (std::abs(there - before) > std::abs(after - there))
            to = middle, after = there;
        else
            from = middle, before = there;
    }
    return {from, after - before};
}

}  // namespace

std::optional<Jump> find_jump(const std::function<double(double)>& value, double duration) {
    const double width = duration / kLooks;
    std::vector<double> samples(kLooks + 1);
    for (int i = 0; i <= kLooks; ++i) samples[static_cast<size_t>(i)] = value(i * width);
    const auto [least, most] = std::ranges::minmax(samples);
    std::optional<Jump> largest;
    for (size_t i = 0; i < kLooks; ++i) {
        const double change = samples[i + 1] - samples[i];
        // Written so that a value that is not a number has none
        if (!(std::abs(change) > kLeastJump * (most - least)) || (largest && std::abs(change) <= std::abs(largest->size)))
            continue;
        // What is smooth has a 64th of the change left
        const Jump found = narrow(value, static_cast<double>(i) * width, static_cast<double>(i + 1) * width);
        if (std::abs(found.size) > 0.5 * std::abs(change)) largest = found;
    }
    return largest;
}

std::optional<Jump> find_jump_of_slope(const std::function<double(double)>& value, double duration) {
    const double width = duration / kLooks / (1 << kCuts) / 16;  // a jump of the slope is a rise as wide
    return find_jump([&](double t) { return (value(t + width) - value(t)) / width; }, duration);
}

}  // namespace dttmm::host
