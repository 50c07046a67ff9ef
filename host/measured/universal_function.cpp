// SPDX-License-Identifier: BSD-3-Clause
#include "measured/universal_function.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <vector>

#include "model/error.h"
#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

using Kind = MeasuredSignal::Kind;

constexpr const char* kCutOff = "the file is cut off or damaged: export it again";

/// A place and a direction of record 6. Direction 0: none; 1..3 along and 4..6 about x, y, z; negative: against them.
struct FreedomField {
    std::string entity;
    long long node = 0, direction = 0;
};

/// Records 8 to 10. Exponents of length, force and temperature in the unit.
struct AxisField {
    long long quantity = 0;
    std::array<long long, 3> exponents = {};
    std::string label, unit;
};

struct FunctionHead {
    std::string place, title;
    long long type = 0;  ///< of the function
    FreedomField response, reference;
    bool is_double = false, is_complex = false, is_even = false;
    std::uint64_t points = 0;
    double first = 0, step = 0;  ///< of even abscissae
    AxisField abscissa, numerator, denominator;

    std::uint64_t numbers_per_point() const { return (is_even ? 0u : 1u) + (is_complex ? 2u : 1u); }
};

/// What the number line of a binary set says beside the number.
struct BinaryLayout {
    bool is_big_endian = false;
    long long bytes = 0;
};

/// Quantities of the format by their codes: SI units, exponents of length and force, along axes and about them.
struct QuantityLine {
    long long code;
    const char *along, *about;
    std::array<long long, 2> along_exponents, about_exponents;
};
constexpr QuantityLine kQuantities[] = {
    {2, "Pa", "Pa", {-2, 1}, {-2, 1}},  {3, "1", "1", {0, 0}, {0, 0}},        {8, "m", "rad", {1, 0}, {0, 0}},
    {9, "N", "N*m", {0, 1}, {1, 1}},    {11, "m/s", "rad/s", {1, 0}, {0, 0}}, {12, "m/s^2", "rad/s^2", {1, 0}, {0, 0}},
    {13, "N", "N*m", {0, 1}, {1, 1}},   {15, "Pa", "Pa", {-2, 1}, {-2, 1}},   {16, "kg", "kg*m^2", {-1, 1}, {1, 1}},
    {21, "Pa", "Pa", {-2, 1}, {-2, 1}},
};

/// A unit text as a quantity; none: the text is empty or not understood.
std::optional<Quantity> quantity_of(const std::string& unit) {
    if (unit.empty()) return std::nullopt;
    try {
        return parse_quantity("1 " + unit);
    } catch (const Error&) {
        return std::nullopt;
    }
}

/// Reads records 1 to 11.
class HeadReader {
public:
    explicit HeadReader(UniversalText& text) : text_(text) { head_.place = text.place(); }
    FunctionHead read();

private:
    std::string_view record();
    long long whole(std::string_view field) const;
    FreedomField freedom(const FixedFields& fields, std::size_t first) const;
    void read_form();
    AxisField axis();

    UniversalText& text_;
    FunctionHead head_;
};

std::string_view HeadReader::record() {
    if (text_.is_at_end() || is_universal_mark(text_.peek()))
        text_.fail(fmt::format("data set 58 ends within its eleven head lines: {}", kCutOff));
    return text_.next();
}

long long HeadReader::whole(std::string_view field) const {
    const auto value = parse_fortran_whole(field);
    if (!value)
        text_.fail(fmt::format(
            "{} stands where data set 58 wants a whole number: columns are shifted, or the file is damaged", quote(field)));
    return *value;
}

FreedomField HeadReader::freedom(const FixedFields& fields, std::size_t first) const {
    const FreedomField found = {universal_text_of(fields.field(first, 10)), whole(fields.field(first + 10, 10)),
                                whole(fields.field(first + 20, 4))};
    if (std::abs(found.direction) > 6)
        text_.fail(fmt::format("direction {} is none of -6 to 6: the file is damaged", found.direction));
    return found;
}

