// SPDX-License-Identifier: BSD-3-Clause
#include "model/toml_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <random>

namespace dttmm::host {
namespace {

using namespace std::string_view_literals;

std::string repeat(std::string_view part, int count) {
    std::string text;
    for (int i = 0; i < count; ++i) text += part;
    return text;
}

void expect_fault(std::string_view text, Place place, const char* message) {
    const auto fault = find_text_fault(text);
    ASSERT_TRUE(fault) << message;
    EXPECT_THAT(fault->text, testing::HasSubstr(message));
    EXPECT_EQ(fault->place.line, place.line) << message;
    EXPECT_EQ(fault->place.column, place.column) << message;
}

TEST(TomlText, OrdinaryTextPasses) {
    for (const auto text : {""sv, "a = 1\r\nb = 2\r\n"sv,
                            "\xef\xbb\xbf"
                            "a = 1"sv,
                            "a = \"ü\" # don't\n[[b.c]]\n"sv, "x = ''' it's '''\ny = \"\"\"\"q\"\"\"\"\n"sv,
                            "x = \"\\\"\" # \"\nx = '\\'\n"sv, "x = [[1.5, 2.5], {a.b = 3}]\n"sv})
        EXPECT_FALSE(find_text_fault(text)) << text << ": " << find_text_fault(text)->text;
}

TEST(TomlText, OtherEncodingsAreNamedWithTheirCure) {
    expect_fault(
        "\xff\xfe"
        "a\0"sv,
        {1, 1}, "the file is UTF-16, not UTF-8; convert it: iconv -f UTF-16 -t UTF-8");
    expect_fault(
        "\xfe\xff"
        "\0a"sv,
        {1, 1}, "UTF-16");
    expect_fault(
        "\xff\xfe\0\0"
        "a\0\0\0"sv,
        {1, 1}, "UTF-32");
    expect_fault("\0\0\xfe\xff"sv, {1, 1}, "UTF-32");
}

TEST(TomlText, ForeignBytesHaveTheirPosition) {
    expect_fault("a = 1\nü\xff"sv, {2, 2}, "not UTF-8 text at byte 8");
    expect_fault("a = 1\nb\0"sv, {2, 2}, "a NUL byte at byte 7");
    expect_fault("a = \"\xed\xa0\x80\""sv, {1, 6}, "not UTF-8 text at byte 5");  // a surrogate
}

TEST(TomlText, RandomBytesAreNoText) {
    std::mt19937 random(1);
    std::string text(1 << 20, '\xff');
    for (char& c : text) c = static_cast<char>(random() & 0xffu);
    text[0] = 'a';
    text[1] = '\xff';
    expect_fault(text, {1, 2}, "not UTF-8 text at byte 1");
}

TEST(TomlText, LongLinesAndFilesAreRefused) {
    expect_fault("a = 1\nb = \"" + std::string(10'000'000, 'x') + "\"\n", {2, 1}, "a line of 10000006 bytes");
    expect_fault(repeat(std::string(1000, ' ') + "\n", 70'000), {1, 1}, "at most 67108864");
}

TEST(TomlText, DeepKeysAndNestingAreRefusedAtOnce) {
    const std::string dotted = "a" + repeat(".a", 99'999);
    const auto start = std::chrono::steady_clock::now();
    expect_fault(dotted + " = 1", {1, 128}, "key too deep; at most 64 parts");
    expect_fault("x = 1\n[" + dotted + "]", {2, 129}, "key too deep");
    expect_fault("x = {" + dotted + " = 1}", {1, 133}, "key too deep");
    expect_fault("x = " + repeat("[", 100'000), {1, 37}, "nested too deep; at most 32");
    expect_fault("x = " + repeat("{a=", 100'000), {1, 101}, "nested too deep");
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::milliseconds(500));  // five of them, each below 100 ms
    EXPECT_FALSE(find_text_fault("a" + repeat(".a", 63) + " = 1"));
    EXPECT_FALSE(find_text_fault("x = " + repeat("[", 32) + repeat("]", 32)));
}

TEST(TomlText, AnOpenStringIsToldWhereItBegins) {
    expect_fault("a = 1\nb = \"abc", {2, 5}, "the string that begins here is not closed on its line");
    expect_fault("b = 'abc\nc = 1'", {1, 5}, "not closed on its line");
    expect_fault("a = \"ü\"\nb = \"\"\"abc\n\nc = 1\n", {2, 5}, "the string that begins here is not closed");
    expect_fault("b = '''a''\n", {1, 5}, "not closed");
    expect_fault("b = \"abc\\", {1, 5}, "not closed");
}

// TOML wants quotes around such keys, and toml++ 3.3.0 runs into undefined behaviour without them.
TEST(TomlText, LettersBeyondAsciiNeedQuotes) {
    expect_fault("a = 1\ngröße = 2\n", {2, 3},
                 "the character \"ö\" (U+00F6) stands outside quotes; a key or text that holds it needs them");
    expect_fault("a =\u00a01\n", {1, 4}, "(U+00A0) stands outside quotes");
    expect_fault("a = 1 \u3042\n", {1, 7}, "(U+3042) stands outside quotes");
    EXPECT_FALSE(find_text_fault("\"größe\" = 'あ' # ü\n"));
}

TEST(TomlText, PlacesCountCharacters) {
    const Place place = place_of_byte("aü\nbüüc", 8);
    EXPECT_EQ(place.line, 2);
    EXPECT_EQ(place.column, 4);
}

}  // namespace
}  // namespace dttmm::host
