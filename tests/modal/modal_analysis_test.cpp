// SPDX-License-Identifier: BSD-3-Clause
#include "modal/modal_analysis.h"
#include "modal/respond_at.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <numbers>
#include <random>

#include "core/error.h"
#include "support/exact_timoshenko.h"
#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

using test::NetworkModel;
using testing::HasSubstr;
constexpr double kPi = std::numbers::pi;
constexpr uint32_t kAllDirections = 0b111111, kHeld = 0b111111, kPlane = 0b100011;

/// A machine of a network alone, with its modes.
class Machine {
public:
    explicit Machine(const NetworkModel& network, uint32_t directions = kAllDirections)
        : network_(network.description()), analysis_(model(directions)) {}

    std::vector<dttmm_mode> find(uint32_t count, double below = 0) {
        std::vector<dttmm_mode> modes(analysis_.find_modes(count, below));
        for (uint32_t m = 0; m < modes.size(); ++m) analysis_.mode(m, &modes[m], nullptr, nullptr, nullptr);
        return modes;
    }
    /// 6 per node.
    Eigen::MatrixXd shape(uint32_t mode) {
        Eigen::MatrixXd nodes(6, network_.node_count);
        analysis_.mode(mode, nullptr, nullptr, nodes.data(), nullptr);
        return nodes;
    }
    std::vector<double> shares(uint32_t mode) {
        std::vector<double> shares(network_.element_count);
        analysis_.mode(mode, nullptr, nullptr, nullptr, shares.data());
        return shares;
    }
    Eigen::MatrixXd along(uint32_t mode, uint32_t element, uint32_t stations) {
        Eigen::MatrixXd shape(6, stations);
        length_ = analysis_.along(mode, element, stations, shape.data());
        return shape;
    }
    double length() const { return length_; }  ///< of the line last looked along
    /// Displacement of a node per unit wrench on another, in the world's axes.
    std::complex<double> respond(double hertz, int in, int in_direction, int out, int out_direction) {
        const std::vector<double> nodes = respond_at(analysis_, hertz, in, Vector6::Unit(in_direction), network_.node_count);
        const auto at = static_cast<size_t>(12 * out + 2 * out_direction);
        return {nodes[at], nodes[at + 1]};
    }

private:
    dttmm_modal_model model(uint32_t directions) const { return {&network_, 0, nullptr, directions, 0, nullptr}; }
    dttmm_network network_;
    ModalAnalysis analysis_;
    double length_ = 0;
};

/// An Euler beam along x with another stiffness in either plane, or Timoshenko's.
NetworkModel::Values bar(bool is_timoshenko = false) {
    NetworkModel::Values values = {{"theory", {is_timoshenko ? 1.0 : 0.0}},
                                   {"section.EA", {4e8}},
                                   {"section.EIy", {3e5}},
                                   {"section.EIz", {7e5}},
                                   {"section.GJ", {2e5}},
                                   {"section.mass", {16}},
                                   {"section.inertia", {0.05}}};
    if (is_timoshenko) values["section.GAy"] = {6e7}, values["section.GAz"] = {9e7};
    return values;
}
constexpr double kBeamLength = 2, kMass = 16 * kBeamLength, kEIz = 7e5;

NetworkModel beam(uint32_t fixed_at_start, uint32_t fixed_at_end, bool is_timoshenko = false) {
    NetworkModel network;
    network.node("a", DTTMM_NODE_INNER, {0.3, 0, 0}).fixed = fixed_at_start;
    network.node("b", DTTMM_NODE_INNER, {0.3 + kBeamLength, 0, 0}).fixed = fixed_at_end;
    network.element("beam", "beam", {"a", "b"}, bar(is_timoshenko));
    return network;
}

double euler(double beta_l) { return beta_l * beta_l / (2 * kPi * kBeamLength * kBeamLength) * std::sqrt(kEIz / 16); }

// ---- What a mode says ---------------------------------------------------------------------------------------------------

/// Three bodies in space on springs, one of them to the ground: eighteen modes, no direction without mass, none held.
NetworkModel cluster() {
    NetworkModel network;
    network.node("ground", DTTMM_NODE_GROUND, {0, 0, 0});
    const Eigen::Vector3d at[] = {{0, 0, 0}, {0.4, 0.1, -0.2}, {0.5, -0.3, 0.3}};
    for (int b = 0; b < 3; ++b) {
        const std::string name = fmt::format("n{}", b);
        network.node(name, DTTMM_NODE_INNER, at[b]);
        network.element("body" + name, "rigid_body", {name},
                        {{"mass", {2.0 + b}},
                         {"center_of_mass", {0.05 * b, 0.03, -0.02}},
                         {"inertia.xx", {0.02}},
                         {"inertia.yy", {0.03}},
                         {"inertia.zz", {0.04 + 0.005 * b}},
                         {"inertia.xy", {0.004}}});
        network.element("spring" + name, "spring_damper", {b == 0 ? "ground" : fmt::format("n{}", b - 1), name},
                        {{"stiffness", {3e4, 5e4, 7e4 + 1e4 * b}}, {"rotational_stiffness", {200, 300, 500}}});
    }
    return network;
}

/// A stiff and a soft oscillator of a kilogram each.
NetworkModel two_oscillators(double stiff, double soft) {
    NetworkModel network;
    network.node("ground", DTTMM_NODE_GROUND, {0, 0, 0});
    for (const auto& [name, stiffness] : {std::pair("a", stiff), std::pair("b", soft)}) {
        network.node(name, DTTMM_NODE_INNER, {0.3, 0, 0}).fixed = 0b111110;
        network.element(std::string("spring ") + name, "spring_damper", {"ground", name},
                        {{"stiffness", {stiffness, 0, 0}}});
        network.element(std::string("mass ") + name, "point_mass", {name}, {{"mass", {1}}});
    }
    return network;
}