/// Record 7: the form of the values. Where columns are shifted blanks part its fields.
void HeadReader::read_form() {
    constexpr std::size_t kWidths[] = {10, 10, 10, 13, 13};
    const std::string_view line = record();
    std::array<std::string_view, 5> fields;
    for (std::size_t i = 0, at = 0; i < fields.size(); at += kWidths[i++])
        fields[i] = line.substr(std::min(at, line.size()), kWidths[i]);
    if (!parse_fortran_whole(fields[0]) || !parse_fortran_whole(fields[1]) || !parse_fortran_whole(fields[2]) ||
        !parse_fortran_real(fields[3]) || !parse_fortran_real(fields[4]))
        for (std::size_t i = 0, at = 0; i < fields.size(); ++i) {
            const std::size_t begin = std::min(line.find_first_not_of(" \t", at), line.size());
            at = std::min(line.find_first_of(" \t", begin), line.size());
            fields[i] = line.substr(begin, at - begin);
        }
    const long long type = whole(fields[0]), points = whole(fields[1]), spacing = whole(fields[2]);
    if (type != 2 && type != 4 && type != 5 && type != 6)
        text_.fail(fmt::format("ordinate type {} is none of 2, 4, 5, 6: the file is damaged", type));
    if (points < 0) text_.fail(fmt::format("{} points are promised: the file is damaged", points));
    if (spacing != 0 && spacing != 1)
        text_.fail(fmt::format("abscissa spacing {} is neither 0 nor 1: the file is damaged", spacing));
    head_.is_double = type == 4 || type == 6;
    head_.is_complex = type == 5 || type == 6;
    head_.is_even = spacing == 1;
    head_.points = static_cast<std::uint64_t>(points);
    if (!head_.is_even) return;
    const auto first = parse_fortran_real(fields[3]), step = parse_fortran_real(fields[4]);
    if (!first || !step || !std::isfinite(*first) || !std::isfinite(*step))
        text_.fail("first abscissa and step must be finite numbers: the file is damaged");
    head_.first = *first;
    head_.step = *step;
}

AxisField HeadReader::axis() {
    constexpr std::size_t kBlank[] = {25, 46};
    const FixedFields fields(record(), kBlank, 67);
    return {whole(fields.field(0, 10)),
            {whole(fields.field(10, 5)), whole(fields.field(15, 5)), whole(fields.field(20, 5))},
            universal_text_of(fields.field(26, 20)),
            universal_text_of(fields.field(47, 20))};
}

FunctionHead HeadReader::read() {
    head_.title = universal_text_of(record());
    for (int i = 2; i <= 5; ++i) record();
    constexpr std::size_t kBlank[] = {30, 55};
    const FixedFields fields(record(), kBlank, 80);
    head_.type = whole(fields.field(0, 5));
    head_.response = freedom(fields, 31);
    head_.reference = freedom(fields, 56);
    read_form();
    head_.abscissa = axis();
    head_.numerator = axis();
    head_.denominator = axis();
    axis();  // of z
    return head_;
}

/// "    58b     1     2          11        2000 ...": byte order, floating-point format, head lines, bytes.
BinaryLayout binary_layout(const UniversalText& text, std::string_view number_line) {
    const std::string_view line = number_line.substr(number_line.find_first_of("bB") + 1);
    constexpr std::size_t kWidths[] = {6, 6, 12, 12};
    std::vector<double> numbers;
    if (append_fortran_reals(line, kWidths, numbers) || numbers.size() < 4)
        text.fail("the number line of data set 58b must hold byte order, floating-point format, lines and bytes: " +
                  std::string(kCutOff));
    if (numbers[1] == 1 || numbers[1] == 3)
        text.fail(fmt::format("the values are in the floating-point format of {}: export them as IEEE, or as ASCII",
                              numbers[1] == 1 ? "VAX" : "IBM"));
    if (numbers[1] != 2 || (numbers[0] != 1 && numbers[0] != 2))
        text.fail("byte order must be 1 or 2, and the floating-point format 2 (IEEE): the file is damaged");
    constexpr double kMost = 1e12;  // the field has twelve columns
    return {numbers[0] == 2,
            std::isfinite(numbers[3]) && std::abs(numbers[3]) < kMost ? static_cast<long long>(numbers[3]) : 0};
}

