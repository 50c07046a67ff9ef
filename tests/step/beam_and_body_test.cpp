// SPDX-License-Identifier: BSD-3-Clause
//
// The body on a beam of examples/beam_and_body against its exact motion.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>
#include <tuple>

#include "model/read_model.h"
#include "step/simulation.h"
#include "support/exact_timoshenko.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

/// A clamped Timoshenko beam with a rigid body at its tip, pushed there by a force F from t = 0 on, from rest, undamped:
///     w(t) = F Σ_n r_n/ω_n² (1 − cos ω_n t),    r_n = φ_n(L)²/(modal mass)
/// With the dynamic stiffness D(ω²) = F/w of the tip, D(ω_n²) = 0 and r_n = −1/(dD/dω²): no integral over a shape is needed.
class ExactBeamAndBody {
public:
    ExactBeamAndBody(const test::ExactTimoshenko& beam, double mass, double inertia, int modes)
        : beam_(beam), mass_(mass), inertia_(inertia) {
        const double step = 2;  // [rad/s], far less than the frequencies are apart
        Real before = singular(step);
        for (int i = 2; static_cast<int>(modes_.size()) < modes; ++i) {
            const Real now = singular(i * step);
            if ((now > 0) != (before > 0)) add_mode((i - 1) * step, i * step);
            before = now;
        }
    }

    struct Mode {
        double omega, residue;  ///< r_n [1/kg]
        double root_moment;     ///< of a tip displacement of one [N]
    };
    const std::vector<Mode>& modes() const { return modes_; }
    /// Per newton: displacement of the tip [m], moment at the root about y [N m], as the beam has it on the body.
    double tip(double t) const {
        double sum = 0;
        for (const Mode& mode : modes_) sum += mode.residue / std::pow(mode.omega, 2) * (1 - std::cos(mode.omega * t));
        return sum;
    }
    double root_moment(double t) const {
        double sum = 0;
        for (const Mode& mode : modes_)
            sum += mode.root_moment * mode.residue / std::pow(mode.omega, 2) * (1 - std::cos(mode.omega * t));
        return sum;
    }

private:
    using Real = test::ExactTimoshenko::Real;
    /// What a root moment and a root force leave over at the tip: moment m − J ω² θ and force −q − m_b ω² y.
    Eigen::Matrix<Real, 2, 2> tip_effort(double omega) const {
        const auto U = beam_.transfer(omega, beam_.length);
        const Real square = static_cast<Real>(omega) * omega;
        Eigen::Matrix<Real, 2, 2> effort;
        effort.row(0) = U.row(2).tail<2>() - inertia_ * square * U.row(1).tail<2>();
        effort.row(1) = -U.row(3).tail<2>() - mass_ * square * U.row(0).tail<2>();
        return effort;
    }
    Real singular(double omega) const { return tip_effort(omega).determinant(); }
    /// Root moment and force that leave no moment at the tip.
    Eigen::Matrix<Real, 2, 1> root(double omega) const {
        const auto effort = tip_effort(omega);
        return {effort(0, 1), -effort(0, 0)};
    }
    Real tip_displacement(double omega) const {
        return (beam_.transfer(omega, beam_.length).row(0).tail<2>() * root(omega))(0);
    }
    Real dynamic_stiffness(double omega) const {
        return (tip_effort(omega).row(1) * root(omega))(0) / tip_displacement(omega);
    }
    void add_mode(double low, double high) {
        const bool sign = singular(low) > 0;
        for (int halving = 0; halving < 60; ++halving) {
            const double middle = 0.5 * (low + high);
            ((singular(middle) > 0) == sign ? low : high) = middle;
        }
        const double omega = 0.5 * (low + high), d = 1e-5 * omega;
        const Real slope = (dynamic_stiffness(omega + d) - dynamic_stiffness(omega - d)) / (4 * omega * d);
        modes_.push_back(
            {omega, static_cast<double>(-1 / slope), static_cast<double>(root(omega)(0) / tip_displacement(omega))});
    }

    test::ExactTimoshenko beam_;
    double mass_, inertia_;
    std::vector<Mode> modes_;
};

