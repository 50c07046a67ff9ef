// SPDX-License-Identifier: BSD-3-Clause
#include "model/units.h"
#include "model/digits.h"

#include <fmt/format.h>
#include <udunits2.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <memory>
#include <mutex>
#include <optional>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

[[noreturn]] void fail(const std::string& text) { throw Error(ExitCode::model_invalid, text); }

/// A unit as scale times a product of powers of SI base units.
struct Unit {
    double scale = 1;                   ///< of one such unit [SI]
    std::map<std::string, int> powers;  ///< exponent of every base unit that occurs

    bool operator==(const Unit&) const = default;
};

/// Exponents without the radian, which is no dimension of its own.
std::map<std::string, int> dimension(const Unit& unit) {
    auto powers = unit.powers;
    powers.erase("rad");
    return powers;
}

int radians(const Unit& unit) {
    const auto found = unit.powers.find("rad");
    return found == unit.powers.end() ? 0 : found->second;
}

/// UDUNITS multiplies scales in binary: an inch becomes 0.025400000000000002 m. Where a decimal of at most 12 digits lies
/// within four units in the last place, that decimal is meant.
double snap_to_decimal(double scale) {
    double decimal = 0;
    const std::string text = fmt::format("{:.12g}", scale);
    std::from_chars(text.data(), text.data() + text.size(), decimal);
    return std::abs(decimal - scale) <= 4 * 2.3e-16 * std::abs(scale) ? decimal : scale;
}

/// value * scale, correctly rounded for the decimal fractions: 35 mm are 35 / 1000 m, not 35 * 0.001 m.
double apply_scale(double value, double scale) {
    const double inverse = snap_to_decimal(1 / scale);
    const bool is_fraction = scale < 1 && inverse == std::round(inverse) && std::abs(inverse * scale - 1) < 1e-15;
    return is_fraction ? value / inverse : value * scale;
}

/// Usual units of one dimension with the value of each [SI], the SI unit first. UDUNITS finds the same, but takes 3 ms to
/// read its database, as long as `dttmm check` of a small model takes to read that.
struct UsualUnits {
    std::map<std::string, int> powers;
    std::vector<std::pair<std::string, double>> units;
};

