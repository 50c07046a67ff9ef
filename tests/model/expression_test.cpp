// SPDX-License-Identifier: BSD-3-Clause
#include "model/expression.h"

#include <cmath>
#include <numbers>

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const Constants kConstants = {{"k", 500.0}, {"mass_2", 3.0}, {"größe", 7.0}, {"k-1", 11.0}, {"min", 13.0}, {"e1", 17.0}};

double value_of(const std::string& text) { return evaluate_expression(text, kConstants); }
std::string expression_fault(const std::string& text) {
    return error_of([&] { value_of(text); });
}

// Oracle: arithmetic by hand.
TEST(Expression, FollowsTheUsualRules) {
    EXPECT_EQ(value_of("1 + 2*3^2"), 19);
    EXPECT_EQ(value_of("-2^2"), -4);
    EXPECT_EQ(value_of("k*mass_2/2"), 750);
    EXPECT_EQ(value_of("größe-k"), -493);
    EXPECT_EQ(value_of("k-1"), 499);  // minus, whatever parameters are called
    EXPECT_EQ(value_of("k > 400 ? 1 : 2"), 1);
    EXPECT_EQ(value_of("max(min(3, 5), 2)"), 3);
    EXPECT_EQ(value_of("1e1 + e1"), 27);
    EXPECT_EQ(value_of("sqrt(16) + ln(1) + log10(100)"), 6);
    EXPECT_EQ(value_of("cos(pi)"), -1);
}

// Oracle: what is not zero is true, as for "?".
TEST(Expression, PartsOfOneAreTrue) {
    const Constants constants = {{"gap", 1e-3}, {"none", 0.0}};
    for (const char* yes : {"0.5 && 1", "gap || 0", "-0.7 || none", "2 && gap", "gap && gap > 0 ? 1 : 0", "0.5 ? 1 : 0"})
        EXPECT_EQ(evaluate_expression(yes, constants), 1) << yes;
    for (const char* no : {"gap && none", "none || 0", "1 && 0"}) EXPECT_EQ(evaluate_expression(no, constants), 0) << no;
}

// Oracle: the formula in C++; the same operations on the same numbers.
TEST(Expression, TimeIsAVariable) {
    const Expression expression("k*sin(2*pi*50*t)", kConstants, "t");
    for (const double t : {0.0, 0.0013, 0.7})
        EXPECT_NEAR(expression.value(t), 500 * std::sin(100 * std::numbers::pi * t), 1e-10) << t;
    EXPECT_THAT(expression_fault("2*t"), HasSubstr("the time exists in the expression of a load only"));
}

TEST(Expression, UnknownNamesGetTheNearest) {
    EXPECT_THAT(expression_fault("mas_2 + 1"),
                HasSubstr("unknown name \"mas_2\" in \"mas_2 + 1\"; did you mean \"mass_2\"?"));
    EXPECT_THAT(expression_fault("sqtr(1)"), HasSubstr("unknown function \"sqtr\" in \"sqtr(1)\"; did you mean \"sqrt\"?"));
    EXPECT_THAT(expression_fault("x*k-1"), HasSubstr("parameter \"k-1\" cannot be used in \"x*k-1\": '-' is minus there"));
    EXPECT_THAT(expression_fault("min + 1"), HasSubstr("is a function; rename the parameter"));
}

TEST(Expression, ValuesMustBeFinite) {
    EXPECT_THAT(expression_fault("1/0"), HasSubstr("the value of \"=1/0\" is not finite"));
    EXPECT_THAT(expression_fault("sqrt(-1)"), HasSubstr("not finite"));
    EXPECT_THAT(expression_fault("10^400"), HasSubstr("not finite"));
}

TEST(Expression, SizeAndDepthAreLimited) {
    const auto nested = [](int depth) {
        return std::string(static_cast<std::size_t>(depth), '(') + "1" + std::string(static_cast<std::size_t>(depth), ')');
    };
    EXPECT_EQ(value_of(nested(30)), 1);
    EXPECT_THAT(expression_fault(nested(40)), HasSubstr("more than 30 brackets"));
    EXPECT_THAT(expression_fault("1" + std::string(4999, ' ')), HasSubstr("5000 bytes; at most 1000"));
}

TEST(Expression, WhatIsNoFormulaIsRefused) {
    for (const char* text : {"", "   ", "1 +", "(1", "1)", "1,2", "1 2", "2**3", "sin()", "sin(1,2)", "k = 5", "t = 5",
                             "\"a\"", "1;2", "#", "0x10", "1..2", "k\n+1", "1e999"})
        EXPECT_NE(expression_fault(text), "") << text;
    EXPECT_THAT(expression_fault("k = 5"), HasSubstr("cannot assign"));
}

TEST(Expression, NamesAreListedOnceWithoutFunctions) {
    EXPECT_THAT(expression_names("a*sin(b) + a*2e3 + größe"), ElementsAre("a", "b", "größe"));
    EXPECT_EQ(bare_name(" k "), "k");
    EXPECT_EQ(bare_name("gro\u0308ße"), "größe");
    for (const char* text : {"k+1", "2", "", "k l", "k-1"}) EXPECT_EQ(bare_name(text), "") << text;
}

}  // namespace
}  // namespace dttmm::host
