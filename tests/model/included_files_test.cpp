// SPDX-License-Identifier: BSD-3-Clause
#include "model/included_files.h"

#include <fstream>

#include "model/test_model.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

void write(const std::filesystem::path& file, const std::string& text) {
    std::filesystem::create_directories(file.parent_path());
    std::ofstream(file) << text;
}

class IncludedFiles : public testing::Test {
protected:
    /// A model whose second line, line 4, is that of the key.
    Model read(const std::string& include, const std::string& rest = "") {
        write(folder_ / "m.toml", std::string(kStart) + "include = " + include + "\n" + kSimulation + kBody + rest);
        return read_model(folder_ / "m.toml", test_catalogue());
    }
    std::string fault(const std::string& include, const std::string& rest = "") {
        std::string text = error_of([&] { read(include, rest); });
        const std::string root = folder_.path().string() + "/";
        for (std::size_t at = text.find(root); at != text.npos; at = text.find(root)) text.erase(at, root.size());
        return text;
    }
    void add(const std::string& name, const std::string& text) { write(folder_ / name, text); }

    TemporaryFolder folder_;
};

const std::string kBolt = "[[element]]\nname = \"bolt\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"plate.a\"\n";

// Oracle: the same tables in one file; included ones first. Names are relative to the file that includes.
TEST_F(IncludedFiles, ComeInFrontAndMayIncludeOthers) {
    add("parts/bolts.toml", "format = \"dttmm/1\"\ninclude = [\"more/k.toml\"]\n" + kBolt + "stiffness = \"=k\"\n");
    add("parts/more/k.toml", "[parameters]\nk = 5\n[defaults.spring_damper]\ndamping = 3\n");
    add("parts/more/pull.csv", "0,0\n1,7\n");
    add("load.toml",
        "[[load]]\non = \"plate\"\ndirection = [0, 0, 1]\nforce = { type = \"table\", file = \"more/pull.csv\" }\n");
    std::filesystem::rename(folder_ / "load.toml", folder_ / "parts/load.toml");
    const Model model = read("[\"parts/bolts.toml\", \"parts/load.toml\"]", "[parameters]\nj = 2\n");
    ASSERT_EQ(model.elements.size(), 1u);
    EXPECT_EQ(model.elements[0].values[0], 5);
    EXPECT_EQ(model.elements[0].values[3], 3);
    EXPECT_EQ(model.parameters[0].name, "k");
    EXPECT_EQ(model.parameters[1].name, "j");
    EXPECT_EQ(model.loads[0].signal.value(1), 7);
    EXPECT_THAT(model.files, ElementsAre(folder_ / "parts/bolts.toml", folder_ / "parts/more/k.toml",
                                         folder_ / "parts/load.toml", folder_ / "parts/more/pull.csv"));
}

TEST_F(IncludedFiles, FaultsNameTheFileAndLineOfTheIncludedOne) {
    add("bolts.toml", kBolt + "stifness = 5\n");
    EXPECT_THAT(fault("[\"bolts.toml\"]"), HasSubstr("bolts.toml:6:1: element \"bolt\": unknown key \"stifness\""));
    add("bolts.toml", kBolt + "stiffness = 5,3\n");
    EXPECT_THAT(fault("[\"bolts.toml\"]"), HasSubstr("bolts.toml:6:14: "));
    add("bolts.toml", kBolt + "stiffness = 5\n");
    EXPECT_THAT(fault("[\"bolts.toml\"]", kBolt),
                HasSubstr("m.toml:14:8: element name \"bolt\" on line 14 is taken already, on line 2 of "));
    add("settings.toml", "[simulation]\nstep = 3\n");
    EXPECT_THAT(fault("[\"settings.toml\"]"),
                HasSubstr("m.toml:7:1: \"step\" is given already, on line 2 of settings.toml; leave "
                          "one of them out"));
    add("settings.toml", "title = \"x\"\n");
    EXPECT_THAT(fault("[\"settings.toml\"]"), HasSubstr("m.toml:2:1: \"title\" is given already"));
    add("settings.toml", "format = \"dttmm/2\"\n");
    EXPECT_THAT(fault("[\"settings.toml\"]"), HasSubstr("settings.toml:1:10: this version reads format \"dttmm/1\" only"));
}

TEST_F(IncludedFiles, FaultsOfTheKeyPointAtIt) {
    EXPECT_THAT(fault("[\"none.toml\"]"), HasSubstr("m.toml:4:12: include: none.toml: there is no such file"));
    EXPECT_THAT(fault("\"bolts.toml\""),
                HasSubstr("m.toml:4:11: include must be a list of files, as [\"bolts.toml\"], got a text"));
    EXPECT_THAT(fault("[3]"), HasSubstr("m.toml:4:12: include: a file is named by a text"));
    EXPECT_THAT(fault("[\".\"]"), HasSubstr("is not a regular file"));
    EXPECT_THAT(fault("[\"m.toml\"]"), HasSubstr("m.toml:4:12: include: \"m.toml\" is the model file itself"));
    add("a.toml", "include = [\"b.toml\"]\n");
    add("b.toml", "include = [\"x/../a.toml\"]\n");
    std::filesystem::create_directory(folder_ / "x");
    EXPECT_THAT(fault("[\"a.toml\"]"),
                HasSubstr("b.toml:1:12: include: \"x/../a.toml\" includes itself by way of others, on line 4"));
}

// Bolts and beams that both want the same materials have them once.
TEST_F(IncludedFiles, AFileThatTwoIncludeIsThereOnce) {
    add("steel.toml", "[parameters]\nE = \"210 GPa\"\n");
    add("a.toml", "include = [\"steel.toml\"]\n");
    add("b.toml", "include = [\"steel.toml\", \"a.toml\"]\n");
    EXPECT_EQ(read("[\"a.toml\", \"b.toml\"]").parameters.front().value, 210e9);
}

}  // namespace
}  // namespace dttmm::host
