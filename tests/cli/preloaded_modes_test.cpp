// SPDX-License-Identifier: BSD-3-Clause
//
// Vibrations about equilibrium against tables of machines whose truth is known in closed form, and small runs of the same
// machines.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <string>
#include <vector>

#include "cli/modes_run.h"
#include "cli/pendulum.h"
#include "cli/static_run.h"
#include "support/linear_algebra.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

// Oracle: a frequency goes through zero at Euler's load, pi^2 EI/(4 L l), l the pressed length. Within 1e-8 of it rounding
// hides that frequency, 1e-6 beside nothing: it is listed with 0 Hz, and how fast it may be is said.
TEST(PreloadedModes, AColumnNextToItsCriticalLoadIsListedWithZeroAndABound) {
    static constexpr double kEI = 300, kEA = 4e6, kLength = 1.968501968503937;
    const auto modes = [](double load, const char* below) {
        const TemporaryFolder folder;
        write_text(folder / "m.toml", fmt::format(R"(format = "dttmm/1"
[nodes]
a = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
b = [{}, 0, 0]
[[element]]
name = "e"
type = "beam"
from = "a"
to = "b"
segments = 10
theory = "euler-bernoulli"
section = {{ EA = {}, EIy = 800, EIz = {}, GJ = 200, mass = 2, inertia = 0.003 }}
[[load]]
on = "b"
direction = [-1, 0, 0]
force = {}
)",
                                                  kLength, kEA, kEI, load));
        return run_dttmm(folder.path(), {"modes", "m.toml", "--below", below});
    };
    double euler = M_PI * M_PI * kEI / (4 * kLength * kLength);
    for (int i = 0; i < 3; ++i) euler = M_PI * M_PI * kEI / (4 * kLength * kLength * (1 - euler / kEA));
    int hidden = 0;
    for (const double beside : {-1e-8, -3e-9, 0.0, 3e-9, 1e-8, 2e-8})
        for (const char* below : {"3 Hz", "100 Hz", "1000 Hz"}) {
            const Ended ended = modes(euler * (1 + beside), below);
            EXPECT_EQ(ended.code, 0) << ended.err;
            const size_t at = ended.err.find("at up to ");
            if (at == std::string::npos) continue;
            ++hidden;
            EXPECT_THAT(ended.out, HasSubstr("counted and complete")) << below;
            EXPECT_THAT(ended.out, HasSubstr(", but for what 0 Hz stands for; results in")) << below;
            const double bound = std::stod(ended.err.substr(at + 9));
            // The first frequency of the bar without its load, as slow as the distance from Euler's load makes it
            const double first = 1.8751 * 1.8751 / (2 * M_PI * kLength * kLength) * std::sqrt(kEI / 2);
            EXPECT_GT(bound, 0.9 * first * std::sqrt(std::abs(beside))) << beside << below;
            EXPECT_LT(bound, 1e-3 * first) << beside << below;
        }
    EXPECT_GT(hidden, 3);
    for (const double beside : {-1e-6, 1e-6}) EXPECT_EQ(modes(euler * (1 + beside), "100 Hz").code, 0);
}

// Oracle: N (1 + N/GA) = pi^2 EI/(4 L^2) (Haringx). The message said that the tip has no mass and nothing holds it.
TEST(PreloadedModes, AColumnThatIsSoftInShearHasItsCriticalLoad) {
    for (const double shear : {40.0, 400.0}) {
        const TemporaryFolder folder;
        write_text(folder / "m.toml", fmt::format(R"(format = "dttmm/1"
[nodes]
a = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
t = [0, 0, 1]
[[element]]
name = "e"
type = "beam"
from = "a"
to = "t"
segments = 20
section = {{ EA = 1e9, EIy = 50, EIz = 50, GJ = 20, GAy = {0}, GAz = {0}, mass = 1, inertia = 1e-4 }}
[[load]]
on = "t"
direction = [0, 0, -1]
force = 10
)",
                                                  shear));
        const Ended ended = run_dttmm(folder.path(), {"static", "m.toml", "--buckling", "1", "-o", "out", "-q"});
        ASSERT_EQ(ended.code, 0) << ended.err;
        const double euler = M_PI * M_PI * 50 / 4, critical = 0.5 * shear * (std::sqrt(1 + 4 * euler / shear) - 1);
        const std::vector<double> factors = read_json(folder / "out/summary.json").at("critical_load_factors");
        ASSERT_EQ(factors.size(), 1u);
        EXPECT_NEAR(10 * factors[0], critical, 1e-5 * critical);
    }
}

// What springs against turning alone hold is judged by these springs, not by the rounding of forces at rest: the hub was
// said to have no mass.
TEST(PreloadedModes, AFreeHubWithASprungArmRestsAndItsFreeMotionIsNamed) {
    const AtRest rest = rest_of(R"(format = "dttmm/1"
[[body]]
name = "hub"
mass = 5
inertia = [1, 1, 1]
[[body]]
name = "arm"
mass = 1
inertia = [0.01, 0.01, 0.01]
position = [1, 0, 0]
[[joint]]
name = "h"
type = "hinge"
between = ["ground", "hub"]
axis = [0, 0, 1]
anchor = [0, 0, 0]
[[joint]]
name = "flap"
type = "hinge"
between = ["hub", "arm"]
axis = [0, 1, 0]
anchor = [0.1, 0, 0]
[[element]]
name = "s"
type = "spring_damper"
from = "hub"
to = "arm"
rotational_stiffness = [0, 100, 0]
)");
    EXPECT_THAT(rest.told, testing::HasSubstr("note: nothing holds 1 motion (arm: y 50 %)"));
    EXPECT_EQ(rest.summary.at("free_motions"), 1);
    EXPECT_EQ(rest.summary.at("growing_motions"), 0);
}

// Oracle: by hand, shares of k - m g l. At twice the weight's 1 N m the spring has 200 %; where both all but cancel its
// share says nothing; a pendulum without spring vibrates by its weight alone.
TEST(PreloadedModes, SharesAreNotPrintedWhereForcesCancelThem) {
    const auto printed = [](const std::string& stiffness, double up) {
        const std::string spring = stiffness.empty() ? ""
                                                     : fmt::format(R"([[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "bob.pin"
rotational_stiffness = [0, {}, 0]
)",
                                                                   stiffness);
        const TemporaryFolder folder;
        write_text(folder / "m.toml", fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = [0, 0, -10]
[[body]]
name = "bob"
mass = 0.2
inertia = [0.02, 0.03, 0.04]
position = [0, 0, {}]
markers = {{ pin = [0, 0, {}] }}
[[joint]]
name = "pin"
type = "hinge"
between = ["ground", "bob.pin"]
axis = [0, 1, 0]
{})",
                                                  up, -up, spring));
        const Ended ended = run_dttmm(folder.path(), {"modes", "m.toml"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        return ended.out;
    };
    EXPECT_THAT(printed("2", 0.5), testing::HasSubstr("spring 200 %"));
    const std::string cancelled = printed("1.00001", 0.5);
    EXPECT_THAT(cancelled, testing::HasSubstr("elements and forces at rest cancel"));
    EXPECT_THAT(cancelled, testing::Not(testing::HasSubstr("spring")));
    EXPECT_THAT(printed("", -0.5), testing::HasSubstr("forces at rest"));
    EXPECT_THAT(printed("", 0.5), testing::HasSubstr("forces at rest"));
}

/// A pendulum on a spring: k by m g l, its centre of mass above its pin or below. Its spring is at rest as it hangs or
/// stands.
struct Swinging {
    double ratio;
    bool hangs;
};
constexpr double kBob = 1.37, kArm = 0.83, kInertia = 0.031, kPull = 9.81;

std::string swinging(const Swinging& p, const std::string& simulation, double speed) {
    const double up = p.hangs ? -kArm : kArm;
    return fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = [0, 0, -9.81]
{}
[output]
channels = ["pin.angle"]
[[body]]
name = "bob"
mass = {}
inertia = [0.01, {}, 0.03]
position = [0.3, 0.2, {:.17g}]
velocity = [{:.17g}, 0, 0]
angular_velocity = [0, {:.17g}, 0]
[[joint]]
name = "pin"
type = "hinge"
between = ["ground", "bob"]
anchor = [0.3, 0.2, 0.7]
axis = [0, 1, 0]
[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "bob"
rotational_stiffness = [0, {:.17g}, 0]
)",
                       simulation, kBob, kInertia, 0.7 + up, speed * up, speed, p.ratio * kBob * kPull * kArm);
}

/// Natural frequency [Hz] behind a free vibration x of one mode: x(t + h) + x(t − h) = 2 c x(t) by least squares, with
/// c = cos ω_h h of the scheme, tan(ω_h h/2) = ωh/2. Negative: it grows, c = cosh.
double frequency_behind(const std::vector<double>& x, double h) {
    double over = 0, under = 0;
    for (size_t n = 1; n + 1 < x.size(); ++n) {
        over += (x[n + 1] + x[n - 1]) * x[n];
        under += 2 * x[n] * x[n];
    }
    const double c = over / under;
    return (c < 1 ? std::tan(0.5 * std::acos(c)) : -std::tanh(0.5 * std::acosh(c))) * 2 / h / (2 * M_PI);
}

