// SPDX-License-Identifier: BSD-3-Clause
#include "measured/csv_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <span>
#include <string_view>

#include "model/error.h"
#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"
#include "record/column.h"
#include "record/csv_file.h"
#include "record/file.h"

namespace dttmm::host {

namespace {

constexpr std::uintmax_t kLargestTable = std::uintmax_t{4} << 30;  // [byte]: more would not fit into the memory of a desk
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

std::string_view trimmed(std::string_view text) {
    const size_t begin = text.find_first_not_of(" \t\r\"");
    return begin == text.npos ? "" : text.substr(begin, text.find_last_not_of(" \t\r\"") + 1 - begin);
}

std::string lower(std::string_view text) {
    std::string result(text);
    for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return result;
}

bool is_one_of(const std::string& word, std::initializer_list<const char*> words) {
    return std::ranges::find(words, lower(word)) != words.end();
}

bool is_frequency_name(const std::string& name) {
    return is_one_of(name, {"frequency", "freq", "f", "f_hz", "frequency_hz", "freq_hz", "natural_frequency"});
}
bool is_deviation_name(const std::string& name) {
    return is_one_of(name, {"frequency.deviation", "frequency_deviation", "frequency.sigma", "sigma_f", "f_sd"});
}
bool is_damping_name(const std::string& name) { return is_one_of(name, {"damping_ratio", "damping", "zeta"}); }

/// A table of numbers as the file has it.
class MeasuredTable {
public:
    explicit MeasuredTable(const std::filesystem::path& file);

    const std::vector<Column>& columns() const { return columns_; }
    size_t rows() const { return lines_.size(); }
    size_t line(size_t row) const { return lines_[row]; }
    /// NaN where the field is empty.
    const std::vector<double>& numbers(size_t column) const { return numbers_[column]; }
    const std::vector<std::string>& texts(size_t column) const { return texts_[column]; }
    std::string place(size_t column) const {
        return fmt::format("{}: column {}", file_.string(), quote(columns_[column].name));
    }
    std::string place_of_row(size_t row) const { return fmt::format("{}:{}", file_.string(), lines_[row]); }
    [[noreturn]] void fail(size_t line, const std::string& fault) const {
        throw Error(ExitCode::input_output, fmt::format("{}:{}: {}", file_.string(), line, fault));
    }
    /// The column without gaps. Throws for an empty field.
    const std::vector<double>& complete(size_t column) const;
    /// The column that is called so; none: there is none.
    template <class Is>
    std::optional<size_t> find(const Is& is) const {
        for (size_t c = 0; c < columns_.size(); ++c)
            if (is(columns_[c].name)) return c;
        return std::nullopt;
    }

private:
    void split(std::string_view line, std::vector<std::string_view>& fields) const;
    void take_heads(std::string_view line);
    bool take_units(const std::vector<std::string_view>& fields);
    void take_row(const std::vector<std::string_view>& fields, size_t line);
    std::optional<double> number(std::string_view field) const;

