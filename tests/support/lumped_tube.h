// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>

namespace dttmm::test {

/// The lumped Timoshenko beam of the bond-space paper, corrected, for a round tube: masses at the middle of the segments;
/// what gives at the face between two is the right half of the one and the left half of the other, each a cantilever of
/// length half held at its mass. Efforts at the face [Q_z, M_y], flows [z', θ'], θ about y.
struct LumpedTube {
    double half;                  ///< of a segment [m]
    double mass, inertia;         ///< of a lump [kg], about its diameter [kg m²]
    double EA, EI, shear;         ///< [N], [N m²], κGA [N]
    double mass_per_length;       ///< [kg/m]
    double rotary;                ///< ρI [kg m]
    Eigen::Matrix2d right, left;  ///< compliances of the halves

    LumpedTube(double outer, double inner, double length, double E, double nu, double rho, int segments) {
        const double A = std::numbers::pi / 4 * (outer * outer - inner * inner),
                     I = std::numbers::pi / 64 * (std::pow(outer, 4) - std::pow(inner, 4));
        const double m2 = std::pow(inner / outer, 2), p2 = (1 + m2) * (1 + m2);  // Cowper's coefficient of a hollow circle
        const double kappa = 6 * (1 + nu) * p2 / ((7 + 6 * nu) * p2 + (20 + 12 * nu) * m2);
        EA = E * A;
        EI = E * I;
        shear = kappa * A * E / (2 * (1 + nu));
        mass_per_length = rho * A;
        rotary = rho * I;
        const double l = length / segments, h = l / 2;
        half = h;
        mass = rho * A * l;
        inertia = rho * I * l + mass * l * l / 12;
        const double a = h * h * h / (3 * EI) + h / shear, b = h * h / (2 * EI), g = h / EI;
        right << a, -b, -b, g;
        left << a, b, b, g;
    }
};

}  // namespace dttmm::test
