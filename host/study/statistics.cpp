// SPDX-License-Identifier: BSD-3-Clause
#include "study/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace dttmm::host {

namespace {

constexpr double kNothing = std::numeric_limits<double>::quiet_NaN();

double quantile_of(const std::vector<double>& sorted, double share) {
    const double place = share * static_cast<double>(sorted.size() - 1);
    const auto below = static_cast<size_t>(place);
    const size_t above = std::min(below + 1, sorted.size() - 1);
    return sorted[below] + (place - static_cast<double>(below)) * (sorted[above] - sorted[below]);
}

}  // namespace

double compute_rank_correlation(std::span<const double> x, std::span<const double> y) {
    std::vector<double> both_x, both_y;
    for (size_t i = 0; i < x.size(); ++i)
        if (!std::isnan(x[i]) && !std::isnan(y[i])) both_x.push_back(x[i]), both_y.push_back(y[i]);
    return compute_correlation(compute_ranks(both_x), compute_ranks(both_y));
}

FigureStatistics compute_statistics(std::span<const double> values) {
    std::vector<double> sorted;
    std::ranges::copy_if(values, std::back_inserter(sorted), [](double value) { return !std::isnan(value); });
    std::ranges::sort(sorted);
    FigureStatistics result;
    result.count = sorted.size();
    result.mean = result.deviation = result.minimum = result.maximum = kNothing;
    result.quantiles.fill(kNothing);
    if (sorted.empty()) return result;
    const auto count = static_cast<double>(sorted.size());
    // About the first number: what all have in common costs no digits
    double sum = 0, squares = 0;
    for (const double value : sorted) sum += value - sorted.front();
    const double mean = sum / count;
    for (const double value : sorted) squares += std::pow(value - sorted.front() - mean, 2);
    result.mean = sorted.front() + mean;
    if (sorted.size() > 1) result.deviation = std::sqrt(squares / (count - 1));
    result.minimum = sorted.front();
    result.maximum = sorted.back();
    for (size_t q = 0; q < result.quantiles.size(); ++q)
        result.quantiles[q] = quantile_of(sorted, FigureStatistics::kShares[q]);
    return result;
}

double compute_correlation(std::span<const double> x, std::span<const double> y) {
    double count = 0, mean_x = 0, mean_y = 0, xx = 0, yy = 0, xy = 0;
    for (size_t i = 0; i < x.size(); ++i) {  // Welford's recurrence
        if (std::isnan(x[i]) || std::isnan(y[i])) continue;
        ++count;
        const double dx = x[i] - mean_x, dy = y[i] - mean_y;
        mean_x += dx / count;
        mean_y += dy / count;
        xx += dx * (x[i] - mean_x);
        yy += dy * (y[i] - mean_y);
        xy += dx * (y[i] - mean_y);
    }
    return xx > 0 && yy > 0 ? std::clamp(xy / std::sqrt(xx * yy), -1.0, 1.0) : kNothing;
}

std::vector<double> compute_ranks(std::span<const double> values) {
    std::vector<size_t> order;
    for (size_t i = 0; i < values.size(); ++i)
        if (!std::isnan(values[i])) order.push_back(i);
    std::ranges::sort(order, {}, [&](size_t i) { return values[i]; });
    std::vector<double> ranks(values.size(), kNothing);
    for (size_t begin = 0; begin < order.size();) {
        size_t end = begin + 1;
        while (end < order.size() && values[order[end]] == values[order[begin]]) ++end;
        for (size_t i = begin; i < end; ++i) ranks[order[i]] = 0.5 * static_cast<double>(begin + end - 1) + 1;
        begin = end;
    }
    return ranks;
}

}  // namespace dttmm::host
