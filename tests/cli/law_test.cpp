// SPDX-License-Identifier: BSD-3-Clause
//
// Laws of other people: tested by check-law, and what becomes of a run with a bad one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "process.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string faulty_law(const std::string& fault) { return test::paths::binary_dir() + "/tests/faulty/law_" + fault + ".so"; }

TEST(CheckLaw, PassesALawThatKeepsTheRules) {
    for (const std::string& law : {test::paths::jenkins(), faulty_law("none")}) {
        const Ended ended = run_dttmm("/", {"check-law", law});
        EXPECT_EQ(ended.code, 0) << ended.err;
        EXPECT_THAT(ended.out, HasSubstr(": keeps all rules, 1500 paths"));
    }
    EXPECT_EQ(run_dttmm("/", {"check-law", test::paths::jenkins(), "--set", "slip=2 kN", "--set", "stiffness=3 kN/mm"}).code,
              0);
    EXPECT_THAT(run_dttmm("/", {"check-law", test::paths::jenkins(), "--set", "slop=2"}).err,
                HasSubstr("--set slop: no law has a parameter of that name"));
}

// Oracle: planted faults.
TEST(CheckLaw, FindsEveryPlantedFault) {
    const std::pair<const char*, const char*> faults[] = {
        {"wrong_tangent", "its tangent is not the derivative of its force"},
        {"impure", "it answers the same question in two ways"},
        {"force_at_zero", "a path of no length changes its force"},
        {"negative_dissipation", "it dissipates less than nothing"},
        {"open_loop", "it is elastic, but does work on a closed path"},
        {"not_a_number", "its answer is not finite"},
        {"writes_memory", "it changes the memory it is given"},
        {"other_major", "law \"faulty\": it is of another version"},
        {"no_name", "its name must be letters, digits and underscores"},
        {"taken_name", "there is another law of this name"},
        {"much_memory", "it remembers more than 256 numbers"},
        {"other_unit", "another law has a parameter of the same name with another unit"},
        {"overrun", "it writes more numbers than its memory has"},
        {"tangent_of_slip", "its tangent is not that of going back"},
        {"tangent_in_mm", "its tangent is not the derivative of its force"},
        {"not_at_rest", "its answer is not finite (path 0 to "},
        {"unit_of_nothing", "k has a unit that cannot be read"},
        {"documentation_of_escapes", "the documentation of stiffness is not one line of text"},
        {"key_of_elements", "a parameter has the name of a key of elements: rename it"},
        {"digit_first", "a parameter is not well declared"},
        {"rounds_up", "has changed the rounding mode of the processor"}};
    for (const auto& [fault, says] : faults) {
        const Ended ended = run_dttmm("/", {"check-law", faulty_law(fault)});
        EXPECT_EQ(ended.code, 7) << fault;
        EXPECT_THAT(ended.err, HasSubstr(says)) << fault;
        EXPECT_EQ(ended.out, "") << fault;
    }
    EXPECT_THAT(run_dttmm("/", {"check-law", test::paths::c_spring()}).err, HasSubstr("there is no law in it"));
    EXPECT_EQ(run_dttmm("/", {"check-law", "/nowhere.so"}).code, 7);
}

constexpr const char* kModel = R"(format = "dttmm/1"
[simulation]
duration = "20 ms"
step = "1 ms"
[[body]]
name = "b"
mass = 2
box = [0.1, 0.2, 0.3]
velocity = [0, 0, 0.1]
[[element]]
name = "pad"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = [1e4, 1e4, 0]
rotational_stiffness = [10, 10, 10]
z = { law = "faulty", stiffness = 2e4 }
)";

