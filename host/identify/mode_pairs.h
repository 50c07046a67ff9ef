// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "identify/observations.h"

namespace dttmm::host {

/// The mode of the model that a measured one is.
struct ModePair {
    int mode = 0;          ///< counted from 1; 0: the model has too few
    double frequency = 0;  ///< [Hz]
    double mac = 0;        ///< |aᵀb|²/(aᵀa bᵀb); NaN: no shape was measured
    /// Of the model at the measured freedoms: the multiple of its shape, or the mixture of those of a multiple mode, nearest
    /// to the measured one; 0 if the mode does not move them. No shape was measured: that of the model.
    Eigen::VectorXd shape;
};

/// Pairs measured modes with those of the model, no mode twice: by their shapes, the most alike first; those without a
/// shape by their number. None has a mode at 0 Hz: there is no vibration to measure. frequencies: of the model, ascending
/// [Hz]. shapes: at the measured freedoms, a column per mode, which is 1 where it is largest in the machine.
std::vector<ModePair> pair_modes(const std::vector<ObservedMode>& measured, const std::vector<double>& frequencies,
                                 const Eigen::MatrixXd& shapes);

}  // namespace dttmm::host
