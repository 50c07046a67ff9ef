// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "model/model.h"

namespace dttmm::test {

using namespace host;

inline Body box(const std::string& name, double mass, const Eigen::Vector3d& size, const Eigen::Vector3d& position) {
    Body body;
    body.name = name;
    body.mass = mass;
    const Eigen::Vector3d s = size.cwiseAbs2();
    body.inertia = (mass / 12 * Eigen::Vector3d(s.y() + s.z(), s.z() + s.x(), s.x() + s.y())).asDiagonal();
    body.position = position;
    return body;
}

/// A hinge between two bodies (−1: the ground).
inline Joint pin(const std::string& name, int first, int second, const Eigen::Vector3d& anchor,
                 const Eigen::Vector3d& axis) {
    Joint joint;
    joint.name = name;
    joint.place = name;
    joint.type = JointType::hinge;
    joint.first = first;
    joint.second = second;
    joint.anchor = anchor;
    joint.axis = axis;
    return joint;
}

}  // namespace dttmm::test
