// SPDX-License-Identifier: BSD-3-Clause
//
// Networks with nodes of their own, in the plugin of tests/loader/chain: leap-frog on both sides of the C interface, so that
// body and nodes follow one recurrence, written out here.
#include <gtest/gtest.h>

#include <array>

#include "step/simulation.h"
#include "support/chain.h"

namespace dttmm::host {
namespace {

constexpr double kStep = 1e-3;
constexpr double kGravity = -9.81;

/// Values of one channel, row by row.
std::vector<double> history(const Model& model, const Plugins& plugins, const std::string& channel) {
    Simulation simulation(model, plugins);
    const std::vector<Channel>& channels = simulation.channels();
    const auto found = std::ranges::find(channels, channel, &Channel::name);
    if (found == channels.end()) ADD_FAILURE() << "no channel " << channel;
    std::vector<double> values;
    simulation.record_to(
        [&](std::span<const double> row) { values.push_back(row[static_cast<size_t>(found - channels.begin())]); });
    while (simulation.index() < simulation.step_count()) simulation.step();
    return values;
}

/// ground — near — far — body, upwards; the body and the near node fall and fly at the start, the far node is pulled.
Model chain(const Plugins& plugins) {
    Model model;
    model.simulation.step = kStep;
    model.simulation.duration = 0.05;
    model.simulation.gravity = {0, 0, kGravity};
    Body body = test::box("block", 3, {0.1, 0.1, 0.1}, {0, 0, 0.9});
    body.velocity = {0, 0, 0.4};
    model.bodies.push_back(body);
    model.nodes = {test::node("far", {0, 0, 0.6}), test::node("near", {0, 0, 0.3})};
    model.nodes[1].moves = true;
    model.nodes[1].velocity = {0, 0, -0.7};
    const Attachment far{-1, -1, 0}, near{-1, -1, 1};
    model.elements = {test::link("foot", plugins, {}, near, 900), test::link("middle", plugins, near, far, 700),
                      test::lump("masses", plugins, {0, 1}, 0.5), test::lump("more", plugins, {0}, 0.3),
                      test::link("head", plugins, far, {0, -1}, 800)};
    Load pull;
    pull.on = far;
    pull.direction = Eigen::Vector3d::UnitZ();
    pull.signal = test::smooth_rise(40, 0.03);
    model.loads.push_back(pull);
    return model;
}

/// The recurrence of the chain in z: near, far, block.
struct ByHand {
    std::array<double, 3> m{0.5, 0.8, 3}, x{}, v{-0.7, 0, 0.4}, now{};  ///< way, velocity behind it, velocity at it
    std::vector<std::array<double, 3>> ways;
    std::vector<double> kinetic, strain, work;