[[noreturn]] void fail_for_size(const FunctionHead& head) {
    throw Error(ExitCode::input_output, fmt::format("{}: the head promises {}, and the rest of the file is too short: {}",
                                                    head.place, counted(head.points, "point", "points"), kCutOff));
}

/// Numbers of the points in turn: the abscissa if it is uneven, the value, its imaginary part.
std::vector<double> read_text_numbers(UniversalText& text, const FunctionHead& head) {
    const std::uint64_t wanted = head.points * head.numbers_per_point();
    // A number and the blank or the sign before the next take two bytes at least
    if (wanted > (text.rest().size() + 1) / 2) fail_for_size(head);
    constexpr std::size_t kSingle[] = {13}, kDouble[] = {20}, kUneven[] = {13, 20}, kUnevenComplex[] = {13, 20, 20};
    std::span<const std::size_t> widths = kSingle;
    if (head.is_double) widths = kDouble;
    if (head.is_double && !head.is_even) widths = kUneven;
    if (head.is_double && !head.is_even && head.is_complex) widths = kUnevenComplex;
    std::vector<double> numbers;
    numbers.reserve(wanted);
    while (numbers.size() < wanted) {
        text.skip_blank();
        if (text.is_at_end() || is_universal_mark(text.peek()))
            text.fail(fmt::format("the head promises {}, and the set ends after {} of {}: {}",
                                  counted(head.points, "point", "points"), numbers.size(),
                                  counted(wanted, "number", "numbers"), kCutOff));
        if (const auto bad = append_fortran_reals(text.next(), widths, numbers))
            text.fail(fmt::format("{} is no number: mend it, or export the file again", quote(*bad)));
    }
    if (numbers.size() > wanted)
        text.fail(fmt::format("there are more numbers than the {} of the head: the file is damaged",
                              counted(head.points, "point", "points")));
    if (text.is_at_end() && !text.ends_with_line()) text.fail(fmt::format("the last line has no end: {}", kCutOff));
    return numbers;
}

double ieee_number(const char* bytes, std::size_t size, bool is_big_endian) {
    std::uint64_t bits = 0;
    for (std::size_t i = 0; i < size; ++i)
        bits = bits << 8 | static_cast<unsigned char>(bytes[is_big_endian ? i : size - 1 - i]);
    return size == 4 ? static_cast<double>(std::bit_cast<float>(static_cast<std::uint32_t>(bits)))
                     : std::bit_cast<double>(bits);
}

/// Whether data of so many bytes are followed by the end line, perhaps behind stray line ends, or by nothing.
bool ends_behind(std::string_view rest, std::uint64_t size) {
    if (size > rest.size()) return false;
    rest.remove_prefix(size);
    const std::size_t at = rest.find_first_not_of("\r\n");
    return at == rest.npos || is_universal_mark(rest.substr(at, rest.find('\n', at) - at));
}

