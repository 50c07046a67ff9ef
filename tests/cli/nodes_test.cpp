// SPDX-License-Identifier: BSD-3-Clause
//
// A machine of lumps on springs (the plugin of tests/loader/chain) between a body and the ground, from its file to its
// results, and what a user can get wrong about nodes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cli/process.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::ElementsAre;
using testing::HasSubstr;

const std::string kChain = R"(format = "dttmm/1"

[simulation]
duration = "0.1 s"
step = "0.1 ms"

[modes]
count = 3

[nodes]
near = [0, 0, "0.3 m"]
far = { position = [0, 0, 0.6], fixed = ["x", "y"] }

[[body]]
name = "block"
mass = 3
inertia = [0.2, 0.3, 0.4]
position = [0, 0, 0.9]
markers.hook = [0, 0, "-1 cm"]

[[load]]
on = "far"
direction = [0, 0, 1]
force = { type = "step", from = 0, to = "40 N", start = 0, end = "50 ms" }

[[element]]
name = "foot"
type = "link"
from = "ground"
to = "near"
law = { stiffness = "5 N/mm", kind = "hard" }

[[element]]
name = "middle"
type = "link"
from = "near"
to = "far"
law.stiffness = 9000
strands = 2

[[element]]
name = "head"
type = "link"
from = "far"
to = "block.hook"
law.stiffness = 7000

[[element]]
name = "lumps"
type = "lump"
at = ["near", "far"]
mass = "500 g"
)";

std::string chain_with(const std::string& what, const std::string& instead) {
    std::string text = kChain;
    return text.replace(text.find(what), what.size(), instead);
}

Ended run_chain(const TemporaryFolder& folder, const char* command, const std::string& text) {
    write_text(folder / "chain.toml", text);
    return run_dttmm(folder.path(), {command, "chain.toml", "--plugin", test::paths::chain()});
}

// Oracle: what the file says must stand in the results: units, names, ends, words, nested tables; in the mean the foot
// carries the whole pull of 40 N, so that its peak is more; and the ledger closes to the scheme's second order, (omega
// h)^2/4 = 2e-4 of what was turned over.
TEST(NodesInAFile, AChainRunsFromItsFileToItsSummary) {
    const TemporaryFolder folder;
    const Ended ended = run_chain(folder, "run", kChain);
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, AllOf(HasSubstr("foot"), HasSubstr("head")));
    EXPECT_EQ(read_history(folder / "results/chain/history.csv").size(), 1001u);
    const auto summary = read_json(folder / "results/chain/summary.json");
    const auto& model = summary["model"];
    EXPECT_EQ(model["nodes"]["far"]["position"], nlohmann::json({0, 0, 0.6}));
    EXPECT_EQ(model["nodes"]["far"]["fixed"], nlohmann::json({"x", "y"}));
    EXPECT_EQ(model["elements"]["lumps"]["at"], nlohmann::json({"near", "far"}));
    EXPECT_EQ(model["elements"]["head"]["to"], "block.hook");
    EXPECT_EQ(model["elements"]["foot"]["from"], "ground");
    EXPECT_EQ(model["elements"]["foot"]["law"]["kind"], nlohmann::json({"hard"}));
    EXPECT_EQ(model["elements"]["foot"]["law"]["stiffness"], nlohmann::json({5000.0}));
    EXPECT_TRUE(model["elements"]["foot"]["slack"][0].is_null()) << "not given";
    EXPECT_EQ(model["loads"][0]["on"], "far");
    EXPECT_TRUE(summary["positions"].contains("near"));
    EXPECT_GT(summary["elements"]["foot"]["force"]["z"]["peak"].get<double>(), 40);
    EXPECT_LT(summary["energy"]["residual"]["peak"].get<double>(), 1e-3 * summary["energy"]["work"]["peak"].get<double>());
}

TEST(NodesInAFile, ChannelsOnRequestAreRecordedWhenAsked) {
    const TemporaryFolder folder;
    ASSERT_EQ(
        run_chain(folder, "run", chain_with("[modes]", "[output]\nchannels = [\"near.velocity\", \"far.*.z\"]\n[modes]"))
            .code,
        0);
    const std::string history = read_text(folder / "results/chain/history.csv");
    EXPECT_EQ(history.substr(0, history.find('\n')),
              "time,near.velocity.x,near.velocity.y,near.velocity.z,far.position.z,far.velocity.z");
}

