// SPDX-License-Identifier: BSD-3-Clause
#include "measured/mat_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "measured/mat_arrays.h"
#include "measured/remarks.h"
#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

using SignalKind = MeasuredSignal::Kind;

std::string lower_case(std::string_view text) {
    std::string lower(text);
    for (char& c : lower) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
    return lower;
}

/// "time_s" of "run(2).Time_s".
std::string last_part(const std::string& name) {
    const std::size_t dot = name.rfind('.');
    return lower_case(dot == name.npos ? name : name.substr(dot + 1));
}

/// "run(2)" of "run(2).Time"; empty for a variable that is in no struct.
std::string_view struct_of(std::string_view name) {
    const std::size_t dot = name.rfind('.');
    return dot == name.npos ? std::string_view() : name.substr(0, dot);
}

std::string without_ending(const std::string& name, std::initializer_list<const char*> endings) {
    for (const std::string_view ending : endings)
        if (name.ends_with(ending)) return name.substr(0, name.size() - ending.size());
    return name;
}

bool is_called(const std::string& name, std::initializer_list<const char*> names) {
    return std::ranges::find(names, name) != names.end();
}

bool has_any(const std::string& name, std::initializer_list<const char*> parts) {
    return std::ranges::any_of(parts, [&](const char* part) { return name.find(part) != name.npos; });
}

bool is_real_vector(const MatArray& array) {
    return array.of == MatArray::Of::numbers && !array.is_complex() && array.is_vector() &&
           std::ranges::all_of(array.real, [](double value) { return std::isfinite(value); });
}

bool is_even(const std::vector<double>& values) {
    if (values.size() < 3) return false;
    constexpr double kShare = 1e-6;  // natural frequencies are not at equal distances to six digits
    const double step = values[1] - values[0];
    for (std::size_t i = 2; i < values.size(); ++i)
        if (std::abs(values[i] - values[i - 1] - step) > kShare * std::abs(step)) return false;
    return true;
}

bool is_coherence_name(const std::string& name) {
    return std::ranges::any_of(
        std::initializer_list<std::string>{"coherence", "coh", "gamma2"},
        [&](const std::string& word) { return name == word || name.starts_with(word + "_") || name.ends_with("_" + word); });
}

struct MatAbscissa {
    std::size_t array;
    bool is_time;
};

/// Decides what the arrays of a file are.
class MatMeasurement {
public:
    MatMeasurement(const std::filesystem::path& file, std::vector<MatArray> arrays)
        : file_(file.string()), arrays_(std::move(arrays)), is_used_(arrays_.size()) {
        for (std::size_t i = 0; i < arrays_.size(); ++i) index_.emplace(arrays_[i].name, i);
    }
    Measurement read();

private:
    std::string place(const std::string& name) const { return fmt::format("{}: {}", file_, name); }
    const MatArray* find(const std::string& name) const;
    bool read_own_curves();
    void read_own_curve(const std::map<std::string, std::string>& channel);
    std::optional<std::pair<std::size_t, std::size_t>> choose_modes();
    void read_modes();
    std::vector<double> find_damping(std::size_t frequencies);
    void find_abscissae();
    std::optional<MatAbscissa> abscissa_of(const MatArray& array);
    void read_signals(const MatArray& array, const MatAbscissa& abscissa);
    void add(MeasuredSignal signal, const std::vector<double>& abscissa);
    void note_rest();

    std::string file_;
    std::vector<MatArray> arrays_;
    std::vector<bool> is_used_;
    using Scope = std::pair<std::string, std::size_t>;  ///< a struct, and how many numbers
    std::map<Scope, std::vector<MatAbscissa>> near_abscissae_;
    std::map<std::size_t, std::vector<MatAbscissa>> abscissae_;  ///< of all structs, by how many numbers they have
    std::unordered_map<std::string, std::size_t> index_;         ///< of arrays by their names
    Remarks remarks_;
    Measurement found_;
};

const MatArray* MatMeasurement::find(const std::string& name) const {
    const auto found = index_.find(name);
    return found == index_.end() ? nullptr : &arrays_[found->second];
}

/// Leaves out points that are not finite. The imaginary part is empty for real values.
void MatMeasurement::add(MeasuredSignal signal, const std::vector<double>& abscissa) {
    std::vector<double> real, imaginary;
    for (std::size_t i = 0; i < abscissa.size(); ++i) {
        const double other = signal.imaginary.empty() ? 0 : signal.imaginary[i];
        if (!std::isfinite(abscissa[i]) || !std::isfinite(signal.values[i]) || !std::isfinite(other)) continue;
        signal.abscissa.push_back(abscissa[i]);
        real.push_back(signal.values[i]);
        if (!signal.imaginary.empty()) imaginary.push_back(other);
    }
    signal.values = std::move(real);
    signal.imaginary = std::move(imaginary);
    if (const std::size_t missing = abscissa.size() - signal.values.size())
        remarks_.add(signal.place, fmt::format("left out: {} without a finite value", counted(missing, "point", "points")));
    if (!signal.values.empty()) found_.signals.push_back(std::move(signal));
}

