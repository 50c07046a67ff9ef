// SPDX-License-Identifier: BSD-3-Clause
#include "record/tell.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <exception>

namespace dttmm::host {

namespace {

/// Columns of the terminal that the standard error is; 0 where it is none.
std::size_t read_columns() {
    winsize size{};
    if (::isatty(STDERR_FILENO) != 1) return 0;
    return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1 ? size.ws_col : 80;
}

void write(std::string_view line) {
    std::fwrite(line.data(), 1, line.size(), stderr);
    std::fputc('\n', stderr);
}

}  // namespace

std::string wrap(std::string_view text, std::size_t width) {
    constexpr std::string_view kIndent = "    ";
    std::string wrapped;
    std::size_t length = 0;  // of the open line
    while (!text.empty()) {
        const std::size_t begin = text.find_first_not_of(' ');
        if (begin == text.npos) break;
        const std::size_t end = std::min(text.find(' ', begin), text.size());
        const std::string_view gap = text.substr(0, begin), word = text.substr(begin, end - begin);
        if (length > kIndent.size() && length + gap.size() + word.size() > width) {
            wrapped.append("\n").append(kIndent);
            length = kIndent.size();
        } else {
            wrapped += gap;
            length += gap.size();
        }
        wrapped += word;
        length += word.size();
        text.remove_prefix(end);
    }
    return wrapped;
}

void tell(const std::string& line) noexcept {
    try {
        const std::size_t columns = read_columns();
        write(columns > 0 && line.find('\n') == line.npos ? wrap(line, columns) : line);
    } catch (const std::exception&) {  // no memory
        write(line);
    }
}

}  // namespace dttmm::host
