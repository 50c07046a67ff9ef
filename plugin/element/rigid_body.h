// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "dttmm_plugin.h"
#include "element/element.h"

namespace dttmm::plugin {

/// A rigid body inside the network, with any number of inputs: the nodes `at` which elements meet it. It moves with them; a
/// body of the model's own is the host's.
class RigidBody : public Element {
public:
    /// values: mass [kg], centre of mass from the first node [m], inertia xx yy zz xy xz yz about the centre of mass
    /// (entries of the tensor) [kg m²], both in the axes of the first node.
    explicit RigidBody(std::span<const double, 10> values);

    static const dttmm_element_type kType;

    Parts discretise(std::span<const Pose> ends) const override;

private:
    double mass_;
    Vector3 centre_of_mass_;
    Matrix3 inertia_;
};

}  // namespace dttmm::plugin
