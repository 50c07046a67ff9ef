// SPDX-License-Identifier: BSD-3-Clause
//
// Load cases: what `dttmm static` finds of each, and --case for the other commands.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <sstream>

#include "cli/modes_run.h"
#include "cli/process.h"
#include "cli/static_run.h"

namespace dttmm::host {
namespace {

using Eigen::Vector3d;
using testing::HasSubstr;

/// Rows of a CSV file by the names of its columns, without the units.
std::vector<std::map<std::string, std::string>> rows_of(const fs::path& file) {
    std::istringstream lines(read_text(file));
    std::string names, line;
    std::getline(lines, names);
    std::getline(lines, line);
    std::vector<std::map<std::string, std::string>> rows;
    while (std::getline(lines, line)) {
        std::istringstream all_names(names), fields(line);
        std::map<std::string, std::string>& row = rows.emplace_back();
        for (std::string name, field; std::getline(all_names, name, ',');) {
            std::getline(fields, field, ',');
            row[name] = fields ? field : "";
        }
    }
    return rows;
}

struct Cases {
    std::map<std::string, std::map<std::string, std::string>> rows;  ///< by the name of the case
    std::vector<std::map<std::string, std::string>> members;
    nlohmann::json summary;
    std::string out, err;
    double at(const std::string& name, const std::string& channel) const { return std::stod(rows.at(name).at(channel)); }
    Vector3d vector(const std::string& name, const std::string& v) const {
        return {at(name, v + ".x"), at(name, v + ".y"), at(name, v + ".z")};
    }
    double member(const std::string& name, const std::string& element, double position, const std::string& what) const {
        for (const auto& row : members)
            if ((name.empty() || row.at("case") == name) && row.at("element") == element &&
                std::abs(std::stod(row.at("position")) - position) < 1e-9)
                return std::stod(row.at(what));
        ADD_FAILURE() << name << " " << element << " " << position;
        return NAN;
    }
};

Cases cases_of(const std::string& text, std::vector<std::string> words = {}) {
    const TemporaryFolder folder;
    write_text(folder / "m.toml", text);
    words.insert(words.begin(), {"static", "m.toml", "-o", "out"});
    const Ended ended = run_dttmm(folder.path(), words);
    EXPECT_EQ(ended.code, 0) << ended.err;
    Cases cases;
    if (ended.code != 0) return cases;
    for (auto& row : rows_of(folder / "out/static.csv"))
        cases.rows[row.contains("case") ? row["case"] : std::string()] = row;
    cases.members = rows_of(folder / "out/members.csv");
    cases.summary = read_json(folder / "out/summary.json");
    cases.out = ended.out;
    cases.err = ended.err;
    return cases;
}

constexpr double kHeight = 3.1, kSpan = 4.7, kEIc = 2e6, kEIb = 3.4e6;

/// Axes of a plane frame whose plane is no plane of the world: x along the girder, z up the columns.
const Eigen::Matrix3d kPlane = Eigen::AngleAxisd(0.83, Vector3d(1, -2, 0.7).normalized()).toRotationMatrix();

std::string place_of(double x, double z) {
    const Vector3d p = kPlane * Vector3d(x, 0, z);
    return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", p.x(), p.y(), p.z());
}
std::string direction_of(double x, double z) { return place_of(x, z); }

std::string bar(const char* name, const char* from, const char* to, double EI) {
    const Vector3d y = kPlane.col(1);
    return fmt::format(R"([[element]]
name = "{}"
type = "beam"
from = "{}"
to = "{}"
segments = 12
up = [{:.17g}, {:.17g}, {:.17g}]
theory = "euler-bernoulli"
section = {{ EA = 1e12, EIy = 7e6, EIz = {}, GJ = 1e6, mass = 50, inertia = 1 }}
)",
                       name, from, to, y.x(), y.y(), y.z(), EI);
}

/// A portal frame with clamped feet in its own plane, in which it bends about local z. EA is large, as closed forms have no
/// stretch: 1.5e-6 of it is left, and the rounding of places.
std::string portal() {
    return fmt::format(R"(format = "dttmm/1"
[nodes]
foot1 = {{ position = {}, fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
top1 = {}
top2 = {}
foot2 = {{ position = {}, fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
{}{}{}
[[load]]
name = "wind"
on = "top1"
direction = {}
force = "30 N"
[[load]]
name = "snow"
element = "girder"
direction = {}
force_per_length = "17 N/m"
[[load]]
name = "crane"
on = "top2"
direction = {}
force = "9 N"
[[case]]
name = "sway"
loads = ["wind"]
[[case]]
name = "snow"
factors = {{ snow = 2 }}
[[case]]
name = "uls"
factors = {{ crane = 1.4 }}
cases = {{ sway = 1.5, snow = -0.75 }}
)",
                       place_of(0, 0), place_of(0, kHeight), place_of(kSpan, kHeight), place_of(kSpan, 0),
                       bar("left", "foot1", "top1", kEIc), bar("girder", "top1", "top2", kEIb),
                       bar("right", "foot2", "top2", kEIc), direction_of(1, 0), direction_of(0, -1), direction_of(0, -1));
}

// Oracle: the clamped portal frame, Kleinlogel: k = (EI_b/EI_c)(h/l). A load w along the girder: w l²/(6 (k + 2)) at the
// knees, half of it at the feet; a force P at a knee: P h (3k + 1)/(2 (6k + 1)) at the feet, P h 3k/(2 (6k + 1)) at the
// knees.
TEST(LoadCases, APortalFrame) {
    const Cases cases = cases_of(portal());
    ASSERT_EQ(cases.rows.size(), 3u);
    const double k = kEIb / kEIc * kHeight / kSpan, w = 34, P = 30;
    const double knee_snow = w * kSpan * kSpan / (6 * (k + 2)), middle = w * kSpan * kSpan / 8 - knee_snow;
    const double foot_sway = P * kHeight * (3 * k + 1) / (2 * (6 * k + 1)),
                 knee_sway = P * kHeight * 3 * k / (2 * (6 * k + 1));
    const auto size = [&](const char* load_case, const char* element, double position) {
        return std::abs(cases.member(load_case, element, position, "Mz"));
    };
    // The girder's load is that of 12 lumps: second order in their length
    EXPECT_NEAR(size("snow", "left", kHeight), knee_snow, 5e-3 * knee_snow);
    EXPECT_NEAR(size("snow", "left", 0), 0.5 * knee_snow, 5e-3 * knee_snow);
    EXPECT_NEAR(size("snow", "girder", kSpan / 2), middle, 5e-3 * middle);
    EXPECT_NEAR(size("sway", "left", 0), foot_sway, 1e-5 * foot_sway);
    EXPECT_NEAR(size("sway", "right", 0), foot_sway, 1e-5 * foot_sway);
    EXPECT_NEAR(size("sway", "girder", 0), knee_sway, 1e-5 * foot_sway);
    EXPECT_NEAR(size("sway", "girder", kSpan / 2), 0, 1e-5 * foot_sway);
    // What the supports do is against the loads
    const Vector3d up = kPlane.col(2), along = kPlane.col(0);
    EXPECT_NEAR(cases.vector("snow", "foot1.reaction").dot(up), w * kSpan / 2, 1e-5 * w * kSpan);
    EXPECT_LT((cases.vector("sway", "foot1.reaction") + cases.vector("sway", "foot2.reaction") + P * along).norm(),
              1e-4 * P);
    EXPECT_NEAR(cases.vector("sway", "foot1.reaction_moment").norm(), foot_sway, 1e-5 * foot_sway);
    EXPECT_THAT(cases.out, HasSubstr("case \"sway\""));
    EXPECT_EQ(cases.summary["cases"].size(), 3u);
    EXPECT_EQ(cases.summary["cases"]["snow"]["load_steps"], 1);
}

// Oracle: a bar in torsion, M = GJ θ/L with GJ = 0.7 N m² and L = 1.4 m; θ is 160° by the factor of the case, beyond full
// turns.
TEST(LoadCases, FactorsOfImposedTwistsCountFullTurns) {
    const std::map<std::string, double> factors = {{"back", -2.5}, {"near", 0.3}, {"turns", 5}};
    std::string text = R"(format = "dttmm/1"
[nodes]
a = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
b = { position = [1.4, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"], motion = { rx = "160 deg" } }
[[element]]
name = "bar"
type = "beam"
from = "a"
to = "b"
segments = 30
theory = "euler-bernoulli"
section = { EA = 1e6, EIy = 2, EIz = 2, GJ = 0.7, mass = 0.1, inertia = 1e-3 }
)";
    for (const auto& [name, factor] : factors)
        text += fmt::format("[[case]]\nname = \"{}\"\nfactors = {{ b = {} }}\n", name, factor);
    const Cases cases = cases_of(text);
    for (const auto& [name, factor] : factors)
        EXPECT_NEAR(cases.at(name, "bar.moment.x"), 0.5 * factor * 160 * M_PI / 180, 1e-8) << name;
}

// Oracle: superposition, of forces small beside what would buckle the frame.
TEST(LoadCases, CombinationsSuperpose) {
    const Cases cases = cases_of(portal());
    Cases crane = cases_of(portal() + "[[case]]\nname = \"crane\"\nloads = [\"crane\"]\n", {"--case", "crane"});
    ASSERT_EQ(crane.rows.size(), 1u);
    for (const char* v : {"foot1.reaction", "foot2.reaction_moment", "girder.moment", "top2.rotation"}) {
        const Vector3d sum = 1.5 * cases.vector("sway", v) - 0.75 * cases.vector("snow", v) + 1.4 * crane.vector("crane", v);
        EXPECT_LT((cases.vector("uls", v) - sum).norm(), 1e-4 * sum.norm()) << v;
    }
}

/// A mass on a spring that weighs, and loads that pull it.
std::string hanging(const std::string& cases) {
    return R"(format = "dttmm/1"
[simulation]
duration = "20 ms"
step = "10 ms"
gravity = [0, 0, -10]
[[body]]
name = "mass"
mass = 3
inertia = [1, 1, 1]
[nodes]
top = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"], motion = { z = { type = "step", to = 0.25, end = "10 ms" } } }
[[element]]
name = "spring"
type = "spring_damper"
from = "top"
to = "mass"
stiffness = 100
rotational_stiffness = 1
[[load]]
name = "pull"
on = "mass"
direction = [0, 0, 1]
force = 7
[[load]]
name = "pull"
on = "mass"
direction = [0, 1, 0]
force = 2
)" + cases;
}

// Oracle: the force of the spring is what it carries: factor times 3 kg times 10 m/s², and the pulls of one name together.
TEST(LoadCases, GravityAndMotionHaveFactors) {
    const Cases cases = cases_of(hanging("[[case]]\nname = \"dead\"\ngravity = 1\n"
                                         "[[case]]\nname = \"live\"\ngravity = 0\nloads = [\"pull\"]\n"
                                         "[[case]]\nname = \"up\"\ngravity = 0\nfactors = { top = -2 }\n"
                                         "[[case]]\nname = \"both\"\ncases = { dead = 1.35, live = 1.5 }\n"
                                         "[[case]]\nname = \"default\"\nfactors = { pull = 1 }\n"),
                                 {"--at", "20 ms"});
    ASSERT_EQ(cases.rows.size(), 5u);
    EXPECT_NEAR(cases.at("dead", "spring.force.z"), -30, 1e-9);
    EXPECT_NEAR(cases.at("live", "spring.force.z"), 7, 1e-9);
    EXPECT_NEAR(cases.at("live", "spring.force.y"), 2, 1e-9) << "a name may be that of several loads";
    EXPECT_NEAR(cases.at("up", "mass.position.z"), -0.5, 1e-12);
    EXPECT_NEAR(cases.at("up", "spring.force.z"), 0, 1e-9);
    EXPECT_NEAR(cases.at("both", "spring.force.z"), -1.35 * 30 + 1.5 * 7, 1e-9);
    EXPECT_NEAR(cases.at("default", "spring.force.z"), -30 + 7, 1e-9);
    EXPECT_NEAR(cases.at("dead", "top.reaction.z"), 30, 1e-9);
}

// Oracle: the first acceleration of a mass under the loads of the case; a run without a case has all.
TEST(LoadCases, RunsTakeOne) {
    const TemporaryFolder folder;
    write_text(folder / "m.toml", hanging("[[case]]\nname = \"live\"\ngravity = 0.5\nfactors = { pull = 3 }\n"));
    const auto first = [&](std::vector<std::string> words) {
        words.insert(words.begin(), {"run", "m.toml", "-o", "out", "-q"});
        const Ended ended = run_dttmm(folder.path(), words);
        EXPECT_EQ(ended.code, 0) << ended.err;
        return std::stod(rows_of(folder / "out/history.csv").at(0).at("mass.acceleration.z"));
    };
    EXPECT_NEAR(first({"--case", "live"}), -5 + 7.0, 1e-12);
    EXPECT_NEAR(first({}), -10 + 7.0 / 3, 1e-12);
    const Ended wrong = run_dttmm(folder.path(), {"run", "m.toml", "--case", "lives"});
    EXPECT_EQ(wrong.code, 2);
    EXPECT_THAT(wrong.err, HasSubstr("--case \"lives\": there is no case \"lives\"; did you mean \"live\"?"));
    const Ended modes = run_dttmm(folder.path(), {"modes", "m.toml", "--case", "live", "-o", "modes"});
    EXPECT_EQ(modes.code, 0) << modes.err;
}

TEST(LoadCases, ACaseWithoutEquilibriumIsNamed) {
    const TemporaryFolder folder;
    std::string text = hanging("[[case]]\nname = \"dead\"\ngravity = 1\n");
    text.replace(text.find("stiffness = 100"), 15, "damping = 100");
    write_text(folder / "m.toml", text);
    const Ended ended = run_dttmm(folder.path(), {"static", "m.toml"});
    EXPECT_EQ(ended.code, 4);
    EXPECT_THAT(ended.err, HasSubstr("case \"dead\": "));
}

// Oracle: the sag of the case that has an equilibrium; a mass that hangs on a damper alone has none under gravity.
TEST(LoadCases, ACaseWithoutEquilibriumLeavesTheOthers) {
    const TemporaryFolder folder;
    std::string text = hanging("[[case]]\nname = \"dead\"\ngravity = 1\n[[case]]\nname = \"none\"\ngravity = 0\n");
    text.replace(text.find("stiffness = 100"), 15, "damping = 100");
    write_text(folder / "m.toml", text);
    const Ended ended = run_dttmm(folder.path(), {"static", "m.toml", "-o", "out"});
    EXPECT_EQ(ended.code, 9) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("case \"dead\": "));
    EXPECT_THAT(ended.err, HasSubstr("1 of 2 cases failed; the results of the others are kept"));
    const nlohmann::json summary = read_json(folder / "out/summary.json");
    EXPECT_EQ(summary["status"], "cases_failed");
    EXPECT_EQ(summary["cases"]["dead"]["status"], "failed");
    const auto rows = rows_of(folder / "out/static.csv");
    ASSERT_EQ(rows.size(), 1u);
    EXPECT_EQ(rows[0].at("case"), "none");
}

// ---- Members ------------------------------------------------------------------------------------------------------------

std::string beam_under_load(const std::string& ends, const std::string& section) {
    return fmt::format(R"(format = "dttmm/1"
[nodes]
{}
[[element]]
name = "beam"
type = "beam"
from = "a"
to = "b"
segments = 6
up = [0, 0, 1]
{}
[[load]]
element = "beam"
direction = [0, 0, -1]
force_per_length = 5
)",
                       ends, section);
}

constexpr const char* kRectangle =
    "section = { rectangle = [\"40 mm\", \"60 mm\"] }\nmaterial = { E = 2.1e11, poisson = 0.3, density = 7850 }";

// Oracle: a cantilever under q: V = q (L − x), M = q (L − x)²/2, sigma = M/(b h²/6); the sign: on the face that looks along
// x the outer part pulls down, and turns about +y.
TEST(Members, ACantilever) {
    const Cases cases = cases_of(beam_under_load(
        "a = { position = [0, 0, 0], fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"] }\nb = [1.2, 0, 0]", kRectangle));
    ASSERT_EQ(cases.members.size(), 7u);
    for (int k = 0; k <= 6; ++k) {
        const double x = 0.2 * k, rest = 1.2 - x, M = 2.5 * rest * rest;
        EXPECT_NEAR(cases.member("", "beam", x, "Vz"), -5 * rest, 1e-6) << k;
        EXPECT_NEAR(cases.member("", "beam", x, "My"), M, 1e-6) << k;
        EXPECT_NEAR(std::abs(cases.member("", "beam", x, "stress")), M / (0.04 * 0.06 * 0.06 / 6), 1) << k;
        EXPECT_NEAR(cases.member("", "beam", x, "N"), 0, 1e-4) << k;
        EXPECT_NEAR(cases.member("", "beam", x, "T"), 0, 1e-9) << k;
    }
    EXPECT_NEAR(cases.at("", "a.reaction.z"), 6, 1e-9);
    EXPECT_NEAR(cases.at("", "a.reaction_moment.y"), -3.6, 1e-6);
}

// Oracle: a beam on two supports: M = −q x (L − x)/2 about y; a tube has pi/32 (D⁴ − d⁴)/D.
TEST(Members, ABeamOnTwoSupports) {
    const Cases cases = cases_of(beam_under_load(
        "a = { position = [0, 0, 0], fixed = [\"x\", \"y\", \"z\", \"rx\"] }\nb = { position = [1.2, 0, 0], fixed = [\"y\", "
        "\"z\"] }",
        "section = { tube = [\"50 mm\", \"30 mm\"] }\nmaterial = { E = 2.1e11, poisson = 0.3, density = 7850 }"));
    const double W = M_PI / 32 * (std::pow(0.05, 4) - std::pow(0.03, 4)) / 0.05;
    for (int k = 0; k <= 6; ++k) {
        const double x = 0.2 * k, M = -2.5 * x * (1.2 - x);
        EXPECT_NEAR(cases.member("", "beam", x, "My"), M, 1e-6) << k;
        EXPECT_NEAR(std::abs(cases.member("", "beam", x, "stress")), -M / W, 10) << k;
    }
    EXPECT_NEAR(cases.at("", "a.reaction.z"), 3, 1e-9);
    EXPECT_NEAR(cases.at("", "b.reaction.z"), 3, 1e-9);
}

/// A light cantilever in a plane that is no plane of the world, from `a` to `b`, under a force along it and one across at b.
/// EI = 1.7 N m², 0.5 m.
std::string pulled_cantilever(const char* from, const char* to, int segments, double along, double across) {
    const Vector3d up = kPlane.col(2);
    return fmt::format(R"(format = "dttmm/1"
[nodes]
a = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
b = {}
[[element]]
name = "beam"
type = "beam"
from = "{}"
to = "{}"
segments = {}
up = [{:.17g}, {:.17g}, {:.17g}]
theory = "euler-bernoulli"
section = {{ EA = 1e7, EIy = 1.7, EIz = 2.9, GJ = 1.1, mass = 1e-3, inertia = 1e-8 }}
[[load]]
on = "b"
direction = {}
force = {}
[[load]]
on = "b"
direction = {}
force = {}
)",
                       place_of(0.5, 0), from, to, segments, up.x(), up.y(), up.z(), direction_of(1, 0), along,
                       direction_of(0, 1), across);
}

/// Largest error of bending moment and shear force over the sections, against their largest values.
Eigen::Vector2d errors_of_pulled_cantilever(bool from_tip, int segments) {
    constexpr double P = 100, Q = 1, L = 0.5;
    const double k = std::sqrt(P / 1.7);
    const Cases cases = cases_of(pulled_cantilever(from_tip ? "b" : "a", from_tip ? "a" : "b", segments, P, Q));
    Eigen::Vector2d worst(0, 0);
    for (const auto& row : cases.members) {
        const double s = std::stod(row.at("position")), rest = from_tip ? s : L - s;
        const double M = -Q / k * std::sinh(k * rest) / std::cosh(k * L), V = Q * std::cosh(k * rest) / std::cosh(k * L);
        worst.x() = std::max(worst.x(), std::abs(std::stod(row.at("My")) - M) * k);
        worst.y() = std::max(worst.y(), std::abs(std::stod(row.at("Vz")) - (from_tip ? -V : V)));
    }
    return worst;
}

// Oracle: P w'' - EI w'''' = 0 of a cantilever under tension.
TEST(Members, OfAPulledCantileverAreOfSecondOrderFromBothEnds) {
    for (const bool from_tip : {false, true}) {
        const Eigen::Vector2d coarse = errors_of_pulled_cantilever(from_tip, 20),
                              fine = errors_of_pulled_cantilever(from_tip, 40);
        for (int i : {0, 1}) {
            EXPECT_LT(fine(i), 0.0012) << from_tip << i;
            EXPECT_GT(coarse(i), 3.5 * fine(i)) << from_tip << i;
        }
    }
}

// Oracle: the balance of what lies between a section and an end: one force all along, no moment at the free end, and at the
// support that of the reaction.
TEST(Members, OfAFarBentCantileverAreInBalance) {
    for (const bool from_tip : {false, true}) {
        const Cases cases = cases_of(pulled_cantilever(from_tip ? "b" : "a", from_tip ? "a" : "b", 7, -3, 11));
        ASSERT_EQ(cases.members.size(), 8u);
        const Vector3d reaction = kPlane.transpose() * cases.vector("", "a.reaction_moment");
        EXPECT_GT(std::abs(reaction.y()), 3.5);
        for (const auto& row : cases.members) {
            const double s = std::stod(row.at("position")), rest = from_tip ? s : 0.5 - s;
            const auto value = [&](const char* name) { return std::stod(row.at(name)); };
            EXPECT_NEAR(std::hypot(value("N"), value("Vy"), value("Vz")), std::sqrt(130.0), 1e-8) << s;
            if (rest == 0) {
                EXPECT_NEAR(value("My"), 0, 1e-9) << from_tip;
            }
            if (rest == 0.5) {
                EXPECT_NEAR(value("My"), -reaction.y(), 1e-9) << from_tip;
                EXPECT_NEAR(value("N"), -3, 1e-9) << from_tip;
            }
        }
    }
}

TEST(Members, StiffnessesTellNoStress) {
    const Cases cases = cases_of(beam_under_load(
        "a = { position = [0, 0, 0], fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"] }\nb = [1.2, 0, 0]",
        "section = { EA = 1e8, EIy = 1e4, EIz = 2e4, GJ = 1e4, GAy = 1e8, GAz = 1e8, mass = 3 }"));
    ASSERT_EQ(cases.members.size(), 7u);
    for (const auto& row : cases.members) EXPECT_EQ(row.at("stress"), "");
    EXPECT_THAT(cases.err, HasSubstr("no outermost fibre"));
}

}  // namespace
}  // namespace dttmm::host
