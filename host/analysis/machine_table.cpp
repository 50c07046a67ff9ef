// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/machine_table.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <string_view>

#include "coupling/network_description.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr size_t kMostLines = 40;
/// Ends nearer than this are one place: positions of the file and rotations are rounded at 1e-16 of some metres.
constexpr double kSamePlace = 1e-9;  // [m]

std::string point_text(const Eigen::Vector3d& p) {
    const Eigen::Vector3d shown = (p.array().abs() < 1e-12).select(0.0, p);  // rounding of a rotation
    return fmt::format("({:.6g}, {:.6g}, {:.6g})", shown.x(), shown.y(), shown.z());
}

/// Sides of the box of the same mass and inertia, largest first [m]: I_1 = m (b² + c²)/12 and so on.
Eigen::Vector3d equal_box(const Body& body) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(body.inertia, Eigen::EigenvaluesOnly);
    const Eigen::Vector3d I = solver.eigenvalues();
    const Eigen::Vector3d squares = 6 / body.mass * (Eigen::Vector3d::Constant(I.sum()) - 2 * I);
    return squares.cwiseMax(0).cwiseSqrt();
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
        const Eigen::Vector3d centre = body.position + body.rotation * body.center_of_mass, box = equal_box(body);
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
    if (type.ends == DTTMM_ENDS_AT) return fmt::format("at {}", point_text(frame_at_start(model, element.ends[0]).position));
    const Attachment &from = element.ends[0], &to = element.ends[1];
    const bool is_grounded = from.is_ground() || to.is_ground();
    const Frame first = frame_at_start(model, from.is_ground() ? to : from);
    const Eigen::Vector3d line =
        is_grounded ? Eigen::Vector3d::Zero() : Eigen::Vector3d(frame_at_start(model, to).position - first.position);
    if (is_line(type) && line.norm() > kSamePlace)
        return fmt::format("{:.6g} m long, x along {}", line.norm(), point_text(line.normalized()));
    // A ground end has the axes of the other end
    const Eigen::Matrix3d axes = element.axes.value_or(first.rotation);
    std::string text = fmt::format("x along {}", point_text(axes.col(0)));
    if (!axes.isIdentity(1e-12)) text += fmt::format(", y along {}", point_text(axes.col(1)));
    if (!element.axes) text += from.is_ground() ? " of its `to` end" : " of its `from` end";
    if (line.norm() > kSamePlace) text = fmt::format("{:.6g} m long, {}", line.norm(), text);
    const bool is_joint = std::string_view(type.name) == "spring_damper" || std::string_view(type.name) == "elastic_hinge";
    return line.norm() > kSamePlace && is_joint ? text + "; its force acts at its `to` end" : text;
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
