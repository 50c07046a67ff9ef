// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <string_view>

#include "model/read_model.h"

namespace dttmm::host {

/// A catalogue of one type, as the real plugin declares it: three stiffnesses and dampings, each optional and spreading; and
/// of others to test what the first does not have: a required count of two and an upper bound; nested tables, words, whole
/// numbers and what may be left out; ends at nodes.
inline const ElementCatalogue& test_catalogue() {
    static const dttmm_parameter spring[] = {
        {"stiffness", "N/m", 3, DTTMM_PARAMETER_SPREADS, 0, 0, 1e15, nullptr, 0, "stiffness along x, y, z"},
        {"damping", "N*s/m", 3, DTTMM_PARAMETER_SPREADS, 0, 0, 1e15, nullptr, 0, "damping along x, y, z"},
        {"rotational_stiffness", "N*m/rad", 3, DTTMM_PARAMETER_SPREADS, 0, 0, 1e15, nullptr, 0, "stiffness about x, y, z"},
        {"rotational_damping", "N*m*s/rad", 3, DTTMM_PARAMETER_SPREADS, 0, 0, 1e15, nullptr, 0, "damping about x, y, z"},
    };
    static const dttmm_parameter strut[] = {
        {"lengths", "m", 2, DTTMM_PARAMETER_REQUIRED, 0, 0.5, 7, nullptr, 0, "lengths of the two halves"},
        {"ratio", "1", 1, 0, 0.25, 0, 0.5, nullptr, 0, "Poisson's ratio"},
    };
    static const dttmm_word free_or_rigid[] = {{"free", 0}, {"rigid", std::numeric_limits<double>::infinity()}};
    static const dttmm_word theories[] = {{"euler-bernoulli", 1}, {"timoshenko", 2}};
    const double not_given = std::numeric_limits<double>::quiet_NaN(), unbounded = std::numeric_limits<double>::infinity();
    static const dttmm_parameter beam[] = {
        {"theory", "1", 1, DTTMM_PARAMETER_WORDS_ONLY, 1, 0, 0, theories, 2, "of bending"},
        {"segments", "1", 1, DTTMM_PARAMETER_INTEGER, 10, 1, 1000, nullptr, 0, "lumps"},
        {"section.tube", "m", 2, 0, not_given, 0, unbounded, nullptr, 0, "outer and inner diameter"},
        {"section.mass", "kg", 1, 0, not_given, 0, unbounded, nullptr, 0, "of the whole"},
        {"stiffness.y", "N/m", 1, 0, unbounded, 0, unbounded, free_or_rigid, 2, "of the end"},
        {"material.E", "Pa", 1, DTTMM_PARAMETER_REQUIRED, 0, 0, unbounded, nullptr, 0, "Young's modulus"},
    };
    static const dttmm_parameter lump[] = {{"mass", "kg", 1, DTTMM_PARAMETER_REQUIRED, 0, 0, 1e9, nullptr, 0, "at a node"}};
    static const dttmm_element_type types[] = {{"spring_damper", DTTMM_ENDS_FROM_TO, 4, spring, "three-way spring-damper"},
                                               {"strut", DTTMM_ENDS_FROM_TO, 2, strut, "strut"},
                                               {"beam", DTTMM_ENDS_FROM_TO, 6, beam, "beam"},
                                               {"lump", DTTMM_ENDS_AT, 1, lump, "mass"}};
    static const ElementCatalogue catalogue = [] {
        ElementCatalogue result;
        result.add("dttmm", types[0]);
        result.add("extra", types[1]);
        result.add("extra", types[2]);
        result.add("extra", types[3]);
        return result;
    }();
    return catalogue;
}

inline Model parse(std::string_view text, const ModelOverrides& overrides = {}) {
    return parse_model(text, "m.toml", test_catalogue(), overrides);
}

/// A warning with this code whose text matches.
inline testing::Matcher<const Warning&> WarningIs(const testing::Matcher<std::string>& code,
                                                  const testing::Matcher<std::string>& text) {
    return testing::AllOf(testing::Field(&Warning::code, code), testing::Field(&Warning::text, text));
}

/// The text of the error that `action` must throw with `code`; a test failure if it does not.
template <class Action>
std::string error_of(Action action, ExitCode code = ExitCode::model_invalid) {
    try {
        action();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), code) << error.what();
        return error.what();
    }
    ADD_FAILURE() << "no error";
    return {};
}

inline std::string errors_of(std::string_view text, const ModelOverrides& overrides = {}) {
    return error_of([&] { parse(text, overrides); });
}

inline std::string errors_of(std::string_view text, const ModelOverrides& overrides, ExitCode code) {
    return error_of([&] { parse(text, overrides); }, code);
}

/// Three lines that begin every model, three of a simulation, five of a body: what a test adds starts at line 12.
inline constexpr const char* kStart = "format = \"dttmm/1\"\ntitle = \"test\"\n\n";
inline constexpr const char* kSimulation = "[simulation]\nduration = 1\nstep = 0.001\n";
inline constexpr const char* kBody = "[[body]]\nname = \"plate\"\nmass = 2\ninertia = [2, 3, 4]\nmarkers.a = [1, 2, 3]\n";

/// A valid model with one body "plate" and its marker "a", and then `rest`, whose first line is line 12.
inline std::string model_with(const std::string& rest) { return std::string(kStart) + kSimulation + kBody + rest; }

/// A valid model with `body` in place of the body; its first line, after [[body]] and name, is line 9.
inline std::string body_with(const std::string& body) {
    return std::string(kStart) + kSimulation + "[[body]]\nname = \"plate\"\n" + body;
}

/// A valid model with the given [simulation]; its first line, after the header, is line 5.
inline std::string simulation_with(const std::string& simulation) {
    return std::string(kStart) + "[simulation]\n" + simulation + kBody;
}

}  // namespace dttmm::host
