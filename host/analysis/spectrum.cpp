// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/spectrum.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "analysis/recorded_run.h"
#include "analysis/spectra.h"
#include "analysis/spectrum_modes.h"
#include "analysis/spectrum_orders.h"
#include "analysis/summary.h"
#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/csv_table.h"
#include "record/csv_writer.h"
#include "record/results_folder.h"

namespace dttmm::host {

namespace {

constexpr size_t kMostPeaks = 6;       // of a channel in summary.json
constexpr size_t kShownPeaks = 3;      // of a channel on the terminal
constexpr size_t kShownChannels = 20;  // on the terminal
constexpr double kLeastPeak = 0.01;    // of the largest: what is smaller is a side lobe of a Hann window (-31 dB) or noise

/// One command: what it reads, what it found.
class SpectrumCommand {
public:
    SpectrumCommand(const Request& request, Warnings& warnings)
        : request_(request),
          warnings_(warnings),
          taper_(parse_taper(request.spectrum.window.empty() ? "hann" : request.spectrum.window)),
          run_(request.words.front(), warnings) {
        check_words();
        run_.read(request.spectrum.channels, request.spectrum.speed, request.response.from, request.response.to);
        size_ = find_segment_size();
    }

    ExitCode run();

private:
    void check_words() const;
    size_t find_segment_size() const;
    void find_levels();
    void find_spectra();
    void judge_peaks();
    std::string levels_table() const;
    void write_spectra(const ResultsFolder& folder) const;
    void print(const ResultsFolder& folder) const;
    Json describe() const;

    double resolution() const { return 1 / (static_cast<double>(size_) * run_.interval()); }
    const Column& channel(size_t i) const { return run_.channels()[i]; }

