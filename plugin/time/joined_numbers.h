// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "time/supports.h"

namespace dttmm::plugin {

/// Where the host's numbers come together with those of the supports: these stand behind its bodies, and their blocks behind
/// its blocks. Without supports the host's own arrays serve.
class JoinedNumbers {
public:
    /// blocks: of all; seen_blocks: of the host. Keeps the supports.
    JoinedNumbers(const Supports& supports, uint32_t bodies, size_t blocks, size_t seen_blocks)
        : supports_(supports), bodies_(bodies), blocks_(blocks), seen_blocks_(seen_blocks) {
        if (supports.empty()) return;
        const size_t all = bodies_ + supports.count();
        motions_.resize(all);
        for (auto* list : {&numbers, &wrenches, &changes}) list->assign(6 * all, 0.0);
        for (auto* list : {&stiffness, &damping}) list->assign(36 * blocks, 0.0);
    }

    const dttmm_motion* with_supports(const dttmm_motion* of_bodies,
                                      void (Supports::*write)(std::span<dttmm_motion>) const) {
        if (supports_.empty()) return of_bodies;
        std::copy_n(of_bodies, bodies_, motions_.begin());
        (supports_.*write)(std::span(motions_).subspan(bodies_));
        return motions_.data();
    }
    /// Six numbers per body. of_supports: null: zero.
    const double* with_supports(const double* of_bodies, const double* of_supports) {
        if (supports_.empty()) return of_bodies;
        const auto behind = std::copy_n(of_bodies, 6 * bodies_, numbers.begin());
        if (of_supports)
            std::copy_n(of_supports, 6 * supports_.count(), behind);
        else
            std::fill(behind, numbers.end(), 0.0);
        return numbers.data();
    }

    /// Where the networks are to add wrenches, cleared; then hand_out() gives the host those of its bodies.
    double* wrenches_for(double* wrench) {
        if (supports_.empty()) return std::fill_n(wrench, 6 * bodies_, 0.0), wrench;
        std::ranges::fill(wrenches, 0.0);
        return wrenches.data();
    }
    void hand_out(double* wrench) const {
        if (!supports_.empty()) std::copy_n(wrenches.begin(), 6 * bodies_, wrench);
    }
    /// The same of a matrix; null: not wanted. own: stiffness or damping.
    double* blocks_for(double* matrix, std::vector<double>& own) const {
        if (!matrix) return nullptr;
        if (supports_.empty()) return std::fill_n(matrix, 36 * blocks_, 0.0), matrix;
        std::ranges::fill(own, 0.0);
        return own.data();
    }
    void hand_out(double* matrix, const std::vector<double>& own) const {
        if (matrix && !supports_.empty()) std::copy_n(own.begin(), 36 * seen_blocks_, matrix);
    }

    std::vector<double> numbers, wrenches, stiffness, damping, changes;  ///< of all; empty without supports

private:
    const Supports& supports_;
    size_t bodies_, blocks_, seen_blocks_;
    std::vector<dttmm_motion> motions_;
};

}  // namespace dttmm::plugin