std::vector<double> angle_of(const std::string& text) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", text);
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "-q"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    std::vector<double> x;
    for (const std::vector<double>& row : read_history(folder / "out/history.csv")) x.push_back(row[1]);
    return x;
}

// Oracle: ω² = (k ± m g l)/(J + m l²): the pendulums of physics2.md's table P5, standing and hanging, and a small run of
// each.
TEST(PreloadedModes, PendulumsOnSprings) {
    for (const Swinging& p :
         {Swinging{2, false}, {1.2, false}, {0.8, false}, {2, true}, {1.2, true}, {0.8, true}, {20, true}, {100, true}}) {
        const double square = (p.ratio + (p.hangs ? 1 : -1)) * kBob * kPull * kArm / (kInertia + kBob * kArm * kArm);
        const double exact = std::copysign(std::sqrt(std::abs(square)), square) / (2 * M_PI);
        const std::vector<double> found = frequencies_of(modes_of(swinging(p, "", 0)));
        ASSERT_EQ(found.size(), 1u);
        EXPECT_NEAR(found[0], exact, 1e-8 * std::abs(exact)) << p.ratio << p.hangs;
        // Forces of joints act along the directions at the start of a step: (ω_g h)²/8 of the frequency, ω_g that of gravity
        const auto rung = [&](double h) {
            const std::string simulation = fmt::format("duration = \"1 s\"\nstep = {}", h);
            return frequency_behind(angle_of(swinging(p, simulation, 1e-5 * std::sqrt(std::abs(square)))), h);
        };
        EXPECT_NEAR((4 * rung(1e-3) - rung(2e-3)) / 3, exact, 1e-6 * std::abs(exact)) << p.ratio << p.hangs;
    }
}

// Oracle: M a = -K x of two physical pendulums in a row, about where they hang: M = [I + m1 c^2 + m2 L^2, m2 L c; ., I + m2
// c^2], K = diag(m1 g c + m2 g L, m2 g c). Nothing is elastic: no equilibrium was found, and no mode.
TEST(PreloadedModes, RigidPartsInsideANetworkSwing) {
    constexpr double kLength = 0.7, kToCentre = 0.31, kOwn = 0.03, kMass[] = {1.9, 0.6}, kGravity = 9.81;
    Eigen::Matrix2d M, K;
    M << kOwn + kMass[0] * kToCentre * kToCentre + kMass[1] * kLength * kLength, kMass[1] * kLength * kToCentre,
        kMass[1] * kLength * kToCentre, kOwn + kMass[1] * kToCentre * kToCentre;
    K << kGravity * (kMass[0] * kToCentre + kMass[1] * kLength), 0, 0, kGravity * kMass[1] * kToCentre;
    const test::Pencil swings = test::solve_pencil(K, M);
    std::string model = R"toml(format = "dttmm/1"
[simulation]
gravity = [0, 0, -9.81]
[nodes]
root = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
)toml";
    std::string elements;
    double x = 0, z = 0;
    const double angles[] = {0.9, -0.4};
    for (int i : {0, 1}) {
        const double s = std::sin(angles[i]), c = std::cos(angles[i]);
        model += fmt::format("a{0} = [{1}, 0, {2}]\nb{0} = [{3}, 0, {4}]\n", i, x, z, x + kLength * s, z - kLength * c);
        elements += fmt::format(R"toml([[element]]
name = "hinge{0}"
type = "elastic_hinge"
from = "{1}"
to = "a{0}"
stiffness = {{ ry = "free" }}
[[element]]
name = "part{0}"
type = "rigid_body"
at = ["a{0}", "b{0}"]
mass = {2}
center_of_mass = [{3}, 0, {4}]
inertia = {{ xx = 0.01, yy = {5}, zz = 0.02 }}
)toml",
                                i, i == 0 ? "root" : "b0", kMass[i], kToCentre * s, -kToCentre * c, kOwn);
        x += kLength * s;
        z -= kLength * c;
    }
    const Eigen::Vector2d exact = swings.values.cwiseSqrt() / (2 * M_PI);
    expect_frequencies(frequencies_of(modes_of(model + elements, {"--count", "2"})), {exact(0), exact(1)}, 1e-8);
}

// Oracle: the column of P5 between pins, ω = (π/L)² √(EI/µ) √(1 − s P L²/π²EI)/s, s = 1 − P/EA, pressed and pulled: the
// length at rest is s L; mass and stiffness of the section are those per length at the start.
TEST(PreloadedModes, ColumnsAndTies) {
    constexpr double kL = 1.2, kEI = 16.4, kMass = 0.7, kEA = 1e7;
    const double critical = M_PI * M_PI * kEI / (kL * kL);
    for (const double load : {0.25, 0.5, 0.9, -1.0, -4.0, -16.0}) {
        const double P = load * critical, s = 1 - P / kEA;
        const double exact = M_PI / 2 / (kL * kL * s) * std::sqrt(kEI / kMass * (1 - s * load));
        const std::vector<double> found = frequencies_of(modes_of(fmt::format(R"(format = "dttmm/1"
[nodes]
foot = {{ position = [0.1, 0.2, 0.3], fixed = ["x", "y", "z", "rz"] }}
head = {{ position = [0.1, 0.2, 1.5], fixed = ["x", "y"] }}
[[element]]
name = "column"
type = "beam"
from = "foot"
to = "head"
segments = 3
theory = "euler-bernoulli"
section = {{ EA = {}, EIy = {}, EIz = {}, GJ = 1e3, mass = {}, inertia = 1e-8 }}
[[load]]
on = "head"
direction = [0, 0, -1]
force = {:.17g}
)",
                                                                              kEA, kEI, 1.9 * kEI, kMass, P),
                                                                  {"--count", "1"}));
        ASSERT_EQ(found.size(), 1u);
        EXPECT_NEAR(found[0], exact, 1e-6 * exact) << load;
    }
}

// Oracle: where k x + k₃ x³ = T − s x the body rests, ω² = (k + 3 k₃ x² + s)/m. Nothing but the preload T of the stay pulls.
TEST(PreloadedModes, APreloadAloneMovesTheMachineToItsEquilibrium) {
    constexpr double kLinear = 1e4, kCubic = 1e9, kStay = 1000, kTension = 400, kMass = 3;
    double x = 0;
    for (int i = 0; i < 50; ++i)
        x -= (kLinear * x + kCubic * x * x * x - kTension + kStay * x) / (kLinear + 3 * kCubic * x * x + kStay);
    const double exact = std::sqrt((kLinear + 3 * kCubic * x * x + kStay) / kMass) / (2 * M_PI);
    const std::string model = fmt::format(R"(format = "dttmm/1"
[nodes]
wall = {{ position = [1, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
[[body]]
name = "a"
mass = {}
inertia = [0.02, 0.03, 0.025]
[[element]]
name = "s"
type = "spring_damper"
from = "ground"
to = "a"
rotational_stiffness = [9000, 8000, 7000]
stiffness = [0, 1e6, 2e6]
x = {{ law = "cubic", stiffness = {}, cubic = {} }}
[[element]]
name = "stay"
type = "axial_spring"
from = "wall"
to = "a"
stiffness = {}
preload = {}
)",
                                          kMass, kLinear, kCubic, kStay, kTension);
    for (const char* more : {"", "[modes]\nabout = \"equilibrium\"\n"})
        EXPECT_NEAR(frequencies_of(modes_of(model + more)).at(0), exact, 1e-9 * exact) << more;
    EXPECT_NEAR(frequencies_of(modes_of(model + "[modes]\nabout = \"start\"\n")).at(0),
                std::sqrt((kLinear + kStay) / kMass) / (2 * M_PI), 1e-9);
}

/// A cantilever along x or along y, with a load along it that has the direction of its axis.
std::string with_load_along(char axis, double load, const char* axes, const std::string& at_tip) {
    const std::string along = axis == 'x' ? "[1, 0, 0]" : "[0, 1, 0]", tip = axis == 'x' ? "[0.5, 0, 0]" : "[0, 0.5, 0]";
    return fmt::format(R"(format = "dttmm/1"
[nodes]
root = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
tip = {{ position = {} }}
[[element]]
name = "mast"
type = "beam"
from = "root"
to = "tip"
segments = 30
up = [0, 0.3, 1]
theory = "euler-bernoulli"
section = {{ EA = 3e7, EIy = 2.5, EIz = 5.6, GJ = 3, mass = 0.01, inertia = 4e-5 }}
[[load]]
element = "mast"
direction = {}
force_per_length = {:.17g}
axes = "{}"
{})",
                       tip, axes == std::string("world") ? along : "[1, 0, 0]", load, axes, at_tip);
}

// Oracle: a load q along a beam that turns with it does q v v' ds of work; its symmetric part is ½ q v² at the tip, that of
// a spring −q/2 there beside the load that keeps its direction. 8 % of the first frequency.
TEST(PreloadedModes, ALoadThatTurnsWithABeamIsASpringAtItsTip) {
    for (const char axis : {'x', 'y'})
        for (const double load : {-20.0, -7.0}) {
            const std::string spring = fmt::format(
                "[[element]]\nname = \"spring\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"tip\"\n"
                "stiffness = {}\n",
                axis == 'x' ? fmt::format("[0, {0}, {0}]", -load / 2) : fmt::format("[{0}, 0, {0}]", -load / 2));
            for (const auto& [beams, near] : {std::pair("exact", 5e-8), std::pair("lumped", 3e-5)}) {
                const TemporaryFolder folder;
                write_text(folder / "model.toml", with_load_along(axis, load, "element", ""));
                const Ended ended = run_dttmm(
                    folder.path(), {"modes", "model.toml", "--json", "-o", "out", "--count", "4", "--beams", beams});
                ASSERT_EQ(ended.code, 0) << ended.err;
                EXPECT_THAT(ended.err, HasSubstr("only the symmetric part"));
                const std::vector<double> turning = frequencies_of(nlohmann::json::parse(ended.out));
                const std::vector<double> still = frequencies_of(
                    modes_of(with_load_along(axis, load, "world", spring), {"--count", "4", "--beams", beams}));
                ASSERT_EQ(turning.size(), 4u);
                ASSERT_EQ(still.size(), 4u);
                for (size_t m = 0; m < 4; ++m)
                    EXPECT_NEAR(turning[m], still[m], near * still[m]) << axis << load << beams << m;
            }
        }
}

// Oracle: the lumps of a run, extrapolated. Across a guide that is oblique to it a bar acts by its tension and by its
// bending; as it sags these are coupled to first order: 1.4 % of the frequency for 0.04 radii of gyration.
TEST(PreloadedModes, ASaggingBarCouplesBendingAndTension) {
    const auto frequency = [](int segments, const char* beams) {
        return frequencies_of(modes_of(fmt::format(R"(format = "dttmm/1"
[nodes]
foot = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "rz"] }}
[[body]]
name = "b"
mass = 5
inertia = [0.01, 0.01, 0.01]
position = [1, 0, 0]
[[joint]]
name = "guide"
type = "slider"
between = ["b", "ground"]
axis = [0.017452406437283512, 0, 0.99984769515639127]
[[element]]
name = "bar"
type = "beam"
from = "foot"
to = "b"
segments = {}
section = {{ circle = "40 mm" }}
material = {{ E = "210 GPa", poisson = 0.3, density = "7850 kg/m^3" }}
[[load]]
element = "bar"
direction = [0, 0, -1]
force_per_length = 400
)",
                                                   segments),
                                       {"--count", "1", "--beams", beams}))
            .at(0);
    };
    const double lumped = (4 * frequency(64, "lumped") - frequency(32, "lumped")) / 3;
    EXPECT_NEAR(frequency(64, "exact"), lumped, 5e-6 * lumped);
    EXPECT_NEAR(frequency(10, "exact"), lumped, 2e-4 * lumped);
}

