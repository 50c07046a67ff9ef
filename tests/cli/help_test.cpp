// SPDX-License-Identifier: BSD-3-Clause
//
// What the program says of itself: help, schema, completion, manual, first models.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <regex>
#include <set>

#include "cli/process.h"
#include "cli/small_model.h"
#include "model/keys.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> lines(const std::string& text) {
    std::vector<std::string> found;
    std::istringstream stream(text);
    for (std::string line; std::getline(stream, line);) found.push_back(line);
    return found;
}

/// The complete model at the end of a help text.
std::string model_in(const std::string& help) {
    const size_t begin = help.find("format = \"dttmm/1\"");
    return begin == std::string::npos ? "" : help.substr(begin);
}

/// Whether a program is there to test with.
bool has(const std::string& program) { return std::system(("command -v " + program + " > /dev/null 2>&1").c_str()) == 0; }

/// Ends a command of the shell; returns what it printed.
std::string shell(const fs::path& folder, const std::string& command) {
    const fs::path out = folder / "shell.out";
    const std::string all = fmt::format("cd {} && PATH={}:$PATH bash -c '{}' > {} 2>&1", folder.string(),
                                        fs::path(test::paths::command()).parent_path().string(), command, out.string());
    EXPECT_EQ(std::system(all.c_str()), 0) << read_text(out);
    return read_text(out);
}

TEST(Help, ShowsEveryKeyOfEveryTable) {
    const std::string topics = run_dttmm("/", {"help"}).out;
    for (const KeyTable& table : key_tables()) {
        const Ended ended = run_dttmm("/", {"help", table.name});
        EXPECT_EQ(ended.code, 0) << ended.err;
        EXPECT_THAT(topics, HasSubstr(fmt::format("\n    {} ", table.name)));
        for (const Key& key : table.keys)
            EXPECT_THAT(ended.out, HasSubstr(fmt::format("\n    {} ", key.name))) << table.name;
    }
}

// Oracle: the file beside the host's README, made by the command that it names.
TEST(Help, MakesTheReference) {
    EXPECT_EQ(run_dttmm("/", {"help", "reference"}).out,
              read_text(fs::path(test::paths::source_dir()) / "host/reference.md"));
}

TEST(Help, TellsElementsToPrograms) {
    const nlohmann::json all = nlohmann::json::parse(run_dttmm("/", {"elements", "--json"}).out);
    EXPECT_EQ(all.size(), 8u);
    const nlohmann::json beam = nlohmann::json::parse(run_dttmm("/", {"elements", "beam", "--json"}).out);
    ASSERT_EQ(beam.size(), 1u);
    EXPECT_EQ(beam[0].at("type"), "beam");
    EXPECT_EQ(beam[0].at("parameters")[0].at("words"), nlohmann::json({"euler-bernoulli", "timoshenko"}));
    EXPECT_EQ(beam[0].at("parameters")[1].at("at_most"), 100000);
}

// Oracle: the half sine that the help shows has the right impulse, F T 2/π, on a free mass.
TEST(Help, KnowsUnitsAndExpressions) {
    EXPECT_THAT(run_dttmm("/", {"help"}).out, HasSubstr("\n    units "));
    EXPECT_THAT(run_dttmm("/", {"help", "units"}).out, HasSubstr("rad/s      deg/s, rpm\n"));
    const std::string help = run_dttmm("/", {"help", "expressions"}).out;
    EXPECT_THAT(help, HasSubstr(" atan2 "));
    std::smatch found;
    ASSERT_TRUE(std::regex_search(help, found, std::regex("force     = (\".*?\")"))) << help;
    const TemporaryFolder folder;
    write_text(folder / "model.toml", fmt::format(R"(format = "dttmm/1"
parameters = {{ T = "3 ms" }}
simulation = {{ duration = "5 ms", step = "10 us" }}
output = {{ channels = ["ball.velocity.x"] }}
body = [{{ name = "ball", mass = 2.5, sphere = 0.1 }}]
load = [{{ on = "ball", direction = [1, 0, 0], force = {} }}]
)",
                                                  found[1].str()));
    EXPECT_EQ(run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "out"}).code, 0);
    const std::string history = read_text(folder / "out/history.csv");
    EXPECT_NEAR(std::stod(history.substr(history.rfind(',') + 1)), 800 * 3e-3 * 2 / M_PI / 2.5, 1e-4);
}

