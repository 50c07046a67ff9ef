// SPDX-License-Identifier: BSD-3-Clause
#include "report/universal_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/index.h"

namespace dttmm::host {

namespace {

/// FORTRAN's E20.12 and D25.16, with E for the letter: every reader knows it.
std::string real_field(double value, int width, int digits) {
    constexpr double kLeast = 1e-99;  // with two digits of the exponent; three would fill the field
    return fmt::format("{:{}.{}E}", std::abs(value) < kLeast ? 0.0 : value, width, digits);
}

/// As many digits as 13 columns hold behind a blank: seven with an exponent, eleven of most numbers without. Who reads by
/// FORTRAN's E13.5 takes both: a decimal point in the field counts before that of the format.
std::string single(double value) {
    constexpr int kField = 13;
    constexpr double kLeast = 1e-3, kMost = 1e9;  // of a magnitude that has more digits without an exponent
    if (!(std::abs(value) >= kLeast && std::abs(value) < kMost)) return real_field(value, kField, value < 0 ? 5 : 6);
    const int whole = std::max(1, static_cast<int>(std::floor(std::log10(std::abs(value)))) + 1);
    const int taken = 1 + (value < 0 ? 1 : 0) + whole + 1;  // the blank, a sign, the digits before the point, the point
    std::string field = fmt::format("{:{}.{}f}", value, kField, kField - taken);
    if (field.front() != ' ') field = fmt::format("{:{}.{}f}", value, kField, kField - taken - 1);  // 9.999… became 10
    return field;
}
std::string twice(double value) { return real_field(value, 20, 12); }

double as_written(double place) { return std::stod(single(place)); }

/// A text field of so many bytes.
std::string text_field(std::string_view text, std::size_t width, bool is_padded = true) {
    std::string field;
    for (const char c : text)
        if (!field.empty() || c != ' ') field += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? ' ' : c;
    if (field.empty()) field = "NONE";
    if (field.size() > width) {
        std::size_t end = width;
        while (end > 0 && (static_cast<unsigned char>(field[end]) & 0xc0) == 0x80) --end;  // within a character
        field.resize(end);
    }
    if (is_padded) field.resize(width, ' ');
    return field;
}

std::string axis_record(const UniversalAxis& axis) {
    return fmt::format("{:10}{:5}{:5}{:5} {} {}", static_cast<int>(axis.quantity), axis.exponents[0], axis.exponents[1],
                       axis.exponents[2], text_field(axis.label, 20), text_field(axis.unit, 20));
}

std::string degree_fields(const UniversalDegree& degree) {
    return fmt::format(" {}{:10}{:4}", text_field(degree.name, 10), degree.node, degree.direction);
}

}  // namespace

bool are_even(std::span<const double> places) {
    if (places.size() < 2) return true;
    const double distance = (places.back() - places.front()) / static_cast<double>(places.size() - 1);
    constexpr double kShare = 1e-6;  // of the distance: what first and distance cannot say of a place between them
    for (std::size_t i = 0; i < places.size(); ++i)
        if (!(std::abs(places[i] - places.front() - static_cast<double>(i) * distance) <= kShare * distance)) return false;
    return distance > 0;
}

std::size_t count_merged(std::span<const double> places) {
    std::size_t merged = 0;
    for (std::size_t i = 1; i < places.size(); ++i)
        if (places[i] != places[i - 1] && as_written(places[i]) == as_written(places[i - 1])) ++merged;
    return merged;
}

void UniversalFile::begin(int dataset) { write_line(fmt::format("{:6}\n{:6}", -1, dataset)); }

void UniversalFile::end() { write_line(fmt::format("{:6}", -1)); }

void UniversalFile::write_header(std::string_view title, std::string_view description, std::string_view program,
                                 std::string_view date, std::string_view time) {
    begin(151);
    write_line(text_field(title, 80, false));
    write_line(text_field(description, 80, false));
    write_line(text_field(program, 80, false));
    const std::string when = text_field(date, 10) + text_field(time, 10);
    write_line(fmt::format("{}{:10}{:10}{:10}", when, 0, 0, 0));
    write_line(when);
    write_line(text_field(program, 80, false));
    write_line(when);
    end();
}

void UniversalFile::write_units() {
    begin(164);
    write_line(fmt::format("{:10}{}{:10}", 1, text_field("SI: metre (newton)", 20), 1));
    write_line(real_field(1, 25, 17) + real_field(1, 25, 17) + real_field(1, 25, 17));
    write_line(real_field(0, 25, 17));
    end();
}

void UniversalFile::write_nodes_15(std::span<const UniversalNode> nodes) {
    begin(15);
    for (const auto& [label, at] : nodes)
        write_line(
            fmt::format("{:10}{:10}{:10}{:10}{}{}{}", label, 0, 0, 1, single(at.x()), single(at.y()), single(at.z())));
    end();
}

void UniversalFile::write_nodes_2411(std::span<const UniversalNode> nodes) {
    begin(2411);
    for (const auto& [label, at] : nodes) {
        write_line(fmt::format("{:10}{:10}{:10}{:10}", label, 0, 0, 1));
        write_line(real_field(at.x(), 25, 16) + real_field(at.y(), 25, 16) + real_field(at.z(), 25, 16));
    }
    end();
}

void UniversalFile::write(const UniversalCurve& curve) {
    const bool is_complex = !curve.complex.empty(), is_even = are_even(curve.places);
    const std::size_t count = curve.places.size();
    begin(58);
    for (const std::string& line : curve.lines) write_line(text_field(line, 80, false));
    write_line(fmt::format("{:5}{:10}{:5}{:10}{}{}", static_cast<int>(curve.function), curve.number, 0, 0,
                           degree_fields(curve.response), degree_fields(curve.reference)));
    const double first = is_even && count > 0 ? curve.places.front() : 0;
    const double distance = is_even && count > 1 ? (curve.places.back() - first) / static_cast<double>(count - 1) : 0;
    write_line(fmt::format("{:10}{:10}{:10}{}{}{}", is_complex ? 6 : 4, count, is_even ? 1 : 0, single(first),
                           single(distance), single(0)));
    for (const UniversalAxis& axis : {curve.abscissa, curve.numerator, curve.denominator, UniversalAxis()})
        write_line(axis_record(axis));
    // Double precision: even 4E20.12; uneven 2(E13.5, E20.12), of complex values E13.5, 2E20.12
    const std::size_t per_line = is_complex ? (is_even ? 2 : 1) : (is_even ? 4 : 2);
    std::string line;
    for (std::size_t i = 0; i < count; ++i) {
        if (!is_even) line += single(curve.places[i]);
        line += is_complex ? twice(curve.complex[i].real()) + twice(curve.complex[i].imag()) : twice(curve.real[i]);
        if ((i + 1) % per_line != 0 && i + 1 < count) continue;
        write_line(line);
        line.clear();
    }
    end();
}

void UniversalFile::write(const UniversalMode& mode) {
    const bool is_complex = !mode.complex.empty();
    begin(55);
    for (const std::string& line : mode.lines) write_line(text_field(line, 80, false));
    // Structural; normal mode or complex eigenvalue of first order; six degrees of freedom; displacements; real or complex
    write_line(fmt::format("{:10}{:10}{:10}{:10}{:10}{:10}", 1, is_complex ? 3 : 2, 3, 8, is_complex ? 5 : 2, 6));
    write_line(fmt::format("{:10}{:10}{:10}{:10}", 2, is_complex ? 6 : 4, 0, mode.number));
    if (is_complex)
        write_line(single(mode.eigenvalue.real()) + single(mode.eigenvalue.imag()) + single(0) + single(0) + single(0) +
                   single(0));
    else
        write_line(single(mode.frequency) + single(mode.modal_mass) + single(mode.viscous_damping) + single(0));
    for (std::size_t n = 0; n < mode.labels.size(); ++n) {
        write_line(fmt::format("{:10}", mode.labels[n]));
        std::string line;
        for (std::size_t d = 0; d < 6; ++d) {
            line +=
                is_complex ? single(mode.complex[n][d].real()) + single(mode.complex[n][d].imag()) : single(mode.real[n][d]);
            if (d == 5 || (is_complex && d == 2)) {
                write_line(line);
                line.clear();
            }
        }
    }
    end();
}

}  // namespace dttmm::host
