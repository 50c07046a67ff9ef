// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "analysis/excitation.h"
#include "analysis/request.h"
#include "loader/plugins.h"
#include "model/error.h"
#include "record/warnings.h"

namespace dttmm::host {

/// What one response found, as sweep.csv has it.
struct ResponseFindings {
    struct Largest {
        std::string name, unit;
        double size = 0, frequency = 0;  ///< [unit, Hz]
        OperatingPoint at = {};
        std::optional<double> rpm = {};           ///< of a response over speed
        bool is_peak = false;                     ///< between the ends of adaptive points: a peak moves with the machine
        std::optional<OperatingPoint> next = {};  ///< the largest peak beside it
    };
    struct Level {
        std::string name, unit;
        double rms = 0;
    };
    std::vector<Parameter> parameters;
    std::vector<Largest> largest;  ///< of every curve
    std::vector<Level> levels;     ///< of every channel, under random loads
    double highest = 0;            ///< frequency that was asked for [Hz]
};

/// Steady vibration over frequency or speed, under unit inputs or the harmonic and random loads of the model: complex
/// amplitudes of channels as response.csv, densities and RMS under random loads as psd.csv and rms.csv in the results
/// folder, the largest of each channel on the terminal.
ExitCode find_steady_response(const Request& request);
/// The same for a case of a sweep, which has the stop signals. ok, or the code of a stop.
ExitCode find_steady_response(const Request& request, const Plugins& plugins, Warnings& warnings, ResponseFindings& found);

}  // namespace dttmm::host
