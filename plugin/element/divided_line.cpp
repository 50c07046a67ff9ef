// SPDX-License-Identifier: BSD-3-Clause
#include "element/divided_line.h"

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "core/error.h"

namespace dttmm::plugin {

namespace {

constexpr double kShortest = 1e-6;  // [m]

}  // namespace

Matrix3 beam_axes(const Vector3& from, const Vector3& to, const Vector3& up) {
    const double length = (to - from).norm();
    if (!(length >= kShortest))
        throw Error(
            DTTMM_ERROR_MODEL,
            fmt::format("its ends are {:.3g} m apart; it needs a length of at least {:g} m. An end on \"ground\" lies "
                        "where the other end is: to clamp it elsewhere give it a node with all of fixed = [\"x\", "
                        "\"y\", \"z\", \"rx\", \"ry\", \"rz\"]",
                        length, kShortest));
    const Vector3 x = (to - from) / length;
    Vector3 z;
    if (up.array().isNaN().any()) {
        const bool is_vertical = x.head<2>().norm() < 1e-6;
        z = is_vertical ? Vector3::UnitX() : Vector3::UnitZ();
    } else {
        if (!(up.norm() > 0) || x.cross(up.normalized()).norm() < 1e-6)
            throw Error(DTTMM_ERROR_MODEL, "up: it must have a length and must not lie along the beam");
        z = up.normalized();
    }
    // Square to rounding even where z and x are nearly one
    Vector3 y = z.cross(x).normalized();
    y = (y - x * x.dot(y)).normalized();
    Matrix3 axes;
    axes << x, y, x.cross(y);
    return axes;
}

Parts lay_out(std::span<const Pose> ends, const Matrix3& axes, int segments, const Lump& lump, const Vector3& offset,
              const JointLaw& whole, const JointLaw& half, const SectionModuli& moduli) {
    const Vector3 start = ends[0].position, way = ends[1].position - start;
    const auto point = [&](double segment) { return Vector3(start + segment / segments * way); };
    Parts parts;
    parts.segments = {way.norm() / segments, -offset, moduli};
    for (int i = 0; i < segments; ++i) {
        parts.lumps.push_back(lump);
        parts.lumps.back().pose = {point(i + 0.5) + axes * offset, axes};
    }
    const auto law = std::make_shared<const JointLaw>(whole), law_at_end = std::make_shared<const JointLaw>(half);
    for (int i = 0; i <= segments; ++i) {
        const bool is_end = i == 0 || i == segments;
        const double middle = i == 0 ? 0.25 : i == segments ? segments - 0.25 : i;
        parts.joints.push_back(
            {i == 0 ? 0 : 1 + i, i == segments ? 1 : 2 + i, is_end ? law_at_end : law, {point(middle), axes}});
    }
    return parts;
}

}  // namespace dttmm::plugin
