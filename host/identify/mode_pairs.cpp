// SPDX-License-Identifier: BSD-3-Clause
#include "identify/mode_pairs.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "analysis/shape_match.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr double kOneFrequency = 1e-6;  // share: modes this near in frequency mix freely
constexpr double kTie = 0.01;           // of MAC: of shapes nearer than this the frequencies decide

/// A shape is a shape from two components on: one alone is like every other.
bool has_shape(const ObservedMode& mode) {
    Eigen::Index count = 0;
    for (const double value : mode.shape) count += !std::isnan(value);
    return count > 1;
}

/// Components that were measured.
Eigen::VectorXd pick_rows(const Eigen::VectorXd& all, const Eigen::VectorXd& measured) {
    std::vector<double> picked;
    for (Eigen::Index i = 0; i < measured.size(); ++i)
        if (!std::isnan(measured(i))) picked.push_back(all(i));
    return Eigen::Map<const Eigen::VectorXd>(picked.data(), as_row(picked.size()));
}

/// What of the modes at the frequency of mode `m` is nearest to the measured shape, and how near.
ModePair compare_shapes(const ObservedMode& measured, size_t m, const std::vector<double>& frequencies,
                        const Eigen::MatrixXd& shapes) {
    const auto is_same = [&](size_t other) {
        return std::abs(frequencies[other] - frequencies[m]) <= kOneFrequency * frequencies[m];
    };
    std::vector<Eigen::Index> group;
    for (size_t other = 0; other < frequencies.size(); ++other)
        if (is_same(other)) group.push_back(as_row(other));
    const Eigen::VectorXd wanted = pick_rows(measured.shape, measured.shape);
    Eigen::MatrixXd basis(wanted.size(), as_row(group.size()));
    for (size_t g = 0; g < group.size(); ++g) basis.col(as_row(g)) = pick_rows(shapes.col(group[g]), measured.shape);
    ModePair pair{as_int(m + 1), frequencies[m], 0, shapes(Eigen::all, group) * nearest_mixture(basis, wanted)};
    const Eigen::VectorXd own = pick_rows(pair.shape, measured.shape);
    const double product = own.dot(wanted), squares = own.squaredNorm() * wanted.squaredNorm();
    pair.mac = squares > 0 ? product * product / squares : 0;
    return pair;
}

}  // namespace

std::vector<ModePair> pair_modes(const std::vector<ObservedMode>& measured, const std::vector<double>& frequencies,
                                 const Eigen::MatrixXd& shapes) {
    std::vector<ModePair> pairs(measured.size());
    std::vector<bool> is_taken(frequencies.size(), false);
    const auto take = [&](size_t i, ModePair pair) {
        is_taken[as_size(pair.mode - 1)] = true;
        pairs[i] = std::move(pair);
    };
    struct Candidate {
        size_t measured;
        ModePair pair;
        double score;
    };
    std::vector<Candidate> candidates;
    for (size_t i = 0; i < measured.size(); ++i)
        for (size_t m = 0; has_shape(measured[i]) && m < frequencies.size(); ++m) {
            if (!(frequencies[m] > 0)) continue;
            ModePair pair = compare_shapes(measured[i], m, frequencies, shapes);
            const double away = std::abs(std::log(frequencies[m] / measured[i].frequency));
            const double score = pair.mac - kTie * away;
            candidates.push_back({i, std::move(pair), score});
        }
    std::ranges::stable_sort(candidates, std::ranges::greater(), &Candidate::score);
    for (Candidate& one : candidates)
        if (pairs[one.measured].mode == 0 && !is_taken[as_size(one.pair.mode - 1)]) take(one.measured, std::move(one.pair));
    for (size_t i = 0; i < measured.size(); ++i) {
        const auto m = as_size(measured[i].number - 1);
        if (pairs[i].mode > 0 || m >= frequencies.size() || is_taken[m] || !(frequencies[m] > 0)) continue;
        take(i, {measured[i].number, frequencies[m], std::numeric_limits<double>::quiet_NaN(), shapes.col(as_row(m))});
    }
    return pairs;
}

}  // namespace dttmm::host
