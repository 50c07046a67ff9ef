// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "modal/response.h"

namespace dttmm::plugin {

/// A solution x e^(st) of (K + s C + s² M) x = 0.
struct DampedMode {
    Complex s;                     ///< [1/s]; its imaginary part is zero or positive
    double correction = 0;         ///< what another step of Newton's method changes on the exact matrix, as share of |s|
    std::vector<Complex6> motion;  ///< of all frames; the largest displacement, or rotation where there is none, is 1
};

/// All modes of a machine with its damping whose |s| is at most a bound, by their |s|. Equations without mass and rigid
/// directions are taken out, and the rest becomes one matrix whose eigenvalues Eigen finds all: with lines by their
/// stiffness at rest and its mass in short pieces, without lines exactly. Newton's method then improves each on the exact
/// matrix.
class DampedModes {
public:
    static constexpr int kMostUnknowns = 900;  ///< of the dense matrix of twice as many rows: 15 s

    struct Count {
        size_t modes;
        bool is_proved, has_left_out;
    };

    /// Cuts the lines. below: largest |s| [rad/s]. Throws Error(DTTMM_ERROR_MODEL) for too many unknowns,
    /// Error(DTTMM_ERROR_NUMERIC) where the eigenvalues do not converge.
    DampedModes(DynamicStiffness& D, HarmonicSolver& solver, double below);

    const std::vector<DampedMode>& modes() const { return modes_; }
    /// Whether Newton's method left every mode distinct and near where the count had it.
    bool is_proved() const { return is_proved_; }
    /// Whether modes are left out that lie within 2 % of −1/η, η the stiffness damping of a line: there are infinitely many.
    bool has_left_out() const { return piles_up_; }

private:
    using Matrix = Eigen::MatrixXd;

    Matrix free_directions(const Matrix& K) const;
    bool is_new_rigid(Eigen::VectorXcd& x) const;
    void deflate(Complex s, Eigen::VectorXcd& x) const;
    bool piles_up(Complex s) const;
    bool has_loss_factor() const;
    template <class Scalar>
    void find_all(double below);
    void improve(DampedMode& mode, Eigen::VectorXcd& x);

    DynamicStiffness& D_;
    HarmonicSolver& solver_;
    std::vector<DampedMode> modes_;
    std::vector<std::pair<Eigen::VectorXcd, Eigen::VectorXcd>> found_;  ///< of each the whole vector x, and A' x
    bool is_proved_ = true, piles_up_ = false;
};

}  // namespace dttmm::plugin
