// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/response.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "analysis/adaptive_points.h"
#include "analysis/excitation.h"
#include "analysis/modal_session.h"
#include "analysis/places.h"
#include "analysis/response_channels.h"
#include "analysis/stop_signals.h"
#include "analysis/summary.h"
#include "model/index.h"
#include "model/units.h"
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
constexpr double kPerRpm = kFullTurn / 60;  ///< [rad/s]
constexpr size_t kMostAdaptive = 200'000;   ///< of one adaptive sweep
constexpr size_t kMostStarts = 2000;        ///< whose frequencies become points

/// One way through frequencies: of a speed's order, or of frequencies themselves.
struct Sweep {
    std::vector<double> x;  ///< the points, or those that adaptive ones begin with; [Hz], of an order [rad/s]
    bool is_adaptive = false;
    bool is_speed = false;
    double order = 0;

    Instance at(double at) const {
        return is_speed ? Instance{order * at / kFullTurn, at, order} : Instance{at, std::nullopt, 0};
    }
};

std::vector<double> spaced(double from, double to, int count, bool is_logarithmic) {
    std::vector<double> points;
    for (int i = 0; i < count; ++i) {
        const double part = count == 1 ? 0 : static_cast<double>(i) / (count - 1);
        points.push_back(i == count - 1   ? to
                         : is_logarithmic ? from * std::pow(to / from, part)
                                          : from + part * (to - from));
    }
    return points;
}

/// "800..6000" or "800..6000:260" [rpm], or with units.
struct Speeds {
    double from = 0, to = 0;  ///< [rad/s]
    int count = 0;            ///< 0: adaptive
};

Speeds parse_speeds(const std::string& text) {
    const auto fail = [&](const std::string& why) {
        throw Error(ExitCode::usage,
                    fmt::format("--rpm {}: {}; write --rpm 800..6000 or --rpm 800..6000:260", quote(text), why));
    };
    const auto number = [&](const std::string& part) {
        try {
            const Quantity quantity = parse_quantity(part);
            return quantity.unit == "1" ? quantity.value * kPerRpm : parse_quantity(part, "rad/s");
        } catch (const Error& error) {
            throw Error(ExitCode::usage, fmt::format("--rpm {}: {}", quote(text), error.what()));
        }
    };
    const size_t dots = text.find("..");
    if (dots == std::string::npos) {
        const double one = number(text);
        return {one, one, 1};
    }
    const size_t colon = text.find(':', dots);
    Speeds speeds{number(text.substr(0, dots)), number(text.substr(dots + 2, colon - std::min(colon, dots + 2))), 0};
    if (colon == std::string::npos) speeds.to = number(text.substr(dots + 2));
    if (colon != std::string::npos) {
        const std::string count = text.substr(colon + 1);
        if (count.empty() || count.size() > 8 || count.find_first_not_of("0123456789") != std::string::npos ||
            std::stoi(count) < 2)
            fail(fmt::format("{} is no number of speeds, 2 or more", quote(count)));
        speeds.count = std::stoi(count);
    }
    if (!(speeds.from >= 0) || !std::isfinite(speeds.to)) fail("speeds are zero or more");
    if (!(speeds.to > speeds.from)) fail("the second speed must be more than the first");
    return speeds;
}

/// What one response has to do and what it found.
class SteadyResponse {
public:
    SteadyResponse(const Request& request, const Plugins& plugins, Warnings& warnings)
        : request_(request),
          plugins_(plugins),
          warnings_(warnings),
          session_(request, plugins, warnings),
          channels_(session_.model, session_.machine),
          excitation_(make_excitation()) {
        std::vector<std::string> patterns = request.outputs;
        chosen_ = select_channels(channels_.all(), patterns);
        chosen_.erase(chosen_.begin());
        with_forces_ = channels_.has_forces(chosen_);
        plan();
    }

    ExitCode run();

private:
    /// Of one channel under one input, or under the loads.
    struct Largest {
        double size = 0, phase = 0;
        Instance at;
    };

