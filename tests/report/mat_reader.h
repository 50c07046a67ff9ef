// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>
#include <zlib.h>

#include <complex>
#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace dttmm::host {

/// A variable of a MAT file of level 5. Read from the bytes; shares nothing with matio but zlib.
struct MatValue {
    int of = 0;  ///< class: 1 cell, 2 struct, 4 char, 6 double
    std::vector<int> sizes;
    std::string name;
    std::vector<double> real, imaginary;  ///< of numbers
    std::u16string text;                  ///< of chars
    std::vector<MatValue> cells;          ///< of a cell; of a struct element by element, field by field
    std::vector<std::string> fields;      ///< of a struct

    const MatValue& field(const std::string& wanted, std::size_t element = 0) const {
        for (std::size_t f = 0; f < fields.size(); ++f)
            if (fields[f] == wanted) return cells.at(element * fields.size() + f);
        throw std::out_of_range("no field " + wanted);
    }
};

class MatReader {
public:
    /// The variables of a file by name.
    static std::map<std::string, MatValue> read(const std::string& file) {
        EXPECT_EQ(file.substr(0, 19), "MATLAB 5.0 MAT-file");
        EXPECT_EQ(file.substr(124, 4), std::string("\0\1IM", 4));
        std::map<std::string, MatValue> variables;
        for (std::size_t at = 128; at < file.size();) {
            const uint32_t type = number<uint32_t>(file, at), size = number<uint32_t>(file, at + 4);
            EXPECT_EQ(type, 15u) << "compressed";
            const std::string element = inflated(file.substr(at + 8, size));
            EXPECT_EQ(number<uint32_t>(element, 0), 14u);
            EXPECT_EQ(number<uint32_t>(element, 4), element.size() - 8);
            MatValue value = matrix(std::string_view(element).substr(8));
            EXPECT_FALSE(variables.contains(value.name)) << value.name;
            variables[value.name] = value;
            at += 8 + size;
        }
        return variables;
    }

private:
    template <class Number>
    static Number number(std::string_view bytes, std::size_t at) {
        Number value;
        if (at + sizeof(value) > bytes.size()) throw std::out_of_range("the MAT file ends early");
        std::memcpy(&value, bytes.data() + at, sizeof(value));
        return value;
    }

    static std::string inflated(const std::string& bytes) {
        std::string all;
        z_stream stream{};
        inflateInit(&stream);
        stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
        stream.avail_in = static_cast<uInt>(bytes.size());
        char block[4096];
        int state = Z_OK;
        while (state == Z_OK) {
            stream.next_out = reinterpret_cast<Bytef*>(block);
            stream.avail_out = sizeof(block);
            state = inflate(&stream, Z_NO_FLUSH);
            all.append(block, sizeof(block) - stream.avail_out);
        }
        EXPECT_EQ(state, Z_STREAM_END);
        inflateEnd(&stream);
        return all;
    }

    /// The next element: its type and bytes. `bytes` moves behind it.
    static std::pair<uint32_t, std::string_view> next(std::string_view& bytes) {
        const uint32_t first = number<uint32_t>(bytes, 0);
        const bool is_small = first >> 16 != 0;
        const uint32_t type = first & 0xffff, size = is_small ? first >> 16 : number<uint32_t>(bytes, 4);
        const std::string_view data = bytes.substr(is_small ? 4 : 8, size);
        bytes.remove_prefix(is_small ? 8 : std::min<std::size_t>(8 + (size + 7) / 8 * 8, bytes.size()));
        return {type, data};
    }

    static std::vector<double> doubles(std::pair<uint32_t, std::string_view> element) {
        EXPECT_EQ(element.first, 9u);
        std::vector<double> values(element.second.size() / 8);
        if (!values.empty()) std::memcpy(values.data(), element.second.data(), 8 * values.size());
        return values;
    }

    static MatValue matrix(std::string_view bytes) {
        MatValue value;
        if (bytes.empty()) return value;
        const auto flags = next(bytes).second;
        value.of = flags[0];
        const auto sizes = next(bytes).second;
        std::size_t count = 1;
        for (std::size_t i = 0; i + 4 <= sizes.size(); i += 4) {
            value.sizes.push_back(number<int>(sizes, i));
            count *= static_cast<std::size_t>(value.sizes.back());
        }
        value.name = next(bytes).second;
        if (value.of == 6) {
            value.real = doubles(next(bytes));
            if (flags[1] & 0x08) value.imaginary = doubles(next(bytes));
            EXPECT_EQ(value.real.size(), count);
        } else if (value.of == 4) {
            const auto [type, data] = next(bytes);
            EXPECT_TRUE(type == 4 || data.empty()) << "unsigned numbers of 16 bits, not " << type;
            for (std::size_t i = 0; i + 2 <= data.size(); i += 2) value.text += number<char16_t>(data, i);
            EXPECT_EQ(value.text.size(), count);
        } else if (value.of == 1 || value.of == 2) {
            if (value.of == 2) {
                const auto width = static_cast<std::size_t>(number<int>(next(bytes).second, 0));
                const auto names = next(bytes).second;
                for (std::size_t at = 0; at < names.size(); at += width)
                    value.fields.emplace_back(std::string(names.substr(at, width)).c_str());
                count *= value.fields.size();
            }
            for (std::size_t i = 0; i < count; ++i) {
                const auto [type, data] = next(bytes);
                EXPECT_EQ(type, 14u);
                value.cells.push_back(matrix(data));
            }
        } else {
            ADD_FAILURE() << "class " << value.of;
        }
        return value;
    }
};

}  // namespace dttmm::host
