// SPDX-License-Identifier: BSD-3-Clause
//
// Loads without a potential: what `static` and `modes` say of stability under them, and what they do not.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "cli/process.h"
#include "cli/static_run.h"

namespace dttmm::host {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::Not;

constexpr double kTall = 1, kSoftPlane = 400, kStiffPlane = 800;  // [m, N m²]

/// A clamped column, its tip a body or a node that is fixed in some directions, and one load.
std::string pressed_column(const std::string& tip, const std::string& load) {
    return fmt::format(R"(format = "dttmm/1"
[nodes]
root = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
{}
[[element]]
name = "column"
type = "beam"
from = "root"
to = "tip"
segments = 20
theory = "euler-bernoulli"
section = {{ EA = 1e8, EIy = {}, EIz = {}, GJ = 200, mass = 2, inertia = 0.003 }}
[[load]]
{}
[modes]
count = 3
)",
                       tip, kStiffPlane, kSoftPlane, load);
}

const std::string kTipNode = "tip = [1, 0, 0]", kTipInPlane = R"(tip = { position = [1, 0, 0], fixed = ["z", "rx", "ry"] })",
                  kTipBody = "[[body]]\nname = \"tip\"\nmass = 0.01\ninertia = [1e-6, 1e-6, 1e-6]\nposition = [1, 0, 0]";

std::string pressure(double force, const char* axes) {
    return fmt::format("on = \"tip\"\ndirection = [-1, 0, 0]\nforce = {}\naxes = \"{}\"", force, axes);
}
std::string end_moment(const char* direction, double size) {
    return fmt::format("on = \"tip\"\ndirection = {}\nmoment = {}", direction, size);
}

std::vector<std::string> codes_told(const nlohmann::json& summary) {
    std::vector<std::string> codes;
    for (const nlohmann::json& warning : summary["warnings"]) codes.push_back(warning["code"]);
    return codes;
}

Ended factors_of(const std::string& text) {
    const TemporaryFolder folder;
    write_text(folder / "m.toml", text);
    return run_dttmm(folder.path(), {"static", "m.toml", "--buckling", "2"});
}

// Oracle: Beck's column has no load at which it buckles, and flutters at 20.05 EI/L² (Beck 1952, ZAMP 3, 225-228). The
// symmetric part alone is singular at π² EI/L²: 1000 N would "buckle" at 3.948 and 7.896.
TEST(Nonconservative, BecksColumnHasNoCriticalLoadFactor) {
    const Ended ended = factors_of(pressed_column(kTipBody, pressure(1000, "body")));
    EXPECT_EQ(ended.code, 3) << ended.out;
    EXPECT_THAT(ended.err, HasSubstr("m.toml:20:1: this load turns with its part of the machine and has no potential"));
    EXPECT_THAT(ended.err, HasSubstr("dttmm run"));
}

// Oracle: the same; 5000 N are beyond the first factor and below flutter, where a run stays bounded.
TEST(Nonconservative, BecksColumnIsNotCalledUnstable) {
    const TemporaryFolder folder;
    write_text(folder / "m.toml", pressed_column(kTipBody, pressure(5000, "body")));
    const Ended rest = run_dttmm(folder.path(), {"static", "m.toml", "-o", "s"});
    const nlohmann::json summary = read_json(folder / "s/summary.json");
    EXPECT_THAT(codes_told(summary), Not(Contains("unstable-equilibrium")));
    EXPECT_THAT(codes_told(summary), Contains("follower-load"));
    EXPECT_THAT(codes_told(summary), Contains("stability-undecided"));
    EXPECT_TRUE(summary["growing_motions"].is_null());
    EXPECT_EQ(summary["growing_motions_of_symmetric_part"], 1);
    EXPECT_EQ(summary["loads_without_potential"].size(), 1u);
    EXPECT_THAT(rest.out, HasSubstr("stability not decided"));
    EXPECT_THAT(rest.out, Not(HasSubstr("unstable")));

    const Ended modes = run_dttmm(folder.path(), {"modes", "m.toml", "--damped", "-o", "d"});
    EXPECT_EQ(modes.code, 0) << modes.err;
    const nlohmann::json found = read_json(folder / "d/summary.json");
    EXPECT_LT(found["frequencies_hz"][0], 0);
    EXPECT_EQ(found["loads_without_potential"].size(), 1u);
    EXPECT_THAT(codes_told(found), Contains("stability-undecided"));
    EXPECT_THAT(codes_told(found), Not(Contains("damped-mode-grows")));
    EXPECT_THAT(modes.err, Not(HasSubstr("the machine is not stable")));
    EXPECT_THAT(run_dttmm(folder.path(), {"check", "m.toml"}).out, HasSubstr("it is not decided whether"));
}

// Oracle: Leipholz' column, a load along its axis that turns with it, flutters at 40.05 EI/L³; the symmetric part is
// singular beyond that.
TEST(Nonconservative, LeipholzColumnHasNoCriticalLoadFactor) {
    const Ended ended = factors_of(pressed_column(
        kTipNode, "element = \"column\"\ndirection = [-1, 0, 0]\nforce_per_length = 1000\naxes = \"element\""));
    EXPECT_EQ(ended.code, 3) << ended.out;
    EXPECT_THAT(ended.err, HasSubstr("turns with its part of the machine and has no potential"));
}

