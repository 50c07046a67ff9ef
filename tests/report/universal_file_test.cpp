// SPDX-License-Identifier: BSD-3-Clause
//
// Universal files read back by columns: uff_reader.h shares nothing with the writer.
#include "report/universal_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "record/error_matcher.h"
#include "record/temporary_folder.h"
#include "report/results.h"
#include "report/uff_reader.h"
#include "report/universal_results.h"

namespace dttmm::host {
namespace {

using ::testing::HasSubstr;

UniversalCurve curve_over(const std::vector<double>& places) {
    UniversalCurve curve;
    curve.lines = {"a [N]", "  a title, \"quoted\"", "25-Nov-26 08:03:00", "", std::string(90, 'x')};
    curve.response = {"plate.corner", 17, -3};
    curve.reference = {"", 0, 0};
    curve.abscissa = {UniversalQuantity::time, {0, 0, 0}, "Time", "s"};
    curve.numerator = {UniversalQuantity::force, {1, 1, 0}, "a\tmoment", "N*m"};
    curve.places = places;
    return curve;
}

UffSet written(const UniversalCurve& curve) {
    std::ostringstream out;
    UniversalFile(out).write(curve);
    const std::vector<UffSet> sets = read_uff(out.str());
    EXPECT_EQ(sets.size(), 1u);
    return sets.front();
}

// Oracle: the numbers written. E20.12 has 13 digits: 5e-13 of itself.
TEST(UniversalFile, EvenRealValuesComeBack) {
    std::vector<double> places, values;
    for (int i = 0; i < 7; ++i) {
        places.push_back(-0.5 + i * 0.125);
        values.push_back(std::pow(-13.7, 3 * i - 9) / 3);
    }
    values[4] = 3e-120;
    UniversalCurve curve = curve_over(places);
    curve.real = values;
    const UffSet set = written(curve);
    EXPECT_EQ(set.number, 58);
    EXPECT_EQ(set.lines[0], "a [N]");
    EXPECT_EQ(set.lines[1], "a title, \"quoted\"");
    EXPECT_EQ(set.lines[3], "NONE");
    EXPECT_EQ(set.lines[4], std::string(80, 'x'));
    EXPECT_EQ(set.text(5, 31, 31), " ");
    EXPECT_EQ(set.text(5, 32, 41), "plate.corn");
    EXPECT_EQ(set.whole(5, 42, 51), 17);
    EXPECT_EQ(set.whole(5, 52, 55), -3);
    EXPECT_EQ(set.trimmed(5, 57, 66), "NONE");
    EXPECT_EQ(set.whole(6, 21, 30), 1);
    EXPECT_EQ(set.whole(8, 1, 10), 13);
    EXPECT_EQ(set.whole(8, 11, 15), 1);
    EXPECT_EQ(set.whole(8, 16, 20), 1);
    EXPECT_EQ(set.trimmed(8, 27, 46), "a moment");
    EXPECT_EQ(set.trimmed(8, 48, 67), "N*m");
    const auto back = read_uff_values(set);
    ASSERT_EQ(back.size(), 7u);
    for (std::size_t i = 0; i < 7; ++i) {
        EXPECT_DOUBLE_EQ(back[i][0], places[i]);
        EXPECT_NEAR(back[i][1], i == 4 ? 0 : values[i], 5e-13 * std::abs(values[i])) << i;
    }
}

TEST(UniversalFile, UnevenAbscissaeStandBesideTheirValues) {
    const std::vector<double> places = {1, 1.2345674, 1.2345676, 1000, 123456.7};
    UniversalCurve real = curve_over(places), complex = curve_over(places);
    const std::vector<double> values = {1, -2, 3, -4, 5};
    const std::vector<std::complex<double>> pairs = {{1, 2}, {3, -4}, {-5, 6}, {7, 8}, {9, -1e-17}};
    real.real = values;
    complex.complex = pairs;
    EXPECT_EQ(written(real).whole(6, 21, 30), 0);
    const auto back = read_uff_values(written(real)), both = read_uff_values(written(complex));
    ASSERT_EQ(back.size(), 5u);
    ASSERT_EQ(both.size(), 5u);
    for (std::size_t i = 0; i < 5; ++i) {
        EXPECT_NEAR(back[i][0], places[i], 5e-11 * places[i]);
        EXPECT_EQ(back[i][1], values[i]);
        EXPECT_EQ(both[i][0], back[i][0]);
        EXPECT_EQ(both[i][1], pairs[i].real());
        EXPECT_EQ(both[i][2], pairs[i].imag());
    }
    EXPECT_EQ(count_merged(places), 0u);
    EXPECT_EQ(count_merged(std::vector<double>{1, 1.00000001, 2, 2, 3}), 0u);
    EXPECT_EQ(count_merged(std::vector<double>{1, 1.000000000001, 2, 2, 3}), 1u) << "the second 2 was one before";
}

// Oracle: the numbers written. Of 13 columns one is a blank, one the point, one perhaps a sign: ten digits and more are left
// without an exponent, six or seven with one.
TEST(UniversalFile, NumbersHaveAllTheDigitsThatTheirColumnsHold) {
    const std::vector<double> places = {-98765.4321098765, -9.99999999996, -1.23456789e-5, 1.23456789012e-5, 0.0123456789012,
                                        9.9999999999996,   15.9154943092,  999999999.96,   1.2345678e12};
    UniversalCurve curve = curve_over(places);
    std::vector<double> values(places.size(), -1);
    curve.real = values;
    const UffSet set = written(curve);
    const auto back = read_uff_values(set);
    ASSERT_EQ(back.size(), places.size());
    for (std::size_t i = 0; i < places.size(); ++i) {
        const double size = std::abs(places[i]);
        const bool has_exponent = size < 1e-3 || size > 1e9;
        const double rounding = has_exponent ? (places[i] < 0 ? 5e-6 : 5e-7) * size : 5e-11 * std::max(1.0, size);
        EXPECT_NEAR(back[i][0], places[i], rounding) << i;
        EXPECT_EQ(set.text(11 + i / 2, 1 + 33 * (i % 2), 1 + 33 * (i % 2)), " ") << "numbers touch: " << i;
    }
}

TEST(UniversalFile, SpacingIsEvenOnlyToTheDigitsOfTheFormat) {
    EXPECT_TRUE(are_even(std::vector<double>{0, 0.1, 0.2, 0.30000000000000004}));
    EXPECT_FALSE(are_even(std::vector<double>{0, 0.1, 0.2001, 0.3}));
    EXPECT_FALSE(are_even(std::vector<double>{2, 2}));
    EXPECT_TRUE(are_even(std::vector<double>{7}));
    // Half and twice the seventh digit of the distance
    EXPECT_TRUE(are_even(std::vector<double>{0, 1 + 0.5e-6, 2}));
    EXPECT_FALSE(are_even(std::vector<double>{0, 1 + 2e-6, 2}));
}

TEST(UniversalFile, TextsAreCutBetweenCharacters) {
    UniversalCurve curve = curve_over({0, 1});
    const std::vector<double> values = {0, 1};
    curve.real = values;
    curve.response.name = "Träger-Öse";  // 12 bytes; the tenth is the first s
    curve.reference.name = "123456789ö";
    const UffSet set = written(curve);
    EXPECT_EQ(set.text(5, 32, 41), "Träger-Ö");
    EXPECT_EQ(set.text(5, 57, 66), "123456789 ");
}

// Oracle: the numbers written.
TEST(UniversalFile, RealAndComplexModesComeBack) {
    UniversalMode mode;
    mode.lines[0] = "mode 3";
    mode.number = 3;
    mode.frequency = 12.3456;
    mode.modal_mass = 0.75;
    mode.labels = {4, 11};
    mode.real = {{1, -2, 3, -4, 5, -6}, {7, 8, 9, 10, 11, 12}};
    UniversalMode damped = mode;
    damped.real.clear();
    damped.eigenvalue = {-2.5, 77.25};
    damped.complex = {{{{1, 2}, {3, 4}, {5, 6}, {7, 8}, {9, 10}, {11, 12}}},
                      {{{-1, 0}, {0, -2}, {3, 3}, {4, 4}, {5, 5}, {6, -6}}}};
    std::ostringstream out;
    UniversalFile file(out);
    file.write(mode);
    file.write(damped);
    const std::vector<UffSet> sets = read_uff(out.str());
    ASSERT_EQ(sets.size(), 2u);
    const UffSet& real = sets[0];
    const int kRecord6[] = {1, 2, 3, 8, 2, 6};
    for (std::size_t i = 0; i < 6; ++i) EXPECT_EQ(real.whole(5, 10 * i + 1, 10 * i + 10), kRecord6[i]) << i;
    EXPECT_EQ(real.whole(6, 11, 20), 4);
    EXPECT_EQ(real.whole(6, 31, 40), 3);
    EXPECT_DOUBLE_EQ(real.number_at(7, 1, 13), 12.3456);
    EXPECT_DOUBLE_EQ(real.number_at(7, 14, 26), 0.75);
    EXPECT_EQ(real.whole(8, 1, 10), 4);
    EXPECT_EQ(real.whole(10, 1, 10), 11);
    for (std::size_t d = 0; d < 6; ++d) {
        EXPECT_EQ(real.number_at(9, 13 * d + 1, 13 * d + 13), mode.real[0][d]);
        EXPECT_EQ(real.number_at(11, 13 * d + 1, 13 * d + 13), mode.real[1][d]);
    }
    const UffSet& complex = sets[1];
    EXPECT_EQ(complex.whole(5, 11, 20), 3);
    EXPECT_EQ(complex.whole(5, 41, 50), 5);
    EXPECT_EQ(complex.whole(6, 11, 20), 6);
    EXPECT_EQ(complex.number_at(7, 1, 13), -2.5);
    EXPECT_EQ(complex.number_at(7, 14, 26), 77.25);
    EXPECT_EQ(complex.whole(11, 1, 10), 11);
    for (std::size_t d = 0; d < 6; ++d) {
        const std::size_t line = 12 + d / 3, at = 26 * (d % 3) + 1;
        EXPECT_EQ(complex.number_at(line, at, at + 12), damped.complex[1][d].real());
        EXPECT_EQ(complex.number_at(line, at + 13, at + 25), damped.complex[1][d].imag());
    }
}

const char* const kUniversalModel =
    R"({"format": "dttmm-response/1", "title": "t", "inputs": {"options": {"--in": [INPUTS]}},
    "model": {"bodies": {"b": {"mass": 2, "center_of_mass": [9, 9, 9], "inertia": [[2,0,0],[0,3,0],[0,0,4]],
    "position": [1, 2, 3], "rotation": [[0,-1,0],[1,0,0],[0,0,1]], "markers": {"m": [10, 0, 0]}}},
    "nodes": {"n": {"position": [7, 8, 9], "rotation": [[1,0,0],[0,1,0],[0,0,1]], "fixed": []}},
    "elements": {"e": {"type": "spring", "from": "b.m", "to": "ground"}}}})";