/// Numbers of the model file, written here again.
constexpr double kLength = 1.2, kForce = 100;
ExactBeamAndBody exact(int modes) {
    const double outer = 0.05, inner = 0.03, E = 210e9, nu = 0.3, rho = 7850;
    const double A = std::numbers::pi / 4 * (outer * outer - inner * inner),
                 I = std::numbers::pi / 64 * (std::pow(outer, 4) - std::pow(inner, 4));
    const double m2 = std::pow(inner / outer, 2), p2 = (1 + m2) * (1 + m2);  // Cowper's coefficient of a hollow circle
    const double kappa = 6 * (1 + nu) * p2 / ((7 + 6 * nu) * p2 + (20 + 12 * nu) * m2);
    const double side = 0.086, mass = 5;
    const test::ExactTimoshenko beam{E * I, kappa * A * E / (2 * (1 + nu)), rho * A, rho * I, kLength};
    return {beam, mass, mass * side * side / 6, modes};
}

/// Largest difference of the tip's displacement from the exact one in 0.2 s [m].
double error_of_tip(int refinement, double& largest_moment) {
    const Plugins plugins;
    Model model = read_model(std::filesystem::path(test::paths::source_dir()) / "examples/beam_and_body/model.toml",
                             plugins.catalogue());
    model.simulation.step /= refinement;
    model.elements[0].values.change()[1] *= refinement;  // segments
    Simulation simulation(model, plugins);
    std::map<std::string, size_t> column;
    for (size_t c = 0; c < simulation.channels().size(); ++c) column[simulation.channels()[c].name()] = c;
    const ExactBeamAndBody oracle = exact(12);
    double error = 0;
    largest_moment = 0;
    simulation.record_to([&](std::span<const double> row) {
        const double z = kForce * oracle.tip(row[column.at("time")]);
        error = std::max(error, std::abs(z - row[column.at("body.position.z")]));
        largest_moment = std::max(largest_moment, std::abs(row[column.at("tube.moment.y")]));
    });
    while (simulation.index() < simulation.step_count()) simulation.step();
    return error;
}

// The oracle itself: what all modes add up to is statics, L³/3EI + L/κGA at the tip and F L at the root.
TEST(BeamAndBody, ModesAddUpToStatics) {
    double tip = 0, moment = 0;
    const ExactBeamAndBody oracle = exact(12);
    for (const auto& mode : oracle.modes()) {
        tip += mode.residue / std::pow(mode.omega, 2);
        moment += mode.root_moment * mode.residue / std::pow(mode.omega, 2);
    }
    const double EI = 210e9 * std::numbers::pi / 64 * (std::pow(0.05, 4) - std::pow(0.03, 4));
    const double kGA = 0.582375 * 210e9 / 2.6 * std::numbers::pi / 4 * (0.05 * 0.05 - 0.03 * 0.03);
    EXPECT_NEAR(tip, std::pow(kLength, 3) / (3 * EI) + kLength / kGA, 1e-5 * tip);
    EXPECT_NEAR(moment, kLength, 2e-4 * kLength);
}

// Oracle: the sum of the exact beam's modes, 2.0574 mm at most and 255.8 N m at the root. At the model's step of 0.25 ms the
// second vibration (140 Hz, 0.4 % of the displacement) falls behind by (ω h)²/12 of its phase, 0.7 rad in 0.2 s: that is the
// error. A quarter of the step and four times the segments leave a sixth of it or less.
TEST(BeamAndBody, TipFollowsTheExactMotion) {
    double moment, finer_moment;
    const double largest = 2.0574e-3, error = error_of_tip(1, moment), finer = error_of_tip(4, finer_moment);
    EXPECT_LT(error, 2e-3 * largest);
    EXPECT_LT(finer, error / 6);
    EXPECT_NEAR(moment, 255.82, 0.01 * 255.82);
    EXPECT_NEAR(finer_moment, 255.82, 0.01 * 255.82);
}

/// Largest magnitude of a channel over a run.
double largest_of(const std::string& channel_name, const std::string& text) {
    const Plugins plugins;
    const Model model = parse_model("format = \"dttmm/1\"\n" + text, "model.toml", plugins.catalogue());
    Simulation simulation(model, plugins);
    const std::vector<Channel>& channels = simulation.channels();
    const auto channel = std::ranges::find(channels, channel_name, &Channel::name) - channels.begin();
    double largest = 0;
    simulation.record_to(
        [&](std::span<const double> row) { largest = std::max(largest, std::abs(row[static_cast<size_t>(channel)])); });
    while (simulation.index() < simulation.step_count()) simulation.step();
    return largest;
}

