// SPDX-License-Identifier: BSD-3-Clause
#include "model/table_file.h"

#include <sys/stat.h>
#include <unistd.h>

#include <fstream>

#include "model/test_model.h"

namespace dttmm::host {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

/// A folder `model` and, beside it, what a model must not reach.
class TableFile : public testing::Test {
protected:
    TableFile()
        : root_(fs::path(testing::TempDir()) / ("table_file_" + std::to_string(getpid()))), folder_(root_ / "model") {
        fs::create_directories(folder_ / "data");
        write(root_ / "secret.csv", "0,31415926\n");
    }
    ~TableFile() override { fs::remove_all(root_); }

    static void write(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }
    void write_load(const std::string& text) { write(folder_ / "load.csv", text); }
    TimeTable read(const std::string& name = "load.csv") { return read_table_file(folder_, name, "N"); }
    std::string fault(const std::string& name = "load.csv") {
        return error_of([&] { read(name); });
    }

    fs::path root_, folder_;
};

TEST_F(TableFile, TwoColumnsWithHeadingAndComments) {
    write_load("time,force\r\n# rise\r\n0, 0\r\n\r\n 0.5 ,1e3\r\n+2,-7\r\n");
    const TimeTable table = read();
    EXPECT_THAT(table.times, ElementsAre(0, 0.5, 2));
    EXPECT_THAT(table.values, ElementsAre(0, 1000, -7));
}

TEST_F(TableFile, FaultsNameTheLineAndNeverQuoteTheFile) {
    write_load("0,1\n1,password\n");
    EXPECT_THAT(fault(), HasSubstr("\"load.csv\" line 2: expected two finite numbers"));
    EXPECT_THAT(fault(), Not(HasSubstr("password")));
    write_load("0,1\n2,1\n2,3\n");
    EXPECT_THAT(fault(), HasSubstr("line 3: the times must increase"));
    for (const char* row : {"1,nan", "inf,1", "1", "1,2,3", "1;2", "1,2 N", "0x1,2"}) {
        write_load("0,1\n" + std::string(row) + "\n");
        EXPECT_THAT(fault(), HasSubstr("line 2")) << row;
    }
    for (const char* text : {"", "time,force\n", "# nothing\n"}) {
        write_load(text);
        EXPECT_THAT(fault(), HasSubstr("has no rows"));
    }
}

TEST_F(TableFile, AHeadingHoldsNoNumber) {
    for (const char* row : {"0,1O00", "0,0x10", "0,1x", "0,1e999", "0,nan", "inf,force", "1st,force"}) {
        write_load(std::string(row) + "\n0.01,500\n0.02,500\n");
        EXPECT_THAT(fault(), HasSubstr("line 1: expected two finite numbers, time and value, and a comma")) << row;
    }
    write_load("information,Newton's force\n0,1\n");
    EXPECT_THAT(read().values, ElementsAre(1));
}

TEST_F(TableFile, ALineOfUnitsConverts) {
    for (const char* head : {"time,force\nms,kN\n", "# a comment\ntime,force\n ms , kN \n", "ms,kN\n"}) {
        write_load(std::string(head) + "0,1\n500,2\n");
        EXPECT_THAT(read().times, ElementsAre(0, 0.5)) << head;
        EXPECT_THAT(read().values, ElementsAre(1000, 2000)) << head;
    }
    for (const char* head : {"t [ms],F [kN]\n", "time (ms), force (kN)\n", "[ms],[kN]\n"}) {
        write_load(std::string(head) + "0,1\n500,2\n");
        EXPECT_THAT(read().times, ElementsAre(0, 0.5)) << head;
        EXPECT_THAT(read().values, ElementsAre(1000, 2000)) << head;
    }
    for (const char* head : {"t [ms],F\n", "t [ms],F [furl]\n", "t,F [kN]\n", "t (measured),F (kN)\n"}) {
        write_load(std::string(head) + "0,1\n");
        EXPECT_THAT(fault(), HasSubstr("line 1: the units in brackets are not both of s and N, e.g. \"t [ms],y [N]\""))
            << head;
    }
    for (const char* units : {"s,mm", "kg,N", "s,furl", "s", "s,N,m", "[s],[N]"}) {
        write_load("time,force\n" + std::string(units) + "\n0,1\n");
        EXPECT_THAT(fault(), HasSubstr("line 2: expected numbers, or the units of time and value in s and N, e.g. \"s,N\""))
            << units;
    }
    write_load("s,N\nms,kN\n0,1\n");
    EXPECT_THAT(fault(), HasSubstr("line 2"));
}

TEST_F(TableFile, StaysInsideTheModelFolder) {
    EXPECT_THAT(fault("../secret.csv"), HasSubstr("is outside the model folder"));
    EXPECT_THAT(fault("data/../../secret.csv"), HasSubstr("is outside the model folder"));
    EXPECT_THAT(fault((root_ / "secret.csv").string()), HasSubstr("is outside the model folder"));
    EXPECT_THAT(fault("../model_beside/load.csv"), HasSubstr("is outside the model folder"));
    fs::create_symlink(root_ / "secret.csv", folder_ / "link.csv");
    EXPECT_THAT(fault("link.csv"), HasSubstr("is outside the model folder, by a link"));
    fs::create_directory_symlink(root_, folder_ / "up");
    EXPECT_THAT(fault("up/secret.csv"), HasSubstr("is outside the model folder"));
    write(folder_ / "data" / "inner.csv", "0,1\n");
    fs::create_symlink(folder_ / "data" / "inner.csv", folder_ / "inner.csv");
    EXPECT_EQ(read("inner.csv").values[0], 1);
    EXPECT_EQ(read("data/../data/inner.csv").values[0], 1);
}

TEST_F(TableFile, IsARegularFileOfReasonableSizeAndName) {
    ASSERT_EQ(mkfifo((folder_ / "fifo").c_str(), 0600), 0);
    EXPECT_THAT(fault("fifo"), HasSubstr("is not a regular file"));
    EXPECT_THAT(fault("data"), HasSubstr("is not a regular file"));
    EXPECT_THAT(fault("none.csv"), HasSubstr("cannot be read"));
    EXPECT_THAT(fault(""), HasSubstr("has no name"));
    EXPECT_THAT(fault("a\nb"), HasSubstr("control character"));
    EXPECT_THAT(fault(std::string(5000, 'a')), HasSubstr("longer than 255"));
    write_load("");
    fs::resize_file(folder_ / "load.csv", std::uintmax_t{100} << 30);  // sparse
    EXPECT_THAT(fault(), HasSubstr("larger than 64 MiB"));
}

}  // namespace
}  // namespace dttmm::host
