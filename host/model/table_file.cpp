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

std::string_view without_blanks(std::string_view text) {
    constexpr const char* kBlanks = " \t\r";
    const std::size_t begin = std::min(text.find_first_not_of(kBlanks), text.size());
    return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

std::optional<double> parse_plain_number(std::string_view text) {
    text = without_blanks(text);
    if (text.starts_with('+')) text.remove_prefix(1);
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const bool is_number = error == std::errc() && end == text.data() + text.size() && std::isfinite(number);
    return is_number ? std::optional(number) : std::nullopt;
}

std::vector<std::string_view> fields_of(std::string_view line) {
    std::vector<std::string_view> fields;
    while (true) {
        const std::size_t comma = std::min(line.find(','), line.size());
        fields.push_back(without_blanks(line.substr(0, comma)));
        if (comma == line.size()) return fields;
        line.remove_prefix(comma + 1);
    }
}

/// `count` numbers; nothing if the line is none of these.
std::optional<std::vector<double>> parse_row(std::string_view line, std::size_t count) {
    const std::vector<std::string_view> fields = fields_of(line);
    if (fields.size() != count) return std::nullopt;
    std::vector<double> row;
    for (const std::string_view field : fields) {
        const auto number = parse_plain_number(field);
        if (!number) return std::nullopt;
        row.push_back(*number);
    }
    return row;
}

/// Whether a field of the line begins like a number: it is no heading and no unit then, but a row with a fault.
bool holds_number(std::string_view line) {
    return std::ranges::any_of(fields_of(line), [](std::string_view field) {
        double number = 0;
        const std::size_t sign = field.starts_with('+') ? 1 : 0;
        const auto result = std::from_chars(field.data() + sign, field.data() + field.size(), number);
        // "info" begins like inf: of words only a whole one is a number
        const bool is_word = !std::isfinite(number) && result.ptr != field.data() + field.size();
        return result.ec != std::errc::invalid_argument && !is_word;
    });
}

/// What a line of units makes of a one in each column [SI]; nothing if it is none.
std::optional<std::vector<double>> parse_units(std::string_view line, const std::vector<TableColumn>& columns) {
    const std::vector<std::string_view> fields = fields_of(line);
    if (fields.size() != columns.size()) return std::nullopt;
    std::vector<double> scale;
    for (std::size_t c = 0; c < fields.size(); ++c) {
        if (fields[c].empty() || !measures(fields[c], columns[c].unit)) return std::nullopt;
        scale.push_back(parse_quantity("1 " + std::string(fields[c]), columns[c].unit));
    }
    return scale;
}

/// "ms,kN" of a heading such as "t [ms],F [kN]" or "time (ms),force (kN)"; empty if it has no bracket.
std::string units_in_heading(std::string_view line) {
    std::string units;
    bool has_any = false;
    for (const std::string_view field : fields_of(line)) {
        const std::size_t begin = field.find_first_of("[("), end = field.find_last_of("])");
        if (!units.empty() || field.data() != fields_of(line).front().data()) units += ',';
        if (begin == field.npos || end == field.npos || begin >= end) continue;
        units += without_blanks(field.substr(begin + 1, end - begin - 1));
        has_any = true;
    }
    return has_any ? units : "";
}

/// "time and value", "s and N", "s,N" of columns.
std::string joined(const std::vector<TableColumn>& columns, std::string TableColumn::*part, bool with_and) {
    std::string text;
    for (std::size_t c = 0; c < columns.size(); ++c)
        text += (c == 0 ? "" : !with_and ? "," : c + 1 < columns.size() ? ", " : " and ") + columns[c].*part;
    return text;
}

}  // namespace

std::vector<std::vector<double>> read_columns_file(const fs::path& folder, const std::string& name,
                                                   const std::vector<TableColumn>& columns) {
    std::ifstream stream(resolve(folder, name), std::ios::binary);
    if (!stream) fail(name, "cannot be read");
    const std::string words = joined(columns, &TableColumn::word, true),
                      units_and = joined(columns, &TableColumn::unit, true),
                      units = joined(columns, &TableColumn::unit, false);
    std::vector<std::vector<double>> rows;
    std::vector<double> scale(columns.size(), 1);
    std::string line;
    bool may_be_heading = true, may_be_units = true;
    for (int number = 1; std::getline(stream, line); ++number) {
        const std::string_view content = without_blanks(line);
        if (content.empty() || content.starts_with('#')) continue;
        auto row = parse_row(content, columns.size());
        if (!row && may_be_units && !holds_number(content)) {
            const std::string bracketed = may_be_heading ? units_in_heading(content) : "";
            const auto given = parse_units(bracketed.empty() ? content : bracketed, columns);
            if (!bracketed.empty() && !given)
                fail(name, fmt::format("line {}: the units in brackets are not {} of {}, e.g. \"{}\"", number,
                                       columns.size() == 2 ? "both" : "all", units_and,
                                       joined(columns, &TableColumn::heading, false)));
            if (given) {
                scale = *given;
                may_be_units = false;
            } else if (!may_be_heading) {
                fail(name, fmt::format("line {}: expected numbers, or the units of {} in {}, e.g. \"{}\"", number, words,
                                       units_and, units));
            }
            may_be_heading = false;
            continue;
        }
        if (!row)
            fail(name, fmt::format("line {}: expected {} finite numbers, {}, and a comma{}; a heading holds no number",
                                   number, columns.size() == 2 ? "two" : std::to_string(columns.size()), words,
                                   columns.size() == 2 ? "" : " between them"));
        may_be_heading = may_be_units = false;
        for (std::size_t c = 0; c < columns.size(); ++c) (*row)[c] *= scale[c];
        if (!rows.empty() && row->front() <= rows.back().front())
            fail(name, fmt::format("line {}: the {} must increase from row to row", number, columns[0].plural));
        rows.push_back(std::move(*row));
    }
    if (stream.bad()) fail(name, "cannot be read to its end");
    if (rows.empty()) fail(name, fmt::format("has no rows of {}", words));
    return rows;
}

TimeTable read_table_file(const fs::path& folder, const std::string& name, std::string_view unit) {
    TimeTable table;
    for (const std::vector<double>& row : read_columns_file(
             folder, name,
             {{"time", "times", "s", "t [ms]"}, {"value", "values", std::string(unit), fmt::format("y [{}]", unit)}})) {
        table.times.push_back(row[0]);
        table.values.push_back(row[1]);
    }
    return table;
}

}  // namespace dttmm::host
