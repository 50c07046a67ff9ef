// SPDX-License-Identifier: BSD-3-Clause
#include "model/bolt_circle.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A second body, whose marker "face" is turned and off its origin.
const std::string kCover = R"toml([[body]]
name = "cover"
mass = 3
inertia = [2, 3, 4]
position = [1, 2, 3.5]
markers.face = { position = [0.1, 0.2, 0.3], rotation = { axis = [1, 2, 2], angle = 0.7 } }
)toml";

/// The model with a circle, whose keys are on lines 19 and further.
std::string with_circle(const std::string& keys) { return model_with(kCover + "[[bolt_circle]]\n" + keys); }
std::string circle_fault(const std::string& keys) { return errors_of(with_circle(keys)); }

const std::string kKeys =
    "name = \"bolt\"\ncount = 5\nradius = \"80 mm\"\nfrom = \"plate.a\"\nto = \"cover.face\"\nstart_angle = \"20 deg\"\n";
const std::string kElement = "element = { type = \"spring_damper\", stiffness = [\"1 N/mm\", 2e3, 3e3], damping = 4 }\n";

Eigen::Matrix3d about(const Eigen::Vector3d& axis, double angle) {
    return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

// Oracle: the same model written out by hand: markers at the angles 20 deg + 72 deg k, turned by them about z.
TEST(BoltCircle, IsTheModelWrittenOut) {
    std::string markers, elements;
    for (int k = 1; k <= 5; ++k) {
        markers += fmt::format(
            "markers.bolt{0} = {{ position = [\"=1+0.08*cos(pi/9+2*pi*{1}/5)\", \"=2+0.08*sin(pi/9+2*pi*{1}/5)\", 3], "
            "rotation "
            "= {{ axis = [0, 0, 1], angle = \"=pi/9+2*pi*{1}/5\" }} }}\n",
            k, k - 1);
        elements += fmt::format(
            "[[element]]\nname = \"bolt{0}\"\ntype = \"spring_damper\"\nfrom = \"plate.bolt{0}\"\nto = "
            "\"ground\"\nstiffness = "
            "[\"1 N/mm\", 2e3, 3e3]\ndamping = 4\n",
            k);
    }
    const Model written = parse(model_with(markers + elements));
    std::string keys = kKeys;
    keys.replace(keys.find("cover.face"), 10, "ground");
    const Model circle = parse(with_circle(keys + kElement));
    ASSERT_EQ(circle.elements.size(), 5u);
    ASSERT_EQ(circle.bodies[0].markers.size(), 6u);
    for (std::size_t k = 0; k < 5; ++k) {
        const Marker &made = circle.bodies[0].markers[k + 1], &by_hand = written.bodies[0].markers[k + 1];
        EXPECT_EQ(made.name, by_hand.name);
        EXPECT_LT((made.position - by_hand.position).norm(), 1e-15);
        EXPECT_LT((made.axes() - by_hand.axes()).norm(), 1e-15);
        EXPECT_EQ(circle.elements[k].name, written.elements[k].name);
        EXPECT_EQ(circle.elements[k].ends, written.elements[k].ends);
        EXPECT_EQ(circle.elements[k].values, written.elements[k].values);
    }
    EXPECT_TRUE(circle.warnings.size() == 1 && circle.warnings[0].code == "free-body");  // the cover
}

// Oracle: Rodrigues' rotation of the first radius about an oblique axis, in the axes of the turned marker.
TEST(BoltCircle, LiesInTheAxesOfItsPorts) {
    const Model model = parse(with_circle(kKeys + "axis = [2, -1, 2]\nzero = [0, 5, 1]\n" + kElement));
    const Eigen::Vector3d axis = Eigen::Vector3d(2, -1, 2) / 3;
    Eigen::Vector3d zero(0, 5, 1);
    zero = (zero - axis * axis.dot(zero)).normalized();
    const Eigen::Matrix3d face = about({1, 2, 2}, 0.7);
    for (int k = 0; k < 5; ++k) {
        const Eigen::Vector3d radius = about(axis, M_PI / 9 + 2 * M_PI * k / 5) * zero;
        const Marker& plate = model.bodies[0].markers[static_cast<std::size_t>(k) + 1];
        const Marker& cover = model.bodies[1].markers[static_cast<std::size_t>(k) + 1];
        EXPECT_LT((plate.position - Eigen::Vector3d(1, 2, 3) - 0.08 * radius).norm(), 1e-15);
        EXPECT_LT((cover.position - Eigen::Vector3d(0.1, 0.2, 0.3) - 0.08 * (face * radius)).norm(), 1e-15);
        EXPECT_LT((plate.axes().col(0) - radius).norm(), 1e-15);
        EXPECT_LT((plate.axes().col(2) - axis).norm(), 1e-15);
        EXPECT_TRUE(cover.axes().isIdentity(0));  // the axes of an element are those of its `from` end
    }
}

// Oracle: what the keys say: axes from the end that is no ground, none for lines and for elements with axes of their own.
TEST(BoltCircle, TurnsTheEndThatGivesTheAxes) {
    std::string keys = kKeys;
    keys.replace(keys.find("plate.a"), 7, "ground");
    const Model on_ground = parse(with_circle(keys + kElement));
    const Eigen::Matrix3d face = about({1, 2, 2}, 0.7);
    EXPECT_LT((on_ground.bodies[1].markers[1].axes() - face * about({0, 0, 1}, M_PI / 9)).norm(), 1e-15);
    const std::string own = "element = { type = \"spring_damper\", stiffness = 3, axes = \"to\" }\n";
    EXPECT_TRUE(parse(with_circle(kKeys + own)).bodies[0].markers[1].axes().isIdentity(0));
}

// Oracle: the stiffness that the expression gives the first bolt, the second and the third.
TEST(BoltCircle, ItsIndexMayMakeOneBoltLoose) {
    const Model model = parse(with_circle(
        kKeys + "index = \"i\"\nelement = { type = \"spring_damper\", stiffness = \"=7*(i == 2 ? 0.5 : 1) + 100*i\" }\n"));
    EXPECT_EQ(model.elements[0].values[0], 107);
    EXPECT_EQ(model.elements[1].values[0], 203.5);
    EXPECT_EQ(model.elements[2].values[0], 307);
}

// Oracle: the two circles of two bolts that the repeat asks for, on a body that the repeat makes.
TEST(BoltCircle, MayBeRepeated) {
    const Model model = parse(model_with(R"toml([[repeat]]
index = "i"
count = 2
[[repeat.bolt_circle]]
name = "ring{i}_"
count = 2
radius = "=i"
from = "disc{i}"
to = "plate.a"
index = "k"
element = { type = "spring_damper", stiffness = "=10*i + k" }
[[repeat.body]]
name = "disc{i}"
density = 7
sphere = 1
)toml"));
    ASSERT_EQ(model.elements.size(), 4u);
    EXPECT_EQ(model.elements[3].name, "ring2_2");
    EXPECT_EQ(model.elements[3].values[0], 22);
    EXPECT_EQ(model.bodies[2].markers[1].position.x(), -2);
}

// Oracle: the place, the rule and the cure in the message.
TEST(BoltCircle, FaultsPointAtItsKeys) {
    const auto fault = [](std::string what, const std::string& instead) {
        std::string keys = kKeys + kElement;
        return circle_fault(keys.replace(keys.find(what), what.size(), instead));
    };
    EXPECT_THAT(fault("count = 5", "count = 0"), HasSubstr("m.toml:20:9: bolt_circle \"bolt\": count must be ≥ 1, got 0"));
    EXPECT_THAT(fault("\"80 mm\"", "0"), HasSubstr("m.toml:21:10: bolt_circle \"bolt\": radius must be > 0 m, got 0"));
    EXPECT_THAT(fault("plate.a", "plat.a"),
                HasSubstr("m.toml:22:8: bolt_circle \"bolt\": from: there is no body \"plat\"; did "
                          "you mean \"plate\"?"));
    EXPECT_THAT(fault("plate.a", "plate.b"), HasSubstr("from: body \"plate\" has no marker \"b\"; known here: a"));
    EXPECT_THAT(fault("count", "cont"), HasSubstr("m.toml:20:1: bolt_circle \"bolt\": unknown key \"cont\""));
    EXPECT_THAT(fault("start_angle = \"20 deg\"", "axis = [0, 0, 0]"),
                HasSubstr("m.toml:24:8: bolt_circle \"bolt\": axis must"));
    EXPECT_THAT(fault("start_angle = \"20 deg\"", "zero = [0, 0, 2]"), HasSubstr("zero lies along axis"));
    EXPECT_THAT(fault("start_angle", "index = \"t\"\nstart_angle"),
                HasSubstr("m.toml:24:9: bolt_circle \"bolt\": index \"t\""));
    EXPECT_THAT(fault("damping = 4", "to = \"plate\""),
                HasSubstr("element: to comes from the bolt circle; leave the key out"));
    EXPECT_THAT(fault("\"spring_damper\"", "\"lump\""),
                HasSubstr("m.toml:25:20: bolt_circle \"bolt\": element: a lump has no two "
                          "ends and is no bolt"));
    EXPECT_THAT(fault("damping", "dampng"),
                HasSubstr("m.toml:25:71: element \"bolt1\": unknown key \"dampng\" in [[element]] "
                          "number 1; did you mean \"damping\"? (and in 4 more copies of this)"));
    EXPECT_THAT(circle_fault(kKeys), HasSubstr("m.toml:18:1: bolt_circle \"bolt\": missing key \"element\""));
    EXPECT_THAT(circle_fault(kKeys + "element = 3\n"),
                HasSubstr("m.toml:25:11: bolt_circle \"bolt\": element: expected a table"));
    EXPECT_THAT(
        errors_of(model_with("[nodes]\nhub = [0, 0, 0]\n[[bolt_circle]]\nname = \"b\"\ncount = 3\nradius = 1\nfrom = "
                             "\"hub\"\nto = \"plate\"\n" +
                             kElement)),
        HasSubstr("m.toml:18:8: bolt_circle \"b\": from: \"hub\" is a node, which is a point"));
    EXPECT_THAT(errors_of(model_with("markers.bolt2 = [0, 0, 0]\n" + kCover + "[[bolt_circle]]\n" + kKeys + kElement)),
                HasSubstr("m.toml:19:1: marker name \"bolt2\" on line 19 is taken already, on line 12"));
}

}  // namespace
}  // namespace dttmm::host
