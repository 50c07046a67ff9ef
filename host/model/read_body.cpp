// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_body.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/read_position.h"
#include "model/read_rotation.h"
#include "model/rigid_body.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

const std::vector<std::string> kShapes = {"box", "cylinder", "tube", "sphere"};

/// Axis of a cylinder or tube: 0, 1, 2 for x, y, z.
int read_axis(const TableReader& table) { return table.choice("axis", 2).value_or(2); }

std::optional<MassProperties> read_tube(const TableReader& table, double density) {
    const auto sizes = table.numbers("tube");
    if (!sizes) return std::nullopt;
    const double outer = (*sizes)[0], inner = (*sizes)[1], length = (*sizes)[2];
    if (inner < outer) return make_tube(density, outer, inner, length, read_axis(table));
    table.error(table.find("tube")->value.place,
                fmt::format("tube = [outer diameter, inner diameter, length]: the inner diameter must be "
                            "less than the outer ({} m), got {} m",
                            outer, inner));
    return std::nullopt;
}

/// Mass and inertia of the shape the table gives, about the shape's centre.
std::optional<MassProperties> read_shape(const TableReader& table, const TomlMember& shape, double density) {
    if (shape.key == "tube") return read_tube(table, density);
    const auto sizes = table.numbers(shape.key);
    if (!sizes) return std::nullopt;
    if (shape.key == "box") return make_box(density, {(*sizes)[0], (*sizes)[1], (*sizes)[2]});
    if (shape.key == "cylinder") return make_tube(density, (*sizes)[0], 0, (*sizes)[1], read_axis(table));
    return make_sphere(density, (*sizes)[0]);
}

/// Foam has 10 kg/m³, osmium 22 600. Of ships and machines of micrometres the density is the same.
constexpr double kLeastDensity = 10, kMostDensity = 25000;

void warn_density(const TableReader& table, Place place, double density) {
    if (density >= kLeastDensity && density <= kMostDensity) return;
    table.warning(place, "density",
                  fmt::format("the density is {:.4g} kg/m³, outside {:g} to {:g}: check the units of density, mass and "
                              "lengths",
                              density, kLeastDensity, kMostDensity));
}

/// A shape of a given density, or of a given mass spread evenly through it.
std::optional<MassProperties> read_shape_and_density(const TableReader& table) {
    if (const TomlMember* member = table.find("inertia"))
        table.error(member->place, "\"inertia\" and a shape exclude each other: the shape gives the inertia");
    const TomlMember* shape = table.require_one(kShapes);
    if (!shape) return std::nullopt;
    const bool is_round = shape->key == "cylinder" || shape->key == "tube";
    if (table.find("axis") && !is_round) table.error(table.find("axis")->place, fmt::format("a {} has no axis", shape->key));
    const auto unit = read_shape(table, *shape, 1);  // of density one; the shape is checked whatever the amount
    const TomlMember* amount = table.require_one({"density", "mass"});
    if (!amount || !unit) return std::nullopt;
    const bool by_mass = amount->key == "mass";
    const double value = table.number(amount->key).value_or(0);
    if (value == 0) return std::nullopt;
    const double density = by_mass ? value / unit->mass : value;
    warn_density(table, amount->value.place, density);
    return MassProperties{density * unit->mass, density * unit->inertia};
}

/// The symmetric tensor of `inertia = { xx, yy, zz, xy, xz, yz }` (tensor entries, not products of inertia) or `[xx, yy,
/// zz]`.
std::optional<Eigen::Matrix3d> read_inertia(const TableReader& body) {
    const TomlMember* member = body.require("inertia");
    if (!member) return std::nullopt;
    if (!member->value.is_table()) {
        const auto moments = body.vector("inertia");
        return moments ? std::optional<Eigen::Matrix3d>(moments->asDiagonal()) : std::nullopt;
    }
    const TableReader table(body.context(), member->value, body.what("inertia"), key_table("inertia"));
    const auto xx = table.number("xx"), yy = table.number("yy"), zz = table.number("zz");
    const auto xy = table.number("xy", 0), xz = table.number("xz", 0), yz = table.number("yz", 0);
    if (!xx || !yy || !zz || !xy || !xz || !yz) return std::nullopt;
    return Eigen::Matrix3d{{*xx, *xy, *xz}, {*xy, *yy, *yz}, {*xz, *yz, *zz}};
}

std::optional<MassProperties> read_mass_and_inertia(const TableReader& table) {
    if (const TomlMember* axis = table.find("axis")) table.error(axis->place, "axis belongs to a cylinder or tube");
    const auto mass = table.number("mass");
    const auto inertia = read_inertia(table);
    if (mass) {
        if (const auto fault = find_mass_fault(*mass)) {
            table.error(table.find("mass")->value.place, *fault);
            return std::nullopt;
        }
    }
    if (inertia) {
        if (const auto fault = find_inertia_fault(*inertia, mass.value_or(0)))
            table.error(table.find("inertia")->value.place, *fault);
    }
    return mass && inertia ? std::optional(MassProperties{*mass, *inertia}) : std::nullopt;
}

