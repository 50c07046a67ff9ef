// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <map>
#include <optional>

#include "model/element_catalogue.h"
#include "model/model.h"

namespace dttmm::host {

/// Where the values of an element say how many segments it is divided into; nothing: it is not.
std::optional<size_t> segments_at(const dttmm_element_type& type);

/// Between the ends of an element with two of them, at the start [m].
Eigen::Vector3d way_along(const Model& model, const Element& element);

/// The forces per length along a divided element, all together. They act at the middles of its segments. Where it is not
/// held statically determinately, forces err by that: a fourth as much with twice as many.
struct LineLoads {
    double length = 0;  ///< [m]
    double segments = 0;
    double across = 0, mean = 0;  ///< the largest across it, at one of its ends, and in the mean [N/m]
    double rise = 0;              ///< by how much more pushes along it at one end than at the other [N/m]

    /// Of axial forces, at most: the forces in the half segments at its ends are those of the ends [N].
    double error_of_force() const { return rise * length / (12 * segments * segments); }
};

/// By element, at a time [s].
std::map<size_t, LineLoads> find_line_loads(const Model& model, const ElementCatalogue& catalogue, double time);

}  // namespace dttmm::host
