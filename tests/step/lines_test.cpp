// SPDX-License-Identifier: BSD-3-Clause
//
// Where beams are between their ends, for pictures of a run: against the same beam cut by a node.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "model/read_model.h"
#include "step/simulation.h"

namespace dttmm::host {
namespace {

using Path = std::vector<Eigen::Vector3d>;

constexpr const char* kHead = R"(format = "dttmm/1"
[simulation]
duration = "30 ms"
step = "0.2 ms"
gravity = [0.5, -4, -9]
)";

/// A beam from a wall at a slant, alone or cut in the middle, whose tip is pulled.
std::string beam(bool is_cut, int segments) {
    std::string text = kHead;
    text += "[nodes]\nwall = { position = [0.1, 0.2, 0.3], fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"] }\n";
    text += is_cut ? "middle = [0.3, 0.3, 0.4]\ntip = [0.5, 0.4, 0.5]\n" : "tip = [0.5, 0.4, 0.5]\n";
    const auto piece = [&](const char* name, const char* from, const char* to, int count) {
        text += fmt::format(
            "[[element]]\nname = \"{}\"\ntype = \"beam\"\nfrom = \"{}\"\nto = \"{}\"\nsegments = {}\nsection = {{ tube = "
            "[\"30 mm\", \"20 mm\"] }}\nmaterial = {{ E = \"210 GPa\", poisson = 0.3, density = 7850 }}\n",
            name, from, to, count);
    };
    piece("arm", "wall", is_cut ? "middle" : "tip", is_cut ? segments / 2 : segments);
    if (is_cut) piece("hand", "middle", "tip", segments / 2);
    return text +
           "[[load]]\non = \"tip\"\ndirection = [0.3, -1, 2]\nforce = { type = \"step\", from = 0, to = 900, start = 0, "
           "end = 0.004 }\n";
}

/// Way of one point over the rows; owner and quantity of its three channels.
Path path(const std::string& text, const std::string& owner, const std::string& quantity) {
    const Plugins plugins;
    Model model = parse_model(text, "beam.toml", plugins.catalogue(), {});
    model.output.has_lines = true;
    Simulation simulation(model, plugins);
    std::vector<size_t> columns;
    const std::vector<Channel>& channels = simulation.channels();
    for (size_t c = 0; c < channels.size(); ++c)
        if (channels[c].owner() == owner && channels[c].quantity() == quantity) columns.push_back(c);
    Path way;
    if (columns.size() != 3) {
        ADD_FAILURE() << "no channel " << owner << "." << quantity;
        return way;
    }
    simulation.record_to(
        [&](std::span<const double> row) { way.emplace_back(row[columns[0]], row[columns[1]], row[columns[2]]); });
    while (simulation.index() < simulation.step_count()) simulation.step();
    return way;
}

double largest_distance(const Path& one, const Path& other) {
    EXPECT_EQ(one.size(), other.size());
    double most = 0;
    for (size_t row = 0; row < std::min(one.size(), other.size()); ++row)
        most = std::max(most, (one[row] - other[row]).norm());
    return most;
}

TEST(Lines, HaveTheirStationsWhereShorterBeamsHaveThem) {
    const std::string whole = beam(false, 20), cut = beam(true, 20);
    const Path second = path(whole, "arm", "station2.position"), eighth = path(whole, "arm", "station8.position");
    EXPECT_GT(largest_distance(eighth, Path(eighth.size(), eighth.front())), 1e-3) << "it moves";
    EXPECT_LT(largest_distance(second, path(cut, "arm", "station4.position")), 1e-9);
    EXPECT_LT(largest_distance(eighth, path(cut, "hand", "station6.position")), 1e-9);
    EXPECT_EQ(largest_distance(path(whole, "arm", "station10.position"), path(whole, "tip", "position")), 0);
    const Path wall = path(whole, "arm", "station0.position");
    EXPECT_EQ(largest_distance(wall, Path(wall.size(), Eigen::Vector3d(0.1, 0.2, 0.3))), 0);
}

// In the middle the one has a joint of lumps, the other a node: alike to the square of the length of a segment.
TEST(Lines, TendToTheNodesOfFinerBeamsWithTheSquareOfTheSegment) {
    const auto misfit = [](int segments) {
        return largest_distance(path(beam(false, segments), "arm", "station5.position"),
                                path(beam(true, segments), "middle", "position"));
    };
    const double coarse = misfit(20), fine = misfit(60);
    EXPECT_LT(coarse, 1e-5);
    EXPECT_NEAR(coarse / fine, 9, 0.5);
}

// Of five segments every second station is a section; those between are the middles of the straight lines. Of ten they are
// sections themselves.
TEST(Lines, AreStraightBetweenSections) {
    const auto bend = [](int segments) {
        const std::string text = beam(false, segments);
        const Path left = path(text, "arm", "station4.position"), right = path(text, "arm", "station6.position");
        Path middle;
        for (size_t row = 0; row < left.size(); ++row) middle.push_back(0.5 * (left[row] + right[row]));
        return largest_distance(path(text, "arm", "station5.position"), middle);
    };
    EXPECT_LT(bend(5), 1e-15);
    EXPECT_GT(bend(10), 1e-5);
}

// Elements that stand at nodes have no line; those before, between and behind them keep theirs.
TEST(Lines, LeaveOutWhatStandsAtNodes) {
    const auto mass = [](const char* name, const char* node) {
        return fmt::format("[[element]]\nname = \"{}\"\ntype = \"point_mass\"\nat = \"{}\"\nmass = 0.3\n", name, node);
    };
    std::string text = beam(true, 20);
    text.insert(text.find("[[element]]"), mass("first", "tip"));
    text.insert(text.find("[[element]]\nname = \"hand\""), mass("second", "middle"));
    text += mass("third", "tip");
    EXPECT_EQ(largest_distance(path(text, "hand", "station10.position"), path(text, "tip", "position")), 0);
    EXPECT_EQ(largest_distance(path(text, "arm", "station10.position"), path(text, "middle", "position")), 0);
    EXPECT_GT(largest_distance(path(text, "arm", "station10.position"), path(beam(true, 20), "middle", "position")), 1e-6);
}

// A wall that moves has a place of its own, where the beam begins.
TEST(Lines, BeginWhereTheirSupportIs) {
    std::string text = beam(false, 20);
    const std::string fixed = "\"rx\", \"ry\", \"rz\"]";
    text.insert(text.find(fixed) + fixed.size(),
                ", motion = { z = \"=0.05*(1 - cos(300*t))\", ry = \"=0.2*(1 - cos(200*t))\" }");
    const Path wall = path(text, "wall", "position"), turned = path(text, "wall", "rotation");
    EXPECT_LT(largest_distance(wall, path(text, "arm", "station0.position")), 1e-14);
    ASSERT_EQ(wall.size(), 151u);
    EXPECT_NEAR(wall[100].z(), 0.3 + 0.05 * (1 - std::cos(300 * 0.02)), 1e-12);
    EXPECT_NEAR(turned[100].y(), 0.2 * (1 - std::cos(200 * 0.02)), 1e-12);
}

TEST(Lines, AreNoChannelsUnlessAskedFor) {
    const Plugins plugins;
    const Simulation simulation(parse_model(beam(false, 5), "beam.toml", plugins.catalogue(), {}), plugins);
    for (const Channel& channel : simulation.channels()) EXPECT_FALSE(channel.quantity().starts_with("station"));
}

}  // namespace
}  // namespace dttmm::host
