// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "support/finite_elements.h"

namespace dttmm::test {

/// The hydroplane of the hydroplane paper's topology (elements 1 to 31) with our data, x y rz rx only: two blades of seven
/// segments, two shafts, a tiller, bearings, a guide and a hydraulic column. kh: stiffness of the hydraulic spring [N/m];
/// count: finite elements per member.
DTTMM_ORACLE FiniteElements hydroplane(double kh, int count, FiniteElements::Across rod = FiniteElements::Across::rigid_bar);

}  // namespace dttmm::test
