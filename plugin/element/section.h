// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>
#include <span>

#include "core/types.h"
#include "dttmm_plugin.h"
#include "element/parameters.h"

namespace dttmm::plugin {

/// What makes stresses of the forces in a section; not a number where only its stiffnesses are known.
struct SectionModuli {
    double area = std::numeric_limits<double>::quiet_NaN();  ///< [m²]
    double about_y = 0, about_z = 0;  ///< second moment over the distance of the outermost fibre [m³]
    bool is_round = false;            ///< it bends alike in all directions
    bool are_known() const { return area > 0; }
    /// The largest normal stress by magnitude [Pa], tension positive, of an axial force and bending moments.
    double extreme_stress(double axial, double moment_y, double moment_z) const;
};

/// Stiffness and inertia of a beam per length, local axes: x along the beam. What the model does not give, and does not
/// follow from what it gives, is not a number.
struct Section {
    double EA = 0;                      ///< axial stiffness [N]
    double EIy = 0, EIz = 0;            ///< bending stiffness: about y (deflection along z), about z (along y) [N m²]
    double GJ = 0;                      ///< torsional stiffness [N m²]
    double GAy = 0, GAz = 0;            ///< shear stiffness κGA along y and z [N]; infinite for Euler-Bernoulli
    double mass = 0;                    ///< [kg/m]
    double inertia = 0;                 ///< polar, about the elastic axis [kg m]
    double rotary_y = 0, rotary_z = 0;  ///< of the section about y and z [kg m]; zero for Euler-Bernoulli
    double offset_y = 0, offset_z = 0;  ///< of the mass axis from the elastic axis [m]
    double stiffness_damping = 0;       ///< damping over stiffness of every deformation [s]
    double loss_factor = 0;             ///< of every stiffness in vibration
    SectionModuli moduli = {};
};

/// Shear coefficient κ of a section, Cowper (1966), J. Appl. Mech. 33, 335–340; ν: Poisson's ratio.
double cowper_tube(double poisson, double inner_over_outer);  ///< 0: solid circle, 1: thin tube
double cowper_rectangle(double poisson);

/// The parameters of a section and its material, for beams and rods: a shape, or stiffnesses and mass.
inline constexpr std::array kSectionParameters = {
    optional("section.tube", "m", 2, 0, kLargest, "outer and inner diameter"),
    optional("section.circle", "m", 1, kPositive, kLargest, "diameter"),
    optional("section.rectangle", "m", 2, kPositive, kLargest, "extent along local y and z"),
    optional("section.shear_coefficient", "1", 1, 1e-3, 1, "kappa, along y and z; Cowper's if not given"),
    optional("section.EA", "N", 1, kPositive, kLargest, "axial stiffness"),
    optional("section.EIy", "N*m^2", 1, kPositive, kLargest, "bending stiffness about y: deflection along z"),
    optional("section.EIz", "N*m^2", 1, kPositive, kLargest, "bending stiffness about z: deflection along y"),
    optional("section.GJ", "N*m^2", 1, kPositive, kLargest, "torsional stiffness"),
    optional("section.GAy", "N", 1, kPositive, kLargest, "shear stiffness kappa G A along y (Timoshenko)"),
    optional("section.GAz", "N", 1, kPositive, kLargest, "shear stiffness kappa G A along z (Timoshenko)"),
    optional("section.mass", "kg/m", 1, kPositive, kLargest, "per length"),
    optional("section.inertia", "kg*m", 1, 0, kLargest, "polar moment of inertia per length about the elastic axis"),
    optional("section.mass_offset", "m", 2, -kLargest, kLargest, "of the mass axis from the elastic axis, along y and z"),
    optional("material.E", "Pa", 1, kPositive, kLargest, "Young's modulus"),
    optional("material.G", "Pa", 1, kPositive, kLargest, "shear modulus; from E and poisson if not given"),
    optional("material.poisson", "1", 1, -0.999, 0.4999, "Poisson's ratio"),
    optional("material.density", "kg/m^3", 1, kPositive, kLargest, "mass per volume"),
    zero_by_default("material.stiffness_damping", "s", 0, "damping over stiffness of every deformation"),
    zero_by_default("material.loss_factor", "1", 0, kLossFactorHelp),
};

/// Their numbers in that order.
inline constexpr size_t kSectionValueCount = 22;

enum class BeamTheory { euler_bernoulli, timoshenko };

/// The section that the parameters describe: by its shape and a material, or by its stiffnesses. Throws
/// Error(DTTMM_ERROR_MODEL) naming the key for what is missing, contradicts itself or cannot be.
Section make_section(std::span<const double, kSectionValueCount> values, BeamTheory theory);

}  // namespace dttmm::plugin
