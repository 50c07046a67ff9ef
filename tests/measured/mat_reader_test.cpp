// SPDX-License-Identifier: BSD-3-Clause
//
// MAT files that the tests write: of level 5 byte by byte (mat_writer.h), of level 7.3 by HDF5.
#include "measured/mat_reader.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cmath>
#include <fstream>

#include "measured/mat_writer.h"
#include "record/error_matcher.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;
using MatKind = MeasuredSignal::Kind;

Measurement read_bytes_as_mat(const std::string& bytes) {
    const TemporaryFolder folder;
    write_text(folder / "a.mat", bytes);
    return read_mat(folder / "a.mat");
}

Measurement read_variables(const std::vector<std::string>& variables) {
    return read_bytes_as_mat(MatWriter().file(variables));
}

void expect_mat_fault(const std::string& bytes, const testing::Matcher<std::string>& fault) {
    expect_error([&] { read_bytes_as_mat(bytes); }, ExitCode::input_output, fault);
}

std::vector<std::string> names_of(const Measurement& all) {
    std::vector<std::string> names;
    for (const MeasuredSignal& signal : all.signals) names.push_back(signal.name);
    return names;
}

const MeasuredSignal& signal_of(const Measurement& all, const std::string& name) {
    for (const MeasuredSignal& signal : all.signals)
        if (signal.name == name) return signal;
    throw std::out_of_range("no signal " + name);
}

const std::vector<double> kTimes = {0, 0.25, 0.5, 0.75, 1.5};          // 5
const std::vector<double> kFrequencies = {0, 10, 20, 30, 40, 50, 60};  // 7
const std::vector<double> kSeven = {1, -2, 3, -4, 5, -6, 7}, kOthers = {8, 9, -10, 11, 12, -13, 14};

// Oracle: the numbers written. 5 times, 3 columns.
TEST(MatReader, HistoriesAreColumnsOverTime) {
    const MatWriter mat;
    std::vector<double> fifteen(15);
    for (std::size_t i = 0; i < 15; ++i) fifteen[i] = std::pow(-1.7, i) / 3;
    const Measurement all =
        read_variables({mat.array("acc", {5, 3}, fifteen), mat.column("Time", kTimes),
                        mat.array("across", {2, 5}, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10}),
                        mat.array("row", {1, 5}, {5, 4, 3, 2, 1}), mat.array("square", {5, 5}, std::vector<double>(25, 1.0)),
                        mat.array("fs", {1, 1}, {4}), mat.array("none", {0, 0}, {}), mat.text("title", u"a title")});
    EXPECT_EQ(all.format, "MAT file");
    EXPECT_THAT(names_of(all), ElementsAre("acc(1)", "acc(2)", "acc(3)", "across(1)", "across(2)", "row", "square(1)",
                                           "square(2)", "square(3)", "square(4)", "square(5)"));
    for (const MeasuredSignal& signal : all.signals) {
        EXPECT_EQ(signal.kind, MatKind::history);
        EXPECT_EQ(signal.abscissa, kTimes);
        EXPECT_THAT(signal.imaginary, IsEmpty());
        EXPECT_EQ(signal.unit, "");
    }
    EXPECT_EQ(all.signals[1].values, std::vector(fifteen.begin() + 5, fifteen.begin() + 10));
    EXPECT_THAT(all.signals[1].place, HasSubstr("a.mat: acc(2)"));
    EXPECT_THAT(all.signals[4].values, ElementsAre(2, 4, 6, 8, 10));
    EXPECT_THAT(all.notes, ElementsAre("not used: fs 1x1, none 0x0", "not read: title (char)"));
}

