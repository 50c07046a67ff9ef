// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "modal/dynamic_stiffness.h"

namespace dttmm::plugin {

/// Damping that belongs to natural modes, not to elements: C = Σ M φ 2 ζ ω φᵀ M, with shapes φ of modal mass 1.
struct ModalDamping {
    std::vector<FrameVector> momenta;  ///< M φ of every mode that is damped, on the frames of one cut
    std::vector<double> rates;         ///< 2 ζ ω [1/s]
    double cut = 0;                    ///< of the lines [rad/s]
};

/// Which modes, by frequency, rigid-body modes and those that grow left out.
struct DampingRatios {
    std::vector<double> ratios;  ///< ζ of the first vibrations
    bool is_of_all = false;      ///< ratios has one number, that of all vibrations up to `below`
    double below = 0;            ///< [rad/s]
};

/// Cuts D for `least` [rad/s] or finer, as the modes want it. Throws what ModeFinder does.
ModalDamping find_modal_damping(DynamicStiffness& D, const DampingRatios& given, double least);

}  // namespace dttmm::plugin
