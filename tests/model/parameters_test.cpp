// SPDX-License-Identifier: BSD-3-Clause
#include "model/parameters.h"

#include <fmt/format.h>

#include <cmath>

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

/// A valid model whose [parameters] are `text`; the first line of it is line 13.
std::string with_parameters(const std::string& text) { return model_with("[parameters]\n" + text); }

std::vector<Parameter> parameters_of(const std::string& text, const Parameters::Overrides& overrides = {}) {
    ModelOverrides all;
    all.parameters = overrides;
    return parse(with_parameters(text), all).parameters;
}

std::string parameter_fault(const std::string& text) { return errors_of(with_parameters(text)); }

std::string override_fault(const Parameters::Overrides& overrides, ExitCode code) {
    ModelOverrides all;
    all.parameters = overrides;
    return errors_of(with_parameters("k1 = \"500 N/mm\"\nc = 2\n"), all, code);
}

TEST(Parameters, NumbersQuantitiesAndExpressionsInAnyOrder) {
    const auto p = parameters_of("d = \"=2*b + a\"\na = 3\nb = \"=c\"\nc = \"500 N/mm\"\n");
    ASSERT_EQ(p.size(), 4u);
    EXPECT_EQ(p[0].name, "d");
    EXPECT_EQ(p[0].value, 1000003);
    EXPECT_EQ(p[0].unit, "");
    EXPECT_EQ(p[0].text, "=2*b + a");
    EXPECT_EQ(p[1].unit, "1");
    EXPECT_EQ(p[2].value, 500000);
    EXPECT_EQ(p[2].unit, "N/m");  // a bare name keeps the unit
    EXPECT_EQ(p[3].text, "500 N/mm");
}

TEST(Parameters, AChainOfManyIsNoRecursion) {
    std::string text = "p0 = 1\n";
    for (int i = 1; i <= 3000; ++i) text += fmt::format("p{} = \"=p{} + 1\"\n", i, i - 1);
    EXPECT_EQ(parameters_of(text).back().value, 3001);
}

TEST(Parameters, OverridesReplaceValues) {
    const auto p = parameters_of("k = \"500 N/mm\"\nm = \"=2*k\"\n", {{"k", "400 N/mm"}});
    EXPECT_EQ(p[0].value, 400000);
    EXPECT_EQ(p[0].text, "400 N/mm");
    EXPECT_EQ(p[1].value, 800000);
    EXPECT_EQ(parameters_of("k = 1\n", {{"k", "2.5"}})[0].value, 2.5);
    EXPECT_EQ(parameters_of("k = 1\nq = 3\n", {{"k", "=2*q"}})[0].value, 6);
}

TEST(Parameters, WrongOverridesAreWrongUsage) {
    EXPECT_EQ(override_fault({{"k9", "1"}}, ExitCode::usage),
              "--set k9: the model has no such parameter; did you mean \"k1\"?");
    EXPECT_EQ(override_fault({{"k1", ""}}, ExitCode::usage), "--set k1: no value; write --set k1=VALUE");
    EXPECT_THAT(override_fault({{"k1", "5 N/mM"}}, ExitCode::model_invalid),
                HasSubstr("--set k1: parameter \"k1\": unknown unit \"N/mM\""));
}

// 400 stands for 400 N/m in SI and, beside "500 N/mm", for 400 N/mm: a thousandfold difference.
TEST(Parameters, APlainNumberDoesNotReplaceAValueWithAUnit) {
    EXPECT_EQ(override_fault({{"k1", "400"}}, ExitCode::usage),
              "--set k1=400: of which unit? the file gives N/mm; write --set k1=\"400 N/mm\"");
    EXPECT_THAT(override_fault({{"k1", "40 %"}}, ExitCode::usage), HasSubstr("of which unit?"));
    EXPECT_THAT(error_of(
                    [] {
                        parameters_of("k = \"500 N/mm\"\nj = \"=k\"\n", {{"j", "400"}});
                    },
                    ExitCode::usage),
                HasSubstr("--set j=400: of which unit? the file gives N/mm"));
    EXPECT_EQ(parameters_of("k = \"500 N/mm\"\n", {{"k", "0"}})[0].value, 0);       // the same in every unit
    EXPECT_EQ(parameters_of("k = \"500 N/mm\"\n", {{"k", "=4e5"}})[0].value, 4e5);  // expressions are in SI
    EXPECT_EQ(parameters_of("k = \"50 %\"\n", {{"k", "0.4"}})[0].value, 0.4);
    EXPECT_EQ(parameters_of("k = \"500 N/mm\"\nj = \"=2*k\"\n", {{"j", "4"}})[1].value, 4);
}

// In an expression a value has no unit any more: only the parameter itself can tell that newtons are no stiffness.
TEST(Parameters, AnotherDimensionDoesNotReplaceAValueWithAUnit) {
    EXPECT_EQ(override_fault({{"k1", "3 N"}}, ExitCode::model_invalid),
              "--set k1: parameter \"k1\": expected a value in N/m, got \"3 N\"; accepted here: N/m, N/mm, kN/m, kN/mm, "
              "MN/m");
    EXPECT_EQ(parameters_of("k = \"500 N/mm\"\n", {{"k", "3 kN/m"}})[0].value, 3000);
    EXPECT_EQ(parameters_of("k = \"5 N*m\"\n", {{"k", "3 N*m/rad"}})[0].value, 3);  // the radian is a pure number
    EXPECT_EQ(parameters_of("k = \"5 N*m/rad\"\n", {{"k", "3 N*m"}})[0].value, 3);
    EXPECT_EQ(parameters_of("k = 5\n", {{"k", "3 N"}})[0].value, 3);  // the file gives no dimension
    EXPECT_EQ(parameters_of("k = \"5 N\"\nj = \"=2*k\"\n", {{"j", "3 mm"}})[1].value, 0.003);
}

