// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "measured/measurement.h"

namespace dttmm::host {

/// Reads a universal file:
///     58, 58b     functions, ASCII or IEEE binary of either byte order: see universal_function.h
///     55          modes: normal ones and complex ones of first and second order, three or six values per node.
///                 The frequency of a complex mode is |eigenvalue| / 2 pi, its damping ratio -Re / |eigenvalue|; one of
///                 negative frequency is taken as its conjugate. Of a normal mode the damping ratio is the viscous one,
///                 or else half of the hysteretic one; 0 is none. shape_names are "12.x" ... "12.rz". A component that is
///                 exactly 0 in every mode was not measured: it is left out
///     164         units: values behind it are made SI; lengths of shapes too
///     15, 2411    nodes: counted in a note
///     151         the head of the file: passed over
/// Every other data set is skipped, with a note per number. Lines end with LF or CR LF; texts are ASCII, UTF-8 or Latin-1.
/// Throws Error(input_output) with file and line, or file and byte behind binary data, for a file that is cut off, for a set
/// that breaks the rules of its format, and for a file without functions and modes. A set needs its end line; only a
/// function, whose size its head tells, may lack it, with a note.
Measurement read_universal(const std::filesystem::path& file);

}  // namespace dttmm::host
