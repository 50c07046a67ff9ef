// SPDX-License-Identifier: BSD-3-Clause
#include "model/units.h"

#include <clocale>
#include <numbers>

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;

std::string unit_fault(const std::string& text, const std::string& wanted) {
    return error_of([&] { parse_quantity(text, wanted); });
}

// Oracle: the definition of each unit. Decimal units give the double nearest to the decimal result: equal to the bit.
TEST(Units, DecimalUnitsAreExact) {
    EXPECT_EQ(parse_quantity("500 N/mm", "N/m"), 5e5);
    EXPECT_EQ(parse_quantity("500 kN/mm", "N/m"), 5e8);
    EXPECT_EQ(parse_quantity("0.1 N*s/mm", "N*s/m"), 100.0);
    EXPECT_EQ(parse_quantity("35 mm", "m"), 0.035);  // 35 * 0.001 is 0.035000000000000003
    EXPECT_EQ(parse_quantity("18.4 ms", "s"), 0.0184);
    EXPECT_EQ(parse_quantity("7.85 g/cm^3", "kg/m^3"), 7850.0);
    EXPECT_EQ(parse_quantity("1 in", "m"), 0.0254);
    EXPECT_EQ(parse_quantity("3 mm^2", "m^2"), 3e-6);
    EXPECT_EQ(parse_quantity("204 GPa", "Pa"), 204e9);
    EXPECT_EQ(parse_quantity("-120 mm", "m"), -0.12);
    EXPECT_EQ(parse_quantity("7 us", "s"), 7e-6);
}

// Oracle: UDUNITS, which reads the same unit in brackets: equal to the bit, in value and dimension.
TEST(Units, UsualOnesAreThoseOfUdunits) {
    for (const std::vector<std::string>& row : usual_units())
        for (const std::string& unit : row) {
            if (unit == "1") continue;  // no unit behind a number
            const Quantity usual = parse_quantity("1 " + unit), full = parse_quantity("1 (" + unit + ")");
            EXPECT_EQ(usual.value, full.value) << unit;
            EXPECT_EQ(usual.unit, full.unit) << unit;
            EXPECT_EQ(parse_quantity("35 " + unit, row.front()), parse_quantity("35 (" + unit + ")", row.front())) << unit;
        }
}

// Oracle: a turn is 2 pi. One rounding in the factor, one in the product: 4e-16 of the value.
TEST(Units, AnglesAreInRadians) {
    EXPECT_NEAR(parse_quantity("30 deg", "rad"), std::numbers::pi / 6, 2e-16);
    EXPECT_NEAR(parse_quantity("90°", "rad"), std::numbers::pi / 2, 7e-16);
    EXPECT_NEAR(parse_quantity("3000 rpm", "rad/s"), 100 * std::numbers::pi, 2e-13);
}

TEST(Units, ManySpellingsOfOneUnit) {
    for (const char* text : {"3N/mm", "3 N/mm", " 3  N/mm ", "+3 N/mm", "3 N mm-1", "3 N·mm^-1", "3e0 N/mm", "3.000 N/mm"})
        EXPECT_EQ(parse_quantity(text, "N/m"), 3000.0) << text;
    EXPECT_EQ(parse_quantity("2 N m", "N*m"), 2.0);
    EXPECT_EQ(parse_quantity("2 N.m", "N*m/rad"), 2.0);
}

TEST(Units, PlainNumberIsSiWhateverIsWanted) {
    EXPECT_EQ(parse_quantity("500", "N/m"), 500.0);
    EXPECT_EQ(parse_quantity("1e-3", "s"), 0.001);
}

TEST(Units, QuantityOfAnyDimensionKeepsItsSiUnit) {
    const auto check = [](const char* text, double value, const char* unit) {
        const Quantity quantity = parse_quantity(text);
        EXPECT_EQ(quantity.value, value) << text;
        EXPECT_EQ(quantity.unit, unit) << text;
    };
    check("300N/mm", 3e5, "N/m");
    check("0.1 N*s/mm", 100, "N*s/m");
    check("7", 7, "1");
    check("50 %", 0.5, "1");
    check("50 Hz", 50, "Hz");
    check("2 kN*m/rad", 2000, "N*m/rad");
    check("3 K", 3, "K");
    check("5 kg*m/s", 5, "kg*m*s^-1");
}

TEST(Units, WrongDimensionNamesTheExpectedOneAndTheUnitsAccepted) {
    EXPECT_EQ(unit_fault("500 kg", "N/m"),
              "expected a value in N/m, got \"500 kg\"; accepted here: N/m, N/mm, kN/m, kN/mm, MN/m");
    EXPECT_THAT(unit_fault("5 N", "s"), HasSubstr("accepted here: s, ms, us, min"));
    EXPECT_THAT(unit_fault("5 N", "m^7"), HasSubstr("accepted here: m^7"));
}

