// SPDX-License-Identifier: BSD-3-Clause
#include "element/registry.h"

#include <gtest/gtest.h>

#include <limits>

#include "core/error.h"

namespace dttmm {
namespace {

dttmm_status status_of(uint32_t type, const double* values) {
    try {
        make_element(type, values);
        return DTTMM_OK;
    } catch (const Error& error) {
        return error.status();
    }
}

TEST(Registry, EveryDeclaredTypeIsBuiltFromItsDefaults) {
    for (uint32_t t = 0; t < element_types().size(); ++t) {
        std::vector<double> values;
        const dttmm_element_type& type = element_types()[t];
        for (uint32_t p = 0; p < type.parameter_count; ++p)
            values.insert(values.end(), type.parameters[p].count, type.parameters[p].default_value);
        EXPECT_NE(make_element(t, values.data()), nullptr) << type.name;
    }
}

TEST(Registry, ValuesOutsideTheDeclaredRangeAreRefused) {
    double values[12] = {};
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
}  // namespace dttmm
