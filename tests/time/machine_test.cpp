// SPDX-License-Identifier: BSD-3-Clause
#include "time/machine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <random>

#include "core/error.h"
#include "core/rotation.h"
#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

using test::NetworkModel;
using ::testing::ElementsAre;

/// Three bodies. Springs between bodies, a chain of two beams with a node that a spring from the ground meets as well, and a
/// beam with masses of its own between two bodies; the elements of one network lie between those of others.
NetworkModel make_model() {
    NetworkModel model;
    const Matrix3 turned = rotation_from_vector(Vector3(0.4, -0.8, 1.3));
    model.node("ground", DTTMM_NODE_GROUND, {0.1, -0.2, 0.05}, turned);
    model.node("a", DTTMM_NODE_ON_BODY, {0.7, 0.15, 0.4}, turned, {0.02, -0.03, 0.05});
    model.node("b", DTTMM_NODE_ON_BODY, {1.1, 0.7, 0.2}, Matrix3::Identity(), {-0.04, 0.01, 0.02});
    model.node("c", DTTMM_NODE_ON_BODY, {0.2, 0.9, 0.6}, turned.transpose());
    model.node("loose", DTTMM_NODE_INNER, {0.5, -0.1, 0.3});
    model.node("node", DTTMM_NODE_INNER, {0.9, 0.5, 0.35}, turned);
    const NetworkModel::Values soft = {{"stiffness", {3e4, 5e4, 2e4}}, {"damping", {20}}, {"rotational_stiffness", {400}}};
    model.element("first", "spring_damper", {"ground", "a"}, soft);
    model.element("left", "beam", {"a", "node"}, test::tube(3, 1e-5));
    model.element("second", "spring_damper", {"c", "b"}, {{"stiffness", {7e4}}, {"rotational_stiffness", {900}}});
    model.element("whole", "beam", {"c", "a"}, test::tube(2));
    model.element("right", "beam", {"node", "b"}, test::tube(2, 2e-5));
    model.element("mass", "point_mass", {"loose"}, {{"mass", {1.7}}});
    model.element("hold", "spring_damper", {"ground", "loose"}, soft);
    model.line_load("right", DTTMM_AXES_ELEMENT);
    model.line_load("whole", DTTMM_AXES_WORLD);
    model.line_load("left", DTTMM_AXES_WORLD);
    return model;
}

std::vector<dttmm_motion> motions(const dttmm_network& network, double t) {
    std::vector<dttmm_motion> list;
    for (uint32_t b = 0; b < network.body_count; ++b) {
        const dttmm_body& body = network.bodies[b];
        const Vector3 v(0.02 + 0.01 * b, -0.03, 0.015 * b), w(0.1, -0.2 * b, 0.15);
        dttmm_motion motion{};
        Eigen::Map<Vector3>{motion.position} = Eigen::Map<const Vector3>(body.position) + t * v;
        Eigen::Map<RowMajor3>{motion.rotation} =
            rotation_from_vector(Vector3(t * w)) * Eigen::Map<const RowMajor3>(body.rotation);
        Eigen::Map<Vector3>{motion.velocity} = v;
        Eigen::Map<Vector3>{motion.angular_velocity} = w;
        list.push_back(motion);
    }
    return list;
}

constexpr double kMachineStep = 1e-4;

std::vector<double> loads_at(double t) {
    return {0,  0,       3 + 100 * t, 0.1, 0,   0,   // of "loose" and "node"
            5,  -2 * t,  1,           0,   0.2, 0,   //
            40, 20,      -30,         10,  t,   5,   // on "right", "whole" and "left"
            7,  300 * t, 90,          0,   0,   50,  //
            11, 0,       -20,         -60, 8,   0};
}

/// What a machine answers in one step.
struct Answer {
    std::vector<double> wrench, stiffness, mean, standing, outputs;
};

void iterate(Machine& machine, const dttmm_motion* trial) {
    std::vector<dttmm_progress> progress(machine.part_count());
    for (int n = 0; n < 4; ++n) machine.iterate(trial, progress.data());
}
void iterate(Network& network, const dttmm_motion* trial) {
    dttmm_progress progress;
    for (int n = 0; n < 4; ++n) network.iterate(trial, progress);
}

size_t count_channels(const Machine& machine) { return machine.channel_count(); }
size_t count_channels(const Network& network) { return network.channels().size(); }