TEST(MatReader, ResponsesAndCoherencesOverFrequency) {
    const MatWriter mat;
    std::vector<double> many(42), imaginary(42);
    for (std::size_t i = 0; i < 42; ++i) {
        many[i] = static_cast<double>(i);
        imaginary[i] = -0.5 * static_cast<double>(i);
    }
    const Measurement all =
        read_variables({mat.array("f_Hz", {1, 7}, kFrequencies), mat.column("H", kSeven, kOthers),
                        mat.array("G", {7, 3, 2}, many, imaginary), mat.array("K", {3, 2, 7}, many, imaginary),
                        mat.column("coh", kSeven), mat.column("H_gamma2", kSeven), mat.column("psd", kSeven)});
    EXPECT_EQ(signal_of(all, "H").kind, MatKind::response);
    EXPECT_EQ(signal_of(all, "H").values, kSeven);
    EXPECT_EQ(signal_of(all, "H").imaginary, kOthers);
    EXPECT_EQ(signal_of(all, "H").abscissa, kFrequencies);
    EXPECT_EQ(signal_of(all, "coh").kind, MatKind::coherence);
    EXPECT_EQ(signal_of(all, "H_gamma2").kind, MatKind::coherence);
    EXPECT_EQ(signal_of(all, "psd").kind, MatKind::other);
    EXPECT_THAT(all.notes, ElementsAre(HasSubstr("a.mat: psd: it is real over frequency")));
    // G(f, 3, 2) is at f + 7 (3 - 1 + 3 (2 - 1)), K(3, 2, f) at 3 - 1 + 3 (2 - 1) + 6 f
    EXPECT_EQ(signal_of(all, "G(3,2)").values.at(4), 4 + 7 * 5);
    EXPECT_EQ(signal_of(all, "G(2,1)").imaginary.at(6), -0.5 * (6 + 7 * 1));
    EXPECT_EQ(signal_of(all, "K(3,2)").values.at(4), 5 + 6 * 4);
    EXPECT_EQ(signal_of(all, "K(1,2)").imaginary.at(6), -0.5 * (3 + 6 * 6));
    EXPECT_THAT(all.signals, SizeIs(1 + 6 + 6 + 3));
}

TEST(MatReader, AnImageIsNotManySignals) {
    const MatWriter mat;
    const Measurement all = read_variables({mat.column("t", {0, 1}), mat.array("y", {2, 3}, {1, 2, 3, 4, 5, 6}),
                                            mat.array("image", {2, 200'000}, std::vector<double>(400'000, 1.0))});
    EXPECT_THAT(names_of(all), ElementsAre("y(1)", "y(2)", "y(3)"));
    EXPECT_THAT(all.notes, Contains(HasSubstr("a.mat: image: has more columns than measurements have signals")));
}

TEST(MatReader, NamesOfAbscissae) {
    const MatWriter mat;
    for (const char* name : {"t", "T", "time", "Time", "TIME_s", "t_sec", "time_s"})
        EXPECT_EQ(read_variables({mat.column(name, kTimes), mat.column("y", kTimes)}).signals.at(0).kind, MatKind::history)
            << name;
    for (const char* name : {"f", "freq", "Frequency", "F_HZ", "freq_Hz", "frequency_hz"})
        EXPECT_EQ(read_variables({mat.column(name, kFrequencies), mat.column("H", kSeven, kSeven)}).signals.at(0).kind,
                  MatKind::response)
            << name;
    for (const char* name : {"t_hz", "f_s", "times2", "tf", "axis"})
        expect_mat_fault(mat.file({mat.column(name, kFrequencies), mat.column("y", kSeven)}),
                         HasSubstr("nothing in it can be used"));
    EXPECT_EQ(read_variables({mat.column("t", kTimes), mat.column("coh", kTimes)}).signals.at(0).kind, MatKind::history);
    // f may be a force: it does not ascend
    const Measurement force = read_variables({mat.column("t", kFrequencies), mat.column("f", kSeven)});
    EXPECT_THAT(names_of(force), ElementsAre("f"));
    EXPECT_EQ(force.signals[0].kind, MatKind::history);
}

TEST(MatReader, TimeAndFrequencyOfOneLength) {
    const MatWriter mat;
    const Measurement all =
        read_variables({mat.column("t", kFrequencies), mat.column("f", kFrequencies), mat.column("y", kSeven),
                        mat.column("H", kSeven, kOthers), mat.column("coherence", kSeven)});
    EXPECT_EQ(signal_of(all, "y").kind, MatKind::history);
    EXPECT_EQ(signal_of(all, "H").kind, MatKind::response);
    EXPECT_EQ(signal_of(all, "coherence").kind, MatKind::coherence);
    EXPECT_THAT(all.notes, Contains(HasSubstr("a.mat: y: several abscissae are as long: \"t\" is taken")));
}