const std::vector<UsualUnits>& usual_table() {
    static const std::vector<UsualUnits> table = {
        {{}, {{"1", 1}, {"%", 1e-2}}},
        {{{"m", 1}}, {{"m", 1}, {"mm", 1e-3}, {"cm", 1e-2}, {"um", 1e-6}, {"km", 1e3}, {"in", 0.0254}}},
        {{{"kg", 1}}, {{"kg", 1}, {"g", 1e-3}, {"t", 1e3}}},
        {{{"s", 1}}, {{"s", 1}, {"ms", 1e-3}, {"us", 1e-6}, {"min", 60}}},
        {{{"rad", 1}}, {{"rad", 1}, {"deg", M_PI / 180}, {"mrad", 1e-3}}},
        {{{"kg", 1}, {"m", 1}, {"s", -2}},
         {{"N", 1}, {"kN", 1e3}, {"MN", 1e6}, {"mN", 1e-3}, {"kgf", 9.80665}, {"lbf", 4.4482216152605}}},
        {{{"kg", 1}, {"m", 2}, {"s", -2}}, {{"N*m", 1}, {"kN*m", 1e3}, {"N*mm", 1e-3}}},
        {{{"kg", 1}, {"s", -2}}, {{"N/m", 1}, {"N/mm", 1e3}, {"kN/m", 1e3}, {"kN/mm", 1e6}, {"MN/m", 1e6}}},
        {{{"kg", 1}, {"s", -1}}, {{"N*s/m", 1}, {"N*s/mm", 1e3}, {"kN*s/m", 1e3}, {"kN*s/mm", 1e6}}},
        {{{"kg", 1}, {"m", 2}, {"s", -2}, {"rad", -1}},
         {{"N*m/rad", 1}, {"kN*m/rad", 1e3}, {"N*mm/rad", 1e-3}, {"N*m/deg", 180 / M_PI}}},
        {{{"kg", 1}, {"m", 2}, {"s", -1}, {"rad", -1}}, {{"N*m*s/rad", 1}, {"kN*m*s/rad", 1e3}, {"N*mm*s/rad", 1e-3}}},
        {{{"kg", 1}, {"m", -3}}, {{"kg/m^3", 1}, {"g/cm^3", 1e3}, {"t/m^3", 1e3}}},
        {{{"kg", 1}, {"m", 2}}, {{"kg*m^2", 1}, {"kg*mm^2", 1e-6}, {"g*mm^2", 1e-9}}},
        {{{"kg", 1}, {"m", -1}}, {{"kg/m", 1}, {"g/mm", 1}}},
        {{{"m", 2}}, {{"m^2", 1}, {"mm^2", 1e-6}, {"cm^2", 1e-4}}},
        {{{"m", 3}}, {{"m^3", 1}, {"mm^3", 1e-9}, {"cm^3", 1e-6}}},
        {{{"m", 4}}, {{"m^4", 1}, {"mm^4", 1e-12}, {"cm^4", 1e-8}}},
        {{{"m", 1}, {"s", -1}}, {{"m/s", 1}, {"mm/s", 1e-3}, {"km/h", 1 / 3.6}}},
        {{{"m", 1}, {"s", -2}}, {{"m/s^2", 1}, {"mm/s^2", 1e-3}}},
        {{{"s", -1}}, {{"1/s", 1}, {"Hz", 1}, {"kHz", 1e3}}},
        {{{"rad", 1}, {"s", -1}}, {{"rad/s", 1}, {"deg/s", M_PI / 180}, {"rpm", M_PI / 30}}},
        {{{"rad", 1}, {"s", -2}}, {{"rad/s^2", 1}, {"deg/s^2", M_PI / 180}}},
        {{{"kg", 1}, {"m", -1}, {"s", -2}}, {{"Pa", 1}, {"kPa", 1e3}, {"MPa", 1e6}, {"GPa", 1e9}, {"N/mm^2", 1e6}}},
        {{{"kg", 1}, {"m", 3}, {"s", -2}}, {{"N*m^2", 1}, {"N*mm^2", 1e-6}, {"kN*m^2", 1e3}}},
    };
    return table;
}

std::map<std::string, std::optional<Unit>> usual_by_text() {
    std::map<std::string, std::optional<Unit>> all;
    for (const auto& [powers, units] : usual_table())
        for (const auto& [text, scale] : units) all[text] = Unit{scale, powers};
    return all;
}

/// Owner of UDUNITS' one unit system and of its parser, which keeps globals.
class UnitSystem {
public:
    static UnitSystem& instance() {
        static UnitSystem system;
        return system;
    }

    /// Nothing if `text` is no unit, or none that only multiplies.
    std::optional<Unit> parse(const std::string& text) {
        if (text.find('\0') != text.npos) return std::nullopt;  // UDUNITS would stop reading there
        const std::scoped_lock lock(mutex_);
        // A file has few units and many values: reading them anew was a third of reading the four-bolt plate
        constexpr size_t kMostKnown = 1000;
        if (const auto found = known_.find(text); found != known_.end()) return found->second;
        if (known_.size() == kMostKnown) known_ = usual_by_text();
        return known_[text] = read(text);
    }

private:
    using UnitPointer = std::unique_ptr<ut_unit, decltype(&ut_free)>;
    using SystemPointer = std::unique_ptr<ut_system, decltype(&ut_free_system)>;

    std::optional<Unit> read(const std::string& text) {
        if (!system_) read_database();
        const UnitPointer unit(ut_parse(system_.get(), text.c_str(), UT_UTF8), &ut_free);
        if (!unit) return std::nullopt;
        Unit result;
        if (ut_accept_visitor(unit.get(), &kVisitor, &result) != UT_SUCCESS) return std::nullopt;
        result.scale = snap_to_decimal(result.scale);
        std::erase_if(result.powers, [](const auto& power) { return power.second == 0; });
        if (!std::isfinite(result.scale) || result.scale <= 0) return std::nullopt;
        return result;
    }