void read_mass_properties(const TableReader& table, Body& body) {
    const bool has_shape = std::any_of(kShapes.begin(), kShapes.end(), [&](const auto& key) { return table.find(key); });
    const bool by_shape = has_shape || table.find("density");
    const auto properties = by_shape ? read_shape_and_density(table) : read_mass_and_inertia(table);
    if (!properties) return;
    if (by_shape) {
        auto fault = find_mass_fault(properties->mass);
        if (!fault) fault = find_inertia_fault(properties->inertia, properties->mass);
        if (fault) return table.error(table.find(table.find("density") ? "density" : "mass")->value.place, *fault);
    }
    body.mass = properties->mass;
    body.inertia = properties->inertia;
}

Marker read_marker(const TableReader& body, const TomlMember& member, NameRegistry& names) {
    const ReadContext& context = body.context();
    Marker marker;
    marker.name = names.add(context, member.place, member.key);
    const std::string label = body.what("marker " + quote(member.key));
    if (!member.value.is_table()) {
        const Key& position = *find_key(key_table("marker"), "position");
        marker.position =
            read_vector(context, member.value, label, position.unit, position.bounds).value_or(marker.position);
        return marker;
    }
    const TableReader table(context, member.value, label, key_table("marker"));
    marker.position = table.vector("position", Eigen::Vector3d::Zero()).value_or(marker.position);
    if (const auto rotation = read_rotation(table); rotation && (table.find("rotation") || table.find("quaternion")))
        marker.rotation = std::make_shared<Eigen::Matrix3d>(*rotation);
    return marker;
}

void read_markers(const TableReader& table, Body& body) {
    const TomlMember* markers = table.find("markers");
    if (!markers) return;
    if (!markers->value.is_table())
        return table.error(markers->value.place, fmt::format("markers must be a table of name = [x, y, z], got {}",
                                                             kind_text(markers->value.kind)));
    NameRegistry names("marker");
    body.markers.reserve(markers->value.members.size());
    for (const TomlMember& member : markers->value.members) body.markers.push_back(read_marker(table, member, names));
}

/// Longer than all but ships and towers. A millimetre read as a metre makes a part of 0.1 m as long.
constexpr double kLongBody = 100;  // [m]
/// Of the reach of the markers.
constexpr double kLargestGyration = 30;

/// The largest radius of gyration, in a bar sqrt(1/12) of its length, says how large a body is.
void warn_size(const TableReader& table, const Body& body) {
    if (!(body.mass > 0)) return;
    const double gyration = std::sqrt(body.inertia.trace() / 2 / body.mass);  // >= the largest, = for a bar
    double reach = 0;
    for (const Marker& marker : body.markers) reach = std::max(reach, (marker.position - body.center_of_mass).norm());
    const double size = gyration * std::sqrt(12.0);
    if (size > kLongBody)
        table.warning(table.place(), "size",
                      fmt::format("by its inertia the body is about {:.3g} m large: check the units of lengths, or of mass "
                                  "and inertia",
                                  size));
    // A flywheel may be some ten times as large as the reach of its bearings
    else if (table.find("inertia") && reach > 0 && gyration > kLargestGyration * reach)
        table.warning(table.find("inertia")->value.place, "inertia",
                      fmt::format("the radius of gyration is {:.3g} m, but no marker is further than {:.3g} m from the "
                                  "centre of mass: check the unit of the inertia",
                                  gyration, reach));
}

Body read_body(const ReadContext& context, const TomlValue& entry, std::size_t index, NameRegistry& names) {
    const TableReader table(context, entry, entry_label("body", entry, index), key_table("body"), entry_note("body", index));
    Body body;
    if (!table.is_valid()) return body;
    const Eigen::Vector3d zero = Eigen::Vector3d::Zero();
    body.name = names.add_from(table);
    check_name(table, body.name);
    read_mass_properties(table, body);
    body.center_of_mass = table.vector("center_of_mass", zero).value_or(zero);
    body.position = table.vector("position", zero).value_or(zero);
    body.rotation = read_rotation(table).value_or(body.rotation);
    body.velocity = table.vector("velocity", zero).value_or(zero);
    body.angular_velocity = table.vector("angular_velocity", zero).value_or(zero);
    read_markers(table, body);
    warn_size(table, body);
    if (const TomlMember* position = table.find("position"))
        check_position(context, position->value.place, entry_label("body", entry, index), body.position);
    return body;
}

}  // namespace

std::vector<Body> read_bodies(const TableReader& file, NameRegistry& names) {
    std::vector<Body> bodies;
    for (const TomlValue& entry : read_entries(file, "body"))
        bodies.push_back(read_body(file.context(), entry, bodies.size(), names));
    return bodies;
}

}  // namespace dttmm::host
