// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <utility>
#include <vector>

#include "support/oracle.h"

namespace dttmm::test {

/// A uniform Timoshenko beam, bending in one plane, exact: its transfer matrix is exp(S x) with, in the signs of the state
/// vector z = [y θ m q],
///     y' = θ − q/κGA,   θ' = m/EI,   m' = q − ρI ω² θ,   q' = ρA ω² y
/// Nothing is discretised. Extended precision: a free-free determinant loses digits like cosh βL.
struct DTTMM_ORACLE ExactTimoshenko {
    using Real = long double;
    using Matrix = Eigen::Matrix<Real, 4, 4>;
    using Vector = Eigen::Matrix<Real, 4, 1>;

    double EI, shear, mass, rotary, length;  ///< [N m²], κGA [N], [kg/m], ρI [kg m], [m]

    Matrix transfer(double omega, double x) const;

    /// Neither force nor moment at both ends.
    Real free_free(double omega) const;

    /// Angular frequencies of the first `count` bending modes of the free beam [rad/s], by steps of `step` and bisection.
    std::vector<double> free_frequencies(int count, double step) const;

    /// Deflection at x of the free mode at omega; its size is of no meaning.
    double free_shape(double omega, double x) const;
};

/// The same beam clamped at one end with a rigid mass at the other, its tip under a sudden force: exact modal solution,
///     y(t) = F Σ r_i (1 − cos ω_i t),   r_i = φ_i²/(M_i ω_i²): the residues of the receptance y/F at the frequencies.
class DTTMM_ORACLE ExactTipMass {
public:
    /// modes: how many of the series.
    ExactTipMass(const ExactTimoshenko& beam, double tip_mass, double tip_inertia, int modes);
    double tip(double force, double t) const;
    const std::vector<double>& frequencies() const { return omegas_; }  ///< [rad/s]
    /// Static deflection per force that the modes add up to.
    double compliance() const;

private:
    /// Numerator and denominator of y/F at the tip.
    std::pair<ExactTimoshenko::Real, ExactTimoshenko::Real> receptance(double omega) const;

    ExactTimoshenko beam_;
    double mass_, inertia_;
    std::vector<double> omegas_, shares_;
};

}  // namespace dttmm::test
