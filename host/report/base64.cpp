// SPDX-License-Identifier: BSD-3-Clause
#include "report/base64.h"

#include <bit>
#include <vector>

namespace dttmm::host {

static_assert(std::endian::native == std::endian::little);

std::string base64(std::string_view bytes) {
    constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    text.reserve((bytes.size() + 2) / 3 * 4);
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned group = 0;
        for (std::size_t k = i; k < i + 3; ++k)
            group = group << 8 | (k < bytes.size() ? static_cast<unsigned char>(bytes[k]) : 0U);
        for (std::size_t k = 0; k < 4; ++k) text += i + k <= bytes.size() ? kDigits[group >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

std::string base64_of_floats(std::span<const double> values) {
    std::vector<float> floats;
    floats.reserve(values.size());
    for (const double value : values) floats.push_back(static_cast<float>(value));
    return base64({reinterpret_cast<const char*>(floats.data()), floats.size() * sizeof(float)});
}

std::string base64_of_doubles(std::span<const double> values) {
    return base64({reinterpret_cast<const char*>(values.data()), values.size() * sizeof(double)});
}

}  // namespace dttmm::host
