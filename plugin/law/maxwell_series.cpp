// SPDX-License-Identifier: BSD-3-Clause
#include "law/maxwell_series.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "core/index.h"

namespace dttmm::plugin {

namespace {

/// x ≥ 0 that minimises |A x − b|. Source: Lawson and Hanson (1974), Solving Least Squares Problems, chapter 23.
Eigen::VectorXd solve_not_negative(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) {
    constexpr double kNone = 1e-10;      // of the largest slope: no unknown gains by growing
    constexpr int kMostExchanges = 300;  // a few per unknown are needed
    const Eigen::Index n = A.cols();
    Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
    std::vector<Eigen::Index> free;
    const double scale = (A.transpose() * b).cwiseAbs().maxCoeff();
    for (int exchange = 0; exchange < kMostExchanges; ++exchange) {
        Eigen::VectorXd slope = A.transpose() * (b - A * x);
        for (const Eigen::Index i : free) slope(i) = 0;
        Eigen::Index best = 0;
        if (slope.maxCoeff(&best) <= kNone * scale) break;
        free.push_back(best);
        while (!free.empty()) {
            const Eigen::VectorXd s = A(Eigen::all, free).colPivHouseholderQr().solve(b);
            double share = 1;  // of the way to s on which no unknown becomes negative
            for (size_t k = 0; k < free.size(); ++k) {
                const double now = x(free[k]), next = s(as_row(k));
                if (next <= 0) share = std::min(share, now / (now - next));
            }
            for (size_t k = 0; k < free.size(); ++k) x(free[k]) += share * (s(static_cast<Eigen::Index>(k)) - x(free[k]));
            if (share == 1) break;
            std::erase_if(free, [&](Eigen::Index i) {
                if (x(i) > kNone * x.maxCoeff()) return false;
                x(i) = 0;
                return true;
            });
        }
    }
    return x;
}

std::complex<double> unit_term(double omega, double time) {
    const std::complex<double> s(0, omega * time);
    return s / (1.0 + s);
}

}  // namespace

std::complex<double> MaxwellSeries::at(double omega) const {
    std::complex<double> sum = spring;
    for (const Term& term : terms) sum += term.stiffness * unit_term(omega, term.time);
    return sum;
}

MaxwellSeries::Misfit MaxwellSeries::misfit(std::span<const DynamicStiffnessRow> rows) const {
    Misfit worst;
    for (const DynamicStiffnessRow& row : rows)
        if (const double share = std::abs(at(row.omega) - row.value()) / row.stiffness; share > worst.share)
            worst = {share, row.omega};
    return worst;
}

MaxwellSeries fit_maxwell(std::span<const DynamicStiffnessRow> rows) {
    constexpr double kBeyond = 3;     // a term bends the curve for about half a decade on each side of 1/τ
    constexpr double kPerDecade = 2;  // terms; more of them are too similar to be distinguished
    constexpr double kFewest = 3;
    const double low = rows.front().omega / kBeyond, high = kBeyond * rows.back().omega;
    const auto count = static_cast<Eigen::Index>(std::max(kFewest, std::ceil(kPerDecade * std::log10(high / low)) + 1));
    std::vector<double> times;
    for (Eigen::Index j = 0; j < count; ++j)
        times.push_back(1 / (low * std::pow(high / low, static_cast<double>(j) / static_cast<double>(count - 1))));
    const auto height = as_row(rows.size());
    Eigen::MatrixXd A(2 * height, 1 + count);
    Eigen::VectorXd b(2 * height);
    for (Eigen::Index i = 0; i < height; ++i) {
        const DynamicStiffnessRow& row = rows[as_size(i)];
        for (Eigen::Index j = 0; j <= count; ++j) {
            const std::complex<double> value = (j == 0 ? 1.0 : unit_term(row.omega, times[as_size(j - 1)])) / row.stiffness;
            A(2 * i, j) = value.real();
            A(2 * i + 1, j) = value.imag();
        }
        b(2 * i) = row.value().real() / row.stiffness;
        b(2 * i + 1) = row.value().imag() / row.stiffness;
    }
    const double unit = rows.front().stiffness;
    const Eigen::VectorXd x = unit * solve_not_negative(unit * A, b);
    MaxwellSeries series{x(0), {}};
    for (Eigen::Index j = 0; j < count; ++j)
        if (x(1 + j) > 0) series.terms.push_back({x(1 + j), times[as_size(j)]});
    return series;
}

}  // namespace dttmm::plugin
