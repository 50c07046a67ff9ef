// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_body.h"

#include <cmath>
#include <numbers>

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

Body body(const std::string& text) { return parse(body_with(text)).bodies.at(0); }
std::string body_fault(const std::string& text) { return errors_of(body_with(text)); }
/// The fault of a body that is otherwise complete; the first line of `text` is line 11.
std::string fault_beside_mass(const std::string& text) { return body_fault("mass = 2\ninertia = [2, 3, 4]\n" + text); }

TEST(ReadBody, MassAndInertia) {
    const Body b = body(
        "mass = \"150 kg\"\ninertia = { xx = 8, yy = 12, zz = 10, xy = 0.1, xz = 0.5, yz = -0.2 }\ncenter_of_mass = [0.15, "
        "0, \"100 mm\"]\n");
    EXPECT_EQ(b.mass, 150);
    EXPECT_EQ(b.inertia, (Eigen::Matrix3d{{8, 0.1, 0.5}, {0.1, 12, -0.2}, {0.5, -0.2, 10}}));
    EXPECT_EQ(b.center_of_mass, Eigen::Vector3d(0.15, 0, 0.1));
    EXPECT_EQ(body("mass = 1\ninertia = [2, 3, 4]\n").inertia, Eigen::Matrix3d(Eigen::Vector3d(2, 3, 4).asDiagonal()));
}

// Oracle: density times volume; the inertias are checked in rigid_body_test.
TEST(ReadBody, DensityAndShape) {
    EXPECT_NEAR(body("density = \"7.85 g/cm^3\"\nbox = [\"300 mm\", 0.2, 0.02]\n").mass, 9.42, 1e-14);
    EXPECT_NEAR(body("density = 4\nsphere = 3\n").mass, 18 * std::numbers::pi, 1e-13);
    const Body cylinder = body("density = 4\ncylinder = [2, 5]\naxis = \"x\"\n");
    EXPECT_NEAR(cylinder.mass, 20 * std::numbers::pi, 1e-13);
    EXPECT_NEAR(cylinder.inertia(0, 0), cylinder.mass / 2, 1e-13);
    const Body tube = body("density = 4\ntube = [2, 1, 5]\n");
    EXPECT_NEAR(tube.mass, 15 * std::numbers::pi, 1e-13);
    EXPECT_NEAR(tube.inertia(2, 2), tube.mass * 5 / 8, 1e-13);
}

