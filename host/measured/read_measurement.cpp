// SPDX-License-Identifier: BSD-3-Clause
#include "measured/read_measurement.h"

#include <fmt/format.h>

#include <fstream>
#include <string>
#include <string_view>

#include "measured/csv_reader.h"
#include "measured/mat_reader.h"
#include "measured/universal_reader.h"
#include "measured/universal_text.h"
#include "model/error.h"

namespace dttmm::host {

namespace {

/// How files begin that are not read, and what they are.
struct OtherFormat {
    std::string_view beginning;
    const char* name;
};
constexpr OtherFormat kOtherFormats[] = {{"\x89HDF\r\n\x1a\n", "an HDF5 file without the head of a MAT file"},
                                         {"PK\x03\x04", "a ZIP archive, as spreadsheets are"},
                                         {"\x1f\x8b", "a file compressed with gzip"},
                                         {"TDSm", "a TDMS file"},
                                         {"\xff\xfe", "text in UTF-16"},
                                         {"\xfe\xff", "text in UTF-16"}};

std::string read_beginning(const std::filesystem::path& file) {
    const auto fail = [&](const std::string& fault) {
        throw Error(ExitCode::input_output, fmt::format("{}: {}", file.string(), fault));
    };
    std::error_code fault;
    const std::filesystem::file_status status = std::filesystem::status(file, fault);
    if (status.type() == std::filesystem::file_type::not_found) fail("there is no such file");
    if (!std::filesystem::status_known(status)) fail("cannot be read: " + fault.message());
    if (!std::filesystem::is_regular_file(status)) fail("is no regular file");
    constexpr std::size_t kEnough = 4096;  // for the head of a MAT file, and for blank lines of a universal file
    std::string text(kEnough, '\0');
    std::ifstream stream(file, std::ios::binary);
    if (!stream) fail("cannot be read: check its permissions");
    stream.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(stream.gcount()));
    if (text.empty()) fail("is empty");
    return text;
}

bool is_mat(std::string_view beginning) {
    constexpr std::size_t kHead = 128;
    if (beginning.size() < kHead) return false;
    const std::string_view order = beginning.substr(126, 2);
    const char level = beginning[order == "MI" ? 124 : 125];
    return (order == "MI" || order == "IM") && (level == 1 || level == 2);
}

bool is_universal(const std::filesystem::path& file, std::string_view beginning) {
    UniversalText text(file, beginning);
    text.skip_blank();
    return is_universal_mark(text.peek());
}

}  // namespace

Measurement read_measurement(const std::filesystem::path& file) {
    const std::string beginning = read_beginning(file);
    if (is_mat(beginning)) return read_mat(file);
    if (is_universal(file, beginning)) return read_universal(file);
    for (const auto& [own, name] : kOtherFormats)
        if (std::string_view(beginning).starts_with(own))
            throw Error(
                ExitCode::input_output,
                fmt::format("{}: is {}: save it as CSV, as a MAT file, or as a universal file", file.string(), name));
    return read_measured_csv(file);
}

}  // namespace dttmm::host