// Oracle: √(k/m). What follows holds the limits between 0.8 and 1.25 times themselves: at half and at twice a line fails.
TEST(ModalAnalysis, FrequenciesWithinTwoBillionthsCountAsEqual) {
    for (const auto& [apart, multiplicity] : {std::pair(1.6e-9, 2u), std::pair(2.5e-9, 1u)}) {
        const std::vector<dttmm_mode> modes = Machine(two_oscillators(5e4, 5e4 * (1 + apart) * (1 + apart))).find(2);
        ASSERT_EQ(modes.size(), 2u);
        EXPECT_EQ(modes[0].multiplicity, multiplicity) << apart;
        for (const double k : {0., 1.})
            EXPECT_NEAR(modes[static_cast<size_t>(k)].frequency, (1 + k * apart) * std::sqrt(5e4) / (2 * kPi), 1e-10) << k;
    }
}
TEST(ModalAnalysis, ASlowVibrationIsFoundRefusedOrFree) {
    const double stiffest = 5e4 / 2;  // over the whole mass
    const auto slowest = [&](double share) {
        return Machine(two_oscillators(5e4, share * stiffest)).find(1).front().frequency;
    };
    EXPECT_EQ(slowest(0.8e-16), 0) << "1e-4 of rounding";
    EXPECT_THROW(slowest(1.25e-16), Error);
    EXPECT_THROW(slowest(0.8e-12), Error);
    EXPECT_NEAR(slowest(1.25e-12), std::sqrt(1.25e-12 * stiffest) / (2 * kPi), 1e-9) << "rounding is 1e-12";
}

// Oracle: Σ (φᵀ M r)²/φᵀ M φ over a whole basis is rᵀ M r, for every direction.
TEST(ModalAnalysis, ParticipationOfAllModesIsWhole) {
    const NetworkModel network = cluster();
    Machine machine(network);
    const std::vector<dttmm_mode> modes = machine.find(18);
    ASSERT_EQ(modes.size(), 18u);
    for (int d = 0; d < 6; ++d) {
        double sum = 0;
        for (const dttmm_mode& mode : modes) {
            EXPECT_GE(mode.participation[d], 0);
            sum += mode.participation[d];
        }
        EXPECT_NEAR(sum, 1, 1e-9) << d;
    }
}

// Oracle: energy is somewhere, and of two springs in series it goes with the square of what they give: φ = (√5 + 1)/2.
TEST(ModalAnalysis, SharesOfStrainEnergySumToOne) {
    const NetworkModel network = cluster();
    Machine machine(network);
    machine.find(18);
    for (uint32_t m = 0; m < 18; ++m) {
        double sum = 0;
        for (const double share : machine.shares(m)) {
            EXPECT_GE(share, 0) << m;
            sum += share;
        }
        EXPECT_NEAR(sum, 1, 1e-12) << m;
    }

    NetworkModel two;
    two.node("ground", DTTMM_NODE_GROUND, {0, 0, 0});
    two.node("a", DTTMM_NODE_INNER, {0, 0, 0});
    two.node("b", DTTMM_NODE_INNER, {1, 0, 0});
    two.element("first", "spring_damper", {"ground", "a"}, {{"stiffness", {12}}});
    two.element("one", "point_mass", {"a"}, {{"mass", {3}}});
    two.element("second", "spring_damper", {"a", "b"}, {{"stiffness", {12}}});
    two.element("two", "point_mass", {"b"}, {{"mass", {3}}});
    Machine chain(two, 0b000001);
    const std::vector<dttmm_mode> modes = chain.find(2);
    ASSERT_EQ(modes.size(), 2u);
    const double golden = (std::sqrt(5.) + 1) / 2;
    const auto share = [](double first, double second) { return first * first / (first * first + second * second); };
    EXPECT_THAT(chain.shares(0),
                testing::Pointwise(testing::DoubleNear(1e-10), {share(1, golden - 1), 0.0, share(golden - 1, 1), 0.0}));
    EXPECT_THAT(chain.shares(1),
                testing::Pointwise(testing::DoubleNear(1e-10), {share(1, golden), 0.0, share(golden, 1), 0.0}));
    // Largest displacement 1: masses 3 (1 + 1/φ²), and (Σ m u)²/(m Σ u² · 6)
    for (const dttmm_mode& mode : modes) EXPECT_NEAR(mode.mass, 3 * (1 + 1 / (golden * golden)), 1e-9);
    EXPECT_NEAR(modes[0].participation[0], 9 * golden * golden / (6 * 3 * (1 + 1 / (golden * golden))), 1e-9);
}

// Oracle: the cantilever's closed form: modal mass ml/4 with its tip at 1; effective masses (2σ/βl)²; and all its energy is
// in the one beam.
TEST(ModalAnalysis, CantileverHasItsModalAndEffectiveMasses) {
    const NetworkModel network = beam(kHeld, 0);
    Machine machine(network, kPlane);
    const std::vector<dttmm_mode> modes = machine.find(3);
    const double beta_l[] = {1.8751040687119611, 4.6940911329741746, 7.8547574382376126};
    ASSERT_EQ(modes.size(), 3u);
    for (uint32_t m = 0; m < 3; ++m) {
        const double b = beta_l[m], sigma = (std::cosh(b) + std::cos(b)) / (std::sinh(b) + std::sin(b));
        EXPECT_NEAR(modes[m].frequency / euler(b), 1, 1e-9);
        EXPECT_NEAR(modes[m].mass, kMass / 4, 1e-8 * kMass) << m;
        const double effective = std::pow(2 * sigma / b, 2);
        EXPECT_NEAR(modes[m].participation[1], effective, 1e-8) << m;
        EXPECT_NEAR(modes[m].participation[0], 0, 1e-12);
        EXPECT_NEAR(machine.shares(m)[0], 1, 1e-12);
    }
}

// Oracle: by hand. Where rotations are left out a rod turns like a bar about its pin on the ground, on a spring across at
// its other end: m/3 there, and the mass that takes part is (m/2)²/(m/3) = 3/4 m.
TEST(ModalAnalysis, ARodBetweenPinsIsABarAcross) {
    NetworkModel network;
    network.node("pin", DTTMM_NODE_GROUND, {0.2, 0.1, 0});
    network.node("tip", DTTMM_NODE_INNER, {0.9, 0.1, 0});
    network.node("anchor", DTTMM_NODE_GROUND, {0.9, 0.1, 0});
    network.element("rod", "rod", {"pin", "tip"}, {{"section.EA", {7e7}}, {"section.mass", {2.5}}});
    network.element("spring", "spring_damper", {"anchor", "tip"}, {{"stiffness", {0, 900, 0}}});
    Machine machine(network, 0b000010);
    const std::vector<dttmm_mode> modes = machine.find(1);
    ASSERT_EQ(modes.size(), 1u);
    const double third = 2.5 * 0.7 / 3;
    EXPECT_NEAR(modes[0].frequency * 2 * kPi, std::sqrt(900 / third), 1e-9 * std::sqrt(900 / third));
    EXPECT_NEAR(modes[0].mass, third, 1e-12);
    EXPECT_NEAR(modes[0].participation[1], 0.75, 1e-9);
}

