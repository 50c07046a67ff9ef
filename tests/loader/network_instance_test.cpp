// SPDX-License-Identifier: BSD-3-Clause
#include "loader/network_instance.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <utility>

#include "loader/faulty_plugin.h"
#include "record/error_matcher.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr dttmm_node kNodes[] = {{"ground", DTTMM_NODE_GROUND, 0, {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 0, 0, {}, {}},
                                 {"mass", DTTMM_NODE_ON_BODY, 0, {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 0, 0, {}, {}}};
constexpr dttmm_body kMass = {"mass", {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 1, {1, 0, 0, 0, 1, 0, 0, 0, 1}};

/// One element "joint" between the ground and a port, in the plugin with this fault; `number` is its one parameter.
NetworkInstance make_joint(const std::string& fault, double number = 0) {
    const uint32_t from_to[] = {0, 1};
    const dttmm_element joint{"joint", 0, 2, from_to, &number};
    return {PluginLibrary::load(faulty_plugin(fault)),
            {1, &kMass, 2, kNodes, 1, &joint, DTTMM_SCHEME_CENTRED, 0.25, 0.5, {}, 0, nullptr, 0, nullptr, nullptr, 0}};
}

void expect_step_fails(const std::string& fault, uint64_t index, ExitCode code, const std::string& text) {
    NetworkInstance joint = make_joint(fault);
    dttmm_motion port{};
    double wrench[7];
    joint.begin_step({index, 0, 1e-3}, nullptr);
    expect_error([&] { joint.evaluate(&port, wrench, nullptr); }, code, HasSubstr(text));
}

TEST(NetworkInstance, KnowsItsBlocksElementsAndChannels) {
    NetworkInstance first = make_joint("none");
    const NetworkInstance joint = std::move(first);
    ASSERT_EQ(joint.blocks().size(), 1u);
    EXPECT_EQ(joint.blocks()[0].row, 0u);
    EXPECT_EQ(joint.blocks()[0].column, 0u);
    EXPECT_EQ(joint.element_name(0), "joint");
    ASSERT_EQ(joint.channel_count(), 1u);
    EXPECT_EQ(joint.channel(0).name_in_owner(), "force.x");
}

// Oracle: the table of exit codes in the design; the text names element and plugin and ends with the plugin's own words.
TEST(NetworkInstance, ARefusedNetworkBecomesAnErrorOfTheRightCode) {
    const std::pair<dttmm_status, ExitCode> expected[] = {
        {DTTMM_DISCARD, ExitCode::numerical_failure},
        {DTTMM_ERROR_ARGUMENT, ExitCode::plugin_failure},
        {DTTMM_ERROR_PHASE, ExitCode::plugin_failure},
        {DTTMM_ERROR_MODEL, ExitCode::model_invalid},
        {DTTMM_ERROR_SINGULAR, ExitCode::numerical_failure},
        {DTTMM_ERROR_NUMERIC, ExitCode::numerical_failure},
        {DTTMM_ERROR_MEMORY, ExitCode::resource_limit},
        {DTTMM_ERROR_INTERNAL, ExitCode::plugin_failure},
        {77, ExitCode::plugin_failure},
    };
    for (const auto& [status, code] : expected)
        expect_error(
            [status = status] { make_joint("create_error", status); }, code,
            AllOf(HasSubstr("element \"joint\""), HasSubstr("create_error.so"), HasSubstr("made of butter; take steel")));
}

TEST(NetworkInstance, CreateThatReturnsNothingIsAFailureOfThePlugin) {
    expect_error([] { make_joint("create_nothing"); }, ExitCode::plugin_failure, HasSubstr("create returned no instance"));
}

// The instance is given back to the plugin: the leak check of the sanitizer build sees to that.
TEST(NetworkInstance, AChannelWithoutUnitOwnerOrRoleIsAFailureOfThePlugin) {
    for (const auto& [fault, reason] :
         {std::pair("bad_channel", "it has no unit"), std::pair("slash_channel", "its name has a slash"),
          std::pair("bad_role", "there is no such role"), std::pair("port_channel", "its node is on a body"),
          std::pair("energy_in_watts", "energy has the unit J")})
        expect_error([fault = fault] { make_joint(fault); }, ExitCode::plugin_failure,
                     HasSubstr(fmt::format("output channel 0 is not well declared: {}", reason)));
}

TEST(NetworkInstance, AFailureSaysWhichElementIsBlamed) {
    try {
        make_joint("create_error", DTTMM_ERROR_MODEL);
        FAIL() << "no failure";
    } catch (const NetworkError& error) {
        EXPECT_EQ(error.element(), 0);
    }
    EXPECT_EQ(make_joint("none").name(), "joint");
}

TEST(NetworkInstance, AFailingStepSpeaksThePluginsWords) {
    expect_step_fails("error_at_step_1000", 1000, ExitCode::plugin_failure, "the spring has melted");
    expect_step_fails("silent_error", 0, ExitCode::plugin_failure, "status -99 without a text");
}

}  // namespace
}  // namespace dttmm::host
