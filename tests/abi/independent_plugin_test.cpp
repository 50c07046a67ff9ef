// SPDX-License-Identifier: BSD-3-Clause
//
// An equivalent model built another way: independent_spring.c, a plugin in C with the whole law of the spring-damper's
// translations, gives what the built-in one gives.
#include <dlfcn.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "abi/joint_run.h"
#include "dttmm_state.h"
#include "support/paths.h"
#include "support/spring_values.h"

namespace dttmm::test {
namespace {

const dttmm_plugin& built_in() { return *dttmm_plugin_entry(DTTMM_PLUGIN_MAJOR); }

/// The C plugin; stays loaded to the end.
const dttmm_plugin& independent() {
    void* library = dlopen(test::paths::independent_spring().c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library) throw std::runtime_error(dlerror());
    const auto entry = reinterpret_cast<dttmm_plugin_entry_function>(dlsym(library, DTTMM_PLUGIN_ENTRY));
    return *entry(DTTMM_PLUGIN_MAJOR);
}

const std::vector<double> kSpring = {5e5, 7.3e6, 1.2e4, 1000, 0.7, 3300};
const std::vector<double> kSpringDamper = spring_values({5e5, 7.3e6, 1.2e4, 1000, 0.7, 3300});

constexpr Ends kAllEnds[] = {{true, true}, {false, true}, {true, false}};

constexpr double kRounding = 4e-16;  // of a deflection [m]

void expect_equal(const std::vector<double>& a, const std::vector<double>& b, const char* what, double rounding = 0) {
    ASSERT_EQ(a.size(), b.size());
    const Eigen::Map<const Eigen::VectorXd> u(a.data(), static_cast<Eigen::Index>(a.size())), v(b.data(), u.size());
    EXPECT_LE((u - v).norm(), std::max(3e-13 * v.norm(), rounding)) << what;
}

void expect_equal(const Answer& spring, const Answer& reference) {
    expect_equal(spring.wrench, reference.wrench, "wrench", kRounding * kSpring[1]);
    expect_equal(spring.mean, reference.mean, "mean wrench", kRounding * kSpring[1]);
    expect_equal(spring.standing, reference.standing, "wrench that stands", kRounding * kSpring[1]);
    expect_equal(spring.stiffness, reference.stiffness, "stiffness");
    for (const auto& [name, value] : spring.outputs) {
        ASSERT_TRUE(reference.outputs.contains(name)) << name;
        const double rounding = name.starts_with("force") ? kRounding * kSpring[1] : 1e-15;
        EXPECT_NEAR(value, reference.outputs.at(name), 1e-12 * std::abs(value) + rounding) << name;
    }
}

// Oracle: the built-in spring-damper without rotational parts, an equal law written in another way. Along a motion with
// large rotations only rounding separates the two: 3e-13 of the wrench, or 4e-16 m of the deflection.
TEST(IndependentPlugin, EqualsTheBuiltInSpringInEverySchemeAndBetweenAllEnds) {
    for (uint32_t scheme = DTTMM_SCHEME_CENTRED; scheme <= DTTMM_SCHEME_PARK; ++scheme)
        for (const Ends& ends : kAllEnds) {
            SCOPED_TRACE(testing::Message()
                         << "scheme " << scheme << ", from moves " << ends.from_moves << ", to moves " << ends.to_moves);
            JointRun spring(independent(), 0, kSpring, scheme, ends), reference(built_in(), 0, kSpringDamper, scheme, ends);
            EXPECT_EQ(independent().is_implicit(spring.instance()), built_in().is_implicit(reference.instance()));
            double weights[3], expected[3];
            independent().load_weights(spring.instance(), weights);
            built_in().load_weights(reference.instance(), expected);
            EXPECT_THAT(weights, testing::ElementsAreArray(expected));
            expect_equal(spring.linearise(3), reference.linearise(3));
            for (uint64_t n = 0; n < 5; ++n) {
                SCOPED_TRACE(testing::Message() << "step " << n);
                expect_equal(spring.step(n), reference.step(n));
            }
        }
}

// Oracle: the same joint alone, and a run put back to a saved state: the same bits.
TEST(IndependentPlugin, SavesItsStateToTheBitAndSharesNothing) {
    JointRun spring(independent(), 0, kSpring, DTTMM_SCHEME_CENTRED, {true, true}),
        other(independent(), 0, kSpring, DTTMM_SCHEME_PARK, {false, true});
    dttmm_error error{};
    spring.step(0);
    const auto& saver = *static_cast<const dttmm_state_table*>(independent().extension(DTTMM_STATE));
    std::vector<unsigned char> state(saver.state_size(spring.instance()));
    ASSERT_EQ(saver.save(spring.instance(), state.data(), state.size(), &error), DTTMM_OK);
    const Answer first = spring.step(1), second = spring.step(2);
    ASSERT_EQ(saver.restore(spring.instance(), state.data(), state.size(), &error), DTTMM_OK);
    EXPECT_EQ(spring.step(1), first);
    other.step(0);
    EXPECT_EQ(spring.step(2), second);
    EXPECT_EQ(saver.restore(spring.instance(), state.data(), state.size() - 1, &error), DTTMM_ERROR_ARGUMENT);
}

TEST(IndependentPlugin, RefusesWithTextElementAndNoInstance) {
    const dttmm_node nodes[] = {{"a", DTTMM_NODE_GROUND, 0, {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 0, 0, {}, {}},
                                {"b", DTTMM_NODE_GROUND, 0, {}, {1, 0, 0, 0, 1, 0, 0, 0, 1}, 0, 0, {}, {}}};
    const uint32_t from_to[] = {0, 1};
    const dttmm_element element{"joint", 0, 2, from_to, kSpring.data()};
    const dttmm_network network{0, nullptr, 2, nodes,   1,       &element, DTTMM_SCHEME_CENTRED, 0.25, 0.5, {},
                                0, nullptr, 0, nullptr, nullptr, 0};
    auto* instance = reinterpret_cast<dttmm_instance*>(0x5a5a);
    dttmm_error error{};
    EXPECT_EQ(independent().create(&network, &instance, &error), DTTMM_ERROR_MODEL);
    EXPECT_EQ(instance, nullptr);
    EXPECT_EQ(error.element, 0);
    EXPECT_THAT(error.text, testing::HasSubstr("both ends are on the ground"));
    independent().destroy(nullptr);
}

}  // namespace
}  // namespace dttmm::test