/// Files of `dttmm export --mat`: the struct array "channels" says what the curves are.
bool MatMeasurement::read_own_curves() {
    std::vector<std::map<std::string, std::string>> channels;
    std::string_view before;
    for (const MatArray& array : arrays_) {
        const std::string_view element = struct_of(array.name);
        if (array.of != MatArray::Of::text || (element != "channels" && !element.starts_with("channels("))) continue;
        if (channels.empty() || element != before) channels.emplace_back();
        before = element;
        channels.back()[array.name.substr(element.size() + 1)] = array.text;
    }
    std::erase_if(channels, [](const auto& channel) {
        return !channel.contains("name") || !channel.contains("variable") || !channel.contains("over");
    });
    const bool is_own = !channels.empty() || (find("kind") && find("version") && find("model_text") && find("command_line"));
    for (const auto& channel : channels) read_own_curve(channel);
    for (std::size_t i = 0; i < arrays_.size() && is_own; ++i)
        if (arrays_[i].of == MatArray::Of::text) is_used_[i] = true;
    return is_own;
}

void MatMeasurement::read_own_curve(const std::map<std::string, std::string>& channel) {
    const MatArray *curve = find(channel.at("variable")), *over = find(channel.at("over"));
    const bool is_whole = curve && over && curve->of == MatArray::Of::numbers && is_real_vector(*over) &&
                          curve->is_vector() && curve->count() == over->count();
    if (!is_whole)
        throw Error(
            ExitCode::input_output,
            fmt::format("{}: the variables {} and {} of the channel {} must be vectors of one length: the file is damaged",
                        file_, quote(channel.at("variable")), quote(channel.at("over")), quote(channel.at("name"))));
    const auto text = [&](const char* name) { return channel.contains(name) ? channel.at(name) : std::string(); };
    MeasuredSignal signal;
    signal.name = channel.at("name");
    signal.unit = text("unit");
    signal.place = place(curve->name);
    signal.values = curve->real;
    signal.imaginary = curve->imaginary;
    const std::string unit = text("over_unit");
    if (unit == "s" && !curve->is_complex()) signal.kind = SignalKind::history;
    if (unit == "Hz" && curve->is_complex()) signal.kind = SignalKind::response;
    if (unit != "s" && unit != "Hz")
        remarks_.add(signal.place, fmt::format("it is over {} in {}, which is neither time nor frequency", quote(over->name),
                                               quote(unit)));
    is_used_[as_size(curve - arrays_.data())] = true;
    is_used_[as_size(over - arrays_.data())] = true;
    add(std::move(signal), over->real);
}

/// Damping ratios as many as frequencies; none: empty.
std::vector<double> MatMeasurement::find_damping(std::size_t frequencies) {
    const MatArray& frequency = arrays_[frequencies];
    for (std::size_t i = 0; i < arrays_.size(); ++i) {
        if (is_used_[i] || !is_real_vector(arrays_[i]) || arrays_[i].count() != frequency.count() ||
            struct_of(arrays_[i].name) != struct_of(frequency.name) ||
            !has_any(last_part(arrays_[i].name), {"damp", "zeta"}))
            continue;
        is_used_[i] = true;
        if (std::ranges::all_of(arrays_[i].real, [](double ratio) { return ratio >= 0 && ratio < 1; }))
            return arrays_[i].real;
        remarks_.add(place(arrays_[i].name), "not used: these are no damping ratios, which are from 0 to 1");
        return {};
    }
    return {};
}

