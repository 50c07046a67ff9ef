// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/types.h"

namespace dttmm {

/// R = exp(θ~): turns by the angle |θ| [rad] about θ. Any size of θ.
Matrix3 rotation_from_vector(const Vector3& theta);

/// θ = log R with |θ| ≤ π [rad], the inverse of rotation_from_vector; exact to rounding for every angle, π included
/// (there one of the two opposite vectors is returned). R must be orthonormal to rounding.
Vector3 rotation_vector(const Matrix3& R);

/// J⁻¹(θ) with d(log R) = J⁻¹(θ) ε when R = exp(θ~) changes to exp(ε~) exp(θ~). |θ| < 2π.
///     J⁻¹ = I − θ~/2 + (1 − (|θ|/2) cot(|θ|/2)) θ~²/|θ|²
/// Source: Bullo and Murray (1995), Proc. 3rd European Control Conf., 1091–1097.
Matrix3 rotation_vector_rate(const Vector3& theta);

}  // namespace dttmm
