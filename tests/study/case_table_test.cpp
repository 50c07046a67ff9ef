// SPDX-License-Identifier: BSD-3-Clause
#include "study/case_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "model/error.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::Pair;

const std::vector<Parameter> kModel = {{"k", 5e5, "N/m", "500 N/mm"}, {"mass", 2, "kg", "2 kg"}, {"n", 3, "1", "3"}};

class CaseTables : public testing::Test {
protected:
    CaseTable read(const std::string& text) {
        write_text(folder_ / "cases.csv", text);
        return read_case_table(folder_ / "cases.csv", kModel);
    }
    std::string refusal_of(const std::string& text, ExitCode code) {
        try {
            read(text);
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), code) << text;
            return error.what();
        }
        ADD_FAILURE() << "accepted: " << text;
        return {};
    }
    const TemporaryFolder folder_;
};

TEST_F(CaseTables, UnitsInASecondRowOrInCells) {
    for (const char* text :
         {"case,k,mass\n,N/mm,g\n1,400,1500\n2,600,2500\n", "k,mass\r\n400 N/mm,1500 g\r\n0.6 kN/mm,2.5 kg\r\n",
          "\xEF\xBB\xBF# by hand\n\"k\" , mass\n N/mm , g\n\n400, 1500\n600 , 2500\n"}) {
        const CaseTable table = read(text);
        ASSERT_EQ(table.cases(), 2u) << text;
        EXPECT_NEAR(table.values(0, 0), 4e5, 1e-9);
        EXPECT_NEAR(table.values(1, 1), 2.5, 1e-15);
        EXPECT_EQ(table.parameters[0].name, "k");
        EXPECT_EQ(table.parameters[0].unit, "N/m");
    }
}

// Oracle: the same bits back.
TEST_F(CaseTables, ItsTextReadsBack) {
    CaseTable table;
    table.parameters = {{"k", "N/m"}, {"n", "1"}};
    table.values.resize(3, 2);
    table.values << 1.0 / 3, 5e300, -2.5e-300, 7, 0.1, 1e-5;
    const CaseTable back = CaseTable::parse(table.text(), "cases.csv");
    EXPECT_EQ(back.values, table.values);
    EXPECT_EQ(back.parameters[1].unit, "1");
    EXPECT_THAT(back.settings(1), ElementsAre(Pair("k", "-2.5e-300 N/m"), Pair("n", "7")));
    for (const char* damaged : {"", "case,k\n1,N/m\n2,5\n", "case,k\n1,N/m\n1,x\n", "case,k\n1,N/m\n1,5,6\n"}) {
        EXPECT_THROW(CaseTable::parse(damaged, "cases.csv"), Error) << damaged;
    }
}

TEST_F(CaseTables, FaultsAreToldWithTheirLine) {
    EXPECT_THAT(refusal_of("k,mas\n,\n", ExitCode::usage),
                HasSubstr("cases.csv:1: column \"mas\" is no parameter of the model; "
                          "did you mean \"mass\"?"));
    EXPECT_THAT(refusal_of("k\n400\n", ExitCode::usage),
                HasSubstr("cases.csv:2: k = 400 of which unit? the model gives N/mm"));
    EXPECT_THAT(refusal_of("k,k\n1 N/m,1 N/m\n", ExitCode::usage), HasSubstr("two columns are called \"k\""));
    EXPECT_THAT(refusal_of("k,n\nN/m,1\n4e5,2\n4e5\n", ExitCode::model_invalid), HasSubstr("cases.csv:4: 1 cell, but"));
    EXPECT_THAT(refusal_of("k\nN/m\nabc\n", ExitCode::model_invalid), HasSubstr("cases.csv:3: k: "));
    EXPECT_THAT(refusal_of("k\nkg\n3\n", ExitCode::model_invalid),
                AllOf(HasSubstr("cases.csv:2: unit of k: "), HasSubstr("expected a value in N/m")));
    EXPECT_THAT(refusal_of("k;n\nN/m;1\n3;4\n", ExitCode::usage), HasSubstr("fields are separated by commas"));
    EXPECT_THAT(refusal_of("k,n\nN/m,1\n3,\n", ExitCode::model_invalid), HasSubstr("cases.csv:3: n has no value"));
    EXPECT_THAT(refusal_of("k\nN/m\n", ExitCode::model_invalid), HasSubstr("0 rows of values"));
    EXPECT_THAT(refusal_of("\n", ExitCode::model_invalid), HasSubstr("the table is empty"));
    EXPECT_THROW(read_case_table(folder_ / "none.csv", kModel), Error);
}

// A row is a case: none is taken for units or passed over, and a table does not number its cases otherwise.
TEST_F(CaseTables, NoRowIsLost) {
    EXPECT_THAT(refusal_of("k,n\nnan,nan\n500 N/m,3\n", ExitCode::model_invalid), HasSubstr("cases.csv:2: k: "));
    EXPECT_THAT(refusal_of("k,n\nN/m,1\n,\n5,5\n", ExitCode::model_invalid), HasSubstr("cases.csv:3: k has no value"));
    EXPECT_THAT(refusal_of("case,n\n1,3\n1,4\n", ExitCode::model_invalid), HasSubstr("cases.csv:3: case is \"1\""));
    EXPECT_THAT(refusal_of("case,n\n7,3\n", ExitCode::model_invalid), HasSubstr("cases count 1, 2, 3"));
}

}  // namespace
}  // namespace dttmm::host