const std::string kSteel =
    "section = { circle = 0.04 }\nmaterial = { E = 210e9, poisson = 0.3, density = 7850, stiffness_damping = 2e-4 }\n";

const std::string kNodes = R"(
root = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
tip = [0.8, 0, 0])";

/// Largest force along z over `duration` of a hinge from the tip of a beam to `load`.
double largest_pull(double duration, double step, const std::string& nodes, const std::string& load_node,
                    const std::string& load, const std::string& stiffness, double damping = 0) {
    return largest_of("hinge.force.z", fmt::format(R"(
[simulation]
duration = {}
step = {}
gravity = [0, 0, -9.81]
[nodes]{}
{}
[[element]]
name = "arm"
type = "beam"
from = "root"
to = "tip"
segments = 16
section = {{ circle = 0.04 }}
material = {{ E = "210 GPa", poisson = 0.3, density = 7850, stiffness_damping = {} }}
[[element]]
name = "hinge"
type = "elastic_hinge"
from = "tip"
to = "{}"
stiffness = {}
)",
                                                   duration, step, nodes, load, damping, load_node, stiffness));
}

/// Of a body that swings down from the horizontal under a damped beam.
double largest_pull_of_a_swing(double step, const std::string& stiffness) {
    return largest_pull(1, step, kNodes, "load.eye", R"(
[[body]]
name = "load"
mass = 8
box = [0.1, 0.1, 0.1]
position = [0.95, 0, 0]
markers.eye = [-0.15, 0, 0])",
                        stiffness, 2e-4);
}

// Oracle: the same hinge rigid. k h²/m = 16 and 250: told by a matrix that has turned with the body, the port's force fed
// the hinge's own vibration until it came out twice and four times as large.
TEST(BeamAndBody, AStiffHingeUnderASwingingBodyIsNearlyRigid) {
    const double rigid = largest_pull_of_a_swing(0.25e-3, "{ ry = 'free' }");
    EXPECT_GT(rigid, 2 * 8 * 9.81);
    for (const double step : {0.25e-3, 1e-3})
        EXPECT_NEAR(largest_pull_of_a_swing(step, "{ x = 2e9, z = 2e9, ry = 'free' }"), rigid, 0.01 * rigid) << step;
}

// k h²/m = 1000 at 0.017 rad per step: every step is found, though the rounding of the network's forces is more than that of
// the body's place, and nothing rings. It did, by a quarter, with the matrix of t_n.
TEST(BeamAndBody, AStepTooCoarseForAHingeIsTakenAllTheSame) {
    const double rigid = largest_pull_of_a_swing(1e-3, "{ ry = 'free' }");
    EXPECT_NEAR(largest_pull_of_a_swing(2e-3, "{ x = 2e9, z = 2e9, ry = 'free' }"), rigid, 0.01 * rigid);
}

/// A body that hangs on a slide at the tip, swings and moves on: by ODE, and within the network.
struct Slide {
    double step;
    std::string stiffness;
};
void PrintTo(const Slide& slide, std::ostream* out) { *out << slide.stiffness << " at " << slide.step << " s"; }
class ABodyOnASlide : public testing::TestWithParam<Slide> {};

TEST_P(ABodyOnASlide, MovesInsideTheNetworkAsUnderOde) {
    const auto& [step, stiffness] = GetParam();
    const double by_ode = largest_pull(0.15, step, kNodes, "load.eye", R"(
[[body]]
name = "load"
mass = 8
box = [0.1, 0.1, 0.1]
position = [0.8, 0, -0.15]
velocity = [0.16, 0, 0]
markers.eye = [0, 0, 0.15])",
                                       stiffness);
    const double inside =
        largest_pull(0.15, step, kNodes + "\neye = { position = [0.8, 0, 0], velocity = [0.16, 0, 0] }", "eye", R"(
[[element]]
name = "load"
type = "rigid_body"
at = ["eye"]
mass = 8
center_of_mass = [0, 0, -0.15]
inertia = { xx = 0.013333333333333, yy = 0.013333333333333, zz = 0.013333333333333 })",
                     stiffness);
    EXPECT_GT(by_ode, 2 * 8 * 9.81);
    EXPECT_NEAR(inside, by_ode, 2e-3 * by_ode);
}

