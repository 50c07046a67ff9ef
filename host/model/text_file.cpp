// SPDX-License-Identifier: BSD-3-Clause
#include "model/text_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "model/error.h"
#include "model/index.h"
#include "model/toml_text.h"

namespace dttmm::host {

namespace fs = std::filesystem;

namespace {

/// To its end, also where its size is said to be 0: what cannot be read is no empty file. Returns errno, 0 if all is well.
int read_to_end(int descriptor, std::string& text) {
    char piece[64 * 1024];
    ssize_t size = 1;
    while (size != 0 && text.size() <= kLargestFile) {
        size = ::read(descriptor, piece, sizeof piece);
        if (size > 0) text.append(piece, as_size(size));
        if (size < 0 && errno != EINTR) return errno;
    }
    text.resize(std::min(text.size(), kLargestFile + 1));
    return 0;
}

/// Read once: a command may look at its model several times.
const std::string& standard_input() {
    static const std::string text = [] {
        std::string read;
        if (const int reason = read_to_end(STDIN_FILENO, read))
            throw Error(ExitCode::input_output, fmt::format("the standard input cannot be read: {}", std::strerror(reason)));
        return read;
    }();
    return text;
}

}  // namespace

std::string read_text_file(const fs::path& file) {
    const auto fail = [&](const std::string& why) {
        throw Error(ExitCode::input_output, fmt::format("{}: {}", file.string(), why));
    };
    if (file == "-") return standard_input();
    std::error_code error;
    const fs::file_status status = fs::status(file, error);
    if (status.type() == fs::file_type::not_found) fail("there is no such file");
    if (!fs::status_known(status)) fail("cannot be read: " + error.message());
    if (!fs::is_regular_file(status)) fail("is not a regular file");
    const int descriptor = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) fail(fmt::format("cannot be read: {}", std::strerror(errno)));
    std::string text;
    const int reason = read_to_end(descriptor, text);
    ::close(descriptor);
    if (reason) fail(fmt::format("cannot be read: {}", std::strerror(reason)));
    return text;
}

}  // namespace dttmm::host
