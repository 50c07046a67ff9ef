// SPDX-License-Identifier: BSD-3-Clause
#include "record/results_folder.h"

#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <ctime>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "model/index.h"

namespace dttmm::host {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kMarker = ".dttmm-results";
constexpr std::string_view kPart = ".part";
constexpr std::string_view kCasePrefix = "case-";
constexpr std::string_view kStudy = "study.json";  // of a folder that `dttmm study` made
constexpr std::string_view kSweepTable = "sweep.csv";
constexpr std::array<std::string_view, 29> kResults{"mac.csv",           "overall_matrix.csv",
                                                    "determinant.csv",   "damped.csv",
                                                    "damped_shapes.csv", "energies.csv",
                                                    "history.csv",       "history.h5",
                                                    "summary.json",      "modes.csv",
                                                    "shapes.csv",        "frf.csv",
                                                    "response.csv",      "psd.csv",
                                                    "rms.csv",           "static.csv",
                                                    "members.csv",       "spectrum.csv",
                                                    "levels.csv",        "identified.csv",
                                                    "orders.csv",        "identify.json",
                                                    "diagnose.json",     "plan.csv",
                                                    "sensitivity.json",  "sensitivity.csv",
                                                    "optimise.json",     "optimise.csv",
                                                    kSweepTable};

/// Set before main: no plugin has been loaded.
const fs::path kStartFolder = [] {
    std::error_code failure;
    return fs::current_path(failure);
}();

Error refusal(const fs::path& path, std::string_view fault) {
    return Error(ExitCode::input_output, fmt::format("{}: {}; choose another folder with -o", path.string(), fault));
}

/// Sorted, so that the entry a message names does not depend on the disk.
std::vector<fs::path> read_entries(const fs::path& folder) {
    std::error_code failure;
    std::vector<fs::path> entries;
    for (fs::directory_iterator it(folder, failure), end; !failure && it != end; it.increment(failure))
        entries.push_back(it->path());
    if (failure) throw file_error(folder, "cannot list", failure.value());
    std::sort(entries.begin(), entries.end());
    return entries;
}

bool is_result_name(std::string_view name) {
    if (name.ends_with(kPart)) name.remove_suffix(kPart.size());
    // Data beside a model, a file per set of times or frequencies
    for (const std::string_view numbered : {"histories-", "responses-"})
        if (name.starts_with(numbered) && name.ends_with(".csv")) return true;
    return std::find(kResults.begin(), kResults.end(), name) != kResults.end();
}

/// A link counts as what it is, not as what it points to; what cannot be looked at is `none`.
fs::file_type type_of(const fs::path& path) {
    std::error_code failure;
    return fs::symlink_status(path, failure).type();
}

bool is_file_or_link(const fs::path& path) {
    return type_of(path) == fs::file_type::regular || type_of(path) == fs::file_type::symlink;
}

bool is_case_folder(const fs::path& path) {
    return path.filename().string().starts_with(kCasePrefix) && type_of(path) == fs::file_type::directory;
}

/// A report or export of a case, which stands beside its folder: case-000001.frames.
bool is_beside_case(const fs::path& path) {
    return path.filename().string().starts_with(kCasePrefix) && path.has_extension();
}

/// Throws Error(input_output) that names the first entry no run has written.
void check_ours(const fs::path& folder) {
    const std::vector<fs::path> entries = read_entries(folder);
    if (entries.empty()) return;
    if (type_of(folder / kStudy) == fs::file_type::regular)
        throw refusal(folder, "holds a study, which no other command replaces");
    if (type_of(folder / kMarker) != fs::file_type::regular)
        throw refusal(folder, fmt::format("holds \"{}\" and no results of dttmm", entries.front().filename().string()));
    for (const fs::path& entry : entries) {
        const std::string name = entry.filename().string();
        if (is_beside_case(entry)) continue;
        if (is_case_folder(entry)) {
            check_ours(entry);
        } else if (!is_file_or_link(entry) || (name != kMarker && !is_result_name(name))) {
            throw refusal(folder, fmt::format("holds \"{}\", which is no result of dttmm and would be in the way", name));
        }
    }
}

void make_folder(const fs::path& path) {
    std::error_code failure;
    if (fs::exists(path, failure) && !fs::is_directory(path, failure)) throw refusal(path, "is a file, not a folder");
    fs::create_directories(path, failure);
    if (failure) throw file_error(path, "cannot make the folder", failure.value());
    if (::access(path.c_str(), W_OK | X_OK) != 0) throw file_error(path, "cannot write into the folder", errno);
}

std::string read_holder(const File& marker) {
    std::array<char, 512> text{};
    const ssize_t size = ::pread(marker.descriptor(), text.data(), text.size(), 0);
    std::string holder(text.data(), size > 0 ? as_size(size) : 0);
    while (!holder.empty() && holder.back() == '\n') holder.pop_back();
    return holder.empty() ? "unknown" : holder;
}

std::string describe_this_process() {
    std::array<char, 256> host{};
    ::gethostname(host.data(), host.size() - 1);
    return fmt::format("process {} on host {}\n", ::getpid(), host.data());
}

/// The marker of `folder`, locked for us. Where the file system has no locks, we go without.
File lock_marker(const fs::path& folder) {
    File marker = File::open(folder / kMarker);
    if (::flock(marker.descriptor(), LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK)
        throw Error(
            ExitCode::input_output,
            fmt::format("{}: another run is writing into it ({}); wait for it to end, or choose another folder with -o",
                        folder.string(), read_holder(marker)));
    return marker;
}

void remove_entry(const fs::path& path) {
    std::error_code failure;
    fs::remove(path, failure);  // a link, not its target
    if (failure) throw file_error(path, "cannot remove the old result", failure.value());
}

/// Removes what a run has left; a sweep in the same folder stays whole.
void clear(const fs::path& folder) {
    for (const fs::path& entry : read_entries(folder)) {
        const std::string name = entry.filename().string();
        const bool of_sweep = name == kSweepTable || is_case_folder(entry) || is_beside_case(entry);
        if (name != kMarker && !of_sweep) remove_entry(entry);
    }
}

/// When a file was last written, local time; empty where there is none.
std::string time_of(const fs::path& file) {
    struct stat status {};
    std::tm local{};
    std::array<char, 32> text{};
    if (::stat(file.c_str(), &status) != 0 || !::localtime_r(&status.st_mtime, &local)) return {};
    return {text.data(), std::strftime(text.data(), text.size(), "%Y-%m-%d %H:%M", &local)};
}

/// Makes the folder, finds it ours or empty, and locks it.
File claim_marker(const fs::path& path) {
    make_folder(path);
    check_ours(path);
    return lock_marker(path);
}

}  // namespace

ResultsFolder::ResultsFolder(fs::path path, Claim claim)
    : path_(std::move(path)), absolute_(from_start(path_)), marker_(claim_marker(absolute_)) {
    check_ours(absolute_);  // once more: now nobody else writes here
    if (claim == Claim::replace) {
        replaced_ = time_of(absolute_ / "summary.json");
        clear(absolute_);
    }
    marker_.truncate(0);
    marker_.write(describe_this_process());
}

std::string ResultsFolder::describe(std::string_view name) const {
    const std::string place = (name.empty() ? path_ : path_ / name).string();
    return replaced_.empty() ? place : fmt::format("{} (those of {} are replaced)", place, replaced_);
}

namespace {

std::optional<fs::file_time_type> written_at(const fs::path& folder) {
    std::error_code fails;
    const fs::file_time_type time = fs::last_write_time(from_start(folder) / "summary.json", fails);
    return fails ? std::nullopt : std::optional(time);
}

}  // namespace

EarlierResults::EarlierResults(fs::path folder) : folder_(std::move(folder)), written_(written_at(folder_)) {}

std::string EarlierResults::left() const {
    if (!written_ || written_at(folder_) != written_) return {};
    return fmt::format("{} still has the results of {}", folder_.string(), time_of(from_start(folder_) / "summary.json"));
}

fs::path from_start(const fs::path& path) { return path.is_absolute() ? path : kStartFolder / path; }

fs::path default_results_path(const fs::path& model_path) {
    if (model_path == "-") return fs::path("results") / "model";
    const fs::path name = model_path.stem();
    if (name != "model") return fs::path("results") / name;
    const fs::path folder = from_start(model_path).lexically_normal().parent_path();
    return fs::path("results") / (folder.has_filename() ? folder.filename() : name);
}

}  // namespace dttmm::host
