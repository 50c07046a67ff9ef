// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/response.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "analysis/adaptive_points.h"
#include "analysis/excitation.h"
#include "analysis/modal_session.h"
#include "analysis/places.h"
#include "analysis/random_response.h"
#include "analysis/response_channels.h"
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

using Values = std::vector<std::complex<double>>;

constexpr double kFullTurn = 2 * std::numbers::pi;
constexpr size_t kShown = 40;              ///< channels on the terminal
constexpr size_t kMostAdaptive = 200'000;  ///< points of an adaptive sweep: of ten channels they take 40 MB

/// What one response has to do and what it found.
class SteadyResponse {
public:
    SteadyResponse(const Request& request, const Plugins& plugins, Warnings& warnings)
        : request_(request),
          plugins_(plugins),
          warnings_(warnings),
          session_(request, plugins, warnings),
          channels_(session_.model, session_.machine),
          excitation_(make_excitation()),
          chosen_(select_channels(channels_.all(), request.outputs)),
          plan_(request, session_.model, excitation_, session_.machine, warnings) {
        chosen_.erase(chosen_.begin());  // the frequency
        with_forces_ = channels_.has_forces(chosen_);
        session_.machine.damp(plan_.highest());
        note_damping(session_.model, warnings);
    }

    ExitCode run();

private:
    /// Of one channel under one input, or under the loads.
    struct Largest {
        double size = 0, phase = 0;
        OperatingPoint at;
    };

    Excitation make_excitation();
    Values evaluate(const OperatingPoint& at);
    Values evaluate_near(const ResponseSweep& sweep, double x);
    using Take = std::function<void(const OperatingPoint&, const Values&)>;
    bool sweep(const ResponseSweep& sweep, const Take& take);
    std::map<double, Values> find_points(const ResponseSweep& sweep);
    void warn_too_many();
    void write_random(const ResultsFolder& folder);
    std::vector<Column> columns() const;
    std::vector<size_t> kinds(size_t cases) const;
    std::string channel_name(size_t curve) const;
    std::string unit(size_t curve) const;
    void keep_largest(const OperatingPoint& at, const Values& values);
    void tell_still();
    void print(const ResultsFolder& folder, size_t rows) const;
    void write_summary(const ResultsFolder& folder, size_t rows, bool is_stopped);

    /// Curves of a row: of inputs one after the other, or of the loads, then of random loads.
    size_t columns_of_rows() const {
        return chosen_.size() * (excitation_.is_by_inputs() ? excitation_.inputs().size() : excitation_.has_harmonics());
    }

    const Request& request_;
    const Plugins& plugins_;
    Warnings& warnings_;
    ModalSession session_;
    ResponseChannels channels_;
    Excitation excitation_;
    std::vector<int> chosen_;  ///< channels
    ResponsePlan plan_;
    bool with_forces_ = false;
    std::vector<Largest> largest_;
};

Excitation SteadyResponse::make_excitation() {
    if (request_.inputs.empty()) {
        Excitation loads(session_.model, session_.machine);
        if (!loads.has_harmonics() && loads.random_count() == 0)
            throw Error(
                ExitCode::model_invalid,
                fmt::format("{}: nothing vibrates: the model has no harmonic, psd or unbalance load; give one, or ask "
                            "for the response to a unit force with --in PLACE.DIRECTION",
                            session_.model.path));
        return loads;
    }
    std::vector<Excitation::Input> inputs;
    for (const std::string& text : request_.inputs) {
        const auto [place, direction] = place_and_direction(session_.model, session_.machine, "--in", text);
        inputs.push_back({text, place, direction});
    }
    return Excitation(std::move(inputs));
}

Values SteadyResponse::evaluate(const OperatingPoint& at) {
    const std::vector<ModalInstance::Loads> cases = excitation_.cases(at);
    const std::vector<ModalInstance::Response> responses = session_.machine.respond(at.frequency, cases, with_forces_);
    Values values;
    for (const ModalInstance::Response& response : responses)
        for (const int channel : chosen_) values.push_back(channels_.value(channel, response, kFullTurn * at.frequency));
    return values;
}