// Oracle: of the beam on two pins the largest displacement is between its nodes: φ = sin nπx/l, modal mass ml/2.
TEST(ModalAnalysis, TheLargestDisplacementMayLieInsideABeam) {
    for (const uint32_t count : {1u, 5u}) {
        const NetworkModel network = beam(0b000011, 0b000011);
        Machine machine(network, 0b100010);
        const std::vector<dttmm_mode> modes = machine.find(count);
        ASSERT_EQ(modes.size(), count);
        for (uint32_t m = 0; m < count; ++m) {
            EXPECT_NEAR(modes[m].frequency / euler((m + 1) * kPi), 1, 1e-9);
            EXPECT_NEAR(modes[m].mass, kMass / 2, 0.02 * kMass) << m;
            EXPECT_NEAR(machine.along(m, 0, 401).row(1).cwiseAbs().maxCoeff(), 1, 0.02) << m;
        }
    }
}

// ---- Shapes -------------------------------------------------------------------------------------------------------------

// Oracle: Euler's cantilever, cosh − cos − σ (sinh − sin), 1 at its tip.
TEST(ModalAnalysis, ShapesAlongABeamAreItsClosedForm) {
    const NetworkModel network = beam(kHeld, 0);
    Machine machine(network, kPlane);
    machine.find(3);
    const double beta_l[] = {1.8751040687119611, 4.6940911329741746, 7.8547574382376126};
    constexpr uint32_t kStations = 17;
    for (uint32_t m = 0; m < 3; ++m) {
        const double b = beta_l[m], sigma = (std::cosh(b) + std::cos(b)) / (std::sinh(b) + std::sin(b));
        const Eigen::MatrixXd found = machine.along(m, 0, kStations);
        EXPECT_NEAR(machine.length(), kBeamLength, 1e-15);
        const auto shape = [&](double x) { return std::cosh(x) - std::cos(x) - sigma * (std::sinh(x) - std::sin(x)); };
        const auto slope = [&](double x) {
            return b / kBeamLength * (std::sinh(x) + std::sin(x) - sigma * (std::cosh(x) - std::cos(x)));
        };
        const double sign = found(1, kStations - 1) / shape(b);
        EXPECT_NEAR(std::abs(found(1, kStations - 1)), 1, 1e-12);
        for (uint32_t k = 0; k < kStations; ++k) {
            const double x = b * k / (kStations - 1.0);
            EXPECT_NEAR(found(1, k), sign * shape(x), 1e-8) << m << ", " << k;
            EXPECT_NEAR(found(5, k), sign * slope(x), 1e-7) << m << ", " << k;
        }
        // The ends are those of the nodes
        EXPECT_LT((found.col(kStations - 1) - machine.shape(m).col(1)).norm(), 1e-9);
        EXPECT_LT(found.col(0).norm(), 1e-9);
    }
}

// Oracle: the free Timoshenko beam in extended precision (exact_timoshenko.h), turned in space: shapes are in world axes.
TEST(ModalAnalysis, ShapesAreInTheWorldsAxes) {
    NetworkModel network = beam(0, 0, true);
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.8, Eigen::Vector3d(1, -2, 0.5).normalized()).toRotationMatrix();
    // Turned with its y: without `up` z would turn back to the world's
    NetworkModel turned;
    turned.node("a", DTTMM_NODE_INNER, turn * Eigen::Vector3d(0.3, 0, 0));
    turned.node("b", DTTMM_NODE_INNER, turn * Eigen::Vector3d(0.3 + kBeamLength, 0, 0));
    NetworkModel::Values values = bar(true);
    const Eigen::Vector3d z = turn.col(2);
    values["up"] = {z.x(), z.y(), z.z()};
    turned.element("beam", "beam", {"a", "b"}, values);

    const test::ExactTimoshenko exact{7e5, 6e7, 16, 16 * 7e5 / 4e8, kBeamLength};
    const double omega = exact.free_frequencies(1, 100)[0];
    Machine straight(network), askew(turned);
    const std::vector<dttmm_mode> modes = straight.find(8), same = askew.find(8);
    ASSERT_EQ(modes.size(), 8u);
    ASSERT_EQ(same.size(), 8u);
    EXPECT_NEAR(modes[7].frequency / (omega / (2 * kPi)), 1, 1e-9) << "the second, in the stiffer plane";
    const Eigen::MatrixXd one = straight.along(7, 0, 9), other = askew.along(7, 0, 9);
    const double sign = one.col(0).dot((Eigen::VectorXd(6) << turn.transpose() * other.col(0).head<3>(),
                                        turn.transpose() * other.col(0).tail<3>())
                                           .finished()) > 0
                            ? 1
                            : -1;
    for (int k = 0; k < 9; ++k) {
        EXPECT_NEAR(one(1, k) / one(1, 0), exact.free_shape(omega, kBeamLength * k / 8) / exact.free_shape(omega, 0), 1e-7)
            << k;
        EXPECT_LT((turn * one.col(k).head<3>() - sign * other.col(k).head<3>()).norm(), 1e-7) << k;
        EXPECT_LT((turn * one.col(k).tail<3>() - sign * other.col(k).tail<3>()).norm(), 1e-6) << k;
    }
}

