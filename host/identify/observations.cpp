// SPDX-License-Identifier: BSD-3-Clause
#include "identify/observations.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <set>

#include "analysis/places.h"
#include "identify/column_maps.h"
#include "identify/mains_hum.h"
#include "identify/model_names.h"
#include "identify/observed_modes.h"
#include "identify/repeats.h"
#include "measured/read_measurement.h"
#include "model/error.h"
#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"
#include "study/text_list.h"

namespace dttmm::host {

namespace {

constexpr double kSilent = 1e-9;       // share of the largest channel of its unit: rounding of a direction that rests
constexpr double kImpossible = 1e100;  // SI: its square is no number any more
constexpr double kLongRecord = 10;     // times the model's duration: most likely a wrong unit of time
constexpr size_t kFewestBefore = 20;   // samples before the start that show the noise

[[noreturn]] void refuse(ExitCode code, const std::string& text) { throw Error(code, text); }

/// A unit as a measuring system writes it: accelerations in g are no grams.
std::string unit_of_sensor(const std::string& unit, const std::string& wanted) {
    return (unit == "g" || unit == "gn" || unit == "G") && wanted == "m/s^2" ? "gravity" : unit;
}

class Reader {
public:
    Reader(const Request& request, const Model& model, const Plugins& plugins, Warnings& warnings)
        : request_(request),
          model_(model),
          warnings_(warnings),
          names_(request, model, plugins),
          maps_(request, model.measured) {}

    Observations read() {
        std::vector<std::filesystem::path> files = request_.fit.measured;
        if (files.empty() && !model_.measured.file.empty()) files.push_back(model_.measured.file);
        if (files.empty())
            refuse(ExitCode::usage,
                   "no measured data: give a file with --measured, or as `file` in [measured] of the model");
        refuse_repeated(files);
        std::vector<Measurement> measurements;
        for (const std::filesystem::path& file : files) measurements.push_back(read_measurement(file));
        set_clock(measurements);
        for (size_t i = 0; i < files.size(); ++i) take_file(files[i].string(), measurements[i]);
        maps_.check_all_found(texts(files));
        complete_shapes(found_);
        join_repeats(found_, warnings_);
        drop_silent();
        note_zeros();
        warn_long_record();
        if (found_.is_empty())
            refuse(ExitCode::input_output,
                   fmt::format("{}: nothing of it is in the model; say with --map COLUMN=CHANNEL what its columns are{}",
                               listed(texts(files)), maps_.columns().empty() ? "" : ": " + listed(maps_.columns())));
        return std::move(found_);
    }

private:
    static std::vector<std::string> texts(const std::vector<std::filesystem::path>& files) {
        std::vector<std::string> names;
        for (const auto& file : files) names.push_back(file.string());
        return names;
    }

    static void refuse_repeated(const std::vector<std::filesystem::path>& files) {
        for (size_t i = 0; i < files.size(); ++i)
            for (size_t other = 0; other < i; ++other) {
                std::error_code fault;
                if (std::filesystem::equivalent(files[i], files[other], fault))
                    refuse(ExitCode::usage, fmt::format("--measured {} and --measured {} are the same file; give it once",
                                                        quote(files[other].string()), quote(files[i].string())));
            }
    }

    /// One recorder took all files.
    void set_clock(const std::vector<Measurement>& measurements) {
        found_.clock = model_.measured.clock;
        if (model_.measured.hum == 0) return;
        std::vector<const MeasuredSignal*> histories;
        for (const Measurement& one : measurements)
            for (const MeasuredSignal& signal : one.signals)
                if (signal.kind == MeasuredSignal::Kind::history) histories.push_back(&signal);
        const double hum = find_mains_hum(histories, model_.measured.hum);
        found_.clock = hum / model_.measured.hum;
        warnings_.note("hum", fmt::format("the mains hum of {:.6g} Hz is at {:.6g} Hz of the file: clock {:.6g}. The mains "
                                          "frequency is usually within 0.1 %",
                                          model_.measured.hum, hum, found_.clock));
    }

    void take_file(const std::string& file, const Measurement& measurement) {
        found_.files.push_back(file);
        maps_.begin_file();
        for (const std::string& note : measurement.notes) warnings_.note("measured", fmt::format("{}: {}", file, note));
        size_t unknown = 0;
        std::string example;
        for (const MeasuredSignal& signal : measurement.signals) {
            if (signal.kind == MeasuredSignal::Kind::coherence || signal.kind == MeasuredSignal::Kind::other) continue;
            const bool is_taken =
                signal.kind == MeasuredSignal::Kind::history ? take_history(signal) : take_response(signal, measurement);
            if (is_taken) continue;
            if (unknown++ == 0) example = signal.name;
        }
        if (unknown > 0)
            warnings_.note("unmapped", fmt::format("{}: {}, as {}: not used; --map says what a column is", file,
                                                   counted(unknown, "column is no channel of the model",
                                                           "columns are no channels of the model"),
                                                   quote(example)));
        if (!measurement.modes.empty())
            add_modes(measurement,
                      read_noise(request_.fit.noise.empty() ? model_.measured.noise : request_.fit.noise, "Hz", "--noise"),
                      names_, maps_, found_, warnings_);
    }