template <class Machine>
Answer take_step(Machine& machine, const dttmm_network& network, uint64_t n, size_t blocks) {
    const double t = static_cast<double>(n) * kMachineStep;
    const std::vector<double> loads = loads_at(t + kMachineStep);
    const size_t size = 6 * network.body_count;
    Answer answer{std::vector<double>(size), std::vector<double>(36 * blocks), std::vector<double>(size),
                  std::vector<double>(size), std::vector<double>(count_channels(machine))};
    machine.begin_step({n, t, kMachineStep}, loads.data());
    const std::vector<dttmm_motion> now = motions(network, t), end = motions(network, t + kMachineStep);
    iterate(machine, end.data());
    machine.evaluate(end.data(), answer.wrench.data(), answer.stiffness.data());
    machine.commit_step(end.data());
    machine.mean_wrench(answer.mean.data());
    machine.stand(now.data(), nullptr, answer.standing.data());
    machine.outputs(answer.outputs.data());
    return answer;
}

std::vector<std::string> channel_names(const dttmm_network& network, const std::vector<dttmm_channel>& channels) {
    std::vector<std::string> names;
    for (const dttmm_channel& channel : channels)
        names.push_back(std::string(channel.of == DTTMM_OF_NODE ? network.nodes[channel.index].name
                                                                : network.elements[channel.index].name) +
                        "." + channel.name);
    return names;
}

// Oracle: the same elements as one network, which solves for all that moves inside at once. Both iterate to a millionth of a
// step's correction.
TEST(Machine, EqualsItsElementsAsOneNetwork) {
    const NetworkModel model = make_model();
    const dttmm_network network = model.description();
    Machine machine(network);
    Network whole(network);
    const std::vector<dttmm_motion> at = motions(network, 0);
    std::vector<double> accelerations(18, 0.0);
    const std::vector<double> loads = loads_at(0);
    const auto names = channel_names(network, machine.channels()), whole_names = channel_names(network, whole.channels());
    machine.start({0, 0, kMachineStep}, at.data(), accelerations.data(), loads.data());
    whole.start({0, 0, kMachineStep}, at.data(), accelerations.data(), loads.data());
    EXPECT_EQ(machine.channel_count(), names.size());
    EXPECT_TRUE(machine.channels().empty()) << "the host has read them";
    for (uint64_t n = 0; n < 12; ++n) {
        const Answer found = take_step(machine, network, n, machine.blocks().size()),
                     expected = take_step(whole, network, n, whole.blocks().list().size());
        const auto expect_near = [&](const std::vector<double>& x, const std::vector<double>& y, const char* what) {
            double largest = 0;
            for (double value : y) largest = std::max(largest, std::abs(value));
            for (size_t i = 0; i < y.size(); ++i)
                EXPECT_NEAR(x[i], y[i], 1e-6 * largest) << what << " " << i << ", step " << n;
        };
        expect_near(found.wrench, expected.wrench, "wrench");
        expect_near(found.mean, expected.mean, "mean wrench");
        expect_near(found.standing, expected.standing, "wrench that stands");
        std::map<std::pair<uint32_t, uint32_t>, const double*> block_of;
        for (size_t b = 0; b < whole.blocks().list().size(); ++b)
            block_of[{whole.blocks().list()[b].row, whole.blocks().list()[b].column}] = &expected.stiffness[36 * b];
        for (size_t b = 0; b < machine.blocks().size() && n == 0; ++b) {  // later each network has it from a step of its own
            const double* own = block_of.at({machine.blocks()[b].row, machine.blocks()[b].column});
            for (size_t i = 0; i < 36; ++i) EXPECT_NEAR(found.stiffness[36 * b + i], own[i], 1) << b << ", " << i;
        }
        std::map<std::string, double> value_of;
        for (size_t c = 0; c < whole_names.size(); ++c) value_of[whole_names[c]] = expected.outputs[c];
        for (size_t c = 0; c < names.size(); ++c) {
            if (names[c].ends_with(".kinetic_energy") || names[c].ends_with(".work")) continue;  // of each network
            ASSERT_TRUE(value_of.contains(names[c])) << names[c];
            const double size = names[c].find("force") != names[c].npos ? 1e3 : 1;
            EXPECT_NEAR(found.outputs[c], value_of[names[c]], 1e-5 * std::max(size, std::abs(value_of[names[c]])))
                << names[c] << ", step " << n;
        }
    }
}

// Channels come element by element, those of nodes and of a whole network behind its last element.
TEST(Machine, ChannelsAreInTheOrderOfTheElements) {
    const NetworkModel model = make_model();
    const dttmm_network network = model.description();
    const Machine machine(network);
    std::vector<std::string> owners;
    for (const dttmm_channel& channel : machine.channels()) {
        const std::string owner =
            channel.of == DTTMM_OF_NODE ? network.nodes[channel.index].name : network.elements[channel.index].name;
        if (owners.empty() || owners.back() != owner) owners.push_back(owner);
    }
    EXPECT_THAT(owners, ElementsAre("first", "left", "right", "node", "left", "second", "whole", "hold", "loose", "mass"))
        << "kinetic energy and work are those of the first element";
}

