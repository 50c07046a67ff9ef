// SPDX-License-Identifier: BSD-3-Clause
#include "report/three_views.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <regex>

#include "loader/plugins.h"

namespace dttmm::host {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using ::testing::HasSubstr;
using ::testing::Not;

/// Views in the order of the picture: front, top, right, corner.
std::vector<std::string> views_in(const std::string& svg) {
    std::vector<std::string> views;
    for (std::size_t at = svg.find("<g>"); at != svg.npos; at = svg.find("<g>", at + 1))
        views.push_back(svg.substr(at, svg.find("</g>", at) - at));
    return views;
}

std::vector<double> numbers_in(const std::string& text) {
    std::vector<double> numbers;
    const std::regex number("-?[0-9]+\\.?[0-9]*");
    for (std::sregex_iterator found(text.begin(), text.end(), number), end; found != end; ++found)
        numbers.push_back(std::stod(found->str()));
    return numbers;
}

/// Numbers of the paths of a class, path by path.
std::vector<std::vector<double>> paths_in(const std::string& view, const std::string& kind) {
    std::vector<std::vector<double>> paths;
    const std::regex path("<path class=\"" + kind + "\" d=\"([^\"]*)\"");
    for (std::sregex_iterator found(view.begin(), view.end(), path), end; found != end; ++found)
        paths.push_back(numbers_in((*found)[1]));
    return paths;
}

/// Two bodies of different size, a spring between them, a beam to a held node, a load and a turning joint.
Model crane() {
    Model model;
    model.title = "Crane <1>";
    Body post;
    post.name = "post";
    post.mass = 12;
    post.position = {0.5, 0.25, 1};
    const Vector3d edges(0.4, 0.6, 2);
    for (int i = 0; i < 3; ++i) post.inertia(i, i) = 12. / 12 * (edges.squaredNorm() - edges[i] * edges[i]);
    post.markers.push_back({"top", {0.1, 0, 1.2}, nullptr});
    Node anchor;
    anchor.name = "anchor";
    anchor.position = {3, -1, 0.5};
    anchor.fixed.set();
    model.bodies = {post};
    model.nodes = {anchor};
    Load load;
    load.on = {0, 0};
    load.direction = {0, 0, -1};
    load.name = "hook";
    model.loads = {load};
    Joint joint;
    joint.name = "foot";
    joint.type = JointType::hinge;
    joint.first = 0;
    joint.anchor = {0.5, 0.25, 0};
    joint.axis = {0, 1, 0};
    model.joints = {joint};
    return model;
}

class ThreeViews : public ::testing::Test {
protected:
    void add_line() {
        const auto& types = plugins_.catalogue().types;
        const auto type =
            std::ranges::find_if(types, [](const auto* one) { return one->name == std::string("axial_spring"); });
        Element spring;
        spring.name = "stay";
        spring.type = static_cast<int>(type - types.begin());
        spring.ends = {{0, 0}, {-1, -1, 0}};
        std::vector<double>& values = spring.values.change();
        for (uint32_t p = 0; p < (*type)->parameter_count; ++p) values.insert(values.end(), (*type)->parameters[p].count, 1);
        model_.elements.push_back(spring);
    }
    std::string draw() const { return draw_three_views(model_, plugins_.catalogue()); }

