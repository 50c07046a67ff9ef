// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>
#include <vector>

namespace dttmm::host {

/// An unstructured grid of VTK's XML, as far as exports use it. Finds arrays by their names; decodes base64 by itself.
class VtuReader {
public:
    explicit VtuReader(std::string file) : text_(std::move(file)) {
        EXPECT_TRUE(text_.starts_with("<?xml version=\"1.0\"?>"));
        EXPECT_NE(text_.find("type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\""),
                  std::string::npos);
        EXPECT_TRUE(text_.ends_with("</VTKFile>\n"));
    }

    std::size_t count(const std::string& attribute) const {
        const std::size_t at = text_.find(attribute + "=\"") + attribute.size() + 2;
        return static_cast<std::size_t>(std::stoul(text_.substr(at)));
    }

    template <class Number>
    std::vector<Number> numbers(const std::string& name, const std::string& type) const {
        const std::string bytes = decoded(body(name, type));
        uint64_t size = 0;
        EXPECT_GE(bytes.size(), 8u);
        std::memcpy(&size, bytes.data(), 8);
        EXPECT_EQ(bytes.size(), 8 + size) << name;
        std::vector<Number> values(size / sizeof(Number));
        if (size > 0) std::memcpy(values.data(), bytes.data() + 8, size);
        return values;
    }
    std::vector<double> doubles(const std::string& name) const { return numbers<double>(name, "Float64"); }

    std::vector<std::string> texts(const std::string& name) const {
        std::vector<std::string> all(1);
        std::istringstream codes(body(name, "String"));
        for (int code = 0; codes >> code;)
            if (code == 0)
                all.emplace_back();
            else
                all.back() += static_cast<char>(code);
        EXPECT_EQ(all.back(), "") << "ended by a zero";
        all.pop_back();
        return all;
    }
    bool has(const std::string& name) const { return text_.find("Name=\"" + name + "\"") != std::string::npos; }

private:
    std::string body(const std::string& name, const std::string& type) const {
        const std::size_t at = text_.find("<DataArray type=\"" + type + "\" Name=\"" + name + "\"");
        EXPECT_NE(at, std::string::npos) << name;
        const std::size_t begin = text_.find('>', at) + 1;
        return text_.substr(begin, text_.find('<', begin) - begin);
    }
    static std::string decoded(const std::string& text) {
        const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        std::string bytes;
        uint32_t held = 0;
        int bits = 0;
        for (const char c : text) {
            if (c == '=') break;
            held = held << 6 | static_cast<uint32_t>(digits.find(c));
            if ((bits += 6) >= 8) bytes += static_cast<char>(held >> (bits -= 8) & 0xff);
        }
        return bytes;
    }

    std::string text_;
};

}  // namespace dttmm::host
