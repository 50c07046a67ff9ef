// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "solve/elimination.h"
#include "statics/resting_joint.h"
#include "time/inside.h"
#include "time/law_rows.h"

namespace dttmm::plugin {

/// The matrix M + h² S of what is inside a network, factored, and what follows from it: how the inside answers the ports.
///
/// It stands in the frames' axes, in which it changes with the deformations only, not with the motion of the whole: it is
/// formed once per step size and kept until it converges slowly, or joints at ports or rigid directions have turned. Elastic
/// directions enter it where the step ends if all goes on, for only their forces there hang on the motion: by those of t_n,
/// k h²/m times what a hinge turns in a step would be missing across it, and k h²/m is in the thousands where it is stiff.
/// Rigid directions enter it where they are at t_n, in the middle of the three instants.
class InteriorMatrix {
public:
    /// Keeps the inside, and works in its `motion` and `motion_q`.
    explicit InteriorMatrix(Inside& inside);
    /// Room for the steps to come: nothing is allocated later.
    void make_room_for_steps();

    /// The factored matrix. Other matrices of the same frames may be copied from it for its pattern.
    Elimination& elimination() { return elimination_; }
    const Elimination& elimination() const { return elimination_; }

    /// To work in. It is stale then.
    Elimination& lend() {
        is_stale_ = true;
        return elimination_;
    }

    /// For the step to come, all frames being where they are in `at` at its end, as far as they are known. Throws
    /// Error(DTTMM_ERROR_SINGULAR); then it is stale.
    void form(const std::vector<Frame>& at);
    /// For the open step, everything where it is tried to end, under the forces there; if that is singular, where the step
    /// began. It serves for this step.
    void form_at_trial();
    /// After a step: finds out whether it serves for the next.
    void take_step();
    bool is_stale() const { return is_stale_; }
    /// Whether it was formed within the open step.
    bool is_own() const { return is_own_; }
    /// How often it was formed for the open step, or within it.
    int formed() const { return formed_; }
    /// What it has most of against the shift of a frame [kg].
    double stiffest() const { return stiffest_; }

    /// Solves in place for the correction of u and of h times the rigid forces. Corrects the result for directions with
    /// laws. psi: receives their extra forces, see LawRows.
    void solve(std::span<Vector6> change, std::span<double> q_change, std::vector<double>& psi);
    size_t law_count() const { return laws_.count(); }

    /// ∂u/∂(u of the ports) of an inner frame; of all, one after the other.
    Eigen::Map<const Eigen::Matrix<double, 6, Eigen::Dynamic>> response(size_t inner) const {
        return {&responses_[inner * 36 * as_size(inside_.ports)], 6, 6 * inside_.ports};
    }
    const std::vector<double>& responses() const { return responses_; }
    /// The same of the forces of rigid directions, times h.
    const Eigen::MatrixXd& rigid_responses() const { return rigid_responses_; }
    /// Change of the force of Inside::near_joints[near] over the step. u_from, u_to: motion of its frames over h, frame
    /// axes. q: rigid forces before; Inside::trial_q has those after.
    JointForce near_change(size_t near, const Vector6& u_from, const Vector6& u_to, const std::vector<double>& q,
                           const std::vector<double>& psi) const;
    /// −∂(wrench)/∂(pose of the ports), world: 6P × 6P row-major.
    void write_stiffness(double* stiffness) const;

private:
    struct Blocks {
        EndBlocks own, acting;
        Matrix6 between(int row, int column) const { return own.at[row][column] + acting.at[row][column]; }
    };
    struct Columns {
        Matrix6 at[2];
    };
    Blocks blocks(size_t joint, const std::vector<Frame>& at) const;
    Blocks blocks_at_trial(size_t joint) const;
    EndBlocks turning(size_t joint, const PlacedJoint& placed, const Vector6& springs, const Vector3& others,
                      const std::vector<double>& q) const;
    Matrix6 gain(size_t joint, const Vector6& deformation) const;
    EndBlocks in_frames(size_t joint, EndBlocks K) const;
    void begin();
    void add_joint(size_t joint, const Blocks& blocks);
    void form_by(const std::vector<Frame>& at);
    void find_stiffest();
    void take_factor(const std::vector<Frame>& at);
    void find_responses();
    bool rigid_directions_have_turned() const;
    double turn_at_ports() const;

    Inside& inside_;
    Elimination elimination_;
    LawRows laws_;
    std::vector<double> responses_;
    Eigen::MatrixXd rigid_responses_;
    std::vector<EndBlocks> near_blocks_;  ///< stiffness of the near joints as in the matrix, frames' axes
    std::vector<Columns> near_columns_;   ///< of their deformation by either frame, when it was formed
    double stiffest_ = 0;
    bool is_stale_ = false;  ///< it no longer serves
    int formed_ = 0;         ///< so often for the open step
    bool is_own_ = false;    ///< it was formed within the open step
};

}  // namespace dttmm::plugin
