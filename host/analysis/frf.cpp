// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/frf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "analysis/modal_session.h"
#include "analysis/places.h"
#include "analysis/response_curves.h"
#include "analysis/response_plan.h"
#include "analysis/stop_signals.h"
#include "analysis/summary.h"
#include "model/index.h"
#include "record/csv_writer.h"
#include "record/results_folder.h"
#include "record/tell.h"

namespace dttmm::host {

namespace {

/// The largest of a curve's points, and by how much the curve may be larger beside it.
struct LargestPoint {
    double size = 0, at = 0, missed = 0;

    void take(double frequency, double next) {
        // A peak between points is larger than the largest of them by an eighth of their second difference or more
        const double rise = next - last_;
        if (count_++ > 1 && last_ == size) missed = (slope_ - rise) / 8;
        slope_ = rise;
        last_ = next;
        if (last_ <= size) return;
        size = last_;
        at = frequency;
        missed = 0;
    }

private:
    double last_ = 0, slope_ = 0;
    int count_ = 0;
};

/// The channel of a displacement or rotation. A marker turns with its body.
int channel_of(const Model& model, const ResponseChannels& channels, const ModalPlace& place, int direction) {
    const bool turns = direction >= 3;
    const std::string& owner = turns && place.body >= 0 ? model.bodies[as_size(place.body)].name : place.name;
    const std::string name = fmt::format("{}.{}.{}", owner, turns ? "rotation" : "position", "xyz"[direction % 3]);
    const auto found = std::ranges::find(channels.all(), name, &Channel::name);
    return as_int(found - channels.all().begin());
}

/// The one-input case of a response: a force or moment at one place, the displacement of another.
class OneResponse {
public:
    OneResponse(const Request& request, const Plugins& plugins, Warnings& warnings)
        : request_(request),
          plugins_(plugins),
          warnings_(warnings),
          session_(request, plugins, warnings),
          in_(place_and_direction(session_.model, session_.machine, "--in", request.response.input)),
          out_(place_and_direction(session_.model, session_.machine, "--out", request.response.response)),
          channels_(session_.model, session_.machine),
          excitation_({{request.response.input, in_.first, in_.second}}),
          curves_(session_.machine, channels_, excitation_,
                  {channel_of(session_.model, channels_, *out_.first, out_.second)}, warnings),
          plan_(request, session_.model, excitation_, session_.machine, warnings) {
        session_.machine.damp(plan_.highest());
        note_damping(session_.model, warnings);
    }

    ExitCode run();

private:
    using Place = std::pair<const ModalPlace*, int>;

    const ResponseSweep& sweep() const { return plan_.sweeps.front(); }
    std::vector<Column> columns() const;
    std::complex<double> receptance(const ResponseCurves::Values& values) const;
    bool write_rows(const ResultsFolder& folder);
    void judge();
    void write_summary(const ResultsFolder& folder, bool is_stopped);