std::vector<UffSet> functions_of(const TemporaryFolder& folder, std::string inputs, const std::string& rows) {
    std::string summary = kUniversalModel;
    write_text(folder / "summary.json", summary.replace(summary.find("INPUTS"), 6, inputs));
    write_text(folder / "response.csv", rows);
    std::ostringstream out;
    write_functions(read_results(folder.path()), out);
    return read_uff(out.str());
}

// Oracle: the marker is a quarter turn about z from x: at b + 10 y. Nodes in the order b, b.m, n.
TEST(UniversalFile, FunctionsKnowTheirPlacesAndInputs) {
    const TemporaryFolder folder;
    const auto sets =
        functions_of(folder, "\"b.m.z\", \"n.ry\"",
                     "frequency,b.m.rotation.y/b.m.z.re,b.m.rotation.y/b.m.z.im,e.force.x/n.ry.re,e.force.x/n.ry.im\n"
                     "Hz,rad/N,rad/N,N/(N*m),N/(N*m)\n1,3,4,5,6\n2,7,8,9,10\n4,1,2,3,4\n");
    ASSERT_EQ(sets.size(), 5u);
    EXPECT_EQ(sets[0].number, 151);
    EXPECT_EQ(sets[1].number, 164);
    EXPECT_EQ(sets[2].number, 2411);
    EXPECT_DOUBLE_EQ(sets[2].number_at(1, 1, 25), 1);
    EXPECT_NEAR(sets[2].number_at(3, 1, 25), 1, 1e-13) << "cosine of a quarter turn times 10 m";
    EXPECT_NEAR(sets[2].number_at(3, 26, 50), 12, 1e-13);
    EXPECT_DOUBLE_EQ(sets[2].number_at(5, 51, 75), 9);
    const UffSet &angle = sets[3], &force = sets[4];
    EXPECT_EQ(angle.whole(5, 1, 5), 4);
    EXPECT_EQ(angle.whole(5, 42, 51), 2);
    EXPECT_EQ(angle.whole(5, 52, 55), 5);
    EXPECT_EQ(angle.whole(5, 67, 76), 2);
    EXPECT_EQ(angle.whole(5, 77, 80), 3);
    EXPECT_EQ(angle.whole(9, 1, 10), 13);
    EXPECT_EQ(read_uff_values(angle)[1], (std::array<double, 3>{2, 7, 8}));
    EXPECT_EQ(force.trimmed(5, 32, 41), "e");
    EXPECT_EQ(force.whole(5, 42, 51), 0);
    EXPECT_EQ(force.whole(5, 67, 76), 3);
    EXPECT_EQ(force.whole(5, 77, 80), 5);
    EXPECT_EQ(force.trimmed(9, 48, 67), "N*m");
}

