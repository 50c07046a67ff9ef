// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analysis/modal_machine.h"
#include "analysis/request.h"
#include "loader/plugins.h"
#include "measured/measurement.h"
#include "model/model.h"
#include "record/warnings.h"

namespace dttmm::host {

/// A standard deviation as a user gives it, or none.
struct NoiseLevel {
    double share = 0;     ///< of the largest value; 0: not given so
    double absolute = 0;  ///< SI; 0: not given so
    bool is_known() const { return share > 0 || absolute > 0; }
};

/// A channel that was measured over time, in SI and with the sign of the model.
struct ObservedHistory {
    std::string channel;
    std::string unit;
    std::vector<double> times;  ///< by the clock of the model, without the channel's own delay [s]
    std::vector<double> values;
    double noise = 0;  ///< standard deviation; 0: not known
    bool is_noise_of_user = false;
    size_t noise_samples = 0;  ///< that a noise of the data was estimated from
    double hum = 0;            ///< of the mains, by the clock of the model; 0: none is sought [Hz]
    std::string place = {};    ///< "blow.csv: column 3", for messages
};

/// The response of a channel to one input.
struct ObservedResponse {
    std::string channel, input;  ///< "plate.corner2.acceleration.z", "plate.corner1.z"
    std::string unit;            ///< of the channel per unit of the input
    std::vector<double> frequencies;
    std::vector<std::complex<double>> values;
    std::vector<double> deviations;  ///< of real and imaginary part, from coherence or repeats; empty: not known
    double noise = 0;                ///< the same of all; 0: not known
    size_t noise_samples = 0;        ///< differences that deviations were estimated from; 0: they are known
    bool is_real = false;            ///< the file gives no imaginary part: it is not compared
    std::string place = {};          ///< "blow.uff: record 3", for messages
};

/// A place and direction of a shape.
struct ObservedFreedom {
    std::string place;
    int direction = 0;
};

struct ObservedMode {
    double frequency = 0;    ///< [Hz]
    double deviation = 0;    ///< of the logarithm of the frequency; 0: not known
    double damping = 0;      ///< NaN: not known
    int number = 0;          ///< among the model's modes where no shape tells it; 0: not known
    int row_of_number = 0;   ///< how many modes of its file before it have this number
    Eigen::VectorXd shape;   ///< at Observations::freedoms, largest 1; NaN: not measured; empty: none
    std::string place = {};  ///< "modes.csv:3", for messages
};

/// Measured data as a model has them.
struct Observations {
    std::vector<ObservedHistory> histories;
    std::vector<ObservedResponse> responses;
    std::vector<ObservedMode> modes;
    std::vector<ObservedFreedom> freedoms;
    std::vector<std::string> files;
    double clock = 1;                    ///< true time per time of the files
    size_t frequency_samples = 0;        ///< differences that the noise of frequencies was estimated from
    bool are_frequencies_known = false;  ///< the noise of frequencies comes from the file or the user

    /// Channels and responses, for gains.
    std::vector<std::string> channel_names() const;
    bool is_empty() const { return histories.empty() && responses.empty() && modes.empty(); }
};

/// Reads the files that the request or the model names, and finds out what each column is in the model: a channel of the
/// same name, or what --map or [measured] says. Data of one channel from several files are repeats: see join_repeats. Throws
/// Error: usage for a map that names no column, two columns for one channel, a channel that the model does not have;
/// input_output for units that measure something else, data that are constant. Columns that are nothing in the model are
/// left out, with a note.
Observations read_observations(const Request& request, const Model& model, const Plugins& plugins, Warnings& warnings);

/// "1 %" or "0.05 m/s^2" in the SI unit `unit`. Throws Error(usage), with `option` before it.
NoiseLevel read_noise(const std::string& text, const std::string& unit, const std::string& option);

}  // namespace dttmm::host
