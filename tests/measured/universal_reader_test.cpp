// SPDX-License-Identifier: BSD-3-Clause
//
// Universal files that the tests write by the columns of the specification.
#include "measured/universal_reader.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "record/error_matcher.h"
#include "record/temporary_folder.h"

namespace dttmm::host {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
using ::testing::SizeIs;
using UffKind = MeasuredSignal::Kind;

constexpr const char* kMark = "    -1\n";

/// Data set 58 as text: what a test does not set is plain.
struct Uff58 {
    int type = 1;
    std::string entity = "NONE", reference_entity = "NONE";
    int node = 12, direction = 3, reference_node = 7, reference_direction = 2;
    int ordinate = 4;  ///< 2 real single, 4 real double, 5 complex single, 6 complex double
    bool is_even = true;
    double first = 0.5, step = 0.25;
    std::vector<double> places = {};
    std::vector<std::complex<double>> values = {1.0, -2.0, 3.5};
    std::string abscissa = "17|Time|s", numerator = "12|acceleration|m/s^2", denominator = "0|NONE|NONE";
    std::array<int, 3> exponents = {};  ///< of the numerator
    std::string title = "a title";

    bool is_complex() const { return ordinate > 4; }
    bool is_double() const { return ordinate == 4 || ordinate == 6; }

    /// The eleven lines.
    std::string head() const {
        std::string text = fmt::format("{}\nNONE\n25-Nov-26 08:03:00\nNONE\nNONE\n", title);
        text += fmt::format("{:5}{:10}{:5}{:10} {:<10}{:10}{:4} {:<10}{:10}{:4}\n", type, 1, 0, 0, entity, node, direction,
                            reference_entity, reference_node, reference_direction);
        text += fmt::format("{:10}{:10}{:10}{:13.5E}{:13.5E}{:13.5E}\n", ordinate, values.size(), is_even ? 1 : 0,
                            is_even ? first : 0, is_even ? step : 0, 0.0);
        for (const std::string& axis : {abscissa, numerator, denominator, std::string("0|NONE|NONE")}) {
            const std::size_t bar = axis.find('|'), second = axis.find('|', bar + 1);
            const std::array<int, 3> own = &axis == &numerator || axis == numerator ? exponents : std::array<int, 3>{};
            text += fmt::format("{:>10}{:5}{:5}{:5} {:<20} {:<20}\n", axis.substr(0, bar), own[0], own[1], own[2],
                                axis.substr(bar + 1, second - bar - 1), axis.substr(second + 1));
        }
        return text;
    }

    /// Numbers of the points in turn.
    std::vector<std::pair<double, bool>> numbers() const {  // whether it is an abscissa
        std::vector<std::pair<double, bool>> all;
        for (std::size_t i = 0; i < values.size(); ++i) {
            if (!is_even) all.emplace_back(places.at(i), true);
            all.emplace_back(values[i].real(), false);
            if (is_complex()) all.emplace_back(values[i].imag(), false);
        }
        return all;
    }

    std::string text() const {
        std::string all = std::string(kMark) + "    58\n" + head(), line;
        const std::size_t per_line = !is_double() ? 6 : !is_even && is_complex() ? 3 : 4;
        std::size_t in_line = 0;
        for (const auto& [number, is_place] : numbers()) {
            line += is_double() && !is_place ? fmt::format("{:20.12E}", number) : fmt::format("{:13.5E}", number);
            if (++in_line % per_line == 0) line += '\n';
        }
        if (in_line % per_line != 0) line += '\n';
        return all + line + kMark;
    }