// Oracle: a quarter turn about z takes x to y.
TEST(ReadBody, PlaceAndMotion) {
    const std::string mass = "mass = 1\ninertia = [2, 3, 4]\n";
    const Body b = body(mass +
                        "position = [1, 2, \"3 km\"]\nrotation = { axis = [0, 0, 7], angle = \"90 deg\" }\n"
                        "velocity = [\"1 mm/s\", 0, 5]\nangular_velocity = [0, \"60 rpm\", 1]\n");
    EXPECT_EQ(b.position, Eigen::Vector3d(1, 2, 3000));
    EXPECT_LT((b.rotation * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-15);
    EXPECT_EQ(b.velocity, Eigen::Vector3d(0.001, 0, 5));
    EXPECT_NEAR(b.angular_velocity.y(), 2 * std::numbers::pi, 1e-14);
    const Body c = body(mass + "quaternion = [0.7071068, 0, 0, 0.7071068]\n");
    EXPECT_LT((c.rotation * Eigen::Vector3d::UnitX() - Eigen::Vector3d::UnitY()).norm(), 1e-15);
    EXPECT_LT((c.rotation.transpose() * c.rotation - Eigen::Matrix3d::Identity()).norm(), 1e-15);
}

TEST(ReadBody, Markers) {
    const Body b = body(
        "mass = 1\ninertia = [2, 3, 4]\nmarkers.q = [\"130 mm\", 0, 1]\n"
        "markers.r = { position = [1, 2, 3], rotation = { axis = [1, 0, 0], angle = \"180 deg\" } }\n");
    ASSERT_EQ(b.markers.size(), 2u);
    EXPECT_EQ(b.markers[0].name, "q");
    EXPECT_EQ(b.markers[0].position, Eigen::Vector3d(0.13, 0, 1));
    EXPECT_EQ(b.markers[0].axes(), Eigen::Matrix3d::Identity());
    EXPECT_EQ(b.markers[1].position, Eigen::Vector3d(1, 2, 3));
    EXPECT_NEAR(b.markers[1].axes()(2, 2), -1, 1e-15);
}

TEST(ReadBody, MassFaults) {
    for (const char* mass : {"0", "-1", "1e-400", "1e13"})
        EXPECT_THAT(body_fault("inertia = [2, 3, 4]\nmass = " + std::string(mass)),
                    HasSubstr("m.toml:10:8: body \"plate\": mass must lie within"))
            << mass;
    for (const char* mass : {"nan", "inf"})
        EXPECT_THAT(body_fault("inertia = [2, 3, 4]\nmass = " + std::string(mass)), HasSubstr("mass must be finite"))
            << mass;
    EXPECT_THAT(body_fault("inertia = [2, 3, 4]\n"), HasSubstr("m.toml:7:1: body \"plate\": missing key \"mass\""));
    EXPECT_THAT(body_fault("mass = 2\n"), HasSubstr("missing key \"inertia\""));
    EXPECT_THAT(body_fault("mass = true\ninertia = [2, 3, 4]\n"),
                HasSubstr("body \"plate\": mass: expected a number in kg, got true or false"));
    EXPECT_THAT(body_fault("mass = 2020-01-01\ninertia = [2, 3, 4]\n"), HasSubstr("got a date or time"));
}

TEST(ReadBody, InertiaFaults) {
    EXPECT_THAT(body_fault("mass = 1\ninertia = [1, 1, 100]\n"),
                HasSubstr("m.toml:10:11: body \"plate\": inertia breaks the triangle inequality"));
    EXPECT_THAT(body_fault("mass = 1\ninertia = [1, -1, 1]\n"),
                HasSubstr("positive definite: principal moments -1, 1, 1 kg m²"));
    EXPECT_THAT(body_fault("mass = 1\ninertia = [1, 1]\n"), HasSubstr("inertia wants 3 numbers, got 2"));
    EXPECT_THAT(body_fault("mass = 1\ninertia = { xx = 1, yy = 1 }\n"), HasSubstr("inertia: missing key \"zz\""));
    EXPECT_THAT(body_fault("mass = 1\ninertia = { xx = 1, yy = 1, zz = 1, yx = 2 }\n"), HasSubstr("unknown key \"yx\""));
}

// Oracle: the box's moments by hand; a weighed machine gives the mass instead of the density.
TEST(ReadBody, AShapeMayHaveAMassInsteadOfADensity) {
    const Body b = body("mass = 50\nbox = [0.6, 0.4, 0.3]\n");
    EXPECT_DOUBLE_EQ(b.mass, 50);
    EXPECT_NEAR(b.inertia(0, 0), 50. / 12 * (0.16 + 0.09), 1e-13);
    EXPECT_NEAR(b.inertia(1, 1), 50. / 12 * (0.36 + 0.09), 1e-13);
    EXPECT_NEAR(b.inertia(2, 2), 50. / 12 * (0.36 + 0.16), 1e-13);
}

TEST(ReadBody, ShapeFaults) {
    EXPECT_THAT(body_fault("density = -5\nbox = [1, 2, 3]\n"), HasSubstr("density must be > 0 kg/m^3, got -5"));
    EXPECT_THAT(body_fault("density = 5\nbox = [1, 0, 3]\n"),
                HasSubstr("m.toml:10:11: body \"plate\": box must be > 0 m, got 0"));
    EXPECT_THAT(body_fault("density = 5\ntube = [1, 2, 3]\n"),
                HasSubstr("the inner diameter must be less than the outer (1 m), got 2 m"));
    EXPECT_THAT(body_fault("density = 5\n"), HasSubstr("missing key: one of box, cylinder, tube, sphere"));
    EXPECT_THAT(body_fault("density = 5\nbox = [1, 2, 3]\nsphere = 1\n"),
                HasSubstr("\"box\" and \"sphere\" exclude each other"));
    EXPECT_THAT(body_fault("density = 5\nbox = [1, 2, 3]\nmass = 1\n"),
                HasSubstr("\"density\" and \"mass\" exclude each other"));
    EXPECT_THAT(body_fault("mass = 5\ninertia = [2, 3, 4]\nbox = [1, 2, 3]\n"),
                HasSubstr("\"inertia\" and a shape exclude each other"));
    EXPECT_THAT(body_fault("box = [1, 2, 3]\n"), HasSubstr("missing key: one of density, mass"));
    EXPECT_THAT(body_fault("density = 5\nbox = [1, 2, 3]\naxis = \"x\"\n"), HasSubstr("a box has no axis"));
    EXPECT_THAT(body_fault("density = 5\ncylinder = [1, 2]\naxis = \"w\"\n"),
                HasSubstr("axis must be one of: x, y, z; got \"w\""));
    EXPECT_THAT(body_fault("density = 1e300\nbox = [1, 1e100, 3]\n"), HasSubstr("mass must lie within"));
}

TEST(ReadBody, PlaceFaults) {
    EXPECT_THAT(fault_beside_mass("quaternion = [0, 0, 0, 0]\n"),
                HasSubstr("m.toml:11:14: body \"plate\": quaternion [w, x, y, z] must have norm 1 to within 1e-06, got 0"));
    EXPECT_THAT(fault_beside_mass("quaternion = [0.9, 0, 0, 0]\n"), HasSubstr("got 0.9"));
    EXPECT_THAT(fault_beside_mass("quaternion = [1, 0, 0]\n"), HasSubstr("quaternion wants 4 numbers, got 3"));
    EXPECT_THAT(fault_beside_mass("rotation = { axis = [0, 0, 0], angle = 1 }\n"), HasSubstr("axis must not be zero"));
    EXPECT_THAT(fault_beside_mass("rotation = { axis = [0, 0, 1], angle = \"3 m\" }\n"),
                HasSubstr("expected a value in rad"));
    EXPECT_THAT(
        fault_beside_mass("rotation = { axis = [0, 0, 1], angle = 30 }\n"),
        HasSubstr("m.toml:11:40: body \"plate\": rotation: angle must be within a turn, got 30 rad; degrees stand in "
                  "quotes"));
    EXPECT_THAT(fault_beside_mass("rotation = { axis = [0, 0, 1], angle = \"-361 deg\" }\n"), HasSubstr("within a turn"));
    EXPECT_THAT(fault_beside_mass("rotation = 3\n"),
                HasSubstr("body \"plate\": rotation: expected a table such as { axis = ... }, got a number"));
    EXPECT_THAT(fault_beside_mass("rotation = { axis = [0, 0, 1], angle = 1 }\nquaternion = [1, 0, 0, 0]\n"),
                HasSubstr("exclude each other"));
    EXPECT_THAT(fault_beside_mass("position = [0, -1e7, 0]\n"),
                HasSubstr("position must be within 1000000 m of the origin"));
    EXPECT_THAT(fault_beside_mass("position = [0, 1]\n"),
                HasSubstr("m.toml:11:12: body \"plate\": position wants 3 numbers, got 2"));
    EXPECT_THAT(fault_beside_mass("position = 1\n"), HasSubstr("position wants 3 numbers, got a number"));
    EXPECT_THAT(fault_beside_mass("angular_velocity = [0, 0, \"50 Hz\"]\n"),
                HasSubstr("m.toml:11:27: body \"plate\": angular_velocity: expected a value in rad/s"));
    EXPECT_THAT(fault_beside_mass("positon = [0, 0, 0]\n"),
                HasSubstr("unknown key \"positon\" in [[body]] number 1; did you mean \"position\"?"));
    EXPECT_THAT(parse(body_with("mass = 2\ninertia = [2, 3, 4]\nposition = [0, 2e4, 0]\n")).warnings,
                testing::Contains(WarningIs("far-from-origin", HasSubstr("position is 20000 m from the origin"))));
}

TEST(ReadBody, MarkerFaults) {
    EXPECT_THAT(fault_beside_mass("markers.q = [0, 1]\n"), HasSubstr("body \"plate\": marker \"q\" wants 3 numbers, got 2"));
    EXPECT_THAT(fault_beside_mass("markers.q = [0, 1, 1e7]\n"), HasSubstr("must be ≤ 1000000 m, got 10000000"));
    EXPECT_THAT(fault_beside_mass("markers.q = { positin = [0, 1, 2] }\n"),
                HasSubstr("marker \"q\": unknown key \"positin\"; did you mean \"position\"?"));
    EXPECT_THAT(fault_beside_mass("markers.\"q.r\" = [0, 1, 2]\n"), HasSubstr("marker name \"q.r\" holds a dot"));
    EXPECT_THAT(fault_beside_mass("markers = [0, 1, 2]\n"),
                HasSubstr("markers must be a table of name = [x, y, z], got a list"));
}

TEST(ReadBody, NamesAreUniqueInNormalForm) {
    const std::string rest = "mass = 2\ninertia = [2, 3, 4]\n";
    const auto two = [&](const std::string& a, const std::string& b) {
        return errors_of(std::string(kStart) + kSimulation + "[[body]]\nname = \"" + a + "\"\n" + rest +
                         "[[body]]\nname = \"" + b + "\"\n" + rest);
    };
    EXPECT_THAT(two("a", "a"), HasSubstr("m.toml:12:8: body name \"a\" on line 12 is taken already, on line 8"));
    EXPECT_THAT(two("\u00e9", "e\u0301"), HasSubstr("body name \"é\" on line 12 is taken already, on line 8"));
    EXPECT_THAT(two("a", "ground"), HasSubstr("the name \"ground\" is reserved"));
    EXPECT_THAT(two("a", "time"), HasSubstr("the name \"time\" is reserved"));
    EXPECT_THAT(two("a", "../../x"), HasSubstr("body name \"../../x\" holds a dot"));
    EXPECT_THAT(two("a", "b\\u0007"), HasSubstr("body name \"b\\u{7}\" holds the character U+0007"));
    EXPECT_THAT(two("a", ""), HasSubstr("body name \"\" is empty"));
    EXPECT_THAT(errors_of(std::string(kStart) + kSimulation + "[[body]]\n" + rest),
                HasSubstr("m.toml:7:1: body number 1: missing key \"name\""));
    EXPECT_THAT(errors_of(std::string(kStart) + kSimulation + "[body]\n" + rest),
                HasSubstr("body must be a list of tables; write [[body]]"));
    EXPECT_THAT(errors_of("body = [1]\n" + std::string(kStart) + kSimulation),
                HasSubstr("m.toml:1:9: body number 1: expected a table such as { name = ... }, got a number"));
}

// Steel is 7850 kg/m³; the others are what a wrong unit makes of it.
TEST(ReadBody, DensitiesAndSizesThatNoBodyHasAreToldOf) {
    const auto codes = [](const std::string& body) {
        std::vector<std::string> result;
        for (const Warning& warning : parse(body_with(body)).warnings)
            if (warning.code != "free-body") result.push_back(warning.code);
        return result;
    };
    using testing::ElementsAre;
    const std::string plate = "box = [\"300 mm\", \"200 mm\", \"20 mm\"]\n";
    EXPECT_THAT(codes(plate + "density = 7850\n"), ElementsAre());
    EXPECT_THAT(codes(plate + "density = 7.85\n"), ElementsAre("density"));
    EXPECT_THAT(codes(plate + "density = 7.85e-5\n"), ElementsAre("density"));
    EXPECT_THAT(codes(plate + "density = 7.85e6\n"), ElementsAre("density"));
    EXPECT_THAT(codes(plate + "mass = \"94.2 t\"\n"), ElementsAre("density"));
    EXPECT_THAT(codes("box = [300, 200, 20]\ndensity = 7850\n"), ElementsAre("size"));
    EXPECT_THAT(codes("box = [\"3 um\", \"2 um\", \"0.5 mm\"]\ndensity = 2300\n"), ElementsAre());
    EXPECT_THAT(codes("mass = 9.42\ninertia = [31720, 70960, 102060]\nmarkers.a = [0.13, 0.08, 0]\n"), ElementsAre("size"));
    EXPECT_THAT(codes("mass = 9.42\ninertia = [317.2, 709.6, 1020.6]\nmarkers.a = [0.13, 0.08, 0]\n"),
                ElementsAre("inertia"));
    EXPECT_THAT(codes("mass = 9.42\ninertia = [0.03172, 0.07096, 0.10206]\nmarkers.a = [0.13, 0.08, 0]\n"), ElementsAre());
}

}  // namespace
}  // namespace dttmm::host
