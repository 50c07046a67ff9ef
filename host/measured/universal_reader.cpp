// SPDX-License-Identifier: BSD-3-Clause
#include "measured/universal_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "measured/remarks.h"
#include "measured/universal_function.h"
#include "measured/universal_text.h"
#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/csv_file.h"

namespace dttmm::host {

namespace {

constexpr std::uintmax_t kLargestUniversal = std::uintmax_t{4} << 30;  // [byte]: it is read as a whole

/// The whole numbers of a line, by columns of ten or, where those are shifted, by blanks.
std::vector<long long> universal_wholes(const UniversalText& text, std::string_view line) {
    constexpr std::size_t kWidth[] = {10};
    std::vector<double> numbers;
    const auto bad = append_fortran_reals(line, kWidth, numbers);
    std::vector<long long> wholes;
    constexpr double kMost = 1e12;  // beyond what ten columns hold
    for (const double number : numbers) {
        if (!(std::abs(number) < kMost) || number != std::floor(number))
            text.fail(fmt::format("{} is no whole number: the file is damaged", number));
        wholes.push_back(static_cast<long long>(number));
    }
    if (bad) text.fail(fmt::format("{} is no whole number: the file is damaged", quote(*bad)));
    return wholes;
}

/// Shapes of modes until it is known which nodes and directions there are.
class ModeCollector {
public:
    explicit ModeCollector(Remarks& remarks) : remarks_(remarks) {}
    /// Data set 55 behind its number line, but for its end line. lengths: values along axes are divided by it.
    void read(UniversalText& text, double lengths);
    void finish(Measurement& measurement);

private:
    struct Component {
        std::size_t freedom;
        std::complex<double> value;
    };
    struct Mode {
        MeasuredMode mode;
        bool is_conjugate = false;
        std::vector<Component> components;
    };

    static std::string_view record(UniversalText& text);
    static std::vector<double> reals(UniversalText& text, std::size_t count);
    static void set_frequency(const UniversalText& text, long long analysis, const std::vector<double>& reals, Mode& mode);
    void read_shape(UniversalText& text, std::size_t per_node, bool is_complex, double lengths, Mode& mode);