    const Plugins plugins_;
    Model model_ = crane();
};

// Oracle: third-angle projection by hand. Right and up are (x, z), (x, y), (y, z), and (x + y)/sqrt 2, (2z - x + y)/sqrt 6
// from the corner. One scale for the first three: differences of places over differences of coordinates are the same.
TEST_F(ThreeViews, AnElementIsWhereItsEndsAreProjected) {
    add_line();
    const std::vector<std::string> views = views_in(draw());
    ASSERT_EQ(views.size(), 4u);
    const Vector3d from(0.6, 0.25, 2.2), to(3, -1, 0.5), along = to - from;
    const Vector2d expected[] = {
        {along.x(), along.z()},
        {along.x(), along.y()},
        {along.y(), along.z()},
        {(along.x() + along.y()) / std::sqrt(2.), (2 * along.z() - along.x() + along.y()) / std::sqrt(6.)}};
    double scale = 0;
    for (std::size_t v = 0; v < 4; ++v) {
        const auto paths = paths_in(views[v], "element");
        ASSERT_EQ(paths.size(), 1u);
        const Vector2d drawn(paths[0][2] - paths[0][0], -(paths[0][3] - paths[0][1]));
        if (v == 0 || v == 3) scale = drawn.norm() / expected[v].norm();
        EXPECT_LT((drawn - scale * expected[v]).norm(), 0.2) << "view " << v;  // places have one decimal
    }
}

// Oracle: the outline of the box of its inertia, whose edges are 0.4, 0.6 and 2 m, in the scale of the element above.
TEST_F(ThreeViews, ABodyIsTheBoxOfItsInertia) {
    add_line();
    const std::vector<std::string> views = views_in(draw());
    const std::vector<double> stay = paths_in(views[0], "element").at(0);
    const double scale = (stay[2] - stay[0]) / 2.4;
    const Vector2d sizes[] = {{0.4, 2}, {0.4, 0.6}, {0.6, 2}};
    for (std::size_t v = 0; v < 3; ++v) {
        const std::vector<double> outline = paths_in(views[v], "body").at(0);
        ASSERT_EQ(outline.size(), 8u) << "four corners";
        double low_x = 1e9, high_x = -1e9, low_y = 1e9, high_y = -1e9;
        for (std::size_t i = 0; i < 8; i += 2) {
            low_x = std::min(low_x, outline[i]), high_x = std::max(high_x, outline[i]);
            low_y = std::min(low_y, outline[i + 1]), high_y = std::max(high_y, outline[i + 1]);
        }
        EXPECT_NEAR(high_x - low_x, scale * sizes[v].x(), 0.3) << "view " << v;
        EXPECT_NEAR(high_y - low_y, scale * sizes[v].y(), 0.3) << "view " << v;
    }
    EXPECT_EQ(paths_in(views[3], "body").at(0).size(), 12u) << "six corners from a corner";
}

// The load presses on the marker from above: in front and right view its arrow ends there; from above it is a ring.
TEST_F(ThreeViews, ALoadPointsAtItsPlace) {
    add_line();
    const std::vector<std::string> views = views_in(draw());
    const std::vector<double> stay = paths_in(views[0], "element").at(0), arrow = paths_in(views[0], "load").at(0);
    EXPECT_NEAR(arrow[2], stay[0], 0.11);
    EXPECT_NEAR(arrow[3], stay[1], 0.11);
    EXPECT_LT(arrow[1], arrow[3]) << "from above";
    EXPECT_THAT(views[1], HasSubstr("<circle class=\"load\""));
}

TEST_F(ThreeViews, TheAxisOfAHingeIsSeenFromTheSideOnly) {
    const std::vector<std::string> views = views_in(draw());
    EXPECT_EQ(paths_in(views[0], "joint").size(), 0u) << "along the eye";
    EXPECT_EQ(paths_in(views[1], "joint").size(), 1u);
    EXPECT_EQ(paths_in(views[2], "joint").size(), 1u);
}

// Forty nodes at one place have room for some of their names; the picture says how many it left out.
TEST_F(ThreeViews, NamesCoverNoOtherNameAndThoseLeftOutAreCounted) {
    for (int i = 0; i < 40; ++i) {
        Node node;
        node.name = "crowd" + std::to_string(i);
        node.position = {1, 0, 0.5 + 1e-4 * i};
        model_.nodes.push_back(node);
    }
    const std::string svg = draw();
    const std::regex label("<text class=\"name\" x=\"([^\"]+)\" y=\"([^\"]+)\">([^<]*)<");
    int drawn = 0;
    for (const std::string& view : views_in(svg)) {
        struct Box {
            double left, right, y;
        };
        std::vector<Box> boxes;
        for (std::sregex_iterator found(view.begin(), view.end(), label), end; found != end; ++found) {
            const double x = std::stod((*found)[1]);
            const Box box{x, x + 6.3 * static_cast<double>((*found)[3].length()), std::stod((*found)[2])};
            for (const Box& other : boxes)
                EXPECT_FALSE(box.left < other.right && other.left < box.right && std::abs(box.y - other.y) < 11.9)
                    << (*found)[3];
            boxes.push_back(box);
        }
        drawn += static_cast<int>(boxes.size());
    }
    EXPECT_THAT(svg, HasSubstr(std::to_string(4 * 44 - drawn) + " labels find no place"));
}

TEST_F(ThreeViews, TextsAreNoMarkup) {
    model_.bodies[0].name = "<script>&\"";
    const std::string svg = draw();
    EXPECT_THAT(svg, HasSubstr("<title>Crane &lt;1&gt;</title>"));
    EXPECT_THAT(svg, Not(HasSubstr("<script")));
}

TEST_F(ThreeViews, APointOfNoSizeIsDrawn) {
    model_ = Model();
    Node node;
    node.name = "alone";
    model_.nodes = {node};
    const std::string svg = draw();
    EXPECT_THAT(svg, HasSubstr(">alone</text>"));
    EXPECT_THAT(svg, Not(HasSubstr("nan")));
    EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

// Characters of the two sizes are at most 6.3 and 7 px wide: words below and headings end inside of what is theirs.
TEST_F(ThreeViews, WordsFitAlsoWhereTheMachineIsThin) {
    model_ = Model();
    for (int i = 0; i < 60; ++i) {
        Node node;
        node.name = "n" + std::to_string(i);
        node.position = {0, 0, 0.001 * i};
        model_.nodes.push_back(node);
    }
    const std::string svg = draw();
    std::smatch width, foot;
    ASSERT_TRUE(std::regex_search(svg, width, std::regex("<svg[^>]* width=\"([0-9]+)\"")));
    const std::string last = svg.substr(svg.rfind("<text"));
    const std::string words = std::regex_replace(last, std::regex("<[^>]*>|\n"), "");
    EXPECT_THAT(words, HasSubstr(" labels find no place"));
    EXPECT_GE(std::stod(width[1]), 17 + 6.3 * static_cast<double>(words.size()) - 0.5);
    for (const std::string& view : views_in(svg)) {
        const std::vector<double> frame = paths_in(view, "frame").at(0);
        std::smatch heading;
        ASSERT_TRUE(std::regex_search(view, heading, std::regex("class=\"heading\"[^>]*>([^<]*)<")));
        EXPECT_GE(frame[2] - frame[0], 7.0 * static_cast<double>(heading[1].length())) << heading[1];
    }
}

}  // namespace
}  // namespace dttmm::host
