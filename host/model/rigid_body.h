// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>

namespace dttmm::host {

/// Mass [kg] and inertia about the centre of mass [kg m²] of homogeneous shapes, in axes through the centre of mass.
/// density [kg/m³] and lengths [m] are positive; `axis` is 0, 1 or 2 for x, y, z.
struct MassProperties {
    double mass = 0;
    Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
};

/// m = rho lx ly lz;  I_xx = m (ly² + lz²)/12, and so on.
MassProperties make_box(double density, const Eigen::Vector3d& lengths);

/// m = rho pi/4 (D² - d²) L;  about the axis m (D² + d²)/8, across it m (3 (D² + d²)/4 + L²)/12. d = 0 is a full cylinder.
MassProperties make_tube(double density, double outer_diameter, double inner_diameter, double length, int axis = 2);

/// m = rho pi/6 D³;  I = m D²/10 about every axis.
MassProperties make_sphere(double density, double diameter);

/// The rule a mass breaks: 1e-12 kg to 1e12 kg. Nothing if it breaks none.
std::optional<std::string> find_mass_fault(double mass);

/// The rule an inertia about the centre of mass breaks, with its principal moments in full: finite, positive definite,
/// its radii of gyration at least 1e-7 m, and no principal moment larger than the sum of the others (to 1e-9 of the
/// largest), as no distribution of mass has it. `inertia` is symmetric. Nothing if it breaks none.
std::optional<std::string> find_inertia_fault(const Eigen::Matrix3d& inertia, double mass);

}  // namespace dttmm::host
