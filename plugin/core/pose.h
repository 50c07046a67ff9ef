// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/types.h"

namespace dttmm::plugin {

/// A frame in the world: its origin [m] and its axes, v_world = rotation · v_frame.
struct Pose {
    Vector3 position = Vector3::Zero();
    Matrix3 rotation = Matrix3::Identity();
};

}  // namespace dttmm::plugin