// Oracle: the model is valid, has an element of that type, and runs.
TEST(Help, ShowsEveryElementTypeInAModelThatRuns) {
    const TemporaryFolder folder;
    for (const char* type : {"spring_damper", "elastic_hinge", "beam", "rod", "point_mass", "rigid_body"}) {
        const Ended help = run_dttmm("/", {"help", type});
        EXPECT_EQ(help.code, 0);
        EXPECT_THAT(help.out,
                    HasSubstr(std::string(type) == "beam" || std::string(type) == "rod" ? "Local x leads" : "xes are"));
        write_text(folder / "model.toml", model_in(help.out));
        EXPECT_THAT(model_in(help.out), testing::ContainsRegex(fmt::format("type +[=] \"{}\"", type)));
        const Ended run = run_dttmm(folder.path(), {"run", ".", "-q", "-o", "out"});
        EXPECT_EQ(run.code, 0) << type << run.err;
        EXPECT_EQ(run.err, "") << type;
    }
}

// Oracle: the model is valid, has a table of that kind, and runs.
TEST(Help, ShowsPatternsInModelsThatRun) {
    const TemporaryFolder folder;
    for (const std::string topic : {"repeat", "body.repeat", "bolt_circle", "probe", "section"}) {
        const Ended help = run_dttmm("/", {"help", topic});
        EXPECT_EQ(help.code, 0);
        write_text(folder / "model.toml", model_in(help.out));
        EXPECT_THAT(model_in(help.out), HasSubstr(topic == "section" ? "sections = [" : "[[" + topic + "]]"));
        const Ended run = run_dttmm(folder.path(), {"run", ".", "-q", "-o", "out"});
        EXPECT_EQ(run.code, 0) << topic << run.err;
        EXPECT_EQ(run.err, "") << topic;
    }
}

// Oracle: the words of the fault; a topic of a foreign plugin comes from its table.
TEST(Help, KnowsForeignElementsAndNearTopics) {
    const Ended wrong = run_dttmm("/", {"help", "beem"});
    EXPECT_EQ(wrong.code, 2);
    EXPECT_THAT(wrong.err, HasSubstr("there is no help on \"beem\"; did you mean \"beam\"?"));
    const Ended foreign = run_dttmm("/", {"help", "link", "--plugin", test::paths::chain()});
    EXPECT_EQ(foreign.code, 0);
    EXPECT_THAT(foreign.out, HasSubstr("law.stiffness"));
    EXPECT_THAT(run_dttmm("/", {"elements", "rod"}).out, HasSubstr("material.E"));
    EXPECT_EQ(run_dttmm("/", {"elements", "rode"}).code, 2);
    EXPECT_EQ(run_dttmm("/", {"help", "frf"}).out, run_dttmm("/", {"frf", "--help"}).out);
}

/// All texts under "$ref".
void collect_references(const nlohmann::json& json, std::set<std::string>& found) {
    if (json.is_object() && json.contains("$ref")) found.insert(json["$ref"].get<std::string>());
    for (const auto& inner : json)
        if (inner.is_structured()) collect_references(inner, found);
}

TEST(Schema, IsTheOneBesideTheExamples) {
    const fs::path examples = fs::path(test::paths::source_dir()) / "examples";
    const std::string schema = run_dttmm("/", {"schema"}).out;
    EXPECT_EQ(schema, read_text(examples / "model.schema.json")) << "run: dttmm schema > examples/model.schema.json";
    EXPECT_EQ(run_dttmm("/", {"schema", "--plugin", test::paths::c_spring()}).out,
              read_text(examples / "minimal_plugin/model.schema.json"));
    EXPECT_EQ(run_dttmm("/", {"schema", "--plugin", test::paths::jenkins()}).out,
              read_text(examples / "minimal_law/model.schema.json"));
    const nlohmann::json json = nlohmann::json::parse(schema);
    std::set<std::string> references;
    collect_references(json, references);
    EXPECT_GE(references.size(), 9u);
    for (const std::string& reference : references)
        EXPECT_TRUE(json.contains(nlohmann::json::json_pointer(reference.substr(1)))) << reference;
    for (const auto& folder : fs::directory_iterator(examples)) {
        if (!folder.is_directory()) continue;
        const bool is_foreign = folder.path().filename().string().starts_with("minimal_");
        EXPECT_TRUE(read_text(folder.path() / "model.toml")
                        .starts_with(is_foreign ? "#:schema ./model.schema.json\n" : "#:schema ../model.schema.json\n"))
            << folder.path();
    }
}

