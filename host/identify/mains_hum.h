// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "measured/measurement.h"

namespace dttmm::host {

/// The frequency by the clock of the file [Hz] of the mains hum in histories that one recorder took, within 5 % of
/// `nominal`: of the record in which its line stands out most. Records of unequal intervals, shorter than 50 periods, that
/// do not resolve it or hold NaN are passed over. Throws Error(input_output): no record is left; no line stands out (white
/// noise alone passes about one time in ten thousand); the line grows or dies away, as a vibration does;
/// records disagree.
double find_mains_hum(const std::vector<const MeasuredSignal*>& histories, double nominal);

/// The sine of this frequency [Hz] that is nearest to values at these times, in the sense of least squares.
Eigen::VectorXd fit_sine(std::span<const double> times, const Eigen::Ref<const Eigen::VectorXd>& values, double frequency);

}  // namespace dttmm::host
