// SPDX-License-Identifier: BSD-3-Clause
#include "element/rigid_body.h"

#include <Eigen/Eigenvalues>

#include "core/error.h"
#include "element/parameters.h"

namespace dttmm::plugin {

namespace {

constexpr dttmm_parameter inertia(const char* name, double minimum) {
    return {name, "kg*m^2", 1, 0, 0, minimum, kLargestInertia, nullptr, 0, "entry of the tensor about the centre of mass"};
}

constexpr dttmm_parameter kParameters[] = {
    kMassParameter,
    {"center_of_mass", "m", 3, 0, 0, -kFarthestPlace, kFarthestPlace, nullptr, 0, "from the first node, in its axes"},
    inertia("inertia.xx", 0),
    inertia("inertia.yy", 0),
    inertia("inertia.zz", 0),
    inertia("inertia.xy", -kLargestInertia),
    inertia("inertia.xz", -kLargestInertia),
    inertia("inertia.yz", -kLargestInertia),
};

}  // namespace

const dttmm_element_type RigidBody::kType = {"rigid_body", DTTMM_ENDS_AT, std::size(kParameters), kParameters,
                                             "a rigid mass that its nodes are part of"};

RigidBody::RigidBody(std::span<const double, 10> v) : mass_(v[0]), centre_of_mass_(v[1], v[2], v[3]) {
    inertia_ << v[4], v[7], v[8], v[7], v[5], v[9], v[8], v[9], v[6];
    const Vector3 moments = Eigen::SelfAdjointEigenSolver<Matrix3>(inertia_).eigenvalues();
    const double rounding = 1e-12 * moments.cwiseAbs().maxCoeff();
    if (moments(0) < -rounding || moments(0) + moments(1) < moments(2) - rounding)
        throw Error(DTTMM_ERROR_MODEL,
                    "inertia: no mass has such a tensor: its principal moments must be positive, none larger than the other "
                    "two together");
}

Parts RigidBody::discretise(std::span<const Pose> ends) const {
    Parts parts;
    const Pose& first = ends[0];
    parts.lumps.push_back({mass_, inertia_, {first.position + first.rotation * centre_of_mass_, first.rotation}});
    parts.mounted.assign(ends.size(), 0);
    return parts;
}

}  // namespace dttmm::plugin
