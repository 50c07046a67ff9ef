// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

#include "analysis/json.h"

namespace dttmm::host {

/// A point fixed to an owner: a body or a node. The owner -1 is the ground.
struct OwnedPoint {
    int owner = -1;
    Eigen::Vector3d local = Eigen::Vector3d::Zero();  ///< [m] in the owner's axes; of the ground in world axes
};

/// The homogeneous box of the same mass and inertia as a body.
struct InertiaBox {
    Eigen::Vector3d centre;   ///< centre of mass [m], body axes
    Eigen::Quaterniond turn;  ///< of the box in the body
    Eigen::Vector3d edges;    ///< [m]; zero where the inertia has no extent
};

/// A body or a node as the model places it at the start, world axes.
struct Owner {
    std::string name;
    Eigen::Vector3d position;  ///< of its origin [m]
    Eigen::Quaterniond turn;
    std::optional<InertiaBox> box;  ///< of a body
    bool is_fixed = false;          ///< a node that is held in all six directions
};

/// An element as a line through its points.
struct ElementLine {
    std::string name, type;
    std::vector<OwnedPoint> points;  ///< from, to; or those of `at`
    double diameter = 0;             ///< of its section [m]; 0 where it has none
    bool is_beam() const { return type == "beam" && points.size() == 2; }
};

/// A place with a name: "plate", "plate.left" (a marker), "knee" (a node).
struct NamedPlace {
    std::string name;
    OwnedPoint point;
};

/// The machine at the start, from the member "model" of summary.json, as machine.js of a report has it.
class Structure {
public:
    /// Throws Error(input_output) for places that are no numbers, nlohmann::json::exception for members of other types.
    explicit Structure(const Json& model);

    const std::vector<Owner>& owners() const { return owners_; }  ///< bodies, then nodes, as in the model
    /// Without those of which no end is a place of the model.
    const std::vector<ElementLine>& elements() const { return elements_; }
    /// Every body with its markers behind it, then the nodes: the order of modes.csv.
    const std::vector<NamedPlace>& places() const { return places_; }
    /// Index in places(); -1 if there is none of that name.
    int find_place(std::string_view name) const;
    /// Index in owners(); -1 if there is none of that name.
    int find_owner(std::string_view name) const;
    /// In world axes [m].
    Eigen::Vector3d at_start(const OwnedPoint& point) const;
    /// From the lowest to the highest corner of all boxes and places [m]; positive.
    double size() const { return size_; }

private:
    void add_owners(const Json& model);
    void measure();
    /// Null for the ground, and for what is no place.
    const OwnedPoint* point_of(const Json& name) const;

    std::vector<Owner> owners_;
    std::vector<ElementLine> elements_;
    std::vector<NamedPlace> places_;
    std::unordered_map<std::string, int> place_of_, owner_of_;
    double size_ = 1;
};

/// The corners of a box in the order of a hexahedron of VTK: below, then above, each counterclockwise. [m], body axes.
std::vector<Eigen::Vector3d> corners_of(const InertiaBox& box);

}  // namespace dttmm::host
