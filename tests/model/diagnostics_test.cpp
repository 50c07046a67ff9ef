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

// Oracle: the places as a compiler would print them; the further file comes behind the model file.
TEST(Diagnostics, PlacesOfAFurtherFileNameIt) {
    Diagnostics diagnostics("m.toml");
    const int bolts = diagnostics.add_file("parts/bolts.toml");
    diagnostics.error({2, 9, bolts}, "there");
    diagnostics.error({7, 3}, "here");
    EXPECT_EQ(error_of([&] { diagnostics.throw_if_errors(); }), "m.toml:7:3: here\nparts/bolts.toml:2:9: there");
    EXPECT_EQ(diagnostics.line_text({2, 9, bolts}), "line 2 of parts/bolts.toml");
    EXPECT_EQ(diagnostics.line_text({7, 3}), "line 7");
}

TEST(Diagnostics, OfCopiesTheFirstIsSpeltOutAndTheOthersAreCounted) {
    Diagnostics diagnostics("m.toml");
    for (const int copy : {3, 2, 4}) {
        diagnostics.error({5, 1, 0, copy}, fmt::format("bolt{}: wrong", copy));
        diagnostics.error({5, 1, 0, copy}, fmt::format("bolt{}: bad", copy));
    }
    diagnostics.error({5, 2, 0, 3}, "alone");
    EXPECT_EQ(error_of([&] { diagnostics.throw_if_errors(); }),
              "m.toml:5:1: bolt2: wrong (and in 2 more copies of this)\nm.toml:5:1: bolt2: bad (and in 2 more copies of "
              "this)\nm.toml:5:2: alone");
}

TEST(Diagnostics, WarningsDoNotThrow) {
    Diagnostics diagnostics("m.toml");
    diagnostics.warning({4, 2}, "odd", "hm");
    EXPECT_NO_THROW(diagnostics.throw_if_errors());
    EXPECT_THAT(diagnostics.warnings(), testing::ElementsAre(Warning{"odd", "m.toml:4:2: hm"}));
}

}  // namespace
}  // namespace dttmm::host
