// SPDX-License-Identifier: BSD-3-Clause
//
// The tree is the design: a layer may include only what stands to its left, and some headers belong to one place.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "support/paths.h"

namespace {

namespace fs = std::filesystem;
using Includes = std::map<std::string, std::vector<std::string>>;  // "host/model/units.cpp" -> what it includes

const fs::path kSource = dttmm::test::paths::source_dir();

/// Every layer with the layers it may include; the header between the halves is checked apart.
const std::map<std::string, std::set<std::string>> kMayInclude = {
    {"plugin/core", {"plugin/core"}},
    {"plugin/law", {"plugin/core", "plugin/law"}},
    {"plugin/element", {"plugin/core", "plugin/law", "plugin/element"}},
    {"plugin/mechanism", {"plugin/core", "plugin/law", "plugin/element", "plugin/mechanism"}},
    {"plugin/solve", {"plugin/core", "plugin/solve"}},
    {"plugin/statics",
     {"plugin/core", "plugin/law", "plugin/element", "plugin/mechanism", "plugin/solve", "plugin/statics"}},
    {"plugin/time",
     {"plugin/core", "plugin/law", "plugin/element", "plugin/mechanism", "plugin/solve", "plugin/statics", "plugin/time"}},
    {"plugin/modal",
     {"plugin/core", "plugin/law", "plugin/element", "plugin/mechanism", "plugin/solve", "plugin/statics", "plugin/modal"}},
    {"plugin/abi",
     {"plugin/core", "plugin/law", "plugin/element", "plugin/mechanism", "plugin/statics", "plugin/time", "plugin/modal",
      "plugin/abi"}},
    {"host/model", {"host/model"}},
    {"host/world", {"host/model", "host/world"}},
    {"host/loader", {"host/model", "host/loader"}},
    {"host/record", {"host/model", "host/record"}},
    {"host/measured", {"host/model", "host/record", "host/measured"}},
    {"host/coupling", {"host/model", "host/world", "host/loader", "host/record", "host/coupling"}},
    {"host/step", {"host/model", "host/world", "host/loader", "host/record", "host/coupling", "host/step"}},
    {"host/analysis",
     {"host/model", "host/world", "host/loader", "host/record", "host/coupling", "host/step", "host/analysis"}},
    {"host/study",
     {"host/model", "host/world", "host/loader", "host/record", "host/coupling", "host/step", "host/analysis",
      "host/study"}},
    {"host/identify",
     {"host/model", "host/world", "host/loader", "host/record", "host/measured", "host/coupling", "host/step",
      "host/analysis", "host/study", "host/identify"}},
    {"host/report", {"host/model", "host/record", "host/analysis", "host/report"}},
    {"host/cli",
     {"host/model", "host/world", "host/loader", "host/record", "host/coupling", "host/step", "host/analysis", "host/study",
      "host/identify", "host/report", "host/cli"}},
};

Includes read_includes() {
    Includes includes;
    for (const char* half : {"plugin", "host"}) {
        for (const auto& entry : fs::recursive_directory_iterator(kSource / half)) {
            const std::string extension = entry.path().extension();
            if (extension != ".h" && extension != ".cpp") continue;
            std::vector<std::string>& found = includes[fs::relative(entry.path(), kSource).generic_string()];
            std::ifstream file(entry.path());
            for (std::string line; std::getline(file, line);) {
                const size_t begin = line.find_first_of("<\"");
                if (line.starts_with("#include") && begin != std::string::npos)
                    found.push_back(line.substr(begin + 1, line.find_first_of(">\"", begin + 1) - begin - 1));
            }
        }
    }
    return includes;
}

std::string half_of(const std::string& file) { return file.substr(0, file.find('/')); }
std::string layer_of(const std::string& file) { return fs::path(file).parent_path().generic_string(); }

/// The layer that an include such as "model/units.h" reaches from a file of its half, or none for what is not ours.
std::string layer_reached(const std::string& from, const std::string& include) {
    const std::string candidate = half_of(from) + "/" + include;
    return fs::exists(kSource / candidate) ? layer_of(candidate) : "";
}

TEST(Layers, IncludePointsLeftOnly) {
    const Includes includes = read_includes();
    ASSERT_GT(includes.size(), 40u) << "the sources were not found";
    for (const auto& [file, list] : includes) {
        const std::string layer = layer_of(file);
        if (layer == "plugin/include" || file == "host/main.cpp") continue;
        ASSERT_TRUE(kMayInclude.contains(layer)) << file << " stands in no layer of the design";
        for (const std::string& include : list) {
            const std::string reached = layer_reached(file, include);
            if (!reached.empty() && reached != "plugin/include") {
                EXPECT_TRUE(kMayInclude.at(layer).contains(reached)) << file << " includes " << include;
            }
        }
    }
}

TEST(Layers, TheHalvesShareTheHeadersOfTheInterface) {
    for (const auto& [file, list] : read_includes())
        for (const std::string& include : list) {
            if (layer_reached(file, include).empty() && include != "dttmm_plugin.h" && include != "dttmm_law.h") {
                const std::string other = half_of(file) == "host" ? "plugin" : "host";
                EXPECT_FALSE(fs::exists(kSource / other / include))
                    << file << " includes " << include << " of the other half";
            }
            EXPECT_EQ(include.find(".."), std::string::npos) << file << " includes " << include;
        }
}

/// Files with an include that begins so.
std::set<std::string> files_with(const std::string& beginning) {
    std::set<std::string> files;
    for (const auto& [file, list] : read_includes())
        for (const std::string& include : list)
            if (include.starts_with(beginning)) files.insert(file);
    return files;
}

TEST(Layers, OdeIsSeenByTheWorldOnly) {
    for (const std::string& file : files_with("ode/")) EXPECT_EQ(layer_of(file), "host/world") << file;
}

TEST(Layers, TheTomlParserIsSeenByOneFile) {
    EXPECT_EQ(files_with("toml++/"), std::set<std::string>{"host/model/toml_document.cpp"});
}

TEST(Layers, ThePluginReadsNoFilesAndKnowsNoEngine) {
    for (const char* header : {"fstream", "filesystem", "cstdio", "stdio.h", "iostream", "ode/", "hdf5.h"})
        for (const std::string& file : files_with(header))
            EXPECT_EQ(half_of(file), "host") << file << " includes " << header;
}

TEST(Layers, TheInterfaceIsImplementedByAbiAlone) {
    // All but abi speak its plain data types; its functions and the entry are defined in abi.
    for (const char* layer : {"core", "law", "element", "mechanism", "solve", "time"})
        for (const auto& entry : fs::directory_iterator(kSource / "plugin" / layer)) {
            std::ifstream file(entry.path());
            const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
            EXPECT_EQ(text.find("dttmm_plugin_entry"), std::string::npos) << entry.path();
            EXPECT_EQ(text.find("dttmm_instance"), std::string::npos) << entry.path();
        }
}

TEST(Layers, TheTopLevelHoldsWhatTheDesignNames) {
    const std::set<std::string> allowed = {
        "CMakeLists.txt", "CMakePresets.json", "LICENSE", "README.md", "plugin",
        "host",           "examples",          "tests",   "results"};  // results/ is ignored by git
    for (const auto& entry : fs::directory_iterator(kSource)) {
        const std::string name = entry.path().filename();
        if (name.front() != '.') {
            EXPECT_TRUE(allowed.contains(name)) << name;
        }
    }
}

}  // namespace
