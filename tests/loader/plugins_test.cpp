// SPDX-License-Identifier: BSD-3-Clause
#include "loader/plugins.h"

#include <gtest/gtest.h>

#include "loader/faulty_plugin.h"
#include "record/error_matcher.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

// Oracle: the built-in types come first, a foreign type resolves to its own table, where it has index 0.
TEST(Plugins, ForeignTypesFollowTheBuiltInOnes) {
    const Plugins plugins({faulty_plugin("none")});
    const int type = plugins.catalogue().find("faulty");
    ASSERT_EQ(plugins.libraries().size(), 2u);
    EXPECT_EQ(plugins.catalogue().find("spring_damper"), 0);
    ASSERT_EQ(type, static_cast<int>(plugins.libraries()[0].table().element_type_count));
    const auto [library, index] = plugins.resolve(type);
    EXPECT_EQ(library, &plugins.libraries()[1]);
    EXPECT_EQ(index, 0u);
    EXPECT_EQ(plugins.catalogue().plugins.back(), faulty_plugin("none").string());
}

TEST(Plugins, ATypeDeclaredTwiceIsRefusedAndBothPluginsAreNamed) {
    expect_error(
        [] {
            Plugins({faulty_plugin("none"), faulty_plugin("huge")});
        },
        ExitCode::plugin_failure,
        testing::AllOf(HasSubstr("huge.so: its element type \"faulty\" is already declared"), HasSubstr("none.so")));
    expect_error(
        [] {
            Plugins({faulty_plugin("none"), faulty_plugin("none")});
        },
        ExitCode::plugin_failure, HasSubstr("already declared"));
    expect_error([] { Plugins({faulty_plugin("builtin_name")}); }, ExitCode::plugin_failure,
                 HasSubstr("element type \"spring_damper\" is already declared by plugin built in"));
}

}  // namespace
}  // namespace dttmm::host