    /// The channel that a signal is called after: as a map says, else by its name, else by its title.
    std::string channel_of(const MeasuredSignal& signal, const MeasuredChannel* map, const std::vector<Channel>& all) const {
        if (map) return map->channel;
        const auto is_title = [&](const Channel& channel) { return channel.name() == signal.title; };
        return !signal.title.empty() && std::ranges::any_of(all, is_title) ? signal.title : signal.name;
    }

    /// Whether --channels wants it.
    bool is_chosen(const std::string& channel) const {
        return request_.spectrum.channels.empty() ||
               std::ranges::any_of(request_.spectrum.channels, [&](const std::string& text) {
                   return std::ranges::any_of(split_list(text), [&](const std::string& pattern) {
                       return fnmatch(pattern.c_str(), channel.c_str(), 0) == 0;
                   });
               });
    }

    /// The channel of this name. A map must name one; a column may. Null: none.
    const Channel* find_channel(const std::vector<Channel>& all, const std::string& name, const MeasuredChannel* map,
                                const std::string& place) {
        for (const Channel& channel : all)
            if (channel.name() == name) return &channel;
        const bool looks_like_one = name.find('.') != name.npos && !map;
        if (!map && !looks_like_one) return nullptr;
        std::vector<std::string> known;
        for (const Channel& channel : all) known.push_back(channel.name());
        if (looks_like_one && !find_nearest(name, known)) return nullptr;
        refuse(ExitCode::usage, fmt::format("{}: the model has no channel {}{}", map ? map->place : place, quote(name),
                                            suggestion(name, known)));
    }

    /// SI per number of the file.
    double factor(const MeasuredSignal& signal, const MeasuredChannel* map, const std::string& unit) {
        std::string own = map && !map->unit.empty() ? map->unit : signal.unit;
        if (own.empty()) {
            no_unit_.insert(signal.name);
            return 1;
        }
        own = unit_of_sensor(own, unit);
        try {
            return unit == "1" && own == "1" ? 1 : parse_quantity("1 " + own, unit);
        } catch (const Error& error) {
            refuse(ExitCode::input_output, fmt::format("{}: {}", signal.place, error.what()));
        }
    }

    double noise_of(const MeasuredChannel* map, const std::string& unit, double largest, bool& is_of_user) {
        std::string text = map ? map->noise : "";
        if (text.empty()) text = request_.fit.noise.empty() ? model_.measured.noise : request_.fit.noise;
        const NoiseLevel level = read_noise(text, unit, map && !map->noise.empty() ? map->place : "--noise");
        is_of_user = level.is_known();
        return level.absolute > 0 ? level.absolute : level.share * largest;
    }

    bool take_history(const MeasuredSignal& signal) {
        const MeasuredChannel* map = maps_.find(signal.name);
        const std::string name = channel_of(signal, map, names_.histories());
        if (name.starts_with("energy") && !map) return true;  // of our own runs: made of the other channels
        const Channel* channel = find_channel(names_.histories(), name, map, signal.place);
        if (!channel) return false;
        if (!is_chosen(name)) return true;
        maps_.claim(name, signal.place);
        const double per_number = factor(signal, map, channel->unit()) / (map ? map->gain : 1) *
                                  ((map && map->is_reversed) != signal.is_reversed ? -1 : 1);
        ObservedHistory history{name, channel->unit(), {}, {}};
        std::vector<double> before, times_before;
        double largest = 0;
        for (size_t i = 0; i < signal.values.size(); ++i) {
            const double time = found_.clock * (signal.abscissa[i] - (map ? map->delay : 0));
            const double value = per_number * signal.values[i];
            if (!(std::abs(value) < kImpossible))
                refuse(ExitCode::input_output,
                       fmt::format("{}: value {} is no finite number of a measurement", signal.place, i + 1));
            if (time < 0) {
                before.push_back(value);
                times_before.push_back(time);
                continue;
            }
            history.times.push_back(time);
            history.values.push_back(value);
            largest = std::max(largest, std::abs(value));
        }
        if (history.times.size() < 2)
            refuse(ExitCode::input_output, fmt::format("{}: fewer than two samples from the start at 0 on", signal.place));
        if (std::ranges::minmax(history.values).min == std::ranges::minmax(history.values).max) {
            warnings_.add("constant-channel", fmt::format("{}: it is constant: not used", signal.place));
            return true;
        }
        history.noise = noise_of(map, history.unit, largest, history.is_noise_of_user);
        if (history.noise == 0 && before.size() >= kFewestBefore) {
            history.noise = deviation(times_before, before, model_.measured.hum);
            history.noise_samples = before.size();
        }
        history.hum = model_.measured.hum;
        history.place = signal.place;
        found_.histories.push_back(std::move(history));
        return true;
    }