// Oracle: ∫ μ u·v ds over all arms by Simpson's rule: no two modes of the double cross, equal or not, have mass between
// them, and each has its modal mass. Simpson's error is 1e-7 of it with 200 stations for at most two waves.
TEST(ModalAnalysis, EqualModesAreAtRightAnglesByMass) {
    NetworkModel network;
    network.node("hub", DTTMM_NODE_INNER, {0, 0, 0});
    const double side = 0.125, A = side * side, mu = 8000 * A;
    for (int arm = 0; arm < 8; ++arm) {
        const std::string end = fmt::format("end{}", arm);
        network.node(end, DTTMM_NODE_INNER, {5 * std::cos(arm * kPi / 4), 5 * std::sin(arm * kPi / 4), 0}).fixed = 0b000011;
        network.element(fmt::format("arm{}", arm), "beam", {"hub", end},
                        {{"theory", {0}},
                         {"section.rectangle", {side, side}},
                         {"material.E", {200e9}},
                         {"material.poisson", {0.3}},
                         {"material.density", {8000}}});
    }
    Machine machine(network, kPlane);
    const std::vector<dttmm_mode> modes = machine.find(0, 60);
    ASSERT_EQ(modes.size(), 16u);
    constexpr uint32_t kStations = 201;
    std::vector<Eigen::MatrixXd> shapes;  // a column per mode, all arms below each other, weighted
    Eigen::MatrixXd all(8 * 2 * kStations, 16);
    for (uint32_t m = 0; m < 16; ++m)
        for (uint32_t arm = 0; arm < 8; ++arm) {
            const Eigen::MatrixXd u = machine.along(m, arm, kStations);
            for (uint32_t k = 0; k < kStations; ++k) {
                const double weight = (k == 0 || k + 1 == kStations ? 1 : k % 2 ? 4 : 2) * 5.0 / (kStations - 1) / 3;
                all.block<2, 1>(2 * (arm * kStations + k), m) = std::sqrt(mu * weight) * u.col(k).head<2>();
            }
        }
    Eigen::MatrixXd M = all.transpose() * all;
    for (int i = 0; i < 16; ++i) {
        EXPECT_NEAR(M(i, i), modes[static_cast<size_t>(i)].mass, 1e-6 * M(i, i)) << i;
        for (int j = 0; j < i; ++j) EXPECT_LT(std::abs(M(i, j)), 1e-6 * std::sqrt(M(i, i) * M(j, j))) << i << ", " << j;
    }
}

// Oracle: masses on springs of their own, of frequencies that differ by all between 1e-10 and 1e-6 of themselves.
TEST(ModalAnalysis, NearlyEqualFrequenciesAreAllFoundInTheirPlaces) {
    std::mt19937 engine(5);
    std::uniform_real_distribution<double> uniform(0, 1);
    for (int machine = 0; machine < 40; ++machine) {
        NetworkModel network;
        network.node("ground", DTTMM_NODE_GROUND, {0, 0, 0});
        std::vector<double> wanted;
        for (int i = 0; i < 4; ++i) {
            const std::string name = fmt::format("m{}", i);
            const double mass = 1 + 5 * uniform(engine);
            std::vector<double> stiffness;
            for (int d = 0; d < 3; ++d) {
                const double beside = std::pow(10, -10 + 4 * uniform(engine));
                stiffness.push_back(2e5 * mass * (1 + beside));
                wanted.push_back(std::sqrt(stiffness.back() / mass) / (2 * kPi));
            }
            network.node(name, DTTMM_NODE_INNER, {0, 0, 0});
            network.element("mass" + name, "point_mass", {name}, {{"mass", {mass}}});
            network.element("spring" + name, "spring_damper", {"ground", name}, {{"stiffness", stiffness}});
        }
        std::ranges::sort(wanted);
        const std::vector<dttmm_mode> modes = Machine(network, 0b000111).find(12);
        ASSERT_EQ(modes.size(), 12u);
        for (size_t m = 0; m < 12; ++m) {
            EXPECT_NEAR(modes[m].frequency, wanted[m], 3e-12 * wanted[m]) << machine << ", mode " << m;
        }
    }
}

// Oracle: the frequencies of a cantilever go with √EI; those of its two planes differ by 4e-6 of themselves.
TEST(ModalAnalysis, NearlyEqualFrequenciesOfABeamAreAsNearAsOthers) {
    NetworkModel network;
    network.node("a", DTTMM_NODE_INNER, {0, 0, 0}).fixed = kHeld;
    network.node("b", DTTMM_NODE_INNER, {kBeamLength, 0, 0});
    NetworkModel::Values values = bar();
    values["section.EIy"] = {kEIz * (1 + 8e-6)};
    network.element("beam", "beam", {"a", "b"}, values);
    const std::vector<dttmm_mode> modes = Machine(network).find(0, 2000);
    const auto is_bending = [](const dttmm_mode& mode) {
        return mode.participation[1] > 1e-6 || mode.participation[2] > 1e-6;
    };
    int pairs = 0;
    for (size_t m = 0; m + 1 < modes.size(); ++m) {
        if (!is_bending(modes[m])) continue;
        EXPECT_NEAR(modes[m + 1].frequency / modes[m].frequency, std::sqrt(1 + 8e-6), 1e-12) << modes[m].frequency;
        EXPECT_LT(modes[m].bracket, 1e-10) << modes[m].frequency;
        ++m, ++pairs;
    }
    EXPECT_GE(pairs, 5);
}

// Oracle: a free machine's six zeros span its rigid motions: they move all of its mass, and strain nothing.
TEST(ModalAnalysis, RigidModesMoveAllTheMass) {
    const NetworkModel network = beam(0, 0);
    Machine machine(network);
    const std::vector<dttmm_mode> modes = machine.find(7);
    ASSERT_GE(modes.size(), 7u);
    for (int d = 0; d < 6; ++d) {
        double sum = 0;
        for (int m = 0; m < 6; ++m) sum += modes[static_cast<size_t>(m)].participation[d];
        EXPECT_NEAR(sum, 1, 1e-7) << d;  // found a little beside zero
        EXPECT_EQ(modes[static_cast<size_t>(d)].frequency, 0);
        EXPECT_NEAR(modes[6].participation[d], 0, 1e-9);
    }
    for (uint32_t m = 0; m < 6; ++m) {
        const Eigen::MatrixXd u = machine.shape(m);
        const Eigen::Vector3d turn = u.col(0).tail<3>(), arm(kBeamLength, 0, 0);
        EXPECT_LT((u.col(1).tail<3>() - turn).norm(), 1e-8);
        EXPECT_LT((u.col(1).head<3>() - u.col(0).head<3>() - turn.cross(arm)).norm(), 1e-8);
        EXPECT_EQ(machine.shares(m)[0], 0);
    }
}

// ---- Response -----------------------------------------------------------------------------------------------------------

