// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/block_matrix.h"

#include <Eigen/OrderingMethods>
#include <set>

namespace dttmm {

namespace {

using Pairs = std::vector<std::pair<int, int>>;

/// Position of every body in an elimination order with little fill.
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
    std::vector<int> order(static_cast<size_t>(count));
    for (int place = 0; place < count; ++place) order[static_cast<size_t>(inverse.indices()(place))] = place;
    return order;
}

}  // namespace

BlockMatrix::BlockMatrix(int body_count, const Pairs& pairs)
    : order_(minimum_degree_order(body_count, pairs)), matrix_(6 * body_count, 6 * body_count) {
    std::set<std::pair<int, int>> blocks;  // (row, column) in the new order, upper triangle
    for (int b = 0; b < body_count; ++b) blocks.emplace(b, b);
    for (const auto& [i, j] : pairs) {
        const int a = order_[static_cast<size_t>(i)], b = order_[static_cast<size_t>(j)];
        blocks.emplace(std::min(a, b), std::max(a, b));
    }

    std::vector<Eigen::Triplet<double>> entries;
    for (const auto& [row, column] : blocks)
        for (int c = 0; c < 6; ++c)
            for (int r = 0; r < (row == column ? c + 1 : 6); ++r) entries.emplace_back(6 * row + r, 6 * column + c, 0.0);
    matrix_.setFromTriplets(entries.begin(), entries.end());
    matrix_.makeCompressed();

    for (const auto& [row, column] : blocks) {
        std::array<int, 6>& place = places_[{row, column}];
        for (int c = 0; c < 6; ++c)
            place[static_cast<size_t>(c)] =
                static_cast<int>(&matrix_.coeffRef(6 * row, 6 * column + c) - matrix_.valuePtr());
    }
}

void BlockMatrix::set_zero() { matrix_.coeffs().setZero(); }

void BlockMatrix::add(int row_body, int column_body, const Block& block) {
    const int row = order_[static_cast<size_t>(row_body)], column = order_[static_cast<size_t>(column_body)];
    if (row > column) return;
    const std::array<int, 6>& place = places_.at({row, column});
    for (int c = 0; c < 6; ++c) {
        double* values = matrix_.valuePtr() + place[static_cast<size_t>(c)];
        for (int r = 0; r < (row == column ? c + 1 : 6); ++r) values[r] += block(r, c);
    }
}

}  // namespace dttmm
