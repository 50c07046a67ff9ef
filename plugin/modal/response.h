// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/SparseCore>
#include <complex>
#include <optional>
#include <vector>

#include "modal/balanced_lu.h"
#include "modal/carried_forces.h"
#include "modal/dynamic_stiffness.h"
#include "modal/modal_damping.h"

namespace dttmm::plugin {

/// A harmonic wrench [N, N m, world] at a point [m, world] of a frame (−1: the ground, nothing moves).
struct PointWrench {
    int frame;
    Vector3 point;
    Complex6 wrench;
};

/// A node of the network that moves in its fixed directions [m, rad, world].
struct SupportMotion {
    int node;
    Complex6 motion;
};

/// What acts together.
struct Drive {
    std::vector<PointWrench> loads;
    std::vector<SupportMotion> supports;
};

/// K + iω C − ω² M of a machine with its damping, and its solutions; the lines in the pieces in which D has them.
class HarmonicSolver {
public:
    explicit HarmonicSolver(const DynamicStiffness& D) : D_(D) {}

    /// Damping beside that of the elements, of all that follows. mass_rate: force on masses per momentum [1/s]. of_modes:
    /// on the frames as D is cut; nothing: none.
    void set_damping(double mass_rate, const ModalDamping* of_modes) {
        mass_rate_ = mass_rate;
        of_modes_ = of_modes;
    }

    /// Finds damping.followed of the damping last set, for a machine that its supports hold at rest. factor() comes next.
    void follow_supports(ModalDamping& damping);

    /// Throws Error(DTTMM_ERROR_SINGULAR) at a natural frequency without damping.
    void factor(double omega);
    /// How lines and materials that depend on the frequency count.
    enum class Form {
        steady,     ///< lines by their waves, materials by their rows; s is on the imaginary axis
        exact,      ///< lines by their waves, materials by their Maxwell series
        polynomial  ///< lines by their stiffness at rest and the mass that goes with it: K + s C + s² M is all there is
    };
    /// K + s C + s² M at a complex s, 6 rows per frame, then the rigid directions, then damped modes, then, but in a steady
    /// vibration, the terms of Maxwell series: of each the deformation of its spring's other end.
    Eigen::SparseMatrix<Complex> assemble(Complex s, Form form);
    /// C of the damped modes alone, 6 rows per frame.
    Eigen::MatrixXd modal_damping() const;
    /// Rows of the rigid directions, and of the terms of Maxwell series.
    Eigen::Index rigid_rows() const;
    Eigen::Index series_rows() const;
    /// Instead of factor(): solutions are to be those of a machine whose numbers differ a little from those of `middle`,
    /// linear about that, at the frequency which it has factored. With A of this machine and y = A_middle⁻¹ r
    ///     x = y + A_middle⁻¹ (r − A y),
    /// so that half the difference of two such machines is −A⁻¹ dA A⁻¹ r + A⁻¹ dr. `middle` must live on. Throws
    /// Error(DTTMM_ERROR_ARGUMENT) where the equations are not laid out alike.
    void lean_on(const HarmonicSolver& middle);
    /// At the frequency last factored, and so for what follows.
    Response solve(const Drive& drive) const;
    /// After factor() or lean_on(), valid until the next of these.
    CarriedForces forces(Response&&) const = delete;
    CarriedForces forces(const Response& response) const { return {D_, omega_, waves_, *parts_, response}; }

private:
    using Sparse = Eigen::SparseMatrix<Complex>;

    void factor_matrix(const Sparse& matrix);
    void refuse_beyond_rows() const;
    void add_supports(const Response& response, Eigen::VectorXcd& right_hand_side) const;

    const DynamicStiffness& D_;
    double mass_rate_ = 0;
    const ModalDamping* of_modes_ = nullptr;
    double omega_ = 0;
    CarriedForces::Waves waves_;
    std::optional<ElementParts> parts_;  ///< as D is cut
    BalancedLu lu_;
    const HarmonicSolver* middle_ = nullptr;  ///< that this one leans on; null: none
    Sparse leaning_;                          ///< then the matrix of this one
};

}  // namespace dttmm::plugin
