// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/process.h"
#include "cli/small_model.h"

namespace dttmm::host {
namespace {

using ::testing::HasSubstr;

TEST(Show, DrawsAModelBesideItsResults) {
    const TemporaryFolder folder;
    write_text(folder / "pump.toml", kSmallModel);
    const Ended ended = run_dttmm(folder.path(), {"show", "pump.toml"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(ended.out, "results/pump-views.svg\n");
    const std::string svg = read_text(folder / "results/pump-views.svg");
    for (const char* name : {">plate</text>", ">one</text>", ">two</text>", ">front, seen along y</text>"})
        EXPECT_THAT(svg, HasSubstr(name));
    const Ended printed = run_dttmm(folder.path(), {"show", "pump.toml", "-o", "-"});
    EXPECT_EQ(printed.code, 0) << printed.err;
    EXPECT_EQ(printed.out, svg);
}

TEST(Show, RefusesOtherPicturesAndWrongModels) {
    const TemporaryFolder folder;
    write_text(folder / "pump.toml", kSmallModel);
    const Ended picture = run_dttmm(folder.path(), {"show", "pump.toml", "-o", "pump.png"});
    EXPECT_EQ(picture.code, 2);
    EXPECT_THAT(picture.err, HasSubstr("give a name that ends with .svg"));
    write_text(folder / "wrong.toml", small_model_with("plate.left\"", "plate.lfet\""));
    const Ended wrong = run_dttmm(folder.path(), {"show", "wrong.toml"});
    EXPECT_EQ(wrong.code, 3);
    EXPECT_THAT(wrong.err, HasSubstr("wrong.toml:30:6: "));
    EXPECT_FALSE(fs::exists(folder / "results/wrong-views.svg"));
}

}  // namespace
}  // namespace dttmm::host
