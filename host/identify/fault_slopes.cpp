// SPDX-License-Identifier: BSD-3-Clause
#include "identify/fault_slopes.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>

#include "identify/identifiability.h"
#include "identify/residuals.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr size_t kMostPaired = 8;  // suspects that pairs are made of
constexpr size_t kMostPairs = 6;   // pairs that are fitted
constexpr double kUnseen = 1e-6;   // share of the strongest fault's effect

}  // namespace

Eigen::MatrixXd without(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& basis) {
    if (basis.cols() == 0) return columns;
    return columns - basis * basis.colPivHouseholderQr().solve(columns);
}

void FaultSlopes::find(const Eigen::VectorXd& common_at, const Eigen::VectorXd& predicted, std::vector<size_t> columns) {
    const Unknowns unknowns = suspects_.unknowns(common_, suspects_.names, false, true);
    if (is_found_.empty()) {
        is_found_.assign(unknowns.size(), false);
        changes_.setZero(comparison_.rows(), as_row(unknowns.size()));
    }
    std::erase_if(columns, [&](size_t column) { return is_found_[column]; });
    Eigen::VectorXd x = unknowns.start();
    x.head(common_at.size()) = common_at;
    const Eigen::MatrixXd slopes = Residuals(comparison_, unknowns, {}, jobs_)
                                       .differentiate_quickly(x, comparison_.residual(predicted, false), columns);
    for (size_t i = 0; i < columns.size(); ++i) {
        changes_.col(as_row(columns[i])) = slopes.col(as_row(i)).cwiseProduct(comparison_.deviations());
        is_found_[columns[i]] = true;
    }
    scale();
}

/// Of its damping among slopes_.
std::optional<size_t> FaultSlopes::damping_column(size_t suspect) const {
    if (!suspects_.are_damped[suspect]) return std::nullopt;
    return suspects_.size() +
           as_size(std::count(suspects_.are_damped.begin(), suspects_.are_damped.begin() + as_row(suspect), true));
}

void FaultSlopes::scale() {
    const Eigen::MatrixXd scaled = comparison_.deviations().cwiseInverse().asDiagonal() * changes_;
    const auto count = as_row(common_.size());
    slopes_ = without(scaled.rightCols(scaled.cols() - count), scaled.leftCols(count));
}

Eigen::VectorXd FaultSlopes::beyond_common(const Eigen::VectorXd& change) const {
    return without(change, comparison_.deviations().cwiseInverse().asDiagonal() * changes_.leftCols(as_row(common_.size())));
}

double FaultSlopes::gain(const std::vector<size_t>& suspects, const Eigen::VectorXd& residual) const {
    std::vector<Eigen::Index> columns;
    for (const size_t s : suspects) {
        columns.push_back(as_row(s));
        const auto damping = damping_column(s);
        if (damping && is_found_[common_.size() + *damping]) columns.push_back(as_row(*damping));
    }
    Eigen::MatrixXd own(slopes_.rows(), as_row(columns.size()));
    for (size_t c = 0; c < columns.size(); ++c) own.col(as_row(c)) = slopes_.col(columns[c]);
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr;
    qr.setThreshold(kUnseen);
    qr.compute(own);
    return residual.squaredNorm() - (residual - own * qr.solve(residual)).squaredNorm();
}

std::vector<double> FaultSlopes::effects() const {
    const Eigen::VectorXd norms = slopes_.leftCols(as_row(suspects_.size())).colwise().norm();
    std::vector<double> effects(norms.begin(), norms.end());
    const double least = kUnseen * norms.maxCoeff();
    for (double& effect : effects)
        if (!(effect > least)) effect = 0;
    return effects;
}

std::vector<std::vector<size_t>> FaultSlopes::ties() const {
    const double strongest = slopes_.leftCols(as_row(suspects_.size())).colwise().norm().maxCoeff();
    std::vector<std::vector<size_t>> classes;
    for (size_t s = 0; s < suspects_.size(); ++s) {
        const auto own = slopes_.col(as_row(s));
        const double norm = own.norm();
        const auto is_like = [&](const std::vector<size_t>& one) {
            const auto first = slopes_.col(as_row(one.front()));
            return first.norm() > kUnseen * strongest && std::abs(own.dot(first)) >= kTied * norm * first.norm();
        };
        const auto found = norm > kUnseen * strongest ? std::ranges::find_if(classes, is_like) : classes.end();
        if (found != classes.end())
            found->push_back(s);
        else
            classes.push_back({s});
    }
    return classes;
}

/// Those that promise most.
std::vector<size_t> FaultSlopes::strongest(const Eigen::VectorXd& residual) const {
    std::vector<size_t> order(suspects_.size());
    std::iota(order.begin(), order.end(), size_t{0});
    std::vector<double> gains;
    for (size_t s = 0; s < suspects_.size(); ++s) gains.push_back(gain({s}, residual));
    std::ranges::stable_sort(order, [&](size_t a, size_t b) { return gains[a] > gains[b]; });
    order.resize(std::min(order.size(), kMostPaired));
    return order;
}

std::vector<std::array<size_t, 2>> FaultSlopes::promising_pairs(const Eigen::VectorXd& residual) const {
    const std::vector<size_t> order = strongest(residual);
    struct Pair {
        size_t a, b;
        double gain;
    };
    std::vector<Pair> pairs;
    for (size_t i = 0; i < order.size(); ++i)
        for (size_t j = i + 1; j < order.size(); ++j)
            pairs.push_back(
                {std::min(order[i], order[j]), std::max(order[i], order[j]), gain({order[i], order[j]}, residual)});
    std::ranges::stable_sort(pairs, std::ranges::greater(), &Pair::gain);
    pairs.resize(std::min(pairs.size(), kMostPairs));
    std::vector<std::array<size_t, 2>> chosen;
    for (const Pair& pair : pairs) chosen.push_back({pair.a, pair.b});
    return chosen;
}

}  // namespace dttmm::host
