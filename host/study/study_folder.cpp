// SPDX-License-Identifier: BSD-3-Clause
#include "study/study_folder.h"

#include <fmt/format.h>
#include <unistd.h>

#include "analysis/json.h"
#include "analysis/summary.h"
#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/csv_file.h"
#include "record/file.h"
#include "record/results_folder.h"

namespace dttmm::host {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFormat = "dttmm-study/1";
constexpr const char *kStudyFile = "study.json", *kCasesFile = "cases.csv", *kModelFolder = "model";

void copy_into(const fs::path& from, const fs::path& to) {
    std::error_code fault;
    fs::create_directories(to.parent_path(), fault);
    fs::copy_file(from, to, fault);
    if (fault) throw file_error(to, "cannot be written", fault.value());
}

/// Where a file that the model names stands in the study's folder. What the model reaches by a path upwards or from the root
/// could not be found from there.
fs::path place_of_file(const fs::path& file, const fs::path& model_folder) {
    const fs::path relative = file.lexically_normal().lexically_relative(model_folder.lexically_normal());
    if (relative.empty() || *relative.begin() == ".." || relative.is_absolute())
        throw Error(
            ExitCode::model_invalid,
            fmt::format("a study keeps a copy of its model and of the files beside and below it; {} is elsewhere: put "
                        "it into the model's folder",
                        quote(file.string())));
    return fs::path(kModelFolder) / relative;
}

std::string model_file_name(const Request& request) {
    return request.model == "-" ? "model.toml" : request.model.filename().string();
}

fs::path model_folder_of(const Request& request) {
    const fs::path parent = request.model.parent_path();
    return parent.empty() ? fs::path(".") : parent;
}

std::string plugin_place(size_t index, const fs::path& plugin) {
    return fmt::format("{}/plugins/{}/{}", kModelFolder, index + 1, plugin.filename().string());
}

Json describe_options(const Request& request) {
    Json list = Json::array();
    size_t plugins = 0;
    for (const auto& [option, value] : request.given) {
        if (!option->changes_results) continue;
        const bool is_plugin = option->name() == "--plugin";
        list.push_back({option->name(), is_plugin ? plugin_place(plugins++, value) : value});
    }
    return list;
}

Json describe_columns(const std::vector<Column>& columns) {
    Json list = Json::array();
    for (const Column& column : columns) list.push_back({column.name, column.unit});
    return list;
}

std::vector<Column> columns_in(const Json& list) {
    std::vector<Column> columns;
    for (const Json& one : list) columns.push_back({one.at(0), one.at(1)});
    return columns;
}

Json describe_plan(const Request& request, const StudyPlan& plan, const Model& model) {
    Json parameters = Json::array();
    for (const Parameter& parameter : plan.parameters)
        parameters.push_back({parameter.name, parameter.unit, parameter.value});
    Json plan_text = {{"format", kFormat},
                      {"title", model.title},
                      {"command", plan.command},
                      {"model", model_file_name(request)},
                      {"options", describe_options(request)},
                      {"figures", describe_columns(plan.columns)},
                      {"figure_requests", plan.figures},
                      {"parameters", parameters},
                      {"varied", describe_columns(plan.cases.parameters)},
                      {"design", plan.design},
                      {"cases", plan.cases.cases()},
                      {"limit_s", plan.limit},
                      {"keep", plan.keeps},
                      {"inputs", describe_inputs(model, request)}};
    plan_text["inputs"].erase("options");
    return plan_text;
}

/// What two plans differ in, in words.
std::string difference(const Json& there, const Json& asked, bool cases_differ) {
    for (const auto& [key, words] : {std::pair("command", "the command differs"),
                                     {"varied", "the parameters that vary differ"},
                                     {"design", "the design differs"},
                                     {"cases", "the number of cases differs"},
                                     {"options", "the options differ"},
                                     {"figure_requests", "the figures differ"},
                                     {"figures", "the figures differ"},
                                     {"limit_s", "the limit differs"},
                                     {"keep", "what is kept differs"}})
        if (there.value(key, Json()) != asked[key]) return words;
    const Json inputs = there.value("inputs", Json::object());
    for (const auto& [key, words] : {std::pair("model_text", "the model differs"),
                                     {"files", "a file of the model differs"},
                                     {"plugins", "a plugin differs"},
                                     {"version", "the version of dttmm differs"},
                                     {"build", "the build of dttmm differs"}})
        if (inputs.value(key, Json()) != asked["inputs"].value(key, Json())) return words;
    return cases_differ ? "the values of the cases differ" : "";
}

std::string read_part(const fs::path& file) {
    std::error_code fault;
    if (fs::exists(file, fault) && !fs::is_regular_file(file, fault))
        throw Error(ExitCode::input_output, fmt::format("{}: it is not a regular file", file.string()));
    return read_whole_file(file);
}

/// Digests of all files of a study that never change, by their place in its folder.
Json describe_copies(const fs::path& folder) {
    Json copies = {{kCasesFile, digest_of(folder / kCasesFile)}};
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder / kModelFolder))
        if (entry.is_regular_file()) copies[entry.path().lexically_relative(folder).string()] = digest_of(entry.path());
    return copies;
}

/// A study of two models is none.
void check_copies(const fs::path& folder, const Json& copies) {
    std::error_code fault;
    for (const auto& [place, digest] : copies.items())
        if (!fs::is_regular_file(folder / place, fault) || !digest.is_string() ||
            digest_of(folder / place) != digest.get_ref<const std::string&>())
            throw Error(ExitCode::input_output,
                        fmt::format("{}: it is not what it was when the study was made; put it back, or make the study anew "
                                    "in another folder",
                                    (folder / place).string()));
}

