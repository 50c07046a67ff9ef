// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bitset>

#include "core/types.h"

namespace dttmm::plugin {

/// End forces of a transfer equation z_O = U z_I whose two end poses are imposed by the bodies there:
///     q = S x + e      x = [x_I θ_I; x_O θ_O] 12×1,  q = [q_I m_I; q_O m_O] 12×1 with the signs of the state vector
/// In a direction that the element does not carry, q is zero.
struct EndForces {
    Matrix12 S = Matrix12::Zero();
    Vector12 e = Vector12::Zero();
    double reciprocal_condition = 1;
};

/// Some of the six directions x y z rx ry rz.
using Directions = std::bitset<6>;

/// Solves the 2n unknown end forces of the n carried directions at once by full-pivot elimination: for a joint in three
/// translations this is the paper's 6 × 7 augmented system, in six directions its spatial form with 12 unknowns.
///     kinematic rows   U_xq q_I       = x_O − U_xx x_I − u_x
///     load rows       −U_qq q_I + q_O = U_qx x_I + u_q
/// Throws Error(DTTMM_ERROR_SINGULAR) naming the direction when U_xq is singular (a rigid direction cannot be driven) or not
/// finite (a free one carries nothing: leave it out of `carried`).
/// Source: hybrid-algorithm paper, eq. (6).
EndForces solve_driven_ends(const Matrix13& U, Directions carried);

}  // namespace dttmm::plugin