// Oracle: Euler's cantilever under a force at its tip, undamped: (C s − S c)/(β³ EI (1 + c C)), far below, between and far
// above its frequencies; and l³/3EI at rest.
TEST(ModalAnalysis, ReceptanceOfACantileverAtItsTip) {
    const NetworkModel network = beam(kHeld, 0);
    Machine machine(network, kPlane);
    for (const double hertz : {5.0, 100.0, 430.0, 2500.0}) {
        const double beta = std::pow(16 * std::pow(2 * kPi * hertz, 2) / kEIz, 0.25), L = beta * kBeamLength;
        const double expected = (std::cosh(L) * std::sin(L) - std::sinh(L) * std::cos(L)) /
                                (beta * beta * beta * kEIz * (1 + std::cos(L) * std::cosh(L)));
        const std::complex<double> found = machine.respond(hertz, 1, 1, 1, 1);
        EXPECT_NEAR(found.real() / expected, 1, 1e-8) << hertz;
        EXPECT_EQ(found.imag(), 0) << hertz;
    }
    const double at_rest = std::pow(kBeamLength, 3) / (3 * kEIz);
    EXPECT_NEAR(machine.respond(0, 1, 1, 1, 1).real() / at_rest, 1, 1e-10);
    EXPECT_NEAR(machine.respond(0, 1, 1, 1, 5).real() / (1.5 * at_rest / kBeamLength), 1, 1e-10) << "its slope";
}

// Oracle: Maxwell and Betti: what a force at one place and direction does at another is what it does the other way round.
TEST(ModalAnalysis, ResponsesAreReciprocal) {
    NetworkModel network = cluster();
    Machine machine(network);
    for (const double hertz : {3.0, 21.0, 200.0})
        for (const auto& [i, j] : {std::pair(0, 4), std::pair(2, 1), std::pair(5, 3)}) {
            const std::complex<double> one = machine.respond(hertz, 1, i, 3, j), other = machine.respond(hertz, 3, j, 1, i);
            EXPECT_NEAR(one.real(), other.real(), 1e-9 * std::abs(one) + 1e-18) << hertz;
            EXPECT_GT(std::abs(one), 0) << hertz;
        }
}

// Oracle: the same as before. A response higher than the modes looks at more pieces, and takes nothing from the modes.
TEST(ModalAnalysis, ModesStandAfterAResponse) {
    const NetworkModel network = beam(kHeld, 0);
    Machine machine(network);
    const std::vector<dttmm_mode> before = machine.find(4);
    const Eigen::MatrixXd shape = machine.shape(2), along = machine.along(3, 0, 11);
    machine.respond(50 * before[3].frequency, 1, 1, 1, 1);
    EXPECT_LT((machine.shape(2) - shape).norm(), 1e-12);
    EXPECT_LT((machine.along(3, 0, 11) - along).norm(), 1e-12);
    machine.respond(0.5 * before[3].frequency, 1, 1, 1, 1);
    EXPECT_LT((machine.along(3, 0, 11) - along).norm(), 1e-12);
}

TEST(ModalAnalysis, AResponseAtAnUndampedFrequencyIsRefused) {
    NetworkModel network;
    network.node("ground", DTTMM_NODE_GROUND, {0, 0, 0});
    network.node("a", DTTMM_NODE_INNER, {0, 0, 0});
    network.element("spring", "spring_damper", {"ground", "a"}, {{"stiffness", {4}}});
    network.element("mass", "point_mass", {"a"}, {{"mass", {1}}});
    Machine machine(network, 0b000001);
    // At rest a spring has its compliance; a mass that nothing holds has none
    EXPECT_NEAR(machine.respond(0, 1, 0, 1, 0).real(), 0.25, 1e-15);
    const NetworkModel loose = beam(0, 0);
    Machine free(loose);
    try {
        free.respond(0, 1, 1, 1, 1);
        FAIL() << "a free beam has no static deflection";
    } catch (const Error& error) {
        EXPECT_EQ(error.status(), DTTMM_ERROR_SINGULAR);
        EXPECT_THAT(error.what(), HasSubstr("0 Hz: the machine is free to move in"));
    }
}

// Oracle: by hand. Two masses on one slow spring, free, looked at up to 100 kHz: as one they move equally, 1 + 2 kg, and the
// spring's motion of √(k (1/1 + 1/2)) stays out of it.
TEST(ModalAnalysis, ASlowModeStaysOutOfTheRigidShapes) {
    NetworkModel network;
    network.node("a", DTTMM_NODE_INNER, {0, 0, 0});
    network.node("b", DTTMM_NODE_INNER, {1, 0, 0});
    network.element("spring", "spring_damper", {"a", "b"}, {{"stiffness", {1}}});
    network.element("one", "point_mass", {"a"}, {{"mass", {1}}});
    network.element("two", "point_mass", {"b"}, {{"mass", {2}}});
    Machine machine(network, 0b000001);
    const std::vector<dttmm_mode> modes = machine.find(0, 1e5);
    ASSERT_EQ(modes.size(), 2u);
    EXPECT_EQ(modes[0].frequency, 0);
    EXPECT_NEAR(modes[0].mass, 3, 1e-6);
    EXPECT_NEAR(modes[0].participation[0], 1, 1e-6);
    EXPECT_NEAR(machine.shape(0)(0, 0), machine.shape(0)(0, 1), 1e-6);
    EXPECT_NEAR(modes[1].frequency, std::sqrt(1.5) / (2 * kPi), 1e-9);
}

// ---- What rounding hides ------------------------------------------------------------------------------------------------

/// Three masses of 0.5 kg in a row: 0.5 N/m to the ground, `stiff`, 100 N/m.
NetworkModel stiff_row(double stiff) {
    NetworkModel network;
    network.node("ground", DTTMM_NODE_GROUND, {0, 0, 0});
    const double k[] = {0.5, stiff, 100};
    for (int i = 0; i < 3; ++i) {
        const std::string name = fmt::format("n{}", i);
        network.node(name, DTTMM_NODE_INNER, {i + 1.0, 0, 0});
        network.element("spring" + name, "spring_damper", {i == 0 ? "ground" : fmt::format("n{}", i - 1), name},
                        {{"stiffness", {k[i], 0, 0}}});
        network.element("mass" + name, "point_mass", {name}, {{"mass", {0.5}}});
    }
    return network;
}

