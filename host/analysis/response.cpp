// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/response.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "analysis/modal_session.h"
#include "analysis/random_response.h"
#include "analysis/response_curves.h"
#include "analysis/response_machine.h"
#include "analysis/response_plan.h"
#include "analysis/stop_signals.h"
#include "analysis/summary.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/channels.h"
#include "record/csv_table.h"
#include "record/csv_writer.h"
#include "record/progress_bar.h"
#include "record/results_folder.h"
#include "record/tell.h"

namespace dttmm::host {

namespace {

using Values = ResponseCurves::Values;

constexpr size_t kShown = 40;  ///< channels on the terminal

/// What one response has to do and what it found.
class SteadyResponse {
public:
    SteadyResponse(const Request& request, const Plugins& plugins, Warnings& warnings)
        : request_(request),
          plugins_(plugins),
          warnings_(warnings),
          machine_(request, plugins, warnings),
          plan_(request, machine_.session.model, machine_.excitation, machine_.session.machine, warnings) {
        machine_.session.machine.damp(plan_.highest());
        note_damping(machine_.session.model, warnings);
        note_forces_of_damping(machine_.session.model, warnings);
    }

    ExitCode run(ResponseFindings* findings);

private:
    /// Of one channel under one input, or under the loads.
    struct Largest {
        double size = 0, phase = 0;
        OperatingPoint at;
        bool is_peak = false;  ///< see ResponseFindings
    };
    /// The two largest peaks of a curve, between rows that ascend.
    struct Peaks {
        struct One {
            double size = 0;
            OperatingPoint at = {};
            bool is_inside = false;
        };
        One first, second, last;
        double before = 0;  ///< the size of the row before the last one

        void take(const One& row) {
            if (last.is_inside && last.size > before && last.size >= row.size) {
                if (last.size > first.size)
                    second = std::exchange(first, last);
                else if (last.size > second.size)
                    second = last;
            }
            before = last.size;
            last = row;
        }
        /// The largest one that is not this.
        const One& beside(double size) const { return first.size == size ? second : first; }
    };

    bool write_rows(const ResultsFolder& folder, size_t& rows);
    size_t write_random(const ResultsFolder& folder);
    std::vector<Column> columns() const;
    void keep_largest(const ResponseSweep& sweep, const OperatingPoint& at, const Values& values);
    void tell_still();
    void print(const ResultsFolder& folder, size_t rows) const;
    void write_summary(const ResultsFolder& folder, size_t rows, bool is_stopped);
    ResponseFindings findings() const;

