// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "model/model.h"

namespace dttmm::host {

/// How a number scatters from case to case, of a parameter in SI.
struct Distribution {
    enum class Kind : unsigned char { normal, lognormal, uniform, list };
    Kind kind = Kind::uniform;
    double mean = 0, deviation = 0;   ///< of normal and lognormal: of the value itself, not of its logarithm
    double low = 0, high = 0;         ///< of uniform
    std::vector<double> values = {};  ///< of a list: equally likely

    /// The value that a case falls below with this probability, 0 < probability < 1; of a list the value that stands there.
    double quantile(double probability) const;
};

/// Parameters that scatter alike, each for itself: one --vary.
struct Variation {
    std::vector<std::string> names;
    Distribution distribution;
};

/// "k1..k4 ~ normal(500 N/mm, 10 %)": names parted by commas, as ranges of numbers or with * and ?; then one of
///     normal(mean, deviation)     lognormal(mean, deviation)     the deviation with a unit, or in % of the mean
///     uniform(low, high)          list(value, value, ...)
/// Throws Error(usage) for a wrong form, a parameter that `parameters` has not, a value without the unit that the file gives
/// or of another dimension, a deviation or range that is not positive, a lognormal mean that is not.
Variation parse_variation(const std::string& text, const std::vector<Parameter>& parameters);

/// The names that a text means: "k1..k4, c*". Throws Error(usage), with `option` before the fault.
std::vector<std::string> parameter_names(const std::string& text, const std::vector<Parameter>& parameters,
                                         const std::string& option);

}  // namespace dttmm::host
