// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_rotation.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

namespace dttmm::host {
namespace {

constexpr double kNormTolerance = 1e-6;
/// More is meant in degrees [rad].
constexpr double kLargestAngle = 2 * M_PI * (1 + 1e-9);

std::optional<Eigen::Matrix3d> read_quaternion(const TableReader& table) {
    const auto q = table.numbers("quaternion");
    if (!q) return std::nullopt;
    const Eigen::Quaterniond quaternion((*q)[0], (*q)[1], (*q)[2], (*q)[3]);
    const double norm = std::hypot(quaternion.w(), quaternion.vec().stableNorm());
    if (!(std::abs(norm - 1) <= kNormTolerance)) {
        table.error(table.find("quaternion")->value.place,
                    fmt::format("quaternion [w, x, y, z] must have norm 1 to within {}, got {}", kNormTolerance, norm));
        return std::nullopt;
    }
    return quaternion.normalized().toRotationMatrix();
}

}  // namespace

std::optional<Eigen::Matrix3d> read_axis_and_angle(const TableReader& outer, const TomlMember& member,
                                                   const std::string& what) {
    const TableReader table(outer.context(), member.value, what, key_table("rotation"));
    if (!table.is_valid()) return std::nullopt;
    const auto axis = read_direction(table, "axis");
    const auto angle = table.number("angle");
    if (!axis || !angle) return std::nullopt;
    if (std::abs(*angle) > kLargestAngle) {
        table.error(table.find("angle")->value.place,
                    fmt::format("angle must be within a turn, got {:g} rad; degrees stand in quotes: \"30 deg\"", *angle));
        return std::nullopt;
    }
    return Eigen::AngleAxisd(*angle, *axis).toRotationMatrix();
}

std::optional<Eigen::Matrix3d> read_rotation(const TableReader& table) {
    const TomlMember* rotation = table.find("rotation");
    const TomlMember* quaternion = table.find("quaternion");
    if (rotation && quaternion) table.require_one(kRotationKeys);
    if (rotation) return read_axis_and_angle(table, *rotation, table.what("rotation"));
    if (quaternion) return read_quaternion(table);
    return Eigen::Matrix3d::Identity();
}

std::optional<Eigen::Vector3d> read_direction(const TableReader& table, const char* key) {
    const auto direction = table.vector(key);
    if (!direction) return std::nullopt;
    if (direction->stableNorm() > 0) return direction->stableNormalized();
    table.error(table.find(key)->value.place, fmt::format("{} must not be zero", key));
    return std::nullopt;
}

std::optional<Eigen::Vector3d> read_zero(const TableReader& table, const char* key, const Eigen::Vector3d& axis,
                                         const char* axis_name) {
    Eigen::Index nearest = 0;
    axis.cwiseAbs().maxCoeff(&nearest);
    Eigen::Vector3d zero = Eigen::Vector3d::Unit((nearest + 1) % 3);
    if (table.find(key)) {
        const auto given = read_direction(table, key);
        if (!given) return std::nullopt;
        zero = *given;
    }
    zero -= axis.dot(zero) * axis;
    if (zero.norm() > 1e-6) return zero.normalized();
    table.error(table.find(key)->place, fmt::format("{} lies along {}", key, axis_name));
    return std::nullopt;
}

}  // namespace dttmm::host