// Elastic, k h²/m = 25: within, the rate of convergence of a step that hardly moved was trusted in one that did, and the
// hinge's force came out twice as large. Rigid: the port's answer carries forces of any size.
INSTANTIATE_TEST_SUITE_P(BeamAndBody, ABodyOnASlide,
                         testing::Values(Slide{1e-3, "{ z = 2e8, x = 'free', ry = 'free' }"},
                                         Slide{0.25e-3, "{ x = 'free' }"}),
                         [](const auto& slide) { return "Case" + std::to_string(slide.index); });

// Oracle: the same rotor as ODE's. Within the network the passes left over what a hinge of 1e9 N/m made 6000 N of, 30 times
// what it carries: turning by 0.02 rad per step, they leave it over at another angle each time.
TEST(BeamAndBody, ARotorTurnsInsideTheNetworkAsUnderOde) {
    const auto text = [](const std::string& nodes, const std::string& rotor, const std::string& left,
                         const std::string& right) {
        return fmt::format(R"(
[simulation]
duration = 0.1
step = 1e-3
gravity = [0, 0, -9.81]
[nodes]
r1 = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
r2 = {{ position = [1, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
t1 = [0.4, 0, 0]
t2 = [0.6, 0, 0]
{}
{}
[[element]]
name = "b1"
type = "beam"
from = "r1"
to = "t1"
segments = 4
{}[[element]]
name = "b2"
type = "beam"
from = "r2"
to = "t2"
segments = 4
{}[[element]]
name = "hinge"
type = "elastic_hinge"
from = "t1"
to = "{}"
stiffness = {{ x = 1e9, y = 1e9, z = 1e9, rx = "free", ry = "free", rz = "free" }}
[[element]]
name = "h2"
type = "elastic_hinge"
from = "t2"
to = "{}"
stiffness = {{ x = "free", y = 1e9, z = 1e9, rx = "free", ry = "free", rz = "free" }}
)",
                           nodes, rotor, kSteel, kSteel, left, right);
    };
    const std::string inertia =
        "mass = 20\ninertia = { xx = 0.2, yy = 0.14, zz = 0.14 }\ncenter_of_mass = [0.1, 0, -0.001]\n";
    const std::string by_ode = text("", "[[body]]\nname = \"load\"\n" + inertia + R"(
position = [0.4, 0, 0]
angular_velocity = [20, 0, 0]
markers.left = [0, 0, 0]
markers.right = [0.2, 0, 0])",
                                    "load.left", "load.right");
    const std::string inside =
        text("left = { position = [0.4, 0, 0], angular_velocity = [20, 0, 0] }\nright = [0.6, 0, 0]",
             "[[element]]\nname = \"load\"\ntype = \"rigid_body\"\nat = [\"left\", \"right\"]\n" + inertia, "left", "right");
    for (const char* channel : {"hinge.force.y", "hinge.force.z"}) {
        const double expected = largest_of(channel, by_ode);
        EXPECT_NEAR(largest_of(channel, inside), expected, 0.01 * 200) << channel;
    }
}

/// A double pendulum of two uniform bars of 0.3 m that falls from the horizontal.
struct DoublePendulum {
    static constexpr double L = 0.3, c = 0.15, g = 9.81;
    double first_mass, second_mass;
    struct State {
        double angle[2], speed[2];
    };

    /// Angular accelerations by Lagrange's equations, angles from the horizontal down.
    std::array<double, 2> accelerations(const State& s) const {
        const double m = second_mass, J = 0.0075 * m, first_inertia = 0.0075 * first_mass, apart = s.angle[0] - s.angle[1];
        const double a = first_inertia + first_mass * c * c + m * L * L, b = m * L * c * std::cos(apart), d = J + m * c * c;
        const double p =
            (first_mass * c + m * L) * g * std::cos(s.angle[0]) - m * L * c * std::sin(apart) * s.speed[1] * s.speed[1];
        const double q = m * g * c * std::cos(s.angle[1]) + m * L * c * std::sin(apart) * s.speed[0] * s.speed[0];
        return {(p * d - q * b) / (a * d - b * b), (q * a - p * b) / (a * d - b * b)};
    }
    State moved(const State& s, const State& rate, double h) const {
        State next = s;
        for (int i : {0, 1}) {
            next.angle[i] += h * rate.angle[i];
            next.speed[i] += h * rate.speed[i];
        }
        return next;
    }
    State rate(const State& s) const {
        const std::array<double, 2> a = accelerations(s);
        return {{s.speed[0], s.speed[1]}, {a[0], a[1]}};
    }
    /// Of the hinge on the second bar, across the first.
    double force(const State& s) const {
        const std::array<double, 2> a = accelerations(s);
        double x = 0, z = g;
        const auto add = [&](double r, size_t i) {  // r e'' with e = (cos, −sin)
            x += r * (-a[i] * std::sin(s.angle[i]) - s.speed[i] * s.speed[i] * std::cos(s.angle[i]));
            z += r * (-a[i] * std::cos(s.angle[i]) + s.speed[i] * s.speed[i] * std::sin(s.angle[i]));
        };
        add(L, 0);
        add(c, 1);
        return second_mass * (x * std::sin(s.angle[0]) + z * std::cos(s.angle[0]));
    }
    /// By Runge and Kutta.
    double largest_force(double duration) const {
        constexpr double h = 1e-4;
        State s = {{0, 0}, {0, 0}};
        double largest = 0;
        for (double t = 0; t < duration; t += h) {
            const State k1 = rate(s), k2 = rate(moved(s, k1, 0.5 * h)), k3 = rate(moved(s, k2, 0.5 * h)),
                        k4 = rate(moved(s, k3, h));
            for (const auto& [k, weight] : {std::pair{k1, 1. / 6}, {k2, 1. / 3}, {k3, 1. / 3}, {k4, 1. / 6}})
                s = moved(s, k, weight * h);
            largest = std::max(largest, std::abs(force(s)));
        }
        return largest;
    }
};

/// Two bars on hinges, the upper of stiffness `above`, the lower of `below`; the second bar as given, its end `eye` on the
/// lower one.
double largest_pull_of_two_bars(double duration, double step, const std::string& above, const std::string& below,
                                double first_mass, const std::string& second, const std::string& eye,
                                const std::string& nodes = "") {
    return largest_of("hinge.force.z", fmt::format(R"(
[simulation]
duration = {}
step = {}
gravity = [0, 0, -9.81]
[nodes]
root = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
p = [0, 0, 0]
q = [0.3, 0, 0]
{}
{}
[[element]]
name = "first"
type = "rigid_body"
at = ["p", "q"]
mass = {}
center_of_mass = [0.15, 0, 0]
inertia = {{ xx = {}, yy = {}, zz = {} }}
[[element]]
name = "above"
type = "elastic_hinge"
from = "root"
to = "p"
stiffness = {}
[[element]]
name = "hinge"
type = "elastic_hinge"
from = "q"
to = "{}"
stiffness = {}
)",
                                                   duration, step, nodes, second, first_mass, 1e-4 * first_mass,
                                                   0.0075 * first_mass, 0.0075 * first_mass, above, eye, below));
}