/// The vector of frequencies and the matrix of shapes whose names are most alike but for what they are called by.
std::optional<std::pair<std::size_t, std::size_t>> MatMeasurement::choose_modes() {
    const auto stem = [](std::string name) {
        for (const std::string_view word :
             {"frequencies", "frequency", "freq", "modes", "mode", "shapes", "shape", "phi", "psi"})
            if (const std::size_t at = name.find(word); at != name.npos) name.erase(at, word.size());
        return name;
    };
    std::map<Scope, std::vector<std::size_t>> frequencies;
    for (std::size_t f = 0; f < arrays_.size(); ++f)
        if (has_any(last_part(arrays_[f].name), {"freq"}) && is_real_vector(arrays_[f]) && !is_even(arrays_[f].real))
            frequencies[{std::string(struct_of(arrays_[f].name)), arrays_[f].count()}].push_back(f);
    std::optional<std::pair<std::size_t, std::size_t>> best;
    int least = 0;
    std::size_t pairs = 0;
    for (std::size_t s = 0; s < arrays_.size(); ++s) {
        const MatArray& shape = arrays_[s];
        if (shape.of != MatArray::Of::numbers || shape.sizes.size() != 2 || shape.sizes[0] < 2 || shape.sizes[1] == 0 ||
            !has_any(last_part(shape.name), {"mode", "shape", "phi", "psi"}))
            continue;
        constexpr std::size_t kMost = 16;  // in one struct; more are no modes, and their pairs would take long
        const auto found = frequencies.find({std::string(struct_of(shape.name)), shape.sizes[1]});
        for (std::size_t i = 0; found != frequencies.end() && i < std::min(found->second.size(), kMost); ++i) {
            const std::size_t f = found->second[i];
            if (f == s) continue;
            ++pairs;
            const int distance = compute_edit_distance(stem(last_part(shape.name)), stem(last_part(arrays_[f].name)));
            if (best && distance >= least) continue;
            least = distance;
            best = {f, s};
        }
    }
    if (pairs > 1)
        remarks_.add("", fmt::format("there are several frequencies and shapes that fit: modes are {} and {}",
                                     quote(arrays_[best->first].name), quote(arrays_[best->second].name)));
    return best;
}

void MatMeasurement::read_modes() {
    const auto chosen = choose_modes();
    if (!chosen) return;
    const auto [f, s] = *chosen;
    is_used_[f] = is_used_[s] = true;
    const MatArray &frequency = arrays_[f], &shape = arrays_[s];
    const std::vector<double> damping = find_damping(f);
    const std::size_t rows = shape.sizes[0];
    for (std::size_t row = 0; row < rows; ++row) found_.shape_names.push_back(fmt::format("{}({})", shape.name, row + 1));
    for (std::size_t m = 0; m < frequency.count(); ++m) {
        MeasuredMode mode;
        mode.frequency = frequency.real[m];
        mode.damping = damping.empty() ? std::numeric_limits<double>::quiet_NaN() : damping[m];
        mode.place = place(fmt::format("{}(:,{})", shape.name, m + 1));
        for (std::size_t row = 0; row < rows; ++row)
            mode.shape.emplace_back(shape.real[m * rows + row], shape.is_complex() ? shape.imaginary[m * rows + row] : 0);
        if (mode.frequency > 0)
            found_.modes.push_back(std::move(mode));
        else
            remarks_.add(mode.place, "left out: a natural frequency must be above 0");
    }
}

void MatMeasurement::find_abscissae() {
    for (std::size_t i = 0; i < arrays_.size(); ++i) {
        const MatArray& array = arrays_[i];
        const std::string name = last_part(array.name);
        const bool is_time = is_called(without_ending(name, {"_s", "_sec"}), {"t", "time"});
        const bool is_frequency = is_called(without_ending(name, {"_hz"}), {"f", "freq", "frequency"});
        if (is_used_[i] || (!is_time && !is_frequency) || !is_real_vector(array) || array.count() < 2) continue;
        if (std::ranges::adjacent_find(array.real, std::greater_equal<>()) != array.real.end()) continue;
        near_abscissae_[{std::string(struct_of(array.name)), array.count()}].push_back({i, is_time});
        abscissae_[array.count()].push_back({i, is_time});
    }
    for (const auto& [count, abscissae] : abscissae_)
        for (const MatAbscissa& abscissa : abscissae) is_used_[abscissa.array] = true;
}

/// The abscissa as long as a dimension of the array: of its own struct, of the nearest around it, or the only one there is.
std::optional<MatAbscissa> MatMeasurement::abscissa_of(const MatArray& array) {
    std::vector<std::size_t> lengths = {array.sizes.front()};
    if (array.sizes.back() != lengths[0]) lengths.push_back(array.sizes.back());
    std::vector<MatAbscissa> near, any;
    const auto gather = [](const auto& all, const auto& key, std::vector<MatAbscissa>& found) {
        if (const auto one = all.find(key); one != all.end())
            found.insert(found.end(), one->second.begin(), one->second.end());
    };
    for (std::string_view scope = array.name; near.empty() && !scope.empty();) {
        scope = struct_of(scope);
        for (const std::size_t length : lengths) gather(near_abscissae_, Scope(scope, length), near);
    }
    for (std::size_t i = 0; near.empty() && i < lengths.size(); ++i) gather(abscissae_, lengths[i], any);
    if (any.size() == 1) return any.front();
    if (near.empty()) return std::nullopt;
    const bool wants_frequency = array.is_complex() || is_coherence_name(last_part(array.name));
    const auto wanted = std::ranges::find(near, !wants_frequency, &MatAbscissa::is_time);
    const MatAbscissa& chosen = wanted == near.end() ? near.front() : *wanted;
    if (near.size() > 1)
        remarks_.add(place(array.name),
                     fmt::format("several abscissae are as long: {} is taken", quote(arrays_[chosen.array].name)));
    return chosen;
}

