// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>

#include "model/element_catalogue.h"
#include "model/table_reader.h"

namespace dttmm::host {

/// Equal elements on a circle about an axis of two bodies, or of a body and the ground. Bolt k of n stands at the angle
/// start_angle + 2 pi (k - 1)/n about `axis`, counted from `zero`. Its ends are markers "<name>k" of the bodies.
struct BoltCircle {
    std::string name;
    int count = 0;
    double radius = 0;                                ///< [m]
    Eigen::Vector3d axis = Eigen::Vector3d::UnitZ();  ///< unit vector, in the axes of each port
    Eigen::Vector3d zero = Eigen::Vector3d::UnitX();  ///< unit vector across it
    double start_angle = 0;                           ///< [rad]
    std::array<std::string, 2> ports;  ///< from, to: a body or marker, at the centre of the circle; or "ground"
    Place place;
    bool turns = false;  ///< the bolts' x is radial, y tangential and z along `axis`; else they have axes of their own
};

/// `table` has the keys of "bolt_circle", `element` (may be null) is what stands in its key `element`. Faults are reported.
std::optional<BoltCircle> read_bolt_circle(const TableReader& table, const TomlValue* element,
                                           const ElementCatalogue& catalogue);

/// Adds the markers of both ends to the bodies of the document. False where a port is no body or marker, which is reported.
bool add_bolt_markers(TomlValue& document, const BoltCircle& circle, const TableReader& table);

/// The table `element` with name and ends of bolt k, counted from 1.
TomlValue make_bolt(const BoltCircle& circle, int k, TomlValue element);

}  // namespace dttmm::host