/// Hinges about y; the lower one leaves to the upper what is not in the plane.
std::string upper_hinge(double k) { return fmt::format("{{ x = {}, z = {}, ry = 'free' }}", k, k); }
std::string lower_hinge(double k) {
    return fmt::format("{{ x = {}, z = {}, y = 'free', rx = 'free', ry = 'free', rz = 'free' }}", k, k);
}

std::string bar_of_ode(double mass) {
    return fmt::format(R"([[body]]
name = "second"
mass = {}
inertia = {{ xx = {}, yy = {}, zz = {} }}
position = [0.45, 0, 0]
markers.eye = [-0.15, 0, 0])",
                       mass, 1e-4 * mass, 0.0075 * mass, 0.0075 * mass);
}

std::string bar_of_the_network(double mass) {
    return fmt::format(R"([[element]]
name = "second"
type = "rigid_body"
at = ["eye", "end"]
mass = {}
center_of_mass = [0.15, 0, 0]
inertia = {{ xx = {}, yy = {}, zz = {} }})",
                       mass, 1e-4 * mass, 0.0075 * mass, 0.0075 * mass);
}

/// A tube, one end fixed, that carries a body: what differs from one to the other.
struct LoadedTube {
    std::string simulation, load, section, density;
    int segments;
};

/// Largest axial force at the root of a tube. nodes, body: the rest of the model; seat: what the tube ends on.
double largest_axial_force(const LoadedTube& tube, const std::string& nodes, const std::string& seat,
                           const std::string& body) {
    return largest_of("tube.force.x",
                      fmt::format(R"(
simulation = {{ {} }}
[nodes]
root = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
{}
{}
[[load]]
on = "body"
{}
[[element]]
name = "tube"
type = "beam"
from = "root"
to = "{}"
segments = {}
section = {{ tube = {} }}
material = {{ E = "210 GPa", poisson = 0.3, density = "{}" }}
)",
                                  tube.simulation, nodes, body, tube.load, seat, tube.segments, tube.section, tube.density));
}

