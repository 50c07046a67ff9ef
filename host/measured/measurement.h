// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <filesystem>
#include <string>
#include <vector>

namespace dttmm::host {

/// Numbers over time or over frequency as a file has them: nothing is known yet of what they are in a model.
struct MeasuredSignal {
    enum class Kind : unsigned char { history, response, coherence, other };
    Kind kind = Kind::other;
    std::string name;                  ///< of the column; in a universal file of node and direction: "12.z", "12.rz"
    std::string title = {};            ///< what else the file calls it, without its unit; empty: nothing
    std::string reference = {};        ///< of a response: what drives it, named alike
    std::string unit = {};             ///< of the values, as the file writes it; empty: it gives none
    std::string reference_title = {};  ///< what else the file calls what drives it; empty: nothing
    std::string reference_unit = {};   ///< of a response whose unit is given in two parts
    bool is_reversed = false;          ///< counts against the direction that `name` says
    std::vector<double> abscissa;      ///< [s] or [Hz]
    std::vector<double> values;        ///< in `unit`; of a response the real part
    std::vector<double> imaginary;     ///< of a response; empty: real
    std::string place;                 ///< "blow.csv: column 3", for messages
};

/// A mode that was identified from a measurement.
struct MeasuredMode {
    double frequency = 0;                          ///< [Hz]
    double frequency_deviation = 0;                ///< standard deviation [Hz]; 0: the file gives none
    double damping = 0;                            ///< damping ratio; NaN: the file gives none
    int number = 0;                                ///< counted from 1, as the file numbers it; 0: it does not
    std::vector<std::complex<double>> shape = {};  ///< at Measurement::shape_names; NaN where the file gives nothing
    std::string place = {};                        ///< "modes.csv:3", for messages
};

/// A file of measured data.
struct Measurement {
    std::string format;  ///< "CSV", "universal file", "MAT file"
    std::vector<MeasuredSignal> signals;
    std::vector<MeasuredMode> modes;
    std::vector<std::string> shape_names;  ///< places and directions of the shapes: "floor1.x", "12.z"
    std::vector<std::string> notes;        ///< what of the file was not used, and what was repaired
};

}  // namespace dttmm::host
