// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "modal/dynamic_stiffness.h"

namespace dttmm::plugin {

/// Shapes of natural frequencies next to a shift.
class InverseIteration {
public:
    explicit InverseIteration(DynamicStiffness& stiffness) : stiffness_(stiffness) {}

    /// Shapes without a pattern, others at every call.
    std::vector<FrameVector> random_shapes(size_t count);
    /// Iterates a group of shapes at a shift λ [1/s²]. What their span says of the natural frequencies next to it (Ritz): λ,
    /// ascending. The shapes are then these, of unit modal mass. Nothing: they cannot be distinguished there.
    std::vector<double> iterate(std::vector<FrameVector>& shapes, double lambda);

private:
    DynamicStiffness& stiffness_;
    uint64_t seed_ = 1;
};

}  // namespace dttmm::plugin