// Oracle: the two slow frequencies of the row with its stiff spring rigid, (0.5 − λ, ...): λ² · 0.5 − λ (0.5 · 100.5 + 100)
// + 50 = 0 of masses 1 and 0.5 kg. Beside 1e9 N/m the count tells them; beside 1e12 N/m it cannot, and says so: a slow
// spring is no rigid-body mode.
TEST(ModalAnalysis, ASlowSpringIsNoRigidBodyMode) {
    const double b = 0.5 * 100.5 + 100, root = std::sqrt(b * b - 4 * 0.5 * 50);
    const double slow = std::sqrt((b - root) / 1) / (2 * kPi), fast = std::sqrt((b + root) / 1) / (2 * kPi);
    const NetworkModel network = stiff_row(1e9);
    const std::vector<dttmm_mode> modes = Machine(network, 0b000001).find(3);
    ASSERT_EQ(modes.size(), 3u);
    EXPECT_NEAR(modes[0].frequency, slow, 1e-6 * slow);  // of 1e9 + 0.5 N/m the last digit is 1.2e-7
    EXPECT_NEAR(modes[1].frequency, fast, 1e-6 * fast);
    for (const double stiff : {1e12, 1e14}) {
        const NetworkModel too_stiff = stiff_row(stiff);
        try {
            Machine(too_stiff, 0b000001).find(3);
            ADD_FAILURE() << stiff << ": a frequency was hidden";
        } catch (const Error& error) {
            EXPECT_EQ(error.status(), DTTMM_ERROR_NUMERIC);
            EXPECT_THAT(error.what(), HasSubstr("natural frequency at about 0.09"));
        }
    }
}

// A range much wider than the slowest frequency: seen, or the search fails, but never taken for rigid.
TEST(ModalAnalysis, AWideRangeHidesNothing) {
    const NetworkModel network = stiff_row(1e9);
    Machine machine(network, 0b000001);
    try {
        const std::vector<dttmm_mode> modes = machine.find(0, 1e6);
        ASSERT_EQ(modes.size(), 3u);
        EXPECT_NEAR(modes[0].frequency, 0.0918626, 1e-6);
    } catch (const Error& error) {
        EXPECT_EQ(error.status(), DTTMM_ERROR_NUMERIC);
    }
}

/// The clamped Timoshenko beam in `count` uneven parts.
NetworkModel chain_of_beams(int count) {
    NetworkModel network;
    for (int n = 0; n <= count; ++n) {
        const double part = static_cast<double>(n) / count, x = kBeamLength * (part + 0.1 * part * (1 - part));
        network.node(fmt::format("n{}", n), DTTMM_NODE_INNER, {0.3 + x, 0, 0}).fixed = n == 0 ? kHeld : 0;
    }
    for (int n = 0; n < count; ++n)
        network.element(fmt::format("e{}", n), "beam", {fmt::format("n{}", n), fmt::format("n{}", n + 1)}, bar(true));
    return network;
}

// Oracle: the same beam in one piece.
TEST(ModalAnalysis, TheRoundingOfShortPartsIsTold) {
    const NetworkModel whole = beam(kHeld, 0, true);
    const std::vector<dttmm_mode> exact = Machine(whole).find(2);
    for (const int count : {7, 60, 1000}) {
        const NetworkModel network = chain_of_beams(count);
        const std::vector<dttmm_mode> modes = Machine(network).find(2);
        ASSERT_EQ(modes.size(), exact.size());
        for (size_t m = 0; m < modes.size(); ++m) {
            const double error = std::abs(modes[m].frequency / exact[m].frequency - 1);
            EXPECT_LT(error, modes[m].bracket + exact[m].bracket) << count << " parts, mode " << m;
            EXPECT_LT(modes[m].bracket, 1e-6) << count << " parts, mode " << m;
        }
    }
}

// Oracle: the beam without the stub at its tip. The shorter the stub, the stiffer: told, until it hides everything.
TEST(ModalAnalysis, AStubHidesFrequenciesOnlyWhereItSaysSo) {
    const NetworkModel whole = beam(kHeld, 0, true);
    const double exact = Machine(whole).find(1).front().frequency;
    bool was_refused = false;
    for (const double length : {1e-2, 1e-3, 1e-4, 1e-5, 1e-6}) {
        NetworkModel network = beam(kHeld, 0, true);
        network.node("tip", DTTMM_NODE_INNER, {0.3 + kBeamLength + length, 0, 0});
        network.element("stub", "beam", {"b", "tip"}, bar());
        try {
            const dttmm_mode mode = Machine(network).find(1).at(0);
            EXPECT_FALSE(was_refused) << length;
            const double by_its_mass = 4 * length / kBeamLength;  // a tip mass counts fourfold, by ω to the power 2 once
            EXPECT_NEAR(mode.frequency, exact, (by_its_mass + mode.bracket) * exact) << length;
        } catch (const Error& error) {
            EXPECT_EQ(error.status(), DTTMM_ERROR_NUMERIC);
            EXPECT_THAT(error.what(), HasSubstr("rounding"));
            was_refused = true;
        }
    }
    EXPECT_TRUE(was_refused);
}

// ---- Loops --------------------------------------------------------------------------------------------------------------

// Oracle: a square frame of four equal beams, closed, in its plane, free: the same as twice as many beams of half the
// length.
TEST(ModalAnalysis, AClosedFrameIsTheSameInMorePieces) {
    const auto frame = [](int per_side) {
        NetworkModel network;
        const Eigen::Vector3d corner[] = {{0, 0, 0}, {1, 0, 0}, {1, 1.2, 0}, {0, 1.2, 0}};
        const int count = 4 * per_side;
        for (int n = 0; n < count; ++n) {
            const int side = n / per_side;
            const double part = static_cast<double>(n % per_side) / per_side;
            network.node(fmt::format("n{}", n), DTTMM_NODE_INNER,
                         corner[side] + part * (corner[(side + 1) % 4] - corner[side]));
        }
        for (int n = 0; n < count; ++n)
            network.element(fmt::format("e{}", n), "beam", {fmt::format("n{}", n), fmt::format("n{}", (n + 1) % count)},
                            bar(true));
        Machine machine(network);
        std::vector<double> hertz;
        for (const dttmm_mode& mode : machine.find(16)) hertz.push_back(mode.frequency);
        return hertz;
    };
    const std::vector<double> one = frame(1), three = frame(3);
    ASSERT_GE(one.size(), 16u);
    ASSERT_EQ(one.size(), three.size());
    for (size_t i = 0; i < one.size(); ++i) EXPECT_NEAR(one[i], three[i], 1e-9 * one[i]) << i;
    EXPECT_EQ(one[5], 0);
    EXPECT_GT(one[6], 0);
}