    std::filesystem::path file_;
    char separator_ = ',';
    bool has_units_ = false;
    std::vector<Column> columns_;
    std::vector<std::vector<double>> numbers_;
    std::vector<std::vector<std::string>> texts_;  ///< of columns with names of places
    std::vector<size_t> lines_;
};

/// Names may be quoted and hold commas then.
void MeasuredTable::take_heads(std::string_view line) {
    for (const char separator : {'\t', ';', ','})
        if (line.find(separator) != line.npos) {
            separator_ = separator;
            break;
        }
    std::vector<std::string_view> fields;
    split(line, fields);
    for (std::string_view field : fields) {
        field = trimmed(field);
        const size_t open = field.ends_with(']') ? field.rfind('[') : field.npos;
        if (open == field.npos) {
            columns_.push_back({std::string(field), ""});
        } else {
            columns_.push_back({std::string(trimmed(field.substr(0, open))),
                                std::string(trimmed(field.substr(open + 1, field.size() - open - 2)))});
            has_units_ = true;
        }
    }
    for (size_t c = 0; c < columns_.size(); ++c) {
        if (columns_[c].name.empty()) fail(1, fmt::format("column {} has no name", c + 1));
        for (size_t d = 0; d < c; ++d)
            if (columns_[c].name == columns_[d].name)
                fail(1, fmt::format("two columns are called {}", quote(columns_[c].name)));
    }
    numbers_.resize(columns_.size());
    texts_.resize(columns_.size());
}

void MeasuredTable::split(std::string_view line, std::vector<std::string_view>& fields) const {
    fields.clear();
    size_t begin = 0;
    bool is_quoted = false;
    for (size_t i = 0; i <= line.size(); ++i) {
        if (i < line.size() && line[i] == '"') is_quoted = !is_quoted;
        if (i < line.size() && (line[i] != separator_ || is_quoted)) continue;
        fields.push_back(trimmed(line.substr(begin, i - begin)));
        begin = i + 1;
    }
}

std::optional<double> MeasuredTable::number(std::string_view field) const {
    std::string own;
    if (separator_ != ',' && field.find(',') != field.npos) {
        own = field;
        std::ranges::replace(own, ',', '.');
        field = own;
    }
    if (field.starts_with('+')) field.remove_prefix(1);
    double value = 0;
    const auto [end, fault] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (fault != std::errc() || end != field.data() + field.size()) return std::nullopt;
    return value;
}

/// A second line without a number holds the units.
bool MeasuredTable::take_units(const std::vector<std::string_view>& fields) {
    if (std::ranges::any_of(fields, [&](std::string_view field) { return number(field) && field != "1"; })) return false;
    if (std::ranges::all_of(fields, [&](std::string_view field) { return number(field).has_value(); })) return false;
    for (size_t c = 0; c < fields.size() && c < columns_.size(); ++c)
        if (!fields[c].empty()) columns_[c].unit = std::string(fields[c]);
    return true;
}

void MeasuredTable::take_row(const std::vector<std::string_view>& fields, size_t line) {
    if (fields.size() != columns_.size())
        fail(line, fmt::format("{}, but {}: the row is incomplete, or the file was cut off",
                               counted(fields.size(), "field", "fields"), counted(columns_.size(), "name", "names")));
    for (size_t c = 0; c < fields.size(); ++c) {
        if (columns_[c].name == "place" || columns_[c].name == "element" || columns_[c].name == "resembles") {
            texts_[c].emplace_back(fields[c]);
            continue;
        }
        const std::optional<double> value = fields[c].empty() ? kNone : number(fields[c]);
        if (!value || (!fields[c].empty() && !std::isfinite(*value)))
            fail(line, fmt::format("{} of column {} is no finite number: leave the row out, or mend it", quote(fields[c]),
                                   quote(columns_[c].name)));
        numbers_[c].push_back(*value);
    }
    lines_.push_back(line);
}

MeasuredTable::MeasuredTable(const std::filesystem::path& file) : file_(file) {
    std::error_code fault;
    if (std::filesystem::exists(file, fault) && !std::filesystem::is_regular_file(file, fault))
        throw Error(ExitCode::input_output, fmt::format("{}: is no regular file", file.string()));
    if (std::filesystem::file_size(file, fault) > kLargestTable && !fault)
        throw Error(ExitCode::input_output, fmt::format("{}: is larger than 4 GiB; split it", file.string()));
    const std::string text = read_whole_file(file);
    size_t line = 0;
    bool is_second = false;
    std::vector<std::string_view> fields;
    for (size_t begin = 0; begin < text.size();) {
        const size_t end = std::min(text.find('\n', begin), text.size());
        std::string_view one = std::string_view(text).substr(begin, end - begin);
        if (line == 0 && one.starts_with("\xEF\xBB\xBF")) one.remove_prefix(3);
        begin = end + 1;
        ++line;
        if (one.find_first_not_of(" \t\r") == one.npos || one.starts_with('#')) continue;
        if (one.find('\0') != one.npos) fail(line, "there is a zero byte: this is no text");
        if (columns_.empty()) {
            take_heads(one);
            is_second = true;
            continue;
        }
        split(one, fields);
        if (!is_second || !take_units(fields)) take_row(fields, line);
        is_second = false;
    }
    if (columns_.empty()) fail(1, "the file is empty");
    if (columns_.size() < 2 && !is_frequency_name(columns_.front().name))
        fail(1, "there is one column only: names, parted by commas, semicolons or tabulators, are wanted in the first line");
    if (number(columns_.front().name)) fail(1, "the first line must hold the names of the columns, but it holds a number");
    if (lines_.empty()) fail(line, "there is no row of numbers");
}

const std::vector<double>& MeasuredTable::complete(size_t column) const {
    const auto gap = std::ranges::find_if(numbers_[column], [](double value) { return std::isnan(value); });
    if (gap != numbers_[column].end())
        fail(lines_[as_size(gap - numbers_[column].begin())],
             fmt::format("there is no value of {}: leave the row out, or mend it", quote(columns_[column].name)));
    return numbers_[column];
}

/// The first column, ascending, in the SI unit.
std::vector<double> abscissa_of(const MeasuredTable& table, const char* unit) {
    std::vector<double> x = table.complete(0);
    const std::string& own = table.columns().front().unit;
    double factor = 1;
    try {
        if (!own.empty()) factor = parse_quantity("1 " + own, unit);
    } catch (const Error& error) {
        table.fail(1, fmt::format("column {}: {}", quote(table.columns().front().name), error.what()));
    }
    for (size_t i = 0; i < x.size(); ++i) {
        x[i] *= factor;
        if (i > 0 && !(x[i] > x[i - 1]))
            table.fail(table.line(i),
                       fmt::format("{} must ascend, but {} {} follows {}", quote(table.columns().front().name),
                                   number_text(x[i]), unit, number_text(x[i - 1])));
    }
    return x;
}

/// A name, and what of a complex number it is.
struct Part {
    enum class Of : unsigned char { whole, real, imaginary, magnitude, phase, coherence };
    std::string name;
    Of of = Of::whole;
};

Part part_of(const std::string& name) {
    using Of = Part::Of;
    static const std::map<std::string, Of> kEndings = {
        {"re", Of::real},       {"real", Of::real},          {"im", Of::imaginary},        {"imag", Of::imaginary},
        {"abs", Of::magnitude}, {"mag", Of::magnitude},      {"magnitude", Of::magnitude}, {"phase", Of::phase},
        {"coh", Of::coherence}, {"coherence", Of::coherence}};
    const size_t dot = name.rfind('.');
    if (dot == name.npos) return {name, Of::whole};
    const auto ending = kEndings.find(lower(std::string_view(name).substr(dot + 1)));
    return ending == kEndings.end() ? Part{name, Of::whole} : Part{name.substr(0, dot), ending->second};
}

/// "plate.position.z/plate.corner1.z" is an output and an input.
void split_reference(MeasuredSignal& signal) {
    const size_t slash = signal.name.find('/');
    if (slash == signal.name.npos) return;
    signal.reference = std::string(trimmed(std::string_view(signal.name).substr(slash + 1)));
    signal.name = std::string(trimmed(std::string_view(signal.name).substr(0, slash)));
}

void read_histories(const MeasuredTable& table, Measurement& found) {
    const std::vector<double> times = abscissa_of(table, "s");
    for (size_t c = 1; c < table.columns().size(); ++c) {
        MeasuredSignal signal;
        signal.kind = MeasuredSignal::Kind::history;
        signal.name = table.columns()[c].name;
        signal.unit = table.columns()[c].unit;
        signal.abscissa = times;
        signal.values = table.complete(c);
        signal.place = table.place(c);
        found.signals.push_back(std::move(signal));
    }
}

/// Columns of one response.
struct Columns {
    std::array<std::optional<size_t>, 6> at;
    const std::optional<size_t>& of(Part::Of part) const { return at[static_cast<size_t>(part)]; }
};

void take_complex(const MeasuredTable& table, const Columns& columns, MeasuredSignal& signal) {
    using Of = Part::Of;
    if (columns.of(Of::magnitude) && columns.of(Of::phase)) {
        const std::vector<double>&size = table.complete(*columns.of(Of::magnitude)),
              &phase = table.complete(*columns.of(Of::phase));
        const double per_unit = table.columns()[*columns.of(Of::phase)].unit == "rad" ? 1 : std::numbers::pi / 180;
        for (size_t i = 0; i < size.size(); ++i) {
            signal.values.push_back(size[i] * std::cos(per_unit * phase[i]));
            signal.imaginary.push_back(size[i] * std::sin(per_unit * phase[i]));
        }
        return;
    }
    const auto& real = columns.of(columns.of(Of::real) ? Of::real : Of::whole);
    const bool is_half = columns.of(Of::real).has_value() != columns.of(Of::imaginary).has_value();
    if (!real || is_half || columns.of(Of::magnitude) || columns.of(Of::phase))
        table.fail(1, fmt::format("{} has not both of .re and .im, or of .magnitude and .phase", quote(signal.name)));
    signal.values = table.complete(*real);
    if (columns.of(Of::imaginary)) signal.imaginary = table.complete(*columns.of(Of::imaginary));
}

void read_responses(const MeasuredTable& table, Measurement& found) {
    using Of = Part::Of;
    const std::vector<double> frequencies = abscissa_of(table, "Hz");
    std::vector<std::string> names;
    std::map<std::string, Columns> columns;
    for (size_t c = 1; c < table.columns().size(); ++c) {
        const Part part = part_of(table.columns()[c].name);
        if (!columns.contains(part.name)) names.push_back(part.name);
        columns[part.name].at[static_cast<size_t>(part.of)] = c;
    }
    for (const std::string& name : names) {
        const Columns& own = columns[name];
        const bool has_values = std::ranges::any_of(std::span(own.at).first(5), [](const auto& c) { return c.has_value(); });
        const auto make = [&](MeasuredSignal::Kind kind, size_t column) {
            MeasuredSignal signal;
            signal.kind = kind;
            signal.name = name;
            signal.unit = table.columns()[column].unit;
            signal.abscissa = frequencies;
            signal.place = table.place(column);
            split_reference(signal);
            return signal;
        };
        if (has_values) {
            size_t first = 0;
            while (!own.at[first] || first == static_cast<size_t>(Of::phase)) {
                if (++first == 5) table.fail(1, fmt::format("of {} there is the phase alone", quote(name)));
            }
            MeasuredSignal signal = make(MeasuredSignal::Kind::response, *own.at[first]);
            take_complex(table, own, signal);
            found.signals.push_back(std::move(signal));
        }
        if (own.of(Of::coherence)) {
            MeasuredSignal signal = make(MeasuredSignal::Kind::coherence, *own.of(Of::coherence));
            signal.values = table.complete(*own.of(Of::coherence));
            found.signals.push_back(std::move(signal));
        }
    }
}

/// What every mode has beside its shape.
MeasuredMode mode_of_row(const MeasuredTable& table, size_t row, size_t frequency) {
    MeasuredMode mode;
    const auto value_of = [&](const std::optional<size_t>& column, double other) {
        const double value = column ? table.numbers(*column)[row] : other;
        return std::isnan(value) ? other : value;
    };
    mode.place = table.place_of_row(row);
    mode.frequency = table.numbers(frequency)[row];
    if (!(mode.frequency > 0)) table.fail(table.line(row), "a natural frequency above 0 is wanted in every row");
    const std::string& unit = table.columns()[frequency].unit;
    if (!unit.empty()) mode.frequency *= parse_quantity("1 " + unit, "Hz");
    mode.frequency_deviation = value_of(table.find(is_deviation_name), 0);
    if (mode.frequency_deviation < 0) table.fail(table.line(row), "a deviation is below 0");
    mode.damping = value_of(table.find(is_damping_name), kNone);
    const double number = value_of(table.find([](const std::string& name) { return lower(name) == "mode"; }), 0);
    if (number < 0 || number > 1e6 || number != std::floor(number))
        table.fail(table.line(row), "the number of a mode must be a whole number from 1 on");
    mode.number = static_cast<int>(number);
    return mode;
}

/// The modes.csv of `dttmm modes`: a row per mode and place.
void read_own_modes(const MeasuredTable& table, size_t frequency, size_t place, Measurement& found) {
    constexpr const char* kColumns[] = {"ux", "uy", "uz", "urx", "ury", "urz"};
    constexpr const char* kDirections[] = {"x", "y", "z", "rx", "ry", "rz"};
    std::map<std::string, size_t> first_of;
    std::map<int, size_t> mode_of;
    for (size_t row = 0; row < table.rows(); ++row) {
        const MeasuredMode mode = mode_of_row(table, row, frequency);
        if (mode_of.emplace(mode.number, found.modes.size()).second) found.modes.push_back(mode);
        const std::string& name = table.texts(place)[row];
        if (first_of.emplace(name, found.shape_names.size()).second)
            for (const char* direction : kDirections) found.shape_names.push_back(name + "." + direction);
        std::vector<std::complex<double>>& shape = found.modes[mode_of[mode.number]].shape;
        for (size_t d = 0; d < 6; ++d) {
            const auto column = table.find([&](const std::string& other) { return other == kColumns[d]; });
            shape.resize(std::max(shape.size(), first_of[name] + 6), {kNone, 0});
            if (column) shape[first_of[name] + d] = table.numbers(*column)[row];
        }
    }
    for (MeasuredMode& mode : found.modes) mode.shape.resize(found.shape_names.size(), {kNone, 0});
    // Directions in which nothing moves are no data
    for (size_t i = 0; i < found.shape_names.size(); ++i)
        if (std::ranges::all_of(found.modes, [&](const MeasuredMode& mode) { return mode.shape[i] == 0.0; }))
            for (MeasuredMode& mode : found.modes) mode.shape[i] = {kNone, 0};
}

void read_modes(const MeasuredTable& table, size_t frequency, Measurement& found) {
    if (const auto place = table.find([](const std::string& name) { return name == "place"; }))
        return read_own_modes(table, frequency, *place, found);
    struct Freedom {
        std::optional<size_t> real, imaginary;
    };
    std::vector<Freedom> freedoms;
    for (size_t c = 0; c < table.columns().size(); ++c) {
        const std::string& name = table.columns()[c].name;
        const bool is_other = c == frequency || is_deviation_name(name) || is_damping_name(name) || lower(name) == "mode" ||
                              !table.texts(c).empty() || is_one_of(name, {"multiplicity", "modal_mass", "mac"});
        if (is_other) continue;
        const Part part = part_of(name);
        const auto known = std::ranges::find(found.shape_names, part.name);
        const size_t at = as_size(known - found.shape_names.begin());
        if (known == found.shape_names.end()) {
            found.shape_names.push_back(part.name);
            freedoms.emplace_back();
        }
        (part.of == Part::Of::imaginary ? freedoms[at].imaginary : freedoms[at].real) = c;
    }
    for (size_t row = 0; row < table.rows(); ++row) {
        MeasuredMode mode = mode_of_row(table, row, frequency);
        for (const Freedom& freedom : freedoms)
            mode.shape.emplace_back(freedom.real ? table.numbers(*freedom.real)[row] : 0,
                                    freedom.imaginary ? table.numbers(*freedom.imaginary)[row] : 0);
        found.modes.push_back(std::move(mode));
    }
}

}  // namespace

Measurement read_measured_csv(const std::filesystem::path& file) {
    const MeasuredTable table(file);
    Measurement found;
    found.format = "CSV";
    const std::string first = lower(table.columns().front().name);
    if (is_one_of(first, {"time", "t", "time_s", "t_s"})) {
        read_histories(table, found);
        return found;
    }
    const auto frequency = table.find(is_frequency_name);
    const bool is_list = std::ranges::all_of(table.columns(), [](const Column& column) {
        return is_frequency_name(column.name) || is_deviation_name(column.name) || is_damping_name(column.name);
    });
    if (frequency && (first == "mode" || is_list))
        read_modes(table, *frequency, found);
    else if (frequency && *frequency == 0)
        read_responses(table, found);
    else
        table.fail(1, fmt::format("the first column is called {}: it must be \"time\", \"frequency\" or \"mode\"{}",
                                  quote(table.columns().front().name),
                                  first == "mode" ? ", and of modes there must be a column \"frequency\"" : ""));
    return found;
}

}  // namespace dttmm::host
