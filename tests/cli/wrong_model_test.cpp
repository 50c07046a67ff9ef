// SPDX-License-Identifier: BSD-3-Clause
//
// What a user can get wrong in a model file, and what the command answers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/process.h"
#include "cli/small_model.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

/// One fault. Its place is that in model.toml, counted by hand; `says` is part of the message.
struct ModelFault {
    const char* name;
    std::string text;
    const char* place;
    const char* says;
};
void PrintTo(const ModelFault& fault, std::ostream* out) { *out << fault.name; }

ModelFault change(const char* name, const char* what, const char* instead, const char* place, const char* says) {
    return {name, small_model_with(what, instead), place, says};
}

std::string repeat(const std::string& part, int count) {
    std::string all;
    for (int i = 0; i < count; ++i) all += part;
    return all;
}

std::string every_byte() {
    std::string all;
    for (int i = 255; i >= 0; --i) all += static_cast<char>(i);
    return repeat(all, 4096);
}

class WrongModel : public testing::TestWithParam<ModelFault> {};

// Oracle: exit code 3 in less than a second, file:line:column, the fault in words, and nothing left behind.
TEST_P(WrongModel, IsRefusedWithPlaceAndCure) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", GetParam().text);
    for (const char* command : {"run", "check"}) {
        const Ended ended = run_dttmm(folder.path(), {command, "model.toml"});
        EXPECT_EQ(ended.code, 3) << ended.err;
        EXPECT_THAT(ended.err, HasSubstr(std::string("model.toml:") + GetParam().place + ": "));
        EXPECT_THAT(ended.err, HasSubstr(GetParam().says));
        EXPECT_EQ(ended.out, "");
        EXPECT_LT(ended.seconds, 5);  // a tenth without sanitizers on an idle machine
        EXPECT_FALSE(fs::exists(folder / "results"));
    }
}

const ModelFault kModelFaults[] = {
    {"EmptyFile", "", "1:1", "no format key"},
    {"BinaryFile", every_byte(), "1:1", "not UTF-8"},
    {"Utf16",
     std::string("\xff\xfe"
                 "f\0o\0",
                 6),
     "1:1", "UTF-16"},
    {"NulByte", std::string("format = \"dttmm/1\"\ntitle = \"a\0b\"\n", 34), "2:11", "NUL byte"},
    {"KeyOf100000Parts", repeat("a.", 99999) + "a = 1\n", "1:128", "key too deep"},
    {"HeaderOf100000Parts", "[" + repeat("a.", 99999) + "a]\n", "1:129", "key too deep"},
    {"NestedArrays", "a = " + repeat("[", 100000), "1:37", "nested too deep"},
    {"LongLine", "format = \"dttmm/1\"\na = \"" + repeat("x", 10000000) + "\"\n", "2:1", "a line of"},
    {"OpenString", "format = \"dttmm/1", "1:10", "not closed"},
    change("TripleBracket", "[[body]]", "[[[body]]", "14:3", "expected"),
    change("OtherFormat", "dttmm/1", "dttmm/9", "1:10", "format \"dttmm/1\" only"),
    change("UnknownTopKey", "title = ", "titel = ", "2:1", "did you mean \"title\"?"),
    change("MisspeltKey", "stiffness = \"5e4 N/m\"", "stifness = 1", "31:1", "unknown key \"stifness\""),
    change("DuplicateKey", "mass = \"=mass\"", "mass = 1\nmass = 2", "17:1", "mass"),
    change("MissingMass", "mass = \"=mass\"\n", "", "14:1", "missing key \"mass\""),
    change("MassZero", "\"=mass\"", "0", "16:8", "mass must"),
    change("MassNegative", "\"=mass\"", "-1", "16:8", "mass must"),
    change("MassNan", "\"=mass\"", "nan", "16:8", "mass must be finite"),
    change("MassInfinite", "\"=mass\"", "inf", "16:8", "mass must be finite"),
    change("MassOutOfRange", "\"=mass\"", "1e999", "16:8", "out of range"),
    change("DecimalComma", "\"=mass\"", "\"0,5 kg\"", "16:8", "the decimal sign is a point"),
    change("UnknownParameter", "\"=mass\"", "\"=mas\"", "16:8", "did you mean \"mass\"?"),
    change("ExpressionNotFinite", "\"=mass\"", "\"=mass/0\"", "16:8", "not finite"),
    change("WrongDimension", "\"5e4 N/m\"", "\"500 kg\"", "31:13", "expected a value in N/m, got \"500 kg\""),
    change("NegativeStiffness", "\"5e4 N/m\"", "-1", "31:13", "stiffness must be"),
    change("NanStiffness", "\"5e4 N/m\"", "nan", "31:13", "stiffness must be finite"),
    change("TwoInsteadOfThree", "[0.2, 0.3, 0.4]", "[0.2, 0.3]", "17:11", "3"),
    change("TriangleRule", "[0.2, 0.3, 0.4]", "[1, 1, 100]", "17:11", "triangle"),
    change("QuaternionZero", "inertia", "quaternion = [0, 0, 0, 0]\ninertia", "17:14", "norm 1"),
    change("QuaternionNotUnit", "inertia", "quaternion = [0.9, 0, 0, 0]\ninertia", "17:14", "norm 1"),
    change("StepZero", "step = \"1 ms\"", "step = 0", "9:8", "step must be"),
    change("StepNegative", "step = \"1 ms\"", "step = \"-1 ms\"", "9:8", "step must be"),
    change("StepNan", "step = \"1 ms\"", "step = nan", "9:8", "step must be finite"),
    change("StepTiny", "step = \"1 ms\"", "step = 1e-300", "9:8", "step must be"),
    change("StepNotDividingDuration", "step = \"1 ms\"", "step = \"3 ms\"", "8:12", "whole number of steps"),
    change("StepNotDividingOutputStep", "step = \"5 ms\"", "step = \"2.5 ms\"", "12:8", "whole multiple of the time step"),
    change("TooManySteps", "\"50 ms\"", "1e9", "8:12", "steps; at most"),
    change("BothEndsOnGround", "\"plate.left\"", "\"ground\"", "30:6", "both ends are on the ground"),
    change("BothEndsOnOneBody", "from = \"ground\"", "from = \"plate.right\"", "30:6", "both ends are on the same body"),
    change("UnknownMarker", "plate.left\"", "plate.lift\"", "30:6", "no marker \"lift\"; did you mean \"left\"?"),
    change("UnknownBody", "\"plate.left\"", "\"plaet.left\"", "30:6", "no body \"plaet\"; did you mean \"plate\"?"),
    change("DuplicateName", "name = \"two\"", "name = \"one\"", "34:8", "taken already, on line 27"),
    change("NameIsAPath", "name = \"one\"", "name = \"../../x\"", "27:8", "a name is made of letters"),
    change("TypeIsAPath", "\"spring_damper\"", "\"./evil.so\"", "28:8", "no loaded plugin declares"),
    change("DecreasingTable", "\"100 N\"", "{ type = \"table\", times = [0, 2, 1], values = [0, 1, 2] }", "24:42",
           "times must increase"),
    change("TableOutside", "\"100 N\"", "{ type = \"table\", file = \"../secret.csv\" }", "24:34",
           "outside the model folder"),
    change("TableAbsolute", "\"100 N\"", "{ type = \"table\", file = \"/etc/passwd\" }", "24:34",
           "outside the model folder"),
};

