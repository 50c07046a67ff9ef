// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "model/model.h"
#include "step/simulation.h"

namespace dttmm::host {

/// What a step does to the motion that a load makes. A step weights a load by w+ at its end, w0 at its start, w− one step
/// earlier. The displacement of a free mass under a harmonic load of circular frequency ω is then the exact one times
///     |w+ e^{iωh} + w0 + w− e^{−iωh}| (a/sin a)²,  a = ωh/2:
/// with the weights 1/4, 1/2, 1/4 of the implicit coupling (a/tan a)², too small; with the 0, 1, 0 of the explicit one too
/// large. (Accelerations are those of the instant: that of a free mass is exact.)
/// Returns the departure from one, −1 from two steps per period on.
double compute_load_error(const double weights[3], double omega_h);

/// The parts of a signal over `duration` [s]: in closed form where its shape knows them, else by its spectrum. That is taken
/// of at least 16 samples per step, up to 2^18 samples, of the signal and its mirror image: the mirrored signal has no jump
/// at its ends, so it needs no window, which would hide what happens at the start. Only parts above 1 % of the largest: a
/// smaller part cannot cost 1 % of the load. A part that lasts a short part of the duration only is small in the spectrum.
std::vector<SignalPart> find_parts(const Signal& signal, double duration, double step);

/// A load, or the motion of a support or a motor, which acts on what follows it as a load does: through elements, with the
/// same weights.
struct Acting {
    std::string place, name;  ///< "model.toml:24:1", "load number 1"
    std::vector<SignalPart> parts;
};
/// All of a model over its duration; of a force per length the parts at both ends.
std::vector<Acting> find_acting(const Model& model, double step);

/// The error of the part that costs most: the largest |share · compute_load_error|.
double compute_largest_error(const std::vector<SignalPart>& parts, const double weights[3], double step);

/// A load or motion with a part that is too fast for the step.
struct FastLoad {
    std::string place, name;
    double frequency = 0;  ///< of the part that suffers most [Hz]
    double error = 0;      ///< of the load's effect, as a share of its largest part; negative: too small
    double step = 0;       ///< at which it would be 1 % or less [s]; divides the present step
};

/// The loads and motions whose effect is in error by more than `tolerable` [1] at the simulation's step.
std::vector<FastLoad> find_fast_loads(const Model& model, const Simulation& simulation, double tolerable);

/// The effect of a load may be in error by this much without a word. It is the tolerance of a run without a step.
inline constexpr double kTolerableLoadError = 0.01;
/// In a run to a tolerance. Extrapolation removes the error in h²; at a tenth (10 steps per period) the longer step of the
/// two runs has 5 steps per period, and the error no longer follows h².
inline constexpr double kTolerableExtrapolatedError = 0.1;

/// "model.toml:24:1: load number 1 has a part at 200 Hz, 5 steps per period: at a step of 0.001 s its effect is about 35 %
/// too small; use --step "0.000125 s" for 1 %".
std::string describe(const FastLoad& fast, double step);

/// The largest step that is short enough among those that divide `step` into 1, 2, 4, 5, 8, 10, 20, ... parts: it then
/// divides duration and output step as well, and is short to write.
double divide_step(double step, const std::function<bool(double)>& is_short_enough);
/// The same for steps up to `longest` [s].
double divide_step(double step, double longest);

}  // namespace dttmm::host
