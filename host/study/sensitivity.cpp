// SPDX-License-Identifier: BSD-3-Clause
#include "study/sensitivity.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "model/index.h"
#include "study/statistics.h"

namespace dttmm::host {

namespace {

constexpr size_t kResamples = 500;

/// The estimate over all of `count` blocks, and its percentiles over sets of as many drawn with replacement.
WithErrors with_errors(size_t count, const std::function<double(const std::vector<size_t>& blocks)>& estimate) {
    std::vector<size_t> blocks(count);
    for (size_t b = 0; b < count; ++b) blocks[b] = b;
    WithErrors result{estimate(blocks)};
    std::mt19937_64 engine(1);  // the same bits from run to run
    std::vector<double> resampled;
    for (size_t r = 0; r < kResamples; ++r) {
        for (size_t& block : blocks) block = engine() % count;
        if (const double value = estimate(blocks); std::isfinite(value)) resampled.push_back(value);
    }
    std::ranges::sort(resampled);
    const auto at = [&](double share) {
        return resampled.empty() ? std::nan("")
                                 : resampled[static_cast<size_t>(share * static_cast<double>(resampled.size() - 1))];
    };
    result.low = at(0.025);
    result.high = at(0.975);
    return result;
}

/// Places of the first case of each block of which all completed.
std::vector<size_t> whole_blocks(std::span<const double> values, size_t size) {
    std::vector<size_t> firsts;
    for (size_t first = 0; first + size <= values.size(); first += size)
        if (std::ranges::none_of(values.subspan(first, size), [](double value) { return std::isnan(value); }))
            firsts.push_back(first);
    return firsts;
}

}  // namespace

std::vector<SobolIndices> compute_sobol_indices(std::span<const double> values, Eigen::Index parameters) {
    const auto count = as_size(parameters);
    const std::vector<size_t> firsts = whole_blocks(values, count + 2);
    std::vector<SobolIndices> all(count);
    if (firsts.size() < 2) return {};
    // 2 V, by A and B of the blocks
    const auto twice_variance = [&](const std::vector<size_t>& blocks) {
        double sum = 0, squares = 0;
        const double about = values[firsts.front()];
        for (const size_t block : blocks)
            for (const size_t offset : {size_t{0}, size_t{1}}) {
                const double value = values[firsts[block] + offset] - about;
                sum += value;
                squares += value * value;
            }
        const auto n = 2 * static_cast<double>(blocks.size());
        return 2 * (squares - sum * sum / n) / n;
    };
    const auto mean_square = [&](const std::vector<size_t>& blocks, size_t one, size_t other) {
        double sum = 0;
        for (const size_t block : blocks) sum += std::pow(values[firsts[block] + one] - values[firsts[block] + other], 2);
        return sum / static_cast<double>(blocks.size());
    };
    for (size_t p = 0; p < count; ++p) {
        all[p].blocks = firsts.size();
        // A with column p of B shares p with B, and all else with A
        all[p].first = with_errors(firsts.size(), [&](const std::vector<size_t>& blocks) {
            return 1 - mean_square(blocks, 1, 2 + p) / twice_variance(blocks);
        });
        all[p].total = with_errors(firsts.size(), [&](const std::vector<size_t>& blocks) {
            return mean_square(blocks, 0, 2 + p) / twice_variance(blocks);
        });
    }
    return all;
}

std::vector<ElementaryEffects> compute_elementary_effects(std::span<const double> values,
                                                          const Eigen::MatrixXd& probabilities) {
    const auto count = as_size(probabilities.cols());
    std::vector<std::vector<double>> effects(count);
    for (const size_t first : whole_blocks(values, count + 1))
        for (size_t step = first; step < first + count; ++step)
            for (Eigen::Index p = 0; p < probabilities.cols(); ++p) {
                const double moved = probabilities(as_row(step) + 1, p) - probabilities(as_row(step), p);
                if (moved != 0) effects[as_size(p)].push_back(std::copysign(1.0, moved) * (values[step + 1] - values[step]));
            }
    std::vector<ElementaryEffects> all(count);
    for (size_t p = 0; p < count; ++p) {
        if (effects[p].empty()) return {};
        const FigureStatistics of = compute_statistics(effects[p]);
        all[p].mean = of.mean;
        all[p].deviation = of.deviation;
        all[p].walks = effects[p].size();
        all[p].size = with_errors(effects[p].size(), [&](const std::vector<size_t>& walks) {
            double sum = 0;
            for (const size_t walk : walks) sum += std::abs(effects[p][walk]);
            return sum / static_cast<double>(walks.size());
        });
    }
    return all;
}

std::vector<SingleEffect> compute_single_effects(std::span<const double> values, const Eigen::MatrixXd& parameters) {
    std::vector<SingleEffect> effects;
    for (Eigen::Index row = 1; row < parameters.rows(); ++row)
        for (Eigen::Index p = 0; p < parameters.cols(); ++p)
            if (parameters(row, p) != parameters(0, p))
                effects.push_back({as_size(row), p, values[as_size(row)] - values[0]});
    return effects;
}

}  // namespace dttmm::host