INSTANTIATE_TEST_SUITE_P(Command, WrongModel, testing::ValuesIn(kModelFaults),
                         [](const auto& one) { return one.param.name; });

// Oracle: a file with 60 faults: 50 lines with a place, and a word about the other ten.
TEST(WrongModels, AllFaultsAreToldInOneGo) {
    const TemporaryFolder folder;
    std::string text = kSmallModel;
    for (int i = 0; i < 60; ++i)
        text +=
            "[[element]]\nname = \"e" + std::to_string(i) + "\"\ntype = \"nothing\"\nfrom = \"ground\"\nto = \"plate\"\n";
    write_text(folder / "model.toml", text);
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml"});
    EXPECT_EQ(ended.code, 3);
    int places = 0;
    for (size_t at = 0; (at = ended.err.find("model.toml:", at)) != std::string::npos; ++at) ++places;
    EXPECT_EQ(places, 50);
    EXPECT_THAT(ended.err, HasSubstr("10"));
}

// A file that a table points to must not speak through an error.
TEST(WrongModels, AnErrorNeverQuotesATableFilesContent) {
    const TemporaryFolder folder;
    write_text(folder / "secret.csv", "password=swordfish\n");
    write_text(folder / "model.toml", small_model_with("\"100 N\"", "{ type = \"table\", file = \"secret.csv\" }"));
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml"});
    EXPECT_EQ(ended.code, 3);
    EXPECT_THAT(ended.err, testing::AllOf(HasSubstr("secret.csv"), testing::Not(HasSubstr("swordfish"))));
}

// Oracle: the same file with the line ends of another system gives the same history.
TEST(WrongModels, CarriageReturnsAreNoFault) {
    const TemporaryFolder folder;
    std::string text = kSmallModel;
    for (size_t at = 0; (at = text.find('\n', at)) != std::string::npos; at += 2) text.insert(at, "\r");
    write_text(folder / "unix.toml", kSmallModel);
    write_text(folder / "dos.toml", text);
    ASSERT_EQ(run_dttmm(folder.path(), {"run", "unix.toml"}).code, 0);
    ASSERT_EQ(run_dttmm(folder.path(), {"run", "dos.toml"}).code, 0);
    EXPECT_EQ(read_text(folder / "results/unix/history.csv"), read_text(folder / "results/dos/history.csv"));
}

// Oracle: reading this file at 0 fails with EIO on Linux, and its size is 0: no empty file.
TEST(WrongFile, ThatCannotBeReadIsNoEmptyFile) {
    const TemporaryFolder folder;
    for (const char* command : {"check", "run", "modes"}) {
        const Ended ended = run_dttmm(folder.path(), {command, "/proc/self/mem"});
        EXPECT_EQ(ended.code, 5) << ended.err;
        EXPECT_THAT(ended.err, testing::HasSubstr("/proc/self/mem: cannot be read: Input/output error"));
    }
}

}  // namespace
}  // namespace dttmm::host