TEST(MatReader, StructsHaveTheirOwnAbscissae) {
    const MatWriter mat;
    std::vector<double> later = kTimes;
    for (double& time : later) time += 10;
    const std::vector<double> five = {5, -4, 3, -2, 1};
    const std::string inner = mat.structure("", {"y", "name"}, {mat.column("", five), mat.text("", u"ö")});
    const Measurement all =
        read_variables({mat.column("t", kTimes), mat.column("top", five),
                        mat.structure("run", {"Time_s", "y", "in"}, {mat.column("", later), mat.column("", five), inner}),
                        mat.structure("set", {"y", "more"},
                                      {mat.column("", five), mat.element(14, ""), mat.array("", {2, 2}, {1, 2, 3, 4}),
                                       mat.column("", five)})});
    EXPECT_THAT(names_of(all), ElementsAre("top", "run.y", "run.in.y", "set(1).y", "set(2).more"));
    EXPECT_EQ(signal_of(all, "top").abscissa, kTimes);
    EXPECT_EQ(signal_of(all, "run.y").abscissa, later);
    EXPECT_EQ(signal_of(all, "run.in.y").abscissa, later);
    EXPECT_EQ(signal_of(all, "set(1).y").abscissa, kTimes);
    EXPECT_THAT(all.notes, ElementsAre("not used: set.y 2x2", "not read: run.in.name (char)"));
    // The only abscissa of a file serves all
    const Measurement one = read_variables({mat.structure("axis", {"t"}, {mat.column("", kTimes)}), mat.column("y", five)});
    EXPECT_EQ(signal_of(one, "y").abscissa, kTimes);
}

// Oracle: the same numbers in another form of the format.
TEST(MatReader, EveryTypeOfNumberAndOrderOfBytes) {
    for (const bool is_big_endian : {false, true})
        for (const bool is_compressed : {false, true}) {
            MatWriter mat;
            mat.is_big_endian = is_big_endian;
            mat.is_compressed = is_compressed;
            std::vector<std::string> variables = {
                mat.array("t", {5, 1}, {0, 1, 2, 3, 5}, {}, 2)};  // doubles stored as bytes
            for (const int type : {1, 2, 3, 4, 5, 6, 7, 9, 12, 13})
                variables.push_back(mat.array(fmt::format("y{}", type), {5, 1}, {1, 2, 100, 7, 5}, {}, type,
                                              type == 7   ? 7
                                              : type == 2 ? 9
                                                          : 6));
            variables.push_back(mat.array("z", {5, 1}, {-1, 2, -100, 7, 5}, {5, 4, -3, 2, 1}, 3));
            variables.push_back(mat.array("logical", {5, 1}, {0, 1, 1, 0, 1}, {}, 2, 9 | 0x0200));
            const Measurement all = read_bytes_as_mat(mat.file(variables));
            ASSERT_EQ(all.signals.size(), 12u);
            for (std::size_t i = 0; i < 10; ++i)
                EXPECT_THAT(all.signals[i].values, ElementsAre(1, 2, 100, 7, 5)) << all.signals[i].name;
            EXPECT_THAT(signal_of(all, "z").values, ElementsAre(-1, 2, -100, 7, 5));
            EXPECT_THAT(signal_of(all, "z").imaginary, ElementsAre(5, 4, -3, 2, 1));
            EXPECT_EQ(signal_of(all, "z").kind, MatKind::other) << "complex over time";
            EXPECT_THAT(signal_of(all, "logical").values, ElementsAre(0, 1, 1, 0, 1));
            EXPECT_THAT(signal_of(all, "y2").abscissa, ElementsAre(0, 1, 2, 3, 5));
        }
}

TEST(MatReader, WhatIsNotReadIsNamed) {
    const MatWriter mat;
    const std::string name = mat.element(1, "sys"), mcos = mat.element(1, "MCOS"), frd = mat.element(1, "frd");
    const std::string flags = mat.element(6, std::string("\x11\0\0\0\0\0\0\0", 8));
    const Measurement all = read_variables(
        {mat.column("t", kTimes), mat.matrix(1, "c", {1, 2}, mat.text("", u"a") + mat.column("", kTimes)),
         mat.matrix(5, "sparse", {4, 3}, mat.element(5, "") + mat.element(5, "") + mat.element(9, "")),
         mat.structure("old", {"ResponseData"}, {mat.column("", kTimes)}, 3, "frd"),
         mat.element(14, flags + name + mcos + frd + mat.array("", {6, 1}, {1, 2, 3, 4, 5, 6}, {}, 6)),
         mat.matrix(16, "handle", {1, 1}, mat.structure("", {"f"}, {mat.text("", u"@sin")})), mat.column("y", kTimes),
         mat.matrix(9, "", {1, 8}, mat.element(2, "whatever"))});  // without a name: MATLAB's own
    EXPECT_THAT(names_of(all), ElementsAre("y"));
    EXPECT_THAT(all.notes,
                ElementsAre("not read: c (cell), sparse (sparse matrix), old (object of a MATLAB class), sys (object of a "
                            "MATLAB class), handle (function handle)"));
}