/// On a natural frequency that nothing damps a little beside it.
Values SteadyResponse::evaluate_near(const ResponseSweep& sweep, double x) {
    constexpr double kBeside = 1e-8;  // far beyond rounding of x, far within any width that damping gives
    try {
        return evaluate(sweep.at(x));
    } catch (const Error& error) {
        if (error.code() != ExitCode::numerical_failure || x == 0) throw;
    }
    return evaluate(sweep.at((1 + kBeside) * x));
}

void SteadyResponse::keep_largest(const OperatingPoint& at, const Values& values) {
    for (size_t c = 0; c < largest_.size(); ++c)
        if (std::abs(values[c]) > largest_[c].size)
            largest_[c] = {std::abs(values[c]), std::arg(values[c]) * 180 / std::numbers::pi, at};
}

/// Takes all rows, ascending. False: it was stopped.
bool SteadyResponse::sweep(const ResponseSweep& sweep, const Take& take) {
    std::map<double, Values> adaptive;
    if (sweep.is_adaptive) adaptive = find_points(sweep);
    std::vector<double> points = sweep.x;
    if (sweep.is_adaptive) {
        points.clear();
        for (const auto& [x, values] : adaptive) points.push_back(x);
    }
    ProgressBar progress(request_.quiet || sweep.is_adaptive ? -1 : 2);
    size_t own = 0, done = 0;
    const auto take_own = [&] {
        OperatingPoint at = sweep.at(sweep.own[own++]);
        at.has_own = true;
        take(at, evaluate(at));
    };
    for (const double x : points) {
        if (StopSignals::requested() && !sweep.is_adaptive) return false;
        progress.update(static_cast<double>(done++), static_cast<double>(points.size()), "rows");
        while (own < sweep.own.size() && sweep.own[own] < x) take_own();
        if (own < sweep.own.size() && sweep.own[own] == x)
            take_own();
        else
            take(sweep.at(x), sweep.is_adaptive ? adaptive.at(x) : evaluate(sweep.at(x)));
    }
    while (own < sweep.own.size() && !StopSignals::requested()) take_own();
    return !StopSignals::requested();
}

/// Points where the curves bend; those found so far if it is stopped.
std::map<double, Values> SteadyResponse::find_points(const ResponseSweep& sweep) {
    AdaptivePoints adaptive(
        [&](double x) {
            Values values = evaluate_near(sweep, x);
            values.resize(columns_of_rows());
            return values;
        },
        kinds(columns_of_rows() / chosen_.size()));
    if (!adaptive.find(sweep.x, kMostAdaptive, StopSignals::requested) && !StopSignals::requested()) warn_too_many();
    for (const double x : adaptive.unbounded())
        warnings_.add("unbounded-peak",
                      fmt::format("nothing damps the motion at {:.6g} Hz: there the response grows without bound, and the "
                                  "largest values printed are not its peak",
                                  sweep.at(x).frequency));
    return adaptive.points();
}

void SteadyResponse::warn_too_many() {
    warnings_.add(
        "too-many-points",
        fmt::format("after {} points the curves are still not straight between them; give a shorter range", kMostAdaptive));
}

std::string SteadyResponse::channel_name(size_t curve) const {
    const std::string name = channels_.all()[as_size(chosen_[curve % chosen_.size()])].name();
    const auto& inputs = excitation_.inputs();
    return inputs.size() < 2 ? name : name + "/" + inputs[curve / chosen_.size()].text;
}

std::string SteadyResponse::unit(size_t curve) const {
    const std::string unit = channels_.all()[as_size(chosen_[curve % chosen_.size()])].unit();
    if (!excitation_.is_by_inputs()) return unit;
    const Excitation::Input& input = excitation_.inputs()[curve / chosen_.size()];
    const std::string per = input.is_motion() ? (input.turns() ? "rad" : "m") : input.turns() ? "N*m" : "N";
    return unit == per ? "1" : fmt::format("{}/{}", unit, per == "N*m" ? "(N*m)" : per);
}

