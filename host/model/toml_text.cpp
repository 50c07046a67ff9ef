// SPDX-License-Identifier: BSD-3-Clause
#include "model/toml_text.h"

#include <fmt/format.h>
#include <utf8proc.h>

#include <algorithm>

#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

using namespace std::string_view_literals;

constexpr std::string_view kUtf8Mark = "\xef\xbb\xbf";

std::optional<TextFault> find_foreign_mark(std::string_view text) {
    const auto fault = [](const char* encoding) {
        return TextFault{{1, 1}, fmt::format("the file is {0}, not UTF-8; convert it: iconv -f {0} -t UTF-8", encoding)};
    };
    if (text.starts_with("\xff\xfe\0\0"sv) || text.starts_with("\0\0\xfe\xff"sv)) return fault("UTF-32");
    if (text.starts_with("\xff\xfe"sv) || text.starts_with("\xfe\xff"sv)) return fault("UTF-16");
    return std::nullopt;
}

std::optional<TextFault> find_foreign_byte(std::string_view text) {
    const auto* bytes = reinterpret_cast<const utf8proc_uint8_t*>(text.data());
    for (std::size_t i = 0; i < text.size();) {
        if (text[i] == '\0')
            return TextFault{place_of_byte(text, i), fmt::format("a NUL byte at byte {}: this is not text", i)};
        utf8proc_int32_t character = 0;
        const auto length = utf8proc_iterate(bytes + i, static_cast<utf8proc_ssize_t>(text.size() - i), &character);
        if (length <= 0)
            return TextFault{place_of_byte(text, i), fmt::format("not UTF-8 text at byte {}; save the file as UTF-8", i)};
        i += as_size(length);
    }
    return std::nullopt;
}

std::optional<TextFault> find_long_line(std::string_view text) {
    for (std::size_t begin = 0; begin < text.size();) {
        const std::size_t end = std::min(text.find('\n', begin), text.size());
        if (end - begin > kLongestLine)
            return TextFault{place_of_byte(text, begin),
                             fmt::format("a line of {} bytes; at most {} are allowed", end - begin, kLongestLine)};
        begin = end + 1;
    }
    return std::nullopt;
}

/// Walks over TOML text, skips comments and strings, and counts the dots of keys and the open brackets.
class Lexer {
public:
    explicit Lexer(std::string_view text) : text_(text), at_(text.starts_with(kUtf8Mark) ? kUtf8Mark.size() : 0) {}

    std::optional<TextFault> find_fault() {
        while (at_ < text_.size()) {
            const std::size_t begin = at_;
            if (const auto fault = step()) return TextFault{place_of_byte(text_, begin), *fault};
        }
        return std::nullopt;
    }

private:
    std::optional<std::string> step() {
        switch (text_[at_]) {
            case '#':
                at_ = std::min(text_.find('\n', at_), text_.size());
                return std::nullopt;
            case '"':
            case '\'':
                return skip_string();
            case '[':
            case '{':
                dots_ = 0;
                ++at_;
                if (++depth_ > kDeepestNesting)
                    return fmt::format("nested too deep; at most {} arrays and tables", kDeepestNesting);
                return std::nullopt;
            case ']':
            case '}':
                --depth_;
                [[fallthrough]];
            case '=':
            case ',':
            case '\n':
                dots_ = 0;
                ++at_;
                return std::nullopt;
            case '.':
                ++at_;
                if (++dots_ >= kDeepestKey) return fmt::format("key too deep; at most {} parts", kDeepestKey);
                return std::nullopt;
            default:
                if (static_cast<unsigned char>(text_[at_]) >= 0x80) return refuse_character();
                ++at_;
                return std::nullopt;
        }
    }

    std::string refuse_character() const {
        utf8proc_int32_t character = 0;
        const auto length = utf8proc_iterate(reinterpret_cast<const utf8proc_uint8_t*>(text_.data() + at_),
                                             static_cast<utf8proc_ssize_t>(text_.size() - at_), &character);
        const std::string_view bytes = text_.substr(at_, as_size(std::max<utf8proc_ssize_t>(length, 1)));
        return fmt::format("the character {} (U+{:04X}) stands outside quotes; a key or text that holds it needs them",
                           quote(bytes), character);
    }

    std::optional<std::string> skip_string() {
        const char quote = text_[at_];
        const std::string triple(3, quote);
        const bool is_long = text_.substr(at_).starts_with(triple);
        at_ += is_long ? 3 : 1;
        while (at_ < text_.size()) {
            if (quote == '"' && text_[at_] == '\\') {
                at_ += 2;
            } else if (is_long && text_.substr(at_).starts_with(triple)) {
                at_ = std::min(text_.find_first_not_of(quote, at_), text_.size());
                return std::nullopt;
            } else if (!is_long && text_[at_] == quote) {
                ++at_;
                return std::nullopt;
            } else if (!is_long && text_[at_] == '\n') {
                break;
            } else {
                ++at_;
            }
        }
        return fmt::format("the string that begins here is not closed{}", is_long ? "" : " on its line");
    }

    std::string_view text_;
    std::size_t at_;
    int dots_ = 0;
    int depth_ = 0;
};

}  // namespace

std::optional<TextFault> find_text_fault(std::string_view text) {
    if (text.size() > kLargestFile)
        return TextFault{{1, 1}, fmt::format("the file has {} bytes; at most {} are allowed", text.size(), kLargestFile)};
    if (auto fault = find_foreign_mark(text)) return fault;
    if (auto fault = find_foreign_byte(text)) return fault;
    if (auto fault = find_long_line(text)) return fault;
    return Lexer(text).find_fault();
}

Place place_of_byte(std::string_view text, std::size_t offset) {
    const std::string_view before = text.substr(0, offset);
    const std::size_t line_start = before.rfind('\n') + 1;  // npos + 1 = 0: the first line
    const auto is_first_byte = [](char c) { return (static_cast<unsigned char>(c) & 0xC0u) != 0x80u; };
    return {as_int(std::count(before.begin(), before.end(), '\n')) + 1,
            as_int(std::count_if(before.begin() + as_row(line_start), before.end(), is_first_byte)) + 1};
}

}  // namespace dttmm::host
