// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "analysis/adaptive_points.h"
#include "analysis/excitation.h"
#include "analysis/response_channels.h"
#include "analysis/response_plan.h"
#include "model/index.h"
#include "record/warnings.h"

namespace dttmm::host {

/// Channels of a machine in steady vibration as curves over frequency or speed: under unit inputs one after the other, or
/// under the loads of the model together; under each random load alone. `dttmm response` and `dttmm frf` have their rows
/// from here.
class ResponseCurves {
public:
    using Values = std::vector<std::complex<double>>;
    /// Takes a row: its values, a curve each.
    using Take = std::function<void(const OperatingPoint& at, const Values& values)>;

    /// chosen: indices into channels.all(). All arguments must outlive it.
    ResponseCurves(ModalMachine& machine, const ResponseChannels& channels, const Excitation& excitation,
                   std::vector<int> chosen, Warnings& warnings);

    /// Of a row: chosen channels of inputs one after the other, or of the loads; none if only random loads act.
    size_t size() const;
    /// "plate.position.z", with several inputs "plate.position.z/plate.corner1.z".
    std::string name(size_t curve) const;
    /// Of the channel, by inputs per unit of the input: "m/N", "1".
    std::string unit(size_t curve) const;
    const std::vector<int>& chosen() const { return chosen_; }
    const Channel& channel(size_t curve) const { return channels_.all()[as_size(chosen_[curve % chosen_.size()])]; }
    /// The kinds of a block: of the chosen channels, then of what tells how large things are in the machine.
    std::vector<AdaptivePoints::Kind> kinds() const;

    /// The curves of a row, then chosen channels under each random load of unit amplitude.
    Values evaluate(const OperatingPoint& at) { return channels_of(evaluate_blocks(at)); }
    /// The same in blocks of kinds(), one for each input, or one for the loads, and one for each random load; on a natural
    /// frequency that nothing damps a little beside it.
    Values evaluate_near(const ResponseSweep& sweep, double x);
    /// The first row: whether there is a response at all shows before anything is written.
    void try_first(const ResponseSweep& sweep);
    /// Takes all rows, ascending. False: it was stopped.
    bool find_rows(const ResponseSweep& sweep, bool shows_progress, const Take& take);

    /// Points of an adaptive sweep: of ten channels they take 40 MB.
    static constexpr size_t kMostAdaptive = 200'000;
    void warn_too_many();

private:
    std::map<double, Values> find_points(const ResponseSweep& sweep);
    Values evaluate_blocks(const OperatingPoint& at);
    Values channels_of(const Values& blocks) const;

    ModalMachine& machine_;
    const ResponseChannels& channels_;
    const Excitation& excitation_;
    std::vector<int> chosen_;
    Warnings& warnings_;
    bool with_forces_;
};

}  // namespace dttmm::host
