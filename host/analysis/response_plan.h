// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <numbers>
#include <vector>

#include "analysis/excitation.h"
#include "analysis/request.h"
#include "record/warnings.h"

namespace dttmm::host {

/// One way through frequencies: those of a speed's order, or frequencies themselves.
struct ResponseSweep {
    std::vector<double> x;    ///< ascending: the points, or those that adaptive ones begin with; [Hz], of an order [rad/s]
    std::vector<double> own;  ///< ascending: frequencies of loads that act there alone, rows of their own [Hz]
    bool is_adaptive = false;
    bool is_speed = false;
    double order = 0;

    OperatingPoint at(double at) const;
};

/// What `dttmm response` is asked for.
struct ResponsePlan {
    std::vector<ResponseSweep> sweeps;
    double random_from = 0, random_to = 0;  ///< where random loads count [Hz]; equal: nowhere
    bool has_speeds = false;

    /// The highest frequency [Hz].
    double highest() const;

    /// Of the options and of what drives the machine, whose natural frequencies become points. Throws Error(usage) for
    /// options that do not go together, Error(model_invalid) for what the loads do not have.
    ResponsePlan(const Request& request, const Model& model, const Excitation& excitation, ModalMachine& machine,
                 Warnings& warnings);

private:
    void plan_speeds(const Request& request, const Model& model, const Excitation& excitation, ModalMachine& machine,
                     Warnings& warnings);
    void plan_frequencies(const Request& request, const Excitation& excitation, ModalMachine& machine, Warnings& warnings);
};

/// Ascending and above 0, up to `to` [Hz]. Where they are not found, or not all, a warning says so.
std::vector<double> natural_frequencies(ModalMachine& machine, double to, Warnings& warnings);

/// Speed of one turn per minute [rad/s].
inline constexpr double kPerRpm = std::numbers::pi / 30;

}  // namespace dttmm::host