// Oracle: ω² = m g l/(J + m l²) of a bob that stands on a hinge: it grows faster than the slow mass beside it vibrates.
TEST(PreloadedModes, DampedModesReachToWhatGrows) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", R"(format = "dttmm/1"
[simulation]
gravity = [0, 0, -9.81]
[[body]]
name = "bob"
mass = 1
inertia = [0.01, 0.01, 0.01]
position = [0, 0, 0.5]
[[body]]
name = "slow"
mass = 2
inertia = [0.01, 0.01, 0.01]
position = [3, 0, 0]
[[joint]]
name = "pin"
type = "hinge"
between = ["ground", "bob"]
anchor = [0, 0, 0]
axis = [0, 1, 0]
[[joint]]
name = "rail"
type = "slider"
between = ["ground", "slow"]
axis = [1, 0, 0]
[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "slow"
stiffness = [2, 0, 0]
damping = [0.4, 0, 0]
)");
    for (const std::vector<std::string>& range : {std::vector<std::string>{}, {"--below", "0.2 Hz"}}) {
        std::vector<std::string> words = {"modes", "model.toml", "--damped", "-o", "out"};
        words.insert(words.end(), range.begin(), range.end());
        const Ended ended = run_dttmm(folder.path(), words);
        ASSERT_EQ(ended.code, 0) << ended.err;
        EXPECT_THAT(ended.out, HasSubstr("grows without vibration"));
        double growth = 0;
        const nlohmann::json summary = read_json(folder / "out/summary.json");
        for (const nlohmann::json& mode : summary["damped"]["modes"])
            growth = std::max(growth, -mode["decay_per_s"].get<double>());
        EXPECT_NEAR(growth, std::sqrt(9.81 * 0.5 / (0.01 + 0.25)), 1e-6);
    }
}

/// A line between pins, of beams of one segment, under a lasting force at its far end that presses it. A pulse pushes its
/// nodes aside by the shape of the lowest mode, so that nothing else rings.
struct Line {
    int beams;
    double length;    ///< [m]
    double EA, EI;    ///< [N], [N m²]
    double mass;      ///< [kg/m]
    double pressure;  ///< [N]
};

std::string text_of(const Line& line, const std::string& simulation, double push, double width) {
    std::string text =
        fmt::format("format = \"dttmm/1\"\n[simulation]\n{}\n[output]\nchannels = [\"n{}.position\"]\n[nodes]\n", simulation,
                    line.beams / 2);
    const auto place = [&](int i) { return line.length * i / line.beams; };
    for (int i = 0; i <= line.beams; ++i) {
        const char* fixed = i == 0 ? R"(, fixed = ["x", "y", "z", "rz"])" : i == line.beams ? R"(, fixed = ["x", "y"])" : "";
        text += fmt::format("n{} = {{ position = [0.1, 0.2, {:.17g}]{} }}\n", i, 0.3 + place(i), fixed);
    }
    for (int i = 0; i < line.beams; ++i)
        text += fmt::format(R"([[element]]
name = "b{0}"
type = "beam"
from = "n{0}"
to = "n{1}"
segments = 1
theory = "euler-bernoulli"
up = [0, 1, 0]
section = {{ EA = {2:.17g}, EIy = {3:.17g}, EIz = {4:.17g}, GJ = 1e3, mass = {5:.17g}, inertia = 1e-8 }}
)",
                            i, i + 1, line.EA, 1.9 * line.EI, line.EI, line.mass);
    text += fmt::format("[[load]]\non = \"n{}\"\ndirection = [0, 0, -1]\nforce = {:.17g}\n", line.beams, line.pressure);
    for (int i = 1; i < line.beams; ++i)
        text += fmt::format(
            "[[load]]\non = \"n{}\"\ndirection = [1, 0, 0]\n"
            "force = {{ type = \"haversine\", peak = {:.17g}, start = 0, width = {:.17g} }}\n",
            i, push * std::sin(M_PI * i / line.beams), width);
    return text;
}

// Oracle: the frequency of `modes` about the equilibrium of the same lumps, for the columns, ties and the string of P5. A
// run starts at rest and is pushed aside by a millionth of the length. Its frequency, extrapolated to no step, is off by
// less than 1e-7 of itself.
TEST(PreloadedModes, ColumnsTiesAndAStringRingAtTheirFrequencies) {
    constexpr double kEI = 16.4, kL = 1.2, kCritical = M_PI * M_PI * kEI / (kL * kL);
    std::vector<Line> lines;
    for (const double load : {0.25, 0.5, 0.9, -1.0, -4.0, -16.0}) lines.push_back({12, kL, 1e7, kEI, 0.7, load * kCritical});
    lines.push_back({160, 1.0, 1e6, 1e-3, 0.01, -100});
    for (const Line& line : lines) {
        const std::string label = fmt::format("{} beams pressed by {} N", line.beams, line.pressure);
        const std::vector<double> found =
            frequencies_of(modes_of(text_of(line, "", 0, 1), {"--count", "1", "--beams", "lumped"}));
        ASSERT_EQ(found.size(), 1u);
        const double f = found[0], square = std::pow(2 * M_PI * f, 2);
        const double push = 1e-6 * line.length * square * line.mass * line.length / line.beams;
        const auto rung = [&](double h) {
            const std::string simulation =
                fmt::format("start = \"equilibrium\"\nduration = {:.17g}\nstep = {:.17g}", 5 / f, h);
            const TemporaryFolder folder;
            write_text(folder / "model.toml", text_of(line, simulation, push, 0.5 / f));
            const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "-q"});
            EXPECT_EQ(ended.code, 0) << label << ": " << ended.err;
            std::vector<double> aside;
            for (const std::vector<double>& row : read_history(folder / "out/history.csv"))
                if (row[0] > 0.5 / f) aside.push_back(row[1] - 0.1);
            return frequency_behind(aside, h);
        };
        const double h = 0.01 / f;
        EXPECT_NEAR((4 * rung(h) - rung(2 * h)) / 3, f, 2e-7 * f) << label;
    }
}