/// A loop that hangs on a beam: two beams and an oblique rod, in parts of its length that each begin at either end.
struct RodPart {
    double until;  ///< of the length
    bool is_turned;
};
std::vector<dttmm_mode> modes_of_loop(const std::vector<RodPart>& parts) {
    const NetworkModel::Values rod = {{"section.EA", {7e7}}, {"section.mass", {2.65}}};
    const NetworkModel::Values arm = {{"theory", {1}},          {"up", {0.1, 0.2, 0.97}}, {"section.EA", {5e8}},
                                      {"section.EIy", {4e5}},   {"section.EIz", {3e5}},   {"section.GJ", {4e5}},
                                      {"section.GAy", {1.8e8}}, {"section.GAz", {1.8e8}}, {"section.mass", {21.0}}};
    const Eigen::Vector3d start(0.31, -0.52, 0.77), end(-0.64, 0.83, 0.29);
    NetworkModel network;
    network.node("F", DTTMM_NODE_INNER, {0.9, 0.4, -0.3}).fixed = kHeld;
    network.node("B", DTTMM_NODE_INNER, {-0.45, -0.71, -0.58});
    network.node("r0", DTTMM_NODE_INNER, start);
    for (size_t n = 0; n < parts.size(); ++n) {
        const std::string names[] = {fmt::format("r{}", n), fmt::format("r{}", n + 1)};
        network.node(names[1], DTTMM_NODE_INNER, start + parts[n].until * (end - start));
        const bool is_turned = parts[n].is_turned;
        network.element(fmt::format("rod{}", n), "rod", {names[is_turned], names[!is_turned]}, rod);
    }
    network.element("c", "beam", {"F", "r0"}, arm);
    network.element("d", "beam", {"r0", "B"}, arm);
    network.element("e", "beam", {"B", fmt::format("r{}", parts.size())}, arm);
    return Machine(network).find(4);
}

// Oracle: the rod in one piece. Nodes along it have no stiffness against turning, and no mass where no rod begins: all of
// that is in rigid directions, of which some are passed on.
TEST(ModalAnalysis, ARodInALoopIsTheSameInMoreParts) {
    const std::vector<dttmm_mode> whole = modes_of_loop({{1, false}});
    ASSERT_EQ(whole.size(), 4u);
    for (int count = 2; count <= 7; ++count)
        for (unsigned turned = 0; turned < 1u << count; turned += 3) {
            std::vector<RodPart> parts;
            for (int n = 1; n <= count; ++n) {
                const double part = static_cast<double>(n) / count;
                parts.push_back({part + 0.4 * part * (1 - part), (turned >> n & 1u) != 0});
            }
            const std::vector<dttmm_mode> divided = modes_of_loop(parts);
            ASSERT_EQ(divided.size(), 4u);
            for (size_t m = 0; m < 4; ++m)
                EXPECT_NEAR(divided[m].frequency, whole[m].frequency, 1e-9 * whole[m].frequency) << count << ' ' << turned;
        }
}

// Oracle: the loop with its oblique rod in one piece. In three, r1 has no mass, as the rods begin elsewhere, nor stiffness
// against turning: all of it is in rigid directions. (In this order rounding once passed for stiffness there, and a rigid
// direction for redundant.)
TEST(ModalAnalysis, ARodInALoopIsTheSameInMorePieces) {
    struct Part {
        std::string name, type, from, to;
    };
    const auto find = [](const std::vector<Part>& parts) {
        const NetworkModel::Values rod = {{"section.EA", {7e7}}, {"section.mass", {2.65}}};
        const NetworkModel::Values arm = {{"theory", {1}},          {"up", {0.1, 0.2, 0.97}}, {"section.EA", {5e8}},
                                          {"section.EIy", {4e5}},   {"section.EIz", {3e5}},   {"section.GJ", {4e5}},
                                          {"section.GAy", {1.8e8}}, {"section.GAz", {1.8e8}}, {"section.mass", {21.0}}};
        std::map<std::string, Eigen::Vector3d> places = {{"F", {0, 0, 0}},          {"A", {1, 0, 0}},
                                                         {"r1", {1, 1 / 3.0, 0.1}}, {"r2", {1, 2 / 3.0, 0.2}},
                                                         {"C", {1, 1, 0.3}},        {"B", {2, 0.4, 0.2}}};
        NetworkModel network;
        for (const Part& part : parts) {
            for (const std::string& end : {part.from, part.to})
                if (const auto place = places.extract(end))  // nodes in the order in which elements name them
                    network.node(end, DTTMM_NODE_INNER, place.mapped()).fixed = end == "F" ? kHeld : 0;
            network.element(part.name, part.type, {part.from, part.to}, part.type == "rod" ? rod : arm);
        }
        return Machine(network).find(4);
    };
    const Part c{"c", "beam", "F", "A"}, d{"d", "beam", "A", "B"}, e{"e", "beam", "B", "C"};
    const std::vector<dttmm_mode> whole = find({c, d, e, {"rod", "rod", "A", "C"}});
    const std::vector<dttmm_mode> divided =
        find({{"rod1", "rod", "r2", "r1"}, d, c, e, {"rod2", "rod", "r2", "C"}, {"rod0", "rod", "A", "r1"}});
    ASSERT_EQ(whole.size(), 4u);
    ASSERT_EQ(divided.size(), 4u);
    for (size_t m = 0; m < 4; ++m) EXPECT_NEAR(divided[m].frequency, whole[m].frequency, 1e-9 * whole[m].frequency) << m;
}

// ---- A beam between two points of one rigid body ------------------------------------------------------------------------