const Option& option_of_study(const std::string& name) {
    for (const Option& one : options())
        if (one.name() == name && one.commands & kStudy) return one;
    throw Error(ExitCode::input_output,
                fmt::format("study.json has an option {} that this version of dttmm does not have; use "
                            "the version that made the study",
                            quote(name)));
}

}  // namespace

StudyFolder StudyFolder::make(const fs::path& path, const Request& request, const StudyPlan& plan, const Model& model) {
    const fs::path folder = from_start(path);
    const Json text = describe_plan(request, plan, model);
    const std::string cases = plan.cases.text();
    std::error_code fault;
    if (fs::exists(folder / kStudyFile, fault)) {
        const Json there = Json::parse(read_part(folder / kStudyFile), nullptr, false);
        if (!there.is_object() || !there.value("inputs", Json::object()).is_object())
            throw Error(ExitCode::input_output, fmt::format("{}: study.json is damaged", path.string()));
        const StudyFolder kept(path);
        const std::string differs = difference(there, text, read_part(folder / kCasesFile) != cases);
        if (!differs.empty())
            throw Error(
                ExitCode::input_output,
                fmt::format("{}: it holds another study, and a study is never changed: {}; give another folder with -o",
                            path.string(), differs));
        return kept;
    }
    if (fs::exists(folder, fault) && !(fs::is_directory(folder, fault) && fs::is_empty(folder, fault)))
        throw Error(ExitCode::input_output,
                    fmt::format("{}: it is neither a study nor an empty folder; give another one with -o", path.string()));
    // Whole under another name first: nobody sees half a study
    fs::path part = folder;
    part += fmt::format(".part-{}", ::getpid());
    fs::create_directories(part / "journal", fault);
    if (fault) throw file_error(part, "cannot be made", fault.value());
    try {
        fs::create_directories(part / kModelFolder, fault);
        write_atomically(part / kModelFolder / model_file_name(request), model.source);
        for (const fs::path& file : model.files) {
            const fs::path to = part / place_of_file(file, model_folder_of(request));
            if (!fs::exists(to, fault)) copy_into(file, to);
        }
        for (size_t i = 0; i < request.plugins.size(); ++i)
            copy_into(request.plugins[i], part / plugin_place(i, request.plugins[i]));
        write_atomically(part / kCasesFile, cases);
        Json whole = text;
        whole["command_line"] = request.command_line;
        whole["copies"] = describe_copies(part);
        write_atomically(part / kStudyFile, whole.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
        fs::rename(part, folder, fault);
        if (fault && fs::exists(folder / kStudyFile)) {  // another command has just made it
            fs::remove_all(part, fault);
            return make(path, request, plan, model);
        }
        if (fault) throw file_error(folder, "cannot be made", fault.value());
    } catch (...) {
        fs::remove_all(part, fault);
        throw;
    }
    return StudyFolder(path);
}

StudyFolder::StudyFolder(const fs::path& path) : path_(from_start(path)) {
    std::error_code fault;
    if (!fs::exists(path_ / kStudyFile, fault))
        throw Error(ExitCode::input_output,
                    fmt::format("{}: this is no folder of a study: it has no study.json", path.string()));
    const Json text = Json::parse(read_part(path_ / kStudyFile), nullptr, false);
    try {
        if (text.at("format") != kFormat)
            throw Error(ExitCode::input_output, fmt::format("{}: study.json is of the format {}, not {}", path.string(),
                                                            text.at("format").dump(), kFormat));
        check_copies(path_, text.value("copies", Json::object()));
        plan_.command = text.at("command");
        const bool is_known = plan_.command == "run" || plan_.command == "modes" || plan_.command == "response";
        const std::string model_name = text.at("model");
        if (!is_known || model_name.find('/') != model_name.npos || model_name.starts_with("..") || text.at("limit_s") < 0)
            throw Error(ExitCode::input_output, fmt::format("{}: study.json is damaged", path.string()));
        plan_.request.model = path_ / kModelFolder / text.at("model").get<std::string>();
        for (const Json& given : text.at("options")) {
            const std::string name = given.at(0), value = given.at(1);
            give(plan_.request, option_of_study(name), name == "--plugin" ? (path_ / value).string() : value);
        }
        plan_.columns = columns_in(text.at("figures"));
        plan_.figures = text.at("figure_requests").get<std::vector<std::string>>();
        for (const Json& one : text.at("parameters")) plan_.parameters.push_back({one.at(0), one.at(2), one.at(1), {}});
        plan_.limit = text.at("limit_s");
        plan_.design = text.at("design");
        plan_.keeps = text.at("keep");
        title_ = text.value("title", "");
        command_line_ = text.value("command_line", "");
        plan_.cases = CaseTable::parse(read_part(path_ / kCasesFile), path / kCasesFile);
        if (plan_.cases.cases() != text.at("cases").get<size_t>())
            throw Error(ExitCode::input_output, fmt::format("{}: cases.csv has {} cases, study.json {}", path.string(),
                                                            plan_.cases.cases(), text.at("cases").dump()));
    } catch (const Json::exception&) {
        throw Error(ExitCode::input_output, fmt::format("{}: study.json is damaged", path.string()));
    }
}

std::vector<CaseOutcome> StudyFolder::outcomes() const {
    std::vector<CaseOutcome> all(plan_.cases.cases());
    Journals(journal()).read([&](size_t index, CaseOutcome&& outcome) {
        if (index >= all.size()) return;
        CaseOutcome& kept = all[index];
        if (kept.status == "missing" || counts_more(outcome, kept)) kept = std::move(outcome);
    });
    return all;
}

}  // namespace dttmm::host