TEST(NodesInAFile, AnElementMayBeCalledLikeANode) {
    const TemporaryFolder folder;
    ASSERT_EQ(run_chain(folder, "run", chain_with("name = \"foot\"", "name = \"near\"")).code, 0);
    const auto summary = read_json(folder / "results/chain/summary.json");
    EXPECT_TRUE(summary["elements"].contains("near"));
    EXPECT_TRUE(summary["positions"].contains("near"));
}

TEST(NodesInAFile, CheckCountsThem) {
    const TemporaryFolder folder;
    const Ended ended = run_chain(folder, "check", kChain);
    EXPECT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, AllOf(HasSubstr("1 body"), HasSubstr("2 nodes, 4 elements")));
}

// Oracle: statics. The foot carries the 40 N and swings about it, by less than half as the pull takes most of its period of
// 63 ms to rise.
TEST(NodesInAFile, AModelWithoutABodyRuns) {
    const TemporaryFolder folder;
    std::string text = kChain;
    const size_t body = text.find("[[body]]"), load = text.find("[[load]]");
    text.erase(body, load - body);
    const size_t head = text.find("[[element]]\nname = \"head\""), lumps = text.find("[[element]]\nname = \"lumps\"");
    text.erase(head, lumps - head);
    for (const char* command : {"check", "run"}) {
        const Ended ended = run_chain(folder, command, text);
        EXPECT_EQ(ended.code, 0) << ended.err;
        EXPECT_EQ(ended.err, "");
    }
    const auto summary = read_json(folder / "results/chain/summary.json");
    EXPECT_TRUE(summary["model"]["bodies"].empty());
    EXPECT_NEAR(summary["elements"]["foot"]["force"]["z"]["final"].get<double>(), 40, 20);
}

// Oracle: the plugin's own table.
TEST(NodesInAFile, ElementsPrintsWordsNestedNamesAndWhatIsOptional) {
    const Ended ended = run_dttmm("/", {"elements", "--plugin", test::paths::chain()});
    EXPECT_EQ(ended.code, 0);
    for (const char* part : {"link (from, to)", "lump (at)", "law.stiffness", ">= 0", "free", "default soft", "soft | hard",
                             "optional", "1 to 100, whole", "required"})
        EXPECT_THAT(ended.out, HasSubstr(part));
}

/// One fault: `instead` stands in the file for `what`; its place is counted by hand.
struct NodeFault {
    const char* name;
    std::string what, instead;
    const char* place;
    const char* says;
};
void PrintTo(const NodeFault& fault, std::ostream* out) { *out << fault.name; }

class WrongNodes : public testing::TestWithParam<NodeFault> {};

// Oracle: exit code 3, file:line:column, the fault in words, and nothing left behind.
TEST_P(WrongNodes, AreRefusedWithPlaceAndCure) {
    const TemporaryFolder folder;
    for (const char* command : {"run", "check"}) {
        const Ended ended = run_chain(folder, command, chain_with(GetParam().what, GetParam().instead));
        EXPECT_EQ(ended.code, 3) << ended.err;
        EXPECT_THAT(ended.err, HasSubstr(std::string("chain.toml:") + GetParam().place + ": "));
        EXPECT_THAT(ended.err, HasSubstr(GetParam().says));
        EXPECT_FALSE(fs::exists(folder / "results"));
    }
}

