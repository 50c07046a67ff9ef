// SPDX-License-Identifier: BSD-3-Clause
#include "study/engine.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <sstream>

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

struct Ended {
    int status = 0;      ///< exit code, or −1: it could not be started
    std::string output;  ///< standard output and error
};

/// Runs a program of the path, without a shell, to its end; a stop by the user reaches it as a signal.
Ended run_program(const std::vector<std::string>& words) {
    std::array<int, 2> pipe_ends{};
    if (::pipe2(pipe_ends.data(), O_CLOEXEC) != 0)
        throw Error(ExitCode::resource_limit, fmt::format("no pipe for a program: {}", std::strerror(errno)));
    std::vector<char*> arguments;
    for (const std::string& one : words) arguments.push_back(const_cast<char*>(one.c_str()));
    arguments.push_back(nullptr);
    const pid_t child = ::fork();
    if (child < 0)
        throw Error(ExitCode::resource_limit, fmt::format("a program could not be started: {}", std::strerror(errno)));
    if (child == 0) {
        ::dup2(pipe_ends[1], STDOUT_FILENO);
        ::dup2(pipe_ends[1], STDERR_FILENO);
        ::execvp(arguments[0], arguments.data());
        ::_exit(127);
    }
    ::close(pipe_ends[1]);
    Ended ended;
    std::array<char, 4096> buffer{};
    bool is_told = false;
    for (;;) {
        if (StopSignals::requested() && !is_told) {
            ::kill(child, SIGTERM);
            is_told = true;
        }
        const ssize_t size = ::read(pipe_ends[0], buffer.data(), buffer.size());
        if (size < 0 && errno == EINTR) continue;
        if (size <= 0) break;
        ended.output.append(buffer.data(), as_size(size));
    }
    ::close(pipe_ends[0]);
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    ended.status = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    return ended;
}

/// The last lines of what a program said.
std::string last_words(const std::string& output) {
    std::string text = output.size() > 500 ? output.substr(output.size() - 500) : output;
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return printable(text);
}

void refuse_failure(const Ended& ended, const char* program, const char* package) {
    if (ended.status == 127)
        throw Error(ExitCode::input_output, fmt::format("{} is not installed: sudo apt-get install {}", program, package));
    throw Error(ExitCode::input_output,
                fmt::format("{} ended with code {}: {}", program, ended.status, last_words(ended.output)));
}

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
    const Ended ended = run_program(words);
    // A code from 1 to 100 counts jobs that failed: their cases are missing, which the tables tell
    if (!StopSignals::requested() && ended.status > 100) refuse_failure(ended, "GNU parallel", "parallel");
    if (!StopSignals::requested() && ended.status != 0)
        throw Error(ExitCode::input_output, fmt::format("GNU parallel: {} of {} jobs failed: {}; the same command goes on "
                                                        "with what is missing",
                                                        ended.status, count, last_words(ended.output)));
}

size_t submit_to_slurm(const StudyFolder& study, const std::vector<size_t>& cases, const std::string& options) {
    const Ended site = run_program({"scontrol", "show", "config"});
    if (site.status != 0) refuse_failure(site, "scontrol (Slurm)", "slurm-wlm");
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
    const Ended submitted = run_program(words);
    if (submitted.status != 0) refuse_failure(submitted, "sbatch", "slurm-wlm");
    return count;
}

}  // namespace dttmm::host
