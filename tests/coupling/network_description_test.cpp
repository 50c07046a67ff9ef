// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/network_description.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "coupling/networks.h"
#include "support/chain.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr Attachment at_node(int node) { return {-1, -1, node}; }

/// Two bodies and five nodes.
Model machine(const Plugins& plugins) {
    Model model;
    model.simulation.gravity = {1, 2, -9};
    Body first = test::box("first", 2, {0.1, 0.2, 0.3}, {0.4, -0.1, 0.7});
    first.rotation = Eigen::AngleAxisd(0.9, Eigen::Vector3d(1, 2, -1).normalized()).toRotationMatrix();
    first.markers.push_back({"foot", {0.1, 0.2, -0.3}, nullptr});
    first.markers.push_back(
        {"hand", {0.3, 0.1, 0.2}, std::make_shared<Eigen::Matrix3d>(Eigen::AngleAxisd(-0.5, Eigen::Vector3d::UnitX()))});
    model.bodies = {first, test::box("second", 3, {0.3, 0.1, 0.1}, {0.9, 0.2, 0.5})};
    for (int n = 0; n < 5; ++n) model.nodes.push_back(test::node(fmt::format("n{}", n), {0.1 * n, 0.2, -0.3 * n}));
    model.nodes[1].fixed = 0b100010;
    model.nodes[1].moves = true;
    model.nodes[1].velocity = {4, 5, 6};
    model.nodes[1].angular_velocity = {7, 8, 9};
    model.nodes[1].rotation = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    model.elements = {
        test::link("left", plugins, {0, 1}, at_node(0), 1),   test::link("bolt", plugins, {}, {0, 0}, 2),
        test::link("right", plugins, at_node(2), {1, -1}, 3), test::link("spare", plugins, at_node(4), {0, 1}, 4),
        test::lump("masses", plugins, {1, 0, 2}, 5),          test::link("back", plugins, {0, 1}, at_node(2), 6),
        test::link("tie", plugins, at_node(1), {}, 7),        test::lump("spare mass", plugins, {3, 4}, 8)};
    return model;
}

TEST(NetworkDescription, EveryPluginHasItsElements) {
    const Plugins plugins = test::chain_plugins();
    Model model = machine(plugins);
    model.elements.insert(model.elements.begin() + 1, test::spring("other", plugins, {0, 0}, {1, -1}, 1, 0));
    EXPECT_THAT(split_by_plugin(model, plugins), ElementsAre(ElementsAre(0, 2, 3, 4, 5, 6, 7, 8), ElementsAre(1)));
    EXPECT_TRUE(split_by_plugin(Model{}, plugins).empty());
}