// Numbers that others measured: a four-storey frame on a shake table (Georgia Tech, Y. Wang; github
// ywang-structures/Structural-Model-Updating, FourStoryStructure.mat), rounded to the digits here.
TEST(MatReader, ModesOfAFourStoreyFrame) {
    const MatWriter mat;
    const std::vector<double> frequencies = {0.88289843, 2.74773779, 4.29976448, 5.52947434};
    const std::vector<double> shapes = {-0.37813, -0.71911, -0.96369, -1,      -1,       -0.72017, 0.26341, 0.83509,
                                        1,        -0.99711, -0.36039, 0.63237, -0.16876, 0.43459,  -1,      0.69536};
    const Measurement all =
        read_variables({mat.array("test_frequency", {4, 1}, frequencies), mat.array("test_mode", {4, 4}, shapes)});
    EXPECT_THAT(all.signals, IsEmpty());
    EXPECT_THAT(all.notes, IsEmpty());
    EXPECT_THAT(all.shape_names, ElementsAre("test_mode(1)", "test_mode(2)", "test_mode(3)", "test_mode(4)"));
    ASSERT_EQ(all.modes.size(), 4u);
    for (std::size_t m = 0; m < 4; ++m) {
        EXPECT_EQ(all.modes[m].frequency, frequencies[m]);
        EXPECT_TRUE(std::isnan(all.modes[m].damping));
        EXPECT_EQ(all.modes[m].number, 0);
        for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(all.modes[m].shape.at(i), shapes[4 * m + i]);
    }
    EXPECT_THAT(all.modes[2].place, HasSubstr("a.mat: test_mode(:,3)"));
}

TEST(MatReader, ModesWithDampingBesideOthers) {
    const MatWriter mat;
    const std::vector<double> six = {1, 2, 3, 4, 5, 6}, other = {9, 9, 9, 9, 9, 9};
    const Measurement all =
        read_variables({mat.column("freqNum", {1, 2, 4}), mat.array("psiNum", {2, 3}, other),
                        mat.column("dampExp", {0.011, 0.004, 0.0098}), mat.array("freqExp", {1, 3}, {0.865, 2.687, 4.849}),
                        mat.array("psiExp_m", {2, 3}, six, {0, -1, 0, 1, 0, 0}), mat.column("lambdaExp", {1, 2, 5})});
    ASSERT_EQ(all.modes.size(), 3u);
    EXPECT_EQ(all.modes[1].frequency, 2) << "the names freqNum and psiNum are most alike";
    EXPECT_THAT(all.shape_names, ElementsAre("psiNum(1)", "psiNum(2)"));
    const Measurement only =
        read_variables({mat.column("dampExp", {0.011, 0.004, 0.0098}), mat.array("freqExp", {1, 3}, {0.865, 2.687, 4.849}),
                        mat.array("psiExp_m", {2, 3}, six, {0, -1, 0, 1, 0, 0}), mat.column("lambdaExp", {1, 2, 5})});
    ASSERT_EQ(only.modes.size(), 3u);
    EXPECT_EQ(only.modes[2].damping, 0.0098);
    EXPECT_EQ(only.modes[1].shape.at(1), std::complex(4.0, 1.0));
    EXPECT_THAT(only.notes, ElementsAre("not used: lambdaExp 3x1"));
    const Measurement percent = read_variables(
        {mat.column("zeta", {1.1, 0.4, 0.98}), mat.column("freq", {0.865, 2.687, 4.849}), mat.array("Phi", {2, 3}, six)});
    EXPECT_TRUE(std::isnan(percent.modes.at(0).damping));
    EXPECT_THAT(percent.notes, ElementsAre(HasSubstr("a.mat: zeta: not used: these are no damping ratios")));
    // An evenly spaced vector is an abscissa, whatever else there is
    const Measurement even =
        read_variables({mat.column("freq", kFrequencies),
                        mat.array("mode_frf", {2, 7}, std::vector<double>(14, 1), std::vector<double>(14, 1))});
    EXPECT_THAT(even.modes, IsEmpty());
    EXPECT_THAT(names_of(even), ElementsAre("mode_frf(1)", "mode_frf(2)"));
}

