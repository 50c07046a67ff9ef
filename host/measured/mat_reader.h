// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "measured/measurement.h"

namespace dttmm::host {

/// Reads the numeric variables of a MAT file (level 5, 7, 7.3), also those in structs, which are called "run.acc". What is
/// what, by names in which case does not matter and of which the last part counts ("run.Time" is Time):
///     abscissa   a real vector of n finite numbers that ascend, called t or time, with _s or _sec behind it or not: [s];
///                or f, freq or frequency, with _hz behind it or not: [Hz]
///     signals    every other variable whose first or last dimension is n; the abscissa of the nearest struct counts.
///                A column is a signal: "acc" of a vector, "acc(1)", "acc(2)" of columns, "H(2,1)" of three dimensions.
///                Over time a history. Over frequency a complex one is a response, a real one `other`; one that is called
///                coherence, coh or gamma2, or so behind a "_", is a coherence. At most 200000
///     modes      a real vector of natural frequencies [Hz], "freq" in its name, that is not evenly spaced, and a matrix
///                with a column per frequency and mode, shape, phi or psi in its name. shape_names are "phi(1)", "phi(2)"
///                by its rows. A vector as long with damp or zeta in its name: damping ratios. Modes have no numbers
/// A file that `dttmm export --mat` wrote says itself what its curves are: signals have the names and units of its channels.
/// Chars, cells, sparse matrices, objects of MATLAB classes (frd, ss) and numbers without an abscissa: named in notes, not
/// read. Points without a finite value are left out, with a note. Throws Error(input_output) as read_mat_arrays() does, and
/// for a file without signals and modes: the message lists its variables.
Measurement read_mat(const std::filesystem::path& file);

}  // namespace dttmm::host
