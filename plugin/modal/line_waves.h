// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "core/driven_ends.h"
#include "element/element.h"
#include "modal/line_equations.h"
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
/// Where the axial force is linear along it S is a parabola, and U the power series that solves U' = S U: one piece is as
/// exact as with a uniform force.
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
    /// falling: what holds, or tips over, its rotations per length, as a weight beside its axis does [N]: m' has + F θ.
    ///
    /// The directions of its ends in which it moves with waves: `active` are those of the local axes that the model leaves.
    /// A bending plane goes by its deflection; without it the rotation passes unchanged (see passed()). Throws
    /// Error(DTTMM_ERROR_MODEL) naming a stiffness of the section that is needed and not given.
    LineWaves(const Line& line, double length, Directions active, Axial axial = {},
              const Matrix3& falling = Matrix3::Zero());

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
    /// Why it is refused where its axial force alone wants more.
    static std::string too_strong_to_cut();
    /// Share of λ that pieces are cut for beyond that which is asked for: at the frequency of a held bar its stiffness is
    /// infinite, with 2 it is −1.7 times that at rest. With 1.05 to 4, 59 random machines, the hydroplane and the headstock
    /// have the same frequencies to 3e-10, in the same time.
    static constexpr double kMargin = 2;
    /// Pieces it must be cut into so that none vibrates below ω with its ends held, by a lower bound: the frequencies of the
    /// whole below ω can then be counted at its nodes. At most `most` + 1.
    int pieces(double omega, int most) const;
    /// The longest piece that surely does not at any ω² below λ [m].
    double longest_held(double lambda) const;

    /// Dynamic stiffness of one of `count` equal pieces, [force; moment] on its start and end by their displacements, and
    /// the mass −∂D/∂λ if given. stiffening: 1 + iωη of a complex modulus. index: which piece, where it is graded.
    template <class Scalar>
    void evaluate(int count, Scalar lambda, Scalar stiffening, Square<Scalar>& stiffness, Square<Scalar>* mass,
                  int index = 0) const;

    /// The same of a real λ by the powers of λ that U is a sum of: an entire function, of which few are felt. Ten times as
    /// quick, and as long in the making as evaluate() takes six times.
    struct Expansion {
        double largest;  ///< |λ| that it goes up to [1/s²]
        double length;   ///< [m]
        struct OfGroup {
            size_t powers = 0;      ///< 0: an axial or torsional wave, which is quick without
            std::vector<double> U;  ///< one after the other, of λ/largest
            Eigen::VectorXd unit_d, unit_n;
        };
        std::vector<OfGroup> groups;
    };
    /// None: too many powers are felt.
    std::optional<Expansion> expand(int count, double largest, int index = 0) const;
    void evaluate(const Expansion& expansion, double lambda, Matrix12& stiffness, Matrix12* mass) const;

    /// From `start` over s [m]: exp(S s), [d; n] order, directions without waves unchanged.
    Matrix12 transfer(double lambda, double s, double start = 0) const;

    /// That times a state at `start`.
    Vector12 carry(Vector12 state, double lambda, double s, double start = 0) const;

    /// At λ = 0.
    LineShapes static_shapes() const;

private:
    /// Of n directions, or of up to six: n is then Eigen::Dynamic.
    template <int n>
    static constexpr int kMost = n < 0 ? 6 : n;
    template <int n>
    static constexpr int kTwice = n < 0 ? n : 2 * n;
    template <class Scalar, int n>
    using Part = Eigen::Matrix<Scalar, n, n, 0, kMost<n>, kMost<n>>;
    template <class Scalar, int n>
    using Whole = Eigen::Matrix<Scalar, kTwice<n>, kTwice<n>, 0, 2 * kMost<n>, 2 * kMost<n>>;
    template <int n>
    using Numbers = Eigen::Matrix<double, n, 1, 0, kMost<n>, 1>;
    /// Directions that couple with each other.
    struct Group {
        using Few = Part<double, Eigen::Dynamic>;
        std::vector<int> directions;
        Few A, M, falling;
        Numbers<Eigen::Dynamic> C, unit_d, unit_n;  ///< diagonal of C; units of d and n for a piece of unit length
        /// An axial force N makes A of A + N A_by_N, and adds to n' by d N Aᵀ (A + N A_by_N).
        Few A_by_N() const { return -(C.asDiagonal() * A); }
        Few A_at(double axial) const { return A + axial * A_by_N(); }
        int mirror = -1;  ///< group of the other plane that is the same but for the sense of its rotation
    };
    /// U of a group and its derivative by λ, in units of d and n.
    template <class Scalar, int n>
    struct Waves {
        Whole<Scalar, n> U, by_lambda;
        Numbers<n> unit_d, unit_n;
    };
    /// length: that deflections count in; ud, un: units of d and n.
    template <class Scalar, int n>
    LineEquations<Whole<Scalar, n>> equations_of(const Group& group, double start, double s, Scalar lambda,
                                                 Scalar stiffening, double length, Numbers<n>& ud, Numbers<n>& un) const;
    template <class Scalar, int n>
    Waves<Scalar, n> waves(const Group& group, double start, double s, Scalar lambda, Scalar stiffening,
                           bool with_derivative) const;
    template <int n>
    static Waves<double, n> waves(const Expansion::OfGroup& own, double share, bool with_derivative);
    template <class Scalar, class WavesOf>
    void evaluate_groups(Square<Scalar>& stiffness, Square<Scalar>* mass, const WavesOf& waves_of) const;
    template <class Matrix>
    void copy_mirrored(const Group& group, size_t rows, Matrix& matrix) const;
    template <class Scalar, int n>
    static void add_group(const Group& group, const Waves<Scalar, n>& waves, Square<Scalar>& stiffness,
                          Square<Scalar>* mass);
    /// Length in which waves of the group vary, over s at most s: with it as unit no number is large.
    double scale(const Group& group, double start, double s, double lambda) const;
    double axial_at(double s) const { return axial_[0] + s / length_ * (axial_[1] - axial_[0]); }
    double longest_held(const Group& group, double lambda) const;
    void group_directions(const Section& s, Directions moving, const Matrix6& M, const Matrix6& falling, const Vector6& C);
    static bool is_mirror(const Group& one, const Group& other);

    static constexpr size_t kPowers = 24;  ///< of λ at most; the longest piece feels about ten
    double length_;
    Axial axial_;
    Directions passed_, pinned_;
    std::vector<Group> groups_;
};

}  // namespace dttmm::plugin