// The layout that `dttmm export --mat` writes.
TEST(MatReader, OwnExportsSayWhatTheirCurvesAre) {
    const MatWriter mat;
    const std::vector<std::string> fields = {"name", "unit", "variable", "over", "over_unit", "file", "label"};
    std::vector<std::string> lines;
    const auto channel = [&](std::initializer_list<std::u16string_view> texts) {
        for (const std::u16string_view text : texts) lines.push_back(mat.text("", text));
    };
    channel({u"bolt-1.force.z", u"N", u"bolt_1_force_z", u"time", u"s", u"history.csv", u""});
    channel({u"Öse.x", u"m/N", u"x_se_x", u"frequency", u"Hz", u"frf.csv", u""});
    channel({u"Āx₂𝄞", u"(N)^2/Hz", u"psd", u"frequency", u"Hz", u"psd.csv", u""});
    channel({u"a", u"N", u"a_order_2", u"rpm_order_2", u"rpm", u"response.csv", u"order 2"});
    const std::vector<double> gap = {5, NAN, 3, 2, 1};
    const auto file = [&](const std::vector<std::string>& more) {
        std::vector<std::string> all = {mat.text("title", u"t"), mat.text("kind", u"run"), mat.text("version", u"1"),
                                        mat.text("command_line", u""), mat.text("model_text", u"")};
        all.insert(all.end(), more.begin(), more.end());
        return all;
    };
    const Measurement all = read_variables(
        file({mat.column("time", kTimes), mat.column("bolt_1_force_z", gap), mat.column("frequency", kFrequencies),
              mat.column("x_se_x", kSeven, kOthers), mat.column("psd", kSeven), mat.column("rpm_order_2", {1, 2, 3}),
              mat.column("a_order_2", {4, 5, 6}, {1, 1, 1}), mat.structure("channels", fields, lines),
              mat.structure("levels", {"rms"}, {mat.column("", kTimes)})}));
    EXPECT_THAT(names_of(all), ElementsAre("bolt-1.force.z", "Öse.x", "Āx₂𝄞", "a"));
    EXPECT_EQ(all.signals[0].kind, MatKind::history);
    EXPECT_EQ(all.signals[0].unit, "N");
    EXPECT_THAT(all.signals[0].values, ElementsAre(5, 3, 2, 1));
    EXPECT_THAT(all.signals[0].abscissa, ElementsAre(0, 0.5, 0.75, 1.5));
    EXPECT_EQ(all.signals[1].kind, MatKind::response);
    EXPECT_EQ(all.signals[1].unit, "m/N");
    EXPECT_EQ(all.signals[1].imaginary, kOthers);
    EXPECT_EQ(all.signals[2].kind, MatKind::other) << "real over frequency";
    EXPECT_EQ(all.signals[3].kind, MatKind::other) << "over speed";

    EXPECT_THAT(all.notes, Contains(HasSubstr("a.mat: bolt_1_force_z: left out: 1 point without a finite value")));
    EXPECT_THAT(all.notes, Contains(HasSubstr("it is over \"rpm_order_2\" in \"rpm\"")));
    EXPECT_THAT(all.notes, Contains("not used: levels.rms 5x1"));
    // One channel: its struct is no array. None: nothing to read
    const Measurement one = read_variables(file({mat.column("time", kTimes), mat.column("bolt_1_force_z", kTimes),
                                                 mat.structure("channels", fields, {lines.begin(), lines.begin() + 7})}));
    EXPECT_THAT(names_of(one), ElementsAre("bolt-1.force.z"));
    expect_mat_fault(
        mat.file(file({mat.structure("modes", {"frequency", "y"}, {mat.column("", kTimes), mat.column("", kTimes)})})),
        HasSubstr("these results of dttmm have no curves"));
    expect_mat_fault(
        mat.file(file({mat.column("time", kTimes), mat.structure("channels", fields, {lines.begin(), lines.begin() + 7})})),
        HasSubstr("\"bolt_1_force_z\" and \"time\" of the channel \"bolt-1.force.z\""));
}

