// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "modal/mode_finder.h"

namespace dttmm::plugin {

/// How natural frequencies change with the numbers of a machine, exactly to the first order. A mode φ with the forces q of
/// rigid directions obeys D(λ) φ + Jᵀ q = 0, J φ = 0. So L = φᵀ D φ + 2 qᵀ J φ keeps its value for small changes of φ and q,
/// and of a change of the numbers
///     dλ = (dL at these φ, q and λ)/(φᵀ (−∂D/∂λ) φ);
/// of a multiple frequency, dλ are the eigenvalues of the matrix dL over its shapes, one for each of its branches. dL is
/// half the difference of two machines, one on either side; near frequencies do not disturb it, as they do differences of
/// frequencies. Source: Nelson (1976), AIAA J. 14(9), 1201–1205, for one; Mills-Curran (1988), AIAA J. 26(7), 867–871, for
/// multiple ones.
///
/// Changes of ω [rad/s] of the modes, which are of one frequency that is not zero, ascending: half of what lies between
/// `below` and `above`. The machines are cut as the one of the modes was. Throws Error(DTTMM_ERROR_ARGUMENT) where they are
/// not of one structure, Error(DTTMM_ERROR_NUMERIC) where the forces of rigid directions are not found.
std::vector<double> frequency_changes(DynamicStiffness& at, std::span<const Mode> modes, DynamicStiffness& above,
                                      DynamicStiffness& below);

}  // namespace dttmm::plugin
