// SPDX-License-Identifier: BSD-3-Clause
#include "report/svg_chart.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <regex>

namespace dttmm::host {
namespace {

using ::testing::DoubleNear;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::Pointwise;

/// Places and values of the ticks of an axis; class is "x" or "y".
std::vector<std::pair<double, double>> ticks_in(const std::string& svg, const std::string& axis) {
    std::vector<std::pair<double, double>> ticks;
    const std::regex tick("<text class=\"" + axis + "\" x=\"([^\"]+)\" y=\"([^\"]+)\"[^>]*>([^<]+)<");
    for (std::sregex_iterator found(svg.begin(), svg.end(), tick), end; found != end; ++found)
        ticks.emplace_back(std::stod((*found)[axis == "x" ? 1 : 2]), std::stod((*found)[3]));
    return ticks;
}

std::vector<std::pair<double, double>> points_in(const std::string& svg) {
    std::vector<std::pair<double, double>> points;
    std::smatch curve;
    std::regex_search(svg, curve, std::regex("class=\"curve\"[^>]* d=\"([^\"]*)\""));
    const std::string path = curve[1];
    const std::regex point("[ML]([^ ]+) ([^ML]+)");
    for (std::sregex_iterator found(path.begin(), path.end(), point), end; found != end; ++found)
        points.emplace_back(std::stod((*found)[1]), std::stod((*found)[2]));
    return points;
}

/// The value at a place, from the first and last tick.
double value_at(const std::vector<std::pair<double, double>>& ticks, double place, bool is_logarithmic) {
    const auto [p0, v0] = ticks.front();
    const auto [p1, v1] = ticks.back();
    const double share = (place - p0) / (p1 - p0);
    return is_logarithmic ? v0 * std::pow(v1 / v0, share) : v0 + share * (v1 - v0);
}

// Oracle: the values of the points, read off the picture by its own ticks. Places have two decimals of some 230.
TEST(SvgChart, PointsStandWhereTheTicksSay) {
    const std::vector<double> x = {0.1, 0.25, 0.4, 0.9}, y = {12, 3500, 80, 41};
    for (const bool is_logarithmic : {false, true}) {
        const std::string svg = draw_svg("a", {{"time [s]", "N", {{"bolt", x, y}}, is_logarithmic}});
        const auto points = points_in(svg), xs = ticks_in(svg, "x"), ys = ticks_in(svg, "y");
        ASSERT_EQ(points.size(), 4u);
        ASSERT_GE(ys.size(), 3u);
        for (std::size_t i = 0; i < 4; ++i) {
            // Within the frame, which is 764 by 230 behind a margin of 78 and 14
            EXPECT_TRUE(points[i].first >= 78 && points[i].first <= 842) << points[i].first;
            EXPECT_TRUE(points[i].second >= 14 && points[i].second <= 244) << points[i].second;
            EXPECT_NEAR(value_at(xs, points[i].first, false), x[i], 1e-4);
            EXPECT_NEAR(value_at(ys, points[i].second, is_logarithmic), y[i], is_logarithmic ? 3e-4 * y[i] : 0.4);
        }
    }
}

TEST(SvgChart, TicksAreRound) {
    const auto near = [](std::vector<double> values) { return Pointwise(DoubleNear(1e-12), std::move(values)); };
    EXPECT_THAT(round_ticks(0, 1, 5), near({0, 0.2, 0.4, 0.6, 0.8, 1}));
    EXPECT_THAT(round_ticks(-3.2, 7.1, 6), near({-2, 0, 2, 4, 6}));
    EXPECT_THAT(round_ticks(102, 149, 5), near({110, 120, 130, 140}));
}

TEST(SvgChart, GapsAndWhatHasNoLogarithmInterrupt) {
    const std::string svg = draw_svg("a", {{"x", "y", {{"l", {1, 2, 3, 4, 5}, {1, NAN, 3, 0, 5}}}, true}});
    EXPECT_EQ(points_in(svg).size(), 3u);
    EXPECT_THAT(svg, Not(HasSubstr("nan")));
    EXPECT_THAT(svg, Not(HasSubstr("inf")));
}

TEST(SvgChart, ConstantsAndNothingAreDrawn) {
    for (const std::vector<double>& y : {std::vector<double>{5, 5}, {0, 0}, {NAN, NAN}}) {
        const std::string svg = draw_svg("a", {{"x", "y", {{"l", {1, 2}, y}}}});
        EXPECT_THAT(svg, Not(HasSubstr("nan")));
        EXPECT_GE(ticks_in(svg, "y").size(), 2u);
    }
}

TEST(SvgChart, TextsAreNoMarkup) {
    const std::string svg = draw_svg("<a>&\x01", {{"<x>", "\"y\"", {{"</svg>", {1, 2}, {3, 4}}}}});
    EXPECT_THAT(svg, HasSubstr("<title>&lt;a&gt;&amp; </title>"));
    EXPECT_THAT(svg, HasSubstr(">&lt;/svg&gt;</text>"));
    EXPECT_THAT(svg, HasSubstr(">&lt;x&gt;</text>"));
}

}  // namespace
}  // namespace dttmm::host
