// SPDX-License-Identifier: BSD-3-Clause
#include "law/foreign_law.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <stdexcept>

#include "core/error.h"

namespace dttmm::plugin {
namespace {

const dttmm_law* volatile at_work = nullptr;

dttmm_law law_of(void (*along)(const double*, const dttmm_law_path*, dttmm_law_answer*)) {
    dttmm_law law{};
    law.name = "own";
    law.parameter_count = 1;
    law.along = along;
    return law;
}

std::string refusal(const dttmm_law& law, double value) {
    try {
        ForeignLaw(law, &at_work, &value).along({0, 1});
        return "none";
    } catch (const Error& error) {
        EXPECT_EQ(error.status(), DTTMM_ERROR_INTERNAL);
        EXPECT_EQ(at_work, nullptr);
        return error.what();
    }
}

// Oracle: the cap of 1e100 N, that of trials.
TEST(ForeignLaw, IsRefusedBeyondTheCapOfForces) {
    const dttmm_law law = law_of([](const double* values, const dttmm_law_path*, dttmm_law_answer* answer) {
        *answer = {};
        answer->force = *values;
    });
    EXPECT_EQ(refusal(law, 0.5e100), "none");
    EXPECT_EQ(refusal(law, -0.5e100), "none");
    EXPECT_THAT(refusal(law, 2e100), testing::HasSubstr("law \"own\": its force is 2e+100"));
    EXPECT_THAT(refusal(law, -2e100), testing::HasSubstr("beyond the cap of 1e+100"));
}

TEST(ForeignLaw, ThatThrowsIsNamed) {
    const dttmm_law law =
        law_of([](const double*, const dttmm_law_path*, dttmm_law_answer*) { throw std::runtime_error("the pad is worn"); });
    EXPECT_EQ(refusal(law, 0), "law \"own\": it threw a C++ exception: the pad is worn");
}

}  // namespace
}  // namespace dttmm::plugin
