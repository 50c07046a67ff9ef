// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace dttmm::host {

/// The bytes of a universal file, taken line by line and, behind the head of a binary data set, by their number.
class UniversalText {
public:
    /// bytes must outlive this.
    UniversalText(const std::filesystem::path& file, std::string_view bytes) : file_(file.string()), bytes_(bytes) {}

    bool is_at_end() const { return at_ == bytes_.size(); }
    /// What is not taken yet.
    std::string_view rest() const { return bytes_.substr(at_); }
    /// The next line without its end, which is LF or CR LF. Empty at the end of the file.
    std::string_view peek() const;
    std::string_view next();
    /// Takes lines that are blank.
    void skip_blank();
    /// Whether the file ends with the end of a line.
    bool ends_with_line() const { return bytes_.ends_with('\n') || bytes_.ends_with('\r'); }
    /// The next bytes, of which there must be so many.
    std::string_view take(std::size_t count);
    /// Of the last line taken: "blow.uff:12", or "blow.uff: byte 4711", counted from 0, behind binary data.
    std::string place() const;
    const std::string& file() const { return file_; }
    /// Error(input_output) at place().
    [[noreturn]] void fail(const std::string& fault) const;

private:
    std::string file_;
    std::string_view bytes_;
    std::size_t at_ = 0, line_ = 0, line_begin_ = 0;
    bool has_binary_ = false;  ///< lines are not counted any more
};

/// The line "    -1" that begins and ends a data set: -1 within the first six columns, and nothing else.
bool is_universal_mark(std::string_view line);

/// Fields of a line by their columns. Columns count bytes. Writers who pad texts that are not ASCII by characters shift what
/// follows: where the columns that must be blank are not, and are so in UTF-8 characters, columns count characters.
class FixedFields {
public:
    /// blanks: columns between fields, from 0. width: of the whole record.
    FixedFields(std::string_view line, std::span<const std::size_t> blanks, std::size_t width);
    /// From 0. What is behind the end of the line is blank.
    std::string_view field(std::size_t first, std::size_t width) const;

private:
    std::string_view line_;
    std::vector<std::size_t> starts_;  ///< of characters; empty: columns count bytes
};

/// The text without blanks at its ends, in UTF-8: what is none is taken for Latin-1. NONE is empty.
std::string universal_text_of(std::string_view field);

/// A number as FORTRAN writes it: E or D before the exponent, or no letter before one of three digits. None: it is none.
std::optional<double> parse_fortran_real(std::string_view field);
/// A whole number; a blank field is 0, as in FORTRAN. None: it is no whole number, or one of more than 12 digits.
std::optional<long long> parse_fortran_whole(std::string_view field);

/// Appends the numbers of a line: as blanks part them, and signs where numbers touch; where that gives none, by columns of
/// `widths` in turn. Returns the field that is no number, if there is one; nothing is appended then.
std::optional<std::string_view> append_fortran_reals(std::string_view line, std::span<const std::size_t> widths,
                                                     std::vector<double>& numbers);

}  // namespace dttmm::host
