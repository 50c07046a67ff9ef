// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_signal.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "model/signal_shapes.h"
#include "model/table_file.h"
#include "model/wording.h"

namespace dttmm::host {
namespace {

template <class Shape, class... Arguments>
Signal make_signal(Arguments&&... arguments) {
    return Signal(std::make_shared<const Shape>(std::forward<Arguments>(arguments)...));
}

std::optional<Signal> read_constant(const ReadContext& context, const TomlValue& value, const std::string& what,
                                    std::string_view unit) {
    const auto number = read_number(context, value, what, unit);
    return number ? std::optional(make_signal<ConstantSignal>(*number)) : std::nullopt;
}

std::optional<Signal> read_expression(const ReadContext& context, const TomlValue& value, const std::string& what,
                                      std::string_view unit) {
    const std::string_view text = std::string_view(value.string).substr(1);
    const auto names = expression_names(text);
    if (std::find(names.begin(), names.end(), "t") == names.end()) return read_constant(context, value, what, unit);
    if (context.parameters.rests_on_fault(text)) return std::nullopt;
    try {
        Expression expression(text, context.parameters.constants(), "t");
        if (std::isfinite(expression.value(context.instant))) return make_signal<ExpressionSignal>(std::move(expression));
        context.diagnostics.error(value.place,
                                  fmt::format("{}: the value of {} is not finite at t = {:g}{}", what, quote(value.string),
                                              context.instant, context.instant == 0 ? "" : " s"));
    } catch (const Error& error) {
        context.diagnostics.error(value.place, fmt::format("{}: {}", what, error.what()));
    }
    return std::nullopt;
}

std::optional<Signal> read_expression_table(const TableReader& table) {
    const TomlMember* member = table.require("value");
    if (!member) return std::nullopt;
    if (!member->value.is_text() || !member->value.string.starts_with("=")) {
        table.error(member->value.place, "value must be a text that begins with \"=\"");
        return std::nullopt;
    }
    return read_expression(table.context(), member->value, table.what("value"), table.unit());
}

std::optional<Signal> read_step(const TableReader& table) {
    const auto from = table.number("from", 0);
    const auto to = table.number("to");
    const auto start = table.number("start", 0);
    const auto end = table.number("end");
    if (!from || !to || !start || !end) return std::nullopt;
    if (*end < *start) {
        table.error(table.find("end")->value.place,
                    fmt::format("end must not lie before start ({} s), got {} s", *start, *end));
        return std::nullopt;
    }
    return make_signal<StepSignal>(*from, *to, *start, *end);
}

std::optional<Signal> read_haversine(const TableReader& table) {
    const auto peak = table.number("peak");
    const auto start = table.number("start", 0);
    const auto width = table.number("width");
    if (!peak || !start || !width) return std::nullopt;
    return make_signal<PulseSignal>(*peak, *start, *width);
}

std::optional<double> read_pulse_count(const TableReader& table) {
    const auto count = table.number("count", 1);
    if (!count || *count == std::round(*count)) return count;
    table.error(table.find("count")->value.place, fmt::format("count must be a whole number, got {}", *count));
    return std::nullopt;
}

std::optional<Signal> read_pulse(const TableReader& table) {
    const auto peak = table.number("peak");
    const auto start = table.number("start", 0);
    const auto width = table.number("width");
    const auto count = read_pulse_count(table);
    const bool repeats = count && *count > 1;
    const auto period = repeats ? table.number("period") : table.number("period", 0);
    if (!peak || !start || !width || !count || !period) return std::nullopt;
    if (repeats && *period < *width) {
        table.error(table.find("period")->value.place,
                    fmt::format("period must be ≥ width ({} s), got {} s", *width, *period));
        return std::nullopt;
    }
    return make_signal<PulseSignal>(*peak, *start, *width, *period, *count);
}

std::optional<Signal> read_sine(const TableReader& table) {
    const auto amplitude = table.number("amplitude");
    const auto frequency = table.number("frequency");
    const auto phase = table.number("phase", 0);
    const auto offset = table.number("offset", 0);
    const auto start = table.number("start", 0);
    if (!amplitude || !frequency || !phase || !offset || !start) return std::nullopt;
    return make_signal<SineSignal>(*amplitude, *frequency, *phase, *offset, *start);
}

/// What a vibration is of: the signal, or its first or second derivative where it is a motion. Faults are reported.
std::optional<int> read_derivative(const TableReader& table) {
    if (!table.find("of")) return 0;
    const auto derivative = table.choice("of", 0);
    if (table.unit() == "m" || table.unit() == "rad") return derivative;
    table.error(table.find("of")->place, "of is for the motion of a support");
    return std::nullopt;
}

std::string unit_of_derivative(const TableReader& table, int derivative) {
    return derivative == 0 ? std::string(table.unit()) : fmt::format("{}/s{}", table.unit(), derivative == 2 ? "^2" : "");
}

/// The amplitude: a number, or an expression that rests on the speed.
bool read_amplitude(const TableReader& table, HarmonicSignal::Numbers& numbers) {
    const ReadContext& context = table.context();
    const TomlMember* member = table.find("amplitude");
    const bool is_expression = member && member->value.is_text() && member->value.string.starts_with("=");
    const std::string text = is_expression ? member->value.string.substr(1) : std::string();
    if (!is_expression || !context.parameters.rests_on(text, kSpeed)) {
        const TomlMember* given = table.require("amplitude");
        if (!given) return false;
        const auto number =
            read_number(context, given->value, table.what("amplitude"), unit_of_derivative(table, numbers.derivative));
        numbers.amplitude = number.value_or(0);
        return number.has_value();
    }
    if (context.parameters.rests_on_fault(text)) return false;
    try {
        context.parameters.check_unit(text, unit_of_derivative(table, numbers.derivative));
        numbers.formula = std::make_shared<const Expression>(context.parameters.written_out(text, kSpeed),
                                                             context.parameters.constants(), kSpeed);
        return true;
    } catch (const Error& error) {
        table.error(member->value.place, fmt::format("amplitude: {}", error.what()));
        return false;
    }
}

std::optional<Signal> read_harmonic(const TableReader& table) {
    HarmonicSignal::Numbers numbers;
    const auto derivative = read_derivative(table);
    numbers.derivative = derivative.value_or(0);
    const bool has_amplitude = read_amplitude(table, numbers);
    const auto phase = table.number("phase", 0);
    const auto own = [&](const char* key, std::optional<double>& number) {
        if (table.find(key)) number = table.number(key);
        return !table.find(key) || number;
    };
    const bool has_frequency = own("frequency", numbers.frequency), has_order = own("order", numbers.order);
    if (derivative.value_or(0) > 0 && numbers.frequency == 0.0) {
        table.error(table.find("frequency")->place,
                    "a velocity or acceleration of 0 Hz leads away for ever: the frequency must be > 0 Hz");
        return std::nullopt;
    }
    if (!derivative || !has_amplitude || !phase || !has_frequency || !has_order) return std::nullopt;
    if (numbers.frequency && numbers.order) {
        table.error(table.find("order")->place, "order and frequency exclude each other");
        return std::nullopt;
    }
    if (!read_speed(table, table.find(numbers.order ? "order" : "amplitude")->place, numbers)) return std::nullopt;
    numbers.phase = *phase;
    return make_signal<HarmonicSignal>(numbers);
}

std::optional<Signal> read_psd(const TableReader& table) {
    const auto frequencies = table.numbers("frequencies");
    const TomlMember* values = table.require("values");
    const auto interpolation = table.choice("interpolation", 0);
    const auto derivative = read_derivative(table);
    if (!derivative || !frequencies || !values || !interpolation) return std::nullopt;
    const auto fail = [&](const char* key, size_t i, const std::string& text) {
        const TomlValue& list = table.find(key)->value;
        table.error(list.is_array() && i < list.items.size() ? list.items[i].place : list.place, text);
        return std::nullopt;
    };
    const auto densities = read_numbers(table.context(), values->value, table.what("values"),
                                        fmt::format("({})^2/Hz", unit_of_derivative(table, *derivative)),
                                        std::max<std::size_t>(values->value.items.size(), 1), false, kNotNegative);
    if (!densities) return std::nullopt;
    if (frequencies->size() != densities->size())
        return fail("values", densities->size(),
                    fmt::format("frequencies and values must be of one length, got {} and {}", frequencies->size(),
                                densities->size()));
    if (frequencies->size() < 2)
        return fail("frequencies", 0,
                    "a power spectral density wants two points or more: it is zero outside of them; give the lowest and the "
                    "highest frequency");
    for (std::size_t i = 0; i < frequencies->size(); ++i) {
        if (i > 0 && !((*frequencies)[i] > (*frequencies)[i - 1]))
            return fail("frequencies", i,
                        fmt::format("frequencies must increase: {} Hz does not come after {} Hz", (*frequencies)[i],
                                    (*frequencies)[i - 1]));
        if (*interpolation == 1 && !((*frequencies)[i] > 0 && (*densities)[i] > 0))
            return fail("values", i,
                        fmt::format("interpolation = \"log\" wants frequencies and values above zero, got {} at {} Hz",
                                    (*densities)[i], (*frequencies)[i]));
    }
    if (*derivative > 0 && frequencies->front() == 0)
        return fail("frequencies", 0, "a velocity or acceleration of 0 Hz leads away for ever: begin above 0 Hz");
    return make_signal<PsdSignal>(*frequencies, *densities, *interpolation == 1, *derivative);
}

/// The signal of points of a value, or of a velocity or acceleration of it, which may leave it moving for ever.
Signal make_table(const TableReader& table, std::vector<double> times, std::vector<double> values, int derivative) {
    if (derivative == 0) return make_signal<TableSignal>(std::move(times), std::move(values));
    const auto shape = std::make_shared<const IntegratedTableSignal>(std::move(times), std::move(values), derivative);
    constexpr double kAtRest = 1e-6;  // of the largest velocity: rounding of a table's digits
    if (std::abs(shape->last_velocity()) > kAtRest * shape->largest_velocity())
        table.warning(
            table.place(), "motion-drifts",
            fmt::format("{}: behind the last point it goes on with {:.3g} {} for ever: correct the baseline of the "
                        "acceleration, so that its integral ends at zero",
                        table.what("values"), shape->last_velocity(), unit_of_derivative(table, 1)));
    return Signal(shape);
}

std::optional<Signal> read_inline_table(const TableReader& table, int derivative) {
    const auto times = table.numbers("times");
    const TomlMember* given = table.require("values");
    if (!times || !given) return std::nullopt;
    const auto values =
        read_numbers(table.context(), given->value, table.what("values"), unit_of_derivative(table, derivative),
                     std::max<std::size_t>(given->value.items.size(), 1));
    if (!values) return std::nullopt;
    const TomlValue& place = table.find("times")->value;
    if (times->size() != values->size()) {
        table.error(place.place,
                    fmt::format("times and values must be of one length, got {} and {}", times->size(), values->size()));
        return std::nullopt;
    }
    for (std::size_t i = 1; i < times->size(); ++i) {
        if ((*times)[i] > (*times)[i - 1]) continue;
        table.error(place.is_array() ? place.items[i].place : place.place,
                    fmt::format("times must increase: row {} ({} s) does not come after row {} ({} s)", i + 1, (*times)[i],
                                i, (*times)[i - 1]));
        return std::nullopt;
    }
    return make_table(table, *times, *values, derivative);
}

std::optional<Signal> read_file_table(const TableReader& table, int derivative) {
    const auto name = table.text("file");
    if (!name) return std::nullopt;
    for (const char* key : {"times", "values"})
        if (const TomlMember* member = table.find(key))
            table.error(member->place, fmt::format("{} and file exclude each other", key));
    try {
        const std::filesystem::path& folder = table.context().folder_of(table.find("file")->value.place);
        TimeTable columns = read_table_file(folder, *name, unit_of_derivative(table, derivative));
        table.context().inputs.read.push_back(folder / *name);
        return make_table(table, std::move(columns.times), std::move(columns.values), derivative);
    } catch (const Error& error) {
        table.error(table.find("file")->value.place, error.what());
        return std::nullopt;
    }
}

std::optional<Signal> read_table(const TableReader& table) {
    const auto derivative = read_derivative(table);
    if (!derivative) return std::nullopt;
    return table.find("file") ? read_file_table(table, *derivative) : read_inline_table(table, *derivative);
}

std::optional<Signal> read_constant_table(const TableReader& table) {
    const auto number = table.number("value");
    return number ? std::optional(make_signal<ConstantSignal>(*number)) : std::nullopt;
}

/// The key tables "signal.<type>" and what reads them.
constexpr struct ShapeReader {
    const char* type;
    std::optional<Signal> (*read)(const TableReader& table);
} kShapes[] = {
    {"constant", read_constant_table},
    {"step", read_step},
    {"haversine", read_haversine},
    {"pulse", read_pulse},
    {"sine", read_sine},
    {"harmonic", read_harmonic},
    {"psd", read_psd},
    {"table", [](const TableReader& table) { return read_table(table); }},
    {"expression", read_expression_table},
};

std::optional<Signal> read_shape(const ReadContext& context, const TomlValue& value, const std::string& what,
                                 std::string_view unit) {
    const TomlMember* type = value.find("type");
    std::vector<std::string> types;
    for (const ShapeReader& shape : kShapes) {
        types.emplace_back(shape.type);
        if (type && type->value.string == shape.type)
            return shape.read(TableReader(context, value, what, key_table("signal." + types.back()), {}, unit));
    }
    if (!type) {
        context.diagnostics.error(value.place, fmt::format("{}: missing key \"type\"; one of {}", what, listed(types)));
    } else {
        const std::string hint = suggestion(type->value.string, types);
        context.diagnostics.error(type->value.place,
                                  fmt::format("{}: unknown type {} of a signal{}", what, quote(type->value.string), hint));
    }
    return std::nullopt;
}

}  // namespace

std::optional<Signal> read_vibration(const TableReader& table, bool is_random) {
    return is_random ? read_psd(table) : read_harmonic(table);
}

std::optional<Signal> read_signal(const ReadContext& context, const TomlValue& value, const std::string& what,
                                  std::string_view unit) {
    if (value.is_table()) return read_shape(context, value, what, unit);
    if (value.is_text() && value.string.starts_with("=")) return read_expression(context, value, what, unit);
    return read_constant(context, value, what, unit);
}

bool read_speed(const TableReader& table, Place place, HarmonicSignal::Numbers& numbers) {
    const Parameters& parameters = table.context().parameters;
    const auto found = parameters.constants().find(kSpeed);
    if (found == parameters.constants().end()) return true;
    numbers.speed = found->second;
    if (!numbers.order && !numbers.formula) return true;
    try {
        parameters.check_unit(kSpeed, "rad/s");
    } catch (const Error& error) {
        table.error(place, fmt::format("the speed: {}", error.what()));
        return false;
    }
    return true;
}

}  // namespace dttmm::host
