// SPDX-License-Identifier: BSD-3-Clause
#include "report/results.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "record/error_matcher.h"
#include "record/temporary_folder.h"
#include "report/base64.h"

namespace dttmm::host {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

void expect_refusal(const std::filesystem::path& path, const testing::Matcher<std::string>& text) {
    expect_error([&] { describe_results(path, {}); }, ExitCode::input_output, text);
}

TEST(Results, WhatIsNoneIsRefusedAndNamed) {
    const TemporaryFolder folder;
    expect_refusal(folder / "nothing", HasSubstr("nothing: cannot read"));
    expect_refusal(folder.path(), HasSubstr("these are no results of dttmm"));
    write_text(folder / "notes.txt", "x");
    expect_refusal(folder / "notes.txt", HasSubstr("this is no results folder of dttmm"));
    write_text(folder / "model.toml", "x");
    expect_refusal(folder.path(), HasSubstr("this is the folder of a model; run it"));
    expect_refusal(folder / "model.toml", HasSubstr("this is a model; run it"));
}

TEST(Results, ADamagedSummaryIsRefused) {
    const TemporaryFolder folder;
    const auto expect = [&](const char* text, const testing::Matcher<std::string>& message) {
        write_text(folder / "summary.json", text);
        expect_refusal(folder.path(), AllOf(HasSubstr("summary.json: "), message));
    };
    expect("{\"format\": \"dttmm-su", HasSubstr("damaged: "));
    const auto nested = [](size_t levels) {
        return "{\"format\": \"dttmm-spectrum/1\", \"more\": " + std::string(levels - 1, '[') +
               std::string(levels - 1, ']') + "}";
    };
    expect(nested(66).c_str(), HasSubstr("damaged: it is nested more than 64 deep"));
    expect(nested(100000).c_str(), HasSubstr("damaged: it is nested more than 64 deep"));
    write_text(folder / "summary.json", nested(60));
    EXPECT_EQ(describe_results(folder.path(), {})["kind"], "spectrum");
    expect("[]", HasSubstr("this is no summary of dttmm"));
    expect("{\"format\": 3}", HasSubstr("this is no summary of dttmm"));
    expect("{\"format\": \"dttmm-summary/9\"}", HasSubstr("its format \"dttmm-summary/9\" is not known"));
}

TEST(Results, ADamagedTableIsRefusedAtItsPlace) {
    const TemporaryFolder folder;
    write_text(folder / "summary.json", "{\"format\": \"dttmm-summary/1\"}");
    write_text(folder / "history.csv", "time,a\ns,N\n0,1\n0.1,x\n");
    expect_refusal(folder.path(), HasSubstr("history.csv:4: \"x\" of the channel \"a\" is no finite number"));
}

TEST(Results, AKilledRunIsShownAndSaysSo) {
    const TemporaryFolder folder;
    write_text(folder / "history.csv", "time,a\ns,N\n0,1\n0.1,2\n0.2,");
    const Json json = describe_results(folder.path(), {});
    EXPECT_EQ(json["kind"], "run");
    EXPECT_TRUE(json["summary"].is_null());
    ASSERT_EQ(json["notes"].size(), 2u);
    EXPECT_THAT(json["notes"][0].get<std::string>(), HasSubstr("has not ended, or it was killed"));
    EXPECT_THAT(json["notes"][1].get<std::string>(), HasSubstr("last row is not whole"));
    EXPECT_EQ(json["curve_sets"][0]["rows"], 2);
}

TEST(Results, ChosenChannelsAreCounted) {
    const TemporaryFolder folder;
    write_text(folder / "history.csv", "time,a.x,a.y,b\ns,N,N,m\n0,1,2,3\n1,2,3,4\n");
    const Json json = describe_results(folder / "history.csv", {{"a"}, 4000});
    EXPECT_EQ(json["curve_sets"][0]["curves"].size(), 2u);
    EXPECT_THAT(json["notes"].back().get<std::string>(), HasSubstr("2 of the 3 recorded channels"));
    expect_error([&] { describe_results(folder.path(), {{"c"}, 4000}); }, ExitCode::usage, HasSubstr("--channels: "));
}

// Orders over speed: a set each, ascending in speed, though the rows are not.
TEST(Results, OrdersAreSetsOfTheirOwn) {
    const TemporaryFolder folder;
    write_text(folder / "summary.json", "{\"format\": \"dttmm-response/1\"}");
    write_text(folder / "response.csv",
               "frequency,rpm,order,a.re,a.im\nHz,rpm,1,N,N\n20,600,2,3,0\n10,300,2,1,0\n50,300,10,5,0\n");
    const Json json = describe_results(folder.path(), {});
    ASSERT_EQ(json["curve_sets"].size(), 2u);
    EXPECT_EQ(json["curve_sets"][0]["label"], "order 2");
    EXPECT_EQ(json["curve_sets"][0]["places"], base64_of_doubles(std::vector<double>{300, 600}));
    EXPECT_EQ(json["curve_sets"][0]["curves"][0]["values"], base64_of_floats(std::vector<double>{1, 3}));
    EXPECT_EQ(json["curve_sets"][1]["label"], "order 10");
}

// A sweep of one parameter is drawn over it; of a grid over the number of the case.
TEST(Results, ASweepIsDrawnOverItsParameter) {
    const TemporaryFolder folder;
    const std::string head = "case,k,c,status,warnings,f.peak\n,N/m,N*s/m,,,N\n";
    write_text(folder / "sweep.csv",
               head + "case-000001,5,1,completed,0,9\ncase-000002,4,1,failed,0,\ncase-000003,3,1,completed,0,7\n");
    const Json line = describe_results(folder.path(), {})["curve_sets"][0];
    EXPECT_EQ(line["x"], "k");
    EXPECT_EQ(line["places"], base64_of_doubles(std::vector<double>{3, 4, 5}));
    EXPECT_EQ(line["curves"][0]["largest_at"], 5);
    write_text(folder / "sweep.csv",
               head + "case-000001,5,1,completed,0,9\ncase-000002,5,2,completed,0,8\ncase-000003,3,1,completed,0,7\n");
    const Json grid = describe_results(folder.path(), {})["curve_sets"][0];
    EXPECT_EQ(grid["x"], "case");
    EXPECT_EQ(grid["places"], base64_of_doubles(std::vector<double>{1, 2, 3}));
}

}  // namespace
}  // namespace dttmm::host