    void read_database() {
        ut_set_error_message_handler(&ut_ignore);  // faults are told by us, with their place
        system_.reset(ut_read_xml(nullptr));
        if (!system_)
            throw Error(
                ExitCode::input_output,
                "cannot read the unit database of UDUNITS-2; is it installed, and UDUNITS2_XML_PATH unset or right?");
        const UnitPointer degree(ut_parse(system_.get(), "arc_degree", UT_UTF8), &ut_free);
        ut_map_symbol_to_unit("deg", UT_ASCII, degree.get());
    }

    static std::string symbol(const ut_unit* unit) {
        const char* text = ut_get_symbol(unit, UT_ASCII);
        return text ? text : "?";
    }

    static ut_status visit_basic(const ut_unit* unit, void* result) {
        static_cast<Unit*>(result)->powers[symbol(unit)] += 1;
        return UT_SUCCESS;
    }

    static ut_status visit_product(const ut_unit*, int count, const ut_unit* const* units, const int* powers, void* result) {
        for (int i = 0; i < count; ++i) static_cast<Unit*>(result)->powers[symbol(units[i])] += powers[i];
        return UT_SUCCESS;
    }

    static ut_status visit_galilean(const ut_unit*, double scale, const ut_unit* underlying, double offset, void* result) {
        if (offset != 0) return UT_MEANINGLESS;
        static_cast<Unit*>(result)->scale *= scale;
        return ut_accept_visitor(underlying, &kVisitor, result);
    }

    static ut_status visit_timestamp(const ut_unit*, const ut_unit*, double, void*) { return UT_MEANINGLESS; }
    static ut_status visit_logarithmic(const ut_unit*, double, const ut_unit*, void*) { return UT_MEANINGLESS; }

    static constexpr ut_visitor kVisitor = {visit_basic, visit_product, visit_galilean, visit_timestamp, visit_logarithmic};

    std::mutex mutex_;
    SystemPointer system_{nullptr, &ut_free_system};  ///< null: no unusual unit has come yet
    std::map<std::string, std::optional<Unit>> known_ = usual_by_text();
};

std::optional<Unit> parse_unit(std::string_view text) { return UnitSystem::instance().parse(std::string(text)); }

/// The SI unit with the dimension of `unit` as text.
std::string si_text(const Unit& unit) {
    for (const auto& row : usual_units())
        if (parse_unit(row.front())->powers == unit.powers) return row.front();
    std::string text;
    for (const auto& [base, power] : unit.powers)
        text += (text.empty() ? "" : "*") + base + (power == 1 ? std::string() : fmt::format("^{}", power));
    return text;
}

std::string accepted_text(std::string_view wanted) { return listed(accepted_units(wanted)); }

/// Hertz, or so many per minute or hour: turns or cycles, not radians.
bool is_cycles(std::string_view text, const Unit& unit) {
    const bool is_per_long = unit.scale < 1 && unit.powers == std::map<std::string, int>{{"s", -1}};
    return is_per_long || text.find("Hz") != text.npos || text.find("hertz") != text.npos;
}

std::string_view trimmed(std::string_view text) {
    constexpr const char* kBlanks = " \t\r\n";
    const std::size_t begin = std::min(text.find_first_not_of(kBlanks), text.size());
    return text.substr(begin, text.find_last_not_of(kBlanks) - begin + 1);
}

struct NumberAndUnit {
    double number;
    std::string_view unit;  ///< empty for a plain number
};

