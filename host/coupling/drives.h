// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "dttmm_plugin.h"
#include "model/model.h"
#include "world/joint_system.h"

namespace dttmm::host {

/// The motors of a model's joints over time.
class Drives {
public:
    explicit Drives(const Model& model);

    bool empty() const { return is_empty_; }
    /// The first step takes the rate from points this many times nearer than its end.
    static constexpr double kNearer = 1024;
    /// Error of that rate for a motor that begins at rest, in a first step of size h. Differences leave at most 2/kNearer²
    /// of the mean speed over the step, for one that grows as t³; 5 % are added. Values round by some eps of themselves, at
    /// least of one: 1 - cos(w t) does, however small it is.
    static double rate_error(const Drive& drive, double h) {
        constexpr double kOfSpeed = 2.1 / (kNearer * kNearer), kOfValue = 1e-12;  // 1024 times 4.4 eps
        return kOfSpeed * std::abs(drive.speed) + kOfValue * std::max(1.0, std::abs(drive.end - drive.speed * h)) / h;
    }
    /// Of every joint around a step; zero where there is no motor. The first step has rate and acceleration by one-sided
    /// differences of second order, the others by central ones over the step size. Throws Error(numerical_failure)
    /// for an angle or a travel that is not finite or beyond 1e6.
    const std::vector<Drive>& around(const dttmm_step& step);
    /// At rest at an instant [s].
    const std::vector<Drive>& at(double time);

private:
    double value(const Joint& joint, double time) const;

    const std::vector<Joint>& joints_;
    bool is_empty_ = true;
    std::vector<Drive> drives_;
};

}  // namespace dttmm::host