/// A model with one fault, and whether a schema can see it.
struct Fault {
    const char* what;
    const char* instead;
};

// Oracle: two linters of others. All examples pass; a wrong key, type or missing key does not.
TEST(Schema, LintersTakeTheExamplesAndFindFaults) {
    const TemporaryFolder folder;
    const fs::path examples = fs::path(test::paths::source_dir()) / "examples";
    fs::create_directories(folder / "a");
    fs::copy_file(examples / "model.schema.json", folder / "model.schema.json");
    const std::string good = read_text(examples / "four_bolt_plate/model.toml");
    const std::string linters[] = {
        "tombi lint --offline a/model.toml",
        fmt::format("taplo lint --schema file://{}/model.schema.json a/model.toml", folder.path().string())};
    int tried = 0;
    for (const std::string& linter : linters) {
        if (!has(linter.substr(0, linter.find(' ')))) continue;
        ++tried;
        const auto passes = [&](const std::string& text) {
            write_text(folder / "a/model.toml", text);
            return std::system(fmt::format("cd {} && {} > lint.out 2>&1", folder.path().string(), linter).c_str()) == 0;
        };
        for (const auto& example : fs::directory_iterator(examples)) {
            if (!example.is_directory() || example.path().filename().string().starts_with("minimal_")) continue;
            EXPECT_TRUE(passes(read_text(example.path() / "model.toml")))
                << example.path() << read_text(folder / "lint.out");
        }
        for (const Fault& fault : {Fault{"\nduration", "\ndurration"},
                                   {"\nstiffness", "\nstifness"},
                                   {"\"spring_damper\"", "\"sprung\""},
                                   {"coupling = \"implicit\"", "coupling = \"half\""},
                                   {"\ndirection", "\ndirections"}}) {
            std::string bad = good;
            bad.replace(bad.find(fault.what), std::string(fault.what).size(), fault.instead);
            EXPECT_FALSE(passes(bad)) << linter << fault.instead;
        }
    }
    if (tried == 0) GTEST_SKIP() << "neither tombi nor taplo is installed (npm install tombi @taplo/cli)";
}

TEST(Completion, KnowsCommandsOptionsTopicsAndWhatIsInTheModel) {
    const TemporaryFolder folder;
    write_text(folder / "small.toml", kSmallModel);
    const auto complete = [&](std::vector<std::string> words) {
        words.insert(words.begin(), "complete");
        const Ended ended = run_dttmm(folder.path(), words);
        EXPECT_EQ(ended.code, 0);
        EXPECT_EQ(ended.err, "");
        return lines(ended.out);
    };
    EXPECT_THAT(complete({"c"}), ElementsAre("check", "channels", "check-law", "completion"));
    EXPECT_THAT(complete({"run", "--to"}), ElementsAre("--tolerance"));
    EXPECT_THAT(complete({"run", "small.toml", "--se"}), ElementsAre("--set"));
    EXPECT_THAT(complete({"run", "small.toml", "--set", ""}), Contains("mass="));
    EXPECT_THAT(complete({"run", "small.toml", "--coupling", ""}), ElementsAre("implicit", "explicit"));
    EXPECT_THAT(complete({"run", "-o", "out", "small.toml", "--channels", "two.force."}),
                ElementsAre("two.force.x", "two.force.y", "two.force.z"));
    EXPECT_THAT(complete({"channels", "small.toml", "plate.acc"}).size(), 3u);
    EXPECT_THAT(complete({"frf", "small.toml", "--in", "plate.right.r"}),
                ElementsAre("plate.right.rx", "plate.right.ry", "plate.right.rz"));
    EXPECT_THAT(complete({"spectrum", "out", "--wi"}), ElementsAre("--window"));
    EXPECT_THAT(complete({"spectrum", "out", "--window", "f"}), ElementsAre("flattop"));
    fs::create_directory(folder / "out");
    write_text(folder / "out/history.csv", "time,one.force.x,two.force.x\ns,N,N\n");
    EXPECT_THAT(complete({"spectrum", "out", "--channels", "t"}), ElementsAre("two.force.x"));
    EXPECT_THAT(complete({"spectrum", "nowhere", "--speed", ""}), ElementsAre());
    EXPECT_THAT(complete({"report", "out", "--channels", "t"}), ElementsAre("two.force.x"));
    EXPECT_THAT(complete({"help", "be"}), ElementsAre("beam"));
    EXPECT_THAT(complete({"help", "--plugin", test::paths::chain(), "lu"}), ElementsAre("lump"));
    EXPECT_THAT(complete({"completion", "z"}), ElementsAre("zsh"));
    EXPECT_THAT(complete({"run", "sm"}), ElementsAre());  // a file: the shell completes it
    EXPECT_THAT(complete({"run", "missing.toml", "--set", ""}), ElementsAre());
    EXPECT_THAT(complete({"rum", ""}), ElementsAre());
    EXPECT_THAT(complete({"run", "-", "--set", ""}), ElementsAre());  // and does not wait for the standard input
    fs::create_directory(folder / "a b");
    write_text(folder / "a b/model.toml", kSmallModel);
    EXPECT_THAT(complete({"run", "a\\ b", "--set", "ma"}), ElementsAre("mass="));
    EXPECT_THAT(complete({"run", "\"a b\"", "--set", "ma"}), ElementsAre("mass="));
}

