// SPDX-License-Identifier: BSD-3-Clause
#include "measured/read_measurement.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "measured/mat_writer.h"
#include "record/error_matcher.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using ::testing::HasSubstr;

constexpr const char* kUniversalFile =
    "    -1\n    58\nNONE\nNONE\nNONE\nNONE\nNONE\n"
    "    1         0    0         0 NONE              12   3 NONE               0   0\n"
    "         2         3         1  0.00000E+00  2.50000E-01  0.00000E+00\n"
    "        17    0    0    0 Time                 s\n        12    0    0    0 a                    m/s^2\n"
    "         0    0    0    0 NONE                 NONE\n         0    0    0    0 NONE                 NONE\n"
    "  1.00000E+00  2.00000E+00  3.00000E+00\n    -1\n";

// The content says what a file is, whatever it is called.
TEST(ReadMeasurement, TheContentSaysTheFormat) {
    const TemporaryFolder folder;
    MatWriter mat;
    for (const char* name : {"a.csv", "b.mat", "c.uff", "d"}) {
        write_text(folder / name, kUniversalFile);
        const Measurement universal = read_measurement(folder / name);
        EXPECT_EQ(universal.format, "universal file") << name;
        EXPECT_EQ(universal.signals.at(0).name, "12.z");
        write_text(folder / name, std::string(" \r\n\n") + kUniversalFile);
        EXPECT_EQ(read_measurement(folder / name).format, "universal file") << "behind blank lines";
        for (const bool is_big_endian : {false, true}) {
            mat.is_big_endian = is_big_endian;
            write_text(folder / name, mat.file({mat.column("t", {0, 1, 2}), mat.column("y", {3, 5, 4})}));
            EXPECT_EQ(read_measurement(folder / name).format, "MAT file") << name;
        }
        write_text(folder / name, "time,a\ns,m\n0,1\n0.5,-1\n");
        const Measurement csv = read_measurement(folder / name);
        EXPECT_EQ(csv.format, "CSV") << name;
        EXPECT_EQ(csv.signals.at(0).name, "a");
    }
}

TEST(ReadMeasurement, OtherFormatsAreNamed) {
    const TemporaryFolder folder;
    const auto expect = [&](std::string_view bytes, const char* fault) {
        write_text(folder / "x", bytes);
        expect_error([&] { read_measurement(folder / "x"); }, ExitCode::input_output, HasSubstr(fault));
    };
    expect("\x89HDF\r\n\x1a\nmore", "x: is an HDF5 file without the head of a MAT file: save it as CSV");
    expect("PK\x03\x04more", "x: is a ZIP archive, as spreadsheets are");
    expect("\x1f\x8bmore", "compressed with gzip");
    expect("TDSmmore", "a TDMS file");
    expect("\xff\xfet", "text in UTF-16");
    expect("", "x: is empty");
    expect_error([&] { read_measurement(folder / "none"); }, ExitCode::input_output,
                 HasSubstr("none: there is no such file"));
    expect_error([&] { read_measurement(folder.path()); }, ExitCode::input_output, HasSubstr("is no regular file"));
}

}  // namespace
}  // namespace dttmm::host
