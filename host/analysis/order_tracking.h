// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <string>
#include <vector>

namespace dttmm::host {

/// The angle that a shaft has turned [rad], ascending, and its speed [rad/s], one per row.
struct ShaftAngle {
    std::vector<double> angle, speed;

    double revolutions() const;
};

/// From an angular velocity [rad/s], by the trapezoidal rule, or from an angle [rad] that may jump by a full turn. A shaft
/// that turns backwards all the time counts forwards. Throws Error(usage) for another unit and for a shaft that stops or
/// turns back.
ShaftAngle shaft_angle(const std::vector<double>& channel, const std::string& name, const std::string& unit,
                       double interval);

/// Amplitudes of orders about one instant: the channel is the sum of Re(amplitude e^(i order angle)).
struct OrderRow {
    double time = 0;   ///< from the first row [s]
    double speed = 0;  ///< [rad/s]
    std::vector<std::complex<double>>
        amplitudes;  ///< of each channel in turn; NaN where rows are too far apart for an order
};

/// Revolutions of a block: two over the least distance of orders, or of zero, so that a Hann window parts them.
double revolutions_per_block(const std::vector<double>& orders);

/// Least squares of all orders and a mean together, over blocks of angle that overlap by half, weighted by a Hann window: a
/// discrete Fourier transform at the orders that varies in time. Throws Error(usage) for a shaft that does not turn through
/// a block. Known as TVDFT with orthogonality compensation.
std::vector<OrderRow> track_orders(const std::vector<const std::vector<double>*>& channels, const ShaftAngle& shaft,
                                   const std::vector<double>& orders, double interval);

}  // namespace dttmm::host