TEST(MatReader, AFileOfNoUseListsItsVariables) {
    const MatWriter mat;
    expect_mat_fault(
        mat.file({mat.array("A", {2, 3}, {1, 2, 3, 4, 5, 6}), mat.text("title", u"abc"), mat.column("f", kFrequencies)}),
        AllOf(HasSubstr("a.mat: nothing in it can be used"),
              HasSubstr("it has A 2x3 double, title 1x3 char, f 7x1 double")));
    expect_mat_fault(mat.file({}), HasSubstr("it has no variable"));
    expect_mat_fault("no MAT file at all", HasSubstr("a.mat: is no MAT file of level 5, 7 or 7.3"));
    expect_error([] { read_mat("/no/such/file.mat"); }, ExitCode::input_output, HasSubstr("/no/such/file.mat: cannot read"));
}

// Cut off within a variable, a file is refused.
TEST(MatReader, AFileThatIsCutOffIsRefused) {
    for (const bool is_compressed : {false, true}) {
        MatWriter mat;
        mat.is_compressed = is_compressed;
        const std::string first = mat.column("t", kTimes),
                          whole = mat.file({first, mat.structure("s", {"y"}, {mat.column("", kTimes)})});
        const std::size_t between = mat.file({first}).size();
        const TemporaryFolder folder;
        write_text(folder / "a.mat", whole);
        for (std::size_t size = whole.size(); size-- > 0;) {
            std::filesystem::resize_file(folder / "a.mat", size);
            expect_error([&] { read_mat(folder / "a.mat"); }, ExitCode::input_output,
                         HasSubstr(size == 128 || size == between ? "nothing in it can be used" : "a.mat: "));
        }
        if (is_compressed) {  // the check sum at the end
            std::string changed = whole;
            changed.back() = static_cast<char>(changed.back() ^ 1);
            expect_mat_fault(changed, HasSubstr("its compressed data are not whole"));
        }
        expect_mat_fault(
            whole.substr(0, whole.size() - 1),
            AllOf(HasSubstr(fmt::format("a.mat: variable 2 at byte {}: ", between)), HasSubstr("save it again")));
    }
}

TEST(MatReader, SizesThatTheFileCannotHoldTakeNoMemory) {
    const MatWriter mat;
    const std::string t = mat.column("t", kTimes);
    const std::string few = mat.matrix(6, "y", {500'000'000, 1}, mat.element(9, std::string(40, '\0')));
    expect_mat_fault(mat.file({t, few}), HasSubstr("there are fewer numbers than its sizes say"));
    const std::string many = mat.matrix(6, "y", {2'000'000'000, 2'000'000'000}, mat.element(9, std::string(40, '\0')));
    expect_mat_fault(mat.file({t, many}), HasSubstr("it has too many numbers"));
    expect_mat_fault(mat.file({mat.matrix(6, "y", {-5, 1}, mat.element(9, std::string(40, '\0')))}),
                     HasSubstr("a size is below 0"));
    const std::string fields = mat.element(5, std::string("\x20\0\0\0", 4)) + mat.element(1, std::string(32, 'a'));
    expect_mat_fault(mat.file({mat.matrix(2, "s", {500'000'000, 1}, fields)}),
                     HasSubstr("there are fewer fields than its sizes say"));
    expect_mat_fault(mat.file({mat.matrix(2, "s", {1, 1}, mat.element(5, std::string(4, '\0')) + mat.element(1, "a"))}),
                     HasSubstr("the names of its fields have no length"));
    std::string deep = mat.column("", kTimes);
    for (int i = 0; i < 40; ++i) deep = mat.structure(i == 39 ? "s" : "", {"a"}, {deep});
    expect_mat_fault(mat.file({deep}), HasSubstr("structs are nested too deep"));
    // 80 MB of zeros in 80 kB
    MatWriter packed;
    packed.is_compressed = true;
    expect_mat_fault(packed.file({packed.matrix(6, "y", {10'000'000, 1}, packed.element(9, std::string(80'000'000, '\0')))}),
                     HasSubstr("it holds hardly anything but one number"));
}

/// Owns an HDF5 identifier of any kind.
class TestId {
public:
    explicit TestId(hid_t id) : id_(id) { EXPECT_GE(id, 0); }
    TestId(const TestId&) = delete;
    TestId& operator=(const TestId&) = delete;
    ~TestId() { H5Idec_ref(id_); }
    operator hid_t() const { return id_; }

private:
    hid_t id_;
};

