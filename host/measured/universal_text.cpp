// SPDX-License-Identifier: BSD-3-Clause
#include "measured/universal_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <charconv>
#include <limits>

#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr std::string_view kBlanks = " \t\r";

std::string_view without_blanks(std::string_view text) {
    const std::size_t begin = text.find_first_not_of(kBlanks);
    return begin == text.npos ? "" : text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

bool is_inner_byte(char c) { return (static_cast<unsigned char>(c) & 0xc0) == 0x80; }

/// Where its characters begin; none: it is not UTF-8. Overlong forms pass: nothing here depends on them.
std::optional<std::vector<std::size_t>> utf8_starts(std::string_view text) {
    std::vector<std::size_t> starts;
    for (std::size_t i = 0; i < text.size();) {
        const auto first = static_cast<unsigned char>(text[i]);
        const std::size_t length = first < 0x80 ? 1 : first >> 5 == 6 ? 2 : first >> 4 == 14 ? 3 : first >> 3 == 30 ? 4 : 0;
        if (length == 0 || i + length > text.size()) return std::nullopt;
        if (!std::ranges::all_of(text.substr(i + 1, length - 1), is_inner_byte)) return std::nullopt;
        starts.push_back(i);
        i += length;
    }
    return starts;
}

/// What std::from_chars does not know: D for E, and an exponent of three digits without a letter.
std::string with_exponent_letter(std::string_view field) {
    std::string text(field);
    for (char& c : text)
        if (c == 'D' || c == 'd') c = 'E';
    const std::size_t sign = text.find_last_of("+-");
    const bool has_none = text.find_first_of("Ee") == text.npos && text.find('.') != text.npos;
    if (has_none && sign != text.npos && sign > 0 && text.size() == sign + 4) text.insert(sign, "E");
    return text;
}

/// Numbers that touch: a sign that is not that of an exponent begins the next. Each has a decimal point, or they are parted
/// otherwise.
bool append_touching_reals(std::string_view field, std::vector<double>& numbers) {
    const std::size_t before = numbers.size();
    for (std::size_t begin = 0; begin < field.size();) {
        std::size_t end = std::min(field.find_first_of("+-", begin + 1), field.size());
        while (end < field.size() && std::string_view("EeDd").find(field[end - 1]) != std::string_view::npos)
            end = std::min(field.find_first_of("+-", end + 1), field.size());
        const std::string_view one = field.substr(begin, end - begin);
        const auto value = parse_fortran_real(one);
        if (!value || one.find('.') == one.npos) {
            numbers.resize(before);
            return false;
        }
        numbers.push_back(*value);
        begin = end;
    }
    return true;
}

}  // namespace

std::string_view UniversalText::peek() const {
    std::string_view line = rest();
    line = line.substr(0, line.find('\n'));
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
}

std::string_view UniversalText::next() {
    const std::string_view line = peek();
    line_begin_ = at_;
    const std::size_t end = bytes_.find('\n', at_);
    at_ = end == bytes_.npos ? bytes_.size() : end + 1;
    ++line_;
    return line;
}

void UniversalText::skip_blank() {
    while (!is_at_end() && without_blanks(peek()).empty()) next();
}

std::string_view UniversalText::take(std::size_t count) {
    assert(count <= rest().size());
    const std::string_view taken = rest().substr(0, count);
    at_ += count;
    has_binary_ = true;
    return taken;
}

std::string UniversalText::place() const {
    return has_binary_ ? fmt::format("{}: byte {}", file_, line_begin_) : fmt::format("{}:{}", file_, line_);
}

void UniversalText::fail(const std::string& fault) const {
    throw Error(ExitCode::input_output, fmt::format("{}: {}", place(), fault));
}

bool is_universal_mark(std::string_view line) {
    return without_blanks(line.substr(0, 6)) == "-1" && without_blanks(line) == "-1";
}

