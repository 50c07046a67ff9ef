// SPDX-License-Identifier: BSD-3-Clause
#include "model/names.h"

#include "model/test_model.h"

namespace dttmm::host {
namespace {

TEST(Names, LettersOfAnyScriptDigitsUnderscoreAndMinusMakeAName) {
    for (const char* name : {"plate", "Kolben-1", "плита_2", "板", "हड्डी", "é", "1"})
        EXPECT_EQ(find_name_fault(name), std::nullopt) << name;
}

TEST(Names, WhatIsNoNameIsTold) {
    EXPECT_EQ(find_name_fault(""), "is empty");
    EXPECT_THAT(*find_name_fault("-1"), testing::HasSubstr("begins with '-', which a spreadsheet takes for a formula"));
    EXPECT_THAT(*find_name_fault("../../x"), testing::HasSubstr("dot"));
    EXPECT_THAT(*find_name_fault("<script>"), testing::HasSubstr("'<'"));
    EXPECT_THAT(*find_name_fault("a\"b"), testing::HasSubstr("'\"'"));
    EXPECT_THAT(*find_name_fault("a b"), testing::HasSubstr("U+0020"));
    EXPECT_THAT(*find_name_fault("a\nb"), testing::HasSubstr("U+000A"));
    EXPECT_THAT(*find_name_fault("a\u200fb"), testing::HasSubstr("U+200F"));  // right-to-left mark
    EXPECT_THAT(*find_name_fault(std::string(10000, 'a')), testing::HasSubstr("longer than 100"));
    EXPECT_EQ(find_name_fault(std::string(100, 'a')), std::nullopt);
}

TEST(Names, NormalFormCMakesEqualWhatLooksEqual) {
    EXPECT_EQ(normalise_name("e\u0301"), "\u00e9");
    EXPECT_EQ(normalise_name("plate"), "plate");
    EXPECT_EQ(normalise_name(""), "");
}

}  // namespace
}  // namespace dttmm::host
