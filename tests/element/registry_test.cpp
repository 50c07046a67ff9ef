// SPDX-License-Identifier: BSD-3-Clause
#include "element/registry.h"

#include <gtest/gtest.h>

#include <limits>
#include <map>
#include <set>
#include <string>

#include "core/error.h"
#include "support/spring_values.h"

namespace dttmm::plugin {
namespace {

dttmm_status status_of(uint32_t type, const double* values) {
    try {
        make_element(type, values);
        return DTTMM_OK;
    } catch (const Error& error) {
        return error.status();
    }
}

/// What a type needs beyond its defaults, for an element that can be built.
std::map<std::string, std::vector<double>> needed_of(const std::string& type) {
    if (type == "point_mass" || type == "rigid_body") return {{"mass", {2.5}}};
    if (type == "beam")
        return {{"section.tube", {0.05, 0.03}},
                {"material.E", {2e11}},
                {"material.poisson", {0.3}},
                {"material.density", {7850}}};
    if (type == "rod") return {{"section.EA", {1e9}}, {"section.mass", {30}}};
    if (type == "axial_spring") return {{"stiffness", {400}}};
    return {};
}

TEST(Registry, EveryDeclaredTypeIsBuiltFromItsDefaultsAndWhatItNeeds) {
    for (uint32_t t = 0; t < element_types().size(); ++t) {
        std::vector<double> values;
        const dttmm_element_type& type = element_types()[t];
        const auto needed = needed_of(type.name);
        for (uint32_t p = 0; p < type.parameter_count; ++p) {
            const dttmm_parameter& parameter = type.parameters[p];
            if (const auto given = needed.find(parameter.name); given != needed.end())
                values.insert(values.end(), given->second.begin(), given->second.end());
            else
                values.insert(values.end(), parameter.count, parameter.default_value);
        }
        EXPECT_NE(make_element(t, values.data()), nullptr) << type.name;
    }
}

TEST(Registry, NamesAreUniqueAndWordsHaveOneNumber) {
    std::set<std::string> names;
    for (const dttmm_element_type& type : element_types()) {
        EXPECT_TRUE(names.insert(type.name).second) << type.name;
        std::set<std::string> keys;
        for (uint32_t p = 0; p < type.parameter_count; ++p) {
            EXPECT_TRUE(keys.insert(type.parameters[p].name).second) << type.parameters[p].name;
            EXPECT_TRUE(type.parameters[p].word_count == 0 || type.parameters[p].count == 1) << type.parameters[p].name;
        }
    }
}

TEST(Registry, ValuesOutsideTheDeclaredRangeAreRefused) {
    std::vector<double> list = test::spring_values({});
    double* const values = list.data();
    EXPECT_EQ(status_of(0, values), DTTMM_OK);
    for (double bad : {-1.0, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        values[7] = bad;
        EXPECT_EQ(status_of(0, values), DTTMM_ERROR_ARGUMENT) << bad;
    }
}

TEST(Registry, UnknownTypesAndMissingValuesAreRefused) {
    const double values[12] = {};
    EXPECT_EQ(status_of(static_cast<uint32_t>(element_types().size()), values), DTTMM_ERROR_ARGUMENT);
    EXPECT_EQ(status_of(0, nullptr), DTTMM_ERROR_ARGUMENT);
}

}  // namespace
}  // namespace dttmm::plugin
