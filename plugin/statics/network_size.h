// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mechanism/mechanism.h"

namespace dttmm::plugin {

/// How large a network is: what its forces and motions at rest are measured by.
struct NetworkSize {
    explicit NetworkSize(const Mechanism& mechanism);

    double span;  ///< diagonal of the box around all frames [m]; a metre if they coincide
    /// Lever arm of every inner frame [m], by which moments count as forces and rotations as displacements: to the farthest
    /// joint from its origin, at least the radius of gyration. Where both are zero it is the span.
    std::vector<double> reach;
};

}  // namespace dttmm::plugin