TEST(UniversalFile, WithoutAnInputAmplitudesAreASpectrum) {
    const TemporaryFolder folder;
    const auto sets = functions_of(folder, "", "frequency,n.velocity.y.re,n.velocity.y.im\nHz,m/s,m/s\n1,3,4\n2,7,8\n");
    EXPECT_EQ(sets.back().whole(5, 1, 5), 12);
    EXPECT_EQ(sets.back().whole(5, 42, 51), 3);
    EXPECT_EQ(sets.back().whole(5, 52, 55), 2);
    EXPECT_EQ(sets.back().whole(8, 1, 10), 11);
}

TEST(UniversalFile, DensitiesHaveSquaredUnits) {
    const TemporaryFolder folder;
    write_text(folder / "psd.csv", "frequency,n.position.x\nHz,(m)^2/Hz\n1,3\n2,7\n5,\n");
    const auto sets = functions_of(folder, "", "frequency\nHz\n");
    EXPECT_EQ(sets.back().whole(5, 1, 5), 9);
    EXPECT_EQ(sets.back().whole(5, 52, 55), 1);
    EXPECT_EQ(sets.back().whole(8, 11, 15), 2);
    EXPECT_EQ(read_uff_values(sets.back()).size(), 2u) << "a point without a value is left out";
}

TEST(UniversalFile, RefusesResultsWithoutFunctionsOrModes) {
    const TemporaryFolder folder;
    std::string summary = kUniversalModel;
    write_text(folder / "summary.json", summary.replace(summary.find("INPUTS"), 6, ""));
    const Results results = read_results(folder.path());
    std::ostringstream out;
    expect_error([&] { write_functions(results, out); }, ExitCode::usage,
                 HasSubstr("no curves over time, frequency or speed"));
    expect_error([&] { write_modes(results, out); }, ExitCode::usage, HasSubstr("modes have shapes"));
}

}  // namespace
}  // namespace dttmm::host
