// SPDX-License-Identifier: BSD-3-Clause
//
// The installed tree, moved away: the command finds its plugin, and a plugin of others is built against it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "cli/process.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

const char* const kForeignProject = R"(cmake_minimum_required(VERSION 3.25)
project(foreign C)
find_package(dttmm 0.1 REQUIRED)
add_library(by_cmake MODULE spring.c)
target_link_libraries(by_cmake PRIVATE dttmm::plugin_interface)
)";

TEST(Install, AMovedTreeRunsAndServesForeignPlugins) {
    const TemporaryFolder folder;
    const auto shell = [&](const std::string& words) {
        return std::system(fmt::format("cd {} && {} > out 2>&1", folder.path().string(), words).c_str());
    };
    ASSERT_EQ(shell("cmake --install " + test::paths::binary_dir() + " --prefix there && mv there moved"), 0)
        << read_text(folder / "out");
    const std::string examples = test::paths::source_dir() + "/examples/";
    EXPECT_EQ(shell("moved/bin/dttmm run -q " + examples + "four_bolt_plate/model.toml -o plate"), 0)
        << read_text(folder / "out");
    EXPECT_TRUE(fs::exists(folder / "moved/share/doc/dttmm/LICENSE"));

    fs::copy_file(examples + "minimal_plugin/spring.c", folder / "spring.c");
    write_text(folder / "CMakeLists.txt", kForeignProject);
    ASSERT_EQ(shell("cmake -G Ninja -B build -DCMAKE_PREFIX_PATH=$PWD/moved && cmake --build build"), 0)
        << read_text(folder / "out");
    ASSERT_EQ(shell("export PKG_CONFIG_PATH=$(dirname $(find $PWD/moved -name dttmm.pc)); "
                    "cc -shared -fPIC $(pkg-config --cflags dttmm) spring.c -o by_pkg_config.so"),
              0)
        << read_text(folder / "out");
    // Every header of the interface is there
    EXPECT_EQ(shell("export PKG_CONFIG_PATH=$(dirname $(find $PWD/moved -name dttmm.pc)); "
                    "cc -c $(pkg-config --cflags dttmm) " +
                    test::paths::source_dir() + "/tests/abi/header_in_c.c -o headers.o"),
              0)
        << read_text(folder / "out");
    for (const char* plugin : {"build/libby_cmake.so", "./by_pkg_config.so"})
        EXPECT_EQ(
            shell(fmt::format("moved/bin/dttmm run -q {}minimal_plugin/model.toml --plugin {} -o own", examples, plugin)), 0)
            << plugin << ": " << read_text(folder / "out");
}

}  // namespace
}  // namespace dttmm::host
