// SPDX-License-Identifier: BSD-3-Clause
//
// MAT files read back from their bytes: mat_reader.h shares nothing with matio but zlib.
#include "report/mat_file.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "record/temporary_folder.h"
#include "report/mat_reader.h"

namespace dttmm::host {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

std::map<std::string, MatValue> exported(const TemporaryFolder& folder) {
    write_mat(read_results(folder.path()), read_tables(folder.path()), folder / "out.mat");
    return MatReader::read(read_text(folder / "out.mat"));
}

void expect_bits(const std::vector<double>& found, const std::vector<double>& wanted) {
    ASSERT_EQ(found.size(), wanted.size());
    for (std::size_t i = 0; i < found.size(); ++i)
        EXPECT_EQ(std::bit_cast<uint64_t>(found[i]), std::bit_cast<uint64_t>(wanted[i])) << i;
}

// Oracle: the numbers of the file, bit by bit.
TEST(MatFile, CurvesHaveAllTheirBits) {
    const TemporaryFolder folder;
    std::string text = "time,bolt-1.force.z,bolt_1.force_z,end,Öse.x\ns,N,m,J,rad\n";
    std::vector<double> times, forces;
    for (int i = 0; i < 1357; ++i) {  // more than a block of zlib
        times.push_back(i / 3.0);
        forces.push_back(std::sin(i) * std::pow(10, i % 40 - 20));
        text += fmt::format("{},{},{},-0,{}\n", times.back(), forces.back(), -i, 5e-324);
    }
    write_text(folder / "history.csv", text);
    const auto all = exported(folder);
    expect_bits(all.at("time").real, times);
    EXPECT_THAT(all.at("time").sizes, ElementsAre(1357, 1));
    expect_bits(all.at("bolt_1_force_z").real, forces);
    EXPECT_EQ(all.at("bolt_1_force_z_2").real.back(), -1356);
    EXPECT_TRUE(std::signbit(all.at("end_").real.front()));
    EXPECT_EQ(all.at("x_se_x").real.front(), 5e-324);
    const MatValue& channels = all.at("channels");
    EXPECT_THAT(channels.sizes, ElementsAre(1, 4));
    EXPECT_EQ(channels.field("name", 1).text, u"bolt_1.force_z");
    EXPECT_EQ(channels.field("variable", 1).text, u"bolt_1_force_z_2");
    EXPECT_EQ(channels.field("name", 3).text, u"Öse.x");
    EXPECT_EQ(channels.field("unit", 3).text, u"rad");
    EXPECT_EQ(channels.field("over", 3).text, u"time");
    EXPECT_EQ(channels.field("file", 3).text, u"history.csv");
    EXPECT_EQ(all.at("kind").text, u"run");
}

TEST(MatFile, ResponsesAreComplexAndOrdersStandApart) {
    const TemporaryFolder folder;
    write_text(folder / "summary.json",
               R"({"format": "dttmm-response/1", "title": "a \"ü\" 𝄞", "inputs": {"model_text": "x = 1\n"},
                   "model": {"parameters": {"k": 0.1, "c-2": -3}}})");
    write_text(folder / "response.csv",
               "frequency,rpm,order,a.re,a.im\nHz,rpm,1,N,N\n20,600,2,3,-0.1\n10,300,2,1,2e-9\n50,300,10,5,7\n");
    write_text(folder / "psd.csv", "frequency,a\nHz,(N)^2/Hz\n1,2\n3,4\n5,\n");
    const auto all = exported(folder);
    expect_bits(all.at("rpm_order_2").real, {300, 600});
    expect_bits(all.at("a_order_2").real, {1, 3});
    expect_bits(all.at("a_order_2").imaginary, {2e-9, -0.1});
    expect_bits(all.at("a_order_10").imaginary, {7});
    expect_bits(all.at("frequency").real, {1, 3, 5});
    EXPECT_TRUE(std::isnan(all.at("a").real[2]));
    EXPECT_TRUE(all.at("a").imaginary.empty());
    EXPECT_EQ(all.at("title").text, u"a \"ü\" 𝄞");
    EXPECT_EQ(all.at("model_text").text, u"x = 1\n");
    EXPECT_EQ(all.at("parameters").field("k").real.at(0), 0.1);
    EXPECT_EQ(all.at("parameters").field("c_2").real.at(0), -3);
}

TEST(MatFile, TablesAreStructsOfColumns) {
    const TemporaryFolder folder;
    write_text(folder / "summary.json", R"({"format": "dttmm-spectrum/1"})");
    write_text(folder / "levels.csv", "channel,unit,rms,peak_time\n,,,s\na.x,N,0.25,1\n\"b,\"\"y\",m,-2,3\nc,m,,4\n");
    const auto all = exported(folder);
    const MatValue& levels = all.at("levels");
    ASSERT_EQ(levels.field("channel").of, 1);
    EXPECT_EQ(levels.field("channel").cells.at(1).text, u"b,\"y");
    EXPECT_THAT(levels.field("channel").sizes, ElementsAre(3, 1));
    EXPECT_EQ(levels.field("rms").real[1], -2);
    EXPECT_TRUE(std::isnan(levels.field("rms").real[2]));
    EXPECT_EQ(levels.field("units").field("peak_time").text, u"s");
    EXPECT_EQ(levels.field("units").field("channel").text, u"");
}

TEST(MatFile, NamesAreThoseOfMatlab) {
    MatlabNames names;
    EXPECT_EQ(names.take("bolt1.force.z"), "bolt1_force_z");
    EXPECT_EQ(names.take("bolt1/force z"), "bolt1_force_z_2");
    EXPECT_EQ(names.take("2nd"), "x2nd");
    EXPECT_EQ(names.take("ö"), "x_");
    EXPECT_EQ(names.take(""), "x");
    EXPECT_EQ(names.take("while"), "while_");
    const std::string longest(80, 'a');
    EXPECT_EQ(names.take(longest), std::string(63, 'a'));
    EXPECT_EQ(names.take(longest), std::string(61, 'a') + "_2");
}

TEST(MatFile, AFileThatCannotBeWrittenIsReported) {
    const TemporaryFolder folder;
    write_text(folder / "history.csv", "time,a\ns,N\n0,1\n");
    try {
        write_mat(read_results(folder.path()), {}, folder / "none/out.mat");
        ADD_FAILURE();
    } catch (const std::exception& error) {
        EXPECT_THAT(error.what(), HasSubstr("out.mat: cannot write"));
    }
}

}  // namespace
}  // namespace dttmm::host
