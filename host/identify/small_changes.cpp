// SPDX-License-Identifier: BSD-3-Clause
#include "identify/small_changes.h"

#include <algorithm>
#include <tuple>

#include "model/index.h"

namespace dttmm::host {

std::pair<double, double> extrapolate(const std::array<SlopeAt, kSlopeLevels>& level) {
    constexpr double kMeanFalls = 3;    // fourfold of a smooth figure. Range 0.6 (at 0.3 KnowKinksAndJumps...) to 3.9
    constexpr double kBendFalls = 1.5;  // twofold of a smooth figure. Range 1.1 (at 0.75 KnowKinksAndJumps...) to 1.9
    const double before = std::abs(level[1].mean - level[0].mean), change = std::abs(level[2].mean - level[1].mean);
    const double of_jump = kMeanFalls * change > before ? 2 * change + before : 0,
                 of_kink = kBendFalls * level[2].bend > level[1].bend ? level[2].bend / 2 : 0;
    if (of_jump > 0 || of_kink > 0) return {level[2].mean, std::max(of_jump, of_kink)};
    const auto next_order = [](double worse, double better, double ratio) {
        return better + (better - worse) / (ratio - 1);
    };
    const double fourth = next_order(level[0].mean, level[1].mean, 4), next = next_order(level[1].mean, level[2].mean, 4),
                 sixth = next_order(fourth, next, 16);
    std::pair<double, double> best(level[2].mean, change);
    for (const auto& [better, worse] : {std::pair(next, fourth), std::pair(sixth, next)})
        if (std::abs(better - worse) < best.second) best = {better, std::abs(better - worse)};
    return best;
}

SmallChanges::SmallChanges(const std::vector<TaskResult>& results, size_t count)
    : slopes(as_row(count), as_row(results.size())), errors(slopes) {
    for (size_t p = 0; p < results.size(); ++p)
        for (size_t f = 0; f < count; ++f) {
            std::array<SlopeAt, kSlopeLevels> level;
            for (size_t l = 0; l < level.size(); ++l) {
                const size_t at = 2 * (l * count + f);
                level[l] = {results[p].numbers[at], results[p].numbers[at + 1]};
            }
            std::tie(slopes(as_row(f), as_row(p)), errors(as_row(f), as_row(p))) = extrapolate(level);
        }
}

}  // namespace dttmm::host