    /// Of the noise, beside a mean and the hum.
    static double deviation(const std::vector<double>& times, const std::vector<double>& values, double hum) {
        Eigen::VectorXd left = Eigen::Map<const Eigen::VectorXd>(values.data(), as_row(values.size()));
        left.array() -= left.mean();
        if (hum > 0) left -= fit_sine(times, left, hum);
        return std::sqrt(left.squaredNorm() / static_cast<double>(left.size() - (hum > 0 ? 3 : 1)));
    }

    bool take_response(const MeasuredSignal& signal, const Measurement& all) {
        const MeasuredChannel* map = maps_.find(signal.name);
        const std::string name = channel_of(signal, map, names_.responses());
        const Channel* channel = find_channel(names_.responses(), name, map, signal.place);
        if (!channel) return false;
        if (!is_chosen(name)) return true;
        const std::string input = input_of(signal);
        const auto [place, direction] = place_and_direction(names_.modal_model(), names_.machine(), signal.place, input);
        maps_.claim(name + "/" + input, signal.place);
        const bool is_motion = place->is_held(direction), turns = direction >= 3;
        const std::string per = is_motion ? (turns ? "rad" : "m") : turns ? "N*m" : "N";
        const std::string unit =
            channel->unit() == per ? "1" : fmt::format("{}/{}", channel->unit(), per == "N*m" ? "(N*m)" : per);
        MeasuredSignal own = signal;
        if (!own.reference_unit.empty() && !own.unit.empty())
            own.unit = fmt::format("{}/({})", unit_of_sensor(own.unit, channel->unit()), own.reference_unit);
        const double per_number =
            factor(own, map, unit) / (map ? map->gain : 1) * ((map && map->is_reversed) != signal.is_reversed ? -1 : 1);
        ObservedResponse response{name, input, unit, {}, {}, {}};
        response.is_real = signal.imaginary.empty();
        response.place = signal.place;
        double largest = 0;
        size_t above = 0;  // 0 Hz
        for (size_t i = 0; i < signal.abscissa.size(); ++i) {
            const double f = signal.abscissa[i] / found_.clock;
            const std::complex<double> value =
                per_number * std::complex<double>(signal.values[i], response.is_real ? 0 : signal.imaginary[i]) *
                std::polar(1.0, map ? 2 * std::numbers::pi * f * map->delay : 0.0);
            if (!(std::abs(value) < kImpossible))
                refuse(ExitCode::input_output,
                       fmt::format("{}: value {} is no finite number of a measurement", signal.place, i + 1));
            if (f > 0) ++above;
            if (f <= 0 || std::abs(value) == 0) continue;  // nothing is measured at 0 Hz; zero has no logarithm
            response.frequencies.push_back(f);
            response.values.push_back(value);
            largest = std::max(largest, std::abs(value));
        }
        if (above > 0 && largest == 0) {
            zeros_.push_back(signal.place);
            return true;
        }
        if (response.frequencies.size() < 2)
            refuse(ExitCode::input_output,
                   fmt::format("{}: fewer than two values above 0 Hz that are not zero", signal.place));
        bool is_of_user = false;
        response.noise = noise_of(map, unit, largest, is_of_user);
        if (response.noise == 0) take_coherence(signal, all, response, largest);
        found_.responses.push_back(std::move(response));
        return true;
    }

    /// What drove a response: the file says it, or the user. A map of the channel at the driving point tells the place, too.
    std::string input_of(const MeasuredSignal& signal) {
        if (!signal.reference.empty()) {
            const MeasuredChannel* map = maps_.find_reference(signal.reference);
            for (const std::string& name : {map ? map->channel : signal.reference, signal.reference_title})
                if (const std::optional<ObservedFreedom> freedom = find_freedom(names_, name))
                    return fmt::format("{}.{}", freedom->place, direction_names()[as_size(freedom->direction)]);
            return map ? map->channel : signal.reference;
        }
        if (!request_.response.inputs.empty()) return request_.response.inputs.front();
        if (!model_.measured.input.empty()) return model_.measured.input;
        refuse(ExitCode::usage,
               fmt::format("{}: what drove this response? Give it with --in PLACE.DIRECTION, or `input` in [measured]",
                           signal.place));
    }

