// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <span>
#include <vector>

namespace dttmm::plugin {

/// A dynamic stiffness at a frequency: force over deformation of a vibration, k e^(iδ).
struct DynamicStiffnessRow {
    double omega;      ///< [rad/s]
    double stiffness;  ///< k, its magnitude [N/m, N m/rad]
    double angle;      ///< δ, by which the force leads [rad]
    std::complex<double> value() const { return std::polar(stiffness, angle); }
};

/// A spring beside Maxwell elements, each a spring and a damper in a row:
///     K(s) = k + Σ k_j s τ_j/(1 + s τ_j),     k, k_j ≥ 0
/// It is the form in time of a stiffness that depends on the frequency. Source: Findley, Lai and Onaran (1976), Creep and
/// Relaxation of Nonlinear Viscoelastic Materials, chapter 5.
struct MaxwellSeries {
    struct Term {
        double stiffness;  ///< [N/m, N m/rad]
        double time;       ///< τ [s]
    };
    double spring = 0;  ///< k, at rest [N/m, N m/rad]
    std::vector<Term> terms;

    std::complex<double> at(double omega) const;

    /// The largest |K − row|/|row|, and where.
    struct Misfit {
        double share = 0, omega = 0;
    };
    Misfit misfit(std::span<const DynamicStiffnessRow> rows) const;
};

/// The series with the least sum of |K(iω) − row|²/|row|², no stiffness negative, its times spread evenly over the logarithm
/// of the frequency from a third of the lowest to three times the highest. rows: two or more, their frequencies ascending
/// and positive, stiffnesses positive. Terms that are not needed are left out.
MaxwellSeries fit_maxwell(std::span<const DynamicStiffnessRow> rows);

}  // namespace dttmm::plugin
