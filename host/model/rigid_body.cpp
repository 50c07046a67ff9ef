// SPDX-License-Identifier: BSD-3-Clause
#include "model/rigid_body.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

namespace dttmm::host {
namespace {
constexpr double kSmallestMass = 1e-12;  // [kg]
constexpr double kLargestMass = 1e12;    // [kg]
constexpr double kTriangleTolerance = 1e-9;
constexpr double kLeastGyration = 1e-7;   // radius [m]
constexpr double kLargestInertia = 1e24;  // of kLargestMass at 1000 km, the farthest a body may be [kg m²]
}  // namespace

MassProperties make_box(double density, const Eigen::Vector3d& lengths) {
    const double mass = density * lengths.prod();
    const Eigen::Vector3d squares = lengths.cwiseAbs2();
    const Eigen::Vector3d moments = mass / 12 * (Eigen::Vector3d::Constant(squares.sum()) - squares);
    return {mass, moments.asDiagonal()};
}

MassProperties make_tube(double density, double outer_diameter, double inner_diameter, double length, int axis) {
    const double squares = outer_diameter * outer_diameter + inner_diameter * inner_diameter;
    const double section = std::numbers::pi / 4 * (outer_diameter - inner_diameter) * (outer_diameter + inner_diameter);
    const double mass = density * section * length;
    Eigen::Vector3d moments = Eigen::Vector3d::Constant(mass * (0.75 * squares + length * length) / 12);
    moments[axis] = mass * squares / 8;
    return {mass, moments.asDiagonal()};
}

MassProperties make_sphere(double density, double diameter) {
    const double mass = density * std::numbers::pi / 6 * diameter * diameter * diameter;
    return {mass, mass * diameter * diameter / 10 * Eigen::Matrix3d::Identity()};
}

std::optional<std::string> find_mass_fault(double mass) {
    if (mass >= kSmallestMass && mass <= kLargestMass) return std::nullopt;
    return fmt::format("mass must lie within {} kg and {} kg, got {} kg", kSmallestMass, kLargestMass, mass);
}

std::optional<std::string> find_inertia_fault(const Eigen::Matrix3d& inertia, double mass) {
    if (!inertia.allFinite()) return "inertia must be finite";
    const Eigen::Vector3d p = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
    const std::string moments = fmt::format("principal moments {:.17g}, {:.17g}, {:.17g} kg m²", p[0], p[1], p[2]);
    if (!(p[0] > 0)) return "inertia must be positive definite: " + moments;
    if (p[0] < kLeastGyration * kLeastGyration * mass)
        return fmt::format("inertia is too small beside the mass of {:g} kg (radius of gyration below {:g} m): {}", mass,
                           kLeastGyration, moments);
    if (p[2] > kLargestInertia) return fmt::format("inertia must be {:g} kg m² at most: {}", kLargestInertia, moments);
    if (p[2] - p[1] - p[0] > kTriangleTolerance * p[2])  // p[0] <= p[1] <= p[2]
        return "inertia breaks the triangle inequality, the largest principal moment exceeds the sum of the others: " +
               moments;
    return std::nullopt;
}

}  // namespace dttmm::host