/// As read_text_numbers(). The number of points and the end line say where the data end: some writers count bytes wrong. The
/// abscissae of uneven double precision have eight bytes or four: the end line decides, then the number of bytes.
std::vector<double> read_binary_numbers(UniversalText& text, const FunctionHead& head, const BinaryLayout& layout,
                                        Remarks& remarks) {
    const std::string_view rest = text.rest();
    const std::uint64_t each = head.is_double ? 8 : 4, wanted = head.points * head.numbers_per_point();
    const auto declared = static_cast<std::uint64_t>(std::max(layout.bytes, 0LL));
    std::uint64_t abscissa_size = each;
    const auto size = [&] { return wanted * each - (head.is_even ? 0 : head.points * (each - abscissa_size)); };
    if (head.is_double && !head.is_even && !ends_behind(rest, size())) {
        const bool is_declared = declared == size();
        abscissa_size = 4;
        if (!ends_behind(rest, size()) && is_declared) abscissa_size = 8;
    }
    const std::uint64_t own = size();
    if (own > rest.size()) fail_for_size(head);
    const bool is_padded = !ends_behind(rest, own) && declared > own && ends_behind(rest, declared);
    if (!is_padded && !ends_behind(rest, own))
        throw Error(
            ExitCode::input_output,
            fmt::format("{}: {} take {} bytes, and no end line (-1) follows them: the file is damaged: export it again",
                        head.place, counted(head.points, "point", "points"), own));
    if (declared != own) remarks.add(head.place, "the number of bytes in the head is wrong: the number of points is used");
    const char* data = text.take(is_padded ? declared : own).data();
    std::vector<double> numbers;
    numbers.reserve(wanted);
    for (std::uint64_t i = 0; i < wanted; ++i) {
        const std::uint64_t bytes = !head.is_even && i % head.numbers_per_point() == 0 ? abscissa_size : each;
        numbers.push_back(ieee_number(data, bytes, layout.is_big_endian));
        data += bytes;
    }
    return numbers;
}

void take_end_line(UniversalText& text, const FunctionHead& head, Remarks& remarks) {
    text.skip_blank();
    if (text.is_at_end()) {
        remarks.add(head.place, "the set has no end line (-1): the file may be cut off behind it");
        return;
    }
    if (!is_universal_mark(text.peek())) {
        text.next();
        text.fail(fmt::format("the end line (-1) of the set must follow its {}: the file is damaged",
                              counted(head.points, "point", "points")));
    }
    text.next();
}

/// What the abscissae are, and what they are multiplied by to be in s or Hz.
struct AbscissaUnit {
    enum class Of : unsigned char { time, frequency, other };
    Of of = Of::other;
    double factor = 1;
};

AbscissaUnit abscissa_unit(const FunctionHead& head, Remarks& remarks) {
    using Of = AbscissaUnit::Of;
    const long long code = head.abscissa.quantity;
    const std::string& unit = head.abscissa.unit;
    const std::optional<Quantity> quantity = quantity_of(unit);
    const auto is_in = [&](const char* si) { return quantity && measures(unit, si); };
    const bool is_hertz = unit == "hz" || unit == "HZ", is_angular = is_in("rad/s");
    AbscissaUnit found;
    if (code == 17 || code == 18)
        found.of = code == 17 ? Of::time : Of::frequency;
    else if (code <= 1 && unit.empty())
        found.of = head.type == 1 ? Of::time : Of::frequency;
    else if (code <= 1 && is_in("s"))
        found.of = Of::time;
    else if (code <= 1 && (is_in("Hz") || is_hertz || is_angular))
        found.of = Of::frequency;
    if (found.of == Of::other) {
        const std::string& said = unit.empty() ? head.abscissa.label : unit;
        remarks.add(head.place,
                    fmt::format("its abscissa is neither time nor frequency, but quantity {} in {}", code, quote(said)));
    } else if (is_in(found.of == Of::time ? "s" : "Hz")) {
        found.factor = quantity->value;
    } else if (found.of == Of::frequency && is_angular) {
        found.factor = quantity->value / (2 * std::numbers::pi);
        remarks.add(head.place, fmt::format("its abscissa is made Hz of {}", quote(unit)));
    } else if (!unit.empty() && !(found.of == Of::frequency && is_hertz)) {
        remarks.add(head.place, fmt::format("the unit {} of its abscissa is not understood: {} is taken", quote(unit),
                                            found.of == Of::time ? "s" : "Hz"));
    }
    return found;
}

struct ConvertedUnit {
    std::string unit;
    double factor = 1;  ///< values are divided by it
};

