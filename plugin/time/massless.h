// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/LU>
#include <array>
#include <span>
#include <vector>

#include "core/index.h"
#include "mechanism/mechanism.h"

namespace dttmm::plugin {

/// How the massless frames of a network balance. Forces weighted over three instants, as masses feel them, leave a massless
/// direction free to ring, for w₊ z² + w₀ z + w₋ = (z + 1)²/4 has a double root at −1. Therefore
///   - what rigid directions hold balances over the step, which gives their forces;
///   - what dampers act on balances half way through every step, if the scheme has no numerical damping: its weights are
///     (z + 1)(z + 1)/4 and (z + 1)(z − 1)/2h, and so one factor z + 1 goes;
///   - the rest balances at the end of every step.
/// Where nothing is rigid and every joint has the same ratio τ of damping to stiffness, as in a beam, the elastic forces ψ
/// at the end of the step follow the load alone, ψ + τ ψ' = load, and nothing is left to ring there either.
///
/// The three are orthogonal parts of the space of unit motions of the frames that rigid directions join, in their own axes.
class MasslessFrames {
public:
    /// massless: translation and rotation of every inner frame.
    MasslessFrames(const Mechanism& mechanism, const std::vector<std::array<bool, 2>>& massless);

    /// Inner frames with a massless half, in the order of every list below.
    const std::vector<size_t>& frames() const { return frames_; }
    /// Of an inner frame; −1: it has none.
    int index_of(size_t frame) const { return index_[frame]; }
    bool is_massless(size_t frame, int half) const {
        return index_[frame] >= 0 && massless_[as_size(index_[frame])][as_size(half)];
    }
    /// Whether the forces of a joint are wanted at the end of the step; those of its damper half way.
    bool is_settling(size_t joint) const { return settling_[joint]; }
    bool is_half_way(size_t joint) const { return half_way_[joint]; }
    /// Of a joint, its first rigid direction among those of all.
    size_t rigid_begin(size_t joint) const { return rigid_begin_[joint]; }
    /// τ [s]
    double relaxation(size_t i) const { return clusters_[as_size(cluster_of_[i])].relaxation; }

    /// Finds the parts of the space of motions where the frames are at t_n.
    void look(const Mechanism& mechanism);

    /// Forces on a frame in its own axes that must vanish: over the step, at its end, half way through it.
    struct Residual {
        Vector6 step, end, half_way;
    };
    /// What must vanish of them, into `step`, in massless halves; the rest of `step` stays.
    void combine(std::span<Residual> residuals) const;

