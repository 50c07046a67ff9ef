// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "identify/unknowns.h"
#include "model/index.h"

namespace dttmm::host {

/// Elements that may have changed, each by a factor of its stiffness and perhaps one of its damping.
struct Suspects {
    std::vector<std::string> names;
    std::vector<bool> are_damped;

    size_t size() const { return names.size(); }
    size_t damped_count() const { return as_size(std::ranges::count(are_damped, true)); }
    bool is_damped(const std::string& name) const {
        return are_damped[as_size(std::ranges::find(names, name) - names.begin())];
    }
    /// The common unknowns, then the factors of stiffness of elements, then those of damping. are_alike: they share one
    /// of each.
    Unknowns unknowns(const Unknowns& common, const std::vector<std::string>& elements, bool are_alike,
                      bool with_damping) const;
};

}  // namespace dttmm::host
