// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/LU>
#include <span>
#include <vector>

#include "mechanism/mechanism.h"
#include "solve/elimination.h"

namespace dttmm::plugin {

/// The directions of joints that have laws of their own, beside the matrix A of a network, in which they stand with a
/// constant gain D. A correction A δ₀ = r is put right for what they do otherwise:
///     z = z₀ − C ψ(z),   ψ(z) = Φ(s + z) − Φ(s) − D z,   C = h² G A⁻¹ Gᵀ,
/// z = h G δ the change of their deformations s, Φ their forces over the step; then δ = δ₀ − h A⁻¹ Gᵀ ψ. So a pass finds the
/// forces of laws as it finds linear ones, and the matrix is kept. (Woodbury's identity, for forces that are not linear.)
/// These equations take the cube of the number of rows. Where that is more than some passes over the network they are wanted
/// only once the iteration of the network, which otherwise finds the laws by itself, has been slow. Networks with more than
/// kMostRows take none.
class LawRows {
public:
    static constexpr size_t kMostRows = 100;  ///< at 3 ms a step

    /// driven: number of frames before the inner ones.
    LawRows(const Mechanism& mechanism, int driven);

    /// The columns G and gains D for a matrix that is formed with the frames where they are in `at`.
    void form(const Mechanism& mechanism, const std::vector<Frame>& at);
    /// A⁻¹ Gᵀ and C, once the matrix is factored. u, q: working memory, of all inner frames and all rigid directions.
    void find_responses(const Elimination& matrix, double step_size, std::vector<Vector6>& u, std::vector<double>& q);
    /// Puts right a correction from the frames `trial` on, of u and of the rigid directions times h. psi: takes ψ; zero, and
    /// the correction as it was, where there is no answer.
    void correct(const Mechanism& mechanism, const std::vector<Frame>& trial, std::span<Vector6> change,
                 std::span<double> q_change, std::vector<double>& psi);
    /// Adds to the force of a joint, as D has it, what ψ adds; its frames' axes.
    void add_force(size_t joint, const std::vector<double>& psi, Vector6& on_from, Vector6& on_to) const;
    size_t count() const { return rows_.size(); }
    /// is_slow: whether a step of the network has been slow.
    bool are_wanted(bool is_slow) const { return !rows_.empty() && (is_cheap_ || is_slow); }

private:
    struct Row {
        size_t joint;
        int direction;
        int frame[2];  ///< inner frame of either end; −1: it is driven
        Vector6 G[2];
        double gain;
    };
    Joint::OnPath on_path(const Mechanism& mechanism, Eigen::Index row, double z) const;
    void look(const Mechanism& mechanism, const std::vector<Frame>& trial, std::span<const Vector6> change);
    void find_lack(const Mechanism& mechanism);
    bool solve(const Mechanism& mechanism);

    std::vector<Row> rows_;
    bool is_cheap_ = false;
    std::vector<Vector6> responses_;  ///< A⁻¹ Gᵀ of a row, all inner frames, behind each other
    std::vector<double> rigid_responses_;
    size_t frames_ = 0, rigid_ = 0;
    double h_ = 0;
    Eigen::MatrixXd compliance_;
    // Working memory: s, Φ(s), z₀, z, its last change, ψ and its slope
    Eigen::VectorXd start_, base_, wanted_, z_, change_, psi_, slope_, lack_;
    Eigen::MatrixXd newton_;
    Eigen::PartialPivLU<Eigen::MatrixXd> factor_;
};

}  // namespace dttmm::plugin