// Oracle: bash itself.
TEST(Completion, WorksInBash) {
    const TemporaryFolder folder;
    write_text(folder / "small.toml", kSmallModel);
    const auto complete = [&](const std::string& words) {
        return shell(folder.path(), fmt::format("source <(dttmm completion bash); COMP_WORDS=({}); "
                                                "COMP_CWORD=$((${{#COMP_WORDS[@]}}-1)); _dttmm; echo \"${{COMPREPLY[*]}}\"",
                                                words));
    };
    EXPECT_EQ(complete("dttmm mo"), "modes\n");
    EXPECT_EQ(complete("dttmm run small.toml --set ma"), "mass=\n");
    EXPECT_EQ(run_dttmm("/", {"completion", "ksh"}).code, 2);
}

// Oracle: groff, which warns of what is no macro; every command and option is named.
TEST(Manual, IsAManualPage) {
    const TemporaryFolder folder;
    const Ended manual = run_dttmm("/", {"manual"});
    EXPECT_EQ(manual.code, 0);
    for (const char* word : {"run", "check", "modes", "frf", "\\-\\-sweep", "\\-\\-output\\-step", "130"})
        EXPECT_THAT(manual.out, HasSubstr(word));
    if (!has("groff")) GTEST_SKIP() << "groff is not installed";
    write_text(folder / "dttmm.1", manual.out);
    EXPECT_THAT(shell(folder.path(), "groff -man -Tutf8 -ww dttmm.1 | head -5"), HasSubstr("DTTMM(1)"));
    EXPECT_EQ(shell(folder.path(), "groff -man -Tutf8 -ww dttmm.1 > /dev/null"), "");
}

// Oracle: each kind does what its next command says; nothing is replaced.
TEST(New, MakesAModelThatWorks) {
    const TemporaryFolder folder;
    for (const char* kind : {"plate", "mounts", "beam", "modes"}) {
        const Ended made = run_dttmm(folder.path(), {"new", std::string("my ") + kind, "--from", kind});
        EXPECT_EQ(made.code, 0) << made.err;
        EXPECT_TRUE(fs::exists(folder / (std::string("my ") + kind + "/model.schema.json")));
        const std::string command = made.out.find("dttmm run") != std::string::npos ? "run" : "modes";
        EXPECT_EQ(command == "modes", std::string(kind) == "modes");
        const Ended ended = run_dttmm(folder.path(), {command, std::string("my ") + kind, "-q"});
        EXPECT_EQ(ended.code, 0) << ended.err;
    }
    const Ended again = run_dttmm(folder.path(), {"new", "my plate"});
    EXPECT_EQ(again.code, 5);
    EXPECT_THAT(again.err, HasSubstr("is there already; nothing was written"));
    EXPECT_EQ(run_dttmm(folder.path(), {"new", "other", "--from", "boat"}).code, 2);
    EXPECT_EQ(run_dttmm(folder.path(), {"new", "other", "--plugin", "missing.so"}).code, 7);
    EXPECT_FALSE(fs::exists(folder / "other"));
}

