// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "analysis/request.h"
#include "loader/plugins.h"
#include "model/model.h"

namespace dttmm::host {

/// The homogeneous box with the mass and the inertia of a body, about its centre of mass.
struct EqualBox {
    Eigen::Vector3d edges;  ///< [m], the longest first
    Eigen::Matrix3d axes;   ///< columns: directions of the edges in the axes of the body, right-handed
};

/// I_1 = m (b² + c²)/12 and so on, solved for the edges; one that would be imaginary is zero, and all are without a mass.
/// mass [kg]; inertia about the centre of mass, body axes [kg m²].
EqualBox equal_box(double mass, const Eigen::Matrix3d& inertia);

/// Where an element is at the start, in the world.
struct ElementPlace {
    Eigen::Vector3d from, to;  ///< its ends [m]; the same where one is the ground, or where it has one end
    Eigen::Matrix3d axes;      ///< columns: its local axes
    bool has_only_x = false;   ///< a line whose y and z only its plugin knows
    bool is_grounded = false;  ///< one end is the ground
    double length() const { return (to - from).norm(); }
    /// Its ends are apart: positions of the file and rotations are rounded at 1e-16 of some metres.
    bool is_long() const { return length() > 1e-9; }
};

/// A line has its x from end to end, and z as near to its parameter `up` as can be, if it has one. Others have the axes of
/// their `from` end, or those given to them.
ElementPlace place_at_start(const Model& model, const Element& element, const dttmm_element_type& type);

/// Where a place on a body, or a node, is at the start, in the world [m].
Eigen::Vector3d position_at_start(const Model& model, const Attachment& at);

/// A model as it stands, with the plugins that its elements are of.
struct StandingMachine {
    /// Reads what was asked for; wants no settings of a run. Throws Error for a model that cannot be read.
    explicit StandingMachine(const Request& request);
    const Plugins plugins;
    const Model model;
};

}  // namespace dttmm::host
