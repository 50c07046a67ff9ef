// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/LU>
#include <algorithm>
#include <vector>

#include "time/massless_set.h"

namespace dttmm::plugin {

/// How the massless frames of a network balance at an instant: velocities where dampers act, and forces of rigid directions.
class InstantBalances {
public:
    /// Keeps the set.
    InstantBalances(const Mechanism& mechanism, const MasslessSet& set);

    /// Whether a massless frame has dampers or rigid directions: then find_instant has something to find.
    bool exist() const { return !balances_.empty(); }
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
        for (const Balance& balance : balances_) {
            balance.matrix.setZero();
            balance.stiffness.setZero();
            balance.right_hand_side.setZero();
            balance.farthest = 0;
            for (size_t k = 0; k < balance.group.frames.size(); ++k)
                balance.right_hand_side.segment<6>(as_row(6 * k)) = load(set_.frames()[balance.group.frames[k]]);
            for (size_t j : balance.group.joints) {
                const Joint& joint = mechanism.joints[j];
                const FrameView from = frames[as_size(joint.from())], to = frames[as_size(joint.to())];
                balance.farthest = std::max({balance.farthest, from.origin().norm(), to.origin().norm()});
                add_balance(mechanism, balance, j, joint.pose(from, to), acting(j), q);
            }
            solve_balance(balance, h, velocities, corrections, q);
        }
    }

private:
    /// Massless frames that rigid directions or dampers join.
    struct Balance {
        MasslessGroup group;
        // Working memory, so mutable: what is to be added to velocities, 6 per frame, and to the forces of rigid directions
        mutable Eigen::MatrixXd matrix, stiffness, directions;
        mutable Eigen::VectorXd right_hand_side, solution, scale, follow;
        mutable Eigen::FullPivLU<Eigen::MatrixXd> lu;
        mutable double farthest = 0;                ///< of its frames from the origin [m]
        mutable Eigen::MatrixXd undamped, reduced;  ///< columns: motions that no damper resists; what springs make of them
    };
    int frame_in(const Mechanism& mechanism, const Balance& balance, int frame) const;
    void add_balance(const Mechanism& mechanism, const Balance& balance, size_t joint, const JointPose& pose,
                     const Acting& acting, const std::vector<double>& q) const;
    void scale_balance(const Balance& balance, double h) const;
    void drop_dependent_rows(const Balance& balance) const;
    void add_undamped(const Balance& balance, Eigen::Index rank) const;
    void solve_balance(const Balance& balance, double h, std::vector<Twist>& velocities, std::vector<Twist>& corrections,
                       std::vector<double>& q) const;

    const MasslessSet& set_;
    std::vector<Balance> balances_;
    std::vector<int> balance_of_;  ///< of every massless frame; −1: none
    std::vector<int> begin_;       ///< its first unknown there
};

}  // namespace dttmm::plugin
