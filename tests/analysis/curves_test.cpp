// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/curves.h"

#include <gtest/gtest.h>

#include <cmath>

namespace dttmm::host {
namespace {

// Shapes in a plane that turn with the parameters: the angle of curve k is its start plus `a` of the first and `b` of the
// second parameter.
Eigen::MatrixXd plane_shapes(double x, double y) {
    Eigen::MatrixXd shapes(2, 2);
    const double angle = 0.5 * x + 1.1 * y;
    shapes << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
    return shapes;
}

TEST(Curves, LikenessOfTwoShapes) {
    const Eigen::Vector2d a(3, 0), b(-2, 2);
    EXPECT_DOUBLE_EQ(compute_likeness(a, a), 1);
    EXPECT_DOUBLE_EQ(compute_likeness(a, b), 0.5);
    EXPECT_DOUBLE_EQ(compute_likeness(a, Eigen::Vector2d(0, 7)), 0);
    EXPECT_DOUBLE_EQ(compute_likeness(a, Eigen::Vector2d::Zero()), 0);
}

// Oracle: the shapes turn by 0.22 rad at most from a case of a 6 x 5 grid to its neighbour, cos² 0.22 = 0.95, but by 2 rad
// where the listing goes back to the start of the second parameter. The order of the columns is the same in all cases; it
// is turned round in every third to make it a question.
TEST(Curves, AGridIsFollowedFromNeighbourToNeighbour) {
    std::vector<std::vector<double>> parameters;
    std::vector<Eigen::MatrixXd> shapes;
    for (int i = 0; i < 6; ++i)
        for (int j = 0; j < 5; ++j) {
            parameters.push_back({1e6 + 300.0 * i, 0.001 * j});  // ranges of 1500 and 0.004
            shapes.push_back(plane_shapes(0.2 * i, 0.2 * j));
            if (shapes.size() % 3 == 0) shapes.back().col(0).swap(shapes.back().col(1));
        }
    const std::vector<CaseCurves> curves = follow_curves(parameters, shapes);
    for (size_t c = 0; c < shapes.size(); ++c) {
        const size_t first = (c + 1) % 3 == 0 ? 1 : 0;
        ASSERT_EQ(curves[c].mode_of, (std::vector<size_t>{first, 1 - first})) << c;
        if (c == 0) {
            EXPECT_EQ(curves[c].nearest, CaseCurves::kNone);
            EXPECT_TRUE(std::isnan(curves[c].likeness[0]));
            continue;
        }
        EXPECT_GT(curves[c].likeness[0], 0.95) << c;
        const auto column = [](size_t i) { return static_cast<long>(i % 5); };
        const auto row = [](size_t i) { return static_cast<long>(i / 5); };
        EXPECT_EQ(std::abs(column(c) - column(curves[c].nearest)) + std::abs(row(c) - row(curves[c].nearest)), 1) << c;
    }
}

// Oracle: of cases listed out of order each is compared with its neighbour in the parameter.
TEST(Curves, TheOrderOfTheListDoesNotMatter) {
    const std::vector<double> values = {0, 4, 1, 3, 2};
    std::vector<std::vector<double>> parameters;
    std::vector<Eigen::MatrixXd> shapes;
    for (const double x : values) {
        parameters.push_back({x});
        shapes.push_back(plane_shapes(0.8 * x, 0));
    }
    for (const CaseCurves& one : follow_curves(parameters, shapes)) {
        EXPECT_EQ(one.mode_of, (std::vector<size_t>{0, 1}));
        if (one.nearest != CaseCurves::kNone) {
            EXPECT_NEAR(one.likeness[1], std::pow(std::cos(0.4), 2), 1e-12);
        }
    }
}

// Oracle: a mode with a shape of its own is in the first and the last case only; another in the middle only.
TEST(Curves, ACurveThatIsLeftKeepsItsShape) {
    const Eigen::Matrix3d all = Eigen::Matrix3d::Identity();
    Eigen::MatrixXd ends(3, 2), middle(3, 2);
    ends << all.col(0), all.col(1);
    middle << all.col(2), all.col(0);
    const std::vector<CaseCurves> curves = follow_curves({{0}, {1}, {2}}, {ends, middle, ends});
    constexpr size_t kNone = CaseCurves::kNone;
    EXPECT_EQ(curves[0].mode_of, (std::vector<size_t>{0, 1}));
    // What is most alike is paired first; what is left over is paired too, and its likeness says that it is another
    EXPECT_EQ(curves[1].mode_of, (std::vector<size_t>{1, 0}));
    EXPECT_EQ(curves[1].likeness[0], 1);
    EXPECT_EQ(curves[1].likeness[1], 0);
    EXPECT_EQ(curves[2].mode_of, (std::vector<size_t>{0, 1}));
    Eigen::MatrixXd one(3, 1);
    one << all.col(0);
    const std::vector<CaseCurves> gap = follow_curves({{0}, {1}, {2}}, {ends, one, ends});
    EXPECT_EQ(gap[1].mode_of, (std::vector<size_t>{0, kNone}));
    EXPECT_EQ(gap[2].mode_of, (std::vector<size_t>{0, 1}));
    EXPECT_EQ(gap[2].likeness[1], 1);
}

}  // namespace
}  // namespace dttmm::host
