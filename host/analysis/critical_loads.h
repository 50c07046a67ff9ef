// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "coupling/modal_description.h"

namespace dttmm::host {

/// A load factor at which a motion begins to grow.
struct CriticalLoad {
    double factor;  ///< 0: a motion that nothing but the forces acts on grows however small they are
    /// Share of it by which rounding and forces that do not balance may change it at most; none: not known.
    std::optional<double> uncertainty;
    /// Share of it that the segments of beams leave, at most; none: not known.
    std::optional<double> segment_error = std::nullopt;
};

/// Ascending, and how far they were looked for.
struct CriticalLoads {
    std::vector<CriticalLoad> factors;
    double up_to = 0;
    std::string why_not_beyond;  ///< empty: up to the largest
};

/// Load factors at which motions of a machine at rest begin to grow, ascending: all its forces count so many times, with the
/// places and the stiffness that it has there. Each factor is enclosed by two counts. Looked for up to 1e9, or to within 2 %
/// of where forces are so large that a section cannot bear them or nothing can be counted beside them.
CriticalLoads find_critical_loads(ModalDescription resting, int wanted);

}  // namespace dttmm::host