    Excitation make_excitation();
    void plan();
    void plan_speeds();
    void plan_frequencies();
    std::vector<double> natural_frequencies(double to);
    Values evaluate(const Instance& at);
    Values evaluate_near(const Sweep& sweep, double x);
    bool sweep(const Sweep& sweep, const std::function<void(const Instance&, const Values&)>& take);
    void write_random(const ResultsFolder& folder);
    std::vector<Column> columns() const;
    std::vector<size_t> kinds() const;
    std::string channel_name(size_t curve) const;
    std::string unit(size_t curve) const;
    void keep_largest(const Instance& at, const Values& values);
    void tell_still();
    void print(const ResultsFolder& folder, size_t rows) const;
    void write_summary(const ResultsFolder& folder, size_t rows, bool is_stopped);

    /// Curves of an instance: of inputs one after the other, or of the loads, then of random loads.
    size_t columns_of_rows() const {
        return chosen_.size() * (excitation_.is_by_inputs() ? excitation_.inputs().size() : excitation_.has_harmonics());
    }

    const Request& request_;
    const Plugins& plugins_;
    Warnings& warnings_;
    ModalSession session_;
    ResponseChannels channels_;
    Excitation excitation_;
    std::vector<int> chosen_;
    bool with_forces_ = false, has_speeds_ = false;
    std::vector<Sweep> sweeps_;
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

std::vector<double> SteadyResponse::natural_frequencies(double to) {
    std::vector<double> natural;
    try {
        natural = session_.machine.frequencies_below(to);
    } catch (const Error& error) {
        warnings_.add("no-natural-frequencies",
                      fmt::format("the natural frequencies are not found, so that a narrow peak between the points may be "
                                  "missed: {}",
                                  error.what()));
    }
    std::erase_if(natural, [](double f) { return !(f > 0); });
    if (natural.size() > kMostStarts) natural.resize(kMostStarts);
    return natural;
}

/// `natural` with the ends of a range and some points between.
std::vector<double> begin_with(double from, double to, const std::vector<double>& natural) {
    constexpr int kEven = 17;  // where nothing resonates curves are parted from here
    std::vector<double> x = spaced(from, to, kEven, false);
    for (const double f : natural)
        if (f > from && f < to) x.push_back(f);
    std::ranges::sort(x);
    x.erase(std::unique(x.begin(), x.end()), x.end());
    return x;
}

void SteadyResponse::plan() {
    if (request_.rpm.empty()) {
        if (!request_.orders.empty())
            throw Error(ExitCode::usage, "--order: orders of which speed? give it with --rpm, as --rpm 800..6000");
        plan_frequencies();
    } else {
        plan_speeds();
    }
}

void SteadyResponse::plan_speeds() {
    const auto fail = [](const std::string& text) { throw Error(ExitCode::usage, text); };
    if (excitation_.is_by_inputs())
        fail("--rpm asks for the orders of the model's loads; with --in give frequencies, --from and --to");
    if (!request_.from.empty() || !request_.to.empty() || request_.points > 0)
        fail("--rpm excludes --from, --to and --points; write the number of speeds behind it, --rpm 800..6000:260");
    std::vector<double> orders = excitation_.orders();
    if (orders.empty())
        throw Error(ExitCode::model_invalid,
                    fmt::format("{}: --rpm: no load is an order of the speed; write order = 2 in a harmonic load, or an "
                                "unbalance",
                                session_.model.path));
    if (session_.model.machine_rests_on_speed)
        warnings_.add("machine-of-speed",
                      "other numbers of the model than amplitudes rest on Omega: they stay as they are at the model's own "
                      "Omega; --set Omega=.. changes them for all speeds");
    if (!request_.orders.empty()) {
        std::vector<double> chosen;
        for (const std::string& text : request_.orders) {
            const double order = [&] {
                try {
                    return parse_quantity(text, "1");
                } catch (const Error& error) {
                    throw Error(ExitCode::usage, fmt::format("--order {}: {}", quote(text), error.what()));
                }
            }();
            if (std::ranges::find(orders, order) == orders.end())
                fail(fmt::format("--order {}: no load has this order; they have {}", text, fmt::join(orders, ", ")));
            chosen.push_back(order);
        }
        orders = chosen;
    }
    const Speeds speeds = parse_speeds(request_.rpm);
    has_speeds_ = true;
    std::vector<double> natural;
    if (speeds.count == 0) natural = natural_frequencies(orders.back() * speeds.to / kFullTurn);
    for (const double order : orders) {
        Sweep& sweep = sweeps_.emplace_back();
        sweep.is_speed = true;
        sweep.order = order;
        sweep.is_adaptive = speeds.count == 0;
        if (sweep.is_adaptive) {
            std::vector<double> critical;
            for (const double f : natural) critical.push_back(kFullTurn * f / order);
            sweep.x = begin_with(speeds.from, speeds.to, critical);
        } else {
            sweep.x = spaced(speeds.from, speeds.to, speeds.count, false);
        }
    }
}

void SteadyResponse::plan_frequencies() {
    const bool has_range = !request_.from.empty() || !request_.to.empty();
    if (has_range && (request_.from.empty() || request_.to.empty()))
        throw Error(ExitCode::usage, "--from and --to go together");
    const std::vector<double> own = excitation_.is_by_inputs() ? std::vector<double>() : excitation_.own_frequencies();
    const bool everywhere = excitation_.acts_everywhere(), is_random = excitation_.random_count() > 0;
    double from = 0, to = 0;
    if (has_range) {
        from = frequency_of("--from", request_.from);
        to = frequency_of("--to", request_.to);
        if (!(to > from)) throw Error(ExitCode::usage, "--to must be more than --from");
        if (request_.is_logarithmic && from == 0) throw Error(ExitCode::usage, "--log: --from must be more than zero");
    } else if (is_random) {
        std::tie(from, to) = excitation_.random_range();
    } else if (everywhere) {
        throw Error(ExitCode::usage, "which frequencies? give --from and --to, e.g. --from 1Hz --to 200Hz");
    }
    Sweep sweep;
    sweep.is_adaptive = request_.points == 0;
    if (everywhere || (is_random && !sweep.is_adaptive)) {
        sweep.x = sweep.is_adaptive ? begin_with(from, to, natural_frequencies(to))
                                    : spaced(from, to, request_.points, request_.is_logarithmic);
        if (is_random && request_.points > 0)
            warnings_.note("own-points", "RMS values are integrals over points of their own choice, not over --points");
    }
    if (!everywhere) sweep.is_adaptive = false;
    if (!everywhere && excitation_.has_harmonics()) {
        if (request_.points > 0 || (has_range && !is_random))
            warnings_.note("own-frequencies",
                           "every harmonic load has a frequency of its own: the rows are these frequencies; a harmonic "
                           "without `frequency` acts at all");
        sweep.x.clear();
    }
    for (const double f : own)
        if (!has_range || (f >= from && f <= to)) sweep.x.push_back(f);
    std::ranges::sort(sweep.x);
    sweep.x.erase(std::unique(sweep.x.begin(), sweep.x.end()), sweep.x.end());
    if (sweep.x.empty() && !is_random)
        throw Error(ExitCode::usage,
                    fmt::format("no load acts from {:g} to {:g} Hz: they act at {} Hz", from, to, fmt::join(own, ", ")));
    if (excitation_.is_by_inputs() || excitation_.has_harmonics()) sweeps_.push_back(std::move(sweep));
}

Values SteadyResponse::evaluate(const Instance& at) {
    const std::vector<ModalInstance::Loads> cases = excitation_.cases(at);
    const std::vector<ModalInstance::Response> responses = session_.machine.respond(at.frequency, cases, with_forces_);
    Values values;
    for (const ModalInstance::Response& response : responses)
        for (const int channel : chosen_) values.push_back(channels_.value(channel, response, kFullTurn * at.frequency));
    return values;
}

/// On a natural frequency that nothing damps a little beside it.
Values SteadyResponse::evaluate_near(const Sweep& sweep, double x) {
    constexpr double kBeside = 1e-8;
    try {
        return evaluate(sweep.at(x));
    } catch (const Error& error) {
        if (error.code() != ExitCode::numerical_failure || x == 0) throw;
    }
    return evaluate(sweep.at((1 + kBeside) * x));
}

void SteadyResponse::keep_largest(const Instance& at, const Values& values) {
    for (size_t c = 0; c < largest_.size(); ++c)
        if (std::abs(values[c]) > largest_[c].size)
            largest_[c] = {std::abs(values[c]), std::arg(values[c]) * 180 / std::numbers::pi, at};
}

/// False: it was stopped.
bool SteadyResponse::sweep(const Sweep& sweep, const std::function<void(const Instance&, const Values&)>& take) {
    if (!sweep.is_adaptive) {
        ProgressBar progress(request_.quiet ? -1 : 2);
        for (size_t i = 0; i < sweep.x.size(); ++i) {
            const double x = sweep.x[i];
            if (StopSignals::requested()) return false;
            progress.update(static_cast<double>(i), static_cast<double>(sweep.x.size()), "rows");
            take(sweep.at(x), evaluate(sweep.at(x)));
        }
        return true;
    }
    AdaptivePoints adaptive(
        [&](double x) {
            Values values = evaluate_near(sweep, x);
            values.resize(columns_of_rows());
            return values;
        },
        kinds());
    const bool is_done = adaptive.find(sweep.x, kMostAdaptive, StopSignals::requested);
    for (const auto& [x, values] : adaptive.points()) take(sweep.at(x), values);
    if (!is_done && !StopSignals::requested())
        warnings_.add("too-many-points", fmt::format("after {} points the curves are still not straight between them; give "
                                                     "a shorter range",
                                                     kMostAdaptive));
    for (const double x : adaptive.unbounded())
        warnings_.add("unbounded-peak",
                      fmt::format("nothing damps the motion at {:.6g} Hz: there the response grows without bound, and the "
                                  "largest values told are not its peak",
                                  sweep.at(x).frequency));
    return !StopSignals::requested();
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

/// Of all curves, by the unit of the channel and the input.
std::vector<size_t> SteadyResponse::kinds() const {
    std::vector<std::string> known;
    std::vector<size_t> kinds;
    const size_t cases = excitation_.inputs().size() + 1 + excitation_.random_count();
    for (size_t c = 0; c < cases * chosen_.size(); ++c) {
        const std::string name =
            fmt::format("{} {}", channels_.all()[as_size(chosen_[c % chosen_.size()])].unit(), c / chosen_.size());
        const auto found = std::ranges::find(known, name);
        kinds.push_back(static_cast<size_t>(found - known.begin()));
        if (found == known.end()) known.push_back(name);
    }
    return kinds;
}

std::vector<Column> SteadyResponse::columns() const {
    std::vector<Column> columns = {{"frequency", "Hz"}};
    if (has_speeds_) {
        columns.push_back({"rpm", "rpm"});
        columns.push_back({"order", "1"});
    }
    for (size_t c = 0; c < columns_of_rows(); ++c)
        for (const char* part : {".re", ".im"}) columns.push_back({channel_name(c) + part, unit(c)});
    return columns;
}

/// Densities and what they add up to, by Simpson's rule between points between which the curves are straight to 1 %.
void SteadyResponse::write_random(const ResultsFolder& folder) {
    const size_t skipped = excitation_.has_harmonics() ? chosen_.size() : 0, count = chosen_.size();
    const auto [from, to] = excitation_.random_range();
    const auto amplitudes = [&](double f) {
        Values values = evaluate_near(Sweep(), f);
        values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(skipped));
        return values;
    };
    AdaptivePoints adaptive(amplitudes, kinds());
    std::vector<double> start = begin_with(from, to, natural_frequencies(to));
    if (!adaptive.find(start, kMostAdaptive, StopSignals::requested)) return;
    const auto densities = [&](double f, const Values& values) {
        std::vector<double> density(count);
        for (size_t r = 0; r < excitation_.random_count(); ++r) {
            const double S = excitation_.density(r, f);
            for (size_t c = 0; c < count; ++c) density[c] += std::norm(values[r * count + c]) * S;
        }
        return density;
    };
    std::vector<Column> columns = {{"frequency", "Hz"}};
    for (const int c : chosen_) {
        const Channel& channel = channels_.all()[as_size(c)];
        columns.push_back({channel.name(), fmt::format("({})^2/Hz", channel.unit())});
    }
    CsvWriter rows(folder.file("psd.csv"), columns);
    std::vector<double> square(count), rate(count), row(count + 1), last;
    double last_f = 0;
    for (const auto& [f, values] : adaptive.points()) {
        const std::vector<double> now = densities(f, values);
        row[0] = f;
        std::ranges::copy(now, row.begin() + 1);
        rows.write_row(row);
        if (!last.empty()) {
            const double middle = 0.5 * (last_f + f);
            const std::vector<double> between = densities(middle, amplitudes(middle));
            for (size_t c = 0; c < count; ++c) {
                const double share = (f - last_f) / 6;
                square[c] += share * (last[c] + 4 * between[c] + now[c]);
                rate[c] += share * (last_f * last_f * last[c] + 4 * middle * middle * between[c] + f * f * now[c]);
            }
        }
        last = now;
        last_f = f;
    }
    rows.finish();
    CsvTable table({{"channel", ""}, {"unit", ""}, {"rms", ""}, {"three_sigma", ""}, {"zero_crossings", "1/s"}});
    for (size_t c = 0; c < count; ++c) {
        const Channel& channel = channels_.all()[as_size(chosen_[c])];
        const double rms = std::sqrt(square[c]), crossings = square[c] > 0 ? std::sqrt(rate[c] / square[c]) : 0;
        table.add(channel.name()).add(channel.unit()).add(rms).add(3 * rms).add(crossings);
        table.end_row();
        if (!request_.quiet && c < 20)
            fmt::print("{:<32} RMS {:>11.5g} {}, 3 sigma {:.5g}, {:.4g} upward zero crossings per second\n", channel.name(),
                       rms, channel.unit(), 3 * rms, crossings);
    }
    write_atomically(folder.file("rms.csv"), table.text());
    for (const double f : adaptive.unbounded())
        warnings_.add("unbounded-peak", fmt::format("nothing damps the motion at {:.6g} Hz: RMS values have no bound", f));
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
    constexpr size_t kShown = 40;
    size_t width = 10;
    for (size_t c = 0; c < std::min(kShown, largest_.size()); ++c) width = std::max(width, channel_name(c).size());
    if (!largest_.empty())
        fmt::print("{:<{}}  {:>12}  {:<12} {:>12} {}{:>9}\n", "largest of", width, "magnitude", "unit", "at [Hz]",
                   has_speeds_ ? fmt::format("{:>9} {:>6} ", "rpm", "order") : "", "phase [deg]");
    for (size_t c = 0; c < std::min(kShown, largest_.size()); ++c) {
        const Largest& one = largest_[c];
        fmt::print(
            "{:<{}}  {:>12.6g}  {:<12} {:>12.6g} {}{:>9.1f}\n", channel_name(c), width, one.size, unit(c), one.at.frequency,
            has_speeds_ ? fmt::format("{:>9.1f} {:>6g} ", one.at.speed.value_or(0) / kPerRpm, one.at.order) : "", one.phase);
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
                    if (!has_speeds_) return;
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
    if (!sweeps_.empty()) evaluate(sweeps_.front().at(sweeps_.front().x.front()));  // may be refused: before the folder
    const ResultsFolder folder(results_path(request_, "-response"));
    size_t rows = 0;
    bool is_stopped = false;
    if (!sweeps_.empty()) {
        CsvWriter table(folder.file("response.csv"), columns());
        std::vector<double> row;
        for (const Sweep& one : sweeps_) {
            is_stopped = !sweep(one, [&](const Instance& at, const Values& values) {
                row.assign(1, at.frequency);
                if (has_speeds_) row.insert(row.end(), {at.speed.value_or(0) / kPerRpm, at.order});
                for (size_t c = 0; c < largest_.size(); ++c) row.insert(row.end(), {values[c].real(), values[c].imag()});
                table.write_row(row);
                keep_largest(at, values);
                ++rows;
            });
            if (is_stopped) break;
        }
        table.finish();
    }
    if (excitation_.random_count() > 0 && !has_speeds_ && !is_stopped) {
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
