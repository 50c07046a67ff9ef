// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <functional>
#include <vector>

#include "analysis/adaptive_points.h"
#include "analysis/excitation.h"

namespace dttmm::host {

/// What random loads, independent of each other, do to channels.
struct RandomResponse {
    /// One-sided densities of the channels at a frequency [unit²/Hz]. Where a load begins or ends two rows may have one
    /// frequency: from the left and from the right.
    struct Row {
        double frequency;
        std::vector<double> densities;
    };
    std::vector<Row> rows;
    std::vector<double> rms;             ///< of every channel
    std::vector<double> zero_crossings;  ///< of every channel, upward per second
    std::vector<double> unbounded;       ///< frequencies at which nothing damps a channel: RMS values have no bound
    bool is_done = false;                ///< else it was stopped, or there were too many points
};

/// Amplitudes of the channels, and of what tells how large things are, under each random load of unit amplitude, one load
/// after the other, at a frequency [Hz].
using RandomAmplitudes = std::function<std::vector<std::complex<double>>(double frequency)>;

/// From `from` to `to` [Hz]; natural: frequencies that become points. kinds: of the amplitudes under one load; those that
/// are drawn come first and are the channels. Between the corners of the densities |H| √S is drawn by straight lines good to
/// 1 %, and its square is integrated by Simpson's rule.
RandomResponse find_random_response(const Excitation& excitation, double from, double to, const std::vector<double>& natural,
                                    const RandomAmplitudes& amplitudes, const std::vector<AdaptivePoints::Kind>& kinds,
                                    size_t most_points, const std::function<bool()>& is_asked_to_stop);

}  // namespace dttmm::host
