// SPDX-License-Identifier: BSD-3-Clause
//
// What `dttmm modes` refuses, with which code and which words.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/modes_run.h"
#include "cli/small_model.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;

/// `dttmm words...` with a model m.toml of this text in its folder.
Ended ended_with(const std::string& text, const std::vector<std::string>& words) {
    const TemporaryFolder folder;
    write_text(folder / "m.toml", text);
    const Ended ended = run_dttmm(folder.path(), words);
    EXPECT_EQ(fs::exists(folder / "results"), ended.code == 0) << "a refused model leaves nothing";
    return ended;
}
Ended modes_with(const std::string& text, std::vector<std::string> words = {}) {
    words.insert(words.begin(), {"modes", "m.toml"});
    return ended_with(text, words);
}
void expect_refused(const Ended& ended, int code, const testing::Matcher<std::string>& text) {
    EXPECT_EQ(ended.code, code) << ended.err;
    EXPECT_THAT(ended.err, text);
    EXPECT_EQ(ended.out, "");
}

/// A bar between a and b, clamped at a; `head` stands before it.
std::string bar(const std::string& head = "", const std::string& b = "[2, 0, 0]") {
    return "format = \"dttmm/1\"\n" + head + R"([nodes]
a = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
b = )" + b +
           R"(
[[element]]
name = "bar"
type = "beam"
from = "a"
to = "b"
section = { circle = 0.04 }
material = { E = 210e9, poisson = 0.3, density = 7850 }
)";
}

TEST(ModesWrong, NothingElastic) {
    const std::string body = R"(format = "dttmm/1"
[[body]]
name = "plate"
mass = 2
inertia = [1, 1, 1]
)";
    expect_refused(modes_with(body), 3, HasSubstr("m.toml: no element: nothing is elastic, nothing vibrates"));
    const std::string damper =
        body + "[[element]]\nname = \"d\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"plate\"\ndamping = 3\n";
    expect_refused(modes_with(damper), 3, AllOf(HasSubstr("m.toml"), HasSubstr("nothing is elastic")));
}

// A spring between a body and the ground in a direction that does not move stores nothing either.
TEST(ModesWrong, NothingElasticInTheDirectionsLeft) {
    const std::string text = R"(format = "dttmm/1"
dofs = ["y"]
[[body]]
name = "plate"
mass = 2
inertia = [1, 1, 1]
[[element]]
name = "s"
type = "spring_damper"
from = "ground"
to = "plate"
stiffness = [100, 0, 0]
)";
    expect_refused(modes_with(text), 3, HasSubstr("nothing is elastic"));
}

// Oracle: the count proves that there is none: the list is empty, and that is no failure.
TEST(ModesWrong, ARangeWithoutAFrequencyHasAnEmptyList) {
    for (const auto& [model, words, says] : {std::tuple{bar("[modes]\nbelow = \"1 Hz\"\n"), std::vector<std::string>{},
                                                        "m.toml:3:9: no natural frequency lies below 1 Hz\n"},
                                             {bar(), {"--below", "2 Hz"}, "--below: no natural frequency lies below 2 Hz\n"},
                                             {bar("[parameters]\nk = 1\n"),
                                              {"--below", "2 Hz", "--sweep", "k=1,2"},
                                              "--below: no natural frequency lies below 2 Hz\n"}}) {
        const TemporaryFolder folder;
        write_text(folder / "m.toml", model);
        std::vector<std::string> all = {"modes", "m.toml", "-o", "out"};
        all.insert(all.end(), words.begin(), words.end());
        const Ended ended = run_dttmm(folder.path(), all);
        EXPECT_EQ(ended.code, 0) << ended.err;
        EXPECT_THAT(ended.err, testing::StartsWith(says));
        if (words.size() > 2)
            EXPECT_EQ(read_text(folder / "out/sweep.csv"), "case,k\n,1\ncase-000001,1\ncase-000002,2\n");
        else
            EXPECT_EQ(read_json(folder / "out/summary.json")["modes"], nlohmann::json::array());
    }
}

TEST(ModesWrong, FrequenciesTooHighToCount) {
    expect_refused(modes_with(bar(), {"--below", "1e9 Hz"}), 6,
                   AllOf(HasSubstr("element \"bar\""), HasSubstr("too many waves"), HasSubstr("ask for lower frequencies")));
}

