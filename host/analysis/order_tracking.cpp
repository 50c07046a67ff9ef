// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/order_tracking.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis/spectra.h"
#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

constexpr double kRevolution = 2 * std::numbers::pi;

/// Least squares of one block: its rows, and the orders that the rows resolve.
class Block {
public:
    Block(const ShaftAngle& shaft, const std::vector<double>& orders, double begin, double end, double interval)
        : first_(std::ranges::lower_bound(shaft.angle, begin) - shaft.angle.begin()),
          rows_(std::ranges::upper_bound(shaft.angle, end) - shaft.angle.begin() - first_) {
        const double fastest = *std::max_element(shaft.speed.begin() + first_, shaft.speed.begin() + first_ + rows_);
        for (const double order : orders) is_resolved_.push_back(2 * order * fastest * interval < kRevolution * kEndOfBand);
        Eigen::MatrixXd A(rows_, 1 + 2 * std::ranges::count(is_resolved_, true));
        weights_.resize(rows_);
        for (Eigen::Index i = 0; i < rows_; ++i) {
            const double angle = shaft.angle[as_size(first_ + i)];
            // Least squares take its square: Hann over the angle. Rows are even in time, the speed makes them so in angle
            weights_(i) =
                std::sin(std::numbers::pi * (angle - begin) / (end - begin)) * std::sqrt(shaft.speed[as_size(first_ + i)]);
            A(i, 0) = weights_(i);
            Eigen::Index column = 1;
            for (size_t o = 0; o < orders.size(); ++o) {
                if (!is_resolved_[o]) continue;
                A(i, column++) = weights_(i) * std::cos(orders[o] * angle);
                A(i, column++) = -weights_(i) * std::sin(orders[o] * angle);
            }
        }
        if (A.rows() >= A.cols()) qr_.compute(A);
        is_solvable_ = A.rows() >= A.cols();
    }

    void solve(const std::vector<double>& channel, std::vector<std::complex<double>>& amplitudes) const {
        const auto values = Eigen::Map<const Eigen::VectorXd>(channel.data() + first_, rows_);
        Eigen::VectorXd parts;
        if (is_solvable_) parts = qr_.solve(weights_.cwiseProduct(values));
        Eigen::Index column = 1;
        for (const bool is_resolved : is_resolved_) {
            constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
            if (!is_resolved || !is_solvable_) {
                amplitudes.emplace_back(kNone, kNone);
                continue;
            }
            amplitudes.emplace_back(parts(column), parts(column + 1));
            column += 2;
        }
    }

private:
    Eigen::Index first_, rows_;
    std::vector<bool> is_resolved_;
    Eigen::VectorXd weights_;
    Eigen::HouseholderQR<Eigen::MatrixXd> qr_;
    bool is_solvable_ = false;
};

}  // namespace

double ShaftAngle::revolutions() const { return (angle.back() - angle.front()) / kRevolution; }

ShaftAngle shaft_angle(const std::vector<double>& channel, const std::string& name, const std::string& unit,
                       double interval) {
    ShaftAngle shaft;
    const size_t rows = channel.size();
    if (unit == "rad/s") {
        shaft.speed = channel;
        shaft.angle.push_back(0);
        for (size_t n = 1; n < rows; ++n)
            shaft.angle.push_back(shaft.angle.back() + 0.5 * interval * (channel[n - 1] + channel[n]));
    } else if (unit == "rad") {
        shaft.angle.push_back(channel.front());
        for (size_t n = 1; n < rows; ++n)
            shaft.angle.push_back(shaft.angle.back() + std::remainder(channel[n] - channel[n - 1], kRevolution));
        for (size_t n = 0; n < rows; ++n) {
            const size_t before = n > 0 ? n - 1 : 0, after = std::min(n + 1, rows - 1);
            shaft.speed.push_back((shaft.angle[after] - shaft.angle[before]) /
                                  (static_cast<double>(after - before) * interval));
        }
    } else {
        throw Error(ExitCode::usage,
                    fmt::format("--speed {}: its unit is {}; a shaft needs an angular velocity [rad/s] or an angle "
                                "[rad]",
                                quote(name), unit));
    }
    if (shaft.angle.back() < shaft.angle.front())
        for (std::vector<double>* values : {&shaft.angle, &shaft.speed})
            for (double& value : *values) value = -value;
    for (size_t n = 1; n < rows; ++n)
        if (!(shaft.angle[n] > shaft.angle[n - 1]))
            throw Error(ExitCode::usage,
                        fmt::format("--speed {}: the shaft stands still or turns back {:g} s after the start of the "
                                    "window; choose a window in which it turns one way with --from and --to",
                                    quote(name), static_cast<double>(n) * interval));
    return shaft;
}

double revolutions_per_block(const std::vector<double>& orders) {
    std::vector<double> sorted = orders;
    sorted.push_back(0);
    std::ranges::sort(sorted);
    double least = std::numeric_limits<double>::infinity();
    for (size_t i = 1; i < sorted.size(); ++i) least = std::min(least, sorted[i] - sorted[i - 1]);
    return 2 / least;
}

std::vector<OrderRow> track_orders(const std::vector<const std::vector<double>*>& channels, const ShaftAngle& shaft,
                                   const std::vector<double>& orders, double interval) {
    const double needed = revolutions_per_block(orders), there = shaft.revolutions();
    if (!(there >= needed))
        throw Error(ExitCode::usage,
                    fmt::format("--orders: the shaft turns {:.4g} times in the window, but these orders need {:.4g}; "
                                "take a longer window, or orders that are further apart",
                                there, needed));
    std::vector<OrderRow> rows;
    const double span = needed * kRevolution;
    const auto count = static_cast<size_t>(std::floor(2 * (there - needed) / needed * (1 + 1e-12))) + 1;
    for (size_t b = 0; b < count; ++b) {
        const double begin = shaft.angle.front() + 0.5 * static_cast<double>(b) * span;
        const Block block(shaft, orders, begin, begin + span, interval);
        OrderRow row;
        const double middle = begin + 0.5 * span;
        const auto after =
            std::min(as_size(std::ranges::lower_bound(shaft.angle, middle) - shaft.angle.begin()), shaft.angle.size() - 1);
        const size_t before = after > 0 ? after - 1 : 0;
        const double share =
            after == before ? 0 : (middle - shaft.angle[before]) / (shaft.angle[after] - shaft.angle[before]);
        row.time = (static_cast<double>(before) + share) * interval;
        row.speed = shaft.speed[before] + share * (shaft.speed[after] - shaft.speed[before]);
        for (const std::vector<double>* channel : channels) block.solve(*channel, row.amplitudes);
        rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace dttmm::host
