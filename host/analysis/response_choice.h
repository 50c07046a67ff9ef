// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "analysis/excitation.h"
#include "analysis/request.h"
#include "model/channel.h"

namespace dttmm::host {

/// The channels that `dttmm response` is asked for, as indices into `all`, the first of which is the frequency: those that
/// --out names, of a kind of response that --as names:
///     receptance     displacement and rotation per unit force or moment
///     mobility       velocities per unit force or moment
///     accelerance    accelerations per unit force or moment
///     transmissibility   displacement per displacement of a support, force of elements and joints per force; and the same
///                    of rotations and moments
/// With --as the patterns of --out may leave the quantity out: plate.z is plate.position.z, plate.rz is plate.rotation.z.
/// Throws Error(usage) for a kind that does not go with the inputs, Error(model_invalid) for a pattern that matches nothing.
std::vector<int> choose_response_channels(const Request& request, const std::vector<Channel>& all,
                                          const Excitation& excitation);

}  // namespace dttmm::host