    Remarks& remarks_;
    std::vector<Mode> modes_;
    std::vector<std::pair<long long, std::size_t>> freedoms_;  ///< node, direction from 0
    std::map<long long, std::size_t> first_of_;                ///< of the six freedoms of a node
};

std::string_view ModeCollector::record(UniversalText& text) {
    if (text.is_at_end() || is_universal_mark(text.peek()))
        text.fail("data set 55 ends within its head or within a node: the file is cut off or damaged: export it again");
    return text.next();
}

/// Of as many lines as it takes.
std::vector<double> ModeCollector::reals(UniversalText& text, std::size_t count) {
    constexpr std::size_t kWidth[] = {13};
    std::vector<double> numbers;
    while (numbers.size() < count)
        if (const auto bad = append_fortran_reals(record(text), kWidth, numbers))
            text.fail(fmt::format("{} is no number: mend it, or export the file again", quote(*bad)));
    if (numbers.size() > count || !std::ranges::all_of(numbers, [](double number) { return std::isfinite(number); }))
        text.fail(fmt::format("{} must stand here: the file is damaged", counted(count, "finite number", "finite numbers")));
    return numbers;
}

void ModeCollector::set_frequency(const UniversalText& text, long long analysis, const std::vector<double>& reals,
                                  Mode& mode) {
    constexpr double kNoDamping = std::numeric_limits<double>::quiet_NaN();
    if (analysis == 2) {
        mode.mode.frequency = reals.at(0);
        const double viscous = reals.size() > 2 ? reals[2] : 0, hysteretic = reals.size() > 3 ? reals[3] : 0;
        mode.mode.damping = viscous != 0 ? viscous : hysteretic != 0 ? hysteretic / 2 : kNoDamping;
        if (mode.mode.frequency < 0) text.fail("a natural frequency is below 0: the file is damaged");
        return;
    }
    // eigenvalue = -zeta omega + i omega sqrt(1 - zeta^2)
    const std::complex<double> eigenvalue(reals.at(0), reals.at(1));
    mode.mode.frequency = std::abs(eigenvalue) / (2 * std::numbers::pi);
    mode.mode.damping = -eigenvalue.real() / std::abs(eigenvalue);
    mode.is_conjugate = eigenvalue.imag() < 0;
}

void ModeCollector::read_shape(UniversalText& text, std::size_t per_node, bool is_complex, double lengths, Mode& mode) {
    std::map<long long, bool> seen;
    for (text.skip_blank(); !text.is_at_end() && !is_universal_mark(text.peek()); text.skip_blank()) {
        const std::vector<long long> label = universal_wholes(text, text.next());
        const long long node = label.front();
        if (!seen.emplace(node, true).second)
            text.fail(fmt::format("node {} comes twice in a mode: the file is damaged", node));
        const auto [known, is_new] = first_of_.emplace(node, freedoms_.size());
        for (std::size_t d = 0; d < 6 && is_new; ++d) freedoms_.emplace_back(node, d);
        const std::vector<double> numbers = reals(text, per_node * (is_complex ? 2 : 1));
        for (std::size_t d = 0; d < per_node; ++d) {
            std::complex<double> value = is_complex ? std::complex(numbers[2 * d], numbers[2 * d + 1]) : numbers[d];
            if (d < 3) value /= lengths;
            mode.components.push_back({known->second + d, mode.is_conjugate ? std::conj(value) : value});
        }
    }
}

void ModeCollector::read(UniversalText& text, double lengths) {
    Mode mode;
    mode.mode.place = text.place();
    for (int i = 1; i <= 5; ++i) record(text);
    const std::vector<long long> form = universal_wholes(text, record(text));
    if (form.size() < 6) text.fail("record 6 of data set 55 must hold six whole numbers: the file is damaged");
    const long long analysis = form[1], type = form[4], per_node = form[5];
    const bool is_mode = analysis == 2 || analysis == 3 || analysis == 7;
    if (!is_mode || (type != 2 && type != 5) || (per_node != 3 && per_node != 6)) {
        remarks_.add(
            mode.mode.place,
            fmt::format("data set 55 is skipped: its analysis type is {}, its data type {}, with {} per node; modes "
                        "have 2, 3 or 7, then 2 or 5, and 3 or 6 values",
                        analysis, type, counted(as_size(std::max(per_node, 0LL)), "value", "values")));
        while (!text.is_at_end() && !is_universal_mark(text.peek())) text.next();
        return;
    }
    std::vector<long long> wholes = universal_wholes(text, record(text));
    if (wholes.size() < 4 || wholes[1] < (analysis == 2 ? 1 : 2) || wholes[1] > 100)
        text.fail(
            "record 7 of data set 55 must hold the counts of whole and real numbers, load case and mode: the file is "
            "damaged");
    mode.mode.number = wholes[3] > 0 && wholes[3] < std::numeric_limits<int>::max() ? as_int(wholes[3]) : 0;
    set_frequency(text, analysis, reals(text, as_size(wholes[1])), mode);
    read_shape(text, as_size(per_node), type == 5, lengths, mode);
    if (mode.mode.frequency > 0)
        modes_.push_back(std::move(mode));
    else
        remarks_.add(mode.mode.place, "left out: a mode of 0 Hz, which moves the machine as a rigid body");
}

void ModeCollector::finish(Measurement& measurement) {
    std::vector<bool> is_given(freedoms_.size()), is_moved(freedoms_.size());
    std::size_t components = 0;
    for (const Mode& mode : modes_)
        for (const auto& [freedom, value] : mode.components) {
            is_given[freedom] = true;
            if (value != 0.0) is_moved[freedom] = true;
            ++components;
        }
    constexpr const char* kDirections[] = {"x", "y", "z", "rx", "ry", "rz"};
    std::vector<std::size_t> index(freedoms_.size());
    std::size_t at_rest = 0;
    for (std::size_t f = 0; f < freedoms_.size(); ++f) {
        if (is_given[f] && !is_moved[f]) ++at_rest;
        if (!is_moved[f]) continue;
        index[f] = measurement.shape_names.size();
        measurement.shape_names.push_back(fmt::format("{}.{}", freedoms_[f].first, kDirections[freedoms_[f].second]));
    }
    if (at_rest > 0)
        remarks_.add("",
                     fmt::format("left out of the shapes: {} 0 in every mode, which says that nothing was measured there",
                                 at_rest == 1 ? "1 component is" : fmt::format("{} components are", at_rest)));
    // Modes at places that are all different would take memory that grows with the square of the file
    constexpr std::size_t kSpare = 1'000'000, kMostPerComponent = 20;
    if (modes_.size() * measurement.shape_names.size() > kSpare + kMostPerComponent * components)
        throw Error(ExitCode::input_output, fmt::format("{}: its {} have hardly a node in common: split the file",
                                                        modes_.front().mode.place, counted(modes_.size(), "mode", "modes")));
    for (Mode& mode : modes_) {
        mode.mode.shape.assign(measurement.shape_names.size(), {std::numeric_limits<double>::quiet_NaN(), 0});
        for (const auto& [freedom, value] : mode.components)
            if (is_moved[freedom]) mode.mode.shape[index[freedom]] = value;
        measurement.modes.push_back(std::move(mode.mode));
    }
}

/// Data sets one after another.
class UniversalReader {
public:
    UniversalReader(const std::filesystem::path& file, std::string_view bytes) : text_(file, bytes), modes_(remarks_) {}
    Measurement read();

private:
    void read_set(std::string_view number_line);
    void take_mark(const std::string& place, long long number);
    void read_factors();
    void count_nodes(long long number, const std::string& place);
    Measurement finish();