// Code_Aster SDLL101 (V2.02.101): a pinned steel bar, L = 2 m, d = 10 mm, E = 2e11, rho = 7800, under tension T. Its printed
// frequencies to their digits, and the formula n² π/(2 L²) √(EI/µ) √(1 + T L²/(n² π² EI)) to 1e-6.
TEST(PreloadedModes, CodeAsterSDLL101) {
    const std::vector<std::vector<double>> printed = {{4.9713, 19.8851, 44.7414, 79.5403, 124.2818},
                                                      {5.9090, 20.8860, 45.7561, 80.5600, 125.3037}};
    const double d = 0.01, A = M_PI / 4 * d * d, I = M_PI / 64 * std::pow(d, 4), E = 2e11, rho = 7800, L = 2;
    for (size_t c : {0u, 1u}) {
        const double T = c == 0 ? 0 : 100;
        const std::vector<double> found = frequencies_of(modes_of(fmt::format(R"(format = "dttmm/1"
[nodes]
left = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx"] }}
right = {{ position = [2, 0, 0], fixed = ["y", "z"] }}
[[element]]
name = "bar"
type = "beam"
from = "left"
to = "right"
theory = "euler-bernoulli"
section = {{ EA = {:.17g}, EIy = {:.17g}, EIz = {:.17g}, GJ = 1e4, mass = {:.17g}, inertia = 1e-6 }}
[[load]]
on = "right"
direction = [1, 0, 0]
force = {}
)",
                                                                              E * A, E * I, 1.000001 * E * I, rho * A, T),
                                                                  {"--count", "10"}));
        ASSERT_EQ(found.size(), 10u);
        for (size_t n = 1; n <= 5; ++n) {
            const double N = static_cast<double>(n), s = 1 + T / (E * A);
            const double exact = N * N * M_PI / (2 * L * L * s) * std::sqrt(E * I / (rho * A)) *
                                 std::sqrt(1 + T * s * L * L / (N * N * M_PI * M_PI * E * I));
            EXPECT_NEAR(found[2 * n - 2], exact, 1e-6 * exact) << T << " " << n;
            EXPECT_NEAR(found[2 * n - 2], printed[c][n - 1], 2e-4 * exact) << T << " " << n;
        }
    }
}

// Oracle: modes hold the supports, whether these can move or not. Their nodes are turned; elements of all kinds begin or end
// there, a node is held in some directions only. Mounts on supports that can move lost the turn of their axes.
TEST(PreloadedModes, SupportsThatCanMoveAreHeldLikeOthers) {
    const auto machine = [](bool can_move) {
        const std::string motion =
            can_move ? ", motion = { x = { type = \"harmonic\", amplitude = 1e-4, frequency = 5 } }" : "";
        return fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = [0.4, -1, -9.81]
[nodes]
left = {{ position = [-0.6, 0.1, 0.2], rotation = {{ axis = [0.3, 0.8, 1], angle = "50 deg" }}, fixed = ["x", "y", "z", "rx", "ry", "rz"]{0} }}
right = {{ position = [0.7, -0.1, 0.3], rotation = {{ axis = [1, -0.2, 0.4], angle = "-70 deg" }}, fixed = ["x", "y", "z", "rx", "ry", "rz"]{0} }}
guide = {{ position = [0.1, 0.6, 0.1], rotation = {{ axis = [0.2, 0.7, 1], angle = "33 deg" }}, fixed = ["x", "z", "ry"]{0} }}
deep = {{ position = [0.2, -0.4, -0.8], rotation = {{ axis = [0, 1, 0.5], angle = "80 deg" }}, fixed = ["x", "y", "z", "rx", "ry", "rz"]{0} }}
[[body]]
name = "engine"
mass = 4
inertia = [0.2, 0.3, 0.4]
position = [0, 0, 0.1]
rotation = {{ axis = [1, 1, 0.3], angle = "20 deg" }}
markers = {{ a = [0.3, 0.1, 0], b = [-0.3, 0.05, 0.1], c = {{ position = [0.1, 0.2, -0.1], rotation = {{ axis = [0, 0, 1], angle = "45 deg" }} }} }}
[[element]]
name = "one"
type = "spring_damper"
from = "left"
to = "engine.b"
stiffness = [1e5, 2e5, 3e5]
rotational_stiffness = [1000, 4000, 9000]
[[element]]
name = "two"
type = "spring_damper"
from = "engine.a"
to = "right"
stiffness = [3e4, 7e4, 2e4]
rotational_stiffness = [300, 200, 900]
[[element]]
name = "arm"
type = "beam"
from = "guide"
to = "engine.c"
segments = 3
section = {{ tube = ["20 mm", "14 mm"] }}
material = {{ E = "70 GPa", poisson = 0.3, density = 2700 }}
[[element]]
name = "post"
type = "beam"
from = "deep"
to = "engine"
segments = 4
section = {{ circle = "15 mm" }}
material = {{ E = "70 GPa", poisson = 0.3, density = 2700 }}
[[element]]
name = "mount"
type = "spring_damper"
from = "ground"
to = "engine.c"
stiffness = [1e4, 1e4, 4e4]
rotational_stiffness = 40
{1}
)",
                           motion,
                           can_move ? "motion = { z = { type = \"harmonic\", amplitude = 1e-3, frequency = 5 } }" : "");
    };
    for (const char* beams : {"exact", "lumped"}) {
        const std::vector<double> still = frequencies_of(modes_of(machine(false), {"--count", "14", "--beams", beams})),
                                  moving = frequencies_of(modes_of(machine(true), {"--count", "14", "--beams", beams}));
        ASSERT_GE(still.size(), 14u);
        expect_frequencies(moving, still, 1e-8);
    }
}

// Oracle: the same machine with its elements in another order, and with the two nodes a little apart: nodes at one place,
// each held in some directions, were taken for each other.
TEST(PreloadedModes, NodesAtOnePlaceKeepWhatHoldsThem) {
    const std::string nodes = R"(format = "dttmm/1"
[simulation]
gravity = [0, 0, -9.81]
[nodes]
left = { position = [0, 0, 0], fixed = ["ry"] }
right = { position = [%, 0, 0], fixed = ["x", "z"], rotation = { axis = [1, 2, 3], angle = "70 deg" } }
clamp = { position = [0.6, 0.3, 0.2], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
[[body]]
name = "head"
mass = 20
inertia = [0.2, 0.3, 0.4]
position = [-0.8, 0.2, 0.3]
[[load]]
on = "head"
direction = [0.2, -0.9, 0.3]
force = 400
)";
    const auto beam = [](const char* name, const char* from, const char* to, double diameter) {
        return fmt::format(
            "[[element]]\nname = \"{}\"\ntype = \"beam\"\nfrom = \"{}\"\nto = \"{}\"\nsegments = 2\n"
            "section = {{ circle = {} }}\nmaterial = {{ E = 200e9, poisson = 0.3, density = 7800 }}\n",
            name, from, to, diameter);
    };
    const std::string one = beam("one", "head", "left", 0.05), two = beam("two", "right", "clamp", 0.03),
                      joint = R"([[element]]
name = "joint"
type = "spring_damper"
from = "left"
to = "right"
stiffness = [1e6, 2e6, 3e6]
rotational_stiffness = [1e4, 2e4, 3e4]
)";
    const auto frequencies = [&](const std::string& elements, const std::string& apart) {
        std::string text = nodes + elements;
        text.replace(text.find('%'), 1, apart);
        return frequencies_of(modes_of(text, {"--count", "6"}));
    };
    const std::vector<double> found = frequencies(one + two + joint, "0");
    ASSERT_EQ(found.size(), 6u);
    expect_frequencies(frequencies(two + joint + one, "0"), found, 1e-9);
    expect_frequencies(frequencies(joint + two + one, "0"), found, 1e-9);
    expect_frequencies(frequencies(two + one + joint, "1e-7"), found, 1e-5);
}

// A body on a ball may spin about its line of pull, which nothing holds. Oracle: in axes of the body, in which the pull goes
// through its centre of mass, the eigenproblem is that of no direction of gravity: m g l (1 - e eT) over its inertia about
// the ball.
TEST(PreloadedModes, ABodyOnABallSpinsUnderObliqueGravity) {
    const double m = 1.3, g = 9.3;
    const Eigen::Vector3d arm(0.3, -0.1, -0.4);
    for (const double slender : {1.0, 1e-4}) {
        const Eigen::Vector3d inertia(0.012, 0.012, 0.0075 * slender);
        const double l = arm.norm();
        const Eigen::Matrix3d I = Eigen::Matrix3d::Identity(), across = I - arm * arm.transpose() / (l * l),
                              J = Eigen::Matrix3d(inertia.asDiagonal()) + m * l * l * across;
        const Eigen::Vector3d squares = test::solve_pencil(m * g * l * across, J).values;
        for (const Eigen::Vector3d& down : {Eigen::Vector3d(0, 0, -1), Eigen::Vector3d(1, 2, -9), Eigen::Vector3d(-3, 1, -1),
                                            Eigen::Vector3d(0.2, -5, 4), Eigen::Vector3d(7, 7.1, -7.3)}) {
            const Eigen::Vector3d gravity = g * down.normalized();
            const std::vector<double> found = frequencies_of(modes_of(fmt::format(
                R"(format = "dttmm/1"
[simulation]
gravity = [{:.17g}, {:.17g}, {:.17g}]
[[body]]
name = "bob"
mass = {}
inertia = [{}, {}, {:.17g}]
position = [0.5, -0.3, -0.3]
[[joint]]
name = "ball"
type = "ball"
between = ["ground", "bob"]
anchor = [0.2, -0.2, 0.1]
)",
                gravity.x(), gravity.y(), gravity.z(), m, inertia.x(), inertia.y(), inertia.z())));
            ASSERT_EQ(found.size(), 3u);
            EXPECT_EQ(found[0], 0);
            for (Eigen::Index i : {1, 2})
                EXPECT_NEAR(found[static_cast<size_t>(i)] * 2 * M_PI / std::sqrt(squares(i)), 1, 1e-9);
        }
    }
}

