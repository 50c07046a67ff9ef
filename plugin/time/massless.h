// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <span>
#include <vector>

#include "time/massless_set.h"

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
/// A rotation counts there as what it moves at the reach of its frame, so that no unit of length decides.
class MasslessFrames : public MasslessSet {
public:
    /// massless: translation and rotation of every inner frame.
    MasslessFrames(const Mechanism& mechanism, const std::vector<std::array<bool, 2>>& massless);

    /// Whether the forces of a joint are wanted at the end of the step; those of its damper half way.
    bool is_settling(size_t joint) const { return settling_[joint]; }
    bool is_half_way(size_t joint) const { return half_way_[joint]; }
    /// Whether a frame, and those that rigid directions join to it, balance at the end of the step altogether.
    bool balances_at_end(size_t i) const { return parts_[as_size(part_of_[i])].rank == 0; }
    /// τ [s]
    double relaxation(size_t i) const { return parts_[as_size(part_of_[i])].group.relaxation; }

    /// Before look(). reach: of every inner frame [m].
    void set_reach(std::span<const double> reach);
    /// Finds the parts of the space of motions where the frames are at t_n.
    void look(const Mechanism& mechanism);

    /// Forces on a frame in its own axes that must vanish: over the step, at its end, half way through it.
    struct Residual {
        Vector6 step, end, half_way;
    };
    /// What must vanish of them, into `step`, in massless halves; the rest of `step` stays.
    void combine(std::span<Residual> residuals) const;

private:
    /// Massless frames that rigid directions join.
    struct Part {
        MasslessGroup group;
        Eigen::VectorXd unit;                         ///< of its motions: 1 of translations, 1/reach of rotations [1/m]
        Eigen::MatrixXd basis;                        ///< orthonormal: what is rigid, what is damped
        int rigid_rank = 0, rank = 0;                 ///< of the former, of both
        bool is_rigid = false;                        ///< altogether: nothing is left for another balance, wherever it goes
        mutable Eigen::VectorXd end, step, half_way;  ///< working memory of combine(), so mutable
    };
    void add_to_basis(const Mechanism& mechanism, Part& part, const MasslessRow& row, bool is_rigid) const;

    std::vector<Part> parts_;
    std::vector<int> part_of_;  ///< of every massless frame
    std::vector<int> begin_;    ///< its first unknown there
    std::vector<bool> settling_, half_way_;
};

}  // namespace dttmm::plugin
