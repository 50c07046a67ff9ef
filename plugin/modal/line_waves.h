// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <complex>
#include <vector>

#include "core/driven_ends.h"
#include "element/element.h"
#include "modal/line_forces.h"

namespace dttmm::plugin {

/// A uniform element at a frequency, in its local axes. Displacement d = [u; θ] and section force n = [f; m] on the positive
/// face obey, λ = ω²,
///     d' = A d + C n,   n' = −λ M d − Aᵀ n,      A: u' = θ × e_x,  C: compliances,  M: mass per length with its offset,
/// so that [d; n] at a distance s is U = exp(S s) times that at the start: no wave number is divided by, nothing is special
/// at λ = 0, and bending, shear, torsion and axial waves couple as the mass axis has it. Units are balanced and the
/// exponential is squared up from small steps, so that nothing overflows as long as the element is cut into pieces that do
/// not vibrate with their ends held (see pieces). In the letters of the state vector q = −f and m = m.
/// Source: theory of transfer matrices, Pestel and Leckie (1963); the hydroplane paper's eq. (9) is its 8 × 8 part.
/// Where the axial force is linear along it, so is S, and over a length h exp(h S + h³/12 [S', S]), S the mean, errs by
/// order h⁵: the expansion of Magnus (1954), Comm. Pure Appl. Math. 7, 649–673. It is symplectic as the equations are.
class LineWaves {
public:
    template <class Scalar>
    using Square = Eigen::Matrix<Scalar, 12, 12>;
    template <class Scalar>
    using Block = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic, 0, 12, 12>;
    using Column = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, 12, 1>;

    /// Axial force at rest at the start and at the end, linear between them.
    using Axial = std::array<double, 2>;
    /// axial: its force at rest [N], positive in tension. It keeps its direction, and turns with the section
    /// (Reissner's beam): v' = θ + (f − N θ)/GA and m' = −(1 − N/GA) f + (1 − N/GA) N θ in either plane, f across the line.
    ///
    /// The directions of its ends in which it moves with waves: `active` are those of the local axes that the model leaves.
    /// A bending plane goes by its deflection; without it the rotation passes unchanged (see passed()). Throws
    /// Error(DTTMM_ERROR_MODEL) naming a stiffness of the section that is needed and not given.
    LineWaves(const Line& line, double length, Directions active, Axial axial = {});

    /// Whether equal pieces of it differ, as the axial force does.
    bool is_graded() const { return axial_[0] != axial_[1]; }

    /// Directions that both ends share rigidly: rotations whose bending plane is not spanned; of a rod all but the axial
    /// (the ends of a bar, as it stands; with only some directions left each by itself, the paper's reduced state).
    Directions passed() const { return passed_; }
    /// Deflections of a rod whose bending rotation the model leaves out: its ends are pins, and it lies straight between
    /// them.
    Directions pinned() const { return pinned_; }

    /// Pieces that a line is cut into, at most.
    static constexpr int kMostPieces = 20000;
    /// Pieces it must be cut into so that none vibrates below ω with its ends held, by a lower bound: the frequencies of the
    /// whole below ω can then be counted at its nodes. More where the axial force varies, so that these err by at most 1e-6.
    /// At most `most` + 1.
    int pieces(double omega, int most) const;
    /// The longest piece that surely does not at any ω² below λ [m].
    double longest_held(double lambda) const;

    /// Dynamic stiffness of one of `count` equal pieces, [force; moment] on its start and end by their displacements, and
    /// the mass −∂D/∂λ if given. stiffening: 1 + iωη of a complex modulus. index: which piece, where it is graded.
    template <class Scalar>
    void evaluate(int count, Scalar lambda, Scalar stiffening, Square<Scalar>& stiffness, Square<Scalar>* mass,
                  int index = 0) const;

    /// From `start` over s [m]: exp(S s), [d; n] order, directions without waves unchanged.
    Matrix12 transfer(double lambda, double s, double start = 0) const;

    /// At λ = 0.
    LineShapes static_shapes() const;

private:
    /// Directions that couple with each other.
    struct Group {
        std::vector<int> directions;
        Block<double> A, M;  ///< A: without axial force
        /// A + N A_by_N, and what N adds to n' by d: N G_by_N + N² G_by_N2.
        Block<double> A_by_N, G_by_N, G_by_N2;
        Block<double> A_at(double axial) const { return A + axial * A_by_N; }
        Column C, unit_d, unit_n;  ///< diagonal of C; units of d and n for a piece of unit length
        int mirror = -1;           ///< group of the other plane that is the same but for the sense of its rotation
    };
    template <class Scalar>
    struct Waves {
        Block<Scalar> U, by_lambda;
        Column unit_d, unit_n;
    };
    template <class Scalar>
    Waves<Scalar> waves(const Group& group, double start, double s, Scalar lambda, Scalar stiffening,
                        bool with_derivative) const;
    double axial_at(double s) const { return axial_[0] + s / length_ * (axial_[1] - axial_[0]); }
    double longest_held(const Group& group, double lambda) const;
    void group_directions(const Section& s, Directions moving, const Matrix6& M, const Vector6& C);
    static bool is_mirror(const Group& one, const Group& other);

    double length_;
    Axial axial_;
    Directions passed_, pinned_;
    std::vector<Group> groups_;
};

}  // namespace dttmm::plugin
