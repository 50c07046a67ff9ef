// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <utility>
#include <vector>

#include "core/index.h"
#include "core/types.h"
#include "element/element.h"

namespace dttmm::plugin {

/// Displacements at points of a line, and their derivatives by its length, by the motion of its ends.
struct LineShapes {
    static constexpr std::array kPoints = {0.0694318442029737, 0.3300094782075719, 0.6699905217924281, 0.9305681557970263};
    static constexpr std::array kWeights = {0.1739274225687269, 0.3260725774312731, 0.3260725774312731, 0.1739274225687269};
    struct Shape {
        Eigen::Matrix<double, 6, 12> d, slope;
    };
    std::array<Shape, kPoints.size()> at;  ///< at Gauss' points, as shares of the length
    Matrix12 stiffness;                    ///< of the ends
};

/// What a weight does per length, [N] by rotations, at a place beside the axis that turns with the section: the second
/// derivative of its potential −½ w·(θ × (θ × c)).
Matrix3 falling(const Vector3& weight, const Vector3& beside);

/// A line at rest that its segments bend and load: where they meet, and the section forces there, [f; m] on the positive
/// face, world axes. Between these points it is straight, f is linear or, under loads that vary, quadratic, and m' = −e × f
/// along it makes m a cubic. Places on it are shares of it: of equal segments, each of which has an equal share.
class LineForces {
public:
    /// points: from its start to its end, one more than segments [m]. turning: of the loads that turn with it, their force
    /// per length at its start and at its end, its own axes, between which they are linear. factor: so many times the forces
    /// that have bent it.
    LineForces(std::vector<Vector3> points, std::vector<Vector6> forces, const Vector6& turning, double factor = 1);
    /// Its weight per length [N/m, world axes], which acts on the mass axis of its section.
    void set_weight(const Vector3& weight) { weight_ = weight; }
    /// By how much more the loads along it that keep their direction push at its end than at its start, its length times the
    /// force per length [N, world axes].
    void set_rise(const Vector3& rise) { rise_ = rise; }
    /// axes: of its segments, as columns in world. ends: the normals of its sections at its start and end, world.
    void set_sections(std::vector<Matrix3> axes, const std::array<Vector3, 2>& ends) {
        sections_ = std::move(axes);
        ends_ = ends;
    }
    /// What that does, in axes of a straight line: what its waves know.
    Matrix3 falling_in(const Matrix3& axes, const Section& section) const;

    int segments() const { return as_int(points_.size()) - 1; }
    /// Along its points [m].
    double length() const;
    Vector3 point(double share) const;
    Vector6 at(double share) const;
    const Vector6& first() const { return forces_.front(); }
    const Vector6& last() const { return forces_.back(); }
    Vector3 mean_force(double from = 0, double to = 1) const;
    Vector3 turning_load(double share) const;
    /// As set_rise(), of all its loads, where they act on a place [world axes].
    Vector3 rise(double share) const;
    /// How far its points lie beside the line between its ends, as share of the radius of gyration of the section.
    double bend(const Section& section) const;
    /// The same within one of its segments, by what its moments make of a straight one: so much no point shows.
    double bend_between(const Section& section) const;
    /// Into how many pieces the line is to be cut for frequencies of a relative error of 1e-6 and less: its segments at
    /// most, but for a straight one along which loads vary. 0: only the axial force counts, and no piece needs stiffness().
    int pieces(const Section& section) const;

    /// A piece of it that counts as straight, from share to share.
    struct Piece {
        double from, to;
        Matrix3 axes;                    ///< as columns in world, x from end to end
        double length;                   ///< [m]
        std::array<double, 2> axial;     ///< force that its waves know, at its start and end [N], linear between them
        std::array<Vector3, 2> normals;  ///< of its sections at its start and end, which neighbours share; world
        double share(double t) const { return from + t * (to - from); }
    };
    /// As many pieces of it. set_sections() comes before.
    std::vector<Piece> cut(int count, const Section& section) const;
    /// What its forces, but for the axial one, and the bend add to the stiffness of a piece, local axes. As forces turn
    /// with it: the second derivative of ∫ f·(−θ × u' + ½ θ × (θ × r')) − ½ m·(θ × θ') ds, θ the rotation vector, r' the
    /// direction of the axis. Loads q that turn with the line have no potential: the symmetric part of what they do, of −∫
    /// (θ × q)·δu ds, is added. The axis turns against the straight piece by φ, which moments make: it grows longer by ∫ (φ
    /// × e_x)·u' ds, of uniform tension, and bends and twists by ½ ∫ θ'·(R D Rᵀ − D) θ' ds, R = exp φ, D = diag(GJ, EIy,
    /// EIz). Where it turns about e_x, u' has θ_x e_x × (φ × e_x) more: what that makes between the ends is taken off the
    /// motion of the second one. The weight beside the axis turns with all that, too.
    /// The shape between the ends is that without all this, but for the torsion: it follows with a parabola, held by GJ.
    /// Without it the load at which a deep beam tips over would err by 0.25 % at ten segments, not by 2e-5. Errors of the
    /// stiffness fall as the fourth power of the length of a piece, but for those of the lumps that have bent the line. A
    /// round section may spin about the bent axis: that is exact under the forces that have bent it.
    Matrix12 stiffness(const Piece& piece, const Section& section, const LineShapes& shapes) const;

private:
    /// How far moments have turned the sections of a piece against it, in its axes, at Gauss' points and at its ends.
    struct Bend {
        Eigen::Matrix<double, 3, 4> turns;
        std::array<Vector3, 2> at_ends;
    };
    struct Integrands;
    Bend bend_of(const Piece& piece, const Section& section) const;
    Integrands integrands(size_t k, const Piece& piece, const Section& section, const Bend& bend) const;
    bool is_round(const Section& section) const;
    void let_spin(const Piece& piece, Matrix12& K) const;
    Matrix3 axes_along(const Vector3& way, double share) const;
    /// The segment that a share lies in, and where in it, from 0 to 1.
    std::pair<size_t, double> place(double share) const;

    std::vector<Vector3> points_;
    std::vector<Vector6> forces_;
    Vector6 turning_;
    double factor_;
    Vector3 weight_ = Vector3::Zero(), rise_ = Vector3::Zero();
    std::vector<Matrix3> sections_;
    std::array<Vector3, 2> ends_;
};

}  // namespace dttmm::plugin