// Oracle: the code for output, as of every other command.
TEST(Version, OnAFullDiskIsAFailure) {
    const TemporaryFolder folder;
    for (const char* words : {"--version", "run --help", "help"})
        EXPECT_EQ(shell(folder.path(), fmt::format("dttmm {} > /dev/full 2> /dev/null; echo $?", words)), "5\n") << words;
}

// Oracle: the same rows.
TEST(ModelFile, ComesFromItsFolderAndFromTheStandardInputToo) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", kSmallModel);
    EXPECT_EQ(run_dttmm(folder.path(), {"run", "model.toml", "-q", "-o", "a"}).code, 0);
    EXPECT_EQ(run_dttmm(folder.path(), {"run", ".", "-q", "-o", "b"}).code, 0);
    shell(folder.path(), "dttmm run - -q -o c < model.toml");
    for (const char* other : {"b", "c"})
        EXPECT_EQ(read_text(folder / "a/history.csv"), read_text(folder / other / "history.csv"));
    EXPECT_THAT(shell(folder.path(), "sed s/mass/maas/ model.toml | dttmm check - || true"), HasSubstr("<standard input>:"));
    EXPECT_THAT(shell(folder.path(), "dttmm run - --sweep mass=3kg,4kg < model.toml || true"),
                HasSubstr("a sweep reads its model once per case"));
}

// Oracle: each file by itself; the code is the largest.
TEST(Check, TakesSeveralFiles) {
    const TemporaryFolder folder;
    write_text(folder / "good.toml", kSmallModel);
    write_text(folder / "bad.toml", std::regex_replace(std::string(kSmallModel), std::regex("mass "), "maas "));
    const Ended ended = run_dttmm(folder.path(), {"check", "good.toml", "bad.toml", "missing.toml", "good.toml"});
    EXPECT_EQ(ended.code, 5);
    EXPECT_THAT(ended.err, testing::AllOf(HasSubstr("bad.toml:"), HasSubstr("dttmm: missing.toml: there is no such file")));
    EXPECT_EQ(ended.out, run_dttmm(folder.path(), {"check", "good.toml", "good.toml"}).out);
    // A mistyped key is one fault
    EXPECT_THAT(ended.err, HasSubstr("did you mean \"mass\"?"));
    EXPECT_THAT(ended.err, testing::Not(HasSubstr("missing key \"mass\"")));
}

TEST(Run, SaysWhichResultsItReplaces) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", kSmallModel);
    EXPECT_THAT(run_dttmm(folder.path(), {"run", ".", "-o", "out"}).out, testing::EndsWith("results in out\n"));
    EXPECT_THAT(run_dttmm(folder.path(), {"run", ".", "-o", "out"}).out,
                testing::ContainsRegex("results in out .those of 20[0-9-]+ [0-9:]+ are replaced.\n"));
    EXPECT_THAT(run_dttmm(folder.path(), {"modes", ".", "-o", "out"}).out, HasSubstr("are replaced)\n"));
}

// Oracle: the summaries of the cases.
TEST(SweepTable, OnTheScreenHasThePeaks) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", kSmallModel);
    const Ended ended = run_dttmm(folder.path(), {"run", ".", "--sweep", "mass=3kg,4kg", "-o", "out"});
    EXPECT_EQ(ended.code, 0);
    for (const char* name : {"case-000001", "case-000002"}) {
        const nlohmann::json summary = read_json(folder / "out" / name / "summary.json");
        double peak = 0;
        for (const auto& axis : summary["elements"]["two"]["force"]) peak = std::max(peak, axis["peak"].get<double>());
        EXPECT_THAT(ended.out, HasSubstr(fmt::format("{:.5g}", peak)));
    }
    EXPECT_THAT(ended.out, HasSubstr("case  mass"));
}

}  // namespace
}  // namespace dttmm::host
