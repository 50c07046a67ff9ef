// SPDX-License-Identifier: BSD-3-Clause
#include "report/export.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "analysis/recorded_run.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/channels.h"
#include "record/results_folder.h"
#include "report/gltf_file.h"
#include "report/mat_file.h"
#include "report/results.h"
#include "report/scene.h"
#include "report/universal_results.h"
#include "report/vtu_files.h"

namespace dttmm::host {

namespace fs = std::filesystem;

namespace {

/// Rows and recorded numbers that a film has at most, and the frames of ParaView. A number has 4 bytes in a film, of which
/// an element takes 10 per piece. In frames a body takes 48 numbers of 11 bytes for the 7 recorded: 2000 bodies make 70 MB.
constexpr MotionBounds kFilm = {2000, 2'000'000}, kFiles = {500, 1'000'000};

/// Writes the file. Returns what it has and, each in a line below, what it leaves out.
using Write = std::string (*)(const Results& results, const fs::path& path);

struct Format {
    const char *name, *ending, *magic;
    bool has_channels;  ///< --channels chooses of it
    Write write;
};

std::string write_text_file(const Results& results, const fs::path& path,
                            std::string (*write)(const Results&, std::ostream&)) {
    std::string what;
    write_atomically(path, [&](std::ostream& out) { what = write(results, out); });
    return what;
}

constexpr Format kFormats[] = {
    {"gltf", ".glb", "glTF", false,
     [](const Results& results, const fs::path& path) { return write_gltf(Scene(results, kFilm), path); }},
    {"vtu", ".pvd", "<?xml", false,
     [](const Results& results, const fs::path& path) { return write_vtu(Scene(results, kFiles), path); }},
    {"mat", ".mat", "MATLAB 5.0", true,
     [](const Results& results, const fs::path& path) { return write_mat(results, read_tables(results.folder), path); }},
    {"uff58", ".uff", "    -1", true,
     [](const Results& results, const fs::path& path) { return write_text_file(results, path, write_functions); }},
    {"uff55", ".uff", "    -1", false,
     [](const Results& results, const fs::path& path) { return write_text_file(results, path, write_modes); }},
};

std::string listed_formats() {
    std::vector<std::string> names;
    for (const Format& format : kFormats) names.push_back(fmt::format("--{}", format.name));
    return fmt::format("{}", fmt::join(names, ", "));
}

/// Those that were asked for, each once, in the order of the table.
std::vector<const Format*> chosen_formats(const Request& request) {
    std::vector<const Format*> chosen;
    for (const Format& format : kFormats)
        if (std::ranges::find(request.pictures.formats, format.name) != request.pictures.formats.end())
            chosen.push_back(&format);
    if (chosen.empty()) throw Error(ExitCode::usage, fmt::format("say which format: one or more of {}", listed_formats()));
    for (std::size_t i = 1; i < chosen.size(); ++i)
        if (std::string_view(chosen[i]->ending) == chosen[i - 1]->ending)
            throw Error(ExitCode::usage, fmt::format("--{} and --{} are both files {}: ask for one after the other, with -o",
                                                     chosen[i - 1]->name, chosen[i]->name, chosen[i]->ending));
    if (request.output && chosen.size() > 1)
        throw Error(ExitCode::usage, "-o names one file: give it with one format, or leave it out");
    if (!request.spectrum.channels.empty() && std::ranges::none_of(chosen, &Format::has_channels))
        throw Error(ExitCode::usage, "--channels chooses the curves of --mat and --uff58; other formats have none");
    return chosen;
}

fs::path export_path(const Request& request, const Format& format) {
    if (!request.output) return path_beside(request.words.front(), format.ending);
    if (request.output->extension() != format.ending)
        throw Error(ExitCode::usage, fmt::format("{}: --{} writes a file whose name ends with {}; give it such a name",
                                                 request.output->string(), format.name, format.ending));
    return *request.output;
}

/// A file is ours where it begins as its format does, and names dttmm near its beginning.
void refuse_foreign_file(const fs::path& path, const Format& format) {
    std::error_code fault;
    if (!fs::exists(path, fault)) return;
    if (fs::is_directory(path, fault))
        throw Error(ExitCode::input_output, fmt::format("{}: is a folder; give the name of a file with -o, e.g. -o export{}",
                                                        path.string(), format.ending));
    constexpr std::streamsize kBeginning = 1000;
    std::string beginning(kBeginning, ' ');
    std::ifstream(path, std::ios::binary).read(beginning.data(), kBeginning);
    if ((!beginning.starts_with(format.magic) || beginning.find("dttmm") == beginning.npos) &&
        fs::file_size(path, fault) > 0)
        throw Error(ExitCode::input_output,
                    fmt::format("{}: is there and was not exported by dttmm; choose another file with -o", path.string()));
}

/// Keeps the curves that a pattern selects. Throws Error(usage) for a pattern without one.
void choose_curves(std::vector<CurveSet>& sets, const std::vector<std::string>& patterns) {
    if (patterns.empty()) return;
    const std::set<std::string> names = choose_names(sets, patterns, "--channels: ");
    for (CurveSet& set : sets)
        std::erase_if(set.curves, [&](const Curve& curve) { return !names.contains(curve.head.name); });
    std::erase_if(sets, [](const CurveSet& set) { return set.curves.empty(); });
}

void write_all(const Request& request, const std::vector<const Format*>& formats, const std::vector<fs::path>& paths) {
    Results results = read_results(request.words.front());
    choose_curves(results.sets, split_at_commas(request.spectrum.channels));
    for (std::size_t i = 0; i < formats.size(); ++i) {
        const std::string what = formats[i]->write(results, from_start(paths[i]));
        if (request.quiet) continue;
        std::error_code fault;
        const std::uintmax_t size = fs::file_size(from_start(paths[i]), fault);
        fmt::print("{}: {:.2f} MB, {}\n", paths[i].string(), fault ? 0 : static_cast<double>(size) / 1e6, what);
        for (const std::string& note : results.notes) fmt::print("{}\n", note);
    }
}

}  // namespace

ExitCode export_results(const Request& request) {
    const std::vector<const Format*> formats = chosen_formats(request);
    std::vector<fs::path> paths;
    for (const Format* format : formats) {
        paths.push_back(export_path(request, *format));
        refuse_foreign_file(from_start(paths.back()), *format);
    }
    try {
        write_all(request, formats, paths);
    } catch (const nlohmann::json::exception& fault) {
        throw Error(ExitCode::input_output,
                    fmt::format("{}: summary.json: damaged: {}", request.words.front(), fault.what()));
    }
    return ExitCode::ok;
}

}  // namespace dttmm::host
