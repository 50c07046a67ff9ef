// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "analysis/json.h"
#include "analysis/realisation.h"
#include "analysis/recorded_run.h"
#include "analysis/request.h"
#include "analysis/shape_match.h"
#include "analysis/step_shift.h"

namespace dttmm::host {

/// The modes that `dttmm spectrum --identify` finds in a history, freed of the shift of the step where it is known.
class SpectrumModes {
public:
    /// moving: channels that are not constant.
    SpectrumModes(const Request& request, const RecordedRun& run, const std::vector<size_t>& moving, Warnings& warnings);

    /// identified.csv: a line per mode.
    std::string table() const;
    void print() const;
    Json describe() const;

private:
    void keep_strongest(size_t wanted);
    void undo_steps();
    void judge(const RecordedRun& run, int wanted, Warnings& warnings) const;
    double frequency(size_t i) const;
    double shift(size_t i) const;

    std::vector<Column> channels_;
    Identification found_;
    std::vector<StepShift> steps_;
    std::vector<std::complex<double>> true_rates_;  ///< s of the machine; s_h where the shift is not known
    std::vector<bool> is_shift_known_;
    std::vector<ModeMatch> matches_;  ///< empty without --modes
};

}  // namespace dttmm::host
