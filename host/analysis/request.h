// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "model/read_model.h"

namespace dttmm::host {

struct Option;

/// Of a run.
struct RunOptions {
    std::optional<std::filesystem::path> trace;  ///< file with a row per step
    bool force = false;                          ///< an explicit coupling beyond its limit
    bool records_motion = false;                 ///< where all parts are, for a report
};

struct ModesOptions {
    bool is_verbose = false;  ///< print how the overall transfer equation is laid out
    std::string determinant;  ///< over these frequencies, "1Hz..200Hz:400"
    std::string matrix;       ///< the overall matrix at this frequency, a text with unit
    std::string shapes;       ///< a CSV file to compare the shapes with
    bool is_damped = false;   ///< with damping too
    bool as_json = false;     ///< one JSON object on the standard output instead of the table
};

/// Of frf and response.
struct ResponseOptions {
    std::string input, response;               ///< frf: what is moved and what is looked at, "plate.corner1.z"
    std::vector<std::string> inputs, outputs;  ///< response: unit inputs, and patterns of channels
    std::string from, to;                      ///< lowest and highest frequency, texts with units
    int points = 0;                            ///< number of frequencies
    bool is_logarithmic = false;               ///< spaced by equal factors
    std::string rpm;                           ///< speeds, "800..6000:260"
    std::string kind;                          ///< "receptance" and so on; empty: as the outputs are
    std::vector<std::string> orders;           ///< those of the loads' orders that count; none: all
};

struct SpectrumOptions {
    std::vector<std::string> channels;  ///< patterns, perhaps several in one text, parted by commas
    std::string window, resolution;     ///< name of the taper; text with unit
    int segments = 0;                   ///< averaged; 0: one
    int identified = 0;                 ///< so many modes
    std::string speed, modes;           ///< a channel; a results folder of modes
};

/// Of report, plot and export.
struct PictureOptions {
    bool is_flat = false;              ///< report: without the machine in 3-D
    bool is_text = false;              ///< plot: in the terminal
    std::vector<std::string> formats;  ///< export: "gltf", "vtu", "mat", "uff58", "uff55"
};

/// Of the equilibrium.
struct StaticOptions {
    int buckling = 0;  ///< so many critical load factors
    std::string at;    ///< the instant whose loads count, a text with unit
};

struct StudyOptions {
    std::vector<std::string> variations, correlations;  ///< "k1..k4 ~ normal(500 N/mm, 10 %)", "k1, k2 = 0.5"
    std::filesystem::path table;                        ///< of cases
    int cases = 0, seed = 1;
    std::string design, work;          ///< how cases are spread; the command that each does
    std::vector<std::string> figures;  ///< "bolt*.force.z:peak,final"
    std::string limit, engine;         ///< of a case, a text with unit; "slurm:..", "parallel:.."
    bool keeps = false;                ///< the results of every case
};

/// Of identify, diagnose, sensitivity and optimise.
struct FitOptions {
    std::vector<std::filesystem::path> measured;         ///< files
    std::vector<std::string> maps;                       ///< "ch1 = -plate.corner1.acceleration.z"
    std::vector<std::string> free;                       ///< names of what is sought, "k1..k4"; patterns
    std::vector<std::string> bounds, priors, nuisances;  ///< "0.1..10", "k* ~ normal(500 N/mm, 10 %)", "gain"
    std::string noise;                                   ///< "1 %"
    int starts = 0;                                      ///< starting points; 0: by the data
    std::vector<std::string> suspects;                   ///< diagnose: patterns of elements
    bool is_plan = false;                                ///< diagnose: which sensors and blows would tell
    std::vector<std::string> by;                         ///< sensitivity, optimise: parameters, perhaps with ranges
    std::string goal;                                    ///< optimise: "min bolt1.force.z:peak"
};

/// What the command line asks of a command. Each command uses what its options fill in.
struct Request {
    std::filesystem::path model;
    ModelOverrides overrides;
    std::vector<std::string> plugins;             ///< paths of foreign plugins
    std::optional<std::filesystem::path> output;  ///< results folder; none: results/<model name>
    bool quiet = false;                           ///< no table, no progress
    bool is_expanded = false;                     ///< check: print the model with its patterns written out, alone
    std::vector<std::string> sweeps;              ///< "name=from..to:count", as typed
    int jobs = 0;                                 ///< cases at a time; 0: one per core

    RunOptions run;
    ModesOptions modes;
    ResponseOptions response;
    SpectrumOptions spectrum;
    PictureOptions pictures;
    StaticOptions statics;
    StudyOptions study;
    FitOptions fit;

    std::vector<std::string> patterns;  ///< channels: those to list; none: all
    std::vector<std::string> words;     ///< help: the topic; new, spectrum, report: the folders; plot: the folder, then
                                        ///< patterns; completion: the shell; check-law: the library

    std::string command_line;  ///< as typed, for summary.json
    /// The options given, with their values as typed; a flag has an empty one.
    std::vector<std::pair<const Option*, std::string>> given;
};

/// The commands, as bits.
enum Command : unsigned {
    kRun = 1,
    kCheck = 2,
    kModes = 4,
    kFrf = 8,
    kElements = 16,
    kChannels = 32,
    kHelp = 64,
    kSchema = 128,
    kNew = 256,
    kCompletion = 512,
    kManual = 1024,
    kCheckLaw = 2048,
    kStatic = 4096,
    kResponse = 8192,
    kSpectrum = 16384,
    kReport = 32768,
    kPlot = 65536,
    kStudy = 131072,
    kShow = 262144,
    kExport = 524288,
    kIdentify = 1048576,
    kDiagnose = 2097152,
    kSensitivity = 4194304,
    kOptimise = 8388608
};

/// An option of the command line. The commands, the words of a sweep's cases and what decides whether a case is run again
/// all come from the one table of options().
struct Option {
    enum class Kind : unsigned char { text, list, number, flag };
    const char* names;  ///< "-o,--output"; the last is the one that messages and files use
    Kind kind;          ///< a list may be given several times
    unsigned commands;  ///< that have it
    const char* help;
    bool reaches_cases;    ///< handed to the process of every case of a sweep
    bool changes_results;  ///< a case with another value of it is run again
    void (*apply)(Request& request, const std::string& value);
    bool is_required = false;
    int least = 0, most = 0;  ///< of a number

    std::string name() const;  ///< "--output"
};

std::span<const Option> options();
/// By its name, "--step", of one of these commands.
const Option& option(const std::string& name, unsigned commands = ~0u);

/// Takes a value: applies it, and keeps it in `given`. Throws Error(usage) for a value that cannot be read.
void give(Request& request, const Option& option, const std::string& value);

}  // namespace dttmm::host