/// A signal per column: along the first dimension, or along the last.
void MatMeasurement::read_signals(const MatArray& array, const MatAbscissa& abscissa) {
    const std::vector<double>& x = arrays_[abscissa.array].real;
    const bool is_along_first = array.sizes.front() == x.size();
    const std::size_t columns = array.count() / x.size();
    std::vector<std::size_t> others(array.sizes.begin() + (is_along_first ? 1 : 0),
                                    array.sizes.end() - (is_along_first ? 0 : 1));
    for (std::size_t c = 0; c < columns; ++c) {
        MeasuredSignal signal;
        std::vector<std::size_t> subscripts;
        for (std::size_t rest = c; const std::size_t length : others) {
            subscripts.push_back(rest % length + 1);
            rest /= length;
        }
        signal.name = columns == 1 ? array.name : fmt::format("{}({})", array.name, fmt::join(subscripts, ","));
        signal.place = place(signal.name);
        const bool is_coherence = is_coherence_name(last_part(array.name)) && !array.is_complex();
        if (abscissa.is_time && !array.is_complex()) signal.kind = SignalKind::history;
        if (!abscissa.is_time && is_coherence) signal.kind = SignalKind::coherence;
        if (!abscissa.is_time && array.is_complex()) signal.kind = SignalKind::response;
        if (signal.kind == SignalKind::other)
            remarks_.add(signal.place, abscissa.is_time ? "it is complex over time: it is not taken for a history"
                                                        : "it is real over frequency: it is not taken for a response");
        for (std::size_t i = 0; i < x.size(); ++i) {
            const std::size_t at = is_along_first ? c * x.size() + i : i * columns + c;
            signal.values.push_back(array.real[at]);
            if (array.is_complex()) signal.imaginary.push_back(array.imaginary[at]);
        }
        add(std::move(signal), x);
    }
}

/// "not used: fs 1x1, g 3x3" and "not read: title (char)".
void MatMeasurement::note_rest() {
    std::vector<std::string> unused, unread;
    std::set<std::string> seen;
    for (std::size_t i = 0; i < arrays_.size(); ++i) {
        const MatArray& array = arrays_[i];
        std::string name = array.name;  // elements of a struct array are named once
        for (std::size_t open = name.find('('); open != name.npos; open = name.find('(', open))
            name.erase(open, name.find(')', open) - open + 1);
        if (is_used_[i] || !seen.insert(name).second) continue;
        if (array.of == MatArray::Of::numbers)
            unused.push_back(fmt::format("{} {}", printable(name), array.sizes_text()));
        else
            unread.push_back(fmt::format("{} ({})", printable(name), array.kind));
    }
    if (!unused.empty()) remarks_.add("", "not used: " + listed(unused));
    if (!unread.empty()) remarks_.add("", "not read: " + listed(unread));
}

Measurement MatMeasurement::read() {
    found_.format = "MAT file";
    const bool is_own = read_own_curves();
    if (!is_own) {
        read_modes();
        find_abscissae();
        for (std::size_t i = 0; i < arrays_.size(); ++i) {
            if (is_used_[i] || arrays_[i].of != MatArray::Of::numbers || arrays_[i].count() == 0) continue;
            const auto abscissa = abscissa_of(arrays_[i]);
            if (!abscissa) continue;
            constexpr std::size_t kMostSignals = 200'000;  // a few hundred bytes each beside their numbers
            if (arrays_[i].count() / arrays_[abscissa->array].count() > kMostSignals - found_.signals.size()) {
                remarks_.add(place(arrays_[i].name), "has more columns than measurements have signals");
                continue;
            }
            is_used_[i] = true;
            read_signals(arrays_[i], *abscissa);
        }
    }
    note_rest();
    found_.notes = remarks_.notes();
    if (!found_.signals.empty() || !found_.modes.empty()) return std::move(found_);
    std::vector<std::string> all;
    for (const MatArray& array : arrays_)
        all.push_back(fmt::format("{} {} {}", printable(array.name), array.sizes_text(), array.kind));
    throw Error(
        ExitCode::input_output,
        fmt::format("{}: nothing in it can be used: {}; it has {}", file_,
                    is_own ? "these results of dttmm have no curves: read their CSV files, or export them with --uff55"
                           : "a vector called time or frequency and variables as long are wanted, or natural frequencies "
                             "(freq) and mode shapes (mode, shape, phi, psi) with a column for each",
                    all.empty() ? "no variable" : listed(all)));
}

}  // namespace

Measurement read_mat(const std::filesystem::path& file) { return MatMeasurement(file, read_mat_arrays(file)).read(); }

}  // namespace dttmm::host
