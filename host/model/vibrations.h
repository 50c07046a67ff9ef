// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "model/model.h"

namespace dttmm::host {

/// Harmonic and random loads and motions of a model that is to run: warns of those that are zero in a run. Throws
/// Error(model_invalid) for one that vibrates at no frequency that the model gives.
void check_vibrations(Model& model);

/// Takes harmonic and random loads and motions out of what acts for good: `Load::vibration` and `Node::vibrations` keep
/// them, and the signals they were become zero, their mean. Joints that vibrate by a motor are held, which is warned of.
void set_vibrations_aside(Model& model);

/// The end of a message about loads that are missed: what vibrates outside the load case that was chosen, where it does, and
/// the cure, `; load "fan" (m.toml:30:1) vibrates in case "noise"; choose ...`. Empty: nothing is left out.
std::string describe_left_out(const Model& model);

}  // namespace dttmm::host
