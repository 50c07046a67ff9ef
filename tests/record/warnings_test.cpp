// SPDX-License-Identifier: BSD-3-Clause
#include "record/warnings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace dttmm::host {
namespace {

using testing::ElementsAre;

TEST(Warnings, EachIsPrintedWhenItComesAndKept) {
    Warnings warnings;
    testing::internal::CaptureStderr();
    warnings.add("free-body", "body \"a\": free body");
    warnings.note("numerical-damping", "took 3 J");
    warnings.add(std::vector<Warning>{{"free-body", "body \"b\": free body"}, {"free-body", "body \"a\": free body"}});
    warnings.print_rest("; see elsewhere");
    EXPECT_EQ(testing::internal::GetCapturedStderr(),
              "warning: body \"a\": free body\nnote: took 3 J\nwarning: body \"b\": free body\n");
    EXPECT_THAT(warnings.all(),
                ElementsAre(Warning{"free-body", "body \"a\": free body"}, Warning{"numerical-damping", "took 3 J"},
                            Warning{"free-body", "body \"b\": free body"}));
    EXPECT_TRUE(warnings.has("numerical-damping"));
    EXPECT_FALSE(warnings.has("energy-balance"));
}

TEST(Warnings, FiftyArePrintedAndTheRestIsCountedByCode) {
    Warnings warnings;
    testing::internal::CaptureStderr();
    for (int i = 0; i < 57; ++i) warnings.add("free-body", "body " + std::to_string(i));
    warnings.add("energy-balance", "open");
    warnings.print_rest("; see elsewhere");
    const std::string text = testing::internal::GetCapturedStderr();
    EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 51);
    EXPECT_TRUE(text.ends_with("warning: body 49\nand 8 more warnings (1 energy-balance, 7 free-body); see elsewhere\n"))
        << text;
    EXPECT_EQ(warnings.all().size(), 58u);
}

// Cases of a sweep: each keeps its own, the sweep prints an equal one once.
TEST(Warnings, APartKeepsItsOwnAndTheWholePrints) {
    Warnings whole;
    testing::internal::CaptureStderr();
    for (int part = 0; part < 2; ++part) {
        Warnings own(whole);
        own.note("gravity-not-in-modes", "without gravity");
        if (part == 1) own.add("no-response", "zero");
        own.print_rest("");
        EXPECT_EQ(own.all().size(), part == 0 ? 1u : 2u);
    }
    EXPECT_EQ(testing::internal::GetCapturedStderr(), "note: without gravity\nwarning: zero\n");
    EXPECT_EQ(whole.all().size(), 2u);
}

}  // namespace
}  // namespace dttmm::host
