// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "core/types.h"

namespace dttmm::plugin {

/// The state vector of the transfer matrix method, fixed here once for every element:
///     z = [x y z  θx θy θz  mx my mz  qx qy qz  1]ᵀ        13×1; m, rad, N m, N
/// Signs (Rui): the internal force q is positive along the axes at an input end and against them at an output end; the
/// internal moment m is positive against the axes at an input end and along them at an output end. Hence, for a spring,
/// x_O = x_I − q/K and θ_O = θ_I + m/K'; for a massless lever, m_O = m_I + l_IO × q.
/// On the bodies: the one feeding the input end feels −q_I and +m_I, the one behind the output end +q_O and −m_O.
/// Source: Rui et al., signs derived from the hydroplane paper's printed matrices.
namespace state {
inline constexpr int kPosition = 0;
inline constexpr int kAngle = 3;
inline constexpr int kMoment = 6;
inline constexpr int kForce = 9;
inline constexpr int kOne = 12;
inline constexpr int kSize = 13;
}  // namespace state

/// The six directions of a pose or wrench, as messages name them.
inline constexpr std::array<const char*, 6> kDirectionNames = {"x", "y", "z", "rx", "ry", "rz"};

}  // namespace dttmm::plugin
