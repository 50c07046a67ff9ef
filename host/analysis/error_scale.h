// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "coupling/stability.h"
#include "model/model.h"
#include "record/recorder.h"

namespace dttmm::host {

/// What the error of each channel is measured against: the largest value of its kind in the whole machine, never its own,
/// for a component that is zero but for rounding would never converge against itself. Kinds that a length turns into each
/// other share one scale; L [m] is the diagonal of the box around all bodies and markers at the start, at least twice a
/// radius of gyration:
///
///     positions, deflections, L x (rotations, quaternions)     the widest range of values over the run
///     velocities, L x angular velocities                       the largest magnitude, as in all kinds below
///     accelerations
///     forces, moments/L
///     energies
///     anything else a plugin records                           by its unit
///
/// Below these even the largest is taken for rounding, with ρ = max(1e-9 of the widest range, 1e-12 of the largest
/// coordinate), the step h, the largest mass m and the fastest vibration ω: ρ, ρ/h, ρ/h², m ω² ρ, m (ω² + 1/h²) ρ².
///
/// A machine that moves by less than 1e-11 of the largest coordinate rests. What moves it is rounding, however short the
/// step. In a run to a tolerance ρ is then that length over the tolerance, and only forces that change by themselves count.
///
/// `seen`: every channel over a run at the step h. Returns one scale per channel, in its unit; the time's is without
/// meaning.
std::vector<double> error_scales(const Model& model, const FastestMode& fastest, const Recorder& seen, double h);

}  // namespace dttmm::host