TEST(ModesWrong, DirectionsMisspeltOrNone) {
    expect_refused(modes_with(bar("dofs = []\n")), 3, HasSubstr("m.toml:2:1: dofs names no direction"));
    expect_refused(modes_with(bar("dofs = [\"x\", \"zz\"]\n")), 3, AllOf(HasSubstr("m.toml:2:14"), HasSubstr("\"zz\"")));
    expect_refused(modes_with(bar("dofs = [\"x\", \"x\"]\n")), 3, HasSubstr("dofs names \"x\" twice"));
    expect_refused(modes_with(bar("dofs = \"x\"\n")), 3, HasSubstr("dofs must be a list"));
    expect_refused(modes_with(bar("dofs = [3]\n")), 3, HasSubstr("m.toml:2:9"));
}

TEST(ModesWrong, CountAndBelow) {
    expect_refused(modes_with(bar("[modes]\ncount = 3\nbelow = \"9 Hz\"\n")), 3, HasSubstr("give one"));
    expect_refused(modes_with(bar(), {"--count", "3", "--below", "9 Hz"}), 2, HasSubstr("give one"));
    for (const char* count : {"0", "-1", "2.5", "many", "10001"})
        expect_refused(modes_with(bar(), {"--count", count}), 2, HasSubstr("--count"));
    for (const char* below : {"0 Hz", "-3 Hz", "9 kg", "nan", "inf"})
        expect_refused(modes_with(bar(), {"--below", below}), 2, HasSubstr("--below"));
    expect_refused(modes_with(bar("[modes]\ncount = 0\n")), 3, HasSubstr("m.toml:3:9"));
    expect_refused(modes_with(bar("[modes]\ncount = 2.5\n")), 3, HasSubstr("whole number"));
    expect_refused(modes_with(bar("[modes]\nbelow = 0\n")), 3, HasSubstr("m.toml:3:9"));
    expect_refused(modes_with(bar("[modes]\nbeams = \"lumpy\"\n")), 3, AllOf(HasSubstr("lumpy"), HasSubstr("lumped")));
    expect_refused(modes_with(bar("[modes]\ncuont = 3\n")), 3, HasSubstr("did you mean \"count\"?"));
}