// Oracle: the same body as an element inside the network, which has no ports: nothing is answered linearly there. Bending
// shortens a beam; what the change of its slopes δ in a step strains in second order, ½ EA δ², is up to a hundred times the
// axial force, and must not be told as one.
TEST(BeamAndBody, ABodyStruckAcrossPullsAlongItsBeamAsOneInsideTheNetwork) {
    const std::string inertia = "mass = 5\ninertia = { xx = 0.008, yy = 0.008, zz = 0.008 }\n";
    for (const auto& [segments, h, F] :
         {std::tuple{60, 0.5e-3, 1000.0}, {20, 1e-3, 150.0}, {40, 1e-3, 150.0}, {120, 1e-3, 100.0}}) {
        const LoadedTube tube = {fmt::format("duration = 0.4, step = {}", h),
                                 fmt::format("direction = [0, 0.2, 1]\nforce = {}", F), R"(["50 mm", "30 mm"])",
                                 "7850 kg/m^3", segments};
        const double by_ode =
            largest_axial_force(tube, "", "body", "[[body]]\nname = \"body\"\nposition = [1.2, 0, 0]\n" + inertia);
        const double inside =
            largest_axial_force(tube, "body = [1.2, 0, 0]", "body",
                                "[[element]]\nname = \"mass\"\ntype = \"rigid_body\"\nat = \"body\"\n" + inertia);
        EXPECT_NEAR(by_ode, inside, 0.05 * inside) << segments << " segments";
    }
}

// Oracle: likewise. What a trial left over of the motion inside, and a linear answer of a change of the ports, was small
// beside the bending, and yet fed the axial vibration, which nothing damps and the step does not follow: 1.2 % too much.
TEST(BeamAndBody, AKickedBodyRingsAlongItsBeamAsOneInsideTheNetwork) {
    const std::string inertia = "mass = 0.00104\ninertia = { xx = 4.0785e-9, yy = 5.6801e-9, zz = 7.6353e-9 }\n";
    for (const int segments : {10, 30}) {
        const LoadedTube tube = {"duration = 0.1431, step = 0.000265",
                                 "direction = [0.4, -0.8, -0.45]\nmoment = { type = \"haversine\", peak = 0.004, start = "
                                 "0.0105, width = 0.00186 }",
                                 R"(["1.5 mm", "0.624 mm"])", "755 kg/m^3", segments};
        const double by_ode = largest_axial_force(
            tube, "", "body.seat",
            "[[body]]\nname = \"body\"\nposition = [0.073, 0.001, -0.0015]\nmarkers.seat = [0, -0.001, 0.0015]\n" + inertia);
        const double inside = largest_axial_force(
            tube, "body = [0.073, 0, 0]", "body",
            "[[element]]\nname = \"mass\"\ntype = \"rigid_body\"\nat = \"body\"\ncenter_of_mass = [0, 0.001, -0.0015]\n" +
                inertia);
        EXPECT_NEAR(by_ode, inside, 0.005 * inside) << segments << " segments";
    }
}

// Oracle: the same with ideal hinges, and 6 % for what rings as the undamped ones are let go under 981 N and 9.81 N/kg.
// k h²/m = 1e4 and 2.5e5 at 0.01 rad per step: with the matrix of t_n, and the linear answer to the port, the lower hinge
// came out 3.5 times too large, or the step was not found.
TEST(BeamAndBody, ALightBodyOnAStiffHingeThatTurnsIsPulledAsByAnIdealOne) {
    for (const auto& [mass, step] : {std::pair{1., 1e-3}, {1., 0.5e-3}, {0.01, 0.5e-3}}) {
        const double ideal = DoublePendulum{100, mass}.largest_force(0.5);
        EXPECT_GT(ideal, 70 * mass);
        EXPECT_NEAR(
            largest_pull_of_two_bars(0.5, step, upper_hinge(1e10), lower_hinge(1e10), 100, bar_of_ode(mass), "second.eye"),
            ideal, 0.08 * ideal)
            << mass << " kg at " << step << " s";
    }
}

