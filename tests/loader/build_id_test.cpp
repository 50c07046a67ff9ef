// SPDX-License-Identifier: BSD-3-Clause
#include "loader/build_id.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>

#include "dttmm_plugin.h"

namespace dttmm::host {
namespace {

/// What readelf finds in a file.
std::string by_readelf(const std::filesystem::path& file) {
    const std::string command = "readelf -n '" + file.string() + "' 2>&1";
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(::popen(command.c_str(), "r"), &::pclose);
    std::string text;
    for (int c; (c = std::fgetc(pipe.get())) != EOF;) text += static_cast<char>(c);
    const std::string key = "Build ID: ";
    const std::size_t at = text.find(key);
    if (at == text.npos) return "readelf: " + text;
    return text.substr(at + key.size(), text.find('\n', at) - at - key.size());
}

TEST(BuildId, OfTheProgramAndOfItsPluginAreThoseThatReadelfFinds) {
    static int here;
    const std::string program = build_id_at(&here);
    EXPECT_EQ(program, by_readelf(std::filesystem::read_symlink("/proc/self/exe")));

    const auto entry = reinterpret_cast<const void*>(&dttmm_plugin_entry);
    Dl_info info{};
    ASSERT_NE(::dladdr(entry, &info), 0);
    EXPECT_EQ(build_id_at(entry), by_readelf(info.dli_fname));
    EXPECT_NE(build_id_at(entry), program);
}

TEST(BuildId, OfNoLoadedObjectIsRefused) {
    const auto on_the_heap = std::make_unique<int>();
    EXPECT_THROW(build_id_at(on_the_heap.get()), std::logic_error);
}

}  // namespace
}  // namespace dttmm::host