    /// H1 with n averages: the variance of |H| is |H|^2 (1 - g2)/(2 n g2). Source: Bendat and Piersol, Random Data, 2010.
    void take_coherence(const MeasuredSignal& signal, const Measurement& all, ObservedResponse& response, double largest) {
        for (const MeasuredSignal& one : all.signals) {
            if (one.kind != MeasuredSignal::Kind::coherence || one.name != signal.name ||
                one.reference != signal.reference || one.abscissa != signal.abscissa)
                continue;
            for (const double g2 : one.values)
                if (!(g2 >= 0 && g2 <= 1 + 1e-6))
                    refuse(ExitCode::input_output,
                           fmt::format("{}: a coherence of {} lies outside of 0 to 1", one.place, number_text(g2)));
            if (model_.measured.averages < 2) {
                warnings_.note("coherence", fmt::format("{}: the coherence is not used: of one average it is always 1; say "
                                                        "with `averages` in [measured] how many there were",
                                                        one.place));
                return;
            }
            constexpr double kFloor = 1e-4;  // of the largest: rounding of a coherence near 1
            for (size_t i = 0, k = 0; i < one.values.size() && k < response.frequencies.size(); ++i) {
                if (signal.abscissa[i] / found_.clock != response.frequencies[k]) continue;
                const double g2 = std::clamp(one.values[i], 1e-6, 1.0);
                const double share = std::sqrt((1 - g2) / (2 * model_.measured.averages * g2));
                response.deviations.push_back(std::hypot(share * std::abs(response.values[k]), kFloor * largest));
                ++k;
            }
            if (response.deviations.size() != response.frequencies.size()) response.deviations.clear();
            return;
        }
    }

    /// Times in ms that are taken for seconds would be a run without end.
    void warn_long_record() {
        double last = 0;
        for (const ObservedHistory& one : found_.histories) last = std::max(last, one.times.back());
        if (model_.simulation.duration > 0 && last > kLongRecord * model_.simulation.duration)
            warnings_.add("long-record",
                          fmt::format("the measured data last {:.6g} s, the model {:.6g} s: is the unit of the times right?",
                                      last, model_.simulation.duration));
    }

    /// Channels in which there is rounding only, as a run records them in directions without motion.
    void drop_silent() {
        std::map<std::string, double> largest;
        const auto size_of = [](const ObservedHistory& one) {
            double most = 0;
            for (const double value : one.values) most = std::max(most, std::abs(value));
            return most;
        };
        for (const ObservedHistory& one : found_.histories) largest[one.unit] = std::max(largest[one.unit], size_of(one));
        const size_t dropped = std::erase_if(
            found_.histories, [&](const ObservedHistory& one) { return size_of(one) < kSilent * largest[one.unit]; });
        if (dropped > 0)
            warnings_.note("silent-channels", fmt::format("{}: not used", counted(dropped, "channel holds rounding only",
                                                                                  "channels hold rounding only")));
        if (!no_unit_.empty())
            warnings_.note("no-unit", fmt::format("{} without unit, as {}: taken as SI",
                                                  counted(no_unit_.size(), "column", "columns"), quote(*no_unit_.begin())));
    }

    /// Responses of zeros, as `dttmm response` has them in directions without motion.
    void note_zeros() {
        if (zeros_.empty()) return;
        const std::string text = fmt::format(
            "{}, as {}", counted(zeros_.size(), "response is zero", "responses are zero") + " at all frequencies",
            zeros_.front());
        if (found_.is_empty()) refuse(ExitCode::input_output, text + ": there is nothing to fit");
        warnings_.note("zero-responses", text + ": not used");
    }

    const Request& request_;
    const Model& model_;
    Warnings& warnings_;
    ModelNames names_;
    ColumnMaps maps_;
    std::set<std::string> no_unit_;
    std::vector<std::string> zeros_;  ///< places of responses
    Observations found_;
};

}  // namespace

std::vector<std::string> Observations::channel_names() const {
    std::vector<std::string> names;
    for (const ObservedHistory& one : histories) names.push_back(one.channel);
    for (const ObservedResponse& one : responses) names.push_back(one.channel + "/" + one.input);
    return names;
}

NoiseLevel read_noise(const std::string& text, const std::string& unit, const std::string& option) {
    NoiseLevel level;
    if (text.empty()) return level;
    try {
        const Quantity quantity = parse_quantity(text);
        if (quantity.unit == "1")
            level.share = quantity.value;
        else
            level.absolute = parse_quantity(text, unit);
    } catch (const Error& error) {
        refuse(ExitCode::usage, fmt::format("{} {}: {}", option, quote(text), error.what()));
    }
    if (!level.is_known()) refuse(ExitCode::usage, fmt::format("{} {}: must be more than 0", option, quote(text)));
    return level;
}

Observations read_observations(const Request& request, const Model& model, const Plugins& plugins, Warnings& warnings) {
    return Reader(request, model, plugins, warnings).read();
}

}  // namespace dttmm::host
