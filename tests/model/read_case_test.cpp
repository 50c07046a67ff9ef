// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_case.h"

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// Three loads, "snow" twice, from line 12 on; then the cases, from line 27 on.
std::string with_cases(const std::string& cases) {
    std::string loads;
    for (const char* name : {"snow", "wind", "snow"})
        loads +=
            std::string("[[load]]\nname = \"") + name + "\"\non = \"plate\"\ndirection = [1, 0, 0]\nforce = \"=10*t\"\n";
    return model_with(loads + cases);
}

// Oracle: the sums by hand.
TEST(ReadCase, FactorsOfLoadsAndOfCases) {
    const Model model = parse(with_cases(R"([[case]]
name = "sum"
factors = { wind = 0.5 }
cases = { a = 2, b = -3 }
[[case]]
name = "a"
loads = ["snow", "wind"]
[[case]]
name = "b"
factors = { wind = "40 %" }
gravity = 0.25
)"));
    ASSERT_EQ(model.cases.size(), 3u);
    EXPECT_THAT(model.cases[1].load_factors, ElementsAre(1, 1, 1));
    EXPECT_EQ(model.cases[1].gravity, 1);
    EXPECT_THAT(model.cases[2].load_factors, ElementsAre(0, 0.4, 0));
    EXPECT_THAT(model.cases[0].load_factors, ElementsAre(2, testing::DoubleEq(0.5 + 2 - 3 * 0.4), 2));
    EXPECT_EQ(model.cases[0].gravity, 2 - 3 * 0.25);
    EXPECT_EQ(model.loads[0].signal.value(2), 20) << "as the file has them";
    EXPECT_TRUE(model.warnings.empty());
}

TEST(ReadCase, ABraceOutsideOfARepeatIsNoName) {
    EXPECT_EQ(errors_of(with_cases("[[load]]\nname = \"l{i}\"\non = \"plate\"\ndirection = [1, 0, 0]\nforce = 1\n[[case]]\n"
                                   "name = \"c{i}\"\nloads = [\"snow\", \"wind\"]\n")),
              "m.toml:28:8: load name \"l{i}\" holds a brace (braces hold the index of a [[repeat]], and this is in none)\n"
              "m.toml:33:8: case name \"c{i}\" holds a brace (braces hold the index of a [[repeat]], and this is in none)");
    EXPECT_TRUE(parse(with_cases("[[case]]\nname = \"wind & snow, 1.5\"\nloads = [\"snow\", \"wind\"]\n")).warnings.empty());
}

TEST(ReadCase, OneThatIsAskedForScalesTheLoads) {
    ModelOverrides overrides;
    overrides.load_case = "b";
    const std::string cases = "[[case]]\nname = \"b\"\nfactors = { wind = -4 }\n";
    const Model model = parse(with_cases(cases), overrides);
    EXPECT_EQ(model.load_case, "b");
    EXPECT_EQ(model.loads[0].signal.value(2), 0);
    EXPECT_EQ(model.loads[1].signal.value(2), -80);
    EXPECT_THAT(model.warnings, ElementsAre(WarningIs("load-in-no-case", HasSubstr("load \"snow\" acts in no case")),
                                            WarningIs("load-in-no-case", HasSubstr("load \"snow\""))));
    overrides.load_case = "bb";
    EXPECT_THROW(parse(with_cases(cases), overrides), Error);
    overrides.load_case = "b";
    EXPECT_THROW(parse(with_cases(""), overrides), Error);
}

TEST(ReadCase, Faults) {
    const auto fault = [](const std::string& text) { return errors_of(with_cases(text)); };
    EXPECT_THAT(fault("[[case]]\nname = \"a\"\nloads = [\"snov\"]\n"),
                HasSubstr("case \"a\": there is no load \"snov\"; did you mean \"snow\"?"));
    EXPECT_THAT(fault("[[case]]\nname = \"a\"\n"), HasSubstr("case \"a\": nothing acts in it; write loads"));
    EXPECT_THAT(fault("[[case]]\nloads = [\"snow\"]\n"), HasSubstr("missing key \"name\""));
    EXPECT_THAT(fault("[[case]]\nname = \"a\"\nloads = [\"snow\"]\nfactors = { snow = 2 }\n"),
                HasSubstr("\"snow\" is named twice; give it one factor"));
    EXPECT_THAT(fault("[[case]]\nname = \"a\"\ngravity = 1\n[[case]]\nname = \"a\"\ngravity = 1\n"),
                HasSubstr("there is a case \"a\" already, at m.toml:"));
    EXPECT_THAT(fault("[[case]]\nname = \"a\"\ncases = { b = 1 }\n[[case]]\nname = \"b\"\ncases = { a = 1 }\n"),
                HasSubstr("case \"b\": it is a part of itself by case \"a\""));
    EXPECT_THAT(fault("[[case]]\nname = \"alpha\"\ngravity = 1\n[[case]]\nname = \"b\"\ncases = { alpah = 1 }\n"),
                HasSubstr("case \"b\": there is no case \"alpah\"; did you mean \"alpha\"?"));
    EXPECT_THAT(fault("[[case]]\nname = \"a\"\nloads = \"snow\"\n"), HasSubstr("loads must be a list of names"));
    EXPECT_THAT(fault("[[case]]\nname = \"a\"\nfactors = { snow = \"1 N\" }\n"), HasSubstr("factors.snow"));
    EXPECT_THAT(errors_of(model_with("[[load]]\non = \"plate\"\ndirection = [1, 0, 0]\nforce = 1\n"
                                     "[[case]]\nname = \"a\"\nloads = [\"wind\"]\n")),
                HasSubstr("there is no load \"wind\"; give the load a name = \"wind\""));
    // A load with a fault of its own is not missing
    const std::string faulty =
        errors_of(model_with("[[load]]\nname = \"wind\"\non = \"plate\"\ndirection = [1, 0, 0]\nforce = \"1 m\"\n"
                             "[[case]]\nname = \"a\"\nloads = [\"wind\"]\n"));
    EXPECT_THAT(faulty, HasSubstr("force"));
    EXPECT_THAT(faulty, testing::Not(HasSubstr("there is no load")));
}

}  // namespace
}  // namespace dttmm::host
