// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/request.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "model/error.h"

namespace dttmm::host {

namespace {

using Kind = Option::Kind;

constexpr unsigned kEveryModel = kRun | kCheck | kModes | kFrf | kChannels | kStatic | kResponse | kStudy | kShow,
                   kTime = kRun | kCheck, kFrequency = kModes | kFrf | kResponse;

void set_parameter(Request& request, const std::string& text) {
    const size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
        throw Error(ExitCode::usage, fmt::format("--set {}: write name=value", text));
    request.overrides.parameters.emplace_back(text.substr(0, equals), text.substr(equals + 1));
}

// In the order of the help. Columns: names, kind, commands, help, reaches cases, changes results, what it does.
constexpr Option kOptions[] = {
    {"--set", Kind::list, kEveryModel, "name=value: another value for a parameter of the model; repeated for others", true,
     true, set_parameter},
    {"--set", Kind::list, kCheckLaw, "name=value: of a parameter of the law, instead of random ones; repeated for others",
     false, false, set_parameter},
    {"--step", Kind::text, kTime | kStudy, "time step instead of the model's, e.g. \"0.5 ms\"", true, true,
     [](Request& request, const std::string& value) { request.overrides.step = value; }},
    {"--tolerance", Kind::text, kTime | kStudy,
     "halve the step until results are within, e.g. \"0.1 %\", instead of the model's", true, true,
     [](Request& request, const std::string& value) { request.overrides.tolerance = value; }},
    {"--duration", Kind::text, kTime | kStudy, "duration instead of the model's", true, true,
     [](Request& request, const std::string& value) { request.overrides.duration = value; }},
    {"--coupling", Kind::text, kTime | kStudy, "\"implicit\" or \"explicit\" instead of the model's", true, true,
     [](Request& request, const std::string& value) { request.overrides.coupling = value; }},
    {"--output-step", Kind::text, kTime | kStudy, "time between rows instead of the model's, e.g. \"1 ms\"", true, true,
     [](Request& request, const std::string& value) { request.overrides.output_step = value; }},
    {"--channels", Kind::list, kTime,
     "pattern of channels to record instead of the model's, e.g. \"bolt*.force\"; repeated for more", true, true,
     [](Request& request, const std::string& value) { request.overrides.channels.push_back(value); }},
    {"--plugin", Kind::list, kEveryModel | kElements | kHelp | kSchema | kNew,
     "shared library with more element types or force laws", true, true,
     [](Request& request, const std::string& value) { request.plugins.push_back(value); }},
    {"--force", Kind::flag, kTime | kStudy, "run an explicit coupling beyond its stable step", true, true,
     [](Request& request, const std::string&) { request.force = true; }},
    {"-o,--output", Kind::text, kRun, "results folder; default results/<model name>", false, false,
     [](Request& request, const std::string& value) { request.output = value; }},
    {"--trace", Kind::text, kRun, "CSV file with a row per step: how its end was found, and what it waited for", false,
     false, [](Request& request, const std::string& value) { request.trace = value; }},
    {"--for-report", Kind::flag, kRun,
     "record beside the channels asked for where all bodies and nodes are, and the forces of all elements", true, true,
     [](Request& request, const std::string&) { request.records_motion = true; }},
    {"-o,--output", Kind::text, kFrequency, "results folder; default results/<model name>-modes, or -frf", false, false,
     [](Request& request, const std::string& value) { request.output = value; }},
    {"-o,--output", Kind::text, kStatic, "results folder; default results/<model name>-static", false, false,
     [](Request& request, const std::string& value) { request.output = value; }},
    {"--case", Kind::text, kTime | kFrequency | kStatic | kStudy | kShow,
     "load case of the model; without it static finds all, and others have every load", true, true,
     [](Request& request, const std::string& value) { request.overrides.load_case = value; }},
    {"--at", Kind::text, kStatic, "instant whose loads count, e.g. \"0.5 s\"; default the start", false, true,
     [](Request& request, const std::string& value) { request.at = value; }},
    {"--buckling", Kind::number, kStatic, "find the first so many critical load factors", false, true,
     [](Request& request, const std::string& value) { request.buckling = std::stoi(value); }, false, 1, 1000},
    {"--beams", Kind::text, kFrequency | kStudy, "\"exact\" or \"lumped\" instead of the model's", false, true,
     [](Request& request, const std::string& value) { request.overrides.modes.beams = value; }},
    {"--about", Kind::text, kFrequency | kStudy, "\"start\" or \"equilibrium\" instead of the model's", false, true,
     [](Request& request, const std::string& value) { request.overrides.modes.about = value; }},
    {"--count", Kind::text, kModes | kStudy, "the first so many frequencies instead of the model's", false, true,
     [](Request& request, const std::string& value) { request.overrides.modes.count = value; }},
    {"--below", Kind::text, kModes | kStudy, "all frequencies up to this one, e.g. \"500 Hz\"", false, true,
     [](Request& request, const std::string& value) { request.overrides.modes.below = value; }},
    {"--in", Kind::text, kFrf, "body, marker or node and direction of the force, e.g. plate.corner1.z", false, true,
     [](Request& request, const std::string& value) { request.input = value; }, true},
    {"--out", Kind::text, kFrf, "the same of the displacement", false, true,
     [](Request& request, const std::string& value) { request.response = value; }, true},
    {"--in", Kind::list, kResponse | kStudy,
     "body, marker or node and direction of a unit force or moment, instead of the model's loads; repeated for others",
     false, true, [](Request& request, const std::string& value) { request.inputs.push_back(value); }},
    {"--out", Kind::list, kResponse | kStudy,
     "pattern of channels, as mount*.force; repeated for others; default those of a run", false, true,
     [](Request& request, const std::string& value) { request.outputs.push_back(value); }},
    {"--as", Kind::text, kResponse | kStudy,
     "receptance, mobility, accelerance or transmissibility: outputs of this kind only; --out plate.z is enough then", false,
     true, [](Request& request, const std::string& value) { request.kind = value; }},
    {"--from", Kind::text, kResponse | kStudy, "lowest frequency, e.g. \"1 Hz\"", false, true,
     [](Request& request, const std::string& value) { request.from = value; }},
    {"--to", Kind::text, kResponse | kStudy, "highest frequency", false, true,
     [](Request& request, const std::string& value) { request.to = value; }},
    {"--points", Kind::number, kFrf | kResponse | kStudy,
     "number of frequencies; without it they are put where the curves bend", false, true,
     [](Request& request, const std::string& value) { request.points = std::stoi(value); }, false, 2, 10000000},
    {"--log", Kind::flag, kFrf | kResponse | kStudy, "--points are spaced by equal factors", false, true,
     [](Request& request, const std::string&) { request.is_logarithmic = true; }},
    {"--rpm", Kind::text, kResponse | kStudy, "speeds of the loads' orders, as 800..6000, or 800..6000:260 for so many",
     false, true, [](Request& request, const std::string& value) { request.rpm = value; }},
    {"--order", Kind::list, kResponse | kStudy, "an order of these speeds; repeated for others; default all that loads have",
     false, true, [](Request& request, const std::string& value) { request.orders.push_back(value); }},
    {"--from", Kind::text, kFrf, "lowest frequency, e.g. \"1 Hz\"", false, true,
     [](Request& request, const std::string& value) { request.from = value; }, true},
    {"--from", Kind::text, kNew, "kind of model: plate, mounts, beam or modes; default mounts", false, false,
     [](Request& request, const std::string& value) { request.from = value; }},
    {"--to", Kind::text, kFrf, "highest frequency", false, true,
     [](Request& request, const std::string& value) { request.to = value; }, true},
    {"--channels", Kind::list, kSpectrum,
     "patterns of channels, parted by commas or repeated; default all but energies and quaternions", false, true,
     [](Request& request, const std::string& value) { request.channels.push_back(value); }},
    {"--from", Kind::text, kSpectrum, "start of the window of time, e.g. \"0.5 s\"; default the first row", false, true,
     [](Request& request, const std::string& value) { request.from = value; }},
    {"--to", Kind::text, kSpectrum, "end of the window of time; default the last row", false, true,
     [](Request& request, const std::string& value) { request.to = value; }},
    {"--window", Kind::text, kSpectrum, "how its ends are faded: hann (default), rectangular or flattop", false, true,
     [](Request& request, const std::string& value) { request.window = value; }},
    {"--segments", Kind::number, kSpectrum, "average so many segments that overlap by half (Welch)", false, true,
     [](Request& request, const std::string& value) { request.segments = std::stoi(value); }, false, 1, 1000000},
    {"--resolution", Kind::text, kSpectrum, "average segments of this resolution, e.g. \"0.5 Hz\"", false, true,
     [](Request& request, const std::string& value) { request.resolution = value; }},
    {"--identify", Kind::number, kSpectrum,
     "find so many modes in a free decay (ERA): frequency, damping, shape, corrected for the step: identified.csv", false,
     true, [](Request& request, const std::string& value) { request.identified = std::stoi(value); }, false, 1, 1000},
    {"--modes", Kind::text, kSpectrum, "results folder of dttmm modes: MAC of the identified shapes to its modes", false,
     true, [](Request& request, const std::string& value) { request.modes = value; }},
    {"--orders", Kind::list, kSpectrum, "orders of a shaft to track, e.g. 1,2,3.5: orders.csv", false, true,
     [](Request& request, const std::string& value) { request.orders.push_back(value); }},
    {"--speed", Kind::text, kSpectrum, "channel of that shaft: an angular velocity or an angle", false, true,
     [](Request& request, const std::string& value) { request.speed = value; }},
    {"-o,--output", Kind::text, kSpectrum, "results folder; default RESULTS with -spectrum behind it", false, false,
     [](Request& request, const std::string& value) { request.output = value; }},
    {"--channels", Kind::list, kReport, "patterns of a run's channels to show, parted by commas or repeated; default all",
     false, true, [](Request& request, const std::string& value) { request.channels.push_back(value); }},
    {"--points", Kind::number, kReport,
     "most points of a curve, default 4000; of more rows the least and the largest value of every span", false, true,
     [](Request& request, const std::string& value) { request.points = std::stoi(value); }, false, 100, 10000000},
    {"--flat", Kind::flag, kReport, "without the machine in 3-D: 0.6 MB less", false, true,
     [](Request& request, const std::string&) { request.is_flat = true; }},
    {"-o,--output", Kind::text, kReport, "the HTML file; default RESULTS with .html behind it", false, false,
     [](Request& request, const std::string& value) { request.output = value; }},
    {"--log", Kind::flag, kPlot, "logarithmic axis of magnitudes and of other positive values", false, false,
     [](Request& request, const std::string&) { request.is_logarithmic = true; }},
    {"--text", Kind::flag, kPlot, "draw in the terminal", false, false,
     [](Request& request, const std::string&) { request.is_text = true; }},
    {"-o,--output", Kind::text, kPlot,
     "the picture, SVG or PNG by its name, or - for SVG on the standard output; default RESULTS with .svg behind it", false,
     false, [](Request& request, const std::string& value) { request.output = value; }},
    {"-o,--output", Kind::text, kShow, "the SVG file, or - for the standard output; default results/<model name>-views.svg",
     false, false, [](Request& request, const std::string& value) { request.output = value; }},
    {"--gltf", Kind::flag, kExport, "the machine as it moves in a run or in its modes, for viewers: .glb", false, false,
     [](Request& request, const std::string&) { request.formats.emplace_back("gltf"); }},
    {"--vtu", Kind::flag, kExport, "the same for ParaView: a .vtu file per instant or mode and a .pvd file", false, false,
     [](Request& request, const std::string&) { request.formats.emplace_back("vtu"); }},
    {"--mat", Kind::flag, kExport, "all curves and tables for MATLAB and Octave: .mat (level 5)", false, false,
     [](Request& request, const std::string&) { request.formats.emplace_back("mat"); }},
    {"--uff58", Kind::flag, kExport, "histories and frequency responses as universal file datasets 58: .uff", false, false,
     [](Request& request, const std::string&) { request.formats.emplace_back("uff58"); }},
    {"--uff55", Kind::flag, kExport, "mode shapes as universal file datasets 15, 2411 and 55: .uff", false, false,
     [](Request& request, const std::string&) { request.formats.emplace_back("uff55"); }},
    {"--channels", Kind::list, kExport, "patterns of channels, parted by commas or repeated; default all", false, false,
     [](Request& request, const std::string& value) { request.channels.push_back(value); }},
    {"-o,--output", Kind::text, kExport, "the file; default RESULTS with the ending of the format behind it", false, false,
     [](Request& request, const std::string& value) { request.output = value; }},
    {"--sweep", Kind::list, kRun | kModes | kResponse | kStudy,
     "name=from..to:count or name=value,value; several span a grid", false, false,
     [](Request& request, const std::string& value) { request.sweeps.push_back(value); }},
    {"-j,--jobs", Kind::number, kRun | kStudy, "cases at a time; default one per core", false, false,
     [](Request& request, const std::string& value) { request.jobs = std::stoi(value); }, false, 1, 4096},
    {"--determinant", Kind::text, kModes,
     "determinant of the overall transfer equation over frequency, e.g. 1Hz..200Hz:400: determinant.csv", false, true,
     [](Request& request, const std::string& value) { request.determinant = value; }},
    {"--matrix", Kind::text, kModes,
     "matrix of the overall transfer equation at a frequency, e.g. \"38.6 Hz\": overall_matrix.csv", false, true,
     [](Request& request, const std::string& value) { request.matrix = value; }},
    {"--mac", Kind::text, kModes,
     "CSV file of shapes, as modes.csv, or channels and a column per shape: MAC of the modes with them: mac.csv", false,
     true, [](Request& request, const std::string& value) { request.shapes = value; }},
    {"--damped", Kind::flag, kModes, "find the modes with damping too: damped.csv, damped_shapes.csv", false, true,
     [](Request& request, const std::string&) { request.is_damped = true; }},
    {"-o,--output", Kind::text, kStudy, "folder of the study; default results/<model name>-study", false, false,
     [](Request& request, const std::string& value) { request.output = value; }},
    {"--vary", Kind::list, kStudy,
     "parameters and how they scatter, e.g. \"k1..k4 ~ normal(500 N/mm, 10 %)\"; also lognormal, uniform(low, high), "
     "list(value, ..); repeated for others",
     false, false, [](Request& request, const std::string& value) { request.variations.push_back(value); }},
    {"--correlate", Kind::list, kStudy, "parameters whose ranks are correlated, e.g. \"k1..k4 = 0.5\"; repeated for others",
     false, false, [](Request& request, const std::string& value) { request.correlations.push_back(value); }},
    {"--cases", Kind::number, kStudy, "number of cases", false, false,
     [](Request& request, const std::string& value) { request.cases = std::stoi(value); }, false, 1, 10000000},
    {"--seed", Kind::number, kStudy, "of the random numbers; default 1", false, false,
     [](Request& request, const std::string& value) { request.seed = std::stoi(value); }, false, 0, 2147483647},
    {"--design", Kind::text, kStudy, "latin (default), sobol, random, one-at-a-time, morris or sobol-indices", false, false,
     [](Request& request, const std::string& value) { request.design = value; }},
    {"--table", Kind::text, kStudy, "CSV file with the values of each case, instead of --vary: names, units, rows", false,
     false, [](Request& request, const std::string& value) { request.table = value; }},
    {"--command", Kind::text, kStudy, "what each case does: run (default), modes or response", false, false,
     [](Request& request, const std::string& value) { request.work = value; }},
    {"--figures", Kind::list, kStudy,
     "numbers of each case, e.g. \"bolt*.force.z:peak,final\" (also minimum, maximum, time, mean, rms), "
     "\"mode*.frequency\"; "
     "repeated for others",
     false, false, [](Request& request, const std::string& value) { request.figures.push_back(value); }},
    {"--keep", Kind::flag, kStudy, "keep the results of every case, as its command writes them", false, false,
     [](Request& request, const std::string&) { request.keeps = true; }},
    {"--limit", Kind::text, kStudy, "a case that takes longer is stopped and has failed, e.g. \"1 min\"", false, false,
     [](Request& request, const std::string& value) { request.limit = value; }},
    {"--on", Kind::text, kStudy,
     "parallel[:hosts] (GNU parallel, over ssh) or slurm[:options of sbatch] instead of this machine's cores", false, false,
     [](Request& request, const std::string& value) { request.engine = value; }},
    {"-v,--verbose", Kind::flag, kModes, "print how the overall transfer equation is laid out", false, false,
     [](Request& request, const std::string&) { request.is_verbose = true; }},
    {"--expanded", Kind::flag, kCheck, "print the model with includes, patterns and defaults written out, and nothing else",
     false, false, [](Request& request, const std::string&) { request.is_expanded = true; }},
    {"--json", Kind::flag, kModes | kElements, "print one JSON object instead of the table", false, false,
     [](Request& request, const std::string&) { request.as_json = true; }},
    {"-q,--quiet", Kind::flag, kRun | kFrequency | kStatic | kSpectrum | kStudy | kReport | kPlot | kShow | kExport,
     "no table and no progress bar", false, false, [](Request& request, const std::string&) { request.quiet = true; }},
};

}  // namespace

std::string Option::name() const {
    const std::string_view all = names;
    const size_t comma = all.rfind(',');
    return std::string(comma == all.npos ? all : all.substr(comma + 1));
}

std::span<const Option> options() { return kOptions; }

const Option& option(const std::string& name, unsigned commands) {
    return *std::ranges::find_if(kOptions,
                                 [&](const Option& one) { return one.name() == name && (one.commands & commands) != 0; });
}

void give(Request& request, const Option& option, const std::string& value) {
    option.apply(request, value);
    request.given.emplace_back(&option, value);
}

}  // namespace dttmm::host
