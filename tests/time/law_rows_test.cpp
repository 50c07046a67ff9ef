// SPDX-License-Identifier: BSD-3-Clause
#include "time/law_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "law/registry.h"
#include "statics/frame_links.h"
#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

/// A mass on so many springs with a cubic law each: as many rows, one frame.
LawRows rows_of(int springs) {
    test::NetworkModel model;
    model.node("mass", DTTMM_NODE_INNER, {0.3, 0.1, -0.2});
    model.element("m", "point_mass", {"mass"}, {{"mass", {2}}});
    for (int i = 0; i < springs; ++i) {
        const std::string end = "end" + std::to_string(i);
        model.node(end, DTTMM_NODE_GROUND, {0.1 * i, 0.7, 0.4});
        model.element("s" + std::to_string(i), "axial_spring", {"mass", end},
                      {{"law", {1}}, {"stiffness", {3e3}}, {"cubic", {2e5}}});
    }
    const Mechanism mechanism(model.description());
    return {mechanism, mechanism.assembly.driven_count};
}

// Oracle: rows take their cube in time, 150 for each frame is worth it from the start: 5³ = 125, 6³ = 216.
TEST(LawRows, FewAreWantedFromTheStart) {
    EXPECT_TRUE(rows_of(5).are_wanted(false));
    EXPECT_FALSE(rows_of(6).are_wanted(false));
    EXPECT_TRUE(rows_of(6).are_wanted(true));
}

// Oracle: a hundred at most.
TEST(LawRows, ManyAreNeverWanted) {
    EXPECT_EQ(rows_of(80).count(), 80u);
    EXPECT_TRUE(rows_of(80).are_wanted(true));
    EXPECT_EQ(rows_of(125).count(), 0u);
    EXPECT_FALSE(rows_of(125).are_wanted(true));
}

/// A spring of 1e4 N/m that says that it is stiffer, 1 + 4 r times: an iteration leaves the share r of an error.
template <int kHundredths>
void exaggerate(const double*, const dttmm_law_path* path, dttmm_law_answer* answer) {
    constexpr double k = 1e4, said = k * (1 + 4 * kHundredths / 100.0);
    *answer = {k * path->to, said, 0.5 * k * (path->from + path->to), 0.5 * said, 0.5 * k * path->to * path->to, 0};
}
const dttmm_law kFast = {sizeof(dttmm_law), DTTMM_LAW_MAJOR, "test_fast", "", 0, nullptr, 0, exaggerate<40>};
const dttmm_law kSlowLaw = {sizeof(dttmm_law), DTTMM_LAW_MAJOR, "test_slow", "", 0, nullptr, 0, exaggerate<62>};

/// The value that names a law in the file.
double word_of(const char* name) {
    for (const dttmm_element_type& type : element_types())
        for (const dttmm_parameter& parameter : std::span(type.parameters, type.parameter_count))
            for (const dttmm_word& word : std::span(parameter.words, parameter.word_count))
                if (std::string_view(type.name) == "spring_damper" && std::string_view(word.name) == name) return word.value;
    return 0;
}

// A mass on such a spring: h² k/(4 m) = 1/4. Oracle: z = w + r z, found to rounding in log ε/log r iterations, 40 and 77.
// The latter are too many, and nothing is put right.
TEST(LawRows, GiveUpAfterFiftyPasses) {
    static const dttmm_law* volatile at_work = nullptr;
    constexpr double kTime = 0.01, kMass = 1;
    for (const auto& [law, share, is_found] : {std::tuple(&kFast, 0.4, true), {&kSlowLaw, 0.62, false}}) {
        add_law(*law, &at_work);
        test::NetworkModel model;
        model.node("ground", DTTMM_NODE_GROUND, {0, 0, 0});
        model.node("mass", DTTMM_NODE_INNER, {0, 0, 0});
        model.element("m", "rigid_body", {"mass"},
                      {{"mass", {kMass}}, {"inertia.xx", {1}}, {"inertia.yy", {1}}, {"inertia.zz", {1}}});
        model.element("s", "spring_damper", {"ground", "mass"}, {{"z.law", {word_of(law->name)}}});
        Mechanism mechanism(model.description());
        mechanism.scheme.set_step_size(kTime);
        for (Joint& joint : mechanism.joints) joint.set_scheme(mechanism.scheme);
        const Twist rest{Vector3::Zero(), Vector3::Zero()};
        mechanism.start_joints([&](int) { return rest; }, [&](int) { return rest; });
        LawRows rows(mechanism, mechanism.assembly.driven_count);
        ASSERT_EQ(rows.count(), 1u);
        Elimination matrix(1, links_of(mechanism));
        matrix.add_diagonal(0, kMass * Matrix6::Identity());
        ASSERT_FALSE(matrix.factor().has_value());
        rows.form(mechanism, mechanism.frames);
        std::vector<Vector6> u(1);
        std::vector<double> q, psi(1);
        rows.find_responses(matrix, kTime, u, q);
        u[0] << 0, 0, 3, 0, 0, 0;
        rows.correct(mechanism, mechanism.frames, u, q, psi);
        // ψ = −r z/C, z = w/(1 − r), w = 3 h
        const double C = kTime * kTime / kMass, expected = is_found ? -share / C * 3 * kTime / (1 - share) : 0;
        EXPECT_NEAR(psi[0], expected, 1e-12 * std::abs(expected)) << share;
    }
}

}  // namespace
}  // namespace dttmm::plugin