/// A rigid body on a spring, with a beam from one of its points to another. node: on the beam at 0.3 of its length. hinge:
/// the body has its first point only, and a hinge without freedom leads to the second.
NetworkModel bow(bool has_node, bool has_hinge) {
    NetworkModel network;
    const Eigen::Vector3d a(0.3, 0.1, 0), b(-0.4, 0, 0.1);
    network.node("ground", DTTMM_NODE_GROUND, {0, 0, 0});
    network.node("a", DTTMM_NODE_INNER, a);
    network.node("b", DTTMM_NODE_INNER, b);
    if (has_node) network.node("p", DTTMM_NODE_INNER, a + 0.3 * (b - a));
    const std::vector<std::string> ends = {"a", "b"};
    network.element("r", "rigid_body", has_hinge ? std::vector<std::string>{"a"} : ends,
                    {{"mass", {2}}, {"inertia.xx", {0.1}}, {"inertia.yy", {0.12}}, {"inertia.zz", {0.15}}});
    network.element("s", "spring_damper", {"ground", "a"},
                    {{"stiffness", {1e4, 2e4, 3e4}}, {"rotational_stiffness", {1e3, 2e3, 3e3}}});
    const NetworkModel::Values section = {
        {"theory", {1}},         {"up", {0.1, 0.2, 0.97}},   {"section.EA", {2e7}},  {"section.EIy", {100}},
        {"section.EIz", {150}},  {"section.GJ", {80}},       {"section.GAy", {6e6}}, {"section.GAz", {7e6}},
        {"section.mass", {0.6}}, {"section.inertia", {1e-4}}};
    network.element("e", "beam", {"a", has_node ? "p" : "b"}, section);
    if (has_node) network.element("e2", "beam", {"p", "b"}, section);
    if (has_hinge) network.element("h", "elastic_hinge", {"a", "b"}, {});
    return network;
}

// Oracle: the same machine with a node on its beam, and with a rigid hinge in its body. Frequencies to 1e-9; shapes at a and
// b, and of the beam all along, to 1e-6 of the largest; responses to 1e-9.
TEST(ModalAnalysis, ABeamBetweenTwoPointsOfOneRigidBody) {
    Machine bare(bow(false, false)), node(bow(true, false)), hinge(bow(false, true));
    constexpr uint32_t kCount = 14;
    const std::vector<dttmm_mode> own = bare.find(kCount), with_node = node.find(kCount), with_hinge = hinge.find(kCount);
    ASSERT_EQ(own.size(), kCount);
    for (uint32_t m = 0; m < kCount; ++m) {
        EXPECT_NEAR(own[m].frequency, with_node[m].frequency, 1e-9 * own[m].frequency) << m;
        EXPECT_NEAR(own[m].frequency, with_hinge[m].frequency, 1e-9 * own[m].frequency) << m;
        // The largest displacement, which is made one, is looked for at points of each piece: scales differ a little
        const Eigen::MatrixXd shape = bare.along(m, 2, 9), other = hinge.along(m, 2, 9);
        const double scale = shape.cwiseProduct(other).sum() / other.squaredNorm(), size = shape.cwiseAbs().maxCoeff();
        EXPECT_NEAR(std::abs(scale), 1, 2e-3) << m;
        EXPECT_LT((shape - scale * other).cwiseAbs().maxCoeff(), 1e-6 * size) << m;
        EXPECT_LT((bare.shape(m) - scale * hinge.shape(m)).cwiseAbs().maxCoeff(), 1e-6 * size) << m;
        EXPECT_NEAR(bare.shares(m)[2], node.shares(m)[2] + node.shares(m)[3], 1e-7) << m;
    }
    for (const double hertz : {7.0, 93.0, 800.0}) {
        const std::complex<double> response = bare.respond(hertz, 1, 2, 2, 1);
        EXPECT_LT(std::abs(response - node.respond(hertz, 1, 2, 2, 1)), 1e-9 * std::abs(response)) << hertz;
        EXPECT_LT(std::abs(response - hinge.respond(hertz, 1, 2, 2, 1)), 1e-9 * std::abs(response)) << hertz;
    }
}

// Oracle: cosh βl cos βl = 1 across, nπ/l along and about the axis; the same beam with a node on it. All that moves lies
// between the nodes.
TEST(ModalAnalysis, ABeamBetweenTwoClamps) {
    const NetworkModel network = beam(kHeld, kHeld);
    Machine plane(network, kPlane);
    constexpr double kRoots[] = {4.730040744862704, 7.853204624095838, 10.99560783800167};
    const std::vector<dttmm_mode> across = plane.find(3);
    ASSERT_EQ(across.size(), 3u);
    for (uint32_t m = 0; m < 3; ++m) {
        EXPECT_NEAR(across[m].frequency / euler(kRoots[m]), 1, 1e-9) << m;
        EXPECT_NEAR(plane.along(m, 0, 401).row(1).cwiseAbs().maxCoeff(), 1, 0.02) << m;
        EXPECT_LT(plane.shape(m).cwiseAbs().maxCoeff(), 1e-9) << m;
    }
    // Of the first shape cosh − cos − σ (sinh − sin), σ = 0.982502215: largest value, and (∫φ)²/(l ∫φ²)
    EXPECT_NEAR(across[0].mass / kMass, 1 / (1.588146 * 1.588146), 2e-3);  // the largest is looked for at points
    EXPECT_NEAR(across[0].participation[1], 0.690331, 1e-6);
    for (const auto& [direction, speed] : {std::pair(0b000001u, std::sqrt(4e8 / 16)), {0b001000u, std::sqrt(2e5 / 0.05)}}) {
        Machine line(network, direction);
        const std::vector<dttmm_mode> modes = line.find(4);
        ASSERT_EQ(modes.size(), 4u);
        for (uint32_t m = 0; m < 4; ++m)
            EXPECT_NEAR(modes[m].frequency / ((m + 1) * speed / (2 * kBeamLength)), 1, 1e-9) << direction;
    }

    NetworkModel divided;
    divided.node("a", DTTMM_NODE_INNER, {0.3, 0, 0}).fixed = kHeld;
    divided.node("p", DTTMM_NODE_INNER, {1.1, 0, 0});
    divided.node("b", DTTMM_NODE_GROUND, {0.3 + kBeamLength, 0, 0});
    divided.element("left", "beam", {"a", "p"}, bar(true));
    divided.element("right", "beam", {"p", "b"}, bar(true));
    const NetworkModel one = beam(kHeld, kHeld, true);
    Machine whole(one), parts(divided);
    const std::vector<dttmm_mode> own = whole.find(12), others = parts.find(12);
    ASSERT_EQ(own.size(), 12u);
    for (uint32_t m = 0; m < 12; ++m) {
        EXPECT_NEAR(own[m].frequency / others[m].frequency, 1, 1e-9) << m;
        for (int d = 0; d < 6; ++d) EXPECT_NEAR(own[m].participation[d], others[m].participation[d], 1e-6) << m << d;
    }
}

}  // namespace
}  // namespace dttmm::plugin