// Oracle: a moment of fixed direction has a potential only where its point turns about that axis alone (Ziegler 1968).
TEST(Nonconservative, AMomentOfFixedDirectionIsRefusedWhereItsPointTurnsAboutOtherAxes) {
    const std::string twisted = pressed_column(kTipNode, end_moment("[1, 0, 0]", 100));
    EXPECT_EQ(factors_of(twisted).code, 3);
    const nlohmann::json summary = rest_of(twisted).summary;
    EXPECT_THAT(codes_told(summary), Contains("moment-load"));
    EXPECT_TRUE(summary["growing_motions"].is_null());
    EXPECT_EQ(summary["growing_motions_of_symmetric_part"], 0);
}

// Oracle: Euler's load of a column that is clamped at its root, in the plane in which its tip moves. The small moment about
// the only axis about which the tip turns changes nothing of it.
TEST(Nonconservative, LoadsWithAPotentialKeepTheirCriticalLoadFactors) {
    const double euler = M_PI * M_PI * kSoftPlane / (4 * kTall * kTall);
    const std::string dead = pressed_column(kTipInPlane, pressure(100, "world"));
    for (const std::string& text : {dead, dead + "[[load]]\n" + end_moment("[0, 0, 1]", 1e-3)}) {
        const nlohmann::json summary = rest_of(text, {"--buckling", "1"}).summary;
        EXPECT_NEAR(summary["critical_load_factors"][0], euler / 100, 1e-5 * euler / 100);  // 1e-6 shorter
        EXPECT_EQ(summary["growing_motions"], 0);
        EXPECT_FALSE(summary.contains("loads_without_potential"));
        for (const char* code : {"follower-load", "moment-load", "stability-undecided"})
            EXPECT_THAT(codes_told(summary), Not(Contains(code)));
    }
    const nlohmann::json beyond = rest_of(pressed_column(kTipInPlane, pressure(1.1 * euler, "world"))).summary;
    EXPECT_EQ(beyond["growing_motions"], 1);
    EXPECT_THAT(codes_told(beyond), Contains("unstable-equilibrium"));
}

/// Bars on parallel hinges, each against the one before it, the first against the ground.
std::string hinged_bars(int count, const std::string& load) {
    std::string text = "format = \"dttmm/1\"\n";
    for (int i = 0; i < count; ++i) {
        const std::string before = i == 0 ? "ground" : fmt::format("bar{}.end", i - 1);
        text += fmt::format(R"([[body]]
name = "bar{0}"
mass = 1.3
inertia = [0.1, 0.12, 0.14]
position = [{1}, 0.7, 1]
markers = {{ start = [-0.5, 0, 0], end = [0.5, 0, 0] }}
[[joint]]
name = "hinge{0}"
type = "hinge"
between = ["{2}", "bar{0}.start"]
axis = [0, 1, 0]
[[element]]
name = "spring{0}"
type = "spring_damper"
from = "{2}"
to = "bar{0}.start"
rotational_stiffness = [0, {3}, 0]
)",
                            i, i + 0.5, before, 100 + 50 * i);
    }
    return text + fmt::format("[[load]]\non = \"bar{}.end\"\n{}\n", count - 1, load);
}

// Oracle: an antisymmetric form is zero on one motion. On two, Ziegler's double pendulum flutters (Ziegler 1952, Ing.-Arch.
// 20, 49-56). All bars turn about one axis: a moment has a potential, and so has a force along that axis.
TEST(Nonconservative, WhatJointsLeaveFreeDecides) {
    const std::string follows = "direction = [-1, 0, 0]\nforce = 9\naxes = \"body\"";
    struct Case {
        int bars;
        std::string load;
        int code;
    };
    for (const auto& [count, load, code] :
         {Case{1, follows, 0}, Case{2, follows, 3}, Case{2, "direction = [0, 1, 0]\nmoment = 3", 0},
          Case{2, "direction = [0, 1, 0]\nmoment = 3\naxes = \"body\"", 0}, Case{3, "direction = [0, 1, 1]\nmoment = 3", 0},
          Case{3, "direction = [0, 1, 0]\nforce = 9\naxes = \"body\"", 0}}) {
        const Ended ended = factors_of(hinged_bars(count, load));
        EXPECT_EQ(ended.code, code) << count << " " << load << "\n" << ended.err;
    }
}

// Oracle: a body on a slider moves without turning; without the slider it turns too.
TEST(Nonconservative, AForceAlongAGuideHasAPotential) {
    const auto cart = [](const char* joint) {
        return fmt::format(R"(format = "dttmm/1"
[[body]]
name = "cart"
mass = 1.7
inertia = [0.1, 0.2, 0.3]
position = [0.3, -0.2, 1]
[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "cart"
stiffness = [900, 700, 800]
rotational_stiffness = [40, 50, 60]
{}
[[load]]
on = "cart"
direction = [1, 0.2, 0]
force = 9
axes = "body"
)",
                           joint);
    };
    EXPECT_EQ(factors_of(cart("[[joint]]\nname = \"guide\"\ntype = \"slider\"\nbetween = [\"ground\", \"cart\"]\naxis = "
                              "[1, 0, 0]"))
                  .code,
              0);
    EXPECT_EQ(factors_of(cart("")).code, 3);
}

}  // namespace
}  // namespace dttmm::host