    ByHand(const Model& model, int rows) {
        const std::array<double, 3> v0 = v;
        const auto acceleration = [&](int n) {
            const double foot = 900 * x[0], middle = 700 * (x[1] - x[0]), head = 800 * (x[2] - x[1]);
            const double pull = model.loads[0].signal.value(n * kStep);
            return std::array<double, 3>{kGravity + (middle - foot) / m[0], kGravity + (head - middle + pull) / m[1],
                                         kGravity - head / m[2]};
        };
        double done = 0, power_before = 0;
        for (int n = 0; n < rows; ++n) {
            const auto a = acceleration(n);
            if (n == 0)
                for (size_t i = 0; i < 3; ++i) v[i] = v0[i] - 0.5 * kStep * a[i];
            double twice = 0, pulled = 0;
            ways.push_back(x);
            strain.push_back(0.5 * (900 * x[0] * x[0] + 700 * std::pow(x[1] - x[0], 2) + 800 * std::pow(x[2] - x[1], 2)));
            for (size_t i = 0; i < 3; ++i) {
                const double after = v[i] + kStep * a[i];
                now[i] = 0.5 * (v[i] + after);
                twice += m[i] * now[i] * now[i];
                v[i] = after;
            }
            kinetic.push_back(0.5 * twice);
            // The block's weight works exactly, the nodes' and the load's by the trapezoidal rule
            for (size_t i = 0; i < 2; ++i) pulled += m[i] * kGravity * now[i];
            pulled += model.loads[0].signal.value(n * kStep) * now[1];
            if (n > 0) done += 0.5 * kStep * (power_before + pulled);
            power_before = pulled;
            work.push_back(done + m[2] * kGravity * x[2]);
            for (size_t i = 0; i < 3; ++i) x[i] += kStep * v[i];
        }
    }
};

void expect_equal(const std::vector<double>& values, const std::function<double(size_t)>& expected, const char* what) {
    ASSERT_EQ(values.size(), 51u) << what;
    for (size_t n = 0; n < values.size(); ++n) EXPECT_NEAR(values[n], expected(n), 1e-12) << what << ", row " << n;
}

// Oracle: the recurrence by hand; only rounding separates the two (1e-12 of metres).
TEST(Nodes, AChainOfNodesAndABodyFollowsItsRecurrence) {
    const Plugins plugins = test::chain_plugins();
    const Model model = chain(plugins);
    const ByHand hand(model, 51);
    expect_equal(
        history(model, plugins, "near.position.z"), [&](size_t n) { return 0.3 + hand.ways[n][0]; }, "near");
    expect_equal(
        history(model, plugins, "far.position.z"), [&](size_t n) { return 0.6 + hand.ways[n][1]; }, "far");
    expect_equal(
        history(model, plugins, "block.position.z"), [&](size_t n) { return 0.9 + hand.ways[n][2]; }, "block");
}

// Oracle: the same; parts of the network go into the ledger by their role, in joules.
TEST(Nodes, TheLedgerTakesInTheEnergiesOfTheNetwork) {
    const Plugins plugins = test::chain_plugins();
    const Model model = chain(plugins);
    const ByHand hand(model, 51);
    expect_equal(
        history(model, plugins, "energy.kinetic"), [&](size_t n) { return hand.kinetic[n]; }, "kinetic");
    expect_equal(
        history(model, plugins, "energy.strain"), [&](size_t n) { return hand.strain[n]; }, "strain");
    expect_equal(
        history(model, plugins, "energy.work"), [&](size_t n) { return hand.work[n]; }, "work");
}

TEST(Nodes, ChannelsAreNamedAfterElementOrNodeAndShownByRole) {
    const Plugins plugins = test::chain_plugins();
    const Model model = chain(plugins);
    const Simulation simulation(model, plugins);
    const auto shown = [&](const std::string& name) {
        const auto found = std::ranges::find(simulation.channels(), name, &Channel::name);
        return found == simulation.channels().end() ? -1 : static_cast<int>(found->by_default());
    };
    EXPECT_EQ(shown("middle.force.z"), 1);
    EXPECT_EQ(shown("far.position.x"), 1);
    EXPECT_EQ(shown("far.velocity.x"), 0) << "on request";
    EXPECT_EQ(shown("far.kinetic_energy"), -1) << "in the ledger";
    EXPECT_EQ(shown("middle.strain_energy"), -1);
}

// Oracle: the recurrence of one mass on one spring, by hand.
TEST(Nodes, AModelWithoutBodiesRuns) {
    const Plugins plugins = test::chain_plugins();
    Model model;
    model.simulation.step = kStep;
    model.simulation.duration = 0.05;
    model.nodes = {test::node("bob", {1, 2, 3})};
    model.nodes[0].moves = true;
    model.nodes[0].velocity = {0.6, 0, 0};
    model.nodes[0].fixed[1] = true;
    model.elements = {test::lump("mass", plugins, {0}, 2), test::link("spring", plugins, {-1, -1, 0}, {}, 500)};
    Load push;
    push.on = {-1, -1, 0};
    push.direction = Eigen::Vector3d(1, 1, 0).normalized();
    push.signal = test::constant(3);
    model.loads.push_back(push);
    for (Coupling coupling : {Coupling::implicit, Coupling::explicit_}) {
        model.simulation.coupling = coupling;
        const double f = 3 / std::sqrt(2.0);
        double x = 0, v = 0.6 - 0.5 * kStep * f / 2;
        std::vector<double> ways;
        for (int n = 0; n < 51; ++n) {
            ways.push_back(x);
            v += kStep * (f - 500 * x) / 2;
            x += kStep * v;
        }
        expect_equal(
            history(model, plugins, "bob.position.x"), [&](size_t n) { return 1 + ways[n]; }, "free");
        expect_equal(
            history(model, plugins, "bob.position.y"), [](size_t) { return 2.0; }, "fixed");
    }
}

}  // namespace
}  // namespace dttmm::host
