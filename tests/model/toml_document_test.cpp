// SPDX-License-Identifier: BSD-3-Clause
#include "model/toml_document.h"

#include <random>

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;
using Kind = TomlValue::Kind;

TomlValue document(std::string_view text) {
    Diagnostics diagnostics("m.toml");
    auto value = parse_toml(text, diagnostics);
    diagnostics.throw_if_errors();
    return value.value();
}

std::string document_fault(std::string_view text) {
    return error_of([&] { document(text); });
}

void expect_place(Place place, int line, int column) {
    EXPECT_EQ(place.line, line);
    EXPECT_EQ(place.column, column);
}

TEST(TomlDocument, EveryKindOfValueWithItsPlace) {
    const TomlValue root = document(
        "b = 2\n  a = 1.5\r\nt = \"x\"\nf = true\nd = 2020-01-01\n[s]\nl = [1, [2, 3]]\n\"ü\" = { y = inf "
        "}\n[[q]]\n[[q]]\n");
    ASSERT_EQ(root.members.size(), 7u);
    EXPECT_EQ(root.members[0].key, "b");  // in the order of the file
    EXPECT_EQ(root.members[1].key, "a");
    EXPECT_EQ(root.find("b")->value.number, 2);
    EXPECT_EQ(root.find("b")->value.kind, Kind::integer);
    EXPECT_EQ(root.find("a")->value.number, 1.5);
    expect_place(root.find("a")->place, 2, 3);
    expect_place(root.find("a")->value.place, 2, 7);
    EXPECT_EQ(root.find("t")->value.string, "x");
    expect_place(root.find("t")->value.place, 3, 5);
    EXPECT_EQ(root.find("f")->value.kind, Kind::boolean);
    EXPECT_EQ(root.find("d")->value.kind, Kind::date);
    const TomlValue& table = root.find("s")->value;
    EXPECT_EQ(table.find("l")->value.items[1].items[1].number, 3);
    expect_place(table.find("l")->value.items[1].items[1].place, 7, 13);
    EXPECT_EQ(table.find("ü")->value.find("y")->value.kind, Kind::real);
    expect_place(table.find("ü")->value.find("y")->place, 8, 9);
    ASSERT_EQ(root.find("q")->value.items.size(), 2u);
    expect_place(root.find("q")->value.items[1].place, 10, 1);
    EXPECT_EQ(root.find("none"), nullptr);
}

TEST(TomlDocument, SyntaxFaultsHaveTheirPlace) {
    EXPECT_THAT(document_fault("[[[body]]\n"), HasSubstr("m.toml:1:3: expected bare key"));
    EXPECT_THAT(document_fault("a = 1\nb = [1, 2\n"), HasSubstr("m.toml:2:11: encountered end-of-file"));
    EXPECT_THAT(document_fault("a = {x = 1,}\n"), HasSubstr("m.toml:1:12: expected key-value pair"));
    EXPECT_THAT(document_fault("a = 1\r\nb = 2 c\r\n"), HasSubstr("m.toml:2:7: expected a comment"));
    EXPECT_THAT(document_fault("a = \"abc"), HasSubstr("m.toml:1:5: the string that begins here"));
    EXPECT_THAT(document_fault("a = hinge"),
                HasSubstr("m.toml:1:5: could not determine value type; a text stands in quotes"));
}

// The mark stands below the column that the message names.
TEST(TomlDocument, SyntaxFaultsShowTheirLine) {
    EXPECT_THAT(document_fault("a = 1\n  b = [3 mm, 2]\n"), HasSubstr("\n      b = [3 mm, 2]\n             ^"));
    EXPECT_EQ(document_fault("s = \"\x1b[31m\" x\n").find('^'), std::string::npos);
}

TEST(TomlDocument, DecimalCommasAndBareUnitsAreNamed) {
    EXPECT_THAT(document_fault("a = 2,5"),
                HasSubstr("m.toml:1:6: expected a comment or whitespace, saw ','; a number has a decimal point"));
    for (const char* text : {"a = 2 s", "a = 2s", "a = 2.5\tmm"})
        EXPECT_THAT(document_fault(text), HasSubstr("a value with a unit stands in quotes")) << text;
    EXPECT_THAT(document_fault("a = true b"), Not(HasSubstr("quotes")));
}

TEST(TomlDocument, NumbersOutOfRangeSayWhichRange) {
    EXPECT_THAT(document_fault("a = 1\nb = 99999999999999999999"),
                HasSubstr("m.toml:2:5: 99999999999999999999 is out of range"));
    EXPECT_THAT(document_fault("a = [2, 1e999]"), HasSubstr("m.toml:1:9: 1e999 is out of range"));
}

TEST(TomlDocument, DuplicatesNameBothPlaces) {
    EXPECT_THAT(document_fault("a=1\n\nb=2\n a = 3\n"),
                HasSubstr("m.toml:4:2: cannot redefine existing integer 'a'; first defined on line 1, column 1"));
    EXPECT_THAT(document_fault("a=1\r\nb=2\r\nb=3\r\n"),
                HasSubstr("m.toml:3:1: cannot redefine existing integer 'b'; first defined on line 2, column 1"));
    EXPECT_THAT(document_fault("[x]\na.b=1\n[y]\n[x]\n"),
                HasSubstr("m.toml:4:1: cannot redefine existing table 'x'; first defined on line 1, column 2"));
    EXPECT_THAT(document_fault("[[q]]\nm.z=1\n[[q]]\nw=1\n[v]\nm.x=5\nm.x=6"),
                HasSubstr("m.toml:7:1: cannot redefine existing integer 'm.x'; first defined on line 6"));
    EXPECT_THAT(document_fault("a = {x=1, x=2}"), HasSubstr("m.toml:1:"));
}

TEST(TomlDocument, LettersBeyondAsciiMayFollowAFoldedLine) {
    EXPECT_EQ(document("t = \"\"\"a \\\n  éあ\"\"\"\n").find("t")->value.string, "a éあ");
    EXPECT_NE(document_fault("t = \"\"\"a \\é\"\"\"\n"), "");
}

// Oracle: no input may end the process, and every refusal has a text: bytes of a valid file deleted, doubled and swapped.
TEST(TomlDocument, DamagedFilesAreRefusedOrRead) {
    const std::string valid = model_with(
        "[[load]]\non=\"plate\"\ndirection=[0,0,1]\nforce={type=\"step\",to='1 "
        "N',end=1.5}\nx=\"\"\"a\n\"\"\"\ny.z=[[1],{a.b=2}]\n");
    std::mt19937 random(7);
    for (int i = 0; i < 20000; ++i) {
        std::string text = valid;
        for (int edit = 0; edit < 3; ++edit) {
            const std::size_t at = random() % text.size();
            const char kCharacters[] = "[]{}=.\"'\n\r,#\\ -+e0\t\x01\x7f\xc3";
            if (random() % 2)
                text.erase(at, 1 + random() % 3);
            else
                text.insert(at, 1 + random() % 3, kCharacters[random() % (sizeof(kCharacters) - 1)]);
        }
        Diagnostics diagnostics("m.toml");
        const bool is_read = parse_toml(text, diagnostics).has_value();
        EXPECT_EQ(is_read, !diagnostics.has_errors()) << text;
    }
}

}  // namespace
}  // namespace dttmm::host
