// SPDX-License-Identifier: BSD-3-Clause
#include "study/study.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <thread>

#include "analysis/modal_session.h"
#include "analysis/stop_signals.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/tell.h"
#include "study/collect.h"
#include "study/engine.h"
#include "study/plan.h"
#include "study/work.h"

namespace dttmm::host {

namespace {

int jobs_of(const Request& request) {
    return request.jobs > 0 ? request.jobs : as_int(std::max(1u, std::thread::hardware_concurrency()));
}

std::vector<size_t> cases_with(const std::vector<CaseOutcome>& outcomes, std::initializer_list<const char*> statuses) {
    std::vector<size_t> cases;
    for (size_t i = 0; i < outcomes.size(); ++i)
        if (std::ranges::find(statuses, outcomes[i].status) != statuses.end()) cases.push_back(i);
    return cases;
}

/// Collects, tells how it went and what to do next.
ExitCode conclude_study(const Request& request, const StudyFolder& study) {
    const std::vector<CaseOutcome> outcomes = collect(study);
    const StudyCount count = count_cases(outcomes);
    if (!request.quiet) print_statistics(study, outcomes);
    if (!request.quiet) fmt::print("{}\nresults in {}\n", describe_count(count), (study.path() / "results.csv").string());
    if (StopSignals::requested()) {
        tell(fmt::format("{}; {} of {} cases are kept, the same command goes on", StopSignals::reason(),
                         count.completed + count.failed, outcomes.size()));
        return StopSignals::exit_code();
    }
    if (count.failed > 0 && request.quiet)
        tell(fmt::format("{} of {} failed; failures.csv has the reasons", count.failed,
                         counted(outcomes.size(), "case", "cases")));
    return count.failed > 0 ? ExitCode::cases_failed : ExitCode::ok;
}

ExitCode work_here(const Request& request, const StudyFolder& study, const std::vector<size_t>& cases) {
    work_on(study, cases, jobs_of(request), request.quiet);
    return conclude_study(request, study);
}

Engine engine_of(const Request& request) {
    Engine engine = parse_engine(request.study.engine);
    if (engine.kind == Engine::Kind::slurm && request.jobs > 0)
        throw Error(ExitCode::usage,
                    "--jobs does not go with --on slurm: Slurm says how many tasks work at a time; leave it out");
    return engine;
}

ExitCode work_somewhere(const Request& request, const StudyFolder& study, const std::vector<size_t>& cases) {
    if (request.study.engine.empty() || cases.empty()) return work_here(request, study, cases);
    const Engine engine = engine_of(request);
    if (engine.kind == Engine::Kind::parallel) {
        run_by_parallel(study, cases, engine.options, request.jobs);
        return conclude_study(request, study);
    }
    const size_t tasks = submit_to_slurm(study, cases, engine.options);
    if (!request.quiet)
        fmt::print(
            "{} in {} of a job array handed to Slurm; dttmm study status {} tells how far they are, dttmm study "
            "collect {} makes the tables\n",
            counted(cases.size(), "case", "cases"), counted(tasks, "task", "tasks"), study.path().string(),
            study.path().string());
    return ExitCode::ok;
}

/// What the model file says in [study], where the command line does not say it. Options that tell which cases there are
/// count together: one on the command line replaces all of the file.
Request with_file(const Request& request, const Model& model) {
    const auto is_of_cases = [](const std::string& name) {
        return name == "--vary" || name == "--sweep" || name == "--table" || name == "--cases" || name == "--design" ||
               name == "--correlate";
    };
    const auto is_given = [&](const std::string& name) {
        return std::ranges::any_of(request.given, [&](const auto& one) { return one.first->name() == name; });
    };
    const bool has_cases = is_given("--vary") || is_given("--sweep") || is_given("--table");
    Request whole = request;
    for (const auto& [name, value] : model.study)
        if (!is_given(name) && !(has_cases && is_of_cases(name)))
            give(whole, option(name, kStudy), name == "--table" ? (request.model.parent_path() / value).string() : value);
    return whole;
}

/// The model tells what each case does, and that tells how the model is read.
Request completed(const Request& request) {
    Request trial = request;
    trial.overrides.purpose = Purpose::modes;  // wants least
    const Plugins plugins(trial.plugins);
    Request whole = with_file(request, read_model(trial.model, plugins.catalogue(), trial.overrides));
    if (whole.study.work == "modes" || whole.study.work == "response") whole.overrides.purpose = Purpose::modes;
    return whole;
}

ExitCode start_study(const Request& request) {
    if (request.model == "-")
        throw Error(ExitCode::usage, "a study keeps a copy of its model: give a file instead of the standard input");
    if (!request.study.engine.empty()) engine_of(request);  // a wrong word shows before anything is made
    const Request own = completed(request);
    const Plugins plugins(own.plugins);
    const Model model = read_model(own.model, plugins.catalogue(), own.overrides);
    const StudyPlan plan = make_plan(own, model, plugins);
    const StudyFolder study = StudyFolder::make(results_path(own, "-study"), own, plan, model);
    const std::vector<CaseOutcome> outcomes = study.outcomes();
    const std::vector<size_t> missing = cases_with(outcomes, {"missing"});
    if (missing.size() < outcomes.size() && !request.quiet)
        fmt::print("{} of {} cases are there already\n", outcomes.size() - missing.size(), outcomes.size());
    return work_somewhere(request, study, missing);
}

ExitCode print_status(const StudyFolder& study) {
    const StudyCount count = count_cases(study.outcomes());
    fmt::print("{}\n", describe_count(count));
    return ExitCode::ok;
}

const std::string& word(const Request& request, size_t index, const char* what) {
    if (index < request.words.size()) return request.words[index];
    throw Error(ExitCode::usage, fmt::format("study {}: give {}", request.words.front(), what));
}

void refuse_more_words(const Request& request, size_t count) {
    if (request.words.size() > count)
        throw Error(ExitCode::usage,
                    fmt::format("study {}: {} was not expected", request.words.front(), quote(request.words[count])));
}

/// Options of a study that is there already: what it does is fixed.
void refuse_options(const Request& request, std::initializer_list<const char*> allowed) {
    for (const auto& [option, value] : request.given)
        if (option->name() != "--quiet" && std::ranges::find(allowed, option->name()) == allowed.end())
            throw Error(ExitCode::usage,
                        fmt::format("study {}: {} was not expected: what a study does is fixed when it is made",
                                    request.words.front(), option->name()));
}

/// A name without a path.
const std::string& bare_word(const std::string& text) {
    if (text.empty() || text.find('/') != text.npos || text.starts_with('.'))
        throw Error(ExitCode::usage, fmt::format("study serve: {} is no name of a journal", quote(text)));
    return text;
}

int attempt_in(const std::string& text) {
    int attempt = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), attempt);
    if (fault != std::errc() || end != text.data() + text.size() || attempt < 0)
        throw Error(ExitCode::usage, fmt::format("study serve: {} is no number of an attempt", quote(text)));
    return attempt;
}

}  // namespace

