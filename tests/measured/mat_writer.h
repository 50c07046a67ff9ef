// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <zlib.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace dttmm::host {

/// Writes MAT files of level 5, byte by byte; shares nothing with the reader but zlib.
/// Source: MathWorks, MAT-File Format, level 5.
class MatWriter {
public:
    bool is_big_endian = false, is_compressed = false;

    /// Types of numbers in a file: int8 1, uint8 2, int16 3, uint16 4, int32 5, uint32 6, single 7, double 9, int64 12,
    /// uint64 13. Classes of arrays: cell 1, struct 2, object 3, char 4, sparse 5, double 6, single 7, int8 8, ...
    /// uint64 15, function 16.
    std::string array(const std::string& name, std::vector<int> sizes, const std::vector<double>& real,
                      const std::vector<double>& imaginary = {}, int type = 9, int of = 6) const {
        return matrix(of, name, std::move(sizes), numbers(type, real) + (imaginary.empty() ? "" : numbers(type, imaginary)),
                      imaginary.empty() ? 0 : 0x0800);
    }
    std::string column(const std::string& name, const std::vector<double>& real,
                       const std::vector<double>& imaginary = {}) const {
        return array(name, {static_cast<int>(real.size()), 1}, real, imaginary);
    }
    /// Of units of UTF-16.
    std::string text(const std::string& name, std::u16string_view characters) const {
        std::vector<double> codes(characters.begin(), characters.end());
        return matrix(4, name, {1, static_cast<int>(codes.size())}, numbers(4, codes));
    }
    /// fields: element by element, each made by another function of this class.
    std::string structure(const std::string& name, const std::vector<std::string>& names,
                          const std::vector<std::string>& fields, int of = 2, const std::string& class_name = "") const {
        std::string padded;
        for (std::string field : names) {
            field.resize(32, '\0');
            padded += field;
        }
        std::string data = of == 3 ? element(1, class_name) : "";
        data += numbers(5, {32}) + element(1, padded);
        for (const std::string& field : fields) data += field;
        return matrix(of, name, {1, static_cast<int>(fields.size() / names.size())}, data);
    }
    /// Flags, sizes, name and what is behind them.
    std::string matrix(int of, const std::string& name, const std::vector<int>& sizes, const std::string& data,
                       int flags = 0) const {
        const std::vector<double> lengths(sizes.begin(), sizes.end());
        return element(14, numbers(6, {static_cast<double>(of | flags), 0}) + (sizes.empty() ? "" : numbers(5, lengths)) +
                               element(1, name) + data);
    }
    std::string element(int type, const std::string& data) const {
        if (!data.empty() && data.size() <= 4 && type != 14 && type != 15) {  // the small form
            std::string small = bytes(static_cast<std::uint64_t>(type) | data.size() << 16, 4) + data;
            small.resize(8, '\0');
            return small;
        }
        std::string all = bytes(static_cast<std::uint64_t>(type), 4) + bytes(data.size(), 4) + data;
        if (type != 15) all.resize((all.size() + 7) / 8 * 8, '\0');
        return all;
    }
    std::string file(const std::vector<std::string>& variables) const {
        std::string all = "MATLAB 5.0 MAT-file, written by a test";
        all.resize(124, ' ');
        all += bytes(0x0100, 2) + bytes('M' << 8 | 'I', 2);
        for (const std::string& variable : variables) all += is_compressed ? element(15, deflated(variable)) : variable;
        return all;
    }

private:
    std::string bytes(std::uint64_t number, std::size_t size) const {
        std::string text;
        for (std::size_t i = 0; i < size; ++i) text += static_cast<char>(number >> 8 * i & 0xff);
        if (is_big_endian) std::reverse(text.begin(), text.end());
        return text;
    }
    template <class Number>
    std::string raw(double value) const {
        const auto number = static_cast<Number>(value);
        std::string text(reinterpret_cast<const char*>(&number), sizeof(number));  // this machine is little-endian
        if (is_big_endian) std::reverse(text.begin(), text.end());
        return text;
    }
    std::string raw(int type, double value) const {
        switch (type) {
            case 1:
                return raw<std::int8_t>(value);
            case 2:
                return raw<std::uint8_t>(value);
            case 3:
                return raw<std::int16_t>(value);
            case 4:
                return raw<std::uint16_t>(value);
            case 5:
                return raw<std::int32_t>(value);
            case 6:
                return raw<std::uint32_t>(value);
            case 7:
                return raw<float>(value);
            case 12:
                return raw<std::int64_t>(value);
            case 13:
                return raw<std::uint64_t>(value);
            default:
                return raw<double>(value);
        }
    }
    std::string numbers(int type, const std::vector<double>& values) const {
        std::string data;
        for (const double value : values) data += raw(type, value);
        return element(type, data);
    }
    static std::string deflated(const std::string& data) {
        uLongf size = compressBound(static_cast<uLong>(data.size()));
        std::string out(size, '\0');
        compress(reinterpret_cast<Bytef*>(out.data()), &size, reinterpret_cast<const Bytef*>(data.data()),
                 static_cast<uLong>(data.size()));
        out.resize(size);
        return out;
    }
};

}  // namespace dttmm::host