    /// Data set 58b. abscissa_size: bytes of an uneven abscissa; 0: as of an ordinate. wrong: added to the number of bytes.
    std::string binary(bool is_big_endian, std::size_t abscissa_size = 0, int wrong = 0,
                       const std::string& stray = "") const {
        std::string data;
        for (const auto& [number, is_place] : numbers()) {
            const std::size_t size = is_place && abscissa_size > 0 ? abscissa_size : is_double() ? 8 : 4;
            const std::uint64_t bits =
                size == 8 ? std::bit_cast<std::uint64_t>(number) : std::bit_cast<std::uint32_t>(static_cast<float>(number));
            for (std::size_t i = 0; i < size; ++i)
                data += static_cast<char>(bits >> 8 * (is_big_endian ? size - 1 - i : i) & 0xff);
        }
        return kMark +
               fmt::format("    58b{:6}{:6}{:12}{:12}{:6}{:6}{:12}{:12}\n", is_big_endian ? 2 : 1, 2, 11,
                           static_cast<int>(data.size()) + wrong, 0, 0, 0, 0) +
               head() + data + stray + kMark;
    }
};

Measurement read_text_as_uff(const std::string& text) {
    const TemporaryFolder folder;
    write_text(folder / "a.uff", text);
    return read_universal(folder / "a.uff");
}

MeasuredSignal only_signal(const std::string& text) {
    const Measurement all = read_text_as_uff(text);
    EXPECT_EQ(all.signals.size(), 1u);
    return all.signals.at(0);
}

void expect_fault(const std::string& text, const testing::Matcher<std::string>& fault) {
    expect_error([&] { read_text_as_uff(text); }, ExitCode::input_output, fault);
}

/// Numbers that E13.5 and four bytes hold exactly: 7 points.
Uff58 exact_record(int ordinate, bool is_even) {
    Uff58 set;
    set.type = ordinate > 4 ? 4 : 1;
    set.abscissa = ordinate > 4 ? "18|Frequency|Hz" : "17|Time|s";
    set.denominator = ordinate > 4 ? "13|force|N" : "0|NONE|NONE";
    set.ordinate = ordinate;
    set.is_even = is_even;
    set.values.clear();
    for (int i = 0; i < 7; ++i) {
        if (!is_even) set.places.push_back(0.125 * i * i - 0.25);
        set.values.emplace_back(std::ldexp(i % 2 ? -3 : 5, i - 4), ordinate > 4 ? 0.5 * i - 1 : 0);
    }
    return set;
}

void expect_values(const MeasuredSignal& signal, const Uff58& set) {
    ASSERT_EQ(signal.values.size(), set.values.size());
    ASSERT_EQ(signal.abscissa.size(), set.values.size());
    ASSERT_EQ(signal.imaginary.size(), set.is_complex() ? set.values.size() : 0);
    for (std::size_t i = 0; i < set.values.size(); ++i) {
        EXPECT_EQ(signal.abscissa[i], set.is_even ? set.first + static_cast<double>(i) * set.step : set.places[i]) << i;
        EXPECT_EQ(signal.values[i], set.values[i].real()) << i;
        if (set.is_complex()) {
            EXPECT_EQ(signal.imaginary[i], set.values[i].imag()) << i;
        }
    }
}

// Oracle: the numbers written, which every form of the format holds exactly. A binary set equals the same set as text.
TEST(UniversalReader, EveryFormOfAFunctionComesBack) {
    for (const int ordinate : {2, 4, 5, 6})
        for (const bool is_even : {true, false}) {
            SCOPED_TRACE(fmt::format("ordinate {} even {}", ordinate, is_even));
            const Uff58 set = exact_record(ordinate, is_even);
            expect_values(only_signal(set.text()), set);
            for (const bool is_big_endian : {false, true}) expect_values(only_signal(set.binary(is_big_endian)), set);
        }
    const Uff58 uneven = exact_record(6, false);
    expect_values(only_signal(uneven.binary(true, 4)), uneven);  // abscissae of four bytes beside ordinates of eight
}

TEST(UniversalReader, WhatAFunctionIsAndWhereItWasMeasured) {
    const TemporaryFolder folder;
    write_text(folder / "a.uff", exact_record(4, true).text() + exact_record(6, true).text());
    const Measurement all = read_universal(folder / "a.uff");
    EXPECT_EQ(all.format, "universal file");
    EXPECT_THAT(all.notes, IsEmpty());
    ASSERT_EQ(all.signals.size(), 2u);
    const MeasuredSignal &history = all.signals[0], &response = all.signals[1];
    EXPECT_EQ(history.kind, UffKind::history);
    EXPECT_EQ(history.name, "12.z");
    EXPECT_EQ(history.reference, "");
    EXPECT_EQ(history.unit, "m/s^2");
    EXPECT_EQ(history.place, (folder / "a.uff").string() + ":2");
    EXPECT_EQ(response.kind, UffKind::response);
    EXPECT_EQ(response.reference, "7.y");
    EXPECT_EQ(response.reference_title, "force");
    EXPECT_EQ(response.unit, "m/s^2");
    EXPECT_EQ(response.reference_unit, "N");
    EXPECT_EQ(response.place, (folder / "a.uff").string() + ":18");  // 13 lines of head, 2 of values, 1 of the end, and 2
}

TEST(UniversalReader, KindsByFunctionTypeAndAbscissa) {
    Uff58 set = exact_record(2, true);
    set.type = 6;
    set.abscissa = "18|Frequency|Hz";
    set.direction = -3;
    const MeasuredSignal coherence = only_signal(set.text());
    EXPECT_EQ(coherence.kind, UffKind::coherence);
    EXPECT_FALSE(coherence.is_reversed) << "a coherence has no sign";
    set.type = 9;
    EXPECT_EQ(only_signal(set.text()).kind, UffKind::other);
    set.type = 4;
    Measurement all = read_text_as_uff(set.text());
    EXPECT_EQ(all.signals.at(0).kind, UffKind::response);
    EXPECT_THAT(all.signals.at(0).imaginary, IsEmpty());
    EXPECT_THAT(all.notes, ElementsAre(HasSubstr("a.uff:2: this response is real")));
    set.abscissa = "17|Time|s";
    EXPECT_EQ(only_signal(set.text()).kind, UffKind::other) << "a response is over frequency";
    // Complex: a history only without imaginary parts
    Uff58 complex = exact_record(6, true);
    complex.type = 1;
    complex.abscissa = "17|Time|s";
    all = read_text_as_uff(complex.text());
    EXPECT_EQ(all.signals.at(0).kind, UffKind::other);
    EXPECT_THAT(all.signals.at(0).imaginary, SizeIs(7));
    EXPECT_THAT(all.notes, ElementsAre(HasSubstr("this history is complex")));
    for (std::complex<double>& value : complex.values) value = value.real();
    const MeasuredSignal history = only_signal(complex.text());
    EXPECT_EQ(history.kind, UffKind::history);
    EXPECT_THAT(history.imaginary, IsEmpty());
}

TEST(UniversalReader, DirectionsAndSigns) {
    const char* kNames[] = {"12", "12.x", "12.y", "12.z", "12.rx", "12.ry", "12.rz"};
    for (int direction = -6; direction <= 6; ++direction) {
        Uff58 set;
        set.direction = direction;
        set.reference_direction = -1;  // of no meaning for a history
        const MeasuredSignal signal = only_signal(set.text());
        EXPECT_EQ(signal.name, kNames[std::abs(direction)]);
        EXPECT_EQ(signal.is_reversed, direction < 0);
    }
    // Of a response, two signs that are both turned leave it as it is
    for (const int out : {3, -3})
        for (const int in : {2, -2}) {
            Uff58 set = exact_record(5, true);
            set.direction = out;
            set.reference_direction = in;
            EXPECT_EQ(only_signal(set.text()).is_reversed, (out < 0) != (in < 0)) << out << in;
        }
    Uff58 bad;
    bad.direction = 7;
    expect_fault(bad.text(), HasSubstr("a.uff:8: direction 7 is none of -6 to 6"));
}

TEST(UniversalReader, Node0IsNoPlace) {
    Uff58 set;
    set.node = 0;
    set.direction = 1;
    set.title = "some words";
    set.numerator = "12|NONE|g";
    EXPECT_EQ(only_signal(set.text()).name, "some words.x");
    set.numerator = "12|label|g";
    EXPECT_EQ(only_signal(set.text()).name, "label.x");
    set.entity = "Mic 01";
    EXPECT_EQ(only_signal(set.text()).name, "Mic 01.x");
    set.title = "bolt1.force.z [N]";  // what this program writes for what is at no node
    EXPECT_EQ(only_signal(set.text()).name, "bolt1.force.z");
    set.node = 3;
    EXPECT_EQ(only_signal(set.text()).name, "3.x");
}

// Oracle: the same numbers in plain form.
TEST(UniversalReader, NumbersInEveryFormOfFortran) {
    Uff58 set;
    set.ordinate = 2;
    set.values.assign(8, 0.0);
    const std::string head = std::string(kMark) + "    58\n" + set.head();
    const auto values_of = [&](const std::string& lines) { return only_signal(head + lines + kMark).values; };
    const auto plain = ElementsAre(-1.25, -2.5, -3e-100, 4e120, 5, 6, -0.07, 8);
    // Fields that touch; exponents of three digits with and without the letter; D for E; a short last line
    EXPECT_THAT(values_of("-1.250000E+00-2.500000E+00-3.00000E-100 4.00000E+120 5.000000E+00 6.000000E+00\n-7.000000E-02 "
                          "8.000000E+00\n"),
                plain);
    EXPECT_THAT(values_of("-1.250000D+00-2.500000d+00-3.00000D-100 4.00000D+120 5.000000D+00 6.000000D+00\n-7.000000D-02"
                          "+8.000000D+00\n"),
                plain);
    EXPECT_THAT(values_of("-1.25000E+000-2.50000E+000-3.000000-100 4.000000+120 0.500000E+01 6.000000E+00\n-7.00000E-002 "
                          "8.000000E+00\n"),
                plain);
    EXPECT_THAT(values_of("-1.25E+00-2.5E+00 -3.0-100 4.+120 +5.E+00+6.\n-7.E-02 8.\n"), plain) << "in no columns";
    EXPECT_THAT(values_of("-1.25 -2.5 -3e-100 +4e120 5\n\n6 -.07 8.          \n"), plain) << "other columns and blank lines";
    EXPECT_THAT(values_of("-1.25\n-2.5\n-3e-100\n4e120\n5\n6\n-.07\n8\n"), plain);
    EXPECT_EQ(values_of(" 1.00000E-400 2 3 4 5 6 7 8\n").at(0), 0) << "too small for a double";
}

// Oracle: the numbers of the lines. Only the columns tell where one ends.
TEST(UniversalReader, PositiveNumbersThatTouchArePartedByColumns) {
    const auto values_of = [](int ordinate, bool is_even, std::size_t points, const std::string& line) {
        Uff58 set;
        set.ordinate = ordinate;
        set.is_even = is_even;
        set.values.assign(points, 0.0);
        set.places.assign(points, 0.0);
        return only_signal(kMark + std::string("    58\n") + set.head() + line + "\n" + kMark);
    };
    const std::string first = "1.2345678E-06", second = "3.1234567E-03", wide = "7.65432101234567E+08",
                      other = "9.87654321098765E-01";
    EXPECT_THAT(values_of(2, true, 3, first + second + first).values, ElementsAre(1.2345678e-6, 3.1234567e-3, 1.2345678e-6));
    EXPECT_THAT(values_of(4, true, 2, wide + other).values, ElementsAre(7.65432101234567e8, 9.87654321098765e-1));
    const MeasuredSignal uneven = values_of(4, false, 2, first + wide + second + other);
    EXPECT_THAT(uneven.abscissa, ElementsAre(1.2345678e-6, 3.1234567e-3));
    EXPECT_THAT(uneven.values, ElementsAre(7.65432101234567e8, 9.87654321098765e-1));
    const MeasuredSignal complex = values_of(6, false, 2, first + wide + other + "\n" + second + other + wide);
    EXPECT_THAT(complex.abscissa, ElementsAre(1.2345678e-6, 3.1234567e-3));
    EXPECT_THAT(complex.imaginary, ElementsAre(9.87654321098765e-1, 7.65432101234567e8));
}

TEST(UniversalReader, LineEndsAndEncodings) {
    const Uff58 plain = exact_record(5, false);
    std::string text = plain.text();
    for (std::size_t at = 0; (at = text.find('\n', at)) != text.npos; at += 2) text.insert(at, "\r");
    expect_values(only_signal(text), plain);
    Uff58 latin = plain;
    latin.numerator = "12|a|m/s\xb2";
    latin.title =
        "Br\xfc"
        "cke";
    EXPECT_EQ(only_signal(latin.text()).unit, "m/s²");
    latin.numerator = "12|a|m/s²";
    EXPECT_EQ(only_signal(latin.text()).unit, "m/s²");
    // fmt pads by characters, as many writers do: columns behind the name are shifted in bytes
    Uff58 shifted = plain;
    shifted.entity = "Träger-Öse";
    shifted.reference_entity = "Füße";
    shifted.node = 123;
    shifted.reference_node = 45;
    EXPECT_EQ(only_signal(shifted.text()).name, "123.z");
    EXPECT_EQ(only_signal(shifted.text()).reference, "45.y");
    // The same name padded by bytes
    std::string bytes = shifted.text();
    bytes.replace(bytes.find("Träger-Öse"), 12, "Träger-Ö");
    bytes.replace(bytes.find("Füße"), 12, "Füße    ");
    EXPECT_EQ(only_signal(bytes).name, "123.z");
    EXPECT_EQ(only_signal(bytes).reference, "45.y");
}

// Oracle: the conversion factors of the units.
TEST(UniversalReader, AbscissaeAreSecondsAndHertz) {
    Uff58 set;
    set.abscissa = "17|Time|ms";
    EXPECT_DOUBLE_EQ(only_signal(set.text()).abscissa[1], 0.75e-3);
    set.type = 6;
    set.abscissa = "18|Frequency|kHz";
    EXPECT_DOUBLE_EQ(only_signal(set.text()).abscissa[1], 750);
    set.abscissa = "18|Frequency|rad/s";
    EXPECT_DOUBLE_EQ(only_signal(set.text()).abscissa[1], 0.75 / (2 * std::numbers::pi));
    for (const char* unknown : {"0|x|Hz", "0|x|hz", "18|x|hz", "1|NONE|NONE"}) {
        set.abscissa = unknown;
        EXPECT_EQ(only_signal(set.text()).kind, UffKind::coherence) << unknown;
        EXPECT_EQ(only_signal(set.text()).abscissa[1], 0.75) << unknown;
    }
    set.abscissa = "19|Speed|rpm";
    const Measurement all = read_text_as_uff(set.text());
    EXPECT_EQ(all.signals.at(0).kind, UffKind::other);
    EXPECT_EQ(all.signals.at(0).abscissa[1], 0.75);
    EXPECT_THAT(all.notes, ElementsAre(HasSubstr("neither time nor frequency, but quantity 19 in \"rpm\"")));
    set.abscissa = "17|Time|ticks";
    EXPECT_THAT(read_text_as_uff(set.text()).notes,
                Contains(HasSubstr("\"ticks\" of its abscissa is not understood: s is taken")));
}

/// Data set 164: lengths in mm and forces in dN.
constexpr const char* kMillimetres =
    "    -1\n   164\n         9mm, dN                        2\n  1.00000000000000000D+03  1.00000000000000000D+01  "
    "1.00000000000000000D+00\n  2.73149999999999980D+02\n    -1\n";

// Oracle: a length in mm is a thousandth in m, a force in dN a tenth in N, a moment in dN mm 1e-4 in N m.
TEST(UniversalReader, UnitsOfTheFileAreMadeSi) {
    struct Case {
        const char* numerator;
        int direction;
        std::array<int, 3> exponents;
        double factor;
        const char* unit;
    };
    for (const auto& [numerator, direction, exponents, factor, unit] :
         {Case{"12|a|mm/s^2", 3, {}, 1e-3, "m/s^2"}, Case{"8|u|mm", -1, {}, 1e-3, "m"}, Case{"8|u|rad", 5, {}, 1, "rad"},
          Case{"11|v|NONE", 4, {}, 1, "rad/s"}, Case{"13|F|dN", 1, {}, 0.1, "N"}, Case{"13|M|NONE", 6, {}, 1e-4, "N*m"},
          Case{"13|M|NONE", 0, {1, 1, 0}, 1e-4, "N*m"}, Case{"8|phi|rad", 0, {}, 1, "rad"},
          Case{"8|u|NONE", 0, {}, 1e-3, "m"}, Case{"15|p|dN/mm^2", 0, {}, 1e5, "Pa"},
          Case{"1|k|dN/mm", 0, {-1, 1, 0}, 100, "N/m"}, Case{"1|u|V", 1, {}, 1, "V"}}) {
        SCOPED_TRACE(fmt::format("{} direction {}", numerator, direction));
        Uff58 set;
        set.numerator = numerator;
        set.direction = direction;
        set.exponents = exponents;
        const Measurement all = read_text_as_uff(kMillimetres + set.text());
        ASSERT_EQ(all.signals.size(), 1u);
        EXPECT_DOUBLE_EQ(all.signals[0].values[1], -2 * factor);
        EXPECT_EQ(all.signals[0].unit, unit);
        EXPECT_THAT(all.notes, IsEmpty());
    }
}

TEST(UniversalReader, UnitsOfAResponseAndDisagreement) {
    Uff58 set = exact_record(6, true);
    set.numerator = "12|a|g";
    set.denominator = "13|F|NONE";
    const Measurement all = read_text_as_uff(set.text() + kMillimetres + set.text() + set.text());
    ASSERT_EQ(all.signals.size(), 3u);
    EXPECT_EQ(all.signals[0].unit, "g") << "data set 164 is behind it";
    EXPECT_EQ(all.signals[1].unit, "m/s^2");
    EXPECT_EQ(all.signals[1].reference_unit, "N");
    EXPECT_DOUBLE_EQ(all.signals[1].values[1], set.values[1].real() * 1e-2) << "mm over dN";
    EXPECT_DOUBLE_EQ(all.signals[1].imaginary[0], -1e-2);
    EXPECT_THAT(all.notes, ElementsAre(AllOf(HasSubstr("a.uff:26 and 1 more: its unit text \"g\" does not agree"),
                                             HasSubstr("values are in m/s^2"))));
    Uff58 psd = exact_record(2, true);
    psd.type = 9;
    psd.abscissa = "18|Frequency|Hz";
    const Measurement densities = read_text_as_uff(kMillimetres + psd.text());
    EXPECT_EQ(densities.signals.at(0).values[1], psd.values[1].real());
    EXPECT_THAT(densities.notes, ElementsAre(HasSubstr("functions of type 9 stay in the unit of the file")));
    expect_fault("    -1\n   164\n         1\n  1.0D+00  0.0D+00  1.0D+00\n  0.0D+00\n    -1\n",
                 HasSubstr("a.uff:4: a factor of data set 164 is 0: it must be above 0"));
}

TEST(UniversalReader, BinaryDataWithWrongCountsAndStrayLineEnds) {
    const Uff58 set = exact_record(4, true);
    for (const int wrong : {0, -8, 8, -56, 1000000}) {
        const Measurement all = read_text_as_uff(set.binary(false, 0, wrong, wrong == 8 ? "\r\n" : ""));
        ASSERT_EQ(all.signals.size(), 1u) << wrong;
        expect_values(all.signals[0], set);
        EXPECT_EQ(all.notes.size(), wrong == 0 ? 0u : 1u) << wrong;
    }
    // Behind values that look like the end line, and behind padding that the count includes
    Uff58 trap = exact_record(4, true);
    trap.values[2] = std::bit_cast<double>(std::array<char, 8>{'\n', ' ', ' ', ' ', ' ', '-', '1', '\n'});
    trap.values.push_back(2);
    expect_values(only_signal(trap.binary(false)), trap);
    expect_values(only_signal(set.binary(true, 0, 3, std::string("\0\0\0", 3))), set);
    expect_fault(set.binary(true, 0, 0, std::string("\0\0\0", 3)),
                 HasSubstr("7 points take 56 bytes, and no end line (-1) follows"));
    // A second set behind binary data, where lines do not count any more
    const Measurement two = read_text_as_uff(set.binary(true) + set.text());
    ASSERT_EQ(two.signals.size(), 2u);
    expect_values(two.signals[1], set);
    EXPECT_THAT(two.signals[1].place, HasSubstr("a.uff: byte "));
}

TEST(UniversalReader, FormatsOfFloatingPointThatAreRefused) {
    const std::string text = exact_record(4, true).binary(false);
    const auto with = [&](const char* fields) { return std::string(text).replace(text.find("58b") + 3, 12, fields); };
    expect_fault(with("     1     1"),
                 HasSubstr("a.uff:2: the values are in the floating-point format of VAX: export them as IEEE"));
    expect_fault(with("     2     3"), HasSubstr("floating-point format of IBM"));
    expect_fault(with("     7     2"), HasSubstr("byte order must be 1 or 2"));
    EXPECT_EQ(read_text_as_uff(with(" 1   2      ")).signals.size(), 1u) << "other columns";
}

TEST(UniversalReader, PointsWithoutAFiniteValueAreLeftOut) {
    Uff58 set = exact_record(6, false);
    set.values[2] = {NAN, 0};
    set.values[5] = {1, INFINITY};
    const Measurement all = read_text_as_uff(set.binary(true));
    EXPECT_THAT(all.signals.at(0).values, SizeIs(5));
    EXPECT_EQ(all.signals.at(0).abscissa.at(2), set.places[3]);
    EXPECT_THAT(all.notes, ElementsAre(HasSubstr("left out: 2 points without a finite value")));
    Uff58 falling = exact_record(2, false);
    std::swap(falling.places[2], falling.places[3]);
    EXPECT_THAT(read_text_as_uff(falling.text() + set.binary(true)).notes,
                Contains(HasSubstr("abscissae of the function do not ascend")));
}

// Oracle: the columns of data set 55. Mode 1 lacks node 40 of mode 2; the x of node 9 is 0 in both.
TEST(UniversalReader, NormalModes) {
    const std::string modes =
        "    -1\n    55\nNONE\nNONE\nNONE\nNONE\nNONE\n"
        "         1         2         2         8         2         3\n"
        "         2         4         0         1\n"
        "  9.70130E+01  1.00000E+00  2.50000E-02  0.00000E+00\n"
        "         9\n  0.00000E+00  2.50000E-01-5.00000E-01\n"
        "        21\n  1.00000E+00  0.00000E+00  7.50000E-01\n    -1\n"
        "    -1\n    55\nNONE\nNONE\nNONE\nNONE\nNONE\n"
        "         1         2         3        12         2         6\n"
        "         2         4         0         5\n"
        "  1.50000E+02  0.00000E+00  0.00000E+00  3.00000E-02\n"
        "        40\n -1.00000E+00  2.00000E+00  3.00000E+00  4.00000E+00  5.00000E+00 -6.00000E+00\n"
        "         9\n  0.00000E+00  0.00000E+00  8.00000E+00  0.00000E+00  0.00000E+00  0.00000E+00\n    -1\n";
    const Measurement all = read_text_as_uff(modes);
    ASSERT_EQ(all.modes.size(), 2u);
    EXPECT_EQ(all.modes[0].frequency, 97.013);
    EXPECT_EQ(all.modes[0].damping, 0.025);
    EXPECT_EQ(all.modes[0].number, 1);
    EXPECT_EQ(all.modes[1].damping, 0.015) << "half of the hysteretic one";
    EXPECT_EQ(all.modes[1].number, 5);
    EXPECT_THAT(all.modes[1].place, HasSubstr("a.uff:17"));
    EXPECT_THAT(all.shape_names,
                ElementsAre("9.y", "9.z", "21.x", "21.z", "40.x", "40.y", "40.z", "40.rx", "40.ry", "40.rz"));
    EXPECT_THAT(all.notes, ElementsAre(HasSubstr("5 components are 0 in every mode")));
    ASSERT_EQ(all.modes[0].shape.size(), 10u);
    ASSERT_EQ(all.modes[1].shape.size(), 10u);
    EXPECT_EQ(all.modes[0].shape[1], -0.5);
    EXPECT_EQ(all.modes[0].shape[3], 0.75);
    EXPECT_TRUE(std::isnan(all.modes[0].shape[4].real()));
    EXPECT_EQ(all.modes[1].shape[0], 0.0) << "a 0 that is given";
    EXPECT_TRUE(std::isnan(all.modes[1].shape[2].real()));
    EXPECT_EQ(all.modes[1].shape[9], -6.0);
    // Lengths in mm: rotations stay
    const Measurement si = read_text_as_uff(kMillimetres + modes);
    EXPECT_DOUBLE_EQ(si.modes[1].shape[6].real(), 3e-3);
    EXPECT_EQ(si.modes[1].shape[7], 4.0);
}

// Oracle: s = -zeta w + i w sqrt(1 - zeta^2) with w = 2 pi 3 Hz and zeta = 0.2, in six digits of the format.
TEST(UniversalReader, ComplexModes) {
    const double omega = 2 * std::numbers::pi * 3;
    const auto mode = [&](double sign) {
        return fmt::format(
            "    -1\n    55\nNONE\nNONE\nNONE\nNONE\nNONE\n"
            "         1         3         2         8         5         3\n"
            "         2         6         0         2\n"
            "{:13.5E}{:13.5E}{:13.5E}{:13.5E}{:13.5E}{:13.5E}\n"
            "        11\n-1.00000E+00 2.00000E+00 3.00000E+00-4.00000E+00 0.00000E+00 6.00000E+00\n    -1\n",
            -0.2 * omega, sign * omega * std::sqrt(1 - 0.04), 4111.111, -3111.111, 0.0, 0.0);
    };
    const Measurement all = read_text_as_uff(mode(1));
    ASSERT_EQ(all.modes.size(), 1u);
    EXPECT_NEAR(all.modes[0].frequency, 3, 3 * 1e-5);
    EXPECT_NEAR(all.modes[0].damping, 0.2, 0.2 * 1e-5);
    EXPECT_THAT(all.modes[0].shape, ElementsAre(std::complex(-1.0, 2.0), std::complex(3.0, -4.0), std::complex(0.0, 6.0)));
    const Measurement conjugate = read_text_as_uff(mode(-1));
    EXPECT_NEAR(conjugate.modes[0].damping, 0.2, 0.2 * 1e-5);
    EXPECT_EQ(conjugate.modes[0].shape[1], std::complex(3.0, 4.0));
}

TEST(UniversalReader, ModesThatAreNoneAndModesWithoutDamping) {
    const auto mode = [](const char* form, const char* frequency, const char* node) {
        return fmt::format(
            "    -1\n    55\nNONE\nNONE\nNONE\nNONE\nNONE\n{}\n         2         4         0         1\n{}  "
            "0.00000E+00  0.00000E+00  0.00000E+00\n{}    -1\n",
            form, frequency, node);
    };
    const char *form = "         1         2         2         8         2         3",
               *node = "         4\n  1.00000E+00  2.00000E+00  3.00000E+00\n";
    const Measurement all = read_text_as_uff(mode(form, "  0.00000E+00", node) + mode(form, "  7.00000E+00", node) +
                                             mode("         1         5         2         8         2         3", "", ""));
    ASSERT_EQ(all.modes.size(), 1u);
    EXPECT_EQ(all.modes[0].frequency, 7);
    EXPECT_TRUE(std::isnan(all.modes[0].damping));
    EXPECT_THAT(all.notes, Contains(HasSubstr("left out: a mode of 0 Hz")));
    EXPECT_THAT(all.notes, Contains(HasSubstr("data set 55 is skipped: its analysis type is 5")));
    expect_fault(mode(form, "  7.00000E+00", "         4\n  1.00000E+00  2.00000E+00\n"),
                 HasSubstr("ends within its head or within a node"));
    expect_fault(mode(form, "  7.00000E+00", std::string(node).append(node).c_str()), HasSubstr("node 4 comes twice"));
    expect_fault(mode(form, " -7.00000E+00", node), HasSubstr("natural frequency is below 0"));
}

TEST(UniversalReader, OtherDataSetsAreCountedOrNamed) {
    const std::string nodes15 =
        "    -1\n    15\n         1         0         3         8 -2.40000e+00 -9.50000e-01  0.00000e+00\n"
        "         2         0         0         8 -2.60000e+00  2.05000e+00  0.00000e+00\n"
        "         3         0         0         8 -2.60000e+00  2.15000e+00  0.00000e+00\n    -1\n";
    const std::string nodes2411 =
        "    -1\n  2411\n         7         0         0        11\n   -1.711755676269531E+02    1.036403427124023E+02    "
        "1.384829101562500E+02\n    -1\n";
    const std::string lines =
        "    -1\n    82\n         1         3         8\nNONE\n         1         2         0\n    -1\n";
    const Measurement all = read_text_as_uff("    -1\n   151\na\nb\nc\nd\ne\nf\ng\n    -1\n" + nodes15 + lines + nodes2411 +
                                             lines + "    -1\n  2412\n   -1000\n    -1\n" + Uff58().text() + "stray\n\n");
    EXPECT_EQ(all.signals.size(), 1u);
    EXPECT_THAT(all.notes, ElementsAre("skipped: 1 line between data sets", "not used: 4 nodes",
                                       HasSubstr("1 node with axes of their own"), "skipped: data set 82, 2 times",
                                       "skipped: data set 2412"));
    expect_fault(nodes15 + lines, AllOf(HasSubstr("there is no function (data set 58) and no mode (55)"),
                                        HasSubstr("it has data sets 15 (1), 82 (1)")));
    expect_fault("", HasSubstr("it has no data set"));
}

TEST(UniversalReader, EndLinesThatAreMissing) {
    const Uff58 set = exact_record(4, true);
    std::string open = set.text();
    open.resize(open.size() - 7);  // without the end line
    const Measurement last = read_text_as_uff(set.text() + open);
    ASSERT_EQ(last.signals.size(), 2u);
    expect_values(last.signals[1], set);
    EXPECT_THAT(last.notes, ElementsAre(HasSubstr("the set has no end line (-1)")));
    // One line -1 between two sets
    const Measurement both = read_text_as_uff(open + set.text() + "    -1\n    -1\n" + set.text());
    ASSERT_EQ(both.signals.size(), 3u);
    expect_values(both.signals[2], set);
    EXPECT_THAT(both.notes, ElementsAre(HasSubstr("a.uff:17: one line -1 parts two data sets")));
    EXPECT_THAT(read_text_as_uff(set.text() + kMark).notes, ElementsAre(HasSubstr("it may be cut off")));
    expect_fault(set.text() + "    -1\n    82\n  1\n", HasSubstr("a.uff:18: data set 82 has no end line (-1)"));
    expect_fault("    -1\nxyz\n", HasSubstr("a.uff:2: \"xyz\" is no number of a data set"));
}

// Cut off anywhere, a file is refused, or all of a function is there and a note tells that its end line is missing.
TEST(UniversalReader, AFileThatIsCutOffIsRefused) {
    const Uff58 text = exact_record(5, false), binary = exact_record(4, true);
    for (const auto& [whole, set] : {std::pair(text.text(), text), std::pair(binary.binary(true), binary)}) {
        const TemporaryFolder folder;
        write_text(folder / "a.uff", whole);
        const std::size_t data_end = whole.size() - 7;
        for (std::size_t size = whole.size(); --size > 0;) {
            std::filesystem::resize_file(folder / "a.uff", size);
            try {
                const Measurement all = read_universal(folder / "a.uff");
                EXPECT_GE(size, data_end);
                expect_values(all.signals.at(0), set);
                EXPECT_TRUE(all.notes.size() == 1 || whole.substr(data_end, size - data_end) == "    -1") << size;
            } catch (const Error& error) {
                EXPECT_EQ(error.code(), ExitCode::input_output);
                EXPECT_THAT(error.what(), HasSubstr("a.uff"));
                EXPECT_NE(size, data_end) << "only the end line is missing";
            }
        }
    }
    expect_fault(text.text().substr(0, text.text().size() - 20),
                 HasSubstr("the head promises 7 points, and the set ends after"));
}

TEST(UniversalReader, CountsThatTheFileCannotHoldTakeNoMemory) {
    for (const char* count : {"2508876", "999999999", "9999999999"}) {
        for (const std::string& whole : {exact_record(6, true).text(), exact_record(6, false).binary(true)}) {
            std::string text = whole;
            const std::size_t at = text.find("         6         7");
            ASSERT_NE(at, text.npos);
            text.replace(at + 10, 10, fmt::format("{:>10}", count));
            expect_fault(text, HasSubstr(fmt::format(
                                   "a.uff:2: the head promises {} points, and the rest of the file is too short", count)));
        }
    }
    // Modes that have no node in common would make a matrix of shapes that grows with the square of the file
    std::string modes;
    for (int m = 1; m <= 700; ++m)
        modes += fmt::format(
            "    -1\n    55\na\na\na\na\na\n         1         2         2         8         2         3\n"
            "         2         4         0{:10}\n  1.0 0 0 0\n{:10}\n 1 2 3\n    -1\n",
            m, m);
    expect_fault(modes, HasSubstr("its 700 modes have hardly a node in common"));
}

TEST(UniversalReader, FaultsNameTheLine) {
    const std::string text = exact_record(2, true).text();
    const auto with = [&](const std::string& was, const std::string& is) {
        const std::size_t at = text.find(was);
        EXPECT_NE(at, text.npos) << was;
        return std::string(text).replace(at, was.size(), is);
    };
    expect_fault(with("  3.12500E-01", "  3.125O0E-01"), HasSubstr("a.uff:14: \"3.125O0E-01\" is no number"));
    expect_fault(with("         2         7", "         3         7"),
                 HasSubstr("a.uff:9: ordinate type 3 is none of 2, 4, 5, 6"));
    expect_fault(with("         7         1", "         7         2"),
                 HasSubstr("a.uff:9: abscissa spacing 2 is neither 0 nor 1"));
    expect_fault(with("         7         1", "         6         1"),
                 HasSubstr("a.uff:15: the end line (-1) of the set must follow its 6 points"));
    expect_fault(with("         7         1", "         5         1"),
                 HasSubstr("more numbers than the 5 points of the head"));
    expect_fault(with("        17", "     seven"),
                 HasSubstr("a.uff:10: \"     seven\" stands where data set 58 wants a whole number"));
    expect_fault("    -1\n    58\na\nb\n    -1\n", HasSubstr("a.uff:4: data set 58 ends within its eleven head lines"));
}

// Numbers that others measured, with the shape of their files: ladisk/pyuff, data/non_ascii_header.uff and
// data/time-history-not-all-columns-filled.uff, commit 44a12caa (MIT licence).
TEST(UniversalReader, FilesOfOtherPrograms) {
    const Measurement frf = read_text_as_uff(
        "    -1\n    58\nref6_23_Mar                     \nNONE\n23-Mar-17 19:02:23\nRecord 1 of Dataset no 58\nH1 : #  2 / "
        "#  1\n"
        "    4         0    0         0 NONE               0   0 NONE               0   0\n"
        "         5         6         1 0.00000e+00  1.95313e-01  0.00000e+00 \n"
        "        18    0    0    0 NONE                 Hz                  \n"
        "         1    0    0    0 Frequency Function   (1/N)*(m/s\xb2)        \n"
        "         0    0    0    0 NONE                 NONE                \n"
        "         0    0    0    0 NONE                 NONE                \n"
        " 4.07994e-01  0.00000e+00 -5.99924e-02 -5.53260e-02  2.58750e-02 -2.30085e-04 \n"
        "-2.99003e-01  3.17213e-01 -1.80250e+00  1.55302e+00  3.75037e+00  2.93363e+00 \n    -1\n");
    const MeasuredSignal& response = frf.signals.at(0);
    EXPECT_EQ(response.kind, UffKind::response);
    EXPECT_EQ(response.name, "Frequency Function");
    EXPECT_EQ(response.unit, "(1/N)*(m/s²)");
    EXPECT_THAT(response.values, ElementsAre(0.407994, -0.0599924, 0.025875, -0.299003, -1.8025, 3.75037));
    EXPECT_EQ(response.imaginary.back(), 2.93363);
    EXPECT_DOUBLE_EQ(response.abscissa.back(), 5 * 0.195313);
    const MeasuredSignal history = only_signal(
        "    -1                                                                          \n"
        "    58                                                                          \n"
        "1x : m/s²\nUFF58 file created by HBM catman\n30-Apr-20 19:12:52\nNONE\nNONE\n"
        "    1         0    0         0 NONE               0   0 NONE               0   0\n"
        "         2        13         1 0.00000E+000 5.00000E-005 0.00000E+000           \n"
        "        17    0    0    0 Time                 s                                \n"
        "         1    0    0    0 1x                   m/s²                             \n"
        "         0    0    0    0 NONE                 NONE                             \n"
        "         0    0    0    0 NONE                 NONE                             \n"
        " -3.81956E+00 -3.56616E+00 -2.98987E+00 -2.62207E+00 -3.22879E+00 -3.63712E+00\n"
        " -3.90210E+00 -3.69214E+00 -3.42426E+00 -3.48508E+00 -4.03966E+00 -3.46046E+00\n"
        " -5.84096E+00                                                                 \n"
        "    -1                                                                          \n");
    EXPECT_EQ(history.name, "1x");
    EXPECT_THAT(history.values, SizeIs(13));
    EXPECT_EQ(history.values.back(), -5.84096);
}

}  // namespace
}  // namespace dttmm::host