TEST(Parameters, CirclesAreNamedOnce) {
    const std::string text = parameter_fault("x = \"=a\"\na = \"=b\"\nb = \"=c + 1\"\nc = \"=2*a\"\ns = \"=s\"\n");
    EXPECT_EQ(text,
              "m.toml:14:1: parameter \"a\": depends on itself: a -> b -> c -> a\nm.toml:17:1: parameter \"s\": depends on "
              "itself: s -> s");
}

TEST(Parameters, FaultsHaveTheirPlace) {
    EXPECT_THAT(parameter_fault("a = 1\nb = \"=aa + 1\"\n"), HasSubstr("m.toml:14:1: parameter \"b\": unknown name \"aa\""));
    EXPECT_THAT(parameter_fault("a = \"=1/0\"\n"),
                HasSubstr("m.toml:13:1: parameter \"a\": the value of \"=1/0\" is not finite"));
    EXPECT_THAT(parameter_fault("a = true\n"),
                HasSubstr("must be a number, a quantity or an expression, not true or false"));
    EXPECT_THAT(parameter_fault("a = nan\n"), HasSubstr("must be finite"));
    EXPECT_THAT(parameter_fault("a = \"=\"\n"), HasSubstr("nothing follows"));
    EXPECT_THAT(parameter_fault("t = 1\n"), HasSubstr("has the name of the time"));
    EXPECT_THAT(parameter_fault("\"a b\" = 1\n"), HasSubstr("parameter \"a b\" holds the character U+0020"));
    EXPECT_THAT(parameter_fault("\"\\u00e9\" = 1\n\"e\\u0301\" = 1\n"),
                HasSubstr("m.toml:14:1: parameter \"é\" exists already, line 13"));
    EXPECT_THAT(errors_of(std::string("parameters = 3\n") + model_with("")),
                HasSubstr("m.toml:1:14: parameters must be a table"));
}

TEST(Parameters, AFaultIsNotToldAgainWhereItIsUsed) {
    const std::string element = "[[element]]\nname=\"e\"\ntype=\"spring_damper\"\nfrom=\"ground\"\nto=\"plate\"\n";
    const std::string text =
        errors_of(model_with("[parameters]\na = \"5 foo\"\nb = \"=a\"\n" + element + "stiffness = \"=b\"\n"));
    EXPECT_EQ(text, "m.toml:13:1: parameter \"a\": unknown unit \"foo\" in \"5 foo\"");
}

TEST(Parameters, ADimensionIsCheckedWhereABareNameIsUsed) {
    const std::string element = "[[element]]\nname=\"e\"\ntype=\"spring_damper\"\nfrom=\"ground\"\nto=\"plate\"\n";
    const std::string text = errors_of(model_with("[parameters]\nk = \"500 kg\"\n" + element + "stiffness = \"=k\"\n"));
    EXPECT_THAT(
        text,
        HasSubstr(
            "m.toml:19:13: element \"e\": stiffness: expected a value in N/m, got \"=k\", which is \"500 kg\" (line 13)"));
    EXPECT_EQ(parse(model_with("[parameters]\nk = \"500 kg\"\n" + element + "stiffness = \"=k/2\"\n")).elements[0].values[0],
              250);
}

// Oracle: the time it takes. Written out, the 60th of these parameters has 2^60 names.
TEST(Parameters, ManyWaysToAParameterAreOneLook) {
    std::string text = "Omega = 2\np0 = 1\n";
    for (int k = 1; k < 60; ++k) text += fmt::format("p{0} = \"=(p{1} + p{1})/2\"\n", k, k - 1);
    const std::string load = "[[load]]\non = \"plate\"\ndirection = [0, 0, 1]\n";
    EXPECT_FALSE(
        parse(with_parameters(text) + load + "harmonic = { amplitude = \"=p59\", frequency = 3 }\n").machine_rests_on_speed);
    text.replace(text.find("p0 = 1"), 6, "p0 = \"=Omega\"");
    EXPECT_THAT(errors_of(with_parameters(text) + load + "harmonic = { amplitude = \"=p59\", order = 1 }\n"),
                HasSubstr("through more than 30 parameters"));
    EXPECT_THAT(errors_of(with_parameters(text) + load + "harmonic = { amplitude = \"=p20\", order = 1 }\n"),
                HasSubstr("at most 1000 are allowed"));
    const Model model =
        parse(with_parameters(text) + load + "harmonic = { amplitude = \"=p3\", order = 1, phase = \"=p2\" }\n");
    EXPECT_EQ(model.loads.back().signal.value(0), 2 * std::cos(2.0));
    EXPECT_TRUE(model.machine_rests_on_speed);  // by its phase
}

TEST(Parameters, AMinusInANameIsWarnedOf) {
    EXPECT_THAT(parse(with_parameters("k-1 = 1\n")).warnings,
                testing::Contains(
                    WarningIs("unusable-parameter",
                              HasSubstr("m.toml:13:1: parameter \"k-1\" cannot be used: '-' is minus in an expression"))));
}

}  // namespace
}  // namespace dttmm::host
