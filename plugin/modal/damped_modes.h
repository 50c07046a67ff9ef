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

    /// Pieces of lines whose own frequencies lie so far above the bound. Measured on the examples with beams: candidates are
    /// up to 1.7 % from the exact mode with 2, 0.6 % with 4, 0.13 % with 8, for half as many unknowns more each time.
    static constexpr double kFiner = 2;

    /// D is cut for kFiner times the bound or finer, and as damping of modes wants it. below: largest |s| [rad/s]. Throws
    /// Error(DTTMM_ERROR_MODEL) for too many unknowns, Error(DTTMM_ERROR_NUMERIC) where the eigenvalues do not converge.
    DampedModes(const DynamicStiffness& D, HarmonicSolver& solver, double below);

    const std::vector<DampedMode>& modes() const { return modes_; }
    /// Whether Newton's method left every mode distinct and near where the count had it.
    bool is_proved() const { return is_proved_; }
    /// Whether modes are left out: those within 2 % of −1/η, η the stiffness damping of a line, of which there are
    /// infinitely many; and those without vibration that lose most of their energy in Maxwell series.
    bool has_left_out() const { return has_left_out_; }

private:
    using Matrix = Eigen::MatrixXd;

    Matrix free_directions(const Matrix& K) const;
    bool is_new_rigid(Eigen::VectorXcd& x) const;
    void deflate(Complex s, Eigen::VectorXcd& x) const;
    bool piles_up(Complex s) const;
    double lost_inside(const Eigen::VectorXcd& z) const;
    bool has_loss_factor() const;
    template <class Scalar>
    void find_all(double below);
    void take(Complex s, Eigen::VectorXcd x);
    void improve(DampedMode& mode, Eigen::VectorXcd& x);

    const DynamicStiffness& D_;
    HarmonicSolver& solver_;
    std::vector<DampedMode> modes_;
    std::vector<std::pair<Eigen::VectorXcd, Eigen::VectorXcd>> found_;  ///< of each the whole vector x, and A' x
    bool is_proved_ = true, has_left_out_ = false;
};

}  // namespace dttmm::plugin