ExitCode run_study(const Request& request) {
    const StopSignals signals;
    const std::string& first = request.words.front();
    const auto folder = [&](size_t words, std::initializer_list<const char*> allowed = {}) {
        refuse_more_words(request, words);
        StudyFolder study(word(request, 1, "the folder of the study"));
        refuse_options(request, allowed);
        return study;
    };
    if (first == "status") return print_status(folder(2));
    if (first == "collect") return conclude_study(request, folder(2));
    if (first == "retry") {
        const StudyFolder study = folder(2, {"--jobs", "--on"});
        return work_somewhere(request, study, cases_with(study.outcomes(), {"missing", "failed"}));
    }
    if (first == "work") {
        const StudyFolder study = folder(3, {"--jobs"});
        const auto cases = parse_cases(word(request, 2, "the list of cases, e.g. 1-40"), study.plan().cases.cases());
        work_on(study, cases, request.jobs > 0 ? request.jobs : 1, true);
        return StopSignals::requested() ? StopSignals::exit_code() : ExitCode::ok;
    }
    if (first == "serve") {
        const StudyFolder study = folder(5);
        const auto cases = parse_cases(word(request, 2, "the list of cases"), study.plan().cases.cases());
        return serve(study, cases, bare_word(word(request, 3, "the journal")), attempt_in(word(request, 4, "the attempt")));
    }
    refuse_more_words(request, 1);
    return start_study(request);
}

}  // namespace dttmm::host
