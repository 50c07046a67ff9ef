// SPDX-License-Identifier: BSD-3-Clause
//
// A study as the page of a report reads it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "record/temporary_folder.h"
#include "report/base64.h"
#include "report/results.h"

namespace dttmm::host {
namespace {

class StudyResults : public testing::Test {
protected:
    void write(std::size_t cases) const {
        write_text(
            folder_ / "summary.json",
            R"({"format": "dttmm-study-results/1", "title": "plate", "status": "completed", "cases": 3, "completed": 2})");
        write_text(folder_ / "study.json",
                   R"({"format": "dttmm-study/1", "varied": [["k1", "N/m"]], "inputs": {"model_text": "the text"}})");
        std::string rows;
        for (std::size_t i = 1; i <= cases; ++i)
            rows += i == 2 ? "2,failed,,400000,\n" : std::to_string(i) + ",completed,0,500000," + std::to_string(i) + "\n";
        write_text(folder_ / "results.csv", "case,status,warnings,k1,bolt1.force.z.peak\n1,,1,N/m,N\n" + rows);
        write_text(folder_ / "failures.csv", "case,reason\n1,\n2,no mass\n");
    }
    const TemporaryFolder folder_;
};

TEST_F(StudyResults, ParametersAndFiguresOfEveryCase) {
    write(3);
    const Json json = describe_results(folder_.path(), {});
    EXPECT_EQ(json["kind"], "study");
    EXPECT_EQ(json["model_text"], "the text");
    const Json& columns = json["study"]["columns"];
    ASSERT_EQ(columns.size(), 2u);
    EXPECT_EQ(columns[0]["name"], "k1");
    EXPECT_EQ(columns[0]["is_parameter"], true);
    EXPECT_EQ(columns[1]["is_parameter"], false);
    EXPECT_EQ(columns[1]["unit"], "N");
    const std::vector<double> peaks = {1, std::numeric_limits<double>::quiet_NaN(), 3};
    EXPECT_EQ(columns[1]["data"], base64_of_floats(peaks));
    EXPECT_EQ(json["study"]["left_out"], false);
    ASSERT_EQ(json["tables"].size(), 1u);
    EXPECT_EQ(json["tables"][0]["rows"][0][1], "no mass");
}

TEST_F(StudyResults, OfManyCasesEverySoManythIsDrawn) {
    write(45000);
    const Json study = describe_results(folder_.path(), {})["study"];
    EXPECT_EQ(study["every"], 3);
    EXPECT_EQ(study["left_out"], true);
    EXPECT_EQ(study["columns"][0]["data"].get<std::string>().size(), 4u * 15000 * 4 / 3);
}

}  // namespace
}  // namespace dttmm::host
