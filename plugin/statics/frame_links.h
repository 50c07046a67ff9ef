// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mechanism/mechanism.h"
#include "solve/elimination.h"

namespace dttmm::plugin {

// What an Elimination of the frames inside a network is made of.

/// A link for every joint.
std::vector<Link> links_of(const Mechanism& mechanism);

/// Levers shorter than this are rounding of places [m].
double least_lever(const Mechanism& mechanism);

/// Visits the rigid directions of a joint, ascending: function(number, direction).
template <class Function>
void for_each_rigid(const Joint& joint, const Function& function) {
    int i = 0;
    for (int d = 0; d < 6; ++d)
        if (joint.rigid()[as_size(d)]) function(i++, d);
}

/// Columns of what is open of a joint's rigid directions, from those of [d; relative turn].
Matrix6 rigid_rows(const Joint& joint, const Vector3& theta, const Matrix6& columns);

/// Throws Error naming what makes the equations singular: a frame that nothing holds, or rigid directions that meet.
[[noreturn]] void refuse_singular(const Mechanism& mechanism, const Elimination::Fault& fault, dttmm_status status);

}  // namespace dttmm::plugin
