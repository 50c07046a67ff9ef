// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/machine_geometry.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "loader/plugins.h"

namespace dttmm::host {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// An odd turn of the principal axes.
const Matrix3d kAskew = (Eigen::AngleAxisd(0.7, Vector3d(1, 2, -0.5).normalized())).toRotationMatrix();

// Oracle: a homogeneous box of edges a, b, c has the moments m (b² + c²)/12, m (c² + a²)/12, m (a² + b²)/12.
TEST(MachineGeometry, ABoxComesBackFromItsInertia) {
    const double m = 7.3, a = 0.9, b = 0.4, c = 0.13;
    Body body;
    body.mass = m;
    const Vector3d moments = m / 12 * Vector3d(b * b + c * c, c * c + a * a, a * a + b * b);
    body.inertia = kAskew * moments.asDiagonal() * kAskew.transpose();
    const EqualBox box = equal_box(body.mass, body.inertia);
    EXPECT_LT((box.edges - Vector3d(a, b, c)).norm(), 1e-12);
    EXPECT_NEAR(box.axes.determinant(), 1, 1e-12);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(std::abs(box.axes.col(i).dot(kAskew.col(i))), 1, 1e-12);
}

class PlaceAtStart : public ::testing::Test {
protected:
    PlaceAtStart() {
        body_.name = "arm";
        body_.position = {0.3, -1.1, 0.7};
        body_.rotation = kAskew;
        body_.markers.push_back(
            {"tip", {0.2, 0.1, -0.4}, std::make_shared<Matrix3d>(Eigen::AngleAxisd(0.3, Vector3d::UnitY()))});
        model_.bodies = {body_};
        Node node;
        node.name = "far";
        node.position = {2, 1, -3};
        model_.nodes = {node};
    }
    /// Of a type with its parameters not given, but for `up`.
    ElementPlace place(const std::string& type_name, const Attachment& from, const Attachment& to,
                       const Vector3d& up = Vector3d::Constant(std::nan(""))) {
        for (const dttmm_element_type* type : plugins_.catalogue().types) {
            if (type->name != type_name) continue;
            Element element;
            element.ends = {from, to};
            for (uint32_t p = 0; p < type->parameter_count; ++p)
                for (uint32_t i = 0; i < type->parameters[p].count; ++i)
                    element.values.change().push_back(type->parameters[p].name == std::string("up") ? up[i] : -1.0 - i);
            return place_at_start(model_, element, *type);
        }
        ADD_FAILURE() << "no type " << type_name;
        return {};
    }

    const Plugins plugins_;
    Body body_;
    Model model_;
    const Attachment tip_{0, 0}, far_{-1, -1, 0}, ground_{};
};

// Oracle: the marker's place and axes by hand.
TEST_F(PlaceAtStart, AnEndOnTheGroundIsWhereTheOtherIs) {
    const ElementPlace place = this->place("spring_damper", ground_, tip_);
    EXPECT_LT((place.from - (body_.position + kAskew * body_.markers[0].position)).norm(), 1e-15);
    EXPECT_EQ(place.from, place.to);
    EXPECT_LT((place.axes - kAskew * body_.markers[0].axes()).norm(), 1e-15);
    EXPECT_TRUE(place.is_grounded);
    EXPECT_FALSE(place.is_long());
}

// Oracle: x from end to end; y at right angles to x and up; z on the side of up. Without up, the world's z.
TEST_F(PlaceAtStart, ABeamHasZNearUp) {
    const Vector3d up(0.3, -0.2, -0.9);
    for (const auto& [place, upwards] : {std::pair(this->place("beam", tip_, far_, up), up),
                                         std::pair(this->place("beam", tip_, far_), Vector3d(Vector3d::UnitZ()))}) {
        EXPECT_LT((place.axes.col(0) - (place.to - place.from).normalized()).norm(), 1e-15);
        EXPECT_NEAR(place.axes.col(1).dot(upwards), 0, 1e-15);
        EXPECT_GT(place.axes.col(2).dot(upwards), 0);
        EXPECT_NEAR(place.axes.determinant(), 1, 1e-14);
        EXPECT_FALSE(place.has_only_x);
        EXPECT_FALSE(place.is_grounded);
    }
}

}  // namespace
}  // namespace dttmm::host