/// Of the channels in `cases` cases, by their unit and case.
std::vector<size_t> SteadyResponse::kinds(size_t cases) const {
    std::vector<std::string> units;
    std::vector<size_t> kinds;
    for (const int c : chosen_) {
        const std::string& unit = channels_.all()[as_size(c)].unit();
        const auto found = std::ranges::find(units, unit);
        kinds.push_back(static_cast<size_t>(found - units.begin()));
        if (found == units.end()) units.push_back(unit);
    }
    for (size_t c = chosen_.size(); c < cases * chosen_.size(); ++c)
        kinds.push_back(kinds[c - chosen_.size()] + units.size());
    return kinds;
}

std::vector<Column> SteadyResponse::columns() const {
    std::vector<Column> columns = {{"frequency", "Hz"}};
    if (plan_.has_speeds) {
        columns.push_back({"rpm", "rpm"});
        columns.push_back({"order", "1"});
    }
    for (size_t c = 0; c < columns_of_rows(); ++c)
        for (const char* part : {".re", ".im"}) columns.push_back({channel_name(c) + part, unit(c)});
    return columns;
}

/// psd.csv and rms.csv.
void SteadyResponse::write_random(const ResultsFolder& folder) {
    const size_t count = chosen_.size(), skipped = excitation_.has_harmonics() ? count : 0;
    const auto amplitudes = [&](double f) {
        Values values = evaluate_near(ResponseSweep(), f);
        values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(skipped));
        return values;
    };
    const RandomResponse random = find_random_response(excitation_, plan_.random_from, plan_.random_to,
                                                       natural_frequencies(session_.machine, plan_.random_to, warnings_),
                                                       amplitudes, kinds(1), kMostAdaptive, StopSignals::requested);
    if (StopSignals::requested()) return;
    if (!random.is_done) {
        warn_too_many();
        warnings_.add("no-rms", "RMS values are not found, there is no psd.csv");
        return;
    }
    for (const double f : random.unbounded)
        warnings_.add("unbounded-peak", fmt::format("nothing damps the motion at {:.6g} Hz: RMS values have no bound", f));
    std::vector<Column> columns = {{"frequency", "Hz"}};
    CsvTable table({{"channel", ""}, {"unit", ""}, {"rms", ""}, {"three_sigma", ""}, {"zero_crossings", "1/s"}});
    for (size_t c = 0; c < count; ++c) {
        const Channel& channel = channels_.all()[as_size(chosen_[c])];
        columns.push_back({channel.name(), fmt::format("({})^2/Hz", channel.unit())});
        const double rms = random.rms[c], crossings = random.zero_crossings[c];
        table.add(channel.name()).add(channel.unit()).add(rms).add(3 * rms).add(crossings).end_row();
        if (!request_.quiet && c < kShown)
            fmt::print("{:<32} RMS {:>11.5g} {}, 3 sigma {:.5g}, {:.4g} upward zero crossings per second\n", channel.name(),
                       rms, channel.unit(), 3 * rms, crossings);
    }
    if (!request_.quiet && count > kShown) fmt::print("and {} more in rms.csv\n", count - kShown);
    write_atomically(folder.file("rms.csv"), table.text());
    CsvWriter rows(folder.file("psd.csv"), columns);
    std::vector<double> row;
    for (const RandomResponse::Row& one : random.rows) {
        row.assign(1, one.frequency);
        row.insert(row.end(), one.densities.begin(), one.densities.end());
        rows.write_row(row);
    }
    rows.finish();
}