    UniversalText text_;
    Remarks remarks_;
    ModeCollector modes_;
    Measurement found_;
    std::optional<UniversalFactors> factors_;
    std::map<long long, std::size_t> sets_;     ///< how many there are by number
    std::set<long long> nodes_, turned_nodes_;  ///< labels; turned: with axes of their own for displacements
};

/// The number of a data set: up to six digits, and b with its fields behind it. None: the line is something else.
std::optional<long long> universal_set_number(std::string_view line) {
    const std::size_t begin = line.find_first_not_of(" \t");
    if (begin == line.npos) return std::nullopt;
    const std::size_t end = std::min(line.find_first_not_of("0123456789", begin), line.size());
    if (end == begin || end - begin > 6) return std::nullopt;
    const std::string_view behind = line.substr(end);
    const bool is_binary = behind.starts_with('b') || behind.starts_with('B');
    if (!is_binary && behind.find_first_not_of(" \t") != behind.npos) return std::nullopt;
    return parse_fortran_whole(line.substr(begin, end - begin));
}

void UniversalReader::take_mark(const std::string& place, long long number) {
    while (!text_.is_at_end())
        if (is_universal_mark(text_.next())) return;
    throw Error(ExitCode::input_output,
                fmt::format("{}: data set {} has no end line (-1): the file is cut off: export it again", place, number));
}

void UniversalReader::read_factors() {
    const auto record = [&] {
        if (text_.is_at_end() || is_universal_mark(text_.peek()))
            text_.fail("data set 164 ends before its factors: the file is cut off or damaged: export it again");
        return text_.next();
    };
    record();
    constexpr std::size_t kWidth[] = {25};
    std::vector<double> numbers;
    while (numbers.size() < 2)
        if (const auto bad = append_fortran_reals(record(), kWidth, numbers))
            text_.fail(fmt::format("{} is no number: mend it, or export the file again", quote(*bad)));
    for (const double factor : {numbers[0], numbers[1]})
        if (!(factor > 0) || !std::isfinite(factor))
            text_.fail(fmt::format("a factor of data set 164 is {}: it must be above 0", number_text(factor)));
    factors_ = {numbers[0], numbers[1]};
}

/// Data sets 15, a line per node, and 2411, two lines per node.
void UniversalReader::count_nodes(long long number, const std::string& place) {
    while (!text_.is_at_end() && !is_universal_mark(text_.peek())) {
        const std::string_view line = text_.next();
        if (line.find_first_not_of(" \t") == line.npos) continue;
        if (number == 2411) {
            if (text_.is_at_end() || is_universal_mark(text_.peek()))
                throw Error(ExitCode::input_output,
                            fmt::format("{}: data set 2411 ends within a node: the file is cut off or damaged", place));
            text_.next();
        }
        const auto field = [&](std::size_t first) {
            return parse_fortran_whole(line.substr(std::min(first, line.size()), 10)).value_or(0);
        };
        nodes_.insert(field(0));
        if (field(20) != 0) turned_nodes_.insert(field(0));
    }
}

void UniversalReader::read_set(std::string_view number_line) {
    const auto number = universal_set_number(number_line);
    if (!number) text_.fail(fmt::format("{} is no number of a data set: the file is damaged", quote(number_line)));
    ++sets_[*number];
    const std::string place = text_.place();
    if (*number == 58) {
        if (auto signal = read_universal_function(text_, number_line, factors_, remarks_))
            found_.signals.push_back(std::move(*signal));
        return;
    }
    if (*number == 55) modes_.read(text_, factors_.value_or(UniversalFactors()).length);
    if (*number == 164) read_factors();
    if (*number == 15 || *number == 2411) count_nodes(*number, place);
    take_mark(place, *number);
}

Measurement UniversalReader::read() {
    found_.format = "universal file";
    std::size_t stray = 0;
    bool is_behind_set = false;
    for (text_.skip_blank(); !text_.is_at_end(); text_.skip_blank()) {
        const std::string_view line = text_.next();
        const bool is_mark = is_universal_mark(line);
        if (!is_mark && is_behind_set && universal_set_number(line)) {
            remarks_.add(text_.place(),
                         "one line -1 parts two data sets: it is taken for the end of one and the begin of the other");
            read_set(line);
        } else if (!is_mark) {
            ++stray;
            is_behind_set = false;
        } else if (text_.skip_blank(); text_.is_at_end()) {
            remarks_.add(text_.place(), "the file ends where a data set should begin: it may be cut off");
        } else if (!is_universal_mark(text_.peek())) {
            read_set(text_.next());
            is_behind_set = true;
        }
    }
    modes_.finish(found_);
    if (stray > 0) remarks_.add("", fmt::format("skipped: {} between data sets", counted(stray, "line", "lines")));
    return finish();
}

/// Notes of what was not used. Throws if nothing was.
Measurement UniversalReader::finish() {
    if (!nodes_.empty()) remarks_.add("", fmt::format("not used: {}", counted(nodes_.size(), "node", "nodes")));
    if (!turned_nodes_.empty())
        remarks_.add(
            "", fmt::format("{} with axes of their own for displacements: directions there may not be those of the machine",
                            counted(turned_nodes_.size(), "node", "nodes")));
    std::vector<std::string> all;
    for (const auto& [number, count] : sets_) {
        all.push_back(fmt::format("{} ({})", number, count));
        if (number != 15 && number != 55 && number != 58 && number != 151 && number != 164 && number != 2411)
            remarks_.add("",
                         fmt::format("skipped: data set {}{}", number, count > 1 ? fmt::format(", {} times", count) : ""));
    }
    found_.notes = remarks_.notes();
    if (!found_.signals.empty() || !found_.modes.empty()) return std::move(found_);
    std::string text = fmt::format("{}: there is no function (data set 58) and no mode (55) that can be used", text_.file());
    text += all.empty() ? "; it has no data set" : fmt::format("; it has data sets {}", listed(all));
    if (!found_.notes.empty()) text += fmt::format("; {}", listed(found_.notes));
    throw Error(ExitCode::input_output, text);
}

}  // namespace

Measurement read_universal(const std::filesystem::path& file) {
    std::error_code fault;
    if (const auto size = std::filesystem::file_size(file, fault); !fault && size > kLargestUniversal)
        throw Error(ExitCode::input_output, fmt::format("{}: is larger than 4 GiB: split it", file.string()));
    const std::string bytes = read_whole_file(file);
    return UniversalReader(file, bytes).read();
}

}  // namespace dttmm::host