/// The unit of values of an axis, and what makes SI of them.
ConvertedUnit convert(const AxisField& axis, long long direction, const std::optional<UniversalFactors>& factors,
                      const std::string& place, Remarks& remarks) {
    if (!factors) return {axis.unit, 1};
    const std::array<long long, 2> own = {axis.exponents[0], axis.exponents[1]};
    const auto line = std::ranges::find(kQuantities, axis.quantity, &QuantityLine::code);
    const bool is_known = line != std::end(kQuantities), has_own = own != std::array<long long, 2>{0, 0};
    if (axis.exponents[2] != 0 || (!is_known && !has_own)) return {axis.unit, 1};
    const std::optional<Quantity> said = quantity_of(axis.unit);
    bool is_about = std::abs(direction) > 3;
    // Without a direction a moment shows by its exponents, an angle by its unit text
    if (is_known && direction == 0 && own == line->about_exponents && own != line->along_exponents)
        is_about = has_own || (said && measures(axis.unit, line->about));
    const std::array<long long, 2> exponents = !is_known ? own : is_about ? line->about_exponents : line->along_exponents;
    ConvertedUnit found;
    found.factor = std::pow(factors->length, static_cast<double>(exponents[0])) *
                   std::pow(factors->force, static_cast<double>(exponents[1]));
    if (is_known)
        found.unit = is_about ? line->about : line->along;
    else if (said)
        found.unit = said->unit;
    if (!(found.factor > 0) || !std::isfinite(found.factor))
        throw Error(ExitCode::input_output,
                    fmt::format("{}: the exponents {} and {} of a unit are too large: the file is damaged", place,
                                exponents[0], exponents[1]));
    constexpr double kShare = 1e-3;  // units of one size that files give with four digits agree to it
    const bool agrees =
        said && (!is_known || measures(axis.unit, found.unit)) && std::abs(said->value * found.factor - 1) < kShare;
    if (!is_known && !said)
        remarks.add(place, fmt::format("data set 164 makes SI of its values, but their unit {} is not understood",
                                       quote(axis.unit)));
    else if (!axis.unit.empty() && !agrees)
        remarks.add(place, fmt::format("its unit text {} does not agree with data set 164, which is used: values are in {}",
                                       quote(axis.unit), found.unit));
    return found;
}

void set_units(const FunctionHead& head, const std::optional<UniversalFactors>& factors, MeasuredSignal& signal,
               Remarks& remarks) {
    const bool is_quotient = head.type == 4 || head.type == 5;
    signal.unit = head.numerator.unit;
    if (is_quotient) signal.reference_unit = head.denominator.unit;
    if (!factors || signal.kind == Kind::coherence) return;
    if (head.type != 0 && head.type != 1 && head.type != 12 && !is_quotient) {  // squares and densities
        if (factors->length != 1 || factors->force != 1)
            remarks.add(head.place, fmt::format("functions of type {} stay in the unit of the file", head.type));
        return;
    }
    const ConvertedUnit above = convert(head.numerator, head.response.direction, factors, head.place, remarks);
    ConvertedUnit below;
    if (is_quotient) below = convert(head.denominator, head.reference.direction, factors, head.place, remarks);
    signal.unit = above.unit;
    signal.reference_unit = below.unit;
    for (std::vector<double>* values : {&signal.values, &signal.imaginary})
        for (double& value : *values) value = value / above.factor * below.factor;
}

std::string freedom_name(const FreedomField& freedom, const std::string& otherwise) {
    constexpr const char* kDirections[] = {"x", "y", "z", "rx", "ry", "rz"};
    const std::string place = freedom.node != 0 ? std::to_string(freedom.node) : otherwise;
    if (place.empty() || freedom.direction == 0) return place;
    return place + "." + kDirections[std::abs(freedom.direction) - 1];
}

