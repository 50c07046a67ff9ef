// SPDX-License-Identifier: BSD-3-Clause
#include "world/block_matrix.h"

#include <Eigen/OrderingMethods>
#include <algorithm>
#include <set>

#include "model/index.h"

namespace dttmm::host {

namespace {

using Pairs = std::vector<std::pair<int, int>>;

/// Bodies in an elimination order with little fill.
std::vector<int> minimum_degree_order(int count, const Pairs& pairs) {
    std::vector<Eigen::Triplet<double>> entries;
    for (int b = 0; b < count; ++b) entries.emplace_back(b, b, 1.0);
    for (const auto& [i, j] : pairs) {
        entries.emplace_back(i, j, 1.0);
        entries.emplace_back(j, i, 1.0);
    }
    Eigen::SparseMatrix<double> graph(count, count);
    graph.setFromTriplets(entries.begin(), entries.end());
    Eigen::AMDOrdering<int>::PermutationType inverse;
    Eigen::AMDOrdering<int>()(graph, inverse);
    return {inverse.indices().data(), inverse.indices().data() + count};
}

/// Position of every node (bodies, then joints): the bodies with little fill, each joint after the first of its bodies.
std::vector<int> order_nodes(int body_count, Pairs pairs, const std::vector<BlockMatrix::JointNode>& joints) {
    for (const auto& joint : joints)
        if (joint.first >= 0 && joint.second >= 0) pairs.emplace_back(joint.first, joint.second);
    std::vector<int> order(as_size(body_count) + joints.size(), -1);
    std::vector<std::vector<int>> joints_of(as_size(body_count));
    for (size_t j = 0; j < joints.size(); ++j)
        for (int body : {joints[j].first, joints[j].second})
            if (body >= 0) joints_of[as_size(body)].push_back(body_count + as_int(j));
    int next = 0;
    for (int body : minimum_degree_order(body_count, pairs)) {
        order[as_size(body)] = next++;
        for (int node : joints_of[as_size(body)])
            if (order[as_size(node)] < 0) order[as_size(node)] = next++;
    }
    return order;
}

}  // namespace

BlockMatrix::BlockMatrix(int body_count, const Pairs& pairs, const std::vector<JointNode>& joints)
    : body_count_(body_count),
      is_coupled_(!pairs.empty() || !joints.empty()),
      joints_(joints),
      order_(order_nodes(body_count, pairs, joints)) {
    const size_t node_count = order_.size();
    std::vector<int> sizes(node_count), starts(node_count);  // by position
    const auto size_of = [&](size_t node) {
        return node < as_size(body_count) ? 6 : joints[node - as_size(body_count)].equations;
    };
    for (size_t node = 0; node < node_count; ++node) sizes[as_size(order_[node])] = size_of(node);
    int total = 0;
    for (size_t place = 0; place < node_count; ++place) {
        starts[place] = total;
        total += sizes[place];
    }
    for (size_t node = 0; node < node_count; ++node) start_.push_back(starts[as_size(order_[node])]);

    std::set<std::pair<int, int>> blocks;  // (row, column) positions, upper triangle
    const auto couple = [&](int node, int other) {
        const int a = order_[as_size(node)], b = order_[as_size(other)];
        blocks.emplace(std::min(a, b), std::max(a, b));
    };
    for (int node = 0; node < as_int(node_count); ++node) couple(node, node);
    for (const auto& [i, j] : pairs) couple(i, j);
    for (size_t j = 0; j < joints.size(); ++j)
        for (int body : {joints[j].first, joints[j].second})
            if (body >= 0) couple(body_count + as_int(j), body);

    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& [row, column] : blocks) {
        const int r0 = starts[as_size(row)], c0 = starts[as_size(column)];
        for (int c = 0; c < sizes[as_size(column)]; ++c)
            for (int r = 0; r < (row == column ? c + 1 : sizes[as_size(row)]); ++r)
                entries.emplace_back(r0 + r, c0 + c, 0.0);
    }
    matrix_.resize(total, total);
    matrix_.setFromTriplets(entries.begin(), entries.end());
    matrix_.makeCompressed();

    for (const auto& [row, column] : blocks) {
        Places& place = places_[{row, column}];
        for (int c = 0; c < sizes[as_size(column)]; ++c)
            place[as_size(c)] =
                as_int(&matrix_.coeffRef(starts[as_size(row)], starts[as_size(column)] + c) - matrix_.valuePtr());
    }
}

const BlockMatrix::Places& BlockMatrix::places(int row_node, int column_node) const {
    return places_.at({order_[as_size(row_node)], order_[as_size(column_node)]});
}

void BlockMatrix::set_zero() { matrix_.coeffs().setZero(); }

void BlockMatrix::add(int row_body, int column_body, const Block& block) {
    if (order_[as_size(row_body)] > order_[as_size(column_body)]) return;
    const Places& place = places(row_body, column_body);
    for (int c = 0; c < 6; ++c) {
        double* values = matrix_.valuePtr() + place[as_size(c)];
        for (int r = 0; r < (row_body == column_body ? c + 1 : 6); ++r) values[r] += block(r, c);
    }
}

BlockMatrix::Block BlockMatrix::diagonal(int body) const {
    const Places& place = places(body, body);
    Block block;
    for (int c = 0; c < 6; ++c)
        for (int r = 0; r <= c; ++r) block(r, c) = block(c, r) = matrix_.valuePtr()[place[as_size(c)] + r];
    return block;
}

void BlockMatrix::set_joint(int joint, const Rows& first, const Rows& second, const Values& E) {
    const JointNode& node = joints_[as_size(joint)];
    set_side(joint, node.first, first);
    set_side(joint, node.second, second);
    const Places& diagonal = places(body_count_ + joint, body_count_ + joint);
    for (int e = 0; e < node.equations; ++e) matrix_.valuePtr()[diagonal[as_size(e)] + e] = -E(e);
}

void BlockMatrix::set_side(int joint, int body, const Rows& rows) {
    if (body < 0) return;
    const int node = body_count_ + joint, equations = joints_[as_size(joint)].equations;
    const bool body_first = order_[as_size(body)] < order_[as_size(node)];
    const Places& place = body_first ? places(body, node) : places(node, body);
    for (int e = 0; e < equations; ++e)
        for (int i = 0; i < 6; ++i)
            matrix_.valuePtr()[body_first ? place[as_size(e)] + i : place[as_size(i)] + e] = rows(e, i);
}

}  // namespace dttmm::host
