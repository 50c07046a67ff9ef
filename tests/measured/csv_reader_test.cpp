// SPDX-License-Identifier: BSD-3-Clause
#include "measured/csv_reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "model/error.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Measurement read_csv_text(const std::string& text) {
    const TemporaryFolder folder;
    write_text(folder / "data.csv", text);
    return read_measured_csv(folder / "data.csv");
}

std::string fault_of(const std::string& text) {
    try {
        read_csv_text(text);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::input_output);
        return error.what();
    }
    return "none";
}

TEST(MeasuredCsv, HistoriesInOtherUnitsOfTime) {
    const Measurement found = read_csv_text("# of the shaker\r\ntime,ch1,\"a, b\"\r\nms,g,\r\n0,1,-2\r\n0.5,1.5,3e-2\r\n");
    ASSERT_EQ(found.signals.size(), 2u);
    EXPECT_EQ(found.signals[0].kind, MeasuredSignal::Kind::history);
    EXPECT_EQ(found.signals[0].name, "ch1");
    EXPECT_EQ(found.signals[0].unit, "g");
    EXPECT_THAT(found.signals[0].abscissa, ElementsAre(0, 5e-4));
    EXPECT_THAT(found.signals[0].values, ElementsAre(1, 1.5));
    EXPECT_EQ(found.signals[1].name, "a, b");
    EXPECT_EQ(found.signals[1].unit, "");
    EXPECT_THAT(found.signals[1].values, ElementsAre(-2, 0.03));
}

// The table of the same numbers as a spreadsheet of another country writes it.
TEST(MeasuredCsv, UnitsInBracketsAndDecimalCommas) {
    const Measurement found = read_csv_text("\xEF\xBB\xBFt [s];a [m/s^2]\n0;1,25\n0,5;-3\n1;+7\n");
    ASSERT_EQ(found.signals.size(), 1u);
    EXPECT_EQ(found.signals[0].unit, "m/s^2");
    EXPECT_THAT(found.signals[0].abscissa, ElementsAre(0, 0.5, 1));
    EXPECT_THAT(found.signals[0].values, ElementsAre(1.25, -3, 7));
}

// Oracle: the same complex numbers in two forms.
TEST(MeasuredCsv, ResponsesByPartsOrByMagnitudeAndPhase) {
    const Measurement parts =
        read_csv_text("frequency,p.z/q.x.re,p.z/q.x.im,p.z/q.x.coherence\nHz,m/N,m/N,1\n2,3,4,0.9\n5,0,-2,1\n");
    const Measurement polar = read_csv_text("f_Hz,p.z.magnitude,p.z.phase\n2,5,53.13010235415598\n5,2,-90\n");
    ASSERT_EQ(parts.signals.size(), 2u);
    ASSERT_EQ(polar.signals.size(), 1u);
    EXPECT_EQ(parts.signals[0].name, "p.z");
    EXPECT_EQ(parts.signals[0].reference, "q.x");
    EXPECT_EQ(parts.signals[0].unit, "m/N");
    EXPECT_EQ(parts.signals[1].kind, MeasuredSignal::Kind::coherence);
    EXPECT_THAT(parts.signals[1].values, ElementsAre(0.9, 1));
    EXPECT_EQ(polar.signals[0].reference, "");
    for (size_t i = 0; i < 2; ++i) {
        EXPECT_NEAR(parts.signals[0].values[i], polar.signals[0].values[i], 1e-14);
        EXPECT_NEAR(parts.signals[0].imaginary[i], polar.signals[0].imaginary[i], 1e-14);
    }
}

TEST(MeasuredCsv, ModesWithDeviationsDampingAndComplexShapes) {
    const Measurement found = read_csv_text(
        "mode,frequency,frequency.deviation,damping_ratio,a.x,b.x.re,b.x.im\n1,Hz,Hz,1,1,1,1\n2,12.5,0.1,0.02,1,-0.5,0."
        "25\n4,30,,,,2,0\n");
    EXPECT_THAT(found.shape_names, ElementsAre("a.x", "b.x"));
    ASSERT_EQ(found.modes.size(), 2u);
    EXPECT_EQ(found.modes[0].number, 2);
    EXPECT_EQ(found.modes[0].frequency, 12.5);
    EXPECT_EQ(found.modes[0].frequency_deviation, 0.1);
    EXPECT_EQ(found.modes[0].damping, 0.02);
    EXPECT_EQ(found.modes[0].shape[1], std::complex<double>(-0.5, 0.25));
    EXPECT_EQ(found.modes[1].frequency_deviation, 0);
    EXPECT_TRUE(std::isnan(found.modes[1].damping));
    EXPECT_TRUE(std::isnan(found.modes[1].shape[0].real())) << "an empty field is no zero";
    const Measurement list = read_csv_text("frequency\n3\n7\n");
    ASSERT_EQ(list.modes.size(), 2u) << "a list of frequencies alone";
    EXPECT_EQ(list.modes[1].frequency, 7);
}

TEST(MeasuredCsv, RefusesWhatWouldMislead) {
    EXPECT_THAT(fault_of("time,a\n0,1\n1,2\n0.5,3\n"), AllOf(HasSubstr("data.csv:4"), HasSubstr("must ascend")));
    EXPECT_THAT(fault_of("time,a\n0,1\n0,2\n"), HasSubstr("must ascend"));
    EXPECT_THAT(fault_of("time,a\n0,1\n1,nan\n"), AllOf(HasSubstr("data.csv:3"), HasSubstr("no finite number")));
    EXPECT_THAT(fault_of("time,a\n0,1\n1,inf\n"), HasSubstr("no finite number"));
    EXPECT_THAT(fault_of("time,a\n0,1\n1,\n"), HasSubstr("no value of \"a\""));
    EXPECT_THAT(fault_of("time,a\n0,1\n1\n"), AllOf(HasSubstr("data.csv:3"), HasSubstr("cut off")));
    EXPECT_THAT(fault_of("time,a,a\n0,1,2\n"), HasSubstr("two columns are called \"a\""));
    EXPECT_THAT(fault_of("time,a\n"), HasSubstr("no row of numbers"));
    EXPECT_THAT(fault_of(""), HasSubstr("empty"));
    EXPECT_THAT(fault_of("0,1\n1,2\n"), HasSubstr("names"));
    EXPECT_THAT(fault_of("place,a\nx,2\n"), HasSubstr("must be \"time\", \"frequency\" or \"mode\""));
    EXPECT_THAT(fault_of("time,a\nkg,m\n0,1\n"), HasSubstr("data.csv:1"));
    EXPECT_THAT(fault_of("frequency,a.re\n1,2\n"), HasSubstr("has not both"));
    EXPECT_THAT(fault_of("frequency,a.phase\n1,2\n"), HasSubstr("phase alone"));
    EXPECT_THAT(fault_of("mode,frequency\n1,-3\n"), HasSubstr("above 0"));
    EXPECT_THAT(fault_of("mode,frequency\n1.5,3\n"), HasSubstr("whole number"));
    EXPECT_THAT(fault_of(std::string("time,a\n0,\0\n", 11)), HasSubstr("no text"));
    EXPECT_THROW(read_measured_csv("/dev/zero"), Error);
    EXPECT_THROW(read_measured_csv("/nowhere/data.csv"), Error);
}

}  // namespace
}  // namespace dttmm::host