/// Three bodies on hinges, one behind the other, turned as a whole. A force pulls the second; without weight nothing pulls
/// the third, which spins about an axis through its centre of mass, or beside it.
std::string pulled_chain(const Eigen::Matrix3d& turn, bool is_centred) {
    const auto vector = [&](double x, double y, double z) {
        const Eigen::Vector3d v = turn * Eigen::Vector3d(x, y, z);
        return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
    };
    std::string text = "format = \"dttmm/1\"\n";
    const auto body = [&](const char* name, const std::string& position) {
        text += fmt::format("[[body]]\nname = \"{}\"\nmass = 2\ninertia = [0.2, 0.2, 0.2]\nposition = {}\n", name, position);
    };
    const auto hinge = [&](const char* first, const char* second, const std::string& anchor, const std::string& axis) {
        text += fmt::format(
            "[[joint]]\nname = \"to-{1}\"\ntype = \"hinge\"\nbetween = [\"{0}\", \"{1}\"]\nanchor = {2}\naxis = {3}\n",
            first, second, anchor, axis);
    };
    body("b0", vector(0.7, -0.2, 0.4));
    body("b1", vector(-0.6, 0.9, 0.1));
    body("b2", vector(0.3, 0.5, -0.8));
    hinge("ground", "b0", vector(0.1, 0.6, -0.3), vector(0.2, -1, 0.5));
    hinge("b0", "b1", vector(-0.4, 0.3, 0.8), vector(1, 0.3, 0.4));
    hinge("b1", "b2", vector(0.5, -0.7, -0.1), is_centred ? vector(-0.2, 1.2, -0.7) : vector(-0.3, 0.4, 1));
    return text + fmt::format("[[load]]\non = \"b1\"\ndirection = {}\nforce = 40\n", vector(0.3, 0.8, -0.5));
}

// Oracle: the machine turned as a whole has the same frequencies, one of them 0; the others hang on where the third body
// stays, if it swings out.
TEST(PreloadedModes, APartThatNothingPullsMovesFreelyHoweverItLies) {
    std::vector<double> frequencies;
    for (int i = 0; i < 12; ++i) {
        const Eigen::Vector3d axis(std::sin(3.0 * i + 1), std::cos(5.0 * i), std::sin(7.0 * i + 2));
        const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.4 * i, axis.normalized()).toRotationMatrix();
        for (const bool is_centred : {true, false}) {
            const std::string text = pulled_chain(turn, is_centred);
            const std::vector<double> found = frequencies_of(modes_of(text));
            ASSERT_EQ(found.size(), 3u) << i;
            EXPECT_EQ(found[0], 0) << i;
            if (is_centred && i == 0) frequencies = found;
            for (size_t k = 1; is_centred && k < 3; ++k) EXPECT_NEAR(found[k] / frequencies[k], 1, 1e-9) << i;
            EXPECT_LT(rest_of(text).summary["largest_unbalanced_force_n"].get<double>(), 1e-12) << i;
        }
    }
}

/// A rigid body on a spring under gravity, with a beam from one of its points to another. has_hinge: the body has its first
/// point only, and a hinge without freedom leads to the second.
std::string bow_at_rest(bool has_hinge) {
    return fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = [0, 0, -9.81]
[nodes]
a = [0.3, 0.1, 0]
b = [-0.4, 0, 0.1]
[[element]]
name = "r"
type = "rigid_body"
at = [{}]
mass = 2
inertia = {{ xx = 0.1, yy = 0.12, zz = 0.15 }}
[[element]]
name = "e"
type = "beam"
from = "a"
to = "b"
section = {{ EA = 2e7, EIy = 100, EIz = 150, GJ = 80, GAy = 6e6, GAz = 7e6, mass = 0.6, mass_offset = [0.002, 0.001], inertia = 2e-5 }}
[[element]]
name = "s"
type = "spring_damper"
from = "ground"
to = "a"
stiffness = [1e4, 2e4, 3e4]
rotational_stiffness = [1e3, 2e3, 3e3]
{})",
                       has_hinge ? "\"a\"" : "\"a\", \"b\"",
                       has_hinge ? "[[element]]\nname = \"h\"\ntype = \"elastic_hinge\"\nfrom = \"a\"\nto = \"b\"\n" : "");
}

// Oracle: the same machine with a rigid hinge in its body. Gravity bends the beam, so that its pieces have forces at rest.
// They are found by iteration, in each of the two to
// about 1e-8 of the largest. `static` knows whether the equilibrium is stable.
TEST(PreloadedModes, ABeamBetweenTwoPointsOfOneRigidBody) {
    const std::vector<double> own = frequencies_of(modes_of(bow_at_rest(false), {"--count", "12"}));
    ASSERT_EQ(own.size(), 12u);
    expect_frequencies(own, frequencies_of(modes_of(bow_at_rest(true), {"--count", "12"})), 1e-7);
    EXPECT_EQ(rest_of(bow_at_rest(false)).told.find("stable"), std::string::npos);
}

/// Natural frequencies of a rope of 3.7 m and 0.8 kg/m that hangs along an oblique gravity, with a bob or without.
std::vector<double> frequencies_of_rope(double bob, int segments, int count) {
    const std::string mass =
        bob > 0 ? fmt::format("[[element]]\nname = \"bob\"\ntype = \"point_mass\"\nat = \"free\"\nmass = {}\n", bob) : "";
    return frequencies_of(modes_of(fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = [3.27, -6.54, -6.54]
[nodes]
top = {{ position = [0.4, 0.1, -0.3], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
free = [{:.17g}, {:.17g}, {:.17g}]
[[element]]
name = "rope"
type = "beam"
from = "top"
to = "free"
segments = {}
theory = "euler-bernoulli"
section = {{ EA = 1e6, EIy = 1e-4, EIz = 1e-4, GJ = 1e-3, mass = 0.8, inertia = 1e-7 }}
{})",
                                               0.4 + 3.7 / 3, 0.1 - 7.4 / 3, -0.3 - 7.4 / 3, segments, mass),
                                   {"--count", fmt::format("{}", count)}));
}

// Oracle: of a string that hangs, z above the place where its tension would be zero, u = A J0(2 ω √(z/g)) + B Y0(2 ω
// √(z/g)); fixed at its top, with u' = −ω² u/g at the bob, without one the zeros of J0. Both planes are alike. The clamp at
// the top makes the rope shorter by √(EI/N), which is 2e-3 m/3.7 m.
TEST(PreloadedModes, ARopeThatHangsUnderItsOwnWeight) {
    constexpr double kLength = 3.7, kMass = 0.8, kGravity = 9.81;
    for (const double bob : {0., 1.3}) {
        const double low = bob / kMass, high = low + kLength;
        const auto lacks = [&](double omega) {
            const auto argument = [&](double z) { return 2 * omega * std::sqrt(z / kGravity); };
            const double top = argument(high);
            if (bob == 0) return std::cyl_bessel_j(0, top);
            // u' = (−A J1 − B Y1) ω/√(g z)
            const double x = argument(low), by_z = omega / std::sqrt(kGravity * low);
            const auto at_bob = [&](double value, double first) { return -first * by_z + omega * omega / kGravity * value; };
            return std::cyl_bessel_j(0, top) * at_bob(std::cyl_neumann(0, x), std::cyl_neumann(1, x)) -
                   std::cyl_neumann(0, top) * at_bob(std::cyl_bessel_j(0, x), std::cyl_bessel_j(1, x));
        };
        std::vector<double> expected;
        for (double omega = 0.5; expected.size() < 4; omega += 0.01)
            if (lacks(omega) * lacks(omega + 0.01) < 0) {
                double below = omega, above = omega + 0.01;
                for (int k = 0; k < 60; ++k) {
                    const double middle = 0.5 * (below + above);
                    (lacks(below) * lacks(middle) > 0 ? below : above) = middle;
                }
                expected.push_back(below / (2 * M_PI));
            }
        // At a free end the tension falls to zero, and bending counts in higher modes
        const size_t compared = bob > 0 ? 8 : 6;
        for (const int segments : {5, 10, 40}) {
            const std::vector<double> found = frequencies_of_rope(bob, segments, 8);
            for (size_t k = 0; k < compared; ++k)
                EXPECT_NEAR(found.at(k), expected[k / 2], 6e-4 * expected[k / 2]) << bob << ": " << k;
        }
    }
}

