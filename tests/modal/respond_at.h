// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "modal/modal_analysis.h"

namespace dttmm::plugin {

/// Displacement of all nodes, 12 each, per unit of a wrench on one of them.
inline std::vector<double> respond_at(ModalAnalysis& analysis, double hertz, int node, const Vector6& wrench, size_t count) {
    dttmm_harmonic load{-1, node, {}, {}, 0};
    for (size_t d = 0; d < 6; ++d) load.wrench[2 * d] = wrench(as_row(d));
    const std::array loads = {load};
    const std::array<std::span<const dttmm_harmonic>, 1> cases = {loads};
    std::vector<double> nodes(12 * count);
    analysis.respond(hertz, cases, {nullptr, nodes.data(), nullptr, nullptr});
    return nodes;
}

}  // namespace dttmm::plugin