/// Splits "500 N/mm" and "500N/mm". wanted: as of read_unit().
NumberAndUnit split_quantity(std::string_view text, std::string_view wanted = {}) {
    std::string_view rest = trimmed(text);
    if (rest.empty()) fail("expected a number, got an empty text");
    if (rest.size() > 200) fail(fmt::format("expected a number with a unit, got a text of {} bytes", rest.size()));
    if (rest.front() == '+') rest.remove_prefix(1);
    double number = 0;
    const auto [end, error] = std::from_chars(rest.data(), rest.data() + rest.size(), number);
    if (error == std::errc::result_out_of_range)
        fail(fmt::format("the number in {} is out of range: it must lie within 1e-307 and 1e308", quote(text)));
    if (error != std::errc())
        fail(fmt::format("expected a number{}, got {}",
                         wanted == "1" ? "" : fmt::format(" with a unit, e.g. \"20 {}\"", wanted.empty() ? "mm" : wanted),
                         quote(text)));
    if (!std::isfinite(number)) fail(fmt::format("{} is not finite", quote(text)));
    rest.remove_prefix(as_size(end - rest.data()));
    if (rest.size() > 1 && rest[0] == ',' && is_digit(rest[1]))
        fail(fmt::format("the decimal sign is a point: write {} with '.' instead of ','", quote(text)));
    return {number, trimmed(rest)};
}

/// Reads a unit as written by a user; `wanted`: what would be right, if one is expected.
Unit read_unit(std::string_view unit, std::string_view text, std::string_view wanted = {}) {
    const bool is_inverse = unit.starts_with("1/");
    const bool starts_well = is_inverse || !(is_digit(unit[0]) || unit[0] == '+' || unit[0] == '-' || unit[0] == '.');
    const auto result = starts_well ? parse_unit(unit) : std::nullopt;
    if (result) return *result;
    const std::string cure = wanted.empty() ? std::string() : fmt::format("; accepted here: {}", accepted_text(wanted));
    fail(fmt::format("unknown unit {} in {}{}", quote(unit), quote(text), cure));
}

double checked_value(double number, const Unit& unit, std::string_view text) {
    const double value = apply_scale(number, unit.scale);
    if (!std::isfinite(value)) fail(fmt::format("{} is out of range in SI units", quote(text)));
    return value;
}

}  // namespace

Quantity parse_quantity(std::string_view text) {
    const auto [number, unit_text] = split_quantity(text);
    if (unit_text.empty()) return {number, "1"};
    const Unit unit = read_unit(unit_text, text);
    return {checked_value(number, unit, text), is_cycles(unit_text, unit) ? "Hz" : si_text(unit)};
}

double parse_quantity(std::string_view text, std::string_view wanted) {
    const auto [number, unit_text] = split_quantity(text, wanted);
    if (unit_text.empty()) return number;
    const Unit unit = read_unit(unit_text, text, wanted);
    if (!measures(unit_text, wanted))
        fail(fmt::format("expected a value in {}, got {}; accepted here: {}", wanted, quote(text), accepted_text(wanted)));
    return checked_value(number, unit, text);
}

std::string unit_text(std::string_view text) { return std::string(split_quantity(text).unit); }

bool measures(std::string_view unit, std::string_view wanted) {
    const auto given = parse_unit(unit);
    const auto asked = parse_unit(wanted);
    if (!given || !asked || dimension(*given) != dimension(*asked)) return false;
    if (radians(*given) == radians(*asked)) return true;
    return radians(*given) == 0 && !is_cycles(unit, *given);
}

const std::vector<std::vector<std::string>>& usual_units() {
    static const std::vector<std::vector<std::string>> texts = [] {
        std::vector<std::vector<std::string>> rows;
        for (const UsualUnits& row : usual_table()) {
            rows.emplace_back();
            for (const auto& [text, scale] : row.units) rows.back().push_back(text);
        }
        return rows;
    }();
    return texts;
}

std::vector<std::string> accepted_units(std::string_view wanted) {
    const auto asked = parse_unit(wanted);
    for (const auto& row : usual_units()) {
        if (!asked || parse_unit(row.front())->powers != asked->powers) continue;
        std::vector<std::string> units = row;
        std::erase(units, wanted);
        units.insert(units.begin(), std::string(wanted));
        return units;
    }
    return {std::string(wanted)};
}

}  // namespace dttmm::host