// A command line overrides the file: of its own two one is enough.
TEST(ModesWrong, TheCommandLineOverridesTheFile) {
    const std::string text = bar("[modes]\nbelow = \"1 Hz\"\n");
    const Ended ended = modes_with(text, {"--count", "3", "-q"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(ended.out, "");
}

TEST(ModesWrong, AMassThatNothingHolds) {
    // A node that hangs on a spring in x alone: nothing determines its other directions
    const std::string text = bar() + R"([[element]]
name = "loose"
type = "spring_damper"
from = "b"
to = "c"
stiffness = [1e5, 0, 0]
)";
    std::string with_node = text;
    with_node.replace(with_node.find("b = "), 0, "c = [2, 0, 0]\n");
    expect_refused(modes_with(with_node), 3,
                   AllOf(HasSubstr("element \"loose\""), HasSubstr("node \"c\""), HasSubstr("nothing determines its motion"),
                         HasSubstr("it has no inertia")));
}

TEST(ModesWrong, ABeamAtAnAngleToTheDirectionsLeft) {
    const std::string text = bar("dofs = [\"x\", \"y\", \"rz\"]\n", "[2, 0, 0.5]");
    expect_refused(modes_with(text), 3,
                   AllOf(HasSubstr("m.toml:6:1"), HasSubstr("element \"bar\""), HasSubstr("at an angle")));
}

// Its pieces would be held against bending wherever they meet, and so its frequencies depend on their number.
TEST(ModesWrong, ABeamWithoutTheRotationThatBendsIt) {
    expect_refused(modes_with(bar("dofs = [\"y\"]\n", "[2, 0, 0]")), 3,
                   AllOf(HasSubstr("m.toml:6:1"), HasSubstr("dofs keep its local y but not rz"), HasSubstr("take a rod")));
    expect_refused(modes_with(bar("dofs = [\"x\", \"y\", \"z\", \"rz\"]\n", "[2, 0, 0]")), 3,
                   HasSubstr("dofs keep its local z but not ry"));
}

TEST(ModesWrong, SectionsThatDoNotSayEnough) {
    const auto with = [](const std::string& section, const std::string& dofs) {
        std::string text = bar(dofs);
        text.replace(text.find("section = { circle = 0.04 }"), 27,
                     "section = { " + section + " }\ntheory = \"euler-bernoulli\"");
        return text.erase(text.find("material"));
    };
    const std::string plane = "dofs = [\"x\", \"y\", \"rz\"]\n", twist = "dofs = [\"rx\"]\n";
    expect_refused(modes_with(with("EA = 1e6, mass = 2", plane)), 3, HasSubstr("section.EIz is needed"));
    expect_refused(modes_with(with("EA = 1e6, mass = 2, EIz = 10", "")), 3, HasSubstr("section.EIy is needed"));
    expect_refused(modes_with(with("EA = 1e6, mass = 2, EIz = 10", twist)), 3, HasSubstr("section.GJ is needed"));
    expect_refused(modes_with(with("EA = 1e6, mass = 2, EIz = 10, GJ = 20", twist)), 3,
                   HasSubstr("section.inertia is needed"));
    EXPECT_EQ(modes_with(with("EA = 1e6, mass = 2, EIz = 10, GJ = 20, inertia = 0.1", twist)).code, 0);
    EXPECT_EQ(modes_with(with("EA = 1e6, mass = 2, EIz = 10", plane)).code, 0);
}

// Oracle: a bar clamped at one end, (2k − 1)/4l √(EA/μ): a rod needs neither inertia nor more.
TEST(ModesWrong, ARodNeedsItsStiffnessAndMassOnly) {
    std::string text = bar("[modes]\ncount = 3\n");
    text.replace(text.find("\"beam\""), 6, "\"rod\"");
    text.replace(text.find("section = { circle = 0.04 }"), 27, "section = { EA = 1e6, mass = 2 }");
    text.erase(text.find("material"));
    const double f = std::sqrt(1e6 / 2) / 8;
    expect_frequencies(frequencies_of(modes_of(text)), {f, 3 * f, 5 * f}, 1e-9);
}

// `dofs` of a file is no run's: what it leaves out would move all the same.
TEST(ModesWrong, DirectionsInARun) {
    const std::string text = "format = \"dttmm/1\"\ndofs = [\"x\"]\n" + std::string(kSmallModel).substr(19);
    expect_refused(ended_with(text, {"run", "m.toml"}), 3,
                   AllOf(HasSubstr("m.toml:2:1"), HasSubstr("dofs is for `dttmm modes`")));
    EXPECT_EQ(modes_with(text).code, 0);
    // [modes] may stand in the file of a run
    const std::string with_modes = std::string(kSmallModel) + "[modes]\ncount = 2\n";
    EXPECT_EQ(ended_with(with_modes, {"run", "m.toml", "-q"}).code, 0);
}

TEST(ModesWrong, APluginWithoutModes) {
    const std::string minimal = read_text(test::paths::source_dir() + "/examples/minimal_plugin/model.toml");
    const Ended ended = ended_with(minimal, {"modes", "m.toml", "--plugin", test::paths::c_spring()});
    expect_refused(ended, 7, HasSubstr("knows histories only, no natural frequencies"));
}

TEST(ModesWrong, WordsOfTheCommandLine) {
    expect_refused(ended_with(bar(), {"modes", "m.toml", "--set", "k=3"}), 2, HasSubstr("the model has no such parameter"));
    expect_refused(ended_with(bar(), {"modes", "m.toml", "--sweep", "k=1..3:3"}), 2,
                   HasSubstr("--sweep \"k\": no such parameter"));
    expect_refused(ended_with(bar(), {"modes", "other.toml"}), 5, HasSubstr("other.toml"));
}

// Oracle: √(k/m)/2π = 0.00195 Hz, a sixtieth of where rounding of the stiff spring hides what is counted. Nothing may list
// it with 0 Hz and say that the list is complete.
TEST(ModesWrong, ASpringTooSoftToBeCountedIsNotCalledFree) {
    const char* const text = R"(format = "dttmm/1"
[[body]]
name = "a"
mass = 1
inertia = [1, 1, 1]
[[body]]
name = "b"
mass = 1
inertia = [1, 1, 1]
position = [1, 0, 0]
[[element]]
name = "stiff"
type = "spring_damper"
from = "ground"
to = "a"
stiffness = [1e12, 2e5, 3e5]
rotational_stiffness = [1000, 1100, 1300]
[[element]]
name = "soft"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = [1.5e-4, 4e5, 5e5]
rotational_stiffness = [1000, 1100, 1300]
)";
    expect_refused(modes_with(text, {"--count", "3"}), 4,
                   HasSubstr("a natural frequency at about 0.0019 Hz cannot be told from a motion that nothing holds"));
}

}  // namespace
}  // namespace dttmm::host
