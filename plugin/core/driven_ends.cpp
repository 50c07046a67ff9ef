// SPDX-License-Identifier: BSD-3-Clause
#include "core/driven_ends.h"

#include <fmt/format.h>

#include <cmath>
#include <vector>

#include "core/error.h"
#include "core/gauss.h"
#include "core/index.h"
#include "core/state_vector.h"

namespace dttmm::plugin {

namespace {

/// Place in the state vector of the pose, and of the load, in direction d of x y z rx ry rz.
int pose_row(int d) { return d < 3 ? state::kPosition + d : state::kAngle + d - 3; }
int load_row(int d) { return d < 3 ? state::kForce + d : state::kMoment + d - 3; }

/// A free direction has an infinite compliance: no equation determines its force.
void refuse_free(const Matrix13& U, const std::vector<int>& directions) {
    for (int d : directions) {
        if (std::isfinite(U(pose_row(d), load_row(d)))) continue;
        throw Error(DTTMM_ERROR_SINGULAR,
                    fmt::format("the transfer equations are singular in direction {}: it has neither stiffness nor damping",
                                kDirectionNames[as_size(d)]));
    }
}

}  // namespace

EndForces solve_driven_ends(const Matrix13& U, Directions carried) {
    std::vector<int> directions;
    for (int d = 0; d < 6; ++d)
        if (carried[as_size(d)]) directions.push_back(d);
    refuse_free(U, directions);
    const int n = as_int(directions.size());

    // Columns of the right-hand side: the 12 end coordinates, then the constant.
    SmallMatrix A = SmallMatrix::Zero(2 * n, 2 * n);
    SmallMatrix B = SmallMatrix::Zero(2 * n, 13);
    for (int i = 0; i < n; ++i) {
        const int di = directions[as_size(i)];
        for (int j = 0; j < n; ++j) {
            const int dj = directions[as_size(j)];
            A(i, j) = U(pose_row(di), load_row(dj));
            A(n + i, j) = -U(load_row(di), load_row(dj));
        }
        A(n + i, n + i) = 1;
        B(i, 6 + di) = 1;
        for (int d = 0; d < 6; ++d) {
            B(i, d) = -U(pose_row(di), pose_row(d));
            B(n + i, d) = U(load_row(di), pose_row(d));
        }
        B(i, 12) = -U(pose_row(di), state::kOne);
        B(n + i, 12) = U(load_row(di), state::kOne);
    }

    const Elimination solved = eliminate_full_pivot(A, B);
    if (!solved.regular()) {
        const int direction = directions[as_size(solved.weakest_unknown % n)];
        throw Error(
            DTTMM_ERROR_SINGULAR,
            fmt::format("the transfer equations are singular in direction {} (reciprocal condition {:.1e}): a "
                        "direction that is rigid, or 1e14 times stiffer than another, cannot be driven from both ends",
                        kDirectionNames[as_size(direction)], solved.reciprocal_condition));
    }

    EndForces forces;
    forces.reciprocal_condition = solved.reciprocal_condition;
    for (int i = 0; i < n; ++i) {
        const int d = directions[as_size(i)];
        forces.S.row(d) = solved.X.row(i).head<12>();
        forces.S.row(6 + d) = solved.X.row(n + i).head<12>();
        forces.e(d) = solved.X(i, 12);
        forces.e(6 + d) = solved.X(n + i, 12);
    }
    return forces;
}

}  // namespace dttmm::plugin
