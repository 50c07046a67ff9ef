// SPDX-License-Identifier: BSD-3-Clause
#include "record/csv_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>

#include "model/index.h"
#include "model/wording.h"
#include "record/file.h"

namespace dttmm::host {

std::string read_whole_file(const std::filesystem::path& path) {
    std::error_code fault;
    if (std::filesystem::is_directory(path, fault)) throw file_error(path, "cannot read", EISDIR);
    if (std::filesystem::is_character_file(path, fault) || std::filesystem::is_block_file(path, fault))
        throw Error(ExitCode::input_output, fmt::format("{}: cannot read: it is a device, not a file", path.string()));
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    if (!file) throw file_error(path, "cannot read", errno ? errno : ENOENT);
    std::string text;
    const auto size = std::filesystem::file_size(path, fault);
    if (!fault) text.reserve(size);
    std::vector<char> block(1 << 20);
    while (file.read(block.data(), static_cast<std::streamsize>(block.size())), file.gcount() > 0)
        text.append(block.data(), static_cast<std::size_t>(file.gcount()));
    if (file.bad()) throw file_error(path, "cannot read", errno);
    return text;
}

std::vector<std::string> csv_record(std::string_view text, std::size_t& begin) {
    std::vector<std::string> fields(1);
    bool is_quoted = false;
    for (; begin < text.size() && (is_quoted || text[begin] != '\n'); ++begin) {
        const char c = text[begin];
        if (c == '"') {
            if (is_quoted && begin + 1 < text.size() && text[begin + 1] == '"')
                fields.back() += text[begin++];
            else
                is_quoted = !is_quoted;
        } else if (c == ',' && !is_quoted) {
            fields.emplace_back();
        } else if (c != '\r') {
            fields.back() += c;
        }
    }
    ++begin;
    return fields;
}

CsvFile::CsvFile(std::filesystem::path path) : path_(std::move(path)) {
    const std::string text = read_whole_file(path_);
    std::size_t begin = 0;
    const std::vector<std::string> names = csv_record(text, begin);
    if (begin >= text.size()) fail(1, "this is no table of results: its first line are names, the second their units");
    const std::vector<std::string> units = csv_record(text, begin);
    if (units.size() != names.size())
        fail(2, fmt::format("{} units, but {} names: this is no table of results", units.size(), names.size()));
    for (std::size_t c = 0; c < names.size(); ++c) columns_.push_back({names[c], units[c]});
    texts_.resize(columns_.size());
    numbers_.resize(columns_.size());
    is_torn_ = !text.ends_with('\n');
    const std::string_view whole = std::string_view(text).substr(0, text.rfind('\n') + 1);
    for (std::size_t line = 3; begin < whole.size(); ++line, ++rows_) {
        const std::vector<std::string> fields = csv_record(whole, begin);
        if (fields.size() != columns_.size())
            fail(line, fmt::format("{} fields, but {} names", fields.size(), columns_.size()));
        for (std::size_t c = 0; c < fields.size(); ++c) take(c, fields[c], line);
    }
}

void CsvFile::take(std::size_t column, const std::string& field, std::size_t line) {
    if (is_text(column)) {
        texts_[column].push_back(field);
        return;
    }
    double value = std::numeric_limits<double>::quiet_NaN();
    if (!field.empty()) {
        const auto [stop, fault] = std::from_chars(field.data(), field.data() + field.size(), value);
        if (fault != std::errc() || stop != field.data() + field.size())
            fail(line, fmt::format("{} of the column {} is no number", quote(field), quote(columns_[column].name)));
    }
    numbers_[column].push_back(value);
}

int CsvFile::find(std::string_view name) const {
    const auto found = std::ranges::find(columns_, name, &Column::name);
    return found == columns_.end() ? -1 : as_int(found - columns_.begin());
}

void CsvFile::fail(std::size_t line, const std::string& fault) const {
    throw Error(ExitCode::input_output, fmt::format("{}:{}: {}", path_.string(), line, fault));
}

}  // namespace dttmm::host
