// SPDX-License-Identifier: BSD-3-Clause
#include "network/elimination.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <deque>
#include <set>

#include "core/error.h"

namespace dttmm {

namespace {

/// Order of elimination: frames with one neighbour left as long as there are any, in the order in which they come up, so
/// that a chain is eaten from both tips; where only loops are left, the frame with the fewest neighbours. `graph` is filled
/// in on the way.
std::vector<int> find_order(std::vector<std::set<int>>& graph) {
    const size_t n = graph.size();
    std::vector<std::set<int>> left = graph;
    std::vector<bool> done(n), queued(n);
    std::deque<int> tips;
    std::set<std::pair<size_t, int>> by_degree;
    for (size_t f = 0; f < n; ++f) {
        by_degree.emplace(left[f].size(), static_cast<int>(f));
        if (left[f].size() <= 1) tips.push_back(static_cast<int>(f)), queued[f] = true;
    }
    std::vector<int> order;
    while (order.size() < n) {
        int frame;
        if (!tips.empty()) {
            frame = tips.front();
            tips.pop_front();
        } else {
            frame = by_degree.begin()->second;
        }
        const auto f = static_cast<size_t>(frame);
        if (done[f]) continue;
        done[f] = true;
        order.push_back(frame);
        by_degree.erase({left[f].size(), frame});
        const std::set<int> neighbours = left[f];
        for (int a : neighbours) {
            auto& of_a = left[static_cast<size_t>(a)];
            by_degree.erase({of_a.size(), a});
            of_a.erase(frame);
            for (int b : neighbours)
                if (a != b) {
                    of_a.insert(b);
                    graph[static_cast<size_t>(a)].insert(b);
                }
            by_degree.emplace(of_a.size(), a);
            if (of_a.size() <= 1 && !queued[static_cast<size_t>(a)])
                tips.push_back(a), queued[static_cast<size_t>(a)] = true;
        }
    }
    return order;
}

}  // namespace

Elimination::Elimination(int frame_count, const std::vector<Link>& links) {
    const auto n = static_cast<size_t>(frame_count);
    diagonal_.assign(n, Matrix6::Zero());
    work_.assign(n, Matrix6::Zero());
    std::vector<std::set<int>> graph(n);
    for (const Link& link : links) {
        if (link.from < 0 || link.to < 0 || link.from == link.to) continue;
        graph[static_cast<size_t>(link.from)].insert(link.to);
        graph[static_cast<size_t>(link.to)].insert(link.from);
    }
    const std::vector<int> order = find_order(graph);
    order_.resize(n);
    for (size_t k = 0; k < n; ++k) order_[static_cast<size_t>(order[k])] = static_cast<int>(k);
    const auto earlier = [&](int a, int b) { return order_[static_cast<size_t>(a)] < order_[static_cast<size_t>(b)]; };

    // Couplings of later frames with each frame, the fills included
    std::vector<std::vector<std::pair<int, int>>> later(n);  // (frame, coupling)
    for (size_t f = 0; f < n; ++f) {
        for (int other : graph[f]) {
            if (!earlier(static_cast<int>(f), other)) continue;
            later[f].emplace_back(other, static_cast<int>(couplings_.size()));
            couplings_.push_back({static_cast<int>(f), other});
        }
    }
    const auto coupling_of = [&](int a, int b) {
        if (!earlier(a, b)) std::swap(a, b);
        for (const auto& [frame, coupling] : later[static_cast<size_t>(a)])
            if (frame == b) return coupling;
        return -1;
    };
    for (size_t l = 0; l < links.size(); ++l) {
        const Link& link = links[l];
        const bool inside = link.from >= 0 && link.to >= 0 && link.from != link.to;
        link_coupling_.push_back(inside ? coupling_of(link.from, link.to) : -1);
        link_transposed_.push_back(inside && !earlier(link.from, link.to));
        rigid_begin_.push_back(rigid_total_);
        rigid_total_ += link.rigid_count;
        for (int i = 0; i < link.rigid_count; ++i)
            rigid_rows_.push_back({static_cast<int>(l), i, {link.from, link.to}, {Vector6::Zero(), Vector6::Zero()}});
    }

    pivots_.resize(n);
    for (size_t k = 0; k < n; ++k) {
        Pivot& pivot = pivots_[k];
        pivot.frame = order[k];
        for (const auto& [frame, coupling] : later[static_cast<size_t>(pivot.frame)])
            pivot.neighbours.push_back({frame, coupling, {}});
        for (size_t i = 0; i < pivot.neighbours.size(); ++i)
            for (size_t j = i + 1; j < pivot.neighbours.size(); ++j)
                pivot.fills.push_back(coupling_of(pivot.neighbours[i].frame, pivot.neighbours[j].frame));
    }
    for (size_t row = 0; row < rigid_rows_.size(); ++row) {
        const RigidRow& rigid = rigid_rows_[row];
        int first = std::max(rigid.frames[0], rigid.frames[1]);
        if (rigid.frames[0] >= 0 && rigid.frames[1] >= 0)
            first = earlier(rigid.frames[0], rigid.frames[1]) ? rigid.frames[0] : rigid.frames[1];
        Pivot& pivot = pivots_[static_cast<size_t>(order_[static_cast<size_t>(first)])];
        const int block_row = 6 + static_cast<int>(pivot.rigid.size());
        pivot.rigid.push_back(static_cast<int>(row));
        for (Neighbour& neighbour : pivot.neighbours)
            if (neighbour.frame == rigid.frames[0] || neighbour.frame == rigid.frames[1])
                neighbour.rigid.emplace_back(block_row, static_cast<int>(row));
    }
    for (Pivot& pivot : pivots_) {
        pivot.is_plain = pivot.rigid.empty() && pivot.neighbours.size() <= 1;
        pivot.plain = static_cast<int>(pivot.is_plain ? plain_.size() : general_.size());
        if (pivot.is_plain)
            plain_.push_back({Matrix6::Zero(), Matrix6::Zero(), pivot.frame,
                              pivot.neighbours.empty() ? -1 : pivot.neighbours.front().frame});
        else
            general_.push_back({{}, std::vector<Rows>(pivot.neighbours.size())});
    }
    columns_.resize(general_.size());
}

void Elimination::set_zero() {
    for (Matrix6& block : diagonal_) block.setZero();
    for (Coupling& coupling : couplings_) coupling.original.setZero();
}

void Elimination::add_coupling(int link, const Matrix6& block) {
    const int coupling = link_coupling_[static_cast<size_t>(link)];
    if (coupling < 0) return;
    Matrix6& into = couplings_[static_cast<size_t>(coupling)].original;
    if (link_transposed_[static_cast<size_t>(link)])
        into += block.transpose();
    else
        into += block;
}

void Elimination::set_rigid(int link, int i, const Vector6& by_from, const Vector6& by_to) {
    RigidRow& row = rigid_rows_[static_cast<size_t>(rigid_begin(link) + i)];
    row.by[0] = by_from;
    row.by[1] = by_to;
}

// ---- The factor ---------------------------------------------------------------------------------------------------------

std::optional<Elimination::Fault> Elimination::factor() {
    work_ = diagonal_;
    for (Coupling& coupling : couplings_) coupling.block = coupling.original;
    Fault fault;
    for (size_t k = 0; k < pivots_.size(); ++k) {
        const Pivot& pivot = pivots_[k];
        if (!(pivot.is_plain ? factor_plain(pivot, fault) : factor_general(k, fault))) return fault;
    }
    return std::nullopt;
}

/// Full-pivot inverse of a pivot's block, its unknowns scaled by what stood on the diagonal before anything was eliminated:
/// what is left of a motion that nothing holds is small beside that.
bool Elimination::invert(const Pivot& pivot, const Block& block, Block& inverse, Fault& fault) const {
    constexpr double kSmallestCondition = 1e-13;
    const Eigen::Index n = block.rows();
    const Matrix6& original = diagonal_[static_cast<size_t>(pivot.frame)];
    Column scale(n);
    for (Eigen::Index i = 0; i < 6; ++i) {
        const double size = std::max(std::abs(original(i, i)), std::abs(block(i, i)));
        scale(i) = size > 0 ? 1 / std::sqrt(size) : 0;
    }
    // A direction without anything of its own is measured by the others of its kind
    for (Eigen::Index i = 0; i < 6; ++i) {
        if (scale(i) > 0) continue;
        for (Eigen::Index j = 3 * (i / 3); j < 3 * (i / 3) + 3; ++j) scale(i) = std::max(scale(i), scale(j));
        if (scale(i) == 0) scale(i) = 1;
    }
    for (Eigen::Index i = 6; i < n; ++i) {
        double largest = 0;
        for (Eigen::Index j = 0; j < 6; ++j) largest = std::max(largest, std::abs(block(i, j)) * scale(j));
        scale(i) = largest > 0 ? 1 / largest : 1;
    }
    const Block scaled = scale.asDiagonal() * block * scale.asDiagonal();
    Eigen::FullPivLU<Block> lu(scaled);
    lu.setThreshold(0);
    const double last = std::abs(lu.matrixLU()(n - 1, n - 1));
    if (!scaled.allFinite() || last == 0 || !(lu.rcond() > kSmallestCondition)) {
        const auto weakest = static_cast<int>(lu.permutationQ().indices()(n - 1));
        if (weakest < 6) {
            fault.frame = pivot.frame;
            fault.direction = weakest;
        } else {
            const RigidRow& row = rigid_rows_[static_cast<size_t>(pivot.rigid[static_cast<size_t>(weakest - 6)])];
            fault.frame = pivot.frame;
            fault.link = row.link;
            fault.rigid = row.index;
        }
        return false;
    }
    inverse = lu.inverse();
    inverse = (0.5 * (inverse + inverse.transpose())).eval();
    inverse = (scale.asDiagonal() * inverse * scale.asDiagonal()).eval();
    return true;
}

bool Elimination::factor_plain(const Pivot& pivot, Fault& fault) {
    Block inverse;
    if (!invert(pivot, work_[static_cast<size_t>(pivot.frame)], inverse, fault)) return false;
    Plain& plain = plain_[static_cast<size_t>(pivot.plain)];
    plain.inverse = inverse;
    if (plain.neighbour < 0) return true;
    const Matrix6& B = couplings_[static_cast<size_t>(pivot.neighbours.front().coupling)].block;
    plain.gain = plain.inverse * B;
    work_[static_cast<size_t>(plain.neighbour)] -= B.transpose() * plain.gain;
    return true;
}

bool Elimination::factor_general(size_t index, Fault& fault) {
    const Pivot& pivot = pivots_[index];
    const auto n = static_cast<Eigen::Index>(6 + pivot.rigid.size());
    if (n > kLargestBlock) {
        fault = {pivot.frame, -1, rigid_rows_[static_cast<size_t>(pivot.rigid.back())].link,
                 rigid_rows_[static_cast<size_t>(pivot.rigid.back())].index};
        return false;
    }
    Block block = Block::Zero(n, n);
    block.topLeftCorner<6, 6>() = work_[static_cast<size_t>(pivot.frame)];
    for (size_t i = 0; i < pivot.rigid.size(); ++i) {
        const RigidRow& row = rigid_rows_[static_cast<size_t>(pivot.rigid[i])];
        const auto at = static_cast<Eigen::Index>(6 + i);
        const Vector6& by = row.by[row.frames[0] == pivot.frame ? 0 : 1];
        block.block<1, 6>(at, 0) = by.transpose();
        block.block<6, 1>(0, at) = by;
    }
    General& general = general_[static_cast<size_t>(pivot.plain)];
    if (!invert(pivot, block, general.inverse, fault)) return false;
    std::vector<Rows>& gains = general.gains;
    const auto coupling_rows = [&](const Neighbour& neighbour) {
        Rows B = Rows::Zero(n, 6);
        B.topRows<6>() = couplings_[static_cast<size_t>(neighbour.coupling)].block;
        for (const auto& [at, r] : neighbour.rigid) {
            const RigidRow& row = rigid_rows_[static_cast<size_t>(r)];
            B.row(at) = row.by[row.frames[0] == neighbour.frame ? 0 : 1].transpose();
        }
        return B;
    };
    size_t fill = 0;
    for (size_t i = 0; i < pivot.neighbours.size(); ++i) {
        const Rows B = coupling_rows(pivot.neighbours[i]);
        gains[i] = general.inverse * B;
        work_[static_cast<size_t>(pivot.neighbours[i].frame)] -= B.transpose() * gains[i];
    }
    for (size_t i = 0; i < pivot.neighbours.size(); ++i) {
        const Rows B = coupling_rows(pivot.neighbours[i]);
        for (size_t j = i + 1; j < pivot.neighbours.size(); ++j) {
            Coupling& coupling = couplings_[static_cast<size_t>(pivot.fills[fill++])];
            const Matrix6 update = B.transpose() * gains[j];
            if (coupling.row == pivot.neighbours[i].frame)
                coupling.block -= update;
            else
                coupling.block -= update.transpose();
        }
    }
    return true;
}

// ---- Solutions ----------------------------------------------------------------------------------------------------------

void Elimination::solve(std::span<Vector6> r, std::span<double> g) const {
    for (const Pivot& pivot : pivots_) {
        Vector6& own = r[static_cast<size_t>(pivot.frame)];
        if (pivot.is_plain) [[likely]] {
            const Plain& plain = plain_[static_cast<size_t>(pivot.plain)];
            if (plain.neighbour >= 0) r[static_cast<size_t>(plain.neighbour)].noalias() -= plain.gain.transpose() * own;
            own = (plain.inverse * own).eval();
            continue;
        }
        const General& general = general_[static_cast<size_t>(pivot.plain)];
        Column& z = columns_[static_cast<size_t>(pivot.plain)];
        z.resize(general.inverse.rows());
        z.head<6>() = own;
        for (size_t i = 0; i < pivot.rigid.size(); ++i)
            z(static_cast<Eigen::Index>(6 + i)) = g[static_cast<size_t>(pivot.rigid[i])];
        for (size_t i = 0; i < pivot.neighbours.size(); ++i)
            r[static_cast<size_t>(pivot.neighbours[i].frame)] -= general.gains[i].transpose() * z;
        z = (general.inverse * z).eval();
    }
    for (size_t k = pivots_.size(); k-- > 0;) {
        const Pivot& pivot = pivots_[k];
        Vector6& own = r[static_cast<size_t>(pivot.frame)];
        if (pivot.is_plain) [[likely]] {
            const Plain& plain = plain_[static_cast<size_t>(pivot.plain)];
            if (plain.neighbour >= 0) own.noalias() -= plain.gain * r[static_cast<size_t>(plain.neighbour)];
            continue;
        }
        const General& general = general_[static_cast<size_t>(pivot.plain)];
        Column& z = columns_[static_cast<size_t>(pivot.plain)];
        for (size_t i = 0; i < pivot.neighbours.size(); ++i)
            z -= general.gains[i] * r[static_cast<size_t>(pivot.neighbours[i].frame)];
        own = z.head<6>();
        for (size_t i = 0; i < pivot.rigid.size(); ++i)
            g[static_cast<size_t>(pivot.rigid[i])] = z(static_cast<Eigen::Index>(6 + i));
    }
}

}  // namespace dttmm
