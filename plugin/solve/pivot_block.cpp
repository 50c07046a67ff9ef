// SPDX-License-Identifier: BSD-3-Clause
#include "solve/pivot_block.h"

#include "core/six.h"

namespace dttmm::plugin {

DTTMM_WIDE void substitute_six(const double* LU, Eigen::Index n, Eigen::Index stride, double* rows) {
    for (Eigen::Index i = 1; i < n; ++i) {
        Six x(rows + 6 * i);
        for (Eigen::Index k = 0; k < i; ++k) x = x - Six(rows + 6 * k) * LU[i + k * stride];
        x.store(rows + 6 * i);
    }
    for (Eigen::Index i = n; i-- > 0;) {
        Six x(rows + 6 * i);
        for (Eigen::Index k = i + 1; k < n; ++k) x = x - Six(rows + 6 * k) * LU[i + k * stride];
        (x / LU[i + i * stride]).store(rows + 6 * i);
    }
}

}  // namespace dttmm::plugin
