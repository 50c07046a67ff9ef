// SPDX-License-Identifier: BSD-3-Clause
#include "measured/mat_arrays.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>

#include "measured/mat5_file.h"
#include "measured/mat73_file.h"
#include "model/error.h"
#include "record/csv_file.h"

namespace dttmm::host {

std::size_t MatArray::count() const {
    std::size_t product = 1;
    for (const std::size_t size : sizes) product *= size;
    return product;
}

bool MatArray::is_vector() const {
    return std::ranges::count_if(sizes, [](std::size_t size) { return size != 1; }) <= 1;
}

std::string MatArray::sizes_text() const { return fmt::format("{}", fmt::join(sizes, "x")); }

std::string utf8_of_utf16(std::span<const std::uint16_t> units) {
    std::string text;
    const auto add = [&](char32_t bits) { text += static_cast<char>(static_cast<unsigned char>(bits)); };
    for (std::size_t i = 0; i < units.size(); ++i) {
        char32_t code = units[i];
        const bool is_pair = (code & 0xfc00) == 0xd800 && i + 1 < units.size() && (units[i + 1] & 0xfc00) == 0xdc00;
        if (is_pair) code = 0x10000 + ((code & 0x3ff) << 10) + (units[++i] & 0x3ffu);
        if (code < 0x10000 && (code & 0xf800) == 0xd800) code = 0xfffd;
        if (code < 0x80) {
            add(code);
            continue;
        }
        if (code >= 0x10000) add(0xf0 | code >> 18);
        if (code >= 0x10000) add(0x80 | (code >> 12 & 0x3f));
        if (code >= 0x800 && code < 0x10000) add(0xe0 | code >> 12);
        add(code < 0x800 ? 0xc0 | code >> 6 : 0x80 | (code >> 6 & 0x3f));
        add(0x80 | (code & 0x3f));
    }
    return text;
}

std::vector<MatArray> read_mat_arrays(const std::filesystem::path& file) {
    // A head of 128 bytes: text, then the level as a number of two bytes, then "MI" as one, which tells their order
    std::array<char, 128> head = {};
    std::ifstream(file, std::ios::binary).read(head.data(), head.size());
    const std::string_view order(head.data() + 126, 2);
    const int level = static_cast<unsigned char>(head[order == "MI" ? 124 : 125]);
    if (order == "IM" && level == 2) return read_mat73(file);
    constexpr std::uintmax_t kLargestMat5 = std::uintmax_t{4} << 30;  // [byte]: it is read as a whole
    std::error_code fault;
    if (const auto size = std::filesystem::file_size(file, fault); !fault && size > kLargestMat5)
        throw Error(ExitCode::input_output, fmt::format("{}: is larger than 4 GiB: split it", file.string()));
    const std::string bytes = read_whole_file(file);
    if ((order != "IM" && order != "MI") || level != 1)
        throw Error(ExitCode::input_output,
                    fmt::format("{}: is no MAT file of level 5, 7 or 7.3: save it with save -v7 of MATLAB", file.string()));
    return read_mat5(file, bytes, order == "MI");
}

}  // namespace dttmm::host
