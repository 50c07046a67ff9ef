// SPDX-License-Identifier: BSD-3-Clause
#include "study/work.h"

#include <fmt/format.h>
#include <sys/time.h>
#include <sys/wait.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <optional>
#include <set>

#include "analysis/process_pool.h"
#include "analysis/stop_signals.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/progress_bar.h"
#include "record/tell.h"
#include "study/case_runner.h"

namespace dttmm::host {

namespace {

/// The signal of the timer ends the process, also inside a plugin that does not return.
void limit_time(double seconds) {
    const double whole = std::floor(seconds);
    itimerval timer{};
    timer.it_value.tv_sec = static_cast<time_t>(whole);
    timer.it_value.tv_usec = static_cast<suseconds_t>(1e6 * (seconds - whole));
    ::setitimer(ITIMER_REAL, &timer, nullptr);
}

/// Cases of one process at a time: few enough that all processes end at about the same time.
std::vector<std::vector<size_t>> split(const std::vector<size_t>& cases, int jobs) {
    constexpr size_t kRounds = 8, kMostCases = 1000;
    const size_t size = std::clamp(cases.size() / (kRounds * as_size(jobs)), size_t{1}, kMostCases);
    std::vector<std::vector<size_t>> chunks;
    for (size_t begin = 0; begin < cases.size(); begin += size)
        chunks.emplace_back(cases.begin() + as_row(begin), cases.begin() + as_row(std::min(begin + size, cases.size())));
    return chunks;
}

/// One set of processes after the other, until no case is left.
class Supervisor {
public:
    Supervisor(const StudyFolder& study, size_t cases, int jobs, bool quiet)
        : study_(study), journals_(study.journal()), jobs_(jobs), total_(cases), progress_(quiet ? -1 : 2) {
        for (const CaseOutcome& outcome : study.outcomes()) attempt_ = std::max(attempt_, outcome.attempt + 1);
    }

    void work_on(std::vector<size_t> cases) {
        while (!cases.empty() && !StopSignals::requested()) {
            const size_t before = ended_.size() + taken_from_outside_.size();
            run_once(cases);
            std::erase_if(cases, [&](size_t index) { return ended_.contains(index); });
            if (fault_) throw Error(*fault_);
            if (!StopSignals::requested() && !cases.empty() && ended_.size() + taken_from_outside_.size() == before)
                throw Error(ExitCode::internal_error,
                            fmt::format("the workers of the study end without a result: {}", last_line_));
        }
    }

private:
    void run_once(const std::vector<size_t>& cases) {
        const std::vector<std::vector<size_t>> chunks = split(cases, jobs_);
        std::vector<std::string> names;
        for (size_t i = 0; i < chunks.size(); ++i) names.push_back(fmt::format("{}-{}", Journal::make_name(), ++made_));
        run_processes(
            chunks.size(), jobs_,
            [&](size_t i) {
                return std::vector<std::string>{
                    "dttmm", "study", "serve", study_.path(), describe_cases(chunks[i]), names[i], std::to_string(attempt_)};
            },
            [&](size_t i, int status, const std::string& last_line) { conclude(names[i], status, last_line); },
            [&] { look(); });
        read_journals();
    }

    void read_journals() {
        journals_.read([&](size_t index, CaseOutcome&& outcome) {
            if (outcome.attempt >= attempt_) ended_.insert(index);
        });
    }

    void look() {
        const auto now = std::chrono::steady_clock::now();
        if (now < next_look_) return;
        next_look_ = now + std::chrono::milliseconds(200);
        read_journals();
        progress_.update(static_cast<double>(ended_.size()), static_cast<double>(total_), "cases");
    }