// Oracle: the linear spring that it is, in either element.
TEST(ForeignLaw, RunsAsTheSpringThatItIs) {
    const TemporaryFolder folder;
    const std::string linear = kModel;
    const auto replaced = [](std::string text, const std::string& what, const std::string& by) {
        return text.replace(text.find(what), what.size(), by);
    };
    write_text(folder / "law.toml", linear);
    write_text(folder / "linear.toml", replaced(linear, "faulty", "linear"));
    const std::string hinge = replaced(linear, "type = \"spring_damper\"", "type = \"elastic_hinge\"");
    write_text(folder / "hinge.toml",
               replaced(replaced(hinge, "[1e4, 1e4, 0]", "{ x = 1e4, y = 1e4, rx = 10, ry = 10, rz = 10 }"),
                        "rotational_stiffness = [10, 10, 10]\n", ""));
    EXPECT_EQ(run_dttmm(folder.path(), {"run", "linear.toml", "-q", "-o", "linear"}).code, 0);
    const auto own = read_history(folder / "linear/history.csv");
    for (const std::string name : {"law", "hinge"}) {
        const Ended ended =
            run_dttmm(folder.path(), {"run", name + ".toml", "-q", "-o", name, "--plugin", faulty_law("none")});
        EXPECT_EQ(ended.code, 0) << ended.err;
        const auto law = read_history(folder / (name + "/history.csv"));
        ASSERT_EQ(law.size(), own.size());
        for (size_t n = 0; n < law.size(); ++n)
            for (size_t c = 0; c < law[n].size(); ++c) EXPECT_NEAR(law[n][c], own[n][c], 1e-9 * (1 + std::abs(own[n][c])));
    }
}

// Oracle: the minimum that the law declares; the law "linear" has a parameter of the same name from 0 on.
TEST(ForeignLaw, HasItsOwnMinimum) {
    const TemporaryFolder folder;
    std::string text = kModel;
    text.replace(text.find("2e4"), 3, "999");
    write_text(folder / "model.toml", text);
    const Ended ended = run_dttmm(folder.path(), {"check", "model.toml", "--plugin", faulty_law("own_minimum")});
    EXPECT_EQ(ended.code, 3);
    EXPECT_THAT(ended.err, AllOf(HasSubstr("model.toml:"), HasSubstr("element \"pad\""),
                                 HasSubstr("z.stiffness must be at least 1000 N/m, as the law faulty has it")));
    text.replace(text.find("faulty"), 6, "linear");
    write_text(folder / "model.toml", text);
    EXPECT_EQ(run_dttmm(folder.path(), {"check", "model.toml", "--plugin", faulty_law("own_minimum")}).code, 0);
}

TEST(ForeignLaw, ThatBreaksIsNamedWithElementAndTime) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", kModel);
    const auto error_of = [&](const char* command, const std::string& fault) {
        const Ended ended =
            run_dttmm(folder.path(), {command, "model.toml", "-q", "-o", fault, "--plugin", faulty_law(fault)});
        EXPECT_EQ(ended.code, 7) << fault;
        return ended.err;
    };
    const auto pad = HasSubstr("element \"pad\""), at_first = HasSubstr("t = 0.001 s: element \"pad\"");
    EXPECT_THAT(error_of("run", "not_a_number"), AllOf(at_first, HasSubstr("law \"faulty\": its answer is not finite"),
                                                       HasSubstr("rows recorded in not_a_number")));
    EXPECT_THAT(error_of("modes", "other_major"), HasSubstr("law \"faulty\": it is of another version"));
    // Memory of other elements stays what it is; what a law does not write is no memory of an earlier question
    EXPECT_THAT(error_of("run", "overrun"),
                AllOf(pad, HasSubstr("law \"faulty\": it writes more than the 1 numbers of its memory")));
    EXPECT_THAT(error_of("run", "forgets"), HasSubstr("law \"faulty\": its answer is not finite"));
    EXPECT_THAT(error_of("run", "force_at_zero"),
                AllOf(pad, HasSubstr("law \"faulty\": on a path of no length its mean force is")));
    EXPECT_THAT(error_of("run", "rounds_up"),
                AllOf(at_first, HasSubstr("law \"faulty\": it has changed how the processor computes")));
#ifndef __SANITIZE_ADDRESS__
    EXPECT_THAT(error_of("run", "segmentation"),
                AllOf(HasSubstr("dttmm: law \"faulty\" of "), HasSubstr("element \"pad\", t = 0.001 s"),
                      HasSubstr("the rows written stay")));
#endif
}

TEST(ForeignLaw, IsMissedWithoutItsLibrary) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", kModel);
    const Ended ended = run_dttmm(folder.path(), {"check", "model.toml"});
    EXPECT_EQ(ended.code, 3);
    EXPECT_THAT(ended.err, HasSubstr("a law of your own is known with --plugin and its library"));
}

}  // namespace
}  // namespace dttmm::host