/// A MAT file of level 7.3 as MATLAB writes it: HDF5 behind 512 bytes. The last subscript runs fastest.
class Mat73Writer {
public:
    explicit Mat73Writer(const std::filesystem::path& path)
        : path_(path), file_(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, TestId(with_user_block()), H5P_DEFAULT)) {}

    hid_t file() const { return file_; }
    /// rows: of HDF5, which are columns of MATLAB.
    void numbers(hid_t group, const char* name, const std::vector<hsize_t>& rows, const std::vector<double>& values,
                 const char* of = "double", bool is_packed = false) const {
        const TestId space(H5Screate_simple(static_cast<int>(rows.size()), rows.data(), nullptr)),
            made(H5Pcreate(H5P_DATASET_CREATE));
        if (is_packed) {
            H5Pset_chunk(made, static_cast<int>(rows.size()), rows.data());
            H5Pset_deflate(made, 3);
        }
        const TestId set(H5Dcreate2(group, name, H5T_IEEE_F64LE, space, H5P_DEFAULT, made, H5P_DEFAULT));
        H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
        give_class(set, of);
    }
    void complex(hid_t group, const char* name, const std::vector<hsize_t>& rows,
                 const std::vector<std::complex<double>>& values) const {
        const TestId type(H5Tcreate(H5T_COMPOUND, 16)),
            space(H5Screate_simple(static_cast<int>(rows.size()), rows.data(), nullptr));
        H5Tinsert(type, "real", 0, H5T_NATIVE_DOUBLE);
        H5Tinsert(type, "imag", 8, H5T_NATIVE_DOUBLE);
        const TestId set(H5Dcreate2(group, name, type, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
        H5Dwrite(set, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
        give_class(set, "double");
    }
    void text(hid_t group, const char* name, const std::u16string& text) const {
        const std::vector<hsize_t> rows = {text.size(), 1};
        const TestId space(H5Screate_simple(2, rows.data(), nullptr));
        const TestId set(H5Dcreate2(group, name, H5T_STD_U16LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
        H5Dwrite(set, H5T_NATIVE_UINT16, H5S_ALL, H5S_ALL, H5P_DEFAULT, text.data());
        give_class(set, "char");
    }
    /// A field of a struct array, or a cell: references to what is in the group #refs#.
    void references(hid_t group, const char* name, const std::vector<std::string>& targets, const char* of = nullptr) const {
        const std::vector<hsize_t> rows = {targets.size(), 1};
        const TestId space(H5Screate_simple(2, rows.data(), nullptr));
        const TestId set(H5Dcreate2(group, name, H5T_STD_REF_OBJ, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
        std::vector<hobj_ref_t> all(targets.size());
        for (std::size_t i = 0; i < targets.size(); ++i) H5Rcreate(&all[i], file_, targets[i].c_str(), H5R_OBJECT, -1);
        H5Dwrite(set, H5T_STD_REF_OBJ, H5S_ALL, H5S_ALL, H5P_DEFAULT, all.data());
        if (of) give_class(set, of);
    }
    hid_t group(const char* name, const char* of) const {
        const hid_t made = H5Gcreate2(file_, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
        if (of) give_class(made, of);
        return made;
    }
    /// MATLAB writes names without a final zero.
    static void give_class(hid_t object, const std::string& of) {
        const TestId type(H5Tcopy(H5T_C_S1)), space(H5Screate(H5S_SCALAR));
        H5Tset_size(type, of.size());
        const TestId attribute(H5Acreate2(object, "MATLAB_class", type, space, H5P_DEFAULT, H5P_DEFAULT));
        H5Awrite(attribute, type, of.data());
    }
    static void give_flag(hid_t object, const char* name) {
        const TestId space(H5Screate(H5S_SCALAR)),
            attribute(H5Acreate2(object, name, H5T_NATIVE_INT, space, H5P_DEFAULT, H5P_DEFAULT));
        const int one = 1;
        H5Awrite(attribute, H5T_NATIVE_INT, &one);
    }
    void close() {
        H5Fclose(file_);
        std::string head = "MATLAB 7.3 MAT-file, written by a test HDF5 schema 1.00 .";
        head.resize(124, ' ');
        head += std::string("\0\2IM", 4);
        std::fstream(path_, std::ios::binary | std::ios::in | std::ios::out) << head;
    }

private:
    static hid_t with_user_block() {
        const hid_t made = H5Pcreate(H5P_FILE_CREATE);
        H5Pset_userblock(made, 512);
        return made;
    }
    std::filesystem::path path_;
    hid_t file_;
};

TEST(MatReader, Level73) {
    const TemporaryFolder folder;
    Mat73Writer mat(folder / "a.mat");
    std::vector<double> ten;
    for (int i = 0; i < 10; ++i) ten.push_back(i / 3.0);
    mat.numbers(mat.file(), "acc", {2, 5}, ten, "double", true);
    mat.numbers(mat.file(), "time", {1, 5}, kTimes);
    mat.complex(mat.file(), "Z", {1, 5}, {{1, 2}, {3, 4}, {5, 6}, {7, 8}, {9, 0}});
    mat.numbers(mat.file(), "sys", {1, 6}, {1, 2, 3, 4, 5, 6}, "frd");
    mat.numbers(mat.file(), "empty", {1, 2}, {0, 0});
    Mat73Writer::give_flag(TestId(H5Oopen(mat.file(), "empty", H5P_DEFAULT)), "MATLAB_empty");
    mat.text(mat.file(), "title", u"aö");
    {
        const TestId refs(mat.group("#refs#", nullptr)), run(mat.group("run", "struct")), set(mat.group("set", "struct")),
            sparse(mat.group("sparse", "double"));
        mat.numbers(run, "t", {5, 1}, {0, 1, 2, 3, 4});
        mat.numbers(run, "y", {1, 5}, {5, 4, 3, 2, 1}, "single");
        mat.numbers(refs, "a", {1, 5}, {1, 2, 3, 4, 5});
        mat.numbers(refs, "b", {1, 5}, {6, 7, 8, 9, 10});
        mat.text(refs, "c", u"in a cell");
        mat.references(set, "y", {"/#refs#/a", "/#refs#/b"});
        mat.references(mat.file(), "cell", {"/#refs#/c"}, "cell");
        Mat73Writer::give_flag(sparse, "MATLAB_sparse");
    }
    mat.close();
    const Measurement all = read_mat(folder / "a.mat");
    EXPECT_THAT(names_of(all), ElementsAre("Z", "acc(1)", "acc(2)", "run.y", "set(1).y", "set(2).y"));
    EXPECT_EQ(signal_of(all, "acc(2)").values, std::vector(ten.begin() + 5, ten.end()));
    EXPECT_EQ(signal_of(all, "acc(2)").abscissa, kTimes);
    EXPECT_THAT(signal_of(all, "Z").values, ElementsAre(1, 3, 5, 7, 9));
    EXPECT_THAT(signal_of(all, "Z").imaginary, ElementsAre(2, 4, 6, 8, 0));
    EXPECT_THAT(signal_of(all, "run.y").abscissa, ElementsAre(0, 1, 2, 3, 4));
    EXPECT_THAT(signal_of(all, "set(2).y").values, ElementsAre(6, 7, 8, 9, 10));
    EXPECT_THAT(all.notes, Contains("not used: empty 0x0"));
    EXPECT_THAT(all.notes,
                Contains("not read: cell (cell), sparse (sparse matrix), sys (object of class frd), title (char)"));
    const std::string whole = read_text(folder / "a.mat");
    for (const std::size_t size : {std::size_t{600}, whole.size() / 2, whole.size() - 1})
        expect_mat_fault(whole.substr(0, size), HasSubstr("the file is cut off or damaged: save it again"));
}

TEST(MatReader, Level73FaultsAreFound) {
    const TemporaryFolder folder;
    Mat73Writer hollow(folder / "hollow.mat");
    {  // sizes without numbers
        const std::vector<hsize_t> rows = {1, 300'000'000};
        const TestId space(H5Screate_simple(2, rows.data(), nullptr));
        const TestId set(H5Dcreate2(hollow.file(), "y", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
        Mat73Writer::give_class(set, "double");
    }
    hollow.close();
    expect_error([&] { read_mat(folder / "hollow.mat"); }, ExitCode::input_output,
                 HasSubstr("hollow.mat: y: it has more numbers than the file holds"));
    Mat73Writer circle(folder / "circle.mat");
    {
        const TestId group(circle.group("s", "struct"));
        H5Lcreate_hard(circle.file(), "s", group, "s", H5P_DEFAULT, H5P_DEFAULT);
        H5Lcreate_external("/etc/hostname", "/x", circle.file(), "elsewhere", H5P_DEFAULT, H5P_DEFAULT);  // is passed over
    }
    circle.close();
    expect_error([&] { read_mat(folder / "circle.mat"); }, ExitCode::input_output,
                 HasSubstr("circle.mat: s.s: it is a part of itself"));
}

}  // namespace
}  // namespace dttmm::host
