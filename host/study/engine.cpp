// SPDX-License-Identifier: BSD-3-Clause
#include "study/engine.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <sstream>

#include "analysis/program.h"
#include "analysis/stop_signals.h"
#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/file.h"
#include "study/work.h"

namespace dttmm::host {

namespace {

namespace fs = std::filesystem;

std::string program_path() { return fs::read_symlink("/proc/self/exe").string(); }

/// Texts for a shell: between single quotes.
std::string shell_word(const std::string& text) {
    std::string word = "'";
    for (const char c : text) word += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return word + "'";
}

/// Chunks of cases as a file, a line each, that stays: what a task works on never changes. Returns the file and the number
/// of lines.
std::pair<fs::path, size_t> write_chunks(const StudyFolder& study, const std::vector<size_t>& cases, size_t most_chunks) {
    const fs::path folder = study.path() / "submissions";
    std::error_code fault;
    fs::create_directories(folder, fault);
    if (fault) throw file_error(folder, "cannot be made", fault.value());
    const size_t count = std::clamp(most_chunks, size_t{1}, cases.size());
    std::string text;
    for (size_t i = 0; i < count; ++i) {
        const size_t begin = i * cases.size() / count, end = (i + 1) * cases.size() / count;
        text += describe_cases({cases.begin() + as_row(begin), cases.begin() + as_row(end)}) + "\n";
    }
    const fs::path file = folder / (Journal::make_name() + ".txt");
    write_atomically(file, text);
    return {file, count};
}

/// A name of the site's configuration; `otherwise` where it does not say.
size_t site_limit(const std::string& configuration, const std::string& name, size_t otherwise) {
    std::istringstream in(configuration);
    std::string line;
    while (std::getline(in, line)) {
        if (!line.starts_with(name)) continue;
        const size_t equals = line.find('=');
        if (equals == line.npos) continue;
        try {
            return std::stoul(line.substr(equals + 1));
        } catch (const std::exception&) {
            return otherwise;
        }
    }
    return otherwise;
}

std::vector<std::string> split_words(const std::string& text) {
    std::istringstream in(text);
    std::vector<std::string> words;
    std::string one;
    while (in >> one) words.push_back(one);
    return words;
}

}  // namespace

Engine parse_engine(const std::string& text) {
    const size_t colon = text.find(':');
    const std::string name = text.substr(0, colon), options = colon == text.npos ? "" : text.substr(colon + 1);
    if (name == "parallel") return {Engine::Kind::parallel, options};
    if (name == "slurm") return {Engine::Kind::slurm, options};
    throw Error(ExitCode::usage,
                fmt::format("--on {}: there is no such engine{}", quote(text), suggestion(name, {"parallel", "slurm"})));
}

void run_by_parallel(const StudyFolder& study, const std::vector<size_t>& cases, const std::string& hosts, int jobs) {
    constexpr size_t kMostChunks = 200;
    const auto [file, count] = write_chunks(study, cases, kMostChunks);
    std::vector<std::string> words = {"parallel", "--will-cite", "--plain"};
    if (jobs > 0) words.insert(words.end(), {"--jobs", std::to_string(jobs)});
    if (!hosts.empty()) words.insert(words.end(), {"--sshlogin", hosts});
    words.insert(words.end(), {"--arg-file", file.string(),
                               fmt::format("{} study work {} {{}}", shell_word(program_path()), shell_word(study.path()))});
    const ProgramEnd ended = run_program(words);
    // A code from 1 to 100 counts jobs that failed: their cases are missing, which the tables tell
    if (!StopSignals::requested() && ended.status > 100) refuse_failed(ended, "GNU parallel", "parallel");
    if (!StopSignals::requested() && ended.status != 0)
        throw Error(ExitCode::input_output, fmt::format("GNU parallel: {} of {} jobs failed: {}; the same command goes on "
                                                        "with what is missing",
                                                        ended.status, count, ended.last_words()));
}

size_t submit_to_slurm(const StudyFolder& study, const std::vector<size_t>& cases, const std::string& options) {
    const ProgramEnd site = run_program({"scontrol", "show", "config"});
    if (site.status != 0) refuse_failed(site, "scontrol (Slurm)", "slurm-wlm");
    constexpr size_t kMostTasks = 1000;
    const size_t most = std::min(
        {site_limit(site.output, "MaxArraySize", 1001) - 1, site_limit(site.output, "MaxJobCount", 10000) / 2, kMostTasks});
    const auto [file, count] = write_chunks(study, cases, most);
    const std::string script = fmt::format(
        "#!/bin/sh\n"
        "# A task of this array works on the cases in one line of the file.\n"
        "exec {} study work {} \"$(sed -n \"${{SLURM_ARRAY_TASK_ID}}p\" {})\"\n",
        shell_word(program_path()), shell_word(study.path()), shell_word(file));
    fs::path script_file = file;
    script_file.replace_extension(".sh");
    write_atomically(script_file, script);
    fs::path log = file;
    log.replace_extension();
    std::vector<std::string> words = {"sbatch", "--parsable", fmt::format("--array=1-{}", count), "--job-name=dttmm-study",
                                      fmt::format("--output={}-%a.log", log.string())};
    for (const std::string& word : split_words(options)) words.push_back(word);
    words.push_back(script_file.string());
    const ProgramEnd submitted = run_program(words);
    if (submitted.status != 0) refuse_failed(submitted, "sbatch", "slurm-wlm");
    return count;
}

}  // namespace dttmm::host