// Springs between bodies make blocks of their own ends only; every network those of all its bodies.
TEST(Machine, BlocksAreThePairsThatHangOnEachOther) {
    NetworkModel model = make_model();
    const Machine machine(model.description());
    std::set<std::pair<uint32_t, uint32_t>> pairs;
    for (const dttmm_block& block : machine.blocks()) pairs.emplace(block.row, block.column);
    EXPECT_EQ(pairs.size(), machine.blocks().size()) << "each once";
    EXPECT_EQ(pairs.size(), 9u) << "first: aa; second: cc cb bc bb; whole: ca ac; left and right: ab ba";

    NetworkModel chain;
    chain.node("ground", DTTMM_NODE_GROUND, {0, 0, 0});
    for (int b = 0; b < 4; ++b) chain.node("b" + std::to_string(b), DTTMM_NODE_ON_BODY, {1.0 + b, 0, 0});
    for (int b = 0; b < 4; ++b)
        chain.element("s" + std::to_string(b), "spring_damper",
                      {b == 0 ? "ground" : "b" + std::to_string(b - 1), "b" + std::to_string(b)}, {{"stiffness", {1e3}}});
    EXPECT_EQ(Machine(chain.description()).blocks().size(), 4u + 2 * 3u);
}

// Oracle: the elements alone, by their share of u K u.
TEST(Machine, TellsWhatElementsTakeUp) {
    const NetworkModel model = make_model();
    const dttmm_network network = model.description();
    const Machine machine(network);
    std::mt19937 random(7);
    std::vector<double> u(18), elastic(7), damped(7), wrench(18), K(36 * machine.blocks().size()), C(K.size());
    for (double& x : u) x = std::uniform_real_distribution<double>(-1, 1)(random);
    machine.take_up(u.data(), elastic.data(), damped.data());
    std::vector<dttmm_motion> at = motions(network, 0);
    for (dttmm_motion& motion : at)
        for (int i = 0; i < 3; ++i) motion.velocity[i] = motion.angular_velocity[i] = 0;
    machine.linearise(at.data(), wrench.data(), K.data(), C.data());
    double sum = 0, damping = 0;
    for (size_t b = 0; b < machine.blocks().size(); ++b)
        for (size_t i = 0; i < 6; ++i)
            for (size_t j = 0; j < 6; ++j) {
                const double product = u[6 * machine.blocks()[b].row + i] * u[6 * machine.blocks()[b].column + j];
                sum += product * K[36 * b + 6 * i + j];
                damping += product * C[36 * b + 6 * i + j];
            }
    EXPECT_NEAR(elastic[0] + elastic[1] + elastic[2] + elastic[3] + elastic[4], sum, 1e-6 * sum);
    EXPECT_NEAR(damped[0], damping, 1e-9 * damping) << "of the springs between bodies only one has a damper";
    for (size_t e : {0u, 1u, 2u, 3u, 4u}) EXPECT_GT(elastic[e], 0) << e;
    EXPECT_EQ(elastic[5], 0) << "a mass";
    EXPECT_LT(elastic[6], 1e-9 * sum) << "nothing moves it";
}

// Oracle: the same machine that has gone on: the same bits.
TEST(Machine, SavesAllItsNetworks) {
    const NetworkModel model = make_model();
    const dttmm_network network = model.description();
    Machine machine(network);
    const std::vector<double> accelerations(18, 0.0);
    const auto start = [&](Machine& m) {
        m.start({0, 0, kMachineStep}, motions(network, 0).data(), accelerations.data(), loads_at(0).data());
    };
    start(machine);
    const size_t blocks = machine.blocks().size();
    for (uint64_t n = 0; n < 3; ++n) take_step(machine, network, n, blocks);
    std::vector<char> state(machine.state_size());
    machine.save_state(state.data(), state.size());
    Machine other(network);
    start(other);
    other.restore_state(state.data(), state.size());
    for (uint64_t n = 3; n < 6; ++n) {
        const Answer a = take_step(machine, network, n, blocks), b = take_step(other, network, n, blocks);
        EXPECT_EQ(a.wrench, b.wrench);
        EXPECT_EQ(a.outputs, b.outputs);
    }
    EXPECT_THROW(other.restore_state(state.data(), state.size() - 1), Error);
}

