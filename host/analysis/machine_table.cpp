// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/machine_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "analysis/machine_geometry.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr size_t kMostLines = 40;

std::string point_text(const Eigen::Vector3d& p) {
    const Eigen::Vector3d shown = (p.array().abs() < 1e-12).select(0.0, p);  // rounding of a rotation
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", shown.x(), shown.y(), shown.z());
}

std::string rest_text(size_t count) {
    return count > kMostLines ? fmt::format("    and {} more\n", count - kMostLines) : std::string();
}

std::string describe_bodies(const Model& model) {
    if (model.bodies.empty()) return {};
    size_t width = 10;
    for (size_t b = 0; b < std::min(model.bodies.size(), kMostLines); ++b)
        width = std::max(width, model.bodies[b].name.size());
    std::string text = fmt::format("    {:<{}}  {:>12}  {:<30}  {}\n", "body", width, "mass [kg]", "box of its inertia [m]",
                                   "centre of mass [m]");
    double mass = 0;
    Eigen::Vector3d moment = Eigen::Vector3d::Zero();
    for (size_t b = 0; b < model.bodies.size(); ++b) {
        const Body& body = model.bodies[b];
        const Eigen::Vector3d centre = body.position + body.rotation * body.center_of_mass,
                              box = equal_box(body.mass, body.inertia).edges;
        mass += body.mass;
        moment += body.mass * centre;
        if (b < kMostLines)
            text += fmt::format("    {:<{}}  {:>12.6g}  {:<30}  {}\n", body.name, width, body.mass,
                                fmt::format("{:.6g} x {:.6g} x {:.6g}", box.x(), box.y(), box.z()), point_text(centre));
    }
    text += rest_text(model.bodies.size());
    return text +
           fmt::format("    {:<{}}  {:>12.6g}  {:<30}  {}\n", "all bodies", width, mass, "", point_text(moment / mass));
}

std::string describe_geometry(const Model& model, const Element& element, const dttmm_element_type& type) {
    const ElementPlace place = place_at_start(model, element, type);
    if (type.ends == DTTMM_ENDS_AT) return fmt::format("at {}", point_text(place.from));
    const Eigen::Matrix3d& axes = place.axes;
    if (is_line(type) && place.is_long())
        return fmt::format("{:.6g} m long, x along {}", place.length(), point_text(axes.col(0)));
    std::string text = fmt::format("x along {}", point_text(axes.col(0)));
    if (!axes.isIdentity(1e-12)) text += fmt::format(", y along {}", point_text(axes.col(1)));
    if (!element.axes) text += element.ends[0].is_ground() ? " of its `to` end" : " of its `from` end";
    if (place.is_long()) text = fmt::format("{:.6g} m long, {}", place.length(), text);
    const bool is_joint = std::string_view(type.name) == "spring_damper" || std::string_view(type.name) == "elastic_hinge";
    return place.is_long() && is_joint ? text + "; its force acts at its `to` end" : text;
}

std::string describe_elements(const Model& model, const ElementCatalogue& catalogue) {
    size_t width = 10;
    for (size_t e = 0; e < std::min(model.elements.size(), kMostLines); ++e)
        width = std::max(width, model.elements[e].name.size());
    std::string text;
    for (size_t e = 0; e < std::min(model.elements.size(), kMostLines); ++e) {
        const Element& element = model.elements[e];
        const dttmm_element_type& type = *catalogue.types[as_size(element.type)];
        text +=
            fmt::format("    {:<{}}  {:<14} {}\n", element.name, width, type.name, describe_geometry(model, element, type));
    }
    return text + rest_text(model.elements.size());
}

}  // namespace

std::string describe_machine(const Model& model, const ElementCatalogue& catalogue) {
    return describe_bodies(model) + describe_elements(model, catalogue);
}

}  // namespace dttmm::host
