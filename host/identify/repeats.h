// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "identify/observations.h"
#include "record/warnings.h"

namespace dttmm::host {

/// Data of one channel (of one channel and input, of one mode) from several files are repeats of a test. Each set of
/// repeats becomes its mean, at the place of its first. Where neither the user nor the file gives the noise, it is that of
/// the mean: s/sqrt(n), s the scatter of n repeats. s is pooled over all samples of a history, over the lines around each
/// line of a response, over the logarithms of all frequencies. Throws Error(input_output) for repeats with other times,
/// frequencies or places of shapes, and for copies. Repeats of another size are warned of.
void join_repeats(Observations& observations, Warnings& warnings);

}  // namespace dttmm::host