void set_names(const FunctionHead& head, MeasuredSignal& signal) {
    const std::size_t bracket = head.title.find(" [");
    const bool has_unit = bracket != head.title.npos && bracket == head.title.find(' ') && head.title.ends_with(']');
    if (head.response.node == 0 && has_unit) {
        signal.name = head.title.substr(0, bracket);
    } else {
        std::string otherwise = "function";
        for (const std::string* text : {&head.title, &head.numerator.label, &head.response.entity})
            if (!text->empty()) otherwise = *text;
        signal.name = freedom_name(head.response, otherwise);
        signal.title = head.title.substr(0, has_unit ? bracket : head.title.npos);
    }
    if (head.type != 1) {
        signal.reference = freedom_name(head.reference, head.reference.entity);
        signal.reference_title = head.denominator.label;
    }
    const bool is_against = head.response.direction < 0, is_reference_against = head.reference.direction < 0;
    signal.is_reversed = signal.kind == Kind::response ? is_against != is_reference_against : is_against;
    if (signal.kind == Kind::coherence) signal.is_reversed = false;  // it has no sign
}

void set_points(const FunctionHead& head, const std::vector<double>& numbers, double factor, MeasuredSignal& signal,
                Remarks& remarks) {
    std::size_t left_out = 0;
    for (std::size_t i = 0; i < head.points; ++i) {
        const double* at = numbers.data() + i * head.numbers_per_point();
        const double x = factor * (head.is_even ? head.first + static_cast<double>(i) * head.step : *at++);
        const double real = at[0], imaginary = head.is_complex ? at[1] : 0;
        if (!std::isfinite(x) || !std::isfinite(real) || !std::isfinite(imaginary)) {
            ++left_out;
            continue;
        }
        signal.abscissa.push_back(x);
        signal.values.push_back(real);
        if (head.is_complex) signal.imaginary.push_back(imaginary);
    }
    if (left_out > 0)
        remarks.add(head.place, fmt::format("left out: {} without a finite value", counted(left_out, "point", "points")));
}

void set_kind(const FunctionHead& head, AbscissaUnit::Of over, MeasuredSignal& signal, Remarks& remarks) {
    using Of = AbscissaUnit::Of;
    const bool is_real = std::ranges::all_of(signal.imaginary, [](double value) { return value == 0; });
    signal.kind = Kind::other;
    if (head.type == 1 && over == Of::time && is_real) signal.kind = Kind::history;
    if (head.type == 4 && over == Of::frequency) signal.kind = Kind::response;
    if (head.type == 6 && over == Of::frequency && is_real) signal.kind = Kind::coherence;
    if (signal.kind != Kind::response && is_real) signal.imaginary.clear();
    if (head.type == 1 && !is_real) remarks.add(head.place, "this history is complex: it is not taken for a history");
    if (signal.kind == Kind::response && signal.imaginary.empty())
        remarks.add(head.place, "this response is real: it has no phase");
}

}  // namespace

std::optional<MeasuredSignal> read_universal_function(UniversalText& text, std::string_view number_line,
                                                      const std::optional<UniversalFactors>& factors, Remarks& remarks) {
    std::optional<BinaryLayout> layout;
    if (number_line.find_first_of("bB") != number_line.npos) layout = binary_layout(text, number_line);
    const FunctionHead head = HeadReader(text).read();
    const std::vector<double> numbers =
        layout ? read_binary_numbers(text, head, *layout, remarks) : read_text_numbers(text, head);
    take_end_line(text, head, remarks);
    MeasuredSignal signal;
    signal.place = head.place;
    const AbscissaUnit abscissa = abscissa_unit(head, remarks);
    set_points(head, numbers, abscissa.factor, signal, remarks);
    if (signal.values.empty()) {
        remarks.add(head.place, "left out: the function has no points");
        return std::nullopt;
    }
    if (std::ranges::adjacent_find(signal.abscissa, std::greater_equal<>()) != signal.abscissa.end()) {
        remarks.add(head.place, "left out: the abscissae of the function do not ascend");
        return std::nullopt;
    }
    set_kind(head, abscissa.of, signal, remarks);
    set_units(head, factors, signal, remarks);
    set_names(head, signal);
    return signal;
}

}  // namespace dttmm::host
