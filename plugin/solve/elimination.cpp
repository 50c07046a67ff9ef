// SPDX-License-Identifier: BSD-3-Clause
#include "solve/elimination.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/index.h"
#include "core/rounding.h"
#include "core/six.h"

namespace dttmm::plugin {

namespace {

/// Indices of rows independent of each other, the most independent first; a row whose rest is below `threshold` is left out.
template <class Matrix>
void choose_independent(Matrix rows, double threshold, std::vector<int>& choice, std::vector<int>& rest) {
    choice.clear();
    rest.clear();
    for (int k = 0; k < rows.rows(); ++k) rest.push_back(k);
    while (!rest.empty()) {
        const auto longest = std::max_element(rest.begin(), rest.end(),
                                              [&](int a, int b) { return rows.row(a).norm() < rows.row(b).norm(); });
        const int next = *longest;
        const double length = rows.row(next).norm();
        if (!(length > threshold)) return;
        choice.push_back(next);
        rest.erase(longest);
        rows.row(next) /= length;
        for (int k : rest) rows.row(k) -= rows.row(k).dot(rows.row(next)) * rows.row(next);
    }
}

/// Units of a pivot's motions. own: what stood on the diagonal before anything was eliminated; size: what stands there now.
/// What is left of a motion that nothing holds is small beside that. A direction without anything of its own is measured by
/// what it got from others, or, if that is next to nothing, by the other directions of its kind; and if these have no more
/// than rounding (a node that rigid directions alone keep from turning), by those of the other kind on a lever of a metre.
Vector6 scale_of(Vector6 own, Vector6 size, double least_turning) {
    constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
    for (Vector6* entries : {&own, &size}) {
        const double least = least_turning * size.head<3>().maxCoeff();
        for (double& entry : entries->tail<3>())
            if (entry <= least) entry = 0;
    }
    const auto largest = [](const Vector6& of, Eigen::Index half) { return of.segment<3>(half).maxCoeff(); };
    Vector6 scale;
    for (Eigen::Index i = 0; i < 6; ++i) {
        const Eigen::Index half = 3 * (i / 3);
        const double own_kind = largest(own, half), kind = largest(size, half), other = largest(size, 3 - half);
        const bool is_rounding = own_kind == 0 && kind <= kEpsilon * other;
        const bool has_own = own(i) > kRoundingOfSums * own_kind;
        const double measure = is_rounding ? other : !has_own && size(i) < kNextToNothing * kind ? kind : size(i);
        scale(i) = measure > 0 ? 1 / std::sqrt(measure) : 1;
    }
    return scale;
}

/// What an unknown of a pivot's block is: a direction of its frame, or one of the rows of J behind these.
Elimination::Fault fault_at(const EliminationOrder& order, const EliminationOrder::Pivot& pivot, std::span<const int> rows,
                            int unknown) {
    Elimination::Fault fault;
    fault.frame = pivot.frame;
    if (unknown < 6) {
        fault.direction = unknown;
    } else {
        const EliminationOrder::Row& row = order.rows()[as_size(rows[as_size(unknown - 6)])];
        fault.link = row.link;
        fault.rigid = row.index;
    }
    return fault;
}

}  // namespace

Elimination::Elimination(int frame_count, const std::vector<Link>& links, double least_lever)
    : order_(std::make_shared<const EliminationOrder>(frame_count, links)), least_turning_(least_lever * least_lever) {
    const auto n = as_size(frame_count);
    diagonal_.assign(n, Matrix6::Zero());
    acting_.assign(n, Vector6::Zero());
    own_size_.assign(n, Vector6::Zero());
    couplings_.assign(order_->couplings().size(), Matrix6::Zero());
    rows_.resize(order_->rows().size());
    const auto reserve = [](OpenRows& open, size_t frames) {
        open.rows.reserve(kMostRows);
        open.by.resize(frames);
    };
    for (const Pivot& pivot : order_->pivots())
        if (pivot.is_elastic && met_.size() < pivot.neighbours.size()) met_.resize(pivot.neighbours.size());
    size_t most_neighbours = 0;
    for (size_t neighbours : order_->general()) {
        General& general = general_.emplace_back();
        general.gains.resize(neighbours);
        general.kept.reserve(kMostRows);
        most_neighbours = std::max(most_neighbours, neighbours);
    }
    for (size_t neighbours : order_->passing()) reserve(passed_.emplace_back().open, neighbours);
    reserve(open_, 1 + most_neighbours);
    columns_.resize(general_.size());
}

void Elimination::set_zero() {
    is_factored_ = false;
    for (Matrix6& block : diagonal_) block.setZero();
    for (Vector6& acting : acting_) acting.setZero();
    for (Matrix6& coupling : couplings_) coupling.setZero();
}

void Elimination::add_coupling(int link, const Matrix6& block) {
    const EliminationOrder::OfLink& own = order_->links()[as_size(link)];
    if (own.coupling < 0) return;
    Matrix6& into = couplings_[as_size(own.coupling)];
    if (own.is_transposed)
        into += block.transpose();
    else
        into += block;
}

void Elimination::set_rigid(int link, int i, const Vector6& by_from, const Vector6& by_to) {
    rows_[as_size(rigid_begin(link) + i)] = {{by_from, by_to}};
}

// ---- The factor ---------------------------------------------------------------------------------------------------------

std::optional<Elimination::Fault> Elimination::factor(std::optional<double> smallest) {
    assert(!is_factored_);
    is_factored_ = true;
    smallest_ = smallest;
    negatives_ = 0;
    for (size_t f = 0; f < diagonal_.size(); ++f) own_size_[f] = (diagonal_[f].diagonal() - acting_[f]).cwiseAbs();
    Fault fault;
    for (const Pivot& pivot : order_->pivots())
        if (!(pivot.is_elastic ? factor_elastic(pivot, fault) : factor_general(pivot, fault))) return fault;
    return std::nullopt;
}

Vector6 Elimination::motion_scale(const Pivot& pivot) const {
    const auto f = as_size(pivot.frame);
    return scale_of(own_size_[f], own_size_[f].cwiseMax((diagonal_[f].diagonal() - acting_[f]).cwiseAbs()), least_turning_);
}

/// Beside rows a rotation with next to nothing of its own must drown neither the translation in them, which see both, nor
/// them in what acts already.
Vector6 Elimination::scale_with_rows(const Pivot& pivot) const {
    constexpr double kMost = 1 / kNextToNothing;  // ratio of scaled entries in a row
    Vector6 scale = motion_scale(pivot);
    const Vector6& acting = acting_[as_size(pivot.frame)];
    for (Eigen::Index i = 0; i < 6; ++i)
        if (std::abs(acting(i)) * scale(i) * scale(i) > 1) scale(i) = 1 / std::sqrt(std::abs(acting(i)));
    for (Eigen::Index k = 0; k < open_.by[0].rows(); ++k) {
        const Eigen::Matrix<double, 1, 6> row = open_.by[0].row(k);
        if (row.head<3>().norm() <= kNextToNothing * row.tail<3>().norm()) continue;  // of rotation alone
        const double translation = row.transpose().cwiseProduct(scale).head<3>().cwiseAbs().maxCoeff();
        for (Eigen::Index i = 3; i < 6; ++i)
            if (std::abs(row(i)) * scale(i) > kMost * translation) scale(i) = kMost * translation / std::abs(row(i));
    }
    return scale;
}

/// Full-pivot elimination of a pivot's block in the units of result.scale; rows: those of J in it. smallest: of its
/// eigenvalues, where they are counted, as share of the largest; less is at fault.
template <class Square>
bool Elimination::decompose(const Pivot& pivot, const Square& block, std::span<const int> rows,
                            std::optional<double> smallest, PivotBlock<Square>& result, Fault& fault) {
    const std::optional<int> weakest = result.decompose(block, smallest);
    if (!weakest) {
        negatives_ += result.negatives();
        return true;
    }
    fault = fault_at(*order_, pivot, rows, *weakest);
    return false;
}

bool Elimination::factor_elastic(const Pivot& pivot, Fault& fault) {
    Matrix6& own = diagonal_[as_size(pivot.frame)];
    PivotBlock<Matrix6> block;
    block.scale = motion_scale(pivot);
    if (!decompose(pivot, own, {}, smallest_, block, fault)) return false;
    own = block.inverse();
    for (size_t i = 0; i < pivot.neighbours.size(); ++i) {
        const auto [neighbour, index] = pivot.neighbours[i];
        Matrix6& coupling = couplings_[as_size(index)];
        met_[i] = coupling;
        coupling = block.solve(met_[i]);
        diagonal_[as_size(neighbour)] -= met_[i].transpose() * coupling;
    }
    size_t fill = 0;
    for (size_t i = 0; i < pivot.neighbours.size(); ++i)
        for (size_t j = i + 1; j < pivot.neighbours.size(); ++j)
            fill_in(pivot, pivot.fills[fill++], i, met_[i].transpose() * couplings_[as_size(pivot.neighbours[j].coupling)]);
    return true;
}

/// Takes an update off the coupling of neighbour number i with another one.
void Elimination::fill_in(const Pivot& pivot, int coupling, size_t i, const Matrix6& update) {
    Matrix6& block = couplings_[as_size(coupling)];
    if (order_->couplings()[as_size(coupling)].row == pivot.neighbours[i].frame)
        block -= update;
    else
        block -= update.transpose();
}

/// Its own block with rows that are independent of each other by this frame's motion; all of them where there is no other
/// frame. Few to begin with; all that can be told apart if that leaves the frame free.
bool Elimination::factor_general(const Pivot& pivot, Fault& fault) {
    const auto derivatives = [&](size_t row, int end) -> const Vector6& { return rows_[row].by[end]; };
    const auto passed_by = [&](const Pivot& before) -> const OpenRows& { return passed_[as_size(before.passed)].open; };
    if (!open_.gather(*order_, pivot, derivatives, passed_by)) {
        const EliminationOrder::Row& row = order_->rows()[as_size(open_.rows.back())];
        fault = {pivot.frame, -1, row.link, row.index, true};
        return false;
    }
    const Vector6 motions = scale_with_rows(pivot);
    const auto count = as_row(open_.rows.size());
    // Of a row by its size when it was met: what is left of one that is held already is small beside it
    Column row_scale(count);
    for (Eigen::Index k = 0; k < count; ++k) {
        const double largest =
            std::max(open_.by[0].row(k).transpose().cwiseProduct(motions).cwiseAbs().maxCoeff(), open_.among_size(k));
        row_scale(k) = largest > 0 ? 1 / largest : 1;
    }
    choice_.clear();
    rest_.clear();
    if (pivot.passed >= 0) {
        Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMostRows, kLargestBlock> rows(count,
                                                                                                              6 + count);
        rows.leftCols<6>() = row_scale.asDiagonal() * open_.by[0] * motions.asDiagonal();
        rows.rightCols(count) = row_scale.asDiagonal() * open_.among * row_scale.asDiagonal();
        choose_independent(rows, kSmallTurn, choice_, rest_);
        const auto clearly = smallest_ ? std::optional(std::max(*smallest_, kNextToNothing)) : std::nullopt;
        if (!decompose_with_rows(pivot, motions, row_scale, clearly, fault)) {
            choose_independent(rows, kNextToNothing, choice_, rest_);
            if (!decompose_with_rows(pivot, motions, row_scale, smallest_, fault)) return false;
        }
    } else {
        for (int k = 0; k < count; ++k) choice_.push_back(k);
        if (!decompose_with_rows(pivot, motions, row_scale, smallest_, fault)) return false;
    }
    general_[as_size(pivot.index)].inverse = block_.inverse();
    if (pivot.passed >= 0) pass_rows_on(pivot, motions);
    update_neighbours(pivot);
    return true;
}

/// The block of a pivot with the rows of choice_.
bool Elimination::decompose_with_rows(const Pivot& pivot, const Vector6& motions, const Column& row_scale,
                                      std::optional<double> smallest, Fault& fault) {
    General& general = general_[as_size(pivot.index)];
    const auto n = as_row(6 + choice_.size());
    Block block = Block::Zero(n, n);
    Column& scale = block_.scale;
    scale.resize(n);
    block.topLeftCorner<6, 6>() = diagonal_[as_size(pivot.frame)];
    scale.head<6>() = motions;
    general.kept.clear();
    for (Eigen::Index i = 6; i < n; ++i) {
        const int k = choice_[as_size(i - 6)];
        block.block<1, 6>(i, 0) = open_.by[0].row(k);
        block.block<6, 1>(0, i) = open_.by[0].row(k).transpose();
        for (Eigen::Index j = 6; j < n; ++j) block(i, j) = open_.among(k, choice_[as_size(j - 6)]);
        scale(i) = row_scale(k);
        general.kept.push_back(open_.rows[as_size(k)]);
    }
    return decompose(pivot, block, general.kept, smallest, block_, fault);
}

/// The rows of rest_: they are coupled with what is eliminated here like a neighbour.
void Elimination::pass_rows_on(const Pivot& pivot, const Vector6& motions) {
    Passed& on = passed_[as_size(pivot.passed)];
    const auto n = as_row(6 + choice_.size()), passed = as_row(rest_.size());
    Block& E = passed_columns_;
    E.setZero(n, passed);
    on.open.rows.clear();
    on.open.among.resize(passed, passed);
    on.open.among_size.resize(passed);
    for (Eigen::Index p = 0; p < passed; ++p) {
        const int k = rest_[as_size(p)];
        on.open.rows.push_back(open_.rows[as_size(k)]);
        E.col(p).head<6>() = open_.by[0].row(k).transpose();
        for (Eigen::Index i = 6; i < n; ++i) E(i, p) = open_.among(choice_[as_size(i - 6)], k);
        for (Eigen::Index q = 0; q < passed; ++q) on.open.among(p, q) = open_.among(k, rest_[as_size(q)]);
        const double own = open_.by[0].row(k).transpose().cwiseProduct(motions).norm();
        on.open.among_size(p) = std::hypot(open_.among_size(k), own);
    }
    on.gain = block_.solve(E);
    on.open.among -= E.transpose() * on.gain;
}

void Elimination::update_neighbours(const Pivot& pivot) {
    General& general = general_[as_size(pivot.index)];
    Passed* const on = pivot.passed >= 0 ? &passed_[as_size(pivot.passed)] : nullptr;
    const auto n = as_row(6 + choice_.size()), passed = as_row(rest_.size());
    const auto coupling_rows = [&](size_t i) {
        Rows B = Rows::Zero(n, 6);
        B.topRows<6>() = couplings_[as_size(pivot.neighbours[i].coupling)];
        for (Eigen::Index k = 6; k < n; ++k) B.row(k) = open_.by[i + 1].row(choice_[as_size(k - 6)]);
        return B;
    };
    for (size_t i = 0; i < pivot.neighbours.size(); ++i) {
        const Rows B = coupling_rows(i);
        general.gains[i] = block_.solve(B);
        diagonal_[as_size(pivot.neighbours[i].frame)] -= B.transpose() * general.gains[i];
        if (!on) continue;
        Rows& by = on->open.by[i];
        by.resize(passed, 6);
        for (Eigen::Index p = 0; p < passed; ++p)
            by.row(p) = open_.by[i + 1].row(rest_[as_size(p)]) - passed_columns_.col(p).transpose() * general.gains[i];
    }
    size_t fill = 0;
    for (size_t i = 0; i < pivot.neighbours.size(); ++i) {
        const Rows B = coupling_rows(i);
        for (size_t j = i + 1; j < pivot.neighbours.size(); ++j)
            fill_in(pivot, pivot.fills[fill++], i, B.transpose() * general.gains[j]);
    }
}

// ---- Solutions ----------------------------------------------------------------------------------------------------------

DTTMM_WIDE void Elimination::solve(std::span<Vector6> r, std::span<double> g) const {
    const std::vector<Pivot>& pivots = order_->pivots();
    const std::vector<int>& plain_index = order_->plain_index();
    const std::vector<EliminationOrder::Plain>& plains = order_->plain();
    for (size_t k = 0; k < pivots.size(); ++k) {
        if (plain_index[k] < 0) [[unlikely]] {
            eliminate(pivots[k], r, g);
            continue;
        }
        const EliminationOrder::Plain plain = plains[as_size(plain_index[k])];
        if (plain.neighbour < 0) continue;
        double* const next = r[as_size(plain.neighbour)].data();
        (Six(next) - transposed_product(couplings_[as_size(plain.coupling)].data(), r[as_size(plain.frame)].data()))
            .store(next);
    }
    for (size_t k = pivots.size(); k-- > 0;) {
        if (plain_index[k] < 0) [[unlikely]] {
            substitute(pivots[k], r, g);
            continue;
        }
        const EliminationOrder::Plain plain = plains[as_size(plain_index[k])];
        double* const own = r[as_size(plain.frame)].data();
        const Six held = product(diagonal_[as_size(plain.frame)].data(), own);
        if (plain.neighbour < 0)
            held.store(own);
        else
            (held - product(couplings_[as_size(plain.coupling)].data(), r[as_size(plain.neighbour)].data())).store(own);
    }
}

DTTMM_WIDE void Elimination::eliminate_elastic(const Pivot& pivot, std::span<Vector6> r) const {
    const double* const own = r[as_size(pivot.frame)].data();
    for (const auto& [neighbour, coupling] : pivot.neighbours) {
        double* const next = r[as_size(neighbour)].data();
        (Six(next) - transposed_product(couplings_[as_size(coupling)].data(), own)).store(next);
    }
}

DTTMM_WIDE void Elimination::substitute_elastic(const Pivot& pivot, std::span<Vector6> r) const {
    double* const own = r[as_size(pivot.frame)].data();
    product(diagonal_[as_size(pivot.frame)].data(), own).store(own);
    for (const auto& [neighbour, coupling] : pivot.neighbours)
        (Six(own) - product(couplings_[as_size(coupling)].data(), r[as_size(neighbour)].data())).store(own);
}

void Elimination::eliminate(const Pivot& pivot, std::span<Vector6> r, std::span<double> g) const {
    if (pivot.is_elastic) return eliminate_elastic(pivot, r);
    const General& general = general_[as_size(pivot.index)];
    Column& z = columns_[as_size(pivot.index)];
    z.resize(general.inverse.rows());
    z.head<6>() = r[as_size(pivot.frame)];
    for (size_t i = 0; i < general.kept.size(); ++i) z(as_row(6 + i)) = g[as_size(general.kept[i])];
    for (size_t i = 0; i < pivot.neighbours.size(); ++i)
        r[as_size(pivot.neighbours[i].frame)] -= general.gains[i].transpose() * z;
    if (pivot.passed >= 0) {
        const Passed& on = passed_[as_size(pivot.passed)];
        for (size_t p = 0; p < on.open.rows.size(); ++p) g[as_size(on.open.rows[p])] -= on.gain.col(as_row(p)).dot(z);
    }
    z = (general.inverse * z).eval();
}

void Elimination::substitute(const Pivot& pivot, std::span<Vector6> r, std::span<double> g) const {
    if (pivot.is_elastic) return substitute_elastic(pivot, r);
    const General& general = general_[as_size(pivot.index)];
    Column& z = columns_[as_size(pivot.index)];
    for (size_t i = 0; i < pivot.neighbours.size(); ++i) z -= general.gains[i] * r[as_size(pivot.neighbours[i].frame)];
    if (pivot.passed >= 0) {
        const Passed& on = passed_[as_size(pivot.passed)];
        for (size_t p = 0; p < on.open.rows.size(); ++p) z -= on.gain.col(as_row(p)) * g[as_size(on.open.rows[p])];
    }
    r[as_size(pivot.frame)] = z.head<6>();
    for (size_t i = 0; i < general.kept.size(); ++i) g[as_size(general.kept[i])] = z(as_row(6 + i));
}

}  // namespace dttmm::plugin
