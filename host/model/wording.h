// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace dttmm::host {

/// How messages speak of what a user wrote.

/// `text` between double quotes, fit for a terminal: control, format and invisible characters as \u{hex}, at most 100
/// characters. Whatever bytes come in, valid UTF-8 comes out.
std::string quote(std::string_view text);

/// `text` as quote() makes it fit for a terminal, whole and without the quotes.
std::string printable(std::string_view text);
/// Whether it changes nothing.
bool is_printable(std::string_view text);

/// The shortest decimal text that reads back as `value`.
std::string number_text(double value);

/// "1 body", "2 bodies".
std::string counted(std::size_t count, const char* one, const char* many);

/// Fewest insertions, deletions, replacements and swaps of neighbours that turn `a` into `b` (Damerau 1964, no part edited
/// twice), counted in bytes of the first 100.
int compute_edit_distance(std::string_view a, std::string_view b);

/// The candidate nearest to `name`, if one is near enough to be meant.
std::optional<std::string> find_nearest(std::string_view name, const std::vector<std::string>& candidates);

/// The end of a message about an unknown name: `; did you mean "x"?`, or else `; known here: a, b, c`.
std::string suggestion(std::string_view name, const std::vector<std::string>& candidates);

/// "a, b, c"; at most 20 items are spelt out.
std::string listed(const std::vector<std::string>& items);

}  // namespace dttmm::host
