// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <complex>
#include <span>
#include <vector>

#include "modal/dynamic_stiffness.h"

namespace dttmm::plugin {

using Complex = std::complex<double>;
using Complex6 = Eigen::Matrix<Complex, 6, 1>;

/// Damping that belongs to natural modes, not to elements: C = Σ M φ 2 ζ ω φᵀ M, with shapes φ of modal mass 1. Where
/// supports move, its forces are C times the velocity against the place to which the supports would bring the machine at
/// rest: a machine that moves with its supports as a rigid body is not damped.
struct ModalDamping {
    std::vector<FrameVector> momenta;  ///< M φ of every mode that is damped, on the frames of one cut
    std::vector<double> rates;         ///< 2 ζ ω [1/s]
    double cut = 0;                    ///< of the lines [rad/s]
    /// φᵀ M u of every mode that is damped and every node of the network, u the motion at rest by a unit motion of the node
    /// in each of its fixed directions, else 0; empty: not asked for yet.
    std::vector<std::vector<Complex6>> followed = {};
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
