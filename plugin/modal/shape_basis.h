// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "modal/shape.h"

namespace dttmm::plugin {

/// Displacement beside another, or rotation (1 m per rad), that is round-off: shapes are found to 1e-7 or better. From 1e-8
/// to 1e-4 all tests pass.
constexpr double kShapeRounding = 1e-6;

/// Mixes shapes of equal frequencies to a basis that does not depend on how they were found; any mixture would do. The first
/// shape moves one point in one direction as far as a unit of modal mass can, that point and direction where this is
/// farthest; the next does the same among the motions at right angles to the first by mass, and so on. Rigid-body modes
/// begin with the translations in x, y, z and the turns about them. Where points tie, x comes before y before z, then the
/// smaller coordinate. The sign is that of a positive displacement there. D stands at their λ.
void fix_basis(const DynamicStiffness& D, std::vector<FrameVector>& shapes, bool is_rigid);

/// Shapes times a matrix: the j-th is Σ_i mix(i, j) shapes[i].
std::vector<FrameVector> mixed(const std::vector<FrameVector>& shapes, const Eigen::MatrixXd& mix);

}  // namespace dttmm::plugin
