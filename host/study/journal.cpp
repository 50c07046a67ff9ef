// SPDX-License-Identifier: BSD-3-Clause
#include "study/journal.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cmath>
#include <fstream>
#include <limits>

#include "analysis/json.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

namespace fs = std::filesystem;

constexpr const char* kEnding = ".jsonl";

File make_new(const fs::path& file) {
    std::error_code fault;
    if (fs::exists(file, fault)) throw file_error(file, "is there already", EEXIST);
    return File::create(file);
}

/// A whole line of a journal; nothing where it is none.
std::optional<std::pair<size_t, CaseOutcome>> parse_end(const Json& line) {
    const auto is_whole = [&](const char* key) { return line.contains(key) && line[key].is_number_unsigned(); };
    if (!is_whole("end") || !is_whole("warnings") || !is_whole("attempt") || !line.contains("figures") ||
        !line["figures"].is_array() || !line.contains("status") || !line["status"].is_string())
        return std::nullopt;
    CaseOutcome outcome;
    outcome.status = line["status"];
    outcome.reason = line.value("reason", "");
    outcome.warnings = line["warnings"];
    outcome.attempt = line["attempt"];
    outcome.unlisted = line.contains("unlisted");
    for (const Json& figure : line["figures"])
        outcome.figures.push_back(figure.is_number() ? figure.get<double>() : std::numeric_limits<double>::quiet_NaN());
    return std::pair(line["end"].get<size_t>() - 1, std::move(outcome));
}

}  // namespace

bool counts_more(const CaseOutcome& one, const CaseOutcome& other) {
    const bool is_completed = one.status == "completed", other_is = other.status == "completed";
    return is_completed != other_is ? is_completed : one.attempt > other.attempt;
}

Journal::Journal(const fs::path& folder, const std::string& name) : file_(make_new(folder / (name + kEnding))) {}

std::string Journal::make_name() {
    char host[256] = "host";
    ::gethostname(host, sizeof host - 1);
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return fmt::format("{}-{}-{}", host, ::getpid(), std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

void Journal::begin(size_t index) { write_line(fmt::format("{{\"begin\":{}}}\n", index + 1)); }

void Journal::end(size_t index, const CaseOutcome& outcome) {
    Json figures = Json::array();
    for (const double value : outcome.figures) figures.push_back(std::isfinite(value) ? Json(value) : Json());
    Json line = {{"end", index + 1},           {"status", outcome.status},
                 {"reason", outcome.reason},   {"warnings", outcome.warnings},
                 {"attempt", outcome.attempt}, {"figures", figures}};
    if (outcome.unlisted) line["unlisted"] = true;
    write_line(line.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
}

void Journal::write_line(const std::string& line) {
    if (file_.write_some(line) == line.size()) {
        size_ += line.size();
        return;
    }
    const int fault = errno;
    file_.truncate(size_);
    throw file_error(file_.path(), "cannot be written", fault);
}

void Journals::read(const std::function<void(size_t index, CaseOutcome&& outcome)>& take) {
    std::error_code fault;
    const fs::directory_iterator entries(folder_, fault);
    if (fault) throw file_error(folder_, "cannot be read", fault.value());
    for (const fs::directory_entry& entry : entries)
        if (entry.path().extension() == kEnding) {
            Reading& reading = readings_[entry.path().stem().string()];
            const std::uintmax_t size = entry.file_size(fault);
            if (fault) throw file_error(entry.path(), "cannot be read", fault.value());
            if (size > reading.done) read_file(entry.path(), reading, take);
        }
}

void Journals::read_file(const fs::path& file, Reading& reading,
                         const std::function<void(size_t index, CaseOutcome&& outcome)>& take) const {
    errno = 0;
    std::ifstream in(file, std::ios::binary);
    if (!in) throw file_error(file, "cannot be read", errno);
    in.seekg(static_cast<std::streamoff>(reading.done));
    std::string text;
    while (std::getline(in, text) && !in.eof()) {  // a line without its end is still being written, or never will be
        reading.done += text.size() + 1;
        const Json line = Json::parse(text, nullptr, false);
        if (!line.is_object()) continue;
        if (line.contains("begin") && line["begin"].is_number_unsigned()) reading.open = line["begin"].get<size_t>() - 1;
        if (auto ended = parse_end(line)) {
            reading.open.reset();
            take(ended->first, std::move(ended->second));
        }
    }
}

std::optional<size_t> Journals::open_case(const std::string& name) const {
    const auto found = readings_.find(name);
    return found == readings_.end() ? std::nullopt : found->second.open;
}

}  // namespace dttmm::host
