// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/frf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "analysis/modal_session.h"
#include "analysis/places.h"
#include "analysis/stop_signals.h"
#include "analysis/summary.h"
#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"
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

}  // namespace

ExitCode find_response(const Request& request) {
    const StopSignals signals;
    const double from = frequency_of("--from", request.from), to = frequency_of("--to", request.to);
    if (!(to > from)) throw Error(ExitCode::usage, "--to must be more than --from");
    if (request.is_logarithmic && from == 0) throw Error(ExitCode::usage, "--log: --from must be more than zero");
    const Plugins plugins(request.plugins);
    Warnings warnings;
    ModalSession session(request, plugins, warnings);
    const Model& model = session.model;
    ModalMachine& machine = session.machine;
    const std::pair input_place = place_and_direction(model, machine, "--in", request.input),
                    output_place = place_and_direction(model, machine, "--out", request.response);
    const auto& [in, in_direction] = input_place;
    const auto& [out, out_direction] = output_place;

    const char* input = in_direction < 3 ? "N" : "(N*m)";
    const char* unit = out_direction < 3 ? "m" : "rad";
    const auto frequency_at = [&](int i) {
        const double part = static_cast<double>(i) / (request.points - 1);
        return request.is_logarithmic ? from * std::pow(to / from, part) : from + part * (to - from);
    };
    const auto respond = [&](double f) {
        return machine.respond(f, *input_place.first, input_place.second, *output_place.first, output_place.second);
    };
    machine.damp(to);
    note_damping(model, warnings);
    std::complex<double> H = respond(frequency_at(0));  // before the folder is touched: it may be refused

    const ResultsFolder folder(results_path(request, "-frf"));
    const std::string per_input = fmt::format("{}/{}", unit, input), velocity = fmt::format("{}/s/{}", unit, input),
                      acceleration = fmt::format("{}/s^2/{}", unit, input);
    CsvWriter rows(folder.file("frf.csv"), {{"frequency", "Hz"},
                                            {"receptance.re", per_input},
                                            {"receptance.im", per_input},
                                            {"receptance", per_input},
                                            {"phase", "deg"},
                                            {"mobility.re", velocity},
                                            {"mobility.im", velocity},
                                            {"accelerance.re", acceleration},
                                            {"accelerance.im", acceleration}});
    LargestPoint largest;
    int done = 0;
    for (; done < request.points && !StopSignals::requested(); ++done) {
        const double f = frequency_at(done);
        if (done > 0) H = respond(f);
        const std::complex<double> iw(0, 2 * std::numbers::pi * f), V = iw * H, A = iw * V;
        const double row[] = {f,        H.real(), H.imag(), std::abs(H), std::arg(H) * 180 / std::numbers::pi,
                              V.real(), V.imag(), A.real(), A.imag()};
        rows.write_row(row);
        largest.take(f, std::abs(H));
    }
    rows.finish();
    const bool is_stopped = done < request.points;
    if (largest.missed > 0.01 * largest.size)
        warnings.add("peak-between-points",
                     fmt::format("the points are too far apart for the peak near {:.6g} Hz: between them it may be {:.2g} % "
                                 "larger or more; \"dttmm modes\" tells where it is, take more points there",
                                 largest.at, 100 * largest.missed / largest.size));
    if (largest.size == 0 && !is_stopped)
        warnings.add("no-response", fmt::format("{} does not move under {}: {}", request.response, request.input,
                                                machine.why_still(*in, in_direction, *out, out_direction)));
    warnings.print_rest("; summary.json has all of them");
    write_json(folder.file("summary.json"), [&](JsonWriter& json) {
        json.member("format", "dttmm-frf/1");
        json.member("warnings", describe_warnings(warnings));
        json.member("title", model.title);
        json.member("status", is_stopped ? "stopped" : "completed");
        json.member("in", request.input);
        json.member("out", request.response);
        json.member("rows", done);
        json.member("largest_receptance", largest.size);
        json.member("largest_at_hz", largest.at);
        json.member("command_line", request.command_line);
        json.member("inputs", describe_inputs(model, request));
        write_model(json, model, plugins.catalogue());
    });
    if (is_stopped) {
        tell(fmt::format("{} at {:g} Hz; {} of {} rows are kept", StopSignals::reason(), frequency_at(done), done,
                         request.points));
        return StopSignals::exit_code();
    }
    if (!request.quiet)
        fmt::print("{} points from {:g} to {:g} Hz, {} per {}; largest {:.6g} {}/{} at {:.6g} Hz\nresults in {}\n",
                   request.points, from, to, request.response, request.input, largest.size, unit, input, largest.at,
                   folder.describe("frf.csv"));
    return ExitCode::ok;
}

}  // namespace dttmm::host
