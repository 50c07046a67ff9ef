// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <set>
#include <string>
#include <vector>

#include "analysis/json.h"
#include "record/column.h"
#include "record/csv_file.h"

namespace dttmm::host {

struct Curve {
    Column head;
    std::vector<double> values;  ///< in the unit of the head; NaN where there is none
    std::vector<double> phases;  ///< [deg]; empty: it is no amplitude of a vibration
    /// The same as complex numbers, to the bit those of the file where it has real and imaginary parts.
    std::vector<std::complex<double>> complex_values = {};
};

/// Curves over one quantity.
struct CurveSet {
    std::string file;   ///< where they stand
    std::string label;  ///< of the set among those of the file, "order 2"; or empty
    Column x;
    std::vector<double> places;  ///< values of x, ascending
    std::vector<Curve> curves;
};

/// The names of all curves that a pattern selects, as --channels does. Throws Error(usage) for a pattern without a curve;
/// the message begins with the option that has the patterns, "--channels: ", if it is one.
std::set<std::string> choose_names(const std::vector<CurveSet>& sets, const std::vector<std::string>& patterns,
                                   const std::string& option = {});

/// Rows of a curve that stand for all: for every span of rows that of the least and that of the largest value, in their
/// order. The spans are as equal as can be. Where there are at most `most` rows, all of them.
std::vector<std::size_t> thin(const std::vector<double>& values, std::size_t most);

/// As the page reads it. A curve has at most `most` points: of more rows those of thin(). They are drawn at the beginning
/// and in the middle of their span, so that all curves have the same places; "span" is the rows of a span, 1 if all rows are
/// there. Every curve has its least, largest and last value with their places, from all rows. A constant curve is one value.
Json describe(const CurveSet& set, std::size_t most);

/// Of a table over frequency, speed or time: all numbers from column `first` on as curves over column `x`, or, if x is -1,
/// over the number of the row among `rows`, called "case". Columns "<name>.re" and "<name>.im" are one curve of the
/// magnitude with its phase; "<name>.phase" is the phase of "<name>.amplitude". rows: those of the table that count.
CurveSet curves_of(const CsvFile& file, int x, std::size_t first, const std::vector<std::size_t>& rows);

}  // namespace dttmm::host