    const Request& request_;
    Warnings& warnings_;
    Taper taper_;
    RecordedRun run_;
    size_t size_ = 0;  ///< samples of a segment
    std::vector<Levels> levels_;
    std::vector<size_t> moving_;  ///< channels that are not constant
    std::vector<Spectrum> spectra_;
    std::vector<std::vector<Peak>> peaks_;
    std::optional<SpectrumModes> modes_;
    std::optional<SpectrumOrders> orders_;
};

void SpectrumCommand::check_words() const {
    if (request_.response.orders.empty() != request_.spectrum.speed.empty())
        throw Error(ExitCode::usage,
                    "--orders and --speed belong together: the orders, and the channel of the shaft's speed or angle");
    if (!request_.spectrum.modes.empty() && request_.spectrum.identified == 0)
        throw Error(ExitCode::usage, "--modes: what is to be compared? give --identify N, the number of modes to find");
}

size_t SpectrumCommand::find_segment_size() const {
    if (request_.spectrum.segments > 0 && !request_.spectrum.resolution.empty())
        throw Error(ExitCode::usage, "--segments and --resolution say the same; give one of them");
    size_t size = segment_size(run_.rows(), as_size(std::max(request_.spectrum.segments, 1)));
    if (!request_.spectrum.resolution.empty()) {
        double resolution = 0;
        try {
            resolution = parse_quantity(request_.spectrum.resolution, "Hz");
        } catch (const Error& error) {
            throw Error(ExitCode::usage,
                        fmt::format("--resolution {}: {}", quote(request_.spectrum.resolution), error.what()));
        }
        const double wanted = 1 / (resolution * run_.interval());
        if (!(wanted >= 2 && wanted <= (1 + 1e-9) * static_cast<double>(run_.rows())))
            throw Error(ExitCode::usage,
                        fmt::format("--resolution {}: the window of {:g} s has a resolution of {:g} Hz at best, and {:g} Hz "
                                    "at most for rows every {:g} s",
                                    request_.spectrum.resolution, run_.duration(), 1 / run_.duration(),
                                    1 / (2 * run_.interval()), run_.interval()));
        size = std::min(run_.rows(), static_cast<size_t>(std::lround(wanted)));
    }
    if (size < 2)
        throw Error(ExitCode::usage, fmt::format("--segments {}: {} are too few for so many; give fewer",
                                                 request_.spectrum.segments, counted(run_.rows(), "row", "rows")));
    return size;
}

/// What moves by rounding only would count like a vibration where all channels count alike.
void SpectrumCommand::find_levels() {
    // Of the largest value in the same unit. Range 0.5 to 3100 epsilons: WhatMovesByRoundingOnlyIsConstant
    constexpr double kRounding = 16 * std::numeric_limits<double>::epsilon();
    std::map<std::string, double> largest;
    for (size_t c = 0; c < run_.channels().size(); ++c) {
        levels_.push_back(levels_of(run_.values()[c]));
        double& most = largest[channel(c).unit];
        most = std::max(most, levels_.back().peak);
    }
    std::vector<std::string> constant;
    for (size_t c = 0; c < levels_.size(); ++c) {
        if (levels_[c].is_constant || levels_[c].deviation <= kRounding * largest[channel(c).unit])
            constant.push_back(channel(c).name);
        else
            moving_.push_back(c);
    }
    if (!constant.empty())
        warnings_.note("constant-channel",
                       fmt::format("{} constant in the window, apart from round-off, and not in spectrum.csv: {}",
                                   counted(constant.size(), "channel is", "channels are"), listed(constant)));
}

void SpectrumCommand::find_spectra() {
    for (const size_t c : moving_) {
        spectra_.push_back(spectrum_of(run_.values()[c], run_.interval(), run_.start(), taper_, size_));
        peaks_.push_back(peaks_of(spectra_.back().amplitude, resolution(), taper_, kMostPeaks, kLeastPeak));
    }
}

/// What the numbers cannot say: vibrations slower than the window or faster than the rows.
void SpectrumCommand::judge_peaks() {
    std::vector<std::string> slow, fast;
    const double bins = static_cast<double>(size_) / 2;
    for (size_t i = 0; i < moving_.size(); ++i) {
        const std::vector<double>& amplitude = spectra_[i].amplitude;
        const auto largest = static_cast<double>(std::ranges::max_element(amplitude) - amplitude.begin());
        if (largest < kFewPeriods) slow.push_back(channel(moving_[i]).name);
        if (std::ranges::any_of(peaks_[i],
                                [&](const Peak& peak) { return static_cast<double>(peak.bin) > kEndOfBand * bins; }) ||
            largest > kEndOfBand * bins)
            fast.push_back(channel(moving_[i]).name);
    }
    if (!slow.empty())
        warnings_.add(
            "few-periods",
            fmt::format("largest below {:g} Hz, of which the window has fewer than {:g} periods: {}; amplitude and "
                        "frequency there are uncertain, use a longer window",
                        kFewPeriods * resolution(), kFewPeriods, listed(slow)));
    if (!fast.empty())
        warnings_.add(
            "near-end-of-band",
            fmt::format("a peak within the highest tenth of the band, which ends at {:g} Hz: {}; it may be a faster "
                        "vibration that the rows fold back, run with a shorter --output-step",
                        1 / (2 * run_.interval()), listed(fast)));
}

std::string SpectrumCommand::levels_table() const {
    CsvTable table(
        {{"channel", ""}, {"unit", ""}, {"rms", ""}, {"deviation", ""}, {"mean", ""}, {"peak", ""}, {"peak_time", "s"}});
    for (size_t c = 0; c < levels_.size(); ++c) {
        const Levels& one = levels_[c];
        table.add(channel(c).name).add(channel(c).unit).add(one.rms).add(one.deviation).add(one.mean).add(one.peak);
        table.add(run_.start() + static_cast<double>(one.peak_at) * run_.interval()).end_row();
    }
    return table.text();
}

void SpectrumCommand::write_spectra(const ResultsFolder& folder) const {
    std::vector<Column> columns = {{"frequency", "Hz"}};
    const bool has_phase = segment_count(run_.rows(), size_) == 1;
    for (const size_t c : moving_) {
        columns.push_back({channel(c).name + ".amplitude", channel(c).unit});
        if (has_phase) columns.push_back({channel(c).name + ".phase", "deg"});
        columns.push_back({channel(c).name + ".psd", fmt::format("({})^2/Hz", channel(c).unit)});
    }
    CsvWriter rows(folder.file("spectrum.csv"), columns);
    std::vector<double> row;
    for (size_t k = 0; k < size_ / 2 + 1; ++k) {
        row.assign(1, static_cast<double>(k) * resolution());
        for (const Spectrum& spectrum : spectra_) {
            row.push_back(spectrum.amplitude[k]);
            if (has_phase) row.push_back(spectrum.phase[k]);
            row.push_back(spectrum.density[k]);
        }
        rows.write_row(row);
    }
    rows.finish();
}

void SpectrumCommand::print(const ResultsFolder& folder) const {
    if (request_.quiet) return;
    size_t width = 8;
    for (const Column& one : run_.channels()) width = std::max(width, one.name.size());
    fmt::print("{:<{}} {:>8} {:>11} {:>11} {:>11}  {}\n", "channel", width, "unit", "rms", "mean", "peak",
               "largest amplitudes at [Hz]");
    for (size_t i = 0; i < std::min(moving_.size(), kShownChannels); ++i) {
        const size_t c = moving_[i];
        std::vector<std::string> peaks;
        for (size_t p = 0; p < std::min(peaks_[i].size(), kShownPeaks); ++p)
            peaks.push_back(fmt::format("{:.5g} at {:.6g}", peaks_[i][p].amplitude, peaks_[i][p].frequency));
        fmt::print("{:<{}} {:>8} {:>11.5g} {:>11.5g} {:>11.5g}  {}\n", channel(c).name, width, channel(c).unit,
                   levels_[c].rms, levels_[c].mean, levels_[c].peak, fmt::join(peaks, ", "));
    }
    if (moving_.size() > kShownChannels) fmt::print("and {} more in levels.csv\n", moving_.size() - kShownChannels);
    if (modes_) modes_->print();
    if (orders_) orders_->print();
    const size_t segments = segment_count(run_.rows(), size_);
    fmt::print("{} from {:g} s, every {:g} s; resolution {:.5g} Hz, band up to {:g} Hz, window {}, {}; results in {}\n",
               counted(run_.rows(), "row", "rows"), run_.start(), run_.interval(), resolution(), 1 / (2 * run_.interval()),
               taper_name(taper_), counted(segments, "segment", "segments"), folder.describe());
}

Json SpectrumCommand::describe() const {
    Json levels = Json::object(), peaks = Json::object();
    for (size_t c = 0; c < levels_.size(); ++c)
        levels[channel(c).name] = {{"unit", channel(c).unit},
                                   {"rms", levels_[c].rms},
                                   {"deviation", levels_[c].deviation},
                                   {"mean", levels_[c].mean},
                                   {"peak", levels_[c].peak}};
    for (size_t i = 0; i < moving_.size(); ++i) {
        Json& list = peaks[channel(moving_[i]).name] = Json::array();
        for (const Peak& peak : peaks_[i]) list.push_back({{"frequency_hz", peak.frequency}, {"amplitude", peak.amplitude}});
    }
    Json json = {{"format", "dttmm-spectrum/1"},
                 {"status", "completed"},
                 {"warnings", describe_warnings(warnings_)},
                 {"command_line", request_.command_line},
                 {"history", run_.history().string()},
                 {"window", {{"from", run_.start()}, {"rows", run_.rows()}, {"interval", run_.interval()}}},
                 {"taper", taper_name(taper_)},
                 {"segments", segment_count(run_.rows(), size_)},
                 {"resolution_hz", resolution()},
                 {"levels", levels},
                 {"peaks", peaks}};
    if (modes_) json["identified"] = modes_->describe();
    if (orders_) json["orders"] = orders_->describe();
    return json;
}

std::filesystem::path spectrum_path(const Request& request) {
    if (request.output) return *request.output;
    std::filesystem::path path = std::filesystem::path(request.words.front()).lexically_normal();
    if (!path.has_filename()) path = path.parent_path();  // "results/plate/"
    std::error_code fault;
    if (!std::filesystem::is_directory(path, fault)) path = path.parent_path();  // of a file its folder
    if (path.empty() || path == "." || path == "..") path = std::filesystem::path("results") / "history";
    path += "-spectrum";
    return path;
}

ExitCode SpectrumCommand::run() {
    find_levels();
    find_spectra();
    judge_peaks();
    if (request_.spectrum.identified > 0) modes_.emplace(request_, run_, moving_, warnings_);
    if (!request_.response.orders.empty()) orders_.emplace(request_, run_, moving_, warnings_);
    const ResultsFolder folder(spectrum_path(request_));
    write_atomically(folder.file("levels.csv"), levels_table());
    if (!moving_.empty()) write_spectra(folder);
    if (modes_) write_atomically(folder.file("identified.csv"), modes_->table());
    if (orders_) write_atomically(folder.file("orders.csv"), orders_->table());
    warnings_.print_rest("; summary.json has all of them");
    write_json(folder.file("summary.json"), describe());
    print(folder);
    return ExitCode::ok;
}

}  // namespace

ExitCode find_spectrum(const Request& request) {
    Warnings warnings;
    return SpectrumCommand(request, warnings).run();
}

}  // namespace dttmm::host
