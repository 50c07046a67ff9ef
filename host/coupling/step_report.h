// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace dttmm::host {

/// How the end of a step was found, by its last pass. Corrections are the largest speeds of a point [m/s].
struct StepReport {
    uint64_t step = 0;  ///< from 0
    double time = 0;    ///< of its start [s]
    int passes = 0;
    int factorisations = 0, inside_factorisations = 0;  ///< of the bodies' matrix, of those of the plugins' parts
    double correction = 0;                              ///< of the bodies
    double residual = 0;                                ///< momentum that lacked in one before that correction [N s]
    double inside_correction = 0;                       ///< of the plugins' parts
    double inside_residual = 0;                         ///< momentum that lacked in one of them before that correction [N s]
    double rate = 0;  ///< largest ratio of the last two corrections, of bodies or parts; 0: not measured
    int stops = 0;    ///< of joints that act
    /// What the last pass but one was not enough for, a body before a part; -1: there is none, or it is of the other kind.
    int body = -1, part = -1;
};

}  // namespace dttmm::host
