// SPDX-License-Identifier: BSD-3-Clause
//
// A law with a memory in a network: the memory is part of the state.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "law/registry.h"
#include "support/dense_network.h"
#include "support/network_model.h"
#include "time/network.h"

namespace dttmm::plugin {
namespace {

using test::NetworkModel;

/// A slider that gives way at 50 N on a spring of 1e5 N/m; remembers where it stands.
void slide(const double*, const dttmm_law_path* path, dttmm_law_answer* answer) {
    constexpr double k = 1e5, slip = 50;
    const double force = std::clamp(k * (path->to - path->memory[0]), -slip, slip);
    *answer = {force, std::abs(force) < slip ? k : 0, force, 0, 0.5 * force * force / k, 0};
    path->after[0] = path->to - force / k;
}
const dttmm_law kSlider = {sizeof(dttmm_law), DTTMM_LAW_MAJOR, "test_slider", "", 0, nullptr, 1, slide};

// Oracle: the network itself, which goes on the same way to the bit from a state that was saved before it slid.
TEST(LawMemory, IsSavedAndRestored) {
    static const dttmm_law* volatile at_work = nullptr;
    add_law(kSlider, &at_work);
    const auto types = element_types();
    const auto spring =
        std::ranges::find_if(types, [](const auto& type) { return std::string_view(type.name) == "spring_damper"; });
    double word = 0;
    for (const dttmm_parameter& parameter : std::span(spring->parameters, spring->parameter_count))
        for (const dttmm_word& one : std::span(parameter.words, parameter.word_count))
            if (std::string_view(one.name) == "test_slider") word = one.value;
    NetworkModel model;
    model.node("ground", DTTMM_NODE_GROUND, {0, 0, 0});
    model.node("p", DTTMM_NODE_ON_BODY, {0, 0, 0});
    model.element("pad", "spring_damper", {"ground", "p"}, {{"z.law", {word}}});
    test::DenseNetwork network(model.description());
    dttmm_motion at{};
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{at.rotation}.setIdentity();
    const double accelerations[6] = {};
    network.start({0, 0, 0.01}, &at, accelerations, nullptr);
    uint64_t step = 0;
    const auto go = [&](double z) {
        network.begin_step({step, 0.01 * static_cast<double>(step), 0.01}, nullptr);
        ++step;
        at.position[2] = z;
        std::array<double, 6> wrench;
        network.evaluate(&at, wrench.data(), nullptr);
        network.commit_step(&at);
        return wrench;
    };
    for (double z : {1e-4, 3e-4, 8e-4}) go(z);
    std::vector<char> state(network.state_size());
    network.save_state(state.data(), state.size());
    std::vector<std::array<double, 6>> first, second;
    for (double z : {2e-3, 1e-3, 4e-3, 0.0}) first.push_back(go(z));
    network.restore_state(state.data(), state.size());
    step = 3;
    for (double z : {2e-3, 1e-3, 4e-3, 0.0}) second.push_back(go(z));
    EXPECT_EQ(first, second);
    // The memory counts: a virgin network does something else there
    test::DenseNetwork virgin(model.description());
    EXPECT_EQ(virgin.state_size(), network.state_size());
    EXPECT_NE(first[0][2], first[3][2]);
}

TEST(LawMemory, BadDeclarationsAreRefused) {
    static const dttmm_law* volatile at_work = nullptr;
    const auto fault_of = [&](auto change) -> std::string {
        dttmm_law law = kSlider;
        law.name = "another";
        change(law);
        try {
            add_law(law, &at_work);
        } catch (const std::exception& error) {
            return error.what();
        }
        return "none";
    };
    EXPECT_EQ(fault_of([](dttmm_law& law) { law.name = "cubic"; }), "law \"cubic\": there is another law of this name");
    EXPECT_EQ(fault_of([](dttmm_law& law) { law.name = "law"; }),
              "law \"?\": its name must be letters, digits and underscores, without a digit first, and not \"law\"");
    EXPECT_EQ(fault_of([](dttmm_law& law) { law.along = nullptr; }), "law \"another\": it is not whole");
    EXPECT_EQ(fault_of([](dttmm_law& law) { law.size = 8; }), "law \"another\": it is of another version");
    EXPECT_EQ(fault_of([](dttmm_law& law) { law.parameter_count = 1; }), "law \"another\": it is not whole");
}

}  // namespace
}  // namespace dttmm::plugin