// Oracle: √(g/(L + m g/k)) and √(k/m). The spring's stiffness has next to no part in a swing: its shares by direction were
// infinite.
TEST(PreloadedModes, ABodySwingsOnALongSpring) {
    for (const auto& [length, mass, stiffness] : {std::tuple(30., 5., 1e5), std::tuple(2.1, 0.33, 9.5e4)}) {
        const auto found = frequencies_of(modes_of(fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = [0, 0, -9.81]
[nodes]
top = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
[[body]]
name = "a"
mass = {1}
inertia = [{1}, {1}, {1}]
position = [0, 0, -{0}]
[[element]]
name = "s"
type = "axial_spring"
from = "top"
to = "a"
stiffness = {2}
)",
                                                               length, mass, stiffness),
                                                   {"--count", "6"}));
        const double swing = std::sqrt(9.81 / (length + mass * 9.81 / stiffness)) / (2 * M_PI);
        ASSERT_EQ(found.size(), 6u);
        for (const size_t k : {0u, 1u, 2u}) EXPECT_EQ(found[k], 0);
        for (const size_t k : {3u, 4u}) EXPECT_NEAR(found[k], swing, 1e-7 * swing);
        EXPECT_NEAR(found[5], std::sqrt(stiffness / mass) / (2 * M_PI), 1e-8 * found[5]);
    }
}

/// ω of a cantilever of unit length, mass and bending stiffness under an axial load from `first` at its root to `last` at
/// its tip, per length: Ritz' method with x² to x¹³, by ∫ v''² + N v'² and ∫ v².
Eigen::VectorXd pulled_cantilever(double first, double last) {
    constexpr int kShapes = 12, kCells = 400;
    constexpr double kPoint = 0.7745966692414834;  // Gauss' three
    Eigen::MatrixXd K = Eigen::MatrixXd::Zero(kShapes, kShapes), M = K;
    for (int cell = 0; cell < kCells; ++cell)
        for (const auto& [at, weight] : {std::pair(-kPoint, 5. / 18), std::pair(0., 4. / 9), std::pair(kPoint, 5. / 18)}) {
            const double s = (cell + 0.5 + 0.5 * at) / kCells, x = 2 * s - 1;
            // s² P(x), Legendre's polynomials and their derivatives by s
            Eigen::MatrixXd P(3, kShapes), v(3, kShapes);
            for (int k = 0; k < kShapes; ++k)
                for (int d = 0; d < 3; ++d) {
                    const double before = k > 0 ? P(d, k - 1) : 0, last_but_one = k > 1 ? P(d, k - 2) : 0,
                                 lower = d > 0 && k > 0 ? 2 * d * P(d - 1, k - 1) : 0;
                    P(d, k) = k == 0 ? (d == 0 ? 1 : 0) : ((2 * k - 1) * (x * before + lower) - (k - 1) * last_but_one) / k;
                }
            v.row(0) = s * s * P.row(0);
            v.row(1) = 2 * s * P.row(0) + s * s * P.row(1);
            v.row(2) = 2 * P.row(0) + 4 * s * P.row(1) + s * s * P.row(2);
            const double N = first * (1 - s) + 0.5 * (last - first) * (1 - s * s), part = weight / kCells;
            K += part * (v.row(2).transpose() * v.row(2) + N * v.row(1).transpose() * v.row(1));
            M += part * v.row(0).transpose() * v.row(0);
        }
    return test::solve_pencil(K, M).values.cwiseSqrt();
}

// Oracle: Ritz' method, and for a blade whose root is on the axis of rotation the table of Wright, Smith, Thresher and Wang
// (1982), J. Appl. Mech. 49. A blade that rotates is pulled by µ Ω² r along it; out of the plane of rotation that is all.
TEST(PreloadedModes, ABladeThatRotates) {
    constexpr double kLength = 1.7, kMass = 2.3, kEI = 640;  // kg/m, N m²
    const double unit = std::sqrt(kEI / kMass) / (kLength * kLength);
    const Eigen::VectorXd at_12 = pulled_cantilever(0, 144);
    EXPECT_NEAR(at_12(0), 13.1702, 5e-5);
    EXPECT_NEAR(at_12(1), 37.6031, 5e-5);
    EXPECT_NEAR(at_12(2), 79.6145, 5e-5);
    // Pressed, too
    for (const auto& [first, last] : {std::pair(0., 144.), std::pair(16., 41.), std::pair(5., -8.), std::pair(0., -5.)})
        for (const int segments : {1, 3, 10}) {
            const Eigen::VectorXd expected = pulled_cantilever(first, last);
            const double per_length = kEI / (kLength * kLength * kLength);
            const auto found =
                frequencies_of(modes_of(fmt::format(R"(format = "dttmm/1"
[nodes]
hub = {{ position = [0.4, -0.1, 0.3], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
tip = {{ position = [{:.17g}, {:.17g}, {:.17g}] }}
[[element]]
name = "blade"
type = "beam"
theory = "euler-bernoulli"
from = "hub"
to = "tip"
segments = {}
section = {{ EA = 1e11, EIy = {}, EIz = 1e6, GJ = 2e6, mass = {}, inertia = 1e-3 }}
up = [0, 0, 1]
[[load]]
element = "blade"
direction = [1, 2, -2]
force_per_length = [{:.17g}, {:.17g}]
)",
                                                    0.4 + kLength / 3, -0.1 + 2 * kLength / 3, 0.3 - 2 * kLength / 3,
                                                    segments, kEI, kMass, per_length * first, per_length * last),
                                        {"--count", "2"}));
            for (Eigen::Index k : {0, 1})
                EXPECT_NEAR(found.at(static_cast<size_t>(k)) * 2 * M_PI, expected(k) * unit, 2e-6 * expected(k) * unit)
                    << first << " " << last << ": " << segments << ", " << k;
        }
}

// Oracle: a taut wire with stiffness between pins, f = n/(2 L) √(T/µ) √(1 + n² π² EI/(T L²)). Its weight bends it by up
// to 1.1 of its radius of gyration, which is 3e-6 of its frequencies at most; its tension stretches it by 1.3e-3, T/EA.
TEST(PreloadedModes, ATautWireThatItsWeightBends) {
    constexpr double kE = 210e9, kDensity = 7850, kDiameter = 3e-3, kLength = 5;
    const double area = M_PI * kDiameter * kDiameter / 4, bending = kE * area * kDiameter * kDiameter / 16;
    for (const double tension : {2e3, 5e3})
        for (const int segments : {5, 10, 33}) {
            const std::vector<double> found = frequencies_of(modes_of(fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = [0, 5.886, -7.848]
[nodes]
a = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx"] }}
b = {{ position = [5, 0, 0], fixed = ["y", "z", "rx"] }}
[[element]]
name = "wire"
type = "beam"
from = "a"
to = "b"
segments = {}
theory = "euler-bernoulli"
section = {{ circle = "3 mm" }}
material = {{ E = "210 GPa", poisson = 0.3, density = 7850 }}
[[load]]
on = "b"
direction = [1, 0, 0]
force = {}
)",
                                                                                  segments, tension),
                                                                      {"--count", "6"}));
            const double strain = tension / (kE * area), length = kLength * (1 + strain);
            for (size_t k = 0; k < 6; ++k) {
                const double n = static_cast<double>(k / 2 + 1), x = n * M_PI / length;
                const double exact =
                    x / (2 * M_PI) *
                    std::sqrt((tension + x * x * bending * (1 + strain)) * (1 + strain) / (kDensity * area));
                EXPECT_NEAR(found.at(k), exact, 2e-5 * exact) << tension << " " << segments << ": " << k;
            }
        }
}

// Oracle: finer lumps, extrapolated. A body beside the axis of a light cantilever bends and twists it by 0.05 of its radius
// of gyration: its curvature couples bending with torsion.
TEST(PreloadedModes, ABeamThatALoadBesideItsAxisBends) {
    const auto frequencies = [](int segments, const char* beams) {
        return frequencies_of(modes_of(fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = [0, 45, -60]
[nodes]
w = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
[[body]]
name = "b"
mass = 0.5
inertia = [0.002, 0.003, 0.0025]
position = [0.6, 0.06, 0.08]
markers = {{ p = [0, -0.06, -0.08] }}
[[element]]
name = "e"
type = "beam"
from = "w"
to = "b.p"
segments = {}
theory = "euler-bernoulli"
up = [0, -3, 4]
section = {{ EA = 6e5, EIy = 800, EIz = 120, GJ = 100, mass = 1e-8, inertia = 1e-11 }}
)",
                                                   segments),
                                       {"--count", "6", "--beams", beams}));
    };
    const std::vector<double> coarse = frequencies(40, "lumped"), fine = frequencies(80, "lumped");
    const std::vector<double> five = frequencies(5, "exact"), ten = frequencies(10, "exact");
    for (size_t k = 0; k < 6; ++k) {
        const double expected = (4 * fine.at(k) - coarse.at(k)) / 3;
        EXPECT_NEAR(ten.at(k), expected, 2e-6 * expected) << k;
        EXPECT_NEAR(five.at(k), expected, 8e-6 * expected) << k;
    }
}

