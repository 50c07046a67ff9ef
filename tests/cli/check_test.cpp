// SPDX-License-Identifier: BSD-3-Clause
//
// `dttmm check` says what a file is good for, and shows what the model is made of.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/process.h"
#include "cli/small_model.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

Ended check(const std::string& text) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", text);
    const Ended ended = run_dttmm(folder.path(), {"check", "model.toml"});
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1) << "it writes nothing";
    return ended;
}

TEST(Check, SaysWhatAFileIsGoodFor) {
    const Ended all = check(kSmallModel);
    EXPECT_EQ(all.code, 0);
    EXPECT_THAT(all.out, HasSubstr("model.toml: valid\n  good for run, modes and frf\n"));

    std::string text = kSmallModel;
    text.erase(text.find("[simulation]"), text.find("[[body]]") - text.find("[simulation]"));
    const Ended modes = check(text);
    EXPECT_EQ(modes.code, 0) << modes.err;
    EXPECT_THAT(modes.out, HasSubstr("good for modes and frf\n  not for run: model.toml:1:1: missing table [simulation]"));

    // Oracle: one body of 2 kg that nothing holds has six rigid-body modes and no vibration
    text = kSmallModel;
    text.erase(text.find("[[element]]"));
    const Ended run = check(text);
    EXPECT_EQ(run.code, 0) << run.err;
    EXPECT_THAT(run.out, HasSubstr("good for run\n  not for modes and frf: "));

    const Ended none = check(small_model_with("mass = \"=mass\"", "mass = 0"));
    EXPECT_EQ(none.code, 3);
    EXPECT_EQ(none.out, "");
}

TEST(Check, TheExamplesForModesAreValid) {
    for (const char* name : {"hydroplane", "double_cross"}) {
        const Ended ended =
            run_dttmm("/", {"check", fmt::format("{}/examples/{}/model.toml", test::paths::source_dir(), name)});
        EXPECT_EQ(ended.code, 0) << ended.err;
        EXPECT_THAT(ended.out, AllOf(HasSubstr("good for modes and frf\n"), HasSubstr("dofs is for `dttmm modes`")));
    }
}

// Oracle: closed forms. The plate of 9.42 kg as given; sqrt(4k/m)/(2 pi) = 73.3347 Hz.
TEST(Check, ShowsMassSizeCentreAndTheLowestFrequency) {
    const std::string file = test::paths::source_dir() + "/examples/four_bolt_plate/model.toml";
    EXPECT_THAT(run_dttmm("/", {"check", file}).out,
                AllOf(HasSubstr("lowest natural frequency 73.3347 Hz\n"),
                      HasSubstr("plate               9.42  0.3 x 0.2 x 0.02                (0, 0, 0)\n"),
                      HasSubstr("all bodies          9.42"), HasSubstr("bolt4       spring_damper  x along (1, 0, 0)")));
}

// Oracle: by hand. Two bodies of 2 and 6 kg at x = 0 and 0.4 m: their centre is at 0.3 m. The `from` end is turned by 90
// degrees about z, so that its x axis is the world's y axis.
TEST(Check, ShowsLengthsAndAxesAndWhereAForceActs) {
    const std::string second =
        "\n[[body]]\nname = \"block\"\nmass = 6\ninertia = [1, 1, 1]\nposition = [0.4, 0, 0]\n"
        "markers.turned = { position = [0, 0, 0], rotation = { axis = [0, 0, 1], angle = \"90 deg\" } }\n"
        "[[element]]\nname = \"tie\"\ntype = \"spring_damper\"\nfrom = \"block.turned\"\nto = \"plate.right\"\n"
        "stiffness = 5e4\n";
    const Ended ended = check(kSmallModel + second);
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(
        ended.out,
        AllOf(
            HasSubstr("all bodies             8"), HasSubstr("(0.3, 0, 0)"),
            HasSubstr(
                "tie         spring_damper  0.3 m long, x along (0, 1, 0), y along (-1, 0, 0) of its `from` end; its force "
                "acts at its `to` end\n"),
            HasSubstr("one         spring_damper  x along (1, 0, 0) of its `to` end\n")));
}

// Oracle: the turn by hand. A ground end has the axes of the other end, and `axes` goes before both.
TEST(Check, ShowsTheAxesThatAnElementHas) {
    const std::string turned =
        "\n[[body]]\nname = \"block\"\nmass = 6\ninertia = [1, 1, 1]\nposition = [0.4, 0, 0]\n"
        "markers.turned = { position = [0, 0, 0], rotation = { axis = [0, 0, 1], angle = \"90 deg\" } }\n"
        "[[element]]\nname = \"tie\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"block.turned\"\nstiffness = 5e4\n";
    EXPECT_THAT(check(kSmallModel + turned).out,
                HasSubstr("tie         spring_damper  x along (0, 1, 0), y along (-1, 0, 0) of its `to` end\n"));
    EXPECT_THAT(check(kSmallModel + turned + "axes = { axis = [0, 1, 0], angle = \"90 deg\" }\n").out,
                HasSubstr("tie         spring_damper  x along (0, 0, -1), y along (0, 1, 0)\n"));
}

TEST(Check, LongTablesAreCut) {
    std::string text = kSmallModel;
    for (int i = 0; i < 45; ++i)
        text += fmt::format(
            "\n[[body]]\nname = \"b{}\"\nmass = 1\ninertia = [1, 1, 1]\n[[element]]\nname = \"e{}\"\ntype = "
            "\"spring_damper\"\nfrom = \"ground\"\nto = \"b{}\"\nstiffness = 1e3\n",
            i, i, i);
    EXPECT_THAT(check(text).out,
                AllOf(HasSubstr("    and 6 more\n"), HasSubstr("    and 7 more\n"), Not(HasSubstr("  b40 "))));
}

// Oracle: by hand. Each body may turn about three axes, and ten modes are looked for. The shapes of 400 such bodies take
// minutes.
TEST(Check, MotionsThatNothingHoldsAreCounted) {
    for (const int bodies : {30, 40}) {
        std::string text = "format = \"dttmm/1\"\n[simulation]\nstep = \"1 ms\"\nduration = \"0.1 s\"\n";
        for (int i = 0; i < bodies; ++i)
            text += fmt::format(
                "[[body]]\nname = \"b{0}\"\nmass = 1\ninertia = [1, 1, 1]\n[[element]]\nname = \"e{0}\"\ntype = "
                "\"spring_damper\"\nfrom = \"ground\"\nto = \"b{0}\"\nstiffness = 1e3\n",
                i);
        EXPECT_THAT(
            check(text).out,
            HasSubstr(bodies == 30 ? "no natural frequency above 0 Hz among the first 90"
                                   : "natural frequencies not looked for, as nothing, or too little to be seen, holds "
                                     "120 motions"));
    }
}

// The table says 50 steps: so does the summary.
TEST(Check, TheStepsOfTheSummaryAreThoseOfTheTable) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", kSmallModel);
    EXPECT_THAT(run_dttmm(folder.path(), {"run", "model.toml", "-o", "out"}).out, HasSubstr("11 rows, 50 steps of 0.001 s"));
    EXPECT_EQ(read_json(folder / "out/summary.json").at("steps"), 50);
}

}  // namespace
}  // namespace dttmm::host
