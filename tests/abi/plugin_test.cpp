// SPDX-License-Identifier: BSD-3-Clause
#include "dttmm_plugin.h"  // first, so that it must stand alone

#include "dttmm_derivative.h"
#include "dttmm_laws.h"
#include "dttmm_response.h"
#include "dttmm_shape.h"
#include "dttmm_state.h"
//
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>

#include "abi/joint_run.h"
#include "support/paths.h"
#include "support/spring_values.h"

extern "C" const size_t dttmm_layout_in_c[20];

namespace dttmm::test {
namespace {

using testing::HasSubstr;

const dttmm_plugin& table() { return *dttmm_plugin_entry(DTTMM_PLUGIN_MAJOR); }
const dttmm_state_table& saver() { return *static_cast<const dttmm_state_table*>(table().extension(DTTMM_STATE)); }

//                               stiffness           damping         rotational stiffness   rotational damping
const std::vector<double> kUgly = spring_values({5e5, 7.3e6, 1.2e4, 100, 0.7, 330, 2e3, 8.1e4, 300, 5, 0.01, 90});

// Oracle: the same header compiled as C.
TEST(Plugin, TheInterfaceHasOneLayoutInCAndCpp) {
    const size_t layout[] = {
        sizeof(dttmm_error),
        sizeof(dttmm_parameter),
        sizeof(dttmm_element_type),
        sizeof(dttmm_node),
        sizeof(dttmm_element),
        sizeof(dttmm_network),
        sizeof(dttmm_motion),
        sizeof(dttmm_step),
        sizeof(dttmm_channel),
        sizeof(dttmm_plugin),
        offsetof(dttmm_plugin, outputs),
        offsetof(dttmm_network, gravity),
        sizeof(dttmm_body),
        sizeof(dttmm_modal_model),
        sizeof(dttmm_modal_table),
        sizeof(dttmm_response_table),
        sizeof(dttmm_state_table),
        sizeof(dttmm_laws_table),
        sizeof(dttmm_shape_table),
        sizeof(dttmm_derivative_table),
    };
    EXPECT_THAT(layout, testing::ElementsAreArray(dttmm_layout_in_c));
    EXPECT_EQ(sizeof(dttmm_error), 512u);
}

// Oracle: the dynamic symbol table of the library, as the linker's own tool reads it.
TEST(Plugin, TheLibraryExportsOneSymbol) {
    const std::unique_ptr<FILE, int (*)(FILE*)> nm(
        popen((test::paths::nm() + " -D --defined-only " + test::paths::library()).c_str(), "r"), pclose);
    ASSERT_NE(nm, nullptr);
    std::vector<std::string> symbols;
    char address[64], kind[8], name[256];
    while (std::fscanf(nm.get(), "%63s %7s %255s", address, kind, name) == 3) symbols.emplace_back(name);
    EXPECT_THAT(symbols, testing::ElementsAre(DTTMM_PLUGIN_ENTRY));
}

TEST(Plugin, AnotherMajorVersionGetsNull) {
    for (uint32_t major : {0u, DTTMM_PLUGIN_MAJOR + 1, 4000000000u}) EXPECT_EQ(dttmm_plugin_entry(major), nullptr);
}

TEST(Plugin, TheTableIsWhole) {
    const dttmm_plugin& plugin = table();
    EXPECT_EQ(plugin.size, sizeof(dttmm_plugin));
    EXPECT_EQ(plugin.major, DTTMM_PLUGIN_MAJOR);
    EXPECT_EQ(plugin.minor, DTTMM_PLUGIN_MINOR);
    // From `create` on it is functions only.
    const auto* functions = reinterpret_cast<const unsigned char*>(&plugin.create);
    for (size_t i = 0; i < (sizeof plugin - offsetof(dttmm_plugin, create)) / sizeof(void*); ++i) {
        void* function = nullptr;
        std::memcpy(&function, functions + i * sizeof function, sizeof function);
        EXPECT_NE(function, nullptr) << "function " << i;
    }
    ASSERT_GT(plugin.element_type_count, 0u);
    for (uint32_t t = 0; t < plugin.element_type_count; ++t) {
        const dttmm_element_type& type = plugin.element_types[t];
        EXPECT_STRNE(type.documentation, "") << type.name;
        for (uint32_t p = 0; p < type.parameter_count; ++p) EXPECT_STRNE(type.parameters[p].documentation, "") << type.name;
    }
}

// ---- Errors -------------------------------------------------------------------------------------------------------------

/// A network of two elements, the second between nodes `from` and `to`; 0 is the ground, 1 and 2 are on bodies.
struct Refusal {
    dttmm_status status;
    dttmm_error error{};
    dttmm_instance* instance;
};
Refusal create_pair(uint32_t from, uint32_t to, const double* values, const char* name = "place") {
    const dttmm_node nodes[] = {
        {"ground", DTTMM_NODE_GROUND, 0, {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 0, 0, {}, {}},
        {name, DTTMM_NODE_ON_BODY, 0, {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 0, 0, {}, {}},
        {"other place", DTTMM_NODE_ON_BODY, 1, {}, {1, 0, 0, 0, 1, 0, 0, 0, name[0] == 'p' ? 1. : 2.}, 0, 0, {}, {}}};
    const dttmm_body bodies[] = {{"one", {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 1, {1, 0, 0, 0, 1, 0, 0, 0, 1}},
                                 {"two", {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 1, {1, 0, 0, 0, 1, 0, 0, 0, 1}}};
    const uint32_t first_ends[] = {0, 1}, second_ends[] = {from, to};
    const dttmm_element elements[] = {{"good", 0, 2, first_ends, kUgly.data()}, {"second", 0, 2, second_ends, values}};
    const dttmm_network network{2, bodies,  3, nodes,   2,       elements, DTTMM_SCHEME_CENTRED, 0.25, 0.5, {},
                                0, nullptr, 0, nullptr, nullptr, 0};
    Refusal refusal{DTTMM_OK, {}, reinterpret_cast<dttmm_instance*>(0x5a5a)};  // what was there before
    refusal.status = table().create(&network, &refusal.instance, &refusal.error);
    return refusal;
}

TEST(Plugin, ARefusedNetworkIsStatusTextElementAndNoInstance) {
    std::vector<double> negative = kUgly;
    negative[4] = -1;
    const auto expect_refused = [](const Refusal& refusal, dttmm_status status, const char* text) {
        EXPECT_EQ(refusal.status, status);
        EXPECT_EQ(refusal.error.element, 1);
        EXPECT_THAT(refusal.error.text, HasSubstr(text));
        EXPECT_EQ(refusal.instance, nullptr);
    };
    expect_refused(create_pair(1, 1, kUgly.data()), DTTMM_ERROR_MODEL, "same node");
    expect_refused(create_pair(1, 7, kUgly.data()), DTTMM_ERROR_MODEL, "no node");
    expect_refused(create_pair(1, 2, negative.data()), DTTMM_ERROR_ARGUMENT, "damping must be finite and in [0");
    expect_refused(create_pair(1, 2, nullptr), DTTMM_ERROR_ARGUMENT, "no values");

    Refusal good = create_pair(1, 2, kUgly.data());
    EXPECT_EQ(good.status, DTTMM_OK);
    ASSERT_NE(good.instance, nullptr);
    table().destroy(good.instance);
}

TEST(Plugin, NullIsRefusedWhereANetworkIsWanted) {
    const dttmm_network hollow{1, nullptr, 2, nullptr, 1,       nullptr, DTTMM_SCHEME_CENTRED, 0.25, 0.5, {},
                               0, nullptr, 0, nullptr, nullptr, 0};
    for (const dttmm_network* network : {static_cast<const dttmm_network*>(nullptr), &hollow}) {
        auto* instance = reinterpret_cast<dttmm_instance*>(0x5a5a);
        dttmm_error error{7, "unwritten"};
        EXPECT_EQ(table().create(network, &instance, &error), DTTMM_ERROR_ARGUMENT);
        EXPECT_EQ(instance, nullptr);
        EXPECT_EQ(error.element, -1);
        EXPECT_STRNE(error.text, "unwritten");
    }
}

// Oracle: the header: the text is UTF-8 and ends with a zero within its 508 bytes, whatever names the host sends.
TEST(Plugin, ALongTextIsCutBetweenCharacters) {
    for (const char* shift : {"", "x"}) {
        std::string name = shift;
        for (int i = 0; i < 400; ++i) name += "ö";
        dttmm_node node{name.c_str(), 99, 0, {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 0, 0, {}, {}};
        const uint32_t ends[] = {0, 0};
        const dttmm_element element{"joint", 0, 2, ends, kUgly.data()};
        const dttmm_network network{0, nullptr, 1, &node,   1,       &element, DTTMM_SCHEME_CENTRED, 0.25, 0.5, {},
                                    0, nullptr, 0, nullptr, nullptr, 0};
        dttmm_instance* instance = nullptr;
        dttmm_error error;
        std::memset(&error, 'z', sizeof error);
        EXPECT_EQ(table().create(&network, &instance, &error), DTTMM_ERROR_MODEL);
        const size_t length = strnlen(error.text, sizeof error.text);
        ASSERT_LT(length, sizeof error.text);
        EXPECT_GT(length, sizeof error.text - 4);
        EXPECT_EQ(std::string(error.text).substr(length - 2), "ö") << "a whole character is last";
    }
}

TEST(Plugin, CallsOutOfPhaseComeBackWithATextAndChangeNothing) {
    JointRun joint(table(), 0, kUgly, DTTMM_SCHEME_CENTRED, {true, true}),
        twin(table(), 0, kUgly, DTTMM_SCHEME_CENTRED, {true, true});
    dttmm_error error{};
    double wrench[12];
    const dttmm_motion ports[2]{};
    const auto expect_refused = [&](dttmm_status status, const char* text) {
        EXPECT_EQ(status, DTTMM_ERROR_PHASE);
        EXPECT_EQ(error.element, -1);
        EXPECT_THAT(error.text, HasSubstr(text));
    };
    expect_refused(table().evaluate(joint.instance(), ports, wrench, nullptr, &error), "evaluate: ");
    expect_refused(table().commit_step(joint.instance(), ports, &error), "commit_step: ");
    expect_refused(table().discard_step(joint.instance(), &error), "discard_step: ");
    expect_refused(table().outputs(joint.instance(), wrench, &error), "outputs: ");
    EXPECT_EQ(joint.step(0), twin.step(0));
}

TEST(Plugin, NothingCanBeDestroyed) { table().destroy(nullptr); }

// ---- State --------------------------------------------------------------------------------------------------------------

TEST(Plugin, AStateOfAnotherSizeIsRefusedAndChangesNothing) {
    JointRun joint(table(), 0, kUgly, DTTMM_SCHEME_CENTRED, {true, true}),
        twin(table(), 0, kUgly, DTTMM_SCHEME_CENTRED, {true, true});
    const size_t size = saver().state_size(joint.instance());
    std::vector<unsigned char> state(size + 1, 0xa5);
    dttmm_error error{};
    for (size_t wrong : {size_t{0}, size - 1, size + 1}) {
        EXPECT_EQ(saver().save(joint.instance(), state.data(), wrong, &error), DTTMM_ERROR_ARGUMENT);
        EXPECT_THAT(error.text, HasSubstr(std::to_string(wrong)));
        EXPECT_EQ(saver().restore(joint.instance(), state.data(), wrong, &error), DTTMM_ERROR_ARGUMENT);
    }
    EXPECT_EQ(state, std::vector<unsigned char>(size + 1, 0xa5)) << "nothing was written";

    JointRun other(table(), 0, kUgly, DTTMM_SCHEME_CENTRED, {true, false});
    std::vector<unsigned char> foreign(saver().state_size(other.instance()));
    ASSERT_EQ(saver().save(other.instance(), foreign.data(), foreign.size(), &error), DTTMM_OK);
    EXPECT_EQ(saver().restore(joint.instance(), foreign.data(), foreign.size(), &error), DTTMM_ERROR_ARGUMENT);
    EXPECT_EQ(saver().restore(joint.instance(), state.data(), size, &error), DTTMM_ERROR_ARGUMENT) << "bytes of no run";
    EXPECT_EQ(joint.step(0), twin.step(0));
}

// ---- Derivatives --------------------------------------------------------------------------------------------------------

const dttmm_derivative_table& derivative() {
    return *static_cast<const dttmm_derivative_table*>(table().extension(DTTMM_DERIVATIVE));
}

std::vector<double> state_of(const dttmm_instance* instance) {
    dttmm_error error{};
    std::vector<double> state(saver().state_size(instance) / sizeof(double));
    EXPECT_EQ(saver().save(instance, state.data(), state.size() * sizeof(double), &error), DTTMM_OK) << error.text;
    return state;
}

// Oracle: equal distances from the middle, and the difference of the two as it was, number by number.
TEST(Plugin, StatesAreCentredAboutAnother) {
    std::vector<double> more = kUgly, less = kUgly;
    more[0] *= 1.01;
    less[0] *= 0.99;
    JointRun above(table(), 0, more, DTTMM_SCHEME_CENTRED, {true, true}),
        below(table(), 0, less, DTTMM_SCHEME_CENTRED, {true, true}),
        middle(table(), 0, kUgly, DTTMM_SCHEME_CENTRED, {true, true});
    for (JointRun* run : {&above, &below, &middle})
        for (uint64_t n = 0; n < 5; ++n) run->step(n);
    const std::vector<double> up = state_of(above.instance()), down = state_of(below.instance());
    const std::vector<double> at = state_of(middle.instance());
    dttmm_error error{};
    ASSERT_EQ(derivative().centre(above.instance(), below.instance(), middle.instance(), &error), DTTMM_OK) << error.text;
    const std::vector<double> new_up = state_of(above.instance()), new_down = state_of(below.instance());
    EXPECT_EQ(state_of(middle.instance()), at);
    int moved = 0;
    for (size_t i = 0; i < at.size(); ++i) {
        const double size = 1e-14 * (std::abs(at[i]) + std::abs(up[i] - down[i]));
        EXPECT_NEAR(new_up[i] + new_down[i], 2 * at[i], 4 * size) << i;
        EXPECT_NEAR(new_up[i] - new_down[i], up[i] - down[i], 4 * size) << i;
        moved += up[i] != down[i];
    }
    EXPECT_GT(moved, 5) << "forces and what has been dissipated";
}

TEST(Plugin, StatesOfOtherNetworksAreNotCentred) {
    JointRun joint(table(), 0, kUgly, DTTMM_SCHEME_CENTRED, {true, true}),
        twin(table(), 0, kUgly, DTTMM_SCHEME_CENTRED, {true, true}),
        other(table(), 0, kUgly, DTTMM_SCHEME_CENTRED, {true, false});
    dttmm_error error{};
    for (JointRun* run : {&joint, &twin, &other}) run->step(0);
    const std::vector<double> before = state_of(joint.instance());
    EXPECT_EQ(derivative().centre(joint.instance(), twin.instance(), other.instance(), &error), DTTMM_ERROR_ARGUMENT);
    EXPECT_EQ(derivative().centre(joint.instance(), other.instance(), twin.instance(), &error), DTTMM_ERROR_ARGUMENT);
    EXPECT_THAT(error.text, HasSubstr("numbers"));
    const dttmm_step step{1, kStep, kStep};
    ASSERT_EQ(table().begin_step(twin.instance(), &step, nullptr, &error), DTTMM_OK);
    EXPECT_EQ(derivative().centre(joint.instance(), twin.instance(), joint.instance(), &error), DTTMM_ERROR_PHASE);
    EXPECT_EQ(state_of(joint.instance()), before) << "nothing was moved";
}

// ---- Instances ----------------------------------------------------------------------------------------------------------

// Oracle: the same joint alone. The interleaved one differs in stiffness, scheme and ports and is one step ahead.
TEST(Plugin, TwoInstancesSideBySideGiveTheBitsOfOneAlone) {
    const std::vector<double> soft = spring_values({10, 20, 30, 1, 2, 3});
    JointRun alone(table(), 0, kUgly, DTTMM_SCHEME_CENTRED, {true, true});
    std::vector<Answer> expected;
    for (uint64_t n = 0; n < 7; ++n) expected.push_back(alone.step(n));

    JointRun joint(table(), 0, kUgly, DTTMM_SCHEME_CENTRED, {true, true}),
        other(table(), 0, soft, DTTMM_SCHEME_HOUBOLT, {true, false});
    other.step(0);
    for (uint64_t n = 0; n < 7; ++n) {
        EXPECT_EQ(joint.step(n), expected[n]) << "step " << n;
        other.step(n + 1);
    }
}

}  // namespace
}  // namespace dttmm::test
