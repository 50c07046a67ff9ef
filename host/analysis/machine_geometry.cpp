// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/machine_geometry.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <optional>
#include <string_view>

#include "coupling/network_description.h"

namespace dttmm::host {

namespace {

/// Parameter `up` of a line: NaN where the file does not give it; none where the type has no such parameter.
std::optional<Eigen::Vector3d> find_up(const Element& element, const dttmm_element_type& type) {
    std::size_t at = 0;
    for (uint32_t p = 0; p < type.parameter_count; at += type.parameters[p++].count)
        if (std::string_view(type.parameters[p].name) == "up" && type.parameters[p].count == 3)
            return Eigen::Vector3d(element.values[at], element.values[at + 1], element.values[at + 2]);
    return std::nullopt;
}

/// x along the line, z as near to `up` as can be; NaN: the world's z, or its x for a vertical line.
Eigen::Matrix3d line_axes(const Eigen::Vector3d& x, const Eigen::Vector3d& up) {
    Eigen::Vector3d z = up;
    if (!up.allFinite()) z = x.head<2>().norm() < 1e-6 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
    const Eigen::Vector3d y = z.cross(x).normalized();
    Eigen::Matrix3d axes;
    axes << x, y, x.cross(y);
    return axes;
}

Model read_standing(const Request& request, const Plugins& plugins) {
    ModelOverrides overrides = request.overrides;
    overrides.purpose = Purpose::modes;  // wants least of a model
    return read_model(request.model, plugins.catalogue(), overrides);
}

}  // namespace

Eigen::Vector3d position_at_start(const Model& model, const Attachment& at) { return frame_at_start(model, at).position; }

StandingMachine::StandingMachine(const Request& request)
    : plugins(request.plugins), model(read_standing(request, plugins)) {}

EqualBox equal_box(double mass, const Eigen::Matrix3d& inertia) {
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(inertia);
    const Eigen::Vector3d I = solver.eigenvalues();
    Eigen::Vector3d squares = Eigen::Vector3d::Zero();
    if (mass > 0) squares = 6 / mass * (Eigen::Vector3d::Constant(I.sum()) - 2 * I);
    Eigen::Matrix3d axes = solver.eigenvectors();
    if (axes.determinant() < 0) axes.col(2) *= -1;
    return {squares.cwiseMax(0).cwiseSqrt(), axes};
}

ElementPlace place_at_start(const Model& model, const Element& element, const dttmm_element_type& type) {
    if (type.ends == DTTMM_ENDS_AT) {
        const Frame at = frame_at_start(model, element.ends[0]);
        return {at.position, at.position, at.rotation};
    }
    const Attachment &from = element.ends[0], &to = element.ends[1];
    const Frame first = frame_at_start(model, from.is_ground() ? to : from);
    ElementPlace place{first.position, first.position, element.axes ? *element.axes : first.rotation};
    place.is_grounded = from.is_ground() || to.is_ground();
    if (!place.is_grounded) place.to = frame_at_start(model, to).position;
    if (is_line(type) && place.is_long()) {
        const std::optional<Eigen::Vector3d> up = find_up(element, type);
        const Eigen::Vector3d unknown = Eigen::Vector3d::Constant(std::nan(""));
        place.axes = line_axes((place.to - place.from).normalized(), up.value_or(unknown));
        place.has_only_x = !up;
    }
    return place;
}

}  // namespace dttmm::host