// Oracle: the bend by hand: a force F at a tip bends a cantilever by F L³/(3 EI), and its middle by 1/(3 √3) of that beside
// the line between its ends; the radius of gyration is 10 mm. What is bent by more than three radii are lumps.
TEST(PreloadedModes, ABentBeamIsToldWithWhatItsBendLeaves) {
    for (const auto& [bend, words] : {std::pair(0.03, ""),
                                      {0.07,
                                       "by 0.07 of its radius of gyration, which is in the "
                                       "frequencies with a relative error of the order of 0.001/n^2"},
                                      {1.5, "a relative error of the order of 0.5/n^2"},
                                      {2.7, "which is in the frequencies"},
                                      {3.3, "it counts by its segments, as in a run"}}) {
        const TemporaryFolder folder;
        write_text(folder / "m.toml", fmt::format(R"(format = "dttmm/1"
[nodes]
wall = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
tip = [1, 0, 0]
[[element]]
name = "bar"
type = "beam"
from = "wall"
to = "tip"
segments = 20
theory = "euler-bernoulli"
section = {{ EA = 1e6, EIy = 100, EIz = 130, GJ = 80, mass = 0.7, inertia = 1e-4 }}
[[load]]
on = "tip"
direction = [0, 0, 1]
force = {}
)",
                                                  3 * 100 * 0.01 * bend * 3 * std::sqrt(3)));
        const Ended ended = run_dttmm(folder.path(), {"modes", "m.toml", "-o", "out"});
        EXPECT_EQ(ended.code, 0) << bend;
        if (*words) {
            EXPECT_THAT(ended.err, HasSubstr(words)) << bend;
        } else {
            EXPECT_THAT(ended.err, testing::Not(HasSubstr("is bent at rest")));
        }
    }
}

// A pipe that its own weight bends, of a single segment: no place along it shows its bend. Oracle: the moment there, q L²/8,
// by hand.
TEST(PreloadedModes, ABeamOfOneSegmentThatIsBentIsTold) {
    const TemporaryFolder folder;
    write_text(folder / "m.toml", R"(format = "dttmm/1"
[simulation]
gravity = [0, 0, -9.81]
[nodes]
l = { position = [0, 0, 0], fixed = ["x", "y", "z", "ry", "rz"] }
r = { position = [0, 12, 0], fixed = ["x", "y", "z", "rz"] }
[[element]]
name = "pipe"
type = "beam"
from = "l"
to = "r"
segments = 1
theory = "euler-bernoulli"
section = { EA = 2.73e8, EIy = 4.15e5, EIz = 4.15e5, GJ = 3e5, mass = 10.2, inertia = 0.03 }
)");
    // Times L²/(8 EI) it is 78 mm; the radius of gyration is 39 mm
    EXPECT_THAT(run_dttmm(folder.path(), {"modes", "m.toml", "-o", "out"}).err,
                HasSubstr("element \"pipe\" is bent at rest by 2 of its radius of gyration"));
}

/// A shaft of 30 mm on two springs, with a disc whose centre of mass lies below its axis.
std::string rotor(double beside) {
    const auto shaft = [](const char* from, const char* to) {
        return fmt::format(
            "[[element]]\nname = \"{0}_{1}\"\ntype = \"beam\"\nfrom = \"{0}\"\nto = \"{1}\"\nsection = {{ circle = "
            "\"30 mm\" }}\nmaterial = {{ E = \"210 GPa\", poisson = 0.3, density = 7850 }}\n",
            from, to);
    };
    const auto bearing = [](const char* node, double along) {
        return fmt::format(
            "[[element]]\nname = \"under_{0}\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"{0}\"\n"
            "stiffness = [{1}, 5e7, 5e7]\n",
            node, along);
    };
    return fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = [0, 0, -9.81]
[nodes]
left = [0, 0, 0]
right = [0.6, 0, 0]
[[body]]
name = "disc"
mass = 10.65
inertia = [0.0767, 0.0392, 0.0392]
center_of_mass = [0, 0, {:.17g}]
position = [0.25, 0, 0]
)",
                       -beside) +
           shaft("left", "disc") + shaft("disc", "right") + bearing("left", 2e7) + bearing("right", 0);
}

// Oracle: a pendulum, √(m g e/J)/2π, J that of the disc and the shaft. The shaft bends by 10 µm, and its pieces held the
// spin about its bent axis: with e = 2 µm by 45 %, and a centred rotor was called unstable.
TEST(PreloadedModes, ARotorSwingsByItsEccentricityAlone) {
    const double shaft = M_PI * std::pow(0.03, 4) / 32 * 7850 * 0.6;
    for (const double beside : {2e-6, 2e-5, 1e-4}) {
        const double exact = std::sqrt(10.65 * 9.81 * beside / (0.0767 + shaft + 10.65 * beside * beside)) / (2 * M_PI);
        EXPECT_NEAR(frequencies_of(modes_of(rotor(beside), {"--count", "3"})).at(0), exact, 1e-4 * exact) << beside;
    }
    EXPECT_EQ(frequencies_of(modes_of(rotor(0), {"--count", "3"})).at(0), 0);
    const AtRest rest = rest_of(rotor(0));
    EXPECT_THAT(rest.told, testing::Not(HasSubstr("unstable")));
    EXPECT_EQ(rest.summary["free_motions"], 1);
}

// Oracle: a bar that is as stiff in all directions spins about its bent axis, and nothing holds it; by a body beside it, it
// has a frequency that many lumps agree on. It was called unstable, at -0.85 Hz, and erred by 6 %.
TEST(PreloadedModes, ABentBarBetweenBallJointsSpinsFreely) {
    const auto bar = [](int segments, const char* section, const char* body) {
        return fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = [0, 0, -9.81]
[nodes]
a = {{ position = [0, 0, 0], fixed = ["x", "y", "z"] }}
b = {{ position = [1.3, 0, 0], fixed = ["x", "y", "z"] }}
{}[[element]]
name = "bar"
type = "beam"
from = "a"
to = "b"
segments = {}
section = {{ {} }}
material = {{ E = "210 GPa", poisson = 0.3, density = 7850 }}
)",
                           body, segments, section);
    };
    for (const char* section : {"circle = \"8 mm\"", "rectangle = [\"7 mm\", \"7 mm\"]"})
        for (const int segments : {10, 40}) {
            const TemporaryFolder folder;
            write_text(folder / "m.toml", bar(segments, section, ""));
            const Ended ended = run_dttmm(folder.path(), {"modes", "m.toml", "--count", "2", "-o", "out"});
            ASSERT_EQ(ended.code, 0) << section << segments << ended.err;
            EXPECT_NEAR(read_json(folder / "out/summary.json")["modes"][0]["frequency_hz"].get<double>(), 0, 0.02);
            EXPECT_THAT(rest_of(bar(segments, section, "")).told, testing::Not(HasSubstr("unstable"))) << segments;
        }
}

/// A bar between ball joints, which spins; its first critical load factor counts that as 1, by 0.41/n² off with n segments.
TEST(PreloadedModes, ACriticalLoadFactorOfAShaftThatSpinsIsNoted) {
    for (const int segments : {2, 10}) {
        const AtRest rest = rest_of(fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = [0, 0, -9.81]
[nodes]
a = {{ position = [0, 0, 0], fixed = ["x", "y", "z"] }}
b = {{ position = [1.3, 0, 0], fixed = ["y", "z"] }}
[[element]]
name = "bar"
type = "beam"
from = "a"
to = "b"
segments = {}
section = {{ circle = "8 mm" }}
material = {{ E = "210 GPa", poisson = 0.3, density = 7850 }}
)",
                                                segments),
                                    {"--buckling", "1"});
        EXPECT_NEAR(rest.summary["critical_load_factors"][0].get<double>(), 1, 0.42 / (segments * segments)) << segments;
        EXPECT_THAT(rest.told, HasSubstr("may be that of a motion that nothing holds at rest")) << segments;
    }
}

// Oracle: a column with pins buckles at π² EI/(L l), l the pressed length, here at 1.16 times its load. A body that nothing
// holds beside it has no critical load.
TEST(PreloadedModes, ACriticalLoadFactorBesideAFreeBodyIsNotNoted) {
    constexpr double kEI = 12, kEA = 4e6, kL = 0.7;
    const double load = M_PI * M_PI * kEI / (kL * kL) / 1.16;
    const AtRest rest = rest_of(fmt::format(R"(format = "dttmm/1"
[nodes]
foot = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rz"] }}
head = {{ position = [0, 0, {}], fixed = ["x", "y"] }}
[[body]]
name = "stone"
mass = 3
inertia = [0.1, 0.2, 0.25]
position = [1, 0, 0]
[[element]]
name = "column"
type = "beam"
from = "foot"
to = "head"
segments = 20
theory = "euler-bernoulli"
section = {{ EA = {}, EIy = {}, EIz = {}, GJ = 10, mass = 0.7, inertia = 1e-4 }}
[[load]]
on = "head"
direction = [0, 0, -1]
force = {}
)",
                                            kL, kEA, kEI, 2.1 * kEI, load),
                                {"--buckling", "1"});
    EXPECT_NEAR(rest.summary["critical_load_factors"][0].get<double>(), 1.16 / (1 - load / kEA), 1e-4);
    EXPECT_EQ(rest.summary["free_motions"], 6);
    EXPECT_THAT(rest.told, testing::Not(HasSubstr("may be that of a motion that nothing holds at rest")));
}