    /// Whether a massless frame has dampers or rigid directions: then find_instant has something to find.
    bool has_balances() const { return has_balances_; }
    /// A joint at an instant: its deformation [d; θ], the rate of that [d; relative turn] as known before, and what it does
    /// besides damping that rate, [force; moment] on the `from` end; joint axes.
    struct Acting {
        Vector6 deformation, rate, force;
    };
    /// Finds for the instant at which the joints act as acting(j) says and the frames are `frames`: velocities of the
    /// massless halves, where dampers balance what else acts there, and forces of the rigid directions on them. Directions
    /// that no damper holds, or one that is 1e-4 of the strongest, follow as springs let them.
    /// load(i): on an inner frame at its origin, world. h: the step [s], 0 where there is none yet.
    /// velocities: of the inner frames, and corrections: what is added to them; q: forces of all rigid directions, in the
    /// joints' order. Both as they are but for what they lack: what no damper and no rigid direction holds keeps its
    /// velocity, and forces that a massless frame only hands on between what has mass stay as they are.
    /// The same finds accelerations, and rates of the forces of rigid directions, of rates of rates, forces and loads.
    template <class Acts, class Load>
    void find_instant(const Mechanism& mechanism, double h, const std::vector<Frame>& frames, const Acts& acting,
                      const Load& load, std::vector<Twist>& velocities, std::vector<Twist>& corrections,
                      std::vector<double>& q) const {
        for (const Cluster& cluster : balances_.clusters) {
            if (!cluster.is_balanced) continue;
            cluster.matrix.setZero();
            cluster.stiffness.setZero();
            cluster.right_hand_side.setZero();
            for (size_t k = 0; k < cluster.frames.size(); ++k)
                cluster.right_hand_side.segment<6>(as_row(6 * k)) = load(frames_[cluster.frames[k]]);
            for (size_t j : cluster.joints) {
                const Joint& joint = mechanism.joints[j];
                const FrameView from = frames[as_size(joint.from())], to = frames[as_size(joint.to())];
                add_balance(mechanism, cluster, j, joint.pose(from, to), acting(j), q);
            }
            solve_balance(cluster, h, velocities, corrections, q);
        }
    }

private:
    /// A unit force on the frames of a cluster.
    struct Row {
        size_t joint;
        int direction;
        size_t index;  ///< among the rigid directions of all joints; of damped directions unused
    };
    /// Massless frames that rigid directions join.
    struct Cluster {
        std::vector<size_t> frames;  ///< indices into frames_
        std::vector<size_t> joints;  ///< of its frames
        std::vector<Row> rigid, damped;
        bool is_balanced = false;  ///< has dampers or rigid directions
        double relaxation = 0;
        Eigen::MatrixXd basis;         ///< orthonormal: what is rigid, what is damped
        int rigid_rank = 0, rank = 0;  ///< of the former, of both
        bool is_rigid = false;         ///< altogether: nothing is left for another balance, wherever it goes
        // Working memory of combine() and find_instant(), so mutable. The latter finds what is to be added to velocities, 6
        // per frame, and to the forces of rigid directions.
        mutable Eigen::VectorXd end, step, half_way;
        mutable Eigen::MatrixXd matrix, stiffness, directions;
        mutable Eigen::VectorXd right_hand_side, solution, scale, follow;
        mutable Eigen::FullPivLU<Eigen::MatrixXd> lu;
        mutable Eigen::MatrixXd undamped, reduced;  ///< columns: motions that no damper resists; what springs make of them
    };
    int frame_in(const Mechanism& mechanism, const Cluster& cluster, int frame) const;
    void add_balance(const Mechanism& mechanism, const Cluster& cluster, size_t joint, const JointPose& pose,
                     const Acting& acting, const std::vector<double>& q) const;
    void scale_balance(const Cluster& cluster, double h) const;
    void drop_dependent_rows(const Cluster& cluster) const;
    void add_undamped(const Cluster& cluster, Eigen::Index rank) const;
    void solve_balance(const Cluster& cluster, double h, std::vector<Twist>& velocities, std::vector<Twist>& corrections,
                       std::vector<double>& q) const;
    /// Of a frame of the mechanism; −1: it is driven, or has none.
    int index_of(const Mechanism& mechanism, int frame) const {
        const int inner = frame - mechanism.assembly.driven_count;
        return inner < 0 ? -1 : index_[as_size(inner)];
    }
    /// Massless frames that joints of a kind join; a cluster of every massless frame, and its first unknown there.
    struct Grouping {
        std::vector<Cluster> clusters;
        std::vector<int> cluster_of, begin;
    };
    template <class Joins>
    Grouping group(const Mechanism& mechanism, const Joins& joins) const;
    std::vector<std::vector<size_t>> find_joints(const Mechanism& mechanism, const Grouping& grouping) const;
    void make_balances(const Mechanism& mechanism);
    void find_rows(const Mechanism& mechanism, const std::vector<size_t>& joints, Cluster& cluster) const;
    void add_to_basis(const Mechanism& mechanism, Cluster& cluster, const Row& row, bool is_rigid) const;

    std::vector<size_t> frames_;
    std::vector<int> index_;
    std::vector<std::array<bool, 2>> massless_;
    std::vector<int> cluster_of_;  ///< of every massless frame
    std::vector<int> begin_;       ///< its first unknown among those of its cluster, 6 each
    std::vector<Cluster> clusters_;
    std::vector<bool> settling_, half_way_;
    std::vector<size_t> rigid_begin_;  ///< of every joint, its first rigid direction among those of all
    Grouping balances_;                ///< joined by rigid directions or dampers
    bool has_balances_ = false;
};

}  // namespace dttmm::plugin