// Oracle: the same machine that has gone on: the same bits. One support shifts and turns, another lifts a mass.
TEST(Machine, SavesSupportsThatMove) {
    NetworkModel model;
    const Matrix3 turned = rotation_from_vector(Vector3(0.4, -0.8, 1.3));
    model.node("wall", DTTMM_NODE_INNER, {0.05, 0.1, -0.2});
    model.node("tip", DTTMM_NODE_INNER, {0.9, 0.3, 0.2}, turned);
    model.node("a", DTTMM_NODE_ON_BODY, {1.1, 0.7, 0.2}, turned, {-0.04, 0.01, 0.02});
    model.fix("wall", 0x3f);
    model.fix("tip", 0x24);
    model.element("arm", "beam", {"wall", "tip"}, test::tube(3, 1e-5));
    model.element("mass", "point_mass", {"tip"}, {{"mass", {1.7}}});
    model.element("tie", "spring_damper", {"tip", "a"}, {{"stiffness", {3e4, 5e4, 2e4}}, {"damping", {20}}});
    dttmm_network network = model.description();
    const std::vector<uint32_t> supports = {0, 1};
    network.support_count = 2;
    network.supports = supports.data();
    const auto move = [](Machine& machine, double t) {
        dttmm_support_motion motions[2]{};
        motions[0].displacement[1] = 0.3 * t;
        motions[0].rotation[2] = 5 * t * t;
        motions[1].displacement[2] = -40 * t * t;
        motions[0].velocity[1] = 0.3;
        motions[0].angular_acceleration[2] = 10;
        motions[1].acceleration[2] = -80;
        machine.move_supports(motions);
    };
    const std::vector<double> accelerations(6, 0.0), loads(12, 0.0);
    Machine machine(network), other(network);
    for (Machine* m : {&machine, &other}) {
        move(*m, 0);
        m->start({0, 0, kMachineStep}, motions(network, 0).data(), accelerations.data(), loads.data());
    }
    const size_t blocks = machine.blocks().size();
    for (uint64_t n = 0; n < 4; ++n) {
        move(machine, static_cast<double>(n + 1) * kMachineStep);
        take_step(machine, network, n, blocks);
    }
    std::vector<char> state(machine.state_size());
    machine.save_state(state.data(), state.size());
    other.restore_state(state.data(), state.size());
    for (uint64_t n = 4; n < 9; ++n) {
        for (Machine* m : {&machine, &other}) move(*m, static_cast<double>(n + 1) * kMachineStep);
        const Answer a = take_step(machine, network, n, blocks), b = take_step(other, network, n, blocks);
        EXPECT_EQ(a.wrench, b.wrench);
        EXPECT_EQ(a.mean, b.mean);
        EXPECT_EQ(a.outputs, b.outputs);
    }
}

// Oracle: two equal dampers in a row: the node between them moves half as fast as the body. No spring holds it anywhere.
TEST(Machine, ANodeMayHangOnDampersAlone) {
    NetworkModel model;
    model.node("ground", DTTMM_NODE_GROUND, {0, 0, 0});
    model.node("node", DTTMM_NODE_INNER, {0, 0, 0});
    model.node("body", DTTMM_NODE_ON_BODY, {0, 0, 0});
    const NetworkModel::Values damper = {{"stiffness", {0}}, {"damping", {40, 50, 60}}, {"rotational_damping", {3}}};
    model.element("one", "spring_damper", {"ground", "node"}, damper);
    model.element("two", "spring_damper", {"node", "body"}, damper);
    const dttmm_network network = model.description();
    Machine machine(network);
    dttmm_motion motion = motions(network, 0).front();
    const double accelerations[6] = {};
    machine.start({0, 0, kMachineStep}, &motion, accelerations, nullptr);
    double wrench[6];
    machine.linearise(&motion, wrench, nullptr, nullptr);
    for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(wrench[i], -(40 + 10 * i) / 2.0 * motion.velocity[i], 1e-9 * 60) << "direction " << i;
}

TEST(Machine, BlamesTheElementOfTheWhole) {
    NetworkModel model = make_model();
    model.element("bad", "spring_damper", {"b", "c"}, {{"stiffness", {-1}}});
    try {
        const Machine machine(model.description());
        FAIL() << "a negative stiffness was accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.element(), 7);
    }
    NetworkModel free = make_model();
    free.node("free", DTTMM_NODE_INNER, {3, 3, 3});
    free.element("thread", "spring_damper", {"c", "free"}, {{"stiffness", {1, 0, 0}}});
    const dttmm_network network = free.description();
    Machine machine(network);
    const std::vector<double> accelerations(18, 0.0);
    try {
        machine.start({0, 0, kMachineStep}, motions(network, 0).data(), accelerations.data(), nullptr);
        FAIL() << "a node that nothing holds was accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.element(), 7);
        EXPECT_THAT(error.what(), ::testing::HasSubstr("free"));
    }
}

}  // namespace
}  // namespace dttmm::plugin
