// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "measured/measurement.h"

namespace dttmm::host {

/// The frequency by the clock of the file [Hz] of the mains hum in histories that one recorder took, within 5 % of
/// `nominal`: of the record in which its line stands out most. Throws Error(input_output): no history; no line that noise
/// alone would not show (one chance in a million); a line that grows or dies away, as a vibration does; a record of unequal
/// intervals, or shorter than 25 periods.
double find_mains_hum(const std::vector<const MeasuredSignal*>& histories, double nominal);

/// The sine of this frequency [Hz] that is nearest to values at these times, in the sense of least squares.
Eigen::VectorXd fit_sine(std::span<const double> times, const Eigen::Ref<const Eigen::VectorXd>& values, double frequency);

}  // namespace dttmm::host
