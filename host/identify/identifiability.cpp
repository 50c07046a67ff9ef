// SPDX-License-Identifier: BSD-3-Clause
#include "identify/identifiability.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>

#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr double kDead = 1e-7;      // share of the strongest unknown: below it a difference of two runs is rounding
constexpr double kSingular = 1e-6;  // share of the largest singular value: derivatives are not known better
constexpr double kFlat = 1e-3;      // the same, of a direction that the noise hides
constexpr double kHidden = 0.1;     // standard deviation in such a direction, 10 % of a value
constexpr double kShown = 0.1;      // share of a combination's largest part

/// Unknowns that act alike. own: the columns of the Jacobian of those that are live.
std::vector<std::vector<size_t>> find_tied(const Eigen::MatrixXd& own, const std::vector<Eigen::Index>& live) {
    std::vector<std::vector<size_t>> tied;
    std::vector<bool> is_in_class(live.size(), false);
    for (size_t i = 0; i < live.size(); ++i) {
        if (is_in_class[i]) continue;
        std::vector<size_t> alike = {as_size(live[i])};
        for (size_t j = i + 1; j < live.size(); ++j) {
            const double cosine = own.col(as_row(i)).normalized().dot(own.col(as_row(j)).normalized());
            if (is_in_class[j] || std::abs(cosine) < kTied) continue;
            alike.push_back(as_size(live[j]));
            is_in_class[j] = true;
        }
        if (alike.size() > 1) tied.push_back(alike);
    }
    return tied;
}

}  // namespace

Identifiability judge_identifiability(const Eigen::MatrixXd& jacobian, const Unknowns& unknowns,
                                      const std::vector<bool>& held) {
    const auto count = jacobian.cols();
    constexpr double kInfinite = std::numeric_limits<double>::infinity();
    Identifiability found;
    found.is_dead.assign(as_size(count), false);
    found.deviations = Eigen::VectorXd::Constant(count, kInfinite);
    found.covariance.setZero(count, count);
    const double strongest = count > 0 ? jacobian.colwise().norm().maxCoeff() : 0;
    std::vector<Eigen::Index> live;
    for (Eigen::Index i = 0; i < count; ++i) {
        found.is_dead[as_size(i)] = !(jacobian.col(i).norm() > kDead * strongest);
        if (held[as_size(i)])
            found.deviations(i) = 0;
        else if (!found.is_dead[as_size(i)])
            live.push_back(i);
    }
    if (live.empty()) return found;
    Eigen::MatrixXd own(jacobian.rows(), as_row(live.size()));
    for (size_t i = 0; i < live.size(); ++i) own.col(as_row(i)) = jacobian.col(live[i]);

    found.tied = find_tied(own, live);

    // With at least as many rows as columns the thin V is whole
    Eigen::MatrixXd tall = Eigen::MatrixXd::Zero(std::max(own.rows(), own.cols()), own.cols());
    tall.topRows(own.rows()) = own;
    const Eigen::JacobiSVD<Eigen::MatrixXd> svd(tall, Eigen::ComputeThinV);
    const Eigen::VectorXd values = svd.singularValues();
    std::vector<bool> is_open(live.size(), false);
    for (Eigen::Index k = 0; k < values.size(); ++k) {
        const Eigen::VectorXd direction = svd.matrixV().col(k);
        const double share = values(k) / values(0), deviation = 1 / values(k);
        double range = kInfinite;  // half of the narrowest among those that take part
        for (size_t i = 0; i < live.size(); ++i) {
            const Unknown& one = unknowns[as_size(live[i])];
            const double part = std::abs(direction(as_row(i)));
            if (part > kShown) range = std::min(range, 0.5 * (one.coordinate(one.high) - one.coordinate(one.low)) / part);
        }
        const bool is_flat = !(share >= kSingular) || (share < kFlat && deviation > kHidden) || deviation > range;
        if (!is_flat) {
            for (size_t i = 0; i < live.size(); ++i)
                for (size_t j = 0; j < live.size(); ++j)
                    found.covariance(live[i], live[j]) +=
                        direction(as_row(i)) * direction(as_row(j)) * deviation * deviation;
            continue;
        }
        Eigen::VectorXd whole = Eigen::VectorXd::Zero(count);
        for (size_t i = 0; i < live.size(); ++i) {
            whole(live[i]) = direction(as_row(i));
            if (std::abs(direction(as_row(i))) > kShown) is_open[i] = true;
        }
        found.flat.push_back(whole);
    }
    for (size_t i = 0; i < live.size(); ++i)
        if (!is_open[i]) found.deviations(live[i]) = std::sqrt(found.covariance(live[i], live[i]));
    return found;
}

std::string describe_combination(const Eigen::VectorXd& combination, const Unknowns& unknowns) {
    const double largest = combination.cwiseAbs().maxCoeff();
    Eigen::Index first = 0;
    combination.cwiseAbs().maxCoeff(&first);
    const double sign = combination(first) < 0 ? -1 : 1;
    std::string text;
    for (Eigen::Index i = 0; i < combination.size(); ++i) {
        const double part = sign * combination(i) / largest;
        if (std::abs(part) < kShown) continue;
        const std::string factor = std::abs(std::abs(part) - 1) < 0.005 ? "" : fmt::format("{:.2g} ", std::abs(part));
        text += fmt::format(
            "{}{}{}", text.empty() ? (part < 0 ? "-" : "") : (part < 0 ? " - " : " + "), factor,
            unknowns[as_size(i)].is_logarithmic() ? "ln " + unknowns[as_size(i)].name : unknowns[as_size(i)].name);
    }
    return text;
}

}  // namespace dttmm::host
