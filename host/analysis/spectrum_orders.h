// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "analysis/order_tracking.h"
#include "analysis/recorded_run.h"
#include "analysis/request.h"

namespace dttmm::host {

/// The orders that `dttmm spectrum --orders` tracks in a run-up or run-down.
class SpectrumOrders {
public:
    /// moving: channels that are not constant.
    SpectrumOrders(const Request& request, const RecordedRun& run, const std::vector<size_t>& moving, Warnings& warnings);

    /// orders.csv: a line per block of revolutions.
    std::string table() const;
    void print() const;
    Json describe() const;

private:
    struct Largest {
        double amplitude = 0, speed = 0;
    };
    Largest largest(size_t column) const;
    std::string name(size_t column) const;
    const std::string& unit(size_t column) const { return channels_[column / orders_.size()].unit; }

    std::vector<Column> channels_;
    std::vector<double> orders_;
    double start_ = 0;  ///< of the window [s]
    std::vector<OrderRow> rows_;
};

}  // namespace dttmm::host
