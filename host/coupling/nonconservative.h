// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "coupling/modal_description.h"
#include "model/model.h"

namespace dttmm::host {

/// Indices into Model::loads of those that act on a machine at rest and have no potential there; none about the start.
/// A small motion (v, θ) of the point of a load changes a force f that turns with its body by θ × f. Such a load has a
/// potential if and only if the antisymmetric part of its stiffness is zero on the motions that are free:
///     of a force that turns      b(1, 2) = v1·(θ2 × f) − v2·(θ1 × f),
///     of a moment m              b(1, 2) = m·(θ1 × θ2), half of that, whether it keeps its direction or turns.
/// Free is what fixed directions of nodes and ideal joints, motors and stops that push leave; elements count as elastic. A
/// force per length that turns with its line counts as one without a potential wherever it acts.
/// Source: Ziegler (1968), Principles of Structural Stability, chapter 1; Argyris (1982), CMAME 32, 85-155, for moments.
std::vector<size_t> find_nonconservative(const Model& model, const ModalDescription& machine);

}  // namespace dttmm::host