/// Channels that were asked for and stay zero.
void SteadyResponse::tell_still() {
    std::vector<std::string> still;
    for (size_t c = 0; c < largest_.size(); ++c)
        if (largest_[c].size == 0) still.push_back(channel_name(c));
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
    for (size_t c = 0; c < std::min(kShown, largest_.size()); ++c) width = std::max(width, channel_name(c).size());
    if (!largest_.empty())
        fmt::print("{:<{}}  {:>12}  {:<12} {:>12} {}{:>9}\n", "largest of", width, "magnitude", "unit", "at [Hz]",
                   plan_.has_speeds ? fmt::format("{:>9} {:>6} ", "rpm", "order") : "", "phase [deg]");
    for (size_t c = 0; c < std::min(kShown, largest_.size()); ++c) {
        const Largest& one = largest_[c];
        fmt::print("{:<{}}  {:>12.6g}  {:<12} {:>12.6g} {}{:>9.1f}\n", channel_name(c), width, one.size, unit(c),
                   one.at.frequency,
                   plan_.has_speeds ? fmt::format("{:>9.1f} {:>6g} ", one.at.speed.value_or(0) / kPerRpm, one.at.order) : "",
                   one.phase);
    }
    if (largest_.size() > kShown) fmt::print("and {} more in summary.json\n", largest_.size() - kShown);
    fmt::print("{}; results in {}\n", counted(rows, "row", "rows"),
               folder.describe(largest_.empty() ? "psd.csv" : "response.csv"));
}

void SteadyResponse::write_summary(const ResultsFolder& folder, size_t rows, bool is_stopped) {
    write_json(folder.file("summary.json"), [&](JsonWriter& json) {
        json.member("format", "dttmm-response/1");
        json.member("warnings", describe_warnings(warnings_));
        json.member("title", session_.model.title);
        json.member("status", is_stopped ? "stopped" : "completed");
        json.member("rows", rows);
        json.object("largest", [&] {
            for (size_t c = 0; c < largest_.size(); ++c)
                json.object(channel_name(c), [&] {
                    json.member("magnitude", largest_[c].size);
                    json.member("unit", unit(c));
                    json.member("phase_deg", largest_[c].phase);
                    json.member("frequency_hz", largest_[c].at.frequency);
                    if (!plan_.has_speeds) return;
                    json.member("rpm", largest_[c].at.speed.value_or(0) / kPerRpm);
                    json.member("order", largest_[c].at.order);
                });
        });
        json.member("command_line", request_.command_line);
        json.member("inputs", describe_inputs(session_.model, request_));
        write_model(json, session_.model, plugins_.catalogue());
    });
}

ExitCode SteadyResponse::run() {
    largest_.resize(columns_of_rows());
    if (!plan_.sweeps.empty()) {  // the first may be refused: before the folder
        const ResponseSweep& first = plan_.sweeps.front();
        evaluate_near(first, first.x.empty() ? first.own.front() : first.x.front());
    }
    const ResultsFolder folder(results_path(request_, "-response"));
    size_t rows = 0;
    bool is_stopped = false;
    if (!plan_.sweeps.empty()) {
        CsvWriter table(folder.file("response.csv"), columns());
        std::vector<double> row;
        for (const ResponseSweep& one : plan_.sweeps) {
            is_stopped = !sweep(one, [&](const OperatingPoint& at, const Values& values) {
                row.assign(1, at.frequency);
                if (plan_.has_speeds) row.insert(row.end(), {at.speed.value_or(0) / kPerRpm, at.order});
                for (size_t c = 0; c < largest_.size(); ++c) row.insert(row.end(), {values[c].real(), values[c].imag()});
                table.write_row(row);
                keep_largest(at, values);
                ++rows;
            });
            if (is_stopped) break;
        }
        table.finish();
    }
    if (plan_.random_to > plan_.random_from && !is_stopped) {
        write_random(folder);
        is_stopped = StopSignals::requested();
    }
    if (!is_stopped) tell_still();
    warnings_.print_rest("; summary.json has all of them");
    write_summary(folder, rows, is_stopped);
    if (is_stopped) {
        tell(fmt::format("{}; {} kept", StopSignals::reason(), counted(rows, "row is", "rows are")));
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
    return SteadyResponse(request, plugins, warnings).run();
}

}  // namespace dttmm::host
