// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/spectrum_modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "analysis/spectra.h"
#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/csv_table.h"

namespace dttmm::host {

namespace {

constexpr double kPerHertz = 2 * std::numbers::pi;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
constexpr size_t kMostIdentified = 80;  // each needs two rows of the Hankel matrix
constexpr size_t kSpare = 4;            // vibrations of loads, which stand in an extrapolated history once
constexpr double kSameRate =
    1e-5;  // share: rates of a clean history are known to 1e-9, its steps part them by (omega h)^2/16
constexpr double kNoDamping = 1e-6;   // change over the window; a clean history has 1e-10
constexpr double kGrowth = 0.01;      // over the window; less is rounding of an undamped vibration
constexpr double kUnexplained = 0.1;  // share of the RMS; a clean decay leaves 1e-12

double damping(std::complex<double> rate) { return -rate.real() / std::abs(rate); }

}  // namespace

SpectrumModes::SpectrumModes(const Request& request, const RecordedRun& run, const std::vector<size_t>& moving,
                             Warnings& warnings)
    : steps_(StepShift::of_run(run.summary())) {
    if (moving.empty()) throw Error(ExitCode::numerical_failure, "--identify: nothing moves in the window");
    if (moving.size() > kMostIdentified)
        throw Error(ExitCode::usage,
                    fmt::format("--identify: {} channels are more than the {} that it takes; select those that "
                                "tell the shapes with --channels",
                                moving.size(), kMostIdentified));
    std::vector<std::vector<double>> values;
    for (const size_t c : moving) {
        channels_.push_back(run.channels()[c]);
        values.push_back(run.values()[c]);
    }
    std::optional<ShapeMatch> shapes;
    if (!request.spectrum.modes.empty()) shapes.emplace(request.spectrum.modes, channels_);
    const size_t wanted = as_size(request.spectrum.identified), most = most_modes(values.size(), run.rows());
    // An extrapolated history has each mode twice
    const size_t sought = steps_.size() < 2 ? wanted : std::max(wanted, std::min(most, 2 * wanted + kSpare));
    found_ = identify_modes(values, run.interval(), sought);
    undo_steps();
    keep_strongest(wanted);
    for (size_t i = 0; shapes && i < found_.modes.size(); ++i)
        matches_.push_back(shapes->match(found_.modes[i].shape, true_rates_[i]));
    judge(run, request.spectrum.identified, warnings);
    if (shapes && shapes->size() < 2)
        warnings.add("mac-of-one",
                     "a single channel has a place in the shapes of the modes: every MAC is 1 and says nothing; "
                     "take more channels");
    if (steps_.empty())
        warnings.note("no-step-shift",
                      "no summary.json of the run stands beside the history: the step is not known, and frequencies are "
                      "not corrected for it");
}

/// Frees the rates of the shift of the step. An extrapolated history is the sum of those of two steps: rates that are the
/// same without the shift of the shorter and of the longer one are one mode. What has no partner, as a vibration under a
/// load, is left as it is.
void SpectrumModes::undo_steps() {
    std::vector<IdentifiedMode>& modes = found_.modes;
    for (size_t a = 0; a < modes.size(); ++a) {
        const std::complex<double> rate = steps_.empty() ? modes[a].rate : steps_[0].true_rate(modes[a].rate);
        size_t partner = modes.size();
        for (size_t b = 0; steps_.size() == 2 && b < modes.size(); ++b)
            if (b != a && std::abs(steps_[1].true_rate(modes[b].rate) - rate) < kSameRate * std::abs(rate)) partner = b;
        is_shift_known_.push_back(steps_.size() == 1 || partner < modes.size());
        true_rates_.push_back(is_shift_known_.back() ? rate : modes[a].rate);
        if (partner == modes.size()) continue;
        const double before = modes[a].shape.norm();
        modes[a].shape += modes[partner].shape;
        modes[a].strength *= std::pow(modes[a].shape.norm() / before, 2);
        modes.erase(modes.begin() + as_row(partner));
        if (partner > a) continue;
        true_rates_.erase(true_rates_.begin() + as_row(partner));
        is_shift_known_.erase(is_shift_known_.begin() + as_row(partner));
        --a;
    }
}

void SpectrumModes::keep_strongest(size_t wanted) {
    for (; found_.modes.size() > wanted; ++found_.weaker) {
        const auto weakest = std::ranges::min_element(found_.modes, {}, &IdentifiedMode::strength) - found_.modes.begin();
        found_.modes.erase(found_.modes.begin() + weakest);
        true_rates_.erase(true_rates_.begin() + weakest);
        is_shift_known_.erase(is_shift_known_.begin() + weakest);
    }
}

double SpectrumModes::frequency(size_t i) const { return found_.modes[i].rate.imag() / kPerHertz; }

/// By how much the step has moved the frequency, as share; NaN where that is not known.
double SpectrumModes::shift(size_t i) const {
    if (!is_shift_known_[i]) return kUnknown;
    return found_.modes[i].rate.imag() / true_rates_[i].imag() - 1;
}

void SpectrumModes::judge(const RecordedRun& run, int wanted, Warnings& warnings) const {
    const size_t count = found_.modes.size();
    const double duration = run.duration();
    if (found_.spurious > 0)
        warnings.note("spurious-modes", fmt::format("{} dropped: realisations of other orders do not confirm {}",
                                                    counted(found_.spurious, "vibration is", "vibrations are"),
                                                    found_.spurious == 1 ? "it" : "them"));
    if (found_.faint > 0)
        warnings.note("faint-modes", fmt::format("{} dropped: no stronger than what the realisation leaves out",
                                                 counted(found_.faint, "vibration is", "vibrations are")));
    if (found_.weaker > 0)
        warnings.note("weaker-modes",
                      fmt::format("{} beyond the {} asked for; give a larger --identify",
                                  counted(found_.weaker, "weaker mode is there", "weaker modes are there"), wanted));
    if (count < as_size(wanted))
        warnings.add("fewer-modes",
                     fmt::format("{} of the {} modes asked for {} found: the others do not move these channels, or "
                                 "are lost in noise",
                                 count, wanted, count == 1 ? "is" : "are"));
    if (found_.unexplained > kUnexplained)
        warnings.add(
            "poor-realisation",
            fmt::format("the modes leave {:.2g} % of the motion unexplained: the window should hold a free decay, after "
                        "all loads have ended",
                        100 * found_.unexplained));
    for (size_t i = 0; i < count; ++i) {
        const double f = frequency(i), growth = found_.modes[i].rate.real() * duration;
        if (f * duration < kFewPeriods)
            warnings.add("few-periods",
                         fmt::format("the window has {:.2g} periods of the mode at {:.6g} Hz: its damping is uncertain",
                                     f * duration, f));
        if (f > kEndOfBand / (2 * run.interval()))
            warnings.add(
                "near-end-of-band",
                fmt::format("the mode at {:.6g} Hz stands within the highest tenth of the band, which ends at {:g} Hz: "
                            "it may be a faster one that the rows fold back, run with a shorter --output-step",
                            f, 1 / (2 * run.interval())));
        if (growth > kGrowth)
            warnings.add(
                "growing-mode",
                fmt::format("the mode at {:.6g} Hz grows by a factor of {:.4g} over the window, and all orders confirm it",
                            f, std::exp(growth)));
        if (std::abs(growth) < kNoDamping)
            warnings.note("no-damping",
                          fmt::format("nothing damps the vibration at {:.6g} Hz, or a load keeps it up: then it is no "
                                      "mode, and the step does not shift it",
                                      f));
        if (i > 0 && f - frequency(i - 1) < 1 / duration)
            warnings.note("close-modes",
                          fmt::format("modes at {:.6g} and {:.6g} Hz are nearer than the resolution of {:.4g} Hz: "
                                      "the spectrum shows one peak",
                                      frequency(i - 1), f, 1 / duration));
    }
}

std::string SpectrumModes::table() const {
    std::vector<Column> columns = {{"frequency", "Hz"},
                                   {"damping_ratio", "1"},
                                   {"corrected_frequency", "Hz"},
                                   {"corrected_damping_ratio", "1"},
                                   {"natural_frequency", "Hz"},
                                   {"step_shift", "1"},
                                   {"strength", "1"},
                                   {"matched_mode", "1"},
                                   {"mode_frequency", "Hz"},
                                   {"mac", "1"}};
    for (const Column& channel : channels_) {
        columns.push_back({channel.name + ".amplitude", channel.unit});
        columns.push_back({channel.name + ".phase", "deg"});
    }
    CsvTable table(columns);
    for (size_t i = 0; i < found_.modes.size(); ++i) {
        const IdentifiedMode& mode = found_.modes[i];
        const std::complex<double> rate = true_rates_[i];
        table.add(frequency(i)).add(damping(mode.rate));
        if (is_shift_known_[i])
            table.add(rate.imag() / kPerHertz).add(damping(rate)).add(std::abs(rate) / kPerHertz).add(shift(i));
        else
            table.add(kUnknown).add(kUnknown).add(std::abs(rate) / kPerHertz).add(kUnknown);
        table.add(mode.strength);
        if (matches_.empty() || matches_[i].mode == 0)
            table.add(kUnknown).add(kUnknown).add(kUnknown);
        else
            table.add(static_cast<double>(matches_[i].mode)).add(matches_[i].frequency).add(matches_[i].mac);
        for (const std::complex<double> value : mode.shape)
            table.add(std::abs(value)).add(std::arg(value) * 360 / kPerHertz);
        table.end_row();
    }
    return table.text();
}

void SpectrumModes::print() const {
    fmt::print("{:>14} {:>14} {:>14} {:>12} {:>9}{}\n", "identified", "natural", "damping", "step shift", "strength",
               matches_.empty() ? "" : "  mode of `dttmm modes`");
    for (size_t i = 0; i < found_.modes.size(); ++i) {
        std::string match;
        if (!matches_.empty() && matches_[i].mode > 0)
            match = fmt::format("  {} at {:.7g} Hz, MAC {:.4f}", matches_[i].mode, matches_[i].frequency, matches_[i].mac);
        fmt::print("{:>11} Hz {:>11} Hz {:>14} {:>12} {:>7.2g} %{}\n", fmt::format("{:.7g}", frequency(i)),
                   fmt::format("{:.7g}", std::abs(true_rates_[i]) / kPerHertz),
                   fmt::format("{:.4g} %", 100 * damping(true_rates_[i])),
                   is_shift_known_[i] ? fmt::format("{:+.3g} %", 100 * shift(i)) : "unknown", 100 * found_.modes[i].strength,
                   match);
    }
    fmt::print("realisation of order {}, leaves {:.2g} of the motion; {} without vibration (offset, drift) not listed\n",
               found_.order, found_.unexplained, counted(found_.rates, "pole", "poles"));
    if (!steps_.empty()) fmt::print("{}; natural frequency and damping are without this shift\n", steps_[0].describe());
}

Json SpectrumModes::describe() const {
    Json modes = Json::array();
    for (size_t i = 0; i < found_.modes.size(); ++i) {
        Json one = {{"frequency_hz", frequency(i)},
                    {"damping_ratio", damping(found_.modes[i].rate)},
                    {"natural_frequency_hz", std::abs(true_rates_[i]) / kPerHertz},
                    {"corrected_damping_ratio", is_shift_known_[i] ? Json(damping(true_rates_[i])) : Json()},
                    {"step_shift", is_shift_known_[i] ? Json(shift(i)) : Json()},
                    {"strength", found_.modes[i].strength}};
        if (!matches_.empty() && matches_[i].mode > 0) {
            one["matched_mode"] = matches_[i].mode;
            one["mode_frequency_hz"] = matches_[i].frequency;
            one["mac"] = matches_[i].mac;
        }
        modes.push_back(std::move(one));
    }
    return {{"order", found_.order},
            {"unexplained", found_.unexplained},
            {"spurious", found_.spurious},
            {"step_shift", steps_.empty() ? Json() : Json(steps_[0].describe())},
            {"modes", modes}};
}

}  // namespace dttmm::host