    const Request& request_;
    const Plugins& plugins_;
    Warnings& warnings_;
    ModalSession session_;
    Place in_, out_;
    ResponseChannels channels_;
    Excitation excitation_;
    ResponseCurves curves_;
    ResponsePlan plan_;
    LargestPoint largest_;
    size_t rows_ = 0;
    double last_ = 0;  ///< frequency of the last row [Hz]
};

std::vector<Column> OneResponse::columns() const {
    const char* input = in_.second < 3 ? "N" : "(N*m)";
    const char* unit = out_.second < 3 ? "m" : "rad";
    const std::string per_input = fmt::format("{}/{}", unit, input), velocity = fmt::format("{}/s/{}", unit, input),
                      acceleration = fmt::format("{}/s^2/{}", unit, input);
    return {{"frequency", "Hz"},
            {"receptance.re", per_input},
            {"receptance.im", per_input},
            {"receptance", per_input},
            {"phase", "deg"},
            {"mobility.re", velocity},
            {"mobility.im", velocity},
            {"accelerance.re", acceleration},
            {"accelerance.im", acceleration}};
}

/// A force in a direction that is fixed moves nothing, where `dttmm response` moves the support.
std::complex<double> OneResponse::receptance(const ResponseCurves::Values& values) const {
    return in_.first->is_held(in_.second) || out_.first->is_held(out_.second) ? 0 : values.front();
}

/// False: it was stopped.
bool OneResponse::write_rows(const ResultsFolder& folder) {
    CsvWriter table(folder.file("frf.csv"), columns());
    const bool is_done =
        curves_.find_rows(sweep(), !request_.quiet, [&](const OperatingPoint& at, const ResponseCurves::Values& values) {
            const std::complex<double> H = receptance(values), iw(0, 2 * std::numbers::pi * at.frequency), V = iw * H,
                                       A = iw * V;
            const double row[] = {at.frequency, H.real(), H.imag(), std::abs(H), std::arg(H) * 180 / std::numbers::pi,
                                  V.real(),     V.imag(), A.real(), A.imag()};
            table.write_row(row);
            largest_.take(at.frequency, std::abs(H));
            last_ = at.frequency;
            ++rows_;
        });
    table.finish();
    return is_done;
}

void OneResponse::judge() {
    if (!sweep().is_adaptive && largest_.missed > 0.01 * largest_.size)
        warnings_.add(
            "peak-between-points",
            fmt::format("the points are too far apart for the peak near {:.6g} Hz: between them it may be {:.2g} % "
                        "larger or more; without --points they are put where it is",
                        largest_.at, 100 * largest_.missed / largest_.size));
    if (largest_.size == 0)
        warnings_.add("no-response",
                      fmt::format("{} does not move under {}: {}", request_.response.response, request_.response.input,
                                  session_.machine.why_still(*in_.first, in_.second, *out_.first, out_.second)));
}

void OneResponse::write_summary(const ResultsFolder& folder, bool is_stopped) {
    write_json(folder.file("summary.json"), [&](JsonWriter& json) {
        json.member("format", "dttmm-frf/1");
        json.member("warnings", describe_warnings(warnings_));
        json.member("title", session_.model.title);
        json.member("status", is_stopped ? "stopped" : "completed");
        json.member("in", request_.response.input);
        json.member("out", request_.response.response);
        json.member("rows", rows_);
        json.member("largest_receptance", largest_.size);
        json.member("largest_at_hz", largest_.at);
        json.member("command_line", request_.command_line);
        write_inputs(json, session_.model, request_);
        write_model(json, session_.model, plugins_.catalogue());
    });
}

ExitCode OneResponse::run() {
    curves_.try_first(sweep());  // before the folder is touched: it may be refused
    const ResultsFolder folder(results_path(request_, "-frf"));
    const bool is_stopped = !write_rows(folder);
    if (!is_stopped) judge();
    warnings_.print_rest("; summary.json has all of them");
    write_summary(folder, is_stopped);
    if (is_stopped) {
        const std::string asked = sweep().is_adaptive ? "" : fmt::format("of {} ", sweep().x.size());
        tell(fmt::format("{} at {:g} Hz; {} {}rows are kept", StopSignals::reason(), last_, rows_, asked));
        return StopSignals::exit_code();
    }
    if (!request_.quiet)
        fmt::print("{} points from {:g} to {:g} Hz, {} per {}; largest {:.6g} {} at {:.6g} Hz\nresults in {}\n", rows_,
                   sweep().x.front(), sweep().x.back(), request_.response.response, request_.response.input, largest_.size,
                   columns()[1].unit, largest_.at, folder.describe("frf.csv"));
    return ExitCode::ok;
}

}  // namespace

ExitCode find_response(const Request& request) {
    const StopSignals signals;
    const Plugins plugins(request.plugins);
    Warnings warnings;
    return OneResponse(request, plugins, warnings).run();
}

}  // namespace dttmm::host
