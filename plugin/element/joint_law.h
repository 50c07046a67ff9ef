// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <limits>
#include <memory>
#include <optional>

#include "core/driven_ends.h"
#include "law/law.h"

namespace dttmm::plugin {

/// How the wanted instant enters the force law of a joint, whatever the scheme:
///     elastic force  weight · K d + (known),   damping force  c (C d + D),   d: the unknown deformation
struct StepCoefficients {
    double weight =
        1;         ///< of the elastic force at the unknown instant; 1 for schemes that stand there, β for the centred one
    double C = 0;  ///< [1/s] of x' = C x + D
};

/// What an elastic line makes of the motion d of its `to` end, in the axes of its `from` end, and of the rotation θ between
/// them. Its strains are
///     s = d − half θ × d + e_x (sway_y d_y² + sway_z d_z² − bow (θ_y² + θ_z²) + half/2 θ_x (θ_y d_y + θ_z d_z))
/// to second order: the motion in the axes half way between its ends, and how far a line that bends and shears draws its
/// ends nearer. The last term is of third order: a pull acts along the mean t of the x axes of both ends, which twist leaves
/// where it is. In terms of θ, t_y = (θ_z + θ_x θ_y/2)/2 and t_z = (θ_x θ_z/2 − θ_y)/2. Without it a pull on a bent line
/// that twists presses sideways, and slender hanging lines of long segments lose their stiffness against torsion. All are
/// zero where there is no line.
template <class Real>
struct LineStrainsOf {
    Real half{}, bow{}, sway_y{}, sway_z{};  ///< [1, m, 1/m, 1/m]
    bool operator==(const LineStrainsOf&) const = default;
};
using LineStrains = LineStrainsOf<double>;
/// The second derivative of f·s by x = [d; θ].
inline Matrix6 curvature_of(const LineStrains& line, const Vector3& f, const Vector6& x) {
    Matrix6 C = Matrix6::Zero();
    C.diagonal() << 0, 2 * line.sway_y, 2 * line.sway_z, 0, -2 * line.bow, -2 * line.bow;
    C *= f.x();
    C.bottomLeftCorner<3, 3>() = line.half * skew(f);
    C.topRightCorner<3, 3>() = -C.bottomLeftCorner<3, 3>();
    const double twisted = 0.5 * line.half * f.x();
    const auto add = [&](int i, int j, double number) {
        C(i, j) += twisted * number;
        C(j, i) += twisted * number;
    };
    for (int across : {1, 2}) {
        add(3, 3 + across, x(across));
        add(3, across, x(3 + across));
        add(3 + across, across, x(3));
    }
    return C;
}

/// The line between two points along which a joint acts.
struct Axial {
    double length;   ///< of the line at the start [m]
    double natural;  ///< at which the joint is undeformed [m]
    bool operator==(const Axial&) const = default;
};

/// The law of a massless joint in its six directions, each a spring with a damper beside it, rigid, or free. Its deformation
/// d (6×1: m, rad) is the motion of the `to` end relative to the `from` end in the axes of the joint, which go with the
/// `from` end; its force f (6×1: N, N m) is positive in tension: it pulls the `to` end against d and the `from` end along d.
/// In the letters of the state vector f = [−q; m]. A direction may have a law of its own in place of the linear spring: its
/// stiffness is then the law's tangent at rest, by which all that is linear goes. Of an elastic line the strains s are in
/// place of d, and f acts by their gradient. A joint along a line has x
/// only: its deformation is the length of the line, which may turn as it likes, less the natural one.
struct JointLaw {
    Vector6 stiffness = Vector6::Zero();                          ///< [N/m, N m/rad]
    Vector6 damping = Vector6::Zero();                            ///< [N s/m, N m s/rad]
    double loss_factor = 0;                                       ///< of the stiffness in vibration
    Directions rigid;                                             ///< d = 0 there; stiffness and damping are not looked at
    std::array<std::shared_ptr<const Law>, 6> laws;               ///< of directions that are not linear
    LineStrains line;                                             ///< of the elastic line that it stands for
    std::optional<Axial> axial;                                   ///< it acts along a line, which its x goes with
    double most_shift = std::numeric_limits<double>::infinity();  ///< |d| up to which it holds [m]
    double most_turn = std::numeric_limits<double>::infinity();   ///< |θ| up to which it holds [rad]

    /// The laws of directions are equal where they are one object.
    bool operator==(const JointLaw&) const = default;
    /// Gives a direction the law in place of a linear spring.
    void set(int direction, std::shared_ptr<const Law> law);
    bool has_laws() const;
    /// A deformation as share of what the law holds up to.
    double used(const Vector6& deformation) const;
    /// Numbers that the laws before a direction remember; of all for direction 6.
    size_t memory_before(int direction) const;
    /// The law of a direction, linear or not, at an instant; memory: of all laws, NULL where none has one.
    LawOnPath at(int direction, double deformation, const double* memory) const {
        return along(direction, {deformation, deformation, 0, memory});
    }
    /// The same along a path; its memories are those of all laws.
    LawOnPath along(int direction, LawPath path) const;

    /// Directions with a stiffness or damping that is not rigid.
    Directions resisting() const;
    /// These, and those with a law.
    Directions elastic() const;
    /// Those in which the joint transmits a force.
    Directions carried() const { return elastic() | rigid; }

    /// z_O = U z_I at a time step: 13×13, axes of the joint. `known` (6×1) is the part of f that does not depend on the
    /// unknown d. In a free direction the compliance, and with it the entry of U, is infinite; in a rigid one it is zero.
    Matrix13 transfer(const StepCoefficients& step, const Vector6& known) const;
};

}  // namespace dttmm::plugin