TEST(Units, UnknownUnitIsNamed) {
    EXPECT_THAT(unit_fault("500 N/furlongx", "N/m"),
                HasSubstr("unknown unit \"N/furlongx\" in \"500 N/furlongx\"; accepted here: N/m, N/mm"));
    EXPECT_THAT(unit_fault("500 N/mM", "N/m"), HasSubstr("unknown unit \"N/mM\""));
    EXPECT_NEAR(parse_quantity("500 N/furlong", "N/m"), 500 / 201.168,
                1e-5);  // a unit after all, of the US survey foot: 2e-6
}

TEST(Units, WhatIsNoNumberIsToldWhatIsWanted) {
    EXPECT_EQ(unit_fault("x", "N/m"), "expected a number with a unit, e.g. \"20 N/m\", got \"x\"");
    EXPECT_EQ(unit_fault("x", "1"), "expected a number, got \"x\"");
    EXPECT_EQ(error_of([] { parse_quantity("x"); }), "expected a number with a unit, e.g. \"20 mm\", got \"x\"");
}

TEST(Units, OnlyUnitsThatMultiplyPass) {
    for (const char* text :
         {"20 degC", "3 lg(re 1 mW)", "5 seconds since 2000-01-01", "5 m @ 3", "5 2 m", "5 -3 m", "5 .1 m", "5 +m"})
        EXPECT_THAT(error_of([&] { parse_quantity(text); }), HasSubstr("unknown unit")) << text;
}

// 50 Hz are 100 pi rad/s: UDUNITS calls both 1/s, and a factor of 2 pi would be lost without a word.
TEST(Units, CyclesAndRadiansAreKeptApart) {
    EXPECT_THAT(unit_fault("50 Hz", "rad/s"), HasSubstr("expected a value in rad/s"));
    EXPECT_THAT(unit_fault("314 rad/s", "Hz"), HasSubstr("expected a value in Hz"));
    EXPECT_THAT(unit_fault("3000 rpm", "Hz"), HasSubstr("expected a value in Hz"));
    EXPECT_THAT(unit_fault("3000 1/min", "rad/s"), AllOf(HasSubstr("expected a value in rad/s"), HasSubstr("rpm")));
    EXPECT_EQ(parse_quantity("3000 1/min", "Hz"), 50.0);
    EXPECT_EQ(parse_quantity("3000 1/min").unit, "Hz");
    EXPECT_EQ(parse_quantity("314 1/s", "rad/s"), 314.0);
    EXPECT_FALSE(measures("Hz", "rad/s"));
    EXPECT_TRUE(measures("N*m", "N*m/rad"));
    EXPECT_FALSE(measures("N*m/rad", "N*m"));
    EXPECT_FALSE(measures("furlongx", "m"));
    EXPECT_EQ(parse_quantity("314 1/s").unit, "1/s");
    EXPECT_THAT(accepted_units("Hz"), testing::ElementsAre("Hz", "1/s", "kHz"));
    EXPECT_TRUE(measures(parse_quantity("5 kg*m/s").unit, "N*s"));
}

TEST(Units, ANulDoesNotHideWhatFollows) {
    EXPECT_THAT(unit_fault(std::string("5 m\0foo", 7), "m"), HasSubstr("unknown unit \"m\\u{0}foo\""));
}

TEST(Units, CommaHintsAtThePoint) { EXPECT_THAT(unit_fault("0,5 mm", "m"), HasSubstr("the decimal sign is a point")); }

TEST(Units, NumbersMustBeFiniteAndInRange) {
    for (const char* text : {"inf m", "nan", "-infinity"})
        EXPECT_THAT(unit_fault(text, "m"), HasSubstr("not finite")) << text;
    for (const char* text : {"1e999 m", "1e-400 m", "1e306 km"})
        EXPECT_THAT(unit_fault(text, "m"), HasSubstr("out of range")) << text;
    for (const char* text : {"mm", "x5", "--5 m", "= 5"})
        EXPECT_THAT(unit_fault(text, "m"), HasSubstr("expected a number")) << text;
    for (const char* text : {"", "  "}) EXPECT_THAT(unit_fault(text, "m"), HasSubstr("empty")) << text;
    EXPECT_THAT(unit_fault("5 " + std::string(100000, 'm'), "m"), HasSubstr("100002 bytes"));
}

TEST(Units, TheLocaleDoesNotMatter) {
    const char* old = std::setlocale(LC_ALL, nullptr);
    for (const char* locale : {"de_DE.UTF-8", "C"}) {  // where the first is not installed nothing changes
        std::setlocale(LC_ALL, locale);
        EXPECT_EQ(parse_quantity("0.5 mm", "m"), 0.0005);
    }
    std::setlocale(LC_ALL, old);
}

}  // namespace
}  // namespace dttmm::host
