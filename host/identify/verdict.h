// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "analysis/json.h"
#include "identify/identification.h"

namespace dttmm::host {

/// What an identification says, in sentences; the first is the answer.
std::vector<std::string> make_verdict(const Identification& found, const Comparison& comparison, const Unknowns& unknowns);

/// One text of them, each with its full stop.
std::string join_sentences(const std::vector<std::string>& sentences);

/// "k1 = 412300 N/m (409000 to 415500)"; "k1 is not fixed by the data".
std::string describe_value(const Solution& solution, const Unknowns& unknowns, size_t i);

/// Where the noise of the data comes from, a sentence.
std::string describe_noise(const Comparison& comparison);
/// Of every group: name, noise, source.
Json describe_groups(const Comparison& comparison);
/// chi2, points and what they say.
Json describe_fit(const Fit& fit);
/// Sentences on what limits a fit: noise that was assumed or estimated, offsets, correlation. They stand behind a verdict.
std::vector<std::string> describe_limits(const Fit& fit);
/// That the limits of these were not found. They stand behind a verdict.
std::string describe_rough_limits(const std::vector<std::string>& names);
/// That the time step shifts unknowns by more than their intervals allow; empty: it does not.
std::string describe_step(const Eigen::VectorXd& bias, const Solution& solution, const Unknowns& unknowns, double step);
/// "chi2 5189 for 4004 points, 1.3 % of the largest value left"; and that residuals are correlated, where they are.
std::string describe_chi2(const Fit& fit);

}  // namespace dttmm::host
