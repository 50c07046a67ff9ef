// SPDX-License-Identifier: BSD-3-Clause
#include "identify/small_changes.h"

#include "model/index.h"

namespace dttmm::host {

SmallChanges::SmallChanges(const std::vector<TaskResult>& results, size_t count)
    : slopes(as_row(count), as_row(results.size())), errors(slopes) {
    for (size_t p = 0; p < results.size(); ++p) {
        using Rows = Eigen::Map<const Eigen::Matrix<double, Eigen::Dynamic, kShares.size()>>;
        const Rows at(results[p].numbers.data(), as_row(count), kShares.size());
        const Eigen::VectorXd first = at.col(0) + (at.col(0) - at.col(1)) / 3,
                              second = at.col(1) + (at.col(1) - at.col(2)) / 3;
        slopes.col(as_row(p)) = first + (first - second) / 15;
        errors.col(as_row(p)) = (first - second).cwiseAbs();
    }
}

}  // namespace dttmm::host