// Oracle: the interface's own words, place by place.
TEST(NetworkDescription, BodiesNodesAndElementsAreAsTheModelHasThem) {
    const Plugins plugins = test::chain_plugins();
    const Model model = machine(plugins);
    const NetworkDescription description(model, plugins, {0, 2, 4, 5, 6});
    const dttmm_network network = description.network();
    // In the order in which the elements name them; a place on a body is one node however many elements are on it
    std::vector<std::string> names;
    std::vector<uint32_t> kinds;
    for (uint32_t n = 0; n < network.node_count; ++n) {
        names.emplace_back(network.nodes[n].name);
        kinds.push_back(network.nodes[n].kind);
    }
    EXPECT_THAT(names, ElementsAre("first.hand", "n0", "n2", "second", "n1", "ground"));
    EXPECT_THAT(kinds, ElementsAre(DTTMM_NODE_ON_BODY, DTTMM_NODE_INNER, DTTMM_NODE_INNER, DTTMM_NODE_ON_BODY,
                                   DTTMM_NODE_INNER, DTTMM_NODE_GROUND));
    EXPECT_EQ(network.nodes[0].body, 0u);
    EXPECT_EQ(network.nodes[3].body, 1u);
    ASSERT_EQ(network.body_count, 2u);
    EXPECT_STREQ(network.bodies[1].name, "second");
    EXPECT_EQ(network.bodies[1].mass, model.bodies[1].mass);
    const Body& turned_body = model.bodies[0];
    EXPECT_LT((Eigen::Map<const Eigen::Vector3d>(network.bodies[0].position) - turned_body.position -
               turned_body.rotation * turned_body.center_of_mass)
                  .norm(),
              1e-15);
    EXPECT_EQ(network.bodies[0].rotation[1], turned_body.rotation(0, 1)) << "row-major";
    EXPECT_THAT(description.inner_nodes(), ElementsAre(0, 2, 1));

    ASSERT_EQ(network.element_count, 5u);
    const auto ends = [&](uint32_t e) {
        const dttmm_element& element = network.elements[e];
        return std::vector<uint32_t>(element.ends, element.ends + element.end_count);
    };
    EXPECT_THAT(ends(0), ElementsAre(0, 1));
    EXPECT_THAT(ends(1), ElementsAre(2, 3));
    EXPECT_THAT(ends(2), ElementsAre(4, 1, 2));
    EXPECT_THAT(ends(3), ElementsAre(0, 2));
    EXPECT_THAT(ends(4), ElementsAre(4, 5));
    EXPECT_STREQ(network.elements[2].name, "masses");
    EXPECT_EQ(network.elements[2].type, 1u);
    EXPECT_EQ(network.elements[3].values[0], 6);
    EXPECT_THAT(network.gravity, ElementsAre(1, 2, -9));

    const dttmm_node &hand = network.nodes[0], &turned = network.nodes[4], &ground = network.nodes[5];
    const Body& body = model.bodies[0];
    const Eigen::Vector3d position = body.position + body.rotation * body.markers[1].position;
    const Eigen::Matrix3d axes = body.rotation * body.markers[1].axes();
    EXPECT_LT((Eigen::Map<const Eigen::Vector3d>(hand.position) - position).norm(), 1e-15);
    EXPECT_LT((Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(hand.rotation) - axes).norm(), 1e-15);
    EXPECT_EQ(turned.fixed, 0b100010u);
    EXPECT_EQ(turned.moves, 1);
    EXPECT_THAT(turned.velocity, ElementsAre(4, 5, 6));
    EXPECT_THAT(turned.angular_velocity, ElementsAre(7, 8, 9));
    EXPECT_EQ(turned.rotation[3], std::sin(0.3)) << "row-major";
    EXPECT_EQ(network.nodes[1].moves, 0);
    // The ground coincides with the other end, in place and axes
    EXPECT_THAT(ground.position, testing::ElementsAreArray(turned.position));
    EXPECT_THAT(ground.rotation, testing::ElementsAreArray(turned.rotation));
}

TEST(NetworkDescription, TwoPluginsInOneNetworkAreRefusedByName) {
    const Plugins plugins = test::chain_plugins();
    Model model = machine(plugins);
    model.elements.push_back(test::spring("intruder", plugins, at_node(2), {1, -1}, 1, 0));
    model.elements.back().place = "machine.toml:77:1";
    try {
        const Networks networks(model, plugins);
        FAIL() << "two plugins were accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::model_invalid);
        EXPECT_THAT(error.what(), testing::AllOf(HasSubstr("machine.toml:77:1: element \"intruder\" (plugin built in)"),
                                                 HasSubstr("element \"right\" (plugin " + test::paths::chain() + ")")));
    }
}

TEST(Networks, BodiesOfANetworkAreNeighboursHoweverFarApartOnIt) {
    const Plugins plugins = test::chain_plugins();
    const Networks networks(machine(plugins), plugins);
    EXPECT_THAT(networks.neighbours(), ElementsAre(std::pair<int, int>{1, 0}));
    EXPECT_EQ(networks.instances().size(), 1u);
    EXPECT_EQ(networks.instances()[0].name(), "elements of plugin " + test::paths::chain());
}

// What the plugin refuses is told with the place of the element it blames, or that of the model.
TEST(Networks, ARefusalNamesThePlaceOfTheElementThatIsBlamed) {
    const Plugins plugins = test::chain_plugins();
    const auto refusal = [&](const Model& model) -> std::string {
        try {
            const Networks networks(model, plugins);
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::model_invalid);
            return error.what();
        }
        return "no refusal";
    };
    Model model = machine(plugins);
    model.path = "machine.toml";
    for (Element& element : model.elements) element.place = "machine.toml: " + element.name;
    Model unlucky = model, massless = model;
    unlucky.elements[4].values.change()[0] = 13;
    EXPECT_THAT(refusal(unlucky), testing::StartsWith("machine.toml: masses: element \"masses\" (plugin "));
    massless.elements[4].ends.pop_back();
    EXPECT_THAT(refusal(massless), testing::StartsWith("machine.toml: plugin " + test::paths::chain() + ": a node has"));
}

}  // namespace
}  // namespace dttmm::host