// Oracle: 6 motions of the whole are free, and the others are those of the machine on springs that are soft beside it. A
// tube and a tie that presses it balance each other wherever they are; modes ended with code 4.
TEST(PreloadedModes, ATieThatPressesAFreeTube) {
    const auto frequencies = [](const char* springs, int count) {
        const TemporaryFolder folder;
        write_text(folder / "m.toml", fmt::format(R"(format = "dttmm/1"
[nodes]
a = [0.1, 0.2, 0.3]
b = [0.9, 1.1, 0.7]
[[element]]
name = "tube"
type = "beam"
from = "a"
to = "b"
segments = 12
section = {{ tube = ["40 mm", "34 mm"] }}
material = {{ E = "210 GPa", poisson = 0.3, density = 7850 }}
[[element]]
name = "tie"
type = "axial_spring"
from = "a"
to = "b"
stiffness = 2e5
preload = 3000
{})",
                                                  springs));
        const Ended ended = run_dttmm(folder.path(), {"modes", "m.toml", "--count", std::to_string(count), "-o", "out"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        if (ended.code != 0) return std::vector<double>();
        return frequencies_of(read_json(folder / "out/summary.json"));
    };
    const std::vector<double> free = frequencies("", 8), sprung = frequencies(R"([[element]]
name = "one"
type = "spring_damper"
from = "ground"
to = "a"
stiffness = 3
rotational_stiffness = 0.2
[[element]]
name = "other"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = 3
rotational_stiffness = 0.2
)",
                                                                              8);
    ASSERT_EQ(free.size(), 8u);
    ASSERT_EQ(sprung.size(), 8u);
    for (size_t k = 0; k < 6; ++k) EXPECT_EQ(free[k], 0) << k;
    for (size_t k = 6; k < 8; ++k) EXPECT_NEAR(free[k], sprung[k], 1e-4 * sprung[k]) << k;
}

// Oracle: the girder without its load, whose bend is 1e-5 of its frequencies. By ten lumps the eighth is 9 % lower.
TEST(PreloadedModes, AGirderUnderItsOwnWeightIsNotLumps) {
    const std::string girder = R"(format = "dttmm/1"
[simulation]
gravity = [0, 0, -9.81]
[nodes]
a = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "rz"] }
b = { position = [6, 0, 0], fixed = ["y", "z", "rx", "rz"] }
[[element]]
name = "girder"
type = "beam"
from = "a"
to = "b"
section = { tube = ["120 mm", "100 mm"] }
material = { E = "210 GPa", poisson = 0.3, density = 7850 }
)";
    const std::vector<double> bent = frequencies_of(modes_of(girder, {"--count", "8"})),
                              straight = frequencies_of(modes_of(girder, {"--count", "8", "--about", "start"}));
    for (size_t k = 0; k < 8; ++k) EXPECT_NEAR(bent.at(k), straight.at(k), 2e-4 * straight.at(k)) << k;
}

// Oracle: a strip between two clamps that are pushed together by d carries EA d/L and buckles at 4π² EI/(L (L − d)). The
// same strip with a node on it. No node of the strip alone is free to move, and modes were refused.
TEST(PreloadedModes, AStripBetweenClampsThatArePushedTogether) {
    static constexpr double kLength = 0.83, kEA = 3e6, kEI = 7, kPush = 2e-5;
    const auto strip = [](double gravity, const char* probe) {
        return fmt::format(R"(format = "dttmm/1"
[simulation]
gravity = [0, 0, {}]
[nodes]
a = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
b = {{ position = [0, {}, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"], motion = {{ y = {} }} }}
[[element]]
name = "strip"
type = "beam"
from = "a"
to = "b"
segments = 40
theory = "euler-bernoulli"
section = {{ EA = {}, EIy = {}, EIz = 31, GJ = 9, mass = 0.4, inertia = 3e-5 }}
{})",
                           gravity, kLength, -kPush, kEA, kEI, probe);
    };
    const char* const kProbe = "[[probe]]\nname = \"p\"\non = \"strip\"\nat = 0.332\n";
    const std::string straight = strip(0, "");
    const AtRest rest = rest_of(straight, {"--buckling", "1"});
    ASSERT_EQ(rest.summary["critical_load_factors"].size(), 1u);
    EXPECT_NEAR(rest.summary["critical_load_factors"][0].get<double>() /
                    (4 * M_PI * M_PI * kEI / (kLength * (kLength - kPush)) / (kEA * kPush / kLength)),
                1, 1e-8);
    expect_frequencies(frequencies_of(modes_of(straight, {"--count", "9"})),
                       frequencies_of(modes_of(strip(0, kProbe), {"--count", "9"})), 1e-9);
    // bent by its weight, a line is a part of one piece or of two
    expect_frequencies(frequencies_of(modes_of(strip(-9.81, ""), {"--count", "9"})),
                       frequencies_of(modes_of(strip(-9.81, kProbe), {"--count", "9"})), 1e-6);
}

// Oracle: 2 sqrt(T/(m a)) sin(k pi/(2 (n + 1))), each in two directions, and the same along the line with its stiffness. The
// beads turn freely. Two shapes of one frequency may be found one by one, and are not the same.
TEST(PreloadedModes, BeadsOnATautLineHaveTwoOfEachFrequency) {
    constexpr int kBeads = 20;
    constexpr double kMass = 0.02, kTension = 1, kStiffness = 1e6;
    const Eigen::Vector3d step(0.06, 0.048, 0.064);
    std::string text =
        "format = \"dttmm/1\"\n[nodes]\ns = { position = [0, 0, 0], fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"] "
        "}\n";
    const auto place = [&](int i) { return fmt::format("[{}, {}, {}]", i * step.x(), i * step.y(), i * step.z()); };
    text +=
        fmt::format("t = {{ position = {}, fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"] }}\n", place(kBeads + 1));
    for (int i = 1; i <= kBeads; ++i)
        text += fmt::format("[[body]]\nname = \"b{}\"\nmass = {}\ninertia = [1e-6, 1e-6, 1e-6]\nposition = {}\n", i, kMass,
                            place(i));
    for (int i = 0; i <= kBeads; ++i)
        text += fmt::format(
            "[[element]]\nname = \"k{}\"\ntype = \"axial_spring\"\nfrom = \"{}\"\nto = \"{}\"\nstiffness = {}\npreload = "
            "{}\n",
            i, i == 0 ? "s" : fmt::format("b{}", i), i == kBeads ? "t" : fmt::format("b{}", i + 1), kStiffness, kTension);
    const TemporaryFolder folder;
    write_text(folder / "m.toml", text);
    const Ended ended = run_dttmm(folder.path(), {"modes", "m.toml", "--json", "--count", "120", "-o", "out"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    std::vector<double> expected(3 * kBeads, 0.0);
    for (int k = 1; k <= kBeads; ++k) {
        const double wave = std::sin(k * M_PI / (2 * (kBeads + 1))) / M_PI;
        expected.insert(expected.end(), 2, std::sqrt(kTension / (kMass * step.norm())) * wave);
        expected.push_back(std::sqrt(kStiffness / kMass) * wave);
    }
    expect_frequencies(frequencies_of(nlohmann::json::parse(ended.out)), sorted(expected), 1e-8);
}

// Oracle: the pendulum's frequency, 3 to 4 times what rounding of the stiff slider beside it makes of one.
TEST(PreloadedModes, APendulumNearRoundingGrowsOrVibrates) {
    const std::string slider = R"toml(format = "dttmm/1"
[simulation]
gravity = [0, 0, -9.81]
[[body]]
name = "block"
mass = 10
inertia = [1, 1, 1]
position = [2, 0, 0]
[[joint]]
name = "guide"
type = "slider"
between = ["ground", "block"]
axis = [0, 0, 1]
[[element]]
name = "stiff"
type = "spring_damper"
from = "ground"
to = "block"
stiffness = [0, 0, 1e9]
)toml";
    for (const double frequency : {-0.005, -0.0039, 0.0039, 0.005}) {
        const std::string text = slider + pendulum(frequency);
        const AtRest rest = rest_of(text);
        EXPECT_EQ(rest.summary["growing_motions"], frequency < 0 ? 1 : 0) << frequency;
        EXPECT_EQ(rest.summary["free_motions"], 0) << frequency;
        const std::vector<double> found = frequencies_of(modes_of(text, {"--count", "2"}));
        ASSERT_EQ(found.size(), 2u) << frequency;
        EXPECT_NEAR(found[0], frequency, 1e-6 * std::abs(frequency));
    }
}

}  // namespace
}  // namespace dttmm::host