FixedFields::FixedFields(std::string_view line, std::span<const std::size_t> blanks, std::size_t width) : line_(line) {
    const auto starts = utf8_starts(line);
    if (!starts || starts->size() == line.size()) return;
    const auto is_blank = [&](std::size_t byte) { return byte >= line.size() || line[byte] == ' '; };
    const bool bytes_fit = std::ranges::all_of(blanks, is_blank);
    const bool characters_fit = std::ranges::all_of(
        blanks, [&](std::size_t column) { return column >= starts->size() || is_blank((*starts)[column]); });
    const std::size_t bytes = line.find_last_not_of(kBlanks) + 1;
    const auto characters = std::ranges::count_if(*starts, [&](std::size_t start) { return start < bytes; });
    const bool is_too_long = bytes > width && as_size(characters) <= width;
    if (characters_fit && (!bytes_fit || is_too_long)) starts_ = *starts;
}

std::string_view FixedFields::field(std::size_t first, std::size_t width) const {
    const auto byte_of = [&](std::size_t column) {
        if (starts_.empty()) return std::min(column, line_.size());
        return column < starts_.size() ? starts_[column] : line_.size();
    };
    const std::size_t begin = byte_of(first);
    return line_.substr(begin, byte_of(first + width) - begin);
}

std::string universal_text_of(std::string_view field) {
    const std::string_view text = without_blanks(field);
    if (text == "NONE") return {};
    if (utf8_starts(text)) return std::string(text);
    std::string converted;
    for (const char c : text) {
        const auto code = static_cast<unsigned char>(c);
        if (code < 0x80) {
            converted += c;
        } else {
            converted += static_cast<char>(0xc0 | code >> 6);
            converted += static_cast<char>(0x80 | (code & 0x3f));
        }
    }
    return converted;
}

std::optional<double> parse_fortran_real(std::string_view field) {
    field = without_blanks(field);
    if (field.starts_with('+')) field.remove_prefix(1);
    const auto parse = [](std::string_view text) -> std::optional<double> {
        double value = 0;
        const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
        if (end != text.data() + text.size()) return std::nullopt;
        if (fault == std::errc::result_out_of_range) {  // a negative exponent: too small; else too large
            if (text.find("E-") != text.npos || text.find("e-") != text.npos) return 0.0;
            return std::numeric_limits<double>::infinity();
        }
        return fault == std::errc() ? std::optional(value) : std::nullopt;
    };
    constexpr std::size_t kLongest = 64;  // no format of the file has a field as wide
    if (field.empty() || field.size() > kLongest) return std::nullopt;
    if (const auto value = parse(field)) return value;
    return parse(with_exponent_letter(field));
}

std::optional<long long> parse_fortran_whole(std::string_view field) {
    field = without_blanks(field);
    if (field.empty()) return 0;
    if (field.starts_with('+')) field.remove_prefix(1);
    constexpr std::size_t kLongest = 13;  // twelve digits and a sign: no field of whole numbers is wider
    long long value = 0;
    const auto [end, fault] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (fault != std::errc() || end != field.data() + field.size() || field.size() > kLongest) return std::nullopt;
    return value;
}

std::optional<std::string_view> append_fortran_reals(std::string_view line, std::span<const std::size_t> widths,
                                                     std::vector<double>& numbers) {
    const std::size_t before = numbers.size();
    std::optional<std::string_view> bad;
    for (std::size_t at = line.find_first_not_of(kBlanks); at != line.npos && !bad;) {
        const std::size_t end = std::min(line.find_first_of(kBlanks, at), line.size());
        const std::string_view field = line.substr(at, end - at);
        if (const auto value = parse_fortran_real(field))
            numbers.push_back(*value);
        else if (!append_touching_reals(field, numbers))
            bad = field;
        at = line.find_first_not_of(kBlanks, end);
    }
    if (!bad) return std::nullopt;
    numbers.resize(before);
    for (std::size_t at = 0, i = 0; at < line.size(); at += widths[i++ % widths.size()]) {
        const std::string_view field = line.substr(at, widths[i % widths.size()]);
        if (without_blanks(field).empty()) continue;
        const auto value = parse_fortran_real(field);
        if (!value) {
            numbers.resize(before);
            return bad;
        }
        numbers.push_back(*value);
    }
    return std::nullopt;
}

}  // namespace dttmm::host
