// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/rotation.h"
#include "element/divided_line.h"
#include "support/element_values.h"

namespace dttmm::plugin::test_lines {

// What the tests of beams and rods share: ends, sections, and what their parts are in sum.

using test::Given;

/// The bond-space paper's tube, and a section that differs in every direction.
inline const Given kTube = {
    {"section.tube", {0.05, 0.03}}, {"material.E", {204e9}}, {"material.poisson", {0.26}}, {"material.density", {7800}}};
inline const Given kUneven = {{"section.EA", {3.1e8}},  {"section.EIy", {5.2e4}},  {"section.EIz", {7.7e3}},
                              {"section.GJ", {1.9e4}},  {"section.GAy", {6e6}},    {"section.GAz", {8.5e7}},
                              {"section.mass", {13.7}}, {"section.inertia", {0.2}}};

inline const Vector3 kFrom(0.3, -0.1, 0.2), kTo(0.9, 0.7, -0.5), kNotGiven3 = Vector3::Constant(kNotGiven);

/// Parts between two points; the axes of the nodes there are nobody's business.
inline Parts between(const Vector3& from, const Vector3& to, const Element& element) {
    const Pose ends[] = {{from, rotation_from_vector({0.4, -0.8, 1.3})}, {to, rotation_from_vector({-1.1, 0.2, 0.6})}};
    return element.discretise(ends);
}

struct Inertia {
    double mass = 0;
    Vector3 centre = Vector3::Zero();
    Matrix3 tensor = Matrix3::Zero();  ///< about `about`, world axes
};

inline Inertia total(const Parts& parts, const Vector3& about) {
    Inertia sum;
    for (const Lump& lump : parts.lumps) {
        const Vector3 arm = lump.pose.position - about;
        const Matrix3& R = lump.pose.rotation;
        sum.mass += lump.mass;
        sum.centre += lump.mass * lump.pose.position;
        sum.tensor += R * lump.inertia * R.transpose() - lump.mass * skew(arm) * skew(arm);
    }
    sum.centre /= sum.mass;
    return sum;
}

/// Motion of the `to` end of a clamped chain of joints per wrench on it, world axes: the compliance of every joint carried
/// from where it stands to the end.
inline Matrix6 compliance(const Parts& parts, const Vector3& end) {
    Matrix6 sum = Matrix6::Zero();
    for (const JointPart& joint : parts.joints) {
        Matrix6 T = Matrix6::Identity();  // wrench at the end → wrench at the joint, in its axes
        T.bottomLeftCorner<3, 3>() = skew(end - joint.pose.position);
        Matrix6 turn = Matrix6::Zero();
        turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = joint.pose.rotation.transpose();
        T = turn * T;
        Vector6 c = joint.law->stiffness.cwiseInverse();
        for (size_t d = 0; d < 6; ++d)
            if (joint.law->rigid[d]) c(static_cast<int>(d)) = 0;
        sum += T.transpose() * c.asDiagonal() * T;
    }
    return sum;
}

inline Matrix6 in_axes(const Matrix3& R, const Matrix6& world) {
    Matrix6 turn = Matrix6::Zero();
    turn.topLeftCorner<3, 3>() = turn.bottomRightCorner<3, 3>() = R;
    return turn.transpose() * world * turn;
}

}  // namespace dttmm::plugin::test_lines