const NodeFault kNodeFaults[] = {
    {"PositionOfTwo", "[0, 0, \"0.3 m\"]", "[0, 0]", "11:8", "node \"near\" wants 3 numbers, got 2"},
    {"PositionInKilograms", "\"0.3 m\"", "\"3 kg\"", "11:15", "expected a value in m, got \"3 kg\""},
    {"NanPosition", "\"0.3 m\"", "nan", "11:15", "must be finite"},
    {"UnknownNodeKey", "fixed =", "fixd =", "12:33", "did you mean \"fixed\"?"},
    {"UnknownDirection", "[\"x\", \"y\"]", "[\"x\", \"phi\"]", "12:47", "\"phi\" is none of the directions x, y, z"},
    {"DirectionTwice", "[\"x\", \"y\"]", "[\"x\", \"x\"]", "12:47", "fixed names \"x\" twice"},
    {"NodeNamedLikeABody", "name = \"block\"", "name = \"near\"", "11:1", "the body on line 15 has the same name"},
    {"NodeNamedGround", "near = [", "ground = [0, 0, 0]\nnear = [", "11:1", "the name \"ground\" is reserved"},
    {"NodeNamedWithBlank", "near = [", "\"a b\" = [0, 0, 0]\nnear = [", "11:1", "a name is made of letters"},
    {"NodeUsedNowhere", "near = [", "spare = [0, 0, 0]\nnear = [", "11:1", "node \"spare\" is used nowhere"},
    {"NodeWithAMarker", "to = \"near\"", "to = \"near.hook\"", "30:6", "\"near\" is a node, which has no markers"},
    {"MisspeltNode", "to = \"near\"", "to = \"neer\"", "30:6", "no body or node \"neer\"; did you mean \"near\"?"},
    {"SameNode", "from = \"ground\"", "from = \"near\"", "30:6", "both ends are on the same node"},
    {"LumpOnABody", "[\"near\", \"far\"]", "\"block\"", "51:6", "\"block\" is a body; give the mass to the body"},
    {"LumpOnTheGround", "[\"near\", \"far\"]", "\"ground\"", "51:6", "the ground does not move"},
    {"LumpTwiceAtANode", "[\"near\", \"far\"]", "[\"far\", \"far\"]", "51:14", "\"far\" is named twice"},
    {"LumpFromTo", "at = [\"near\", \"far\"]", "from = \"near\"\nto = \"far\"", "51:1", "unknown key \"from\""},
    {"LinkAt", "from = \"ground\"\n", "at = \"near\"\n", "29:1", "unknown key \"at\""},
    {"JointOnANode", "[[load]]", "[[joint]]\nname = \"j\"\ntype = \"ball\"\nbetween = [\"block\", \"far\"]\n[[load]]",
     "24:21", "\"far\" is a node; a joint joins bodies"},
    {"LawIsNoTable", "law = { stiffness = \"5 N/mm\", kind = \"hard\" }", "law = 3", "31:7",
     "law: expected a table such as { stiffness = ... }, got a number"},
    {"MisspeltLaw", "law = {", "lav = {", "31:1", "unknown key \"lav\" in [[element]] number 1; did you mean \"law\"?"},
    {"MisspeltNestedKey", "kind =", "knd =", "31:31", "law: unknown key \"knd\"; did you mean \"kind\"?"},
    {"MissingNestedKey", "stiffness = \"5 N/mm\", ", "", "31:7", "law: missing key \"stiffness\""},
    {"MissingTable", "law.stiffness = 7000\n", "", "41:1", "missing key \"law.stiffness\""},
    {"MisspeltWord", "\"hard\"", "\"herd\"", "31:38",
     "kind must be one of: soft, hard; got \"herd\"; did you mean \"hard\"?"},
    {"NumberForAWord", "\"hard\"", "2", "31:38", "kind must be one of: soft, hard; got a number"},
    {"WordForANumber", "\"5 N/mm\"", "\"fre\"", "31:21", "must be a number in N/m or one of: free; got \"fre\""},
    {"WordOfNone", "\"500 g\"", "\"heavy\"", "52:8", "heavy"},
    {"NotWhole", "strands = 2", "strands = 2.5", "39:11", "strands must be a whole number, got 2.5"},
    {"RefusedByThePlugin", "\"500 g\"", "13", "48:1", "element \"lumps\" (plugin "},
    {"Dofs", "[simulation]", "dofs = [\"x\"]\n[simulation]", "3:1", "dofs is for `dttmm modes`"},
};

INSTANTIATE_TEST_SUITE_P(Command, WrongNodes, testing::ValuesIn(kNodeFaults),
                         [](const auto& one) { return one.param.name; });

}  // namespace
}  // namespace dttmm::host
