// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/json.h"

#include <gtest/gtest.h>

#include <sstream>

namespace dttmm::host {
namespace {

std::string key(int i) { return "member" + std::to_string(i * 7919 % 1000); }

// Oracle: the order written, on both sides of the size at which members are found by hash.
TEST(Json, MembersStayInTheOrderWritten) {
    for (const int n : {3, 16, 17, 500}) {
        Json json = Json::object();
        for (int i = 0; i < n; ++i) json[key(i)] = i;
        for (int i = 0; i < n; ++i) json[key(i)] = i + 1;  // there already
        ASSERT_EQ(json.size(), static_cast<size_t>(n));
        int i = 0;
        for (const auto& [name, value] : json.items()) {
            EXPECT_EQ(name, key(i));
            EXPECT_EQ(value, ++i);
        }
        EXPECT_EQ(Json::parse(json.dump()), json);
    }
}

TEST(Json, MembersAreFoundAfterOthersAreErased) {
    Json json = Json::object();
    for (int i = 0; i < 100; ++i) json[key(i)] = i;
    for (int i = 0; i < 100; i += 3) json.erase(key(i));
    for (int i = 0; i < 100; ++i) {
        ASSERT_EQ(json.contains(key(i)), i % 3 != 0);
        if (i % 3 != 0) {
            EXPECT_EQ(json.at(key(i)), i);
        }
    }
    EXPECT_THROW(json.at("no such member"), Json::out_of_range);
    Json copy = json;
    copy["new"] = 1;
    EXPECT_FALSE(json.contains("new"));
    EXPECT_TRUE(copy.contains("new"));
}

// A key that counts how often it is compared.
struct CountedKey {
    std::string text;
    CountedKey(const char* name) : text(name) {}
    CountedKey(std::string name) : text(std::move(name)) {}
    operator std::string_view() const { return text; }
    static inline long compared = 0;
    bool operator==(std::string_view other) const {
        ++compared;
        return text == other;
    }
};

// Oracle: a table that is half full at most has a free slot or the member after 1.5 to 2.5 slots on average.
TEST(Json, AMemberIsFoundInAHandfulOfComparisons) {
    OrderedMembers<CountedKey, int> members;
    constexpr int kCount = 20000;
    for (int i = 0; i < kCount; ++i) members.emplace("name" + std::to_string(i), int(i));
    for (int i = 0; i < kCount; ++i) ASSERT_EQ(members.at("name" + std::to_string(i)), i);
    EXPECT_LT(CountedKey::compared, 5L * kCount);
}

// Oracle: dump() of the same.
TEST(Json, TheStreamIsTheDump) {
    const Json json = {{"a", {1, 2.5, "\xff broken"}}, {"b", {{"c", nullptr}}}};
    std::ostringstream stream;
    write_json(stream, json);
    EXPECT_EQ(stream.str(), json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
}

// Oracle: the dump of the same as a whole.
TEST(Json, MembersWrittenOneByOneAreTheDump) {
    std::ostringstream stream;
    JsonWriter out(stream);
    out.member("a", {{"x", 1}, {"y", {2, 3}}});
    out.object("empty", [] {});
    out.object("deep", [&] {
        out.member("\"quoted\"\n", 0.1);
        out.object("deeper", [&] { out.member("b", Json::array()); });
    });
    out.array("list", std::vector{3, 5, 7}, [](int i) { return Json{{"i", i}, {"twice", 2 * i}}; });
    out.array("none", std::vector<int>(), [](int i) { return Json(i); });
    // Characters of one to four bytes, so that pieces end within them
    std::string text;
    for (int i = 0; i < 3000; ++i)
        text += i % 7 == 0 ? "\"\n" : i % 3 == 0 ? "\u00e9" : i % 2 == 0 ? "\u20ac" : "\U0001f529";
    out.text("text", text);
    out.text("short", "");
    out.member("last", nullptr);
    out.finish();
    Json whole = {{"a", {{"x", 1}, {"y", {2, 3}}}}, {"empty", Json::object()}};
    whole["deep"] = {{"\"quoted\"\n", 0.1}, {"deeper", {{"b", Json::array()}}}};
    for (const int i : {3, 5, 7}) whole["list"].push_back({{"i", i}, {"twice", 2 * i}});
    whole["none"] = Json::array();
    whole["text"] = text;
    whole["short"] = "";
    whole["last"] = nullptr;
    EXPECT_EQ(stream.str(), whole.dump(2) + "\n");
}

}  // namespace
}  // namespace dttmm::host
