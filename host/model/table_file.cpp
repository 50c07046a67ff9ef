// SPDX-License-Identifier: BSD-3-Clause
#include "model/table_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <optional>
#include <system_error>

#include "model/error.h"
#include "model/units.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestPath = 255;            // [byte]
constexpr std::uintmax_t kLargestTable = 64u << 20;  // [byte]

[[noreturn]] void fail(const std::string& name, const std::string& text) {
    throw Error(ExitCode::model_invalid, fmt::format("table file {} {}", quote(name), text));
}

void check_name(const std::string& name) {
    const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; };
    if (name.empty()) fail(name, "has no name");
    if (name.size() > kLongestPath) fail(name, fmt::format("has a name longer than {} characters", kLongestPath));
    if (std::any_of(name.begin(), name.end(), is_control)) fail(name, "has a control character in its name");
}

bool is_inside(const fs::path& folder, const fs::path& file) {
    return std::mismatch(folder.begin(), folder.end(), file.begin(), file.end()).first == folder.end();
}

/// The file with all links resolved, checked to be a regular one inside the folder.
fs::path resolve(const fs::path& folder, const std::string& name) {
    check_name(name);
    std::error_code error;
    const fs::path root = fs::canonical(folder.empty() ? "." : folder, error);
    if (error) fail(name, "cannot be found: " + error.message());
    const fs::path wanted = (root / name).lexically_normal();
    if (fs::path(name).is_absolute() || !is_inside(root, wanted)) fail(name, "is outside the model folder");
    const fs::path file = fs::canonical(wanted, error);
    if (error) fail(name, "cannot be read: " + error.message());
    if (!is_inside(root, file)) fail(name, "is outside the model folder, by a link");
    if (!fs::is_regular_file(file, error)) fail(name, "is not a regular file");
    if (fs::file_size(file, error) > kLargestTable || error) fail(name, "is larger than 64 MiB");
    return file;
}

std::string_view trimmed(std::string_view text) {
    constexpr const char* kBlanks = " \t\r";
    const std::size_t begin = std::min(text.find_first_not_of(kBlanks), text.size());
    return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::optional<double> parse_plain_number(std::string_view text) {
    text = trimmed(text);
    if (text.starts_with('+')) text.remove_prefix(1);
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const bool is_number = error == std::errc() && end == text.data() + text.size() && std::isfinite(number);
    return is_number ? std::optional(number) : std::nullopt;
}

struct Row {
    double time, value;
};

std::optional<Row> parse_row(std::string_view line) {
    const std::size_t comma = line.find(',');
    if (comma == line.npos) return std::nullopt;
    const auto time = parse_plain_number(line.substr(0, comma));
    const auto value = parse_plain_number(line.substr(comma + 1));
    return time && value ? std::optional(Row{*time, *value}) : std::nullopt;
}

/// Whether a field of the line begins like a number: it is no heading and no unit then, but a row with a fault.
bool holds_number(std::string_view line) {
    while (true) {
        const std::size_t comma = std::min(line.find(','), line.size());
        const std::string_view field = trimmed(line.substr(0, comma));
        double number = 0;
        const std::size_t sign = field.starts_with('+') ? 1 : 0;
        const auto result = std::from_chars(field.data() + sign, field.data() + field.size(), number);
        // "info" begins like inf: of words only a whole one is a number
        const bool is_word = !std::isfinite(number) && result.ptr != field.data() + field.size();
        if (result.ec != std::errc::invalid_argument && !is_word) return true;
        if (comma == line.size()) return false;
        line.remove_prefix(comma + 1);
    }
}

/// What a line of units makes of a time of one and a value of one [s, `unit`]; nothing if it is none.
std::optional<Row> parse_units(std::string_view line, std::string_view unit) {
    const std::size_t comma = line.find(',');
    if (comma == line.npos) return std::nullopt;
    const auto in_si = [](std::string_view text, std::string_view wanted) {
        return parse_quantity("1 " + std::string(trimmed(text)), wanted);
    };
    const std::string_view time = trimmed(line.substr(0, comma)), value = trimmed(line.substr(comma + 1));
    if (time.empty() || value.empty() || !measures(time, "s") || !measures(value, unit)) return std::nullopt;
    return Row{in_si(time, "s"), in_si(value, unit)};
}

/// "ms,kN" of a heading such as "t [ms],F [kN]" or "time (ms),force (kN)"; empty if it has no bracket.
std::string units_in_heading(std::string_view line) {
    std::string units;
    bool has_any = false;
    for (bool is_last = false; !is_last;) {
        const std::size_t comma = std::min(line.find(','), line.size());
        is_last = comma == line.size();
        const std::string_view field = trimmed(line.substr(0, comma));
        const std::size_t begin = field.find_first_of("[("), end = field.find_last_of("])");
        if (begin != field.npos && end != field.npos && begin < end) {
            units += trimmed(field.substr(begin + 1, end - begin - 1));
            has_any = true;
        }
        if (!is_last) {
            units += ',';
            line.remove_prefix(comma + 1);
        }
    }
    return has_any ? units : "";
}

}  // namespace

TimeTable read_table_file(const fs::path& folder, const std::string& name, std::string_view unit) {
    std::ifstream stream(resolve(folder, name), std::ios::binary);
    if (!stream) fail(name, "cannot be read");
    TimeTable table;
    Row scale = {1, 1};
    std::string line;
    bool may_be_heading = true, may_be_units = true;
    for (int number = 1; std::getline(stream, line); ++number) {
        const std::string_view content = trimmed(line);
        if (content.empty() || content.starts_with('#')) continue;
        const auto row = parse_row(content);
        if (!row && may_be_units && !holds_number(content)) {
            const std::string bracketed = may_be_heading ? units_in_heading(content) : "";
            const auto units = parse_units(bracketed.empty() ? content : bracketed, unit);
            if (!bracketed.empty() && !units)
                fail(name, fmt::format("line {}: the units in brackets are not both of s and {}, e.g. \"t [ms],y [{}]\"",
                                       number, unit, unit));
            if (units) {
                scale = *units;
                may_be_units = false;
            } else if (!may_be_heading) {
                fail(name,
                     fmt::format("line {}: expected numbers, or the units of time and value in s and {}, e.g. \"s,{}\"",
                                 number, unit, unit));
            }
            may_be_heading = false;
            continue;
        }
        if (!row)
            fail(name, fmt::format("line {}: expected two finite numbers, time and value, and a comma; a heading holds no "
                                   "number",
                                   number));
        may_be_heading = may_be_units = false;
        const double time = row->time * scale.time;
        if (!table.times.empty() && time <= table.times.back())
            fail(name, fmt::format("line {}: the times must increase from row to row", number));
        table.times.push_back(time);
        table.values.push_back(row->value * scale.value);
    }
    if (stream.bad()) fail(name, "cannot be read to its end");
    if (table.times.empty()) fail(name, "has no rows of time and value");
    return table;
}

}  // namespace dttmm::host
