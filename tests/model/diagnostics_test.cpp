// SPDX-License-Identifier: BSD-3-Clause
#include "model/diagnostics.h"

#include <fmt/format.h>

#include "model/test_model.h"

namespace dttmm::host {
namespace {

TEST(Diagnostics, ErrorsAreToldInTheOrderOfTheFileOptionsFirst) {
    Diagnostics diagnostics("m.toml");
    EXPECT_NO_THROW(diagnostics.throw_if_errors());
    diagnostics.error({7, 3}, "late");
    diagnostics.error({2, 9}, "early");
    diagnostics.error({2, 1}, "earlier");
    diagnostics.error(diagnostics.option_place("--step"), "first");
    EXPECT_EQ(error_of([&] { diagnostics.throw_if_errors(); }),
              "--step: first\nm.toml:2:1: earlier\nm.toml:2:9: early\nm.toml:7:3: late");
}

TEST(Diagnostics, FiftyErrorsAreShownAndTheRestCounted) {
    Diagnostics diagnostics("m.toml");
    for (int line = 53; line >= 1; --line) diagnostics.error({line, 1}, "x");
    const std::string text = error_of([&] { diagnostics.throw_if_errors(); });
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 50);
    EXPECT_TRUE(text.ends_with("m.toml:50:1: x\nand 3 more errors")) << text;
}

TEST(Diagnostics, WarningsDoNotThrow) {
    Diagnostics diagnostics("m.toml");
    diagnostics.warning({4, 2}, "odd", "hm");
    EXPECT_NO_THROW(diagnostics.throw_if_errors());
    EXPECT_THAT(diagnostics.warnings(), testing::ElementsAre(Warning{"odd", "m.toml:4:2: hm"}));
}

}  // namespace
}  // namespace dttmm::host