    const Request& request_;
    const Plugins& plugins_;
    Warnings& warnings_;
    ResponseMachine machine_;
    ResponsePlan plan_;
    std::vector<Largest> largest_;
    std::vector<Peaks> peaks_;
    std::vector<double> rms_;  ///< of the chosen channels
};

void SteadyResponse::keep_largest(const ResponseSweep& sweep, const OperatingPoint& at, const Values& values) {
    const double x = at.speed.value_or(at.frequency);
    const bool is_inside = sweep.is_adaptive && !at.has_own && x > sweep.x.front() && x < sweep.x.back();
    for (size_t c = 0; c < largest_.size(); ++c) {
        if (!at.has_own) peaks_[c].take({std::abs(values[c]), at, is_inside});
        if (std::abs(values[c]) > largest_[c].size)
            largest_[c] = {std::abs(values[c]), std::arg(values[c]) * 180 / std::numbers::pi, at, is_inside};
    }
}

std::vector<Column> SteadyResponse::columns() const {
    std::vector<Column> columns = {{"frequency", "Hz"}};
    if (plan_.has_speeds) {
        columns.push_back({"rpm", "rpm"});
        columns.push_back({"order", "1"});
    }
    for (size_t c = 0; c < machine_.curves.size(); ++c)
        for (const char* part : {".re", ".im"}) columns.push_back({machine_.curves.name(c) + part, machine_.curves.unit(c)});
    return columns;
}

/// psd.csv and rms.csv. Returns the rows of psd.csv.
size_t SteadyResponse::write_random(const ResultsFolder& folder) {
    const std::vector<AdaptivePoints::Kind> kinds = machine_.curves.kinds();
    const size_t count = machine_.curves.chosen().size(), skipped = machine_.excitation.has_harmonics() ? kinds.size() : 0;
    const auto amplitudes = [&](double f) {
        Values values = machine_.curves.evaluate_near(ResponseSweep(), f);
        values.erase(values.begin(), values.begin() + as_row(skipped));
        return values;
    };
    const RandomResponse random =
        find_random_response(machine_.excitation, plan_.random_from, plan_.random_to,
                             natural_frequencies(machine_.session.machine, plan_.random_to, warnings_), amplitudes, kinds,
                             ResponseCurves::kMostAdaptive, StopSignals::requested);
    if (StopSignals::requested()) return 0;
    if (!random.is_done) {
        machine_.curves.warn_too_many();
        warnings_.add("no-rms", "RMS values are not found, there is no psd.csv");
        return 0;
    }
    for (const double f : random.unbounded)
        warnings_.add("unbounded-peak", fmt::format("nothing damps the motion at {:.6g} Hz: RMS values have no bound", f));
    std::vector<Column> columns = {{"frequency", "Hz"}};
    CsvTable table({{"channel", ""}, {"unit", ""}, {"rms", ""}, {"three_sigma", ""}, {"zero_crossings", "1/s"}});
    for (size_t c = 0; c < count; ++c) {
        const Channel& channel = machine_.curves.channel(c);
        columns.push_back({channel.name(), fmt::format("({})^2/Hz", channel.unit())});
        const double rms = random.rms[c], crossings = random.zero_crossings[c];
        table.add(channel.name()).add(channel.unit()).add(rms).add(3 * rms).add(crossings).end_row();
        if (!request_.quiet && c < kShown)
            fmt::print("{:<32} RMS {:>11.5g} {}, 3 sigma {:.5g}, {:.4g} upward zero crossings per second\n", channel.name(),
                       rms, channel.unit(), 3 * rms, crossings);
    }
    if (!request_.quiet && count > kShown) fmt::print("and {} more in rms.csv\n", count - kShown);
    rms_ = random.rms;
    write_atomically(folder.file("rms.csv"), table.text());
    CsvWriter rows(folder.file("psd.csv"), columns);
    std::vector<double> row;
    for (const RandomResponse::Row& one : random.rows) {
        row.assign(1, one.frequency);
        row.insert(row.end(), one.densities.begin(), one.densities.end());
        rows.write_row(row);
    }
    rows.finish();
    return random.rows.size();
}

/// Channels that were asked for and stay zero.
void SteadyResponse::tell_still() {
    std::vector<std::string> still;
    for (size_t c = 0; c < largest_.size(); ++c)
        if (largest_[c].size == 0) still.push_back(machine_.curves.name(c));
    if (still.empty()) return;
    warnings_.add(
        "no-response",
        fmt::format("{}: zero at all frequencies: what drives the machine does not reach {}, or the element cannot "
                    "carry it",
                    listed(still), still.size() == 1 ? "it" : "them"));
}

void SteadyResponse::print(const ResultsFolder& folder, size_t rows) const {
    if (request_.quiet) return;
    size_t width = 10;
    for (size_t c = 0; c < std::min(kShown, largest_.size()); ++c) width = std::max(width, machine_.curves.name(c).size());
    if (!largest_.empty())
        fmt::print("{:<{}}  {:>12}  {:<12} {:>12} {}{:>9}\n", "largest of", width, "magnitude", "unit", "at [Hz]",
                   plan_.has_speeds ? fmt::format("{:>9} {:>6} ", "rpm", "order") : "", "phase [deg]");
    for (size_t c = 0; c < std::min(kShown, largest_.size()); ++c) {
        const Largest& one = largest_[c];
        fmt::print("{:<{}}  {:>12.6g}  {:<12} {:>12.6g} {}{:>9.1f}\n", machine_.curves.name(c), width, one.size,
                   machine_.curves.unit(c), one.at.frequency,
                   plan_.has_speeds ? fmt::format("{:>9.1f} {:>6g} ", one.at.speed.value_or(0) / kPerRpm, one.at.order) : "",
                   one.phase);
    }
    if (largest_.size() > kShown) fmt::print("and {} more in summary.json\n", largest_.size() - kShown);
    fmt::print("{}; results in {}\n", counted(rows, "row", "rows"),
               folder.describe(!largest_.empty() ? "response.csv"
                               : rows > 0        ? "psd.csv"
                                                 : "summary.json"));
}

void SteadyResponse::write_summary(const ResultsFolder& folder, size_t rows, bool is_stopped) {
    write_json(folder.file("summary.json"), [&](JsonWriter& json) {
        json.member("format", "dttmm-response/1");
        json.member("warnings", describe_warnings(warnings_));
        json.member("title", machine_.session.model.title);
        if (!request_.response.kind.empty()) json.member("kind", request_.response.kind);
        json.member("status", is_stopped ? "stopped" : "completed");
        json.member("rows", rows);
        json.object("largest", [&] {
            for (size_t c = 0; c < largest_.size(); ++c)
                json.object(machine_.curves.name(c), [&] {
                    json.member("magnitude", largest_[c].size);
                    json.member("unit", machine_.curves.unit(c));
                    json.member("phase_deg", largest_[c].phase);
                    json.member("frequency_hz", largest_[c].at.frequency);
                    if (!plan_.has_speeds) return;
                    json.member("rpm", largest_[c].at.speed.value_or(0) / kPerRpm);
                    json.member("order", largest_[c].at.order);
                });
        });
        json.member("command_line", request_.command_line);
        write_inputs(json, machine_.session.model, request_);
        write_model(json, machine_.session.model, plugins_.catalogue());
    });
}

/// response.csv. False: it was stopped.
bool SteadyResponse::write_rows(const ResultsFolder& folder, size_t& rows) {
    CsvWriter table(folder.file("response.csv"), columns());
    std::vector<double> row;
    bool is_done = true;
    for (size_t s = 0; s < plan_.sweeps.size() && is_done; ++s)
        is_done =
            machine_.curves.find_rows(plan_.sweeps[s], !request_.quiet, [&](const OperatingPoint& at, const Values& values) {
                row.assign(1, at.frequency);
                if (plan_.has_speeds) row.insert(row.end(), {at.speed.value_or(0) / kPerRpm, at.order});
                for (size_t c = 0; c < largest_.size(); ++c) row.insert(row.end(), {values[c].real(), values[c].imag()});
                table.write_row(row);
                keep_largest(plan_.sweeps[s], at, values);
                ++rows;
            });
    table.finish();
    return is_done;
}

ResponseFindings SteadyResponse::findings() const {
    ResponseFindings found{machine_.session.model.parameters, {}, {}, plan_.highest()};
    for (size_t c = 0; c < largest_.size(); ++c) {
        const OperatingPoint& at = largest_[c].at;
        found.largest.push_back({machine_.curves.name(c), machine_.curves.unit(c), largest_[c].size, at.frequency, at});
        found.largest.back().is_peak = largest_[c].is_peak;
        if (const Peaks::One& next = peaks_[c].beside(largest_[c].size); next.size > 0) found.largest.back().next = next.at;
        if (plan_.has_speeds) found.largest.back().rpm = at.speed.value_or(0) / kPerRpm;
    }
    for (size_t c = 0; c < rms_.size(); ++c)
        found.levels.push_back({machine_.curves.channel(c).name(), machine_.curves.channel(c).unit(), rms_[c]});
    return found;
}

ExitCode SteadyResponse::run(ResponseFindings* found) {
    largest_.resize(machine_.curves.size());
    peaks_.resize(machine_.curves.size());
    if (!plan_.sweeps.empty()) machine_.curves.try_first(plan_.sweeps.front());  // it may be refused: before the folder
    const ResultsFolder folder(results_path(request_, "-response"));
    size_t rows = 0;
    bool is_stopped = !plan_.sweeps.empty() && !write_rows(folder, rows);
    if (plan_.random_to > plan_.random_from && !is_stopped) {
        const size_t written = write_random(folder);
        if (plan_.sweeps.empty()) rows = written;
        is_stopped = StopSignals::requested();
    }
    if (!is_stopped) tell_still();
    warnings_.print_rest("; summary.json has all of them");
    write_summary(folder, rows, is_stopped);
    if (found) *found = findings();
    if (is_stopped) {
        if (!found) tell(fmt::format("{}; {} kept", StopSignals::reason(), counted(rows, "row is", "rows are")));
        return StopSignals::exit_code();
    }
    print(folder, rows);
    return ExitCode::ok;
}

}  // namespace

ExitCode find_steady_response(const Request& request) {
    const StopSignals signals;
    const Plugins plugins(request.plugins);
    Warnings warnings;
    return SteadyResponse(request, plugins, warnings).run(nullptr);
}

ExitCode find_steady_response(const Request& request, const Plugins& plugins, Warnings& warnings, ResponseFindings& found) {
    return SteadyResponse(request, plugins, warnings).run(&found);
}

}  // namespace dttmm::host
