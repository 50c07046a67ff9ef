// SPDX-License-Identifier: BSD-3-Clause
#include "modal/frequency_slope.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "core/error.h"
#include "modal/modal_analysis.h"
#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

using test::NetworkModel;

/// A network that a number shapes, in small vibrations.
class Shaped {
public:
    Shaped(const std::function<NetworkModel(double)>& shape, double value)
        : network_(shape(value)),
          description_(network_.description()),
          analysis_({&description_, 0, nullptr, 63, 0, nullptr}) {}
    ModalAnalysis& analysis() { return analysis_; }
    std::vector<double> frequencies(uint32_t count) {
        std::vector<double> all(analysis_.find_modes(count, 0));
        for (uint32_t m = 0; m < all.size(); ++m) {
            dttmm_mode mode;
            analysis_.mode(m, &mode, nullptr, nullptr, nullptr);
            all[m] = mode.frequency;
        }
        return all;
    }

private:
    NetworkModel network_;
    dttmm_network description_;
    ModalAnalysis analysis_;
};

/// Changes of the frequencies by the number, against differences of them; the frequencies are apart.
void expect_slopes(const std::function<NetworkModel(double)>& shape, double value, uint32_t count) {
    const double d = 2e-5 * value, wide = 1e-3 * value;
    Shaped middle(shape, value), above(shape, value + d), below(shape, value - d);
    std::vector<std::vector<double>> far;
    for (const double way : {1, -1, 2, -2}) far.push_back(Shaped(shape, value + way * wide).frequencies(count));
    const std::vector<double> at = middle.frequencies(count);
    double largest = 0;
    for (uint32_t m = 0; m < count; ++m) {
        double change = 0;
        middle.analysis().frequency_changes(m, above.analysis(), below.analysis(), &change);
        const double difference = (8 * (far[0][m] - far[1][m]) - (far[2][m] - far[3][m])) / (12 * wide);
        EXPECT_NEAR(change / d * value, difference * value, 1e-7 * at[m]) << m;
        largest = std::max(largest, std::abs(change / d * value) / at[m]);
    }
    EXPECT_GT(largest, 1e-2);
}

NetworkModel::Values section(double EIz) {
    return {{"theory", {0}},       {"section.EA", {4e8}},  {"section.EIy", {3e5}},     {"section.EIz", {EIz}},
            {"section.GJ", {2e5}}, {"section.mass", {16}}, {"section.inertia", {0.05}}};
}

/// Two beams alike, clamped at one end; in the second one number is another.
NetworkModel cantilever(double EIz) {
    NetworkModel network;
    network.node("a", DTTMM_NODE_INNER, {0.3, 0, 0}).fixed = 63;
    network.node("b", DTTMM_NODE_INNER, {1.5, 0, 0});
    network.node("c", DTTMM_NODE_INNER, {2.7, 0, 0});
    network.element("first", "beam", {"a", "b"}, section(7e5));
    network.element("second", "beam", {"b", "c"}, section(EIz));
    return network;
}

TEST(FrequencySlope, OfOneOfTwoBeamsThatWereAlike) { expect_slopes(cantilever, 7e5, 8); }

/// The place of the middle node: lengths, and with them where everything stands, change.
TEST(FrequencySlope, OfALength) {
    expect_slopes(
        [](double length) {
            NetworkModel network;
            network.node("a", DTTMM_NODE_INNER, {0.3, 0, 0}).fixed = 63;
            network.node("b", DTTMM_NODE_INNER, {0.3 + length, 0, 0});
            network.element("beam", "beam", {"a", "b"}, section(7e5));
            network.element("tip", "point_mass", {"b"}, {{"mass", {11}}});
            return network;
        },
        1.7, 6);
}

/// Two masses that two rigid links join say the same thing twice: one of the rows is struck out, in all three machines
/// alike.
TEST(FrequencySlope, WithRigidDirectionsThatSayTheSame) {
    expect_slopes(
        [](double k) {
            NetworkModel network;
            network.node("ground", DTTMM_NODE_GROUND, {0, 0, 0});
            network.node("a", DTTMM_NODE_INNER, {0, 0, 0});
            network.node("b", DTTMM_NODE_INNER, {0.6, 0.1, 0});
            for (const char* name : {"a", "b"})
                network.element(std::string("body") + name, "rigid_body", {name},
                                {{"mass", {2.0 + (*name == 'b')}},
                                 {"center_of_mass", {0.05, 0.03, -0.02}},
                                 {"inertia.xx", {0.02}},
                                 {"inertia.yy", {0.03}},
                                 {"inertia.zz", {0.045}}});
            network.element("spring", "spring_damper", {"ground", "a"},
                            {{"stiffness", {3e4, k, 7e4}}, {"rotational_stiffness", {200, 300, 500}}});
            for (const char* name : {"link1", "link2"})
                network.element(name, "elastic_hinge", {"a", "b"}, {{"stiffness.ry", {900}}, {"stiffness.rz", {700}}});
            return network;
        },
        5e4, 5);
}

TEST(FrequencySlope, RigidBodyModesDoNotChangeAndOtherIndicesAreRefused) {
    const auto free = [](double EIz) {
        NetworkModel network;
        network.node("a", DTTMM_NODE_INNER, {0.3, 0, 0});
        network.node("b", DTTMM_NODE_INNER, {1.5, 0, 0});
        network.element("beam", "beam", {"a", "b"}, section(EIz));
        return network;
    };
    Shaped middle(free, 7e5), above(free, 7.1e5), below(free, 6.9e5), other(cantilever, 7e5);
    middle.frequencies(8);
    std::vector<double> changes(6, 1.0);
    middle.analysis().frequency_changes(0, above.analysis(), below.analysis(), changes.data());
    EXPECT_THAT(changes, testing::Each(0.0));
    for (const uint32_t wrong : {1u, 5u, 8u})
        EXPECT_THROW(middle.analysis().frequency_changes(wrong, above.analysis(), below.analysis(), changes.data()), Error)
            << wrong;
    EXPECT_THROW(middle.analysis().frequency_changes(6, other.analysis(), below.analysis(), changes.data()), Error);
}

}  // namespace
}  // namespace dttmm::plugin