    /// A process that did not end well has a case in its hands, or could not even note one.
    void conclude(const std::string& name, int status, const std::string& last_line) {
        if ((WIFEXITED(status) && WEXITSTATUS(status) == 0) || StopSignals::requested()) return;
        last_line_ = last_line.starts_with("dttmm: ") ? last_line.substr(7) : last_line;
        read_journals();
        const std::optional<size_t> open = journals_.open_case(name);
        const int code = WIFEXITED(status) ? WEXITSTATUS(status) : -1, signal = WIFSIGNALED(status) ? WTERMSIG(status) : 0;
        if (!open || code == static_cast<int>(ExitCode::input_output)) {
            if (code >= 0 && !fault_) fault_.emplace(static_cast<ExitCode>(code), last_line_);
            return;
        }
        const bool is_from_outside = signal == SIGKILL || signal == SIGTERM || signal == SIGHUP || signal == SIGINT ||
                                     code == static_cast<int>(ExitCode::stopped_by_user);
        if (is_from_outside && taken_from_outside_.insert(*open).second) return;
        fail(*open, signal == SIGALRM ? fmt::format("exit code {}: it took longer than its limit of {:g} s",
                                                    static_cast<int>(ExitCode::resource_limit), study_.plan().limit)
                    : signal != 0     ? fmt::format("killed by signal {} ({})", signal, strsignal(signal))
                                      : fmt::format("exit code {}: {}", code, last_line_));
    }

    void fail(size_t index, const std::string& reason) {
        if (!own_) own_.emplace(study_.journal(), fmt::format("{}-{}", Journal::make_name(), ++made_));
        CaseOutcome outcome{"failed", reason};
        outcome.attempt = attempt_;
        own_->end(index, outcome);
        ended_.insert(index);
    }

    const StudyFolder& study_;
    Journals journals_;
    int jobs_, attempt_ = 1;
    size_t total_, made_ = 0;
    ProgressBar progress_;
    std::set<size_t> ended_, taken_from_outside_;
    std::optional<Journal> own_;
    std::optional<Error> fault_;
    std::string last_line_;
    std::chrono::steady_clock::time_point next_look_;
};

}  // namespace

std::string describe_cases(const std::vector<size_t>& cases) {
    std::string text;
    for (size_t i = 0; i < cases.size();) {
        size_t end = i + 1;
        while (end < cases.size() && cases[end] == cases[end - 1] + 1) ++end;
        text += fmt::format("{}{}", text.empty() ? "" : ",", cases[i] + 1);
        if (end > i + 1) text += fmt::format("-{}", cases[end - 1] + 1);
        i = end;
    }
    return text;
}

std::vector<size_t> parse_cases(const std::string& text, size_t count) {
    std::vector<size_t> cases;
    const char *at = text.data(), *const end = at + text.size();
    const auto refuse = [&] {
        throw Error(ExitCode::usage,
                    fmt::format("{} names no cases of this study, which has {}: write 1-40,57", quote(text), count));
    };
    const auto number = [&] {
        size_t value = 0;
        const auto [next, fault] = std::from_chars(at, end, value);
        if (fault != std::errc() || value < 1 || value > count) refuse();
        at = next;
        return value - 1;
    };
    for (;;) {
        const size_t first = number();
        const size_t last = at != end && *at == '-' ? (++at, number()) : first;
        if (last < first) refuse();
        for (size_t i = first; i <= last; ++i) cases.push_back(i);
        if (at == end) return cases;
        if (*at++ != ',') refuse();
    }
}

void work_on(const StudyFolder& study, std::vector<size_t> cases, int jobs, bool quiet) {
    Supervisor(study, cases.size(), jobs, quiet).work_on(std::move(cases));
}

ExitCode serve(const StudyFolder& study, const std::vector<size_t>& cases, const std::string& journal_name, int attempt) {
    const Plugins plugins(study.plan().request.plugins);  // held, so that no case loads them again
    Journal journal(study.journal(), journal_name);
    for (const size_t index : cases) {
        if (StopSignals::requested()) return StopSignals::exit_code();
        journal.begin(index);
        if (study.plan().limit > 0) limit_time(study.plan().limit);
        CaseOutcome outcome = run_case(study.plan(), index, plugins, study.path());
        limit_time(0);
        outcome.attempt = attempt;
        journal.end(index, outcome);
    }
    return ExitCode::ok;
}

}  // namespace dttmm::host
