// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "identify/observations.h"
#include "record/warnings.h"

namespace dttmm::host {

/// Data of one channel (of one channel and input, of one number of a mode) from several files are repeats of a test. Each
/// set of repeats becomes its mean, at the place of its first. Where the user does not give the noise (of frequencies: nor
/// the files), it is s/sqrt(n) for the mean, s the scatter of n repeats. s is pooled: over all samples of a history, beside
/// the hum; over at least 20 differences around each line of a response; over the logarithms of all frequencies.
/// noise_samples says how many differences there were. Throws Error(input_output) for repeats with other times,
/// frequencies or places of shapes, for other modes, and for copies. Histories of another size are warned of.
void join_repeats(Observations& observations, Warnings& warnings);

}  // namespace dttmm::host
