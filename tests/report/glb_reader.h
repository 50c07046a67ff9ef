// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace dttmm::host {

/// A binary glTF file, checked while it is read: chunks, alignment, bounds of accessors, samplers. Shares nothing with the
/// writer but the JSON library.
class GlbReader {
public:
    explicit GlbReader(const std::string& file) {
        EXPECT_EQ(file.substr(0, 4), "glTF");
        EXPECT_EQ(whole(file, 4), 2u);
        EXPECT_EQ(whole(file, 8), file.size());
        const uint32_t head = whole(file, 12);
        EXPECT_EQ(file.substr(16, 4), "JSON");
        EXPECT_EQ(head % 4, 0u);
        json = nlohmann::json::parse(file.substr(20, head));
        const uint32_t size = whole(file, 20 + head);
        EXPECT_EQ(file.substr(24 + head, 4), std::string("BIN\0", 4));
        EXPECT_EQ(size % 4, 0u);
        EXPECT_EQ(28 + head + size, file.size());
        bytes_ = file.substr(28 + head);
        EXPECT_EQ(json.at("asset").at("version"), "2.0");
        EXPECT_EQ(json.at("buffers").at(0).at("byteLength"), bytes_.size());
        for (std::size_t i = 0; i < json.at("accessors").size(); ++i) check(i);
        for (const auto& node : json.at("nodes")) {
            double square = 0;
            for (const double q : node.value("rotation", std::vector<double>{1})) square += q * q;
            EXPECT_NEAR(square, 1, 1e-6) << node;
        }
    }

    std::vector<float> numbers(std::size_t accessor) const {
        const auto& one = json["accessors"].at(accessor);
        const auto& view = json["bufferViews"].at(one["bufferView"].get<std::size_t>());
        std::vector<float> values(one["count"].get<std::size_t>() * width(one));
        const std::size_t begin = view["byteOffset"];
        EXPECT_EQ(begin % 4, 0u);
        EXPECT_EQ(view["byteLength"].get<std::size_t>(), 4 * values.size());
        EXPECT_LE(begin + 4 * values.size(), bytes_.size());
        std::memcpy(values.data(), bytes_.data() + begin, 4 * values.size());
        return values;
    }

    std::size_t node(const std::string& name) const {
        for (std::size_t i = 0; i < json["nodes"].size(); ++i)
            if (json["nodes"][i]["name"] == name) return i;
        ADD_FAILURE() << "no node " << name;
        return 0;
    }

    const nlohmann::json& animation(const std::string& name) const {
        for (const auto& one : json.value("animations", nlohmann::json::array()))
            if (one["name"] == name) return *std::find(json["animations"].begin(), json["animations"].end(), one);
        ADD_FAILURE() << "no animation " << name;
        return json;
    }

    /// "translation", "rotation" (x y z w) or "scale" of a node at a time of an animation; of the node itself where the
    /// animation does not change it. Rotations are mixed and normalised, which is near to the great circle.
    std::vector<double> at(const std::string& name, const char* path, const nlohmann::json& motion, double time) const {
        for (const auto& channel : motion["channels"]) {
            if (channel["target"]["node"] != node(name) || channel["target"]["path"] != path) continue;
            const auto& sampler = motion["samplers"].at(channel["sampler"].get<std::size_t>());
            const std::vector<float> times = numbers(sampler["input"]), values = numbers(sampler["output"]);
            const std::size_t count = values.size() / times.size();
            std::size_t low = 0;
            while (low + 2 < times.size() && times[low + 1] <= time) ++low;
            const double part = std::clamp((time - times[low]) / (times[low + 1] - times[low]), 0.0, 1.0);
            std::vector<double> mixed;
            double square = 0;
            for (std::size_t k = 0; k < count; ++k) {
                mixed.push_back((1 - part) * values[count * low + k] + part * values[count * (low + 1) + k]);
                square += mixed.back() * mixed.back();
            }
            if (count == 4)
                for (double& one : mixed) one /= std::sqrt(square);
            return mixed;
        }
        return json["nodes"][node(name)][path].get<std::vector<double>>();
    }

    nlohmann::json json;

private:
    static uint32_t whole(const std::string& file, std::size_t at) {
        uint32_t number = 0;
        EXPECT_LE(at + 4, file.size());
        std::memcpy(&number, file.data() + at, 4);
        return number;
    }
    static std::size_t width(const nlohmann::json& accessor) {
        const std::string type = accessor["type"];
        return type == "SCALAR" ? 1 : static_cast<std::size_t>(type.back() - '0');
    }

    void check(std::size_t accessor) const {
        const auto& one = json["accessors"][accessor];
        if (one["componentType"] == 5123) return;  // indices
        const std::vector<float> values = numbers(accessor);
        for (const float value : values) EXPECT_TRUE(std::isfinite(value));
        const std::size_t count = width(one);
        if (one.contains("min"))
            for (std::size_t k = 0; k < count; ++k) {
                float low = values[k], high = values[k];
                for (std::size_t i = k; i < values.size(); i += count)
                    low = std::min(low, values[i]), high = std::max(high, values[i]);
                EXPECT_EQ(one["min"][k].get<float>(), low);
                EXPECT_EQ(one["max"][k].get<float>(), high);
            }
        for (const auto& animation : json.value("animations", nlohmann::json::array()))
            for (const auto& sampler : animation["samplers"]) {
                if (sampler["input"] != accessor) continue;
                EXPECT_TRUE(one.contains("min") && one.contains("max"));
                EXPECT_EQ(values.front(), 0);
                for (std::size_t i = 1; i < values.size(); ++i) EXPECT_LT(values[i - 1], values[i]);
                EXPECT_EQ(json["accessors"][sampler["output"].get<std::size_t>()]["count"], one["count"]);
                break;
            }
    }

    std::string bytes_;
};

}  // namespace dttmm::host
