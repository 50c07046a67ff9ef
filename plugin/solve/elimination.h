// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/index.h"
#include "core/rounding.h"
#include "core/types.h"
#include "solve/elimination_order.h"
#include "solve/open_rows.h"
#include "solve/pivot_block.h"

namespace dttmm::plugin {

/// The dynamic stiffness of the frames inside a network and its factor, in blocks:
///     K u + Jᵀ q = r,   J u = g         u: 6 per frame, symmetric K;  J: the equations of rigid directions, q: their forces
/// Frames are eliminated from the tips of the tree inwards, those that rigid directions tie to what is known last, each
/// together with the rigid directions of its joints not yet eliminated, by full-pivot elimination of its own block:
/// f = S e + P in Riccati's form, f the force and e the motion that the frames already eliminated hand on. Loops inside the
/// network fill in blocks between the frames that close them. Rigid directions that hold a frame where others hold it say
/// something about the frames behind it: they are passed on to the next. Cost per factor and per solution linear in the
/// number of frames of a tree.
/// Source: Gu, Rui et al. (2017), Riccati transfer matrix method for linear tree multibody systems, J. Appl. Mech. 84.
/// Source of passing on: Duff and Reid (1983), multifrontal solution, ACM Trans. Math. Software 9, 302–325.
class Elimination {
public:
    /// Fixes order and storage; nothing is allocated later. Copies share the order. least_lever: a rotational stiffness that
    /// a lever of this length [m] would make counts as none.
    Elimination(int frame_count, const std::vector<Link>& links, double least_lever = kRoundingOfSums);

    void set_zero();
    void add_diagonal(int frame, const Matrix6& block) { diagonal_[as_size(frame)] += block; }
    /// Of forces that act already: no measure of what is large and small there.
    void add_acting(int frame, const Matrix6& block) {
        add_diagonal(frame, block);
        acting_[as_size(frame)] += block.diagonal();
    }
    /// As added so far; before factor().
    const Matrix6& diagonal(int frame) const { return diagonal_[as_size(frame)]; }
    /// Block (from, to) of the frames of a link; its transpose is understood.
    void add_coupling(int link, const Matrix6& block);
    /// Row of a link's rigid direction number i: its derivatives by the motions of its frames.
    void set_rigid(int link, int i, const Vector6& by_from, const Vector6& by_to);

    /// Derivatives as last set, by the motion of its `from` (0) or `to` (1) frame.
    const Vector6& rigid(int link, int i, int end) const { return rows_[as_size(rigid_begin(link) + i)].by[end]; }

    /// What makes a system singular: an unknown of a frame (direction 0 … 5), or the i-th rigid direction of a link.
    struct Fault {
        int frame = -1, direction = -1;
        int link = -1, rigid = -1;
        bool too_many = false;  ///< rigid directions meet here, kMostRows at most can
    };
    /// Nothing if all is well. The factor takes the place of the blocks added: for another one set_zero() comes first.
    std::optional<Fault> factor() { return factor(std::nullopt); }
    /// Counts negative eigenvalues besides, K of any sign. A pivot is then at fault whose smallest eigenvalue is not more
    /// than `smallest` of its largest.
    std::optional<Fault> factor_counting(double smallest) { return factor(smallest); }
    /// Eigenvalues of K below 0 on the motions that the rigid directions leave: the sum over the pivots' blocks
    /// (Haynsworth's inertia additivity) less one per rigid direction, which has one of its own.
    int negatives() const { return negatives_ - rigid_count(); }

    /// Solves in place: r → u (6 per frame), g → q (in the order of the links' rigid directions).
    void solve(std::span<Vector6> r, std::span<double> g) const;

    int rigid_begin(int link) const { return order_->links()[as_size(link)].first_row; }
    int rigid_count() const { return as_int(rows_.size()); }

    /// Rigid directions to look at in one block at most.
    static constexpr int kMostRows = OpenRows::kMost;

private:
    static constexpr int kLargestBlock = OpenRows::kLargestBlock;
    using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kLargestBlock, kLargestBlock>;
    using Rows = OpenRows::ByMotion;
    using Column = OpenRows::Column;

    using Pivot = EliminationOrder::Pivot;
    struct General {
        Block inverse;
        std::vector<Rows> gains;  ///< of each neighbour
        std::vector<int> kept;    ///< rows of J eliminated here, below the frame in the block
    };
    /// What a pivot passes on to the next: rows by the motion of its neighbours, and their gains, one column each.
    struct Passed {
        OpenRows open;
        Block gain;
    };

    std::optional<Fault> factor(std::optional<double> smallest);
    Vector6 motion_scale(const Pivot& pivot) const;
    Vector6 scale_with_rows(const Pivot& pivot) const;
    template <class Square>
    bool decompose(const Pivot& pivot, const Square& block, std::span<const int> rows, std::optional<double> smallest,
                   PivotBlock<Square>& result, Fault& fault);
    bool factor_elastic(const Pivot& pivot, Fault& fault);
    void fill_in(const Pivot& pivot, int coupling, size_t i, const Matrix6& update);
    bool factor_general(const Pivot& pivot, Fault& fault);
    bool decompose_with_rows(const Pivot& pivot, const Vector6& motions, const Column& row_scale,
                             std::optional<double> smallest, Fault& fault);
    void pass_rows_on(const Pivot& pivot, const Vector6& motions);
    void update_neighbours(const Pivot& pivot);
    /// Of a pivot that is not plain, on the way in and on the way back.
    [[gnu::noinline]] void eliminate(const Pivot& pivot, std::span<Vector6> r, std::span<double> g) const;
    [[gnu::noinline]] void substitute(const Pivot& pivot, std::span<Vector6> r, std::span<double> g) const;
    void eliminate_elastic(const Pivot& pivot, std::span<Vector6> r) const;
    void substitute_elastic(const Pivot& pivot, std::span<Vector6> r) const;

    struct Derivatives {
        Vector6 by[2];
    };

    std::shared_ptr<const EliminationOrder> order_;
    double least_turning_;  ///< share of the translations' largest below which a rotation's entry is rounding [m²]
    bool is_factored_ = false;
    // As added, then as far as the elimination has come; of elastic pivots in the end their inverse, and that times the
    // couplings
    std::vector<Matrix6> diagonal_, couplings_;
    std::vector<Vector6> acting_;    ///< part of the diagonals by add_acting
    std::vector<Vector6> own_size_;  ///< entries of the diagonals as added, less those
    std::vector<Derivatives> rows_;  ///< of the rigid directions
    std::vector<General> general_;
    std::vector<Passed> passed_;
    std::optional<double> smallest_;  ///< of the eigenvalues, where they are counted
    int negatives_ = 0;
    // Of the pivot at hand
    std::vector<Matrix6> met_;  ///< couplings with its neighbours before their gains take their place
    PivotBlock<Block> block_;
    OpenRows open_;
    std::vector<int> choice_, rest_;
    Block passed_columns_;
    mutable std::vector<Column> columns_;  ///< working memory of solve(), so mutable
};

}  // namespace dttmm::plugin
