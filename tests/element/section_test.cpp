// SPDX-License-Identifier: BSD-3-Clause
#include "element/section.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "support/element_values.h"

namespace dttmm::plugin {
namespace {

using test::Given;
using test::with;
using testing::HasSubstr;

Section section_of(const Given& given, BeamTheory theory = BeamTheory::timoshenko) {
    const std::vector<double> values = test::values_of(kSectionParameters, given);
    return make_section(std::span<const double, kSectionValueCount>(values), theory);
}

/// The bond-space paper's tube, and a bar of another material whose extents differ.
const Given kTubeSection = {
    {"section.tube", {0.05, 0.03}}, {"material.E", {204e9}}, {"material.poisson", {0.26}}, {"material.density", {7800}}};
const Given kBar = {{"section.rectangle", {0.03, 0.011}},
                    {"material.E", {70e9}},
                    {"material.poisson", {0.33}},
                    {"material.density", {2710}}};
const Given kStiffnesses = {{"section.EA", {3.1e8}}, {"section.EIy", {5.2e4}}, {"section.EIz", {7.7e3}},
                            {"section.GJ", {1.9e4}}, {"section.GAy", {6e7}},   {"section.GAz", {8.5e7}},
                            {"section.mass", {13.7}}};

// ---- Shapes -------------------------------------------------------------------------------------------------------------

// Oracle: Cowper (1966), table 1 evaluated elsewhere, and its limits: thin tube 2(1 + ν)/(4 + 3ν), solid 6(1 + ν)/(7 + 6ν).
TEST(Section, ShearCoefficientsAreCowpers) {
    EXPECT_NEAR(cowper_tube(0.26, 0.6), 0.578867, 5e-7);
    EXPECT_NEAR(cowper_tube(0.26, 1), 0.5272, 5e-5);
    EXPECT_NEAR(cowper_tube(0.26, 0), 0.8832, 5e-5);
    for (double nu : {0.0, 0.17, 0.5}) {
        EXPECT_DOUBLE_EQ(cowper_tube(nu, 1), 2 * (1 + nu) / (4 + 3 * nu));
        EXPECT_DOUBLE_EQ(cowper_tube(nu, 0), 6 * (1 + nu) / (7 + 6 * nu));
    }
    EXPECT_DOUBLE_EQ(cowper_rectangle(0), 5.0 / 6);
    EXPECT_NEAR(cowper_rectangle(0.3), 0.849673, 5e-7);  // 13/15.3
}

// Oracle: area, second moment, shear modulus and mass of the paper's tube by hand, to the digits given; the products
// exactly.
TEST(Section, ATubeHasTheValuesOfThePaper) {
    const Section s = section_of(kTubeSection);
    const double A = 1.256637e-3, I = 2.670354e-7, G = 80.952381e9;
    EXPECT_NEAR(s.EA / 204e9, A, 5e-10);
    EXPECT_NEAR(s.EIy / 204e9, I, 5e-14);
    EXPECT_EQ(s.EIy, s.EIz);
    EXPECT_NEAR(s.GJ / (2 * I), G, 4e-7 * G);
    EXPECT_NEAR(s.GAy, 0.578867 * G * A, 2e-6 * s.GAy);
    EXPECT_EQ(s.GAy, s.GAz);
    EXPECT_NEAR(1.2 * s.mass, 11.7621, 5e-5);
    EXPECT_DOUBLE_EQ(s.rotary_y, s.mass * s.EIy / s.EA);
    EXPECT_DOUBLE_EQ(s.rotary_z, s.rotary_y);
    EXPECT_DOUBLE_EQ(s.inertia, s.rotary_y + s.rotary_z);
    EXPECT_EQ(s.stiffness_damping, 0);
    EXPECT_EQ(s.offset_y, 0);
    EXPECT_EQ(s.offset_z, 0);
}

// Oracle: N/A ± M/W with W = b h²/6 of a rectangle about each axis at its corner, pi (D⁴ − d⁴)/(32 D) of a tube about the
// axis of the whole moment.
TEST(Section, TheOutermostFibre) {
    const SectionModuli bar = section_of(kBar).moduli, tube = section_of(kTubeSection).moduli;
    const double b = 0.03, h = 0.011, W = M_PI * (std::pow(0.05, 4) - std::pow(0.03, 4)) / (32 * 0.05);
    const double at_corner = 3 / (b * h * h / 6) + 5 / (h * b * b / 6);
    EXPECT_NEAR(bar.extreme_stress(700, -3, 5), 700 / (b * h) + at_corner, 1e-9 * at_corner);
    EXPECT_NEAR(bar.extreme_stress(-700, 3, 5), -700 / (b * h) - at_corner, 1e-9 * at_corner);
    EXPECT_NEAR(tube.extreme_stress(0, -3, 4), 5 / W, 1e-9 / W);
    EXPECT_NEAR(tube.extreme_stress(-8, 0, 0), -8 / (M_PI / 4 * (0.05 * 0.05 - 0.03 * 0.03)), 1e-9);
    EXPECT_FALSE(section_of(kStiffnesses).moduli.are_known());
}

// Oracle: a circle is a tube without a bore, for every value.
TEST(Section, ACircleIsATubeWithoutABore) {
    Given round = kTubeSection;
    round.erase("section.tube");
    const Section circle = section_of(with(round, {{"section.circle", {0.037}}}));
    const Section tube = section_of(with(round, {{"section.tube", {0.037, 0}}}));
    EXPECT_EQ(circle.EA, tube.EA);
    EXPECT_EQ(circle.EIy, tube.EIy);
    EXPECT_EQ(circle.GJ, tube.GJ);
    EXPECT_EQ(circle.GAy, tube.GAy);
    EXPECT_NEAR(circle.EIy, 204e9 * M_PI / 64 * std::pow(0.037, 4), 1e-13 * circle.EIy);
}

// Oracle: the extent along z counts cubed about y (deflection along z), that along y about z.
TEST(Section, TheExtentsOfARectangleBelongToTheirAxes) {
    const Section s = section_of(kBar);
    const double y = 0.03, z = 0.011, A = y * z;
    EXPECT_NEAR(s.EA, 70e9 * A, 1e-15 * s.EA);
    EXPECT_NEAR(s.EIy, 70e9 * A * z * z / 12, 1e-14 * s.EIy);
    EXPECT_NEAR(s.EIz, 70e9 * A * y * y / 12, 1e-14 * s.EIz);
    EXPECT_NEAR(s.rotary_y, 2710 * A * z * z / 12, 1e-14 * s.rotary_y);
    EXPECT_NEAR(s.rotary_z, 2710 * A * y * y / 12, 1e-14 * s.rotary_z);
    EXPECT_NEAR(s.inertia, 2710 * A * (y * y + z * z) / 12, 1e-14 * s.inertia);
    const double kappa = 10 * 1.33 / (12 + 11 * 0.33);
    EXPECT_NEAR(s.GAy, kappa * 70e9 / 2.66 * A, 1e-14 * s.GAy);
    EXPECT_EQ(s.GAz, s.GAy);
}

double torsion_constant(double y, double z) {
    const Section s = section_of(with(kBar, {{"section.rectangle", {y, z}}}));
    return s.GJ / (70e9 / 2.66);
}

/// Prandtl's stress function of a rectangle as a double sine series, ∇²φ = −2, J = 2 ∫φ. The terms left out add less than
/// 1/(3 N³) of the first of their line.
double double_series(double a, double b) {
    double sum = 0;
    for (int m = 399; m > 0; m -= 2)
        for (int n = 399; n > 0; n -= 2) sum += 1 / (1.0 * m * m * n * n * (m * m / (a * a) + n * n / (b * b)));
    return 256 / std::pow(M_PI, 6) * a * b * sum;
}

// Oracle: the double series, another solution of the same equation: 1e-6 of what it leaves out for a strip, less for a
// square; and handbook values (Timoshenko and Goodier, table of k₁) to their digits.
TEST(Section, TheTorsionConstantOfARectangleIsSaintVenants) {
    for (const auto& [y, z] :
         {std::pair(0.02, 0.02), std::pair(0.03, 0.011), std::pair(0.011, 0.03), std::pair(0.05, 0.007)})
        EXPECT_NEAR(torsion_constant(y, z), double_series(y, z), 1e-6 * double_series(y, z)) << y << " x " << z;
    const std::pair<double, double> handbook[] = {{1, 0.1406}, {2, 0.229}, {3, 0.263}, {5, 0.291}, {10, 0.312}};
    for (const auto& [ratio, k] : handbook)
        EXPECT_NEAR(torsion_constant(0.01, 0.01 * ratio) / (std::pow(0.01, 4) * ratio), k, 0.51e-3) << ratio;
    EXPECT_NEAR(torsion_constant(0.01, 0.01) / std::pow(0.01, 4), 0.1406, 5e-5);
    EXPECT_NEAR(torsion_constant(1e-6, 1) / 1e-18, 1.0 / 3, 1e-6);
}

// ---- Material -----------------------------------------------------------------------------------------------------------

// Oracle: G = E/2(1 + ν): either of the two describes the same material. With both, G is used as given and ν for κ only.
TEST(Section, AShearModulusStandsForPoissonsRatio) {
    Given by_G = kTubeSection;
    by_G.erase("material.poisson");
    by_G["material.G"] = {204e9 / 2.52};
    const Section a = section_of(kTubeSection), b = section_of(by_G);
    EXPECT_NEAR(b.GJ, a.GJ, 1e-15 * a.GJ);
    EXPECT_NEAR(b.GAy, a.GAy, 1e-14 * a.GAy);
    const Section both = section_of(with(kTubeSection, {{"material.G", {60e9}}}));
    EXPECT_NEAR(both.GJ / a.GJ, 60e9 * 2.52 / 204e9, 1e-14);
    EXPECT_NEAR(both.GAy / a.GAy, 60e9 * 2.52 / 204e9, 1e-14);
}

TEST(Section, AShearCoefficientTakesThePlaceOfCowpers) {
    const Section a = section_of(kTubeSection), b = section_of(with(kTubeSection, {{"section.shear_coefficient", {0.9}}}));
    EXPECT_NEAR(b.GAy / a.GAy, 0.9 / cowper_tube(0.26, 0.6), 1e-14);
    EXPECT_EQ(b.GAz, b.GAy);
    EXPECT_EQ(b.EIy, a.EIy);
}

TEST(Section, StiffnessDampingIsHandedOn) {
    EXPECT_EQ(section_of(with(kTubeSection, {{"material.stiffness_damping", {3.7e-5}}})).stiffness_damping, 3.7e-5);
    EXPECT_EQ(section_of(with(kStiffnesses, {{"material.stiffness_damping", {3.7e-5}}})).stiffness_damping, 3.7e-5);
}

// Euler-Bernoulli's theory: no shear deformation, no rotary inertia; all else as it was, the polar inertia included.
TEST(Section, EulerBernoulliLeavesOutShearAndRotaryInertia) {
    for (const Given& given : {kTubeSection, kBar, kStiffnesses}) {
        const Section thick = section_of(given), thin = section_of(given, BeamTheory::euler_bernoulli);
        EXPECT_TRUE(std::isinf(thin.GAy) && std::isinf(thin.GAz));
        EXPECT_EQ(thin.rotary_y, 0);
        EXPECT_EQ(thin.rotary_z, 0);
        EXPECT_GT(thick.rotary_y, 0);
        EXPECT_EQ(thin.EIy, thick.EIy);
        EXPECT_EQ(thin.EIz, thick.EIz);
        EXPECT_EQ(thin.GJ, thick.GJ);
        EXPECT_EQ(thin.inertia, thick.inertia);
    }
}

// ---- Sections given by their stiffness ----------------------------------------------------------------------------------

// Oracle: the numbers themselves; rotary inertia from I/A = EI/EA of one material; a tube given either way is one section.
TEST(Section, AStiffnessIsTakenAsGiven) {
    const Section s = section_of(with(kStiffnesses, {{"section.inertia", {0.0123}}}));
    EXPECT_EQ(s.EA, 3.1e8);
    EXPECT_EQ(s.EIy, 5.2e4);
    EXPECT_EQ(s.EIz, 7.7e3);
    EXPECT_EQ(s.GJ, 1.9e4);
    EXPECT_EQ(s.GAy, 6e7);
    EXPECT_EQ(s.GAz, 8.5e7);
    EXPECT_EQ(s.mass, 13.7);
    EXPECT_EQ(s.inertia, 0.0123);
    EXPECT_DOUBLE_EQ(s.rotary_y, 13.7 * 5.2e4 / 3.1e8);
    EXPECT_DOUBLE_EQ(s.rotary_z, 13.7 * 7.7e3 / 3.1e8);
    EXPECT_DOUBLE_EQ(section_of(kStiffnesses).inertia, s.rotary_y + s.rotary_z);

    const Section tube = section_of(kTubeSection);
    const Section again = section_of({{"section.EA", {tube.EA}},
                                      {"section.EIy", {tube.EIy}},
                                      {"section.EIz", {tube.EIz}},
                                      {"section.mass", {tube.mass}}});
    EXPECT_NEAR(again.inertia, tube.inertia, 1e-15 * tube.inertia);
    EXPECT_NEAR(again.rotary_z, tube.rotary_z, 1e-15 * tube.rotary_z);
}

TEST(Section, WhatIsNotGivenIsNotANumber) {
    const Section s = section_of({{"section.EA", {1e9}}, {"section.mass", {30}}});
    for (double value : {s.EIy, s.EIz, s.GJ, s.GAy, s.GAz, s.inertia, s.rotary_y}) EXPECT_TRUE(std::isnan(value));
    EXPECT_EQ(s.offset_y, 0);
    EXPECT_EQ(s.stiffness_damping, 0);
}

// ---- The mass axis ------------------------------------------------------------------------------------------------------

// Oracle: Steiner. The inertia that follows from a shape or from I/A = EI/EA is about the section's own centre and is
// shifted; one that is given is about the elastic axis already.
TEST(Section, AMassOffsetShiftsTheInertiaThatIsNotGiven) {
    const Given offset = {{"section.mass_offset", {0.013, -0.021}}};
    const double square = 0.013 * 0.013 + 0.021 * 0.021;
    for (const Given& given : {kTubeSection, kBar, kStiffnesses}) {
        const Section s = section_of(given), shifted = section_of(with(given, offset));
        EXPECT_EQ(shifted.offset_y, 0.013);
        EXPECT_EQ(shifted.offset_z, -0.021);
        EXPECT_NEAR(shifted.inertia, s.inertia + s.mass * square, 1e-15);
        EXPECT_EQ(shifted.rotary_y, s.rotary_y);
        EXPECT_EQ(shifted.rotary_z, s.rotary_z);
    }
    const Given own = with(with(kStiffnesses, offset), {{"section.inertia", {0.0123}}});
    EXPECT_EQ(section_of(own).inertia, 0.0123);
}

// Oracle: 5 kg/m at sqrt(0.05² + 0.02²) m have 0.0145 kg m, which is the least. In doubles the product is larger than the
// number 0.0145 by its last digit. A billionth less is less by more than rounding.
TEST(Section, TheLeastInertiaOfAMassOffsetIsTaken) {
    const Given line = with(kStiffnesses, {{"section.mass", {5}}, {"section.mass_offset", {0.05, 0.02}}});
    ASSERT_LT(0.0145, 5 * (0.05 * 0.05 + 0.02 * 0.02));
    EXPECT_DOUBLE_EQ(section_of(with(line, {{"section.inertia", {0.0145}}})).inertia, 0.0145);
    EXPECT_THROW(section_of(with(line, {{"section.inertia", {0.0145 * (1 - 1e-9)}}})), Error);
}

// ---- What is refused ----------------------------------------------------------------------------------------------------

TEST(Section, RefusalsNameTheKey) {
    const auto without = [](Given given, const char* name) {
        given.erase(name);
        return given;
    };
    struct Case {
        Given given;
        const char *word, *more;
    };
    const Case cases[] = {
        {{}, "section", "give its shape"},
        {with(kTubeSection, {{"section.circle", {0.02}}}), "section", "one of tube, circle and rectangle"},
        {with(kTubeSection, {{"section.rectangle", {0.02, 0.03}}}), "section", "one of tube, circle and rectangle"},
        {with(kBar, {{"section.circle", {0.02}}}), "section", "one of tube, circle and rectangle"},
        {with(kTubeSection, {{"section.tube", {0, 0}}}), "section.tube", "outer"},
        {with(kTubeSection, {{"section.tube", {0.03, 0.05}}}), "section.tube",
         "0.05 m, must be less than the outer, 0.03 m"},
        {with(kTubeSection, {{"section.tube", {0.03, 0.03}}}), "section.tube", "inner"},
        {without(kTubeSection, "material.E"), "material.E", "needed"},
        {without(kTubeSection, "material.density"), "material.density", "needed"},
        {without(kTubeSection, "material.poisson"), "material.poisson", "material.G"},
        {with(without(kTubeSection, "material.poisson"), {{"material.G", {60e9}}}), "material.G", "Poisson's ratio 0.7"},
        {with(kTubeSection, {{"section.EA", {1}}}), "section.EA", "contradicts the shape"},
        {with(kTubeSection, {{"section.EIy", {1}}}), "section.EIy", "contradicts the shape"},
        {with(kTubeSection, {{"section.EIz", {1}}}), "section.EIz", "contradicts the shape"},
        {with(kTubeSection, {{"section.GJ", {1}}}), "section.GJ", "contradicts the shape"},
        {with(kTubeSection, {{"section.GAy", {1}}}), "section.GAy", "contradicts the shape"},
        {with(kTubeSection, {{"section.GAz", {1}}}), "section.GAz", "contradicts the shape"},
        {with(kTubeSection, {{"section.mass", {1}}}), "section.mass", "contradicts the shape"},
        {with(kTubeSection, {{"section.inertia", {1}}}), "section.inertia", "contradicts the shape"},
        {with(kStiffnesses, {{"material.E", {1}}}), "material.E", "given by its stiffness"},
        {with(kStiffnesses, {{"material.G", {1}}}), "material.G", "given by its stiffness"},
        {with(kStiffnesses, {{"material.poisson", {0.3}}}), "material.poisson", "given by its stiffness"},
        {with(kStiffnesses, {{"material.density", {1}}}), "material.density", "given by its stiffness"},
        {with(kStiffnesses, {{"section.shear_coefficient", {0.8}}}), "section.shear_coefficient", "GAy and GAz"},
        {without(kStiffnesses, "section.EA"), "section", "EA"},
        {without(kStiffnesses, "section.mass"), "section.mass", "needed"},
        {{{"material.E", {204e9}}}, "section", "give its shape"},
        {with(kTubeSection, {{"material.E", {1e-300}}}), "EA", "look at the numbers and units"},
        {with(kTubeSection, {{"material.E", {1e308}}}), "EA", "which must be in [1e-30, 1e+30]"},
        {with(kTubeSection, {{"material.density", {1e-300}}}), "mass", "which must be in"},
        {with(kStiffnesses, {{"section.GAz", {1e31}}}), "GAz comes to 1e+31", "which must be in"},
        {with(kStiffnesses, {{"section.inertia", {0.01}}, {"section.mass_offset", {0.02, 0.03}}}), "section.inertia",
         "0.01781 kg m"},
    };
    for (const Case& c : cases) {
        try {
            section_of(c.given);
            ADD_FAILURE() << "not refused: " << c.word << ", " << c.more;
        } catch (const Error& error) {
            EXPECT_EQ(error.status(), DTTMM_ERROR_MODEL) << error.what();
            EXPECT_THAT(error.what(), HasSubstr(c.word));
            EXPECT_THAT(error.what(), HasSubstr(c.more));
        }
    }
}

}  // namespace
}  // namespace dttmm::plugin