// Oracle: likewise, both within the network, and 14 % for what rings. A rate of convergence measured with a matrix of one
// step was trusted in the next, which was then taken unsolved: the hinge rang for ever with 5 to 70 times its force, at some
// steps only.
TEST(BeamAndBody, TwoBarsOnStiffHingesInsideANetworkPullAsOnIdealOnes) {
    const double ideal = DoublePendulum{1, 1}.largest_force(0.5);
    for (const double k : {1e10, 1e11})
        for (const double step : {0.25e-3, 0.125e-3, 0.05e-3})
            EXPECT_NEAR(largest_pull_of_two_bars(0.5, step, upper_hinge(k), lower_hinge(k), 1, bar_of_the_network(1), "eye",
                                                 "eye = [0.3, 0, 0]\nend = [0.6, 0, 0]"),
                        ideal, 0.2 * ideal)
                << k << " N/m at " << step << " s";
}

// A bar that nothing but its inertia keeps from turning about itself, beside hinges that hold it with 1e21 times that over
// the long step by which static stiffnesses are found: it was refused as held by nothing.
TEST(BeamAndBody, ABarBetweenBallHingesMayTurnAboutItself) {
    const std::string ball = "{ x = 1e8, y = 1e8, z = 1e8, rx = 'free', ry = 'free', rz = 'free' }";
    const double ideal = DoublePendulum{1, 1}.largest_force(0.2);
    for (const double step : {0.5e-3, 0.1e-3})
        EXPECT_NEAR(largest_pull_of_two_bars(0.2, step, ball, ball, 1, bar_of_ode(1), "second.eye"), ideal, 0.2 * ideal)
            << step;
}

// Oracle: the hinge at a step so small that it does not matter. What the passes left over, within the share of the largest
// force of the network, 120 N, rang in a hinge that carries 0.3 N: 11 N at 1 ms, 8.5 N at 0.25 ms.
TEST(BeamAndBody, AHingeThatCarriesLittleDoesNotRingWithTheRestOfTheNetwork) {
    const auto pull = [](double step) {
        return largest_pull(0.3, step, kNodes, "load.eye", R"(
[[body]]
name = "load"
mass = 0.01
box = [0.1, 0.1, 0.1]
position = [0.95, 0, 0]
markers.eye = [-0.15, 0, 0])",
                            "{ x = 1e10, z = 1e10, ry = 'free' }", 2e-4);
    };
    const double fine = pull(0.1e-3);
    for (const double step : {1e-3, 0.25e-3}) EXPECT_NEAR(pull(step), fine, 0.1 * fine) << step;
}

// Oracle: m ω² r = 4.72 N, and that again where it sets in at once. The first step took the linear answer to the ports at
// whatever distance: a smaller step was worse than a larger one, 723 N at 2 ms.
TEST(BeamAndBody, TwoBodiesThatSpinAsOnePullByTheirInertia) {
    for (const double step : {4e-3, 2e-3, 1e-3}) {
        const double pull = largest_of("arm.force.x", fmt::format(R"(
[simulation]
duration = 0.1
step = {}
[[body]]
name = "first"
mass = 5
inertia = {{ xx = 0.005, yy = 0.005, zz = 0.005 }}
velocity = [0, -0.47170596918222313, 0]
angular_velocity = [0, 0, 2]
[[body]]
name = "second"
mass = 5
inertia = {{ xx = 0.005, yy = 0.005, zz = 0.005 }}
position = [0.5, 0, 0]
velocity = [0, 0.5282940308177768, 0]
angular_velocity = [0, 0, 2]
markers.eye = [-0.1, 0, 0]
[[element]]
name = "arm"
type = "beam"
from = "first"
to = "second.eye"
segments = 6
{})",
                                                                  step, kSteel));
        EXPECT_GT(pull, 4.72) << step;
        EXPECT_LT(pull, 2 * 4.72) << step;
    }
}

}  // namespace
}  // namespace dttmm::host
