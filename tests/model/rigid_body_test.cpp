// SPDX-License-Identifier: BSD-3-Clause
#include "model/rigid_body.h"

#include <Eigen/Geometry>
#include <limits>
#include <numbers>

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;
constexpr double kPi = std::numbers::pi;

/// The body as a sum of the point masses of a fine grid over its bounding box: mass and inertia by definition.
template <class Contains>
MassProperties sum_over_grid(double density, const Eigen::Vector3d& lengths, int count, Contains contains) {
    MassProperties sum;
    const double mass = density * lengths.prod() / (count * count * count);
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j)
            for (int k = 0; k < count; ++k) {
                const Eigen::Vector3d r = lengths.cwiseProduct((Eigen::Vector3d(i, j, k).array() + 0.5).matrix() / count -
                                                               Eigen::Vector3d::Constant(0.5));
                if (!contains(r)) continue;
                sum.mass += mass;
                sum.inertia += mass * (r.squaredNorm() * Eigen::Matrix3d::Identity() - r * r.transpose());
            }
    return sum;
}

void expect_near(const MassProperties& actual, const MassProperties& expected, double relative) {
    EXPECT_NEAR(actual.mass, expected.mass, relative * expected.mass);
    EXPECT_LT((actual.inertia - expected.inertia).norm(), relative * expected.inertia.norm());
}

// Oracle: the plate of the four-bolt example by hand: 9.42 kg, I = m/12 (sum of two squares).
TEST(RigidBody, BoxByHand) {
    const MassProperties box = make_box(7850, {0.3, 0.2, 0.02});
    EXPECT_NEAR(box.mass, 9.42, 1e-14);
    EXPECT_NEAR(box.inertia(0, 0), 9.42 / 12 * (0.04 + 0.0004), 1e-16);
    EXPECT_NEAR(box.inertia(1, 1), 9.42 / 12 * (0.09 + 0.0004), 1e-16);
    EXPECT_NEAR(box.inertia(2, 2), 9.42 / 12 * (0.09 + 0.04), 1e-16);
}

// Oracle: a sum over 40³ points. The midpoint rule misses 1/40² of a box's second moments, and stairs of a cell stand for a
// curved surface: 1.5 % of the tube's area, less of the others. Axes mixed up would show as 50 % and more.
TEST(RigidBody, ShapesEqualTheSumOfTheirPoints) {
    const auto radius = [](double a, double b) { return std::hypot(a, b); };
    expect_near(make_box(3, {1, 2, 4}), sum_over_grid(3, {1, 2, 4}, 40, [](const auto&) { return true; }), 0.02);
    expect_near(make_tube(3, 2, 0, 5, 0),
                sum_over_grid(3, {5, 2, 2}, 40, [&](const auto& r) { return radius(r.y(), r.z()) < 1; }), 0.02);
    expect_near(make_tube(3, 2, 1.2, 5, 1),
                sum_over_grid(3, {2, 5, 2}, 40,
                              [&](const auto& r) { return radius(r.x(), r.z()) < 1 && radius(r.x(), r.z()) > 0.6; }),
                0.02);
    expect_near(make_sphere(3, 2), sum_over_grid(3, {2, 2, 2}, 40, [](const auto& r) { return r.norm() < 1; }), 0.02);
}

TEST(RigidBody, ATubeIsTheDifferenceOfTwoCylinders) {
    const MassProperties outer = make_tube(7, 3, 0, 5), inner = make_tube(7, 2, 0, 5), tube = make_tube(7, 3, 2, 5);
    expect_near(tube, {outer.mass - inner.mass, outer.inertia - inner.inertia}, 1e-14);
    EXPECT_NEAR(outer.mass, 7 * kPi * 9 / 4 * 5, 1e-12);
}

TEST(RigidBody, MassMustBePositiveFiniteAndReasonable) {
    for (const double mass : {1e-12, 1.0, 1e12}) EXPECT_FALSE(find_mass_fault(mass)) << mass;
    const double inf = std::numeric_limits<double>::infinity();
    for (const double mass : {0.0, -1.0, 1e-13, 1e13, inf, -inf, std::nan("")})
        EXPECT_THAT(find_mass_fault(mass).value_or(""), HasSubstr("mass must lie within 1e-12 kg and 1000000000000 kg"))
            << mass;
}

TEST(RigidBody, InertiaMustBelongToADistributionOfMass) {
    const auto diagonal = [](double x, double y, double z) {
        return Eigen::Matrix3d(Eigen::Vector3d(x, y, z).asDiagonal());
    };
    EXPECT_FALSE(find_inertia_fault(diagonal(1, 2, 3), 1));  // a flat body: equality
    EXPECT_FALSE(find_inertia_fault(diagonal(1, 2, 3 * (1 + 3e-10)), 1));
    EXPECT_FALSE(find_inertia_fault(diagonal(1e24, 1e24, 1e24), 1e12));
    EXPECT_THAT(*find_inertia_fault(diagonal(1e308, 1e308, 1e308), 1), HasSubstr("inertia must be 1e+24 kg m² at most"));
    EXPECT_THAT(*find_inertia_fault(diagonal(1, 1, 100), 1), HasSubstr("triangle inequality"));
    EXPECT_THAT(*find_inertia_fault(diagonal(1, 1, 100), 1), HasSubstr("principal moments 1, 1, 100 kg m²"));
    EXPECT_THAT(*find_inertia_fault(diagonal(1, 2, 3.00001), 1), HasSubstr("3.0000100000000001"));
    EXPECT_THAT(*find_inertia_fault(diagonal(-1, 2, 2), 1), HasSubstr("positive definite"));
    EXPECT_THAT(*find_inertia_fault(diagonal(0, 2, 2), 1), HasSubstr("positive definite"));
    EXPECT_THAT(find_inertia_fault(diagonal(1e-14, 2, 2), 2).value_or(""), HasSubstr("too small beside the mass of 2 kg"));
    EXPECT_FALSE(find_inertia_fault(diagonal(1e-14, 1e-14, 1e-14), 0.9));
    EXPECT_THAT(*find_inertia_fault(diagonal(1, 2, std::nan("")), 1), HasSubstr("finite"));
    const Eigen::Matrix3d turned = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    EXPECT_THAT(find_inertia_fault(turned * diagonal(1, 1, 100) * turned.transpose(), 1).value_or(""),
                HasSubstr("triangle"));
    EXPECT_FALSE(find_inertia_fault(turned * diagonal(4, 5, 6) * turned.transpose(), 1));
}

}  // namespace
}  // namespace dttmm::host
