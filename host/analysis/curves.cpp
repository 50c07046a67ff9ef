// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/curves.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "model/index.h"

namespace dttmm::host {

namespace {

/// A column of the shapes of a case.
struct Shape {
    size_t in_case;
    Eigen::Index mode;
};

/// The parameters as shares of their ranges.
Eigen::MatrixXd scale(const std::vector<std::vector<double>>& parameters) {
    Eigen::MatrixXd scaled(as_row(parameters.front().size()), as_row(parameters.size()));
    for (size_t c = 0; c < parameters.size(); ++c)
        scaled.col(as_row(c)) = Eigen::Map<const Eigen::VectorXd>(parameters[c].data(), as_row(parameters[c].size()));
    for (Eigen::Index p = 0; p < scaled.rows(); ++p) {
        const double low = scaled.row(p).minCoeff(), range = scaled.row(p).maxCoeff() - low;
        for (double& value : scaled.row(p)) value = range > 0 ? (value - low) / range : 0;
    }
    return scaled;
}

/// All cases but the first with the case each is compared with, in the order in which they are compared.
std::vector<std::pair<size_t, size_t>> make_tree(const Eigen::MatrixXd& points) {
    const auto n = as_size(points.cols());
    std::vector<double> distance(n, std::numeric_limits<double>::infinity());  // to the nearest that is done
    std::vector<size_t> nearest(n, 0);
    std::vector<bool> is_done(n, false);
    std::vector<std::pair<size_t, size_t>> tree;
    // Steps of an even grid differ by rounding, 1e-16 of the range: the case listed first wins
    constexpr double kTie = 1 - 1e-9;
    for (size_t last = 0; tree.size() + 1 < n;) {
        is_done[last] = true;
        size_t next = n;
        for (size_t c = 0; c < n; ++c) {
            if (is_done[c]) continue;
            const double d = (points.col(as_row(c)) - points.col(as_row(last))).norm();
            if (d < kTie * distance[c]) {
                distance[c] = d;
                nearest[c] = last;
            }
            if (next == n || distance[c] < kTie * distance[next]) next = c;
        }
        tree.emplace_back(next, nearest[next]);
        last = next;
    }
    return tree;
}

}  // namespace

double compute_likeness(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
    const double product = a.squaredNorm() * b.squaredNorm();
    return product > 0 ? a.dot(b) * a.dot(b) / product : 0;
}

std::vector<CaseCurves> follow_curves(const std::vector<std::vector<double>>& parameters,
                                      const std::vector<Eigen::MatrixXd>& shapes) {
    std::vector<CaseCurves> curves(shapes.size());
    if (shapes.empty()) return curves;
    std::vector<std::vector<Shape>> last(shapes.size());  // of every curve, as each case knows it
    std::vector<Shape> first;                             // of every curve
    const auto begin = [&](size_t c, Eigen::Index mode) {
        first.push_back({c, mode});
        curves[c].mode_of.resize(first.size(), CaseCurves::kNone);
        curves[c].likeness.resize(first.size(), std::nan(""));
        curves[c].mode_of.back() = as_size(mode);
    };
    for (Eigen::Index m = 0; m < shapes[0].cols(); ++m) begin(0, m);
    last[0] = first;
    for (const auto& [c, nearest] : make_tree(scale(parameters))) {
        CaseCurves& own = curves[c];
        own.nearest = nearest;
        std::vector<Shape> known = last[nearest];
        known.insert(known.end(), first.begin() + as_row(known.size()), first.end());
        own.mode_of.assign(known.size(), CaseCurves::kNone);
        own.likeness.assign(known.size(), std::nan(""));
        std::vector<std::tuple<double, size_t, Eigen::Index>> pairs;
        for (size_t k = 0; k < known.size(); ++k)
            for (Eigen::Index m = 0; m < shapes[c].cols(); ++m)
                pairs.emplace_back(-compute_likeness(shapes[known[k].in_case].col(known[k].mode), shapes[c].col(m)), k, m);
        std::ranges::sort(pairs);
        std::vector<bool> is_taken(as_size(shapes[c].cols()), false);
        for (const auto& [unlike, k, m] : pairs) {
            if (own.mode_of[k] != CaseCurves::kNone || is_taken[as_size(m)]) continue;
            own.mode_of[k] = as_size(m);
            own.likeness[k] = -unlike;
            is_taken[as_size(m)] = true;
            known[k] = {c, m};
        }
        for (size_t m = 0; m < is_taken.size(); ++m)
            if (!is_taken[m]) begin(c, as_row(m));
        last[c] = std::move(known);
        last[c].insert(last[c].end(), first.begin() + as_row(last[c].size()), first.end());
    }
    for (CaseCurves& one : curves) {
        one.mode_of.resize(first.size(), CaseCurves::kNone);
        one.likeness.resize(first.size(), std::nan(""));
    }
    return curves;
}

}  // namespace dttmm::host
