// SPDX-License-Identifier: BSD-3-Clause
#include "report/universal_results.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "report/structure.h"
#include "report/universal_file.h"

namespace dttmm::host {

namespace {

/// A unit of channels: what it measures, and the exponents of length and force in it.
struct UniversalUnit {
    const char* unit;
    UniversalQuantity quantity;
    int length, force;
};

constexpr UniversalUnit kUnits[] = {{"m", UniversalQuantity::displacement, 1, 0},
                                    {"rad", UniversalQuantity::displacement, 0, 0},
                                    {"m/s", UniversalQuantity::velocity, 1, 0},
                                    {"rad/s", UniversalQuantity::velocity, 0, 0},
                                    {"m/s^2", UniversalQuantity::acceleration, 1, 0},
                                    {"rad/s^2", UniversalQuantity::acceleration, 0, 0},
                                    {"N", UniversalQuantity::force, 0, 1},
                                    {"N*m", UniversalQuantity::force, 1, 1},
                                    {"Pa", UniversalQuantity::stress, -2, 1},
                                    {"J", UniversalQuantity::general, 1, 1},
                                    {"N/m", UniversalQuantity::general, -1, 1},
                                    {"1", UniversalQuantity::general, 0, 0}};

/// Quantities of a place along and about its axes, as channels call them.
constexpr const char* kAlong[] = {"position", "velocity", "acceleration", "reaction"};
constexpr const char* kAbout[] = {"rotation", "angular_velocity", "angular_acceleration", "reaction_moment"};

constexpr const char* kDirections[] = {"x", "y", "z", "rx", "ry", "rz"};

UniversalAxis axis_of(const std::string& label, const std::string& unit, const std::string& shown) {
    for (const UniversalUnit& one : kUnits)
        if (unit == one.unit) return {one.quantity, {one.length, one.force, 0}, label, shown};
    return {UniversalQuantity::general, {0, 0, 0}, label, shown};
}

/// Time, frequency or speed; nothing else is an abscissa.
std::optional<UniversalAxis> abscissa_of(const Column& x) {
    if (x.unit == "s") return UniversalAxis{UniversalQuantity::time, {0, 0, 0}, "Time", "s"};
    if (x.unit == "Hz") return UniversalAxis{UniversalQuantity::frequency, {0, 0, 0}, "Frequency", "Hz"};
    if (x.unit == "rpm") return UniversalAxis{UniversalQuantity::rpm, {0, 0, 0}, "Speed", "rpm"};
    return {};
}

/// "m/N" of a unit input: "m" and "N".
std::optional<std::pair<std::string, std::string>> split_unit(const std::string& unit) {
    for (const auto& [ending, per] :
         {std::pair("/N", "N"), std::pair("/(N*m)", "N*m"), std::pair("/m", "m"), std::pair("/rad", "rad")})
        if (unit.ends_with(ending)) return std::pair(unit.substr(0, unit.size() - std::string_view(ending).size()), per);
    return {};
}

/// "(m)^2/Hz": "m". Empty for other units.
std::string unit_of_density(const std::string& unit) {
    constexpr std::string_view kEnding = ")^2/Hz";
    if (!unit.starts_with('(') || !unit.ends_with(kEnding)) return {};
    return unit.substr(1, unit.size() - 1 - kEnding.size());
}

/// Degrees of freedom by the names of channels and inputs.
class DegreeTable {
public:
    explicit DegreeTable(const Structure& structure) {
        for (std::size_t p = 0; p < structure.places().size(); ++p) {
            const std::string& place = structure.places()[p].name;
            for (int axis = 0; axis < 3; ++axis) {
                for (const char* quantity : kAlong) add(place + "." + quantity, p, place, axis, axis);
                for (const char* quantity : kAbout) add(place + "." + quantity, p, place, axis, axis + 3);
            }
            for (int d = 0; d < 6; ++d)
                degrees_[fmt::format("{}.{}", place, kDirections[d])] = {place, as_int(p) + 1, d + 1};
        }
        for (const ElementLine& element : structure.elements()) elements_.push_back(element.name);
        std::ranges::sort(elements_);
    }

    /// Of a channel "plate.left.position.x" or an input "plate.left.z". Of an element only its name; else nothing.
    UniversalDegree find(const std::string& name) const {
        if (const auto found = degrees_.find(name); found != degrees_.end()) return found->second;
        const std::string owner = name.substr(0, name.find('.'));
        return std::ranges::binary_search(elements_, owner) ? UniversalDegree{owner, 0, 0} : UniversalDegree{};
    }

private:
    void add(const std::string& stem, std::size_t place, const std::string& name, int axis, int direction) {
        degrees_[fmt::format("{}.{}", stem, kDirections[axis])] = {name, as_int(place) + 1, direction + 1};
    }

    std::unordered_map<std::string, UniversalDegree> degrees_;
    std::vector<std::string> elements_;
};

/// "2026-11-25 08:03 UTC" as "25-Nov-26" and "08:03:00".
std::pair<std::string, std::string> universal_time(const std::string& written) {
    constexpr const char* kMonths[] = {"Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec"};
    if (written.size() < 16) return {"01-Jan-70", "00:00:00"};
    const int month = std::clamp(std::atoi(written.substr(5, 2).c_str()), 1, 12);
    return {written.substr(8, 2) + "-" + kMonths[month - 1] + "-" + written.substr(2, 2), written.substr(11, 5) + ":00"};
}

std::vector<UniversalNode> nodes_of(const Structure& structure) {
    std::vector<UniversalNode> nodes;
    for (const NamedPlace& place : structure.places())
        nodes.push_back({as_int(nodes.size()) + 1, structure.at_start(place.point)});
    return nodes;
}

void write_beginning(UniversalFile& file, const Results& results) {
    const auto [date, time] = universal_time(results.written);
    file.write_header(results.title, "results of dttmm " + results.kind, "dttmm " DTTMM_VERSION, date, time);
    file.write_units();
}

/// The unit inputs that a response has, as typed; none under the loads of the model.
std::vector<std::string> inputs_of(const Results& results) {
    std::vector<std::string> inputs;
    const Json::json_pointer at("/inputs/options/--in");
    if (results.summary.is_object() && results.summary.contains(at) && results.summary[at].is_array())
        for (const Json& one : results.summary[at])
            if (one.is_string()) inputs.push_back(one);
    return inputs;
}

/// Makes datasets 58 of curves.
class FunctionWriter {
public:
    FunctionWriter(const Results& results, UniversalFile& file)
        : results_(results), file_(file), structure_(results.model), degrees_(structure_), inputs_(inputs_of(results)) {
        const auto [date, time] = universal_time(results.written);
        date_ = date + " " + time;
        if (results.kind == "frf" && results.summary.contains("out") && results.summary["out"].is_string())
            frf_output_ = results.summary["out"];
    }

    const Structure& structure() const { return structure_; }
    void write(const CurveSet& set, const UniversalAxis& abscissa, const Curve& curve);
    std::string remarks() const;
    int written() const { return number_; }

private:
    void choose_function(const CurveSet& set, const Curve& curve, UniversalCurve& one) const;

    const Results& results_;
    UniversalFile& file_;
    Structure structure_;
    DegreeTable degrees_;
    std::vector<std::string> inputs_;
    std::string date_, frf_output_;
    int number_ = 0;
    std::size_t left_out_ = 0, merged_ = 0;  // of all curves, of the worst
};

void FunctionWriter::choose_function(const CurveSet& set, const Curve& curve, UniversalCurve& one) const {
    const auto& [name, unit] = curve.head;
    // A channel with several inputs is called "<channel>/<input>"
    std::string channel = name, input = inputs_.size() == 1 ? inputs_.front() : "";
    for (const std::string& each : inputs_)
        if (inputs_.size() > 1 && name.ends_with("/" + each)) {
            channel = name.substr(0, name.size() - each.size() - 1);
            input = each;
        }
    for (const char* ending : {".amplitude", ".psd"})
        if (channel.ends_with(ending)) channel.resize(channel.size() - std::string_view(ending).size());
    one.response = degrees_.find(frf_output_.empty() ? channel : frf_output_);
    one.numerator = axis_of(name, unit, unit);
    if (const std::string of_density = unit_of_density(unit); !of_density.empty()) {
        one.function = UniversalFunction::power_spectral_density;
        one.numerator = axis_of(name, of_density, unit);
        for (int& exponent : one.numerator.exponents) exponent *= 2;
    } else if (set.x.unit == "s" && one.complex.empty()) {
        one.function = UniversalFunction::time_response;
    } else if (!one.complex.empty()) {
        one.function = UniversalFunction::spectrum;
        if (input.empty()) return;
        one.reference = degrees_.find(input);
        if (const auto parts = split_unit(unit)) {
            one.function = UniversalFunction::frequency_response;
            one.numerator = axis_of(name, parts->first, parts->first);
            one.denominator = axis_of(input, parts->second, parts->second);
        } else if (unit == "1") {
            one.function = UniversalFunction::transmissibility;
        }
    }
}

void FunctionWriter::write(const CurveSet& set, const UniversalAxis& abscissa, const Curve& curve) {
    std::vector<double> real;
    std::vector<std::complex<double>> complex;
    UniversalCurve one;
    for (std::size_t i = 0; i < set.places.size(); ++i) {
        const std::complex<double> value = curve.complex_values.empty() ? curve.values[i] : curve.complex_values[i];
        if (!std::isfinite(value.real()) || !std::isfinite(value.imag()) || !std::isfinite(set.places[i])) {
            ++left_out_;
            continue;
        }
        one.places.push_back(set.places[i]);
        if (curve.complex_values.empty())
            real.push_back(value.real());
        else
            complex.push_back(value);
    }
    if (one.places.empty()) return;
    one.real = real;
    one.complex = complex;
    one.abscissa = abscissa;
    one.number = ++number_;
    choose_function(set, curve, one);
    one.lines = {fmt::format("{} [{}]", curve.head.name, curve.head.unit), results_.title, date_,
                 set.label.empty() ? set.file : set.file + ", " + set.label,
                 one.response.node == 0 ? "" : "node " + std::to_string(one.response.node) + " is " + one.response.name};
    if (!are_even(one.places)) merged_ = std::max(merged_, count_merged(one.places));
    file_.write(one);
}

std::string FunctionWriter::remarks() const {
    std::string text;
    if (left_out_ > 0) text += fmt::format("\nleft out: {} without a value", counted(left_out_, "point", "points"));
    if (merged_ > 0)
        text += fmt::format("\nabscissae have twelve characters in this format: {} of a curve {} that of the one before",
                            counted(merged_, "point", "points"), merged_ == 1 ? "has" : "have");
    return text;
}

/// Columns of a table by their names. Throws for one that is not there.
std::vector<std::size_t> need_columns(const CsvFile& file, const std::vector<std::string>& names) {
    std::vector<std::size_t> found;
    for (const std::string& name : names) {
        const int column = file.find(name);
        if (column < 0)
            throw Error(ExitCode::input_output,
                        fmt::format("{}: damaged: there is no column {}", file.path().string(), quote(name)));
        found.push_back(as_size(column));
    }
    return found;
}

/// What shapes.csv has of one mode: a row per station.
struct Stations {
    std::vector<std::string> elements;
    std::vector<Eigen::Vector3d> places;
    std::vector<std::array<double, 6>> shape;
};

/// By mode; every mode has the stations of the first, or none are taken.
std::vector<Stations> read_stations(const std::filesystem::path& path, std::size_t modes) {
    std::error_code fault;
    std::vector<Stations> all(modes);
    if (!std::filesystem::exists(path, fault)) return all;
    const CsvFile file(path);
    const std::vector<std::size_t> columns =
        need_columns(file, {"mode", "x", "y", "z", "ux", "uy", "uz", "urx", "ury", "urz", "element"});
    for (std::size_t row = 0; row < file.rows(); ++row) {
        const double mode = file.numbers(columns[0])[row];
        if (!(mode >= 1 && mode <= static_cast<double>(modes))) continue;
        Stations& one = all[static_cast<std::size_t>(mode) - 1];
        const auto number = [&](std::size_t c) { return file.numbers(columns[c])[row]; };
        one.elements.push_back(file.texts(columns[10])[row]);
        one.places.emplace_back(number(1), number(2), number(3));
        one.shape.push_back({number(4), number(5), number(6), number(7), number(8), number(9)});
    }
    for (const Stations& one : all)
        if (one.places.size() != all.front().places.size())
            throw Error(ExitCode::input_output, path.string() + ": damaged: modes have different numbers of rows");
    return all;
}

std::string described(const std::string& what, std::size_t places, std::size_t stations) {
    std::string text = fmt::format("{}, {}", what, counted(places, "node", "nodes"));
    if (stations > 0) text += fmt::format(" and {} of beams", counted(stations, "station", "stations"));
    return text;
}

/// damped.csv and damped_shapes.csv. Returns how many.
std::size_t write_damped(const Results& results, const Structure& structure, UniversalFile& file,
                         const std::array<std::string, 5>& lines) {
    std::error_code fault;
    const std::filesystem::path shapes_path = results.folder / "damped_shapes.csv";
    if (!std::filesystem::exists(shapes_path, fault)) return 0;
    const CsvFile table(results.folder / "damped.csv"), shapes(shapes_path);
    const std::vector<std::size_t> of_table = need_columns(table, {"damped_frequency", "damping_ratio", "decay"});
    std::vector<std::string> names = {"mode", "place"};
    for (const char* direction : kDirections)
        for (const char* part : {".re", ".im"}) names.push_back(std::string("u") + direction + part);
    const std::vector<std::size_t> columns = need_columns(shapes, names);
    std::vector<UniversalMode> modes(table.rows());
    for (std::size_t m = 0; m < modes.size(); ++m) {
        const double frequency = table.numbers(of_table[0])[m], ratio = table.numbers(of_table[1])[m];
        modes[m].lines = lines;
        modes[m].lines[0] = fmt::format("damped mode {}: {:.6g} Hz, damping ratio {:.4g}", m + 1, frequency, ratio);
        modes[m].lines[4] = "eigenvalue in 1/s; modal A and B are not known: 0";
        modes[m].number = as_int(m) + 1;
        modes[m].eigenvalue = {-table.numbers(of_table[2])[m], 2 * std::numbers::pi * frequency};
    }
    for (std::size_t row = 0; row < shapes.rows(); ++row) {
        const double mode = shapes.numbers(columns[0])[row];
        const int place = structure.find_place(shapes.texts(columns[1])[row]);
        if (!(mode >= 1 && mode <= static_cast<double>(modes.size())) || place < 0) continue;
        UniversalMode& one = modes[static_cast<std::size_t>(mode) - 1];
        one.labels.push_back(place + 1);
        std::array<std::complex<double>, 6>& u = one.complex.emplace_back();
        for (std::size_t d = 0; d < 6; ++d)
            u[d] = {shapes.numbers(columns[2 + 2 * d])[row], shapes.numbers(columns[3 + 2 * d])[row]};
    }
    for (const UniversalMode& one : modes)
        if (!one.labels.empty()) file.write(one);
    return modes.size();
}

}  // namespace

std::string write_functions(const Results& results, std::ostream& out) {
    UniversalFile file(out);
    FunctionWriter functions(results, file);
    write_beginning(file, results);
    const std::vector<UniversalNode> nodes = nodes_of(functions.structure());
    if (!nodes.empty()) file.write_nodes_2411(nodes);
    std::size_t others = 0;
    for (const CurveSet& set : results.sets) {
        const std::optional<UniversalAxis> abscissa = abscissa_of(set.x);
        for (const Curve& curve : set.curves)
            if (abscissa)
                functions.write(set, *abscissa, curve);
            else
                ++others;
    }
    if (functions.written() == 0)
        throw Error(ExitCode::usage,
                    fmt::format("--uff58: these results of dttmm {} have no curves over time, frequency or speed; --mat has "
                                "all that they have",
                                results.kind));
    std::string text =
        described(counted(as_size(functions.written()), "function", "functions"), nodes.size(), 0) + functions.remarks();
    if (others > 0) text += fmt::format("\nleft out: {} over a parameter", counted(others, "curve", "curves"));
    return text;
}

std::string write_modes(const Results& results, std::ostream& out) {
    if (results.kind != "modes")
        throw Error(ExitCode::usage, fmt::format("--uff55: these are results of dttmm {}, and modes have shapes; export the "
                                                 "results of dttmm modes",
                                                 results.kind));
    const Structure structure(results.model);
    const Json& modes = results.summary.at("modes");
    const std::vector<Stations> stations = read_stations(results.folder / "shapes.csv", modes.size());
    UniversalFile file(out);
    write_beginning(file, results);
    std::vector<UniversalNode> nodes = nodes_of(structure);
    const std::size_t places = nodes.size();
    if (!stations.empty())
        for (const Eigen::Vector3d& at : stations.front().places) nodes.push_back({as_int(nodes.size()) + 1, at});
    file.write_nodes_15(nodes);
    file.write_nodes_2411(nodes);
    const auto [date, time] = universal_time(results.written);
    const std::array<std::string, 5> lines = {"", results.title, date + " " + time, "modes.csv",
                                              "shape and modal mass are scaled as in modes.csv"};
    for (std::size_t m = 0; m < modes.size(); ++m) {
        UniversalMode mode;
        mode.lines = lines;
        mode.number = as_int(m) + 1;
        mode.frequency = modes[m].at("frequency_hz").get<double>();
        mode.modal_mass = modes[m].at("modal_mass").get<double>();
        mode.lines[0] = fmt::format("mode {}: {:.6g} Hz", m + 1, mode.frequency);
        for (std::size_t p = 0; p < places; ++p) {
            const Json& shape = modes[m].at("shape");
            if (!shape.contains(structure.places()[p].name)) continue;
            mode.labels.push_back(as_int(p) + 1);
            for (std::size_t d = 0; d < 6; ++d)
                mode.real.resize(mode.labels.size()),
                    mode.real.back()[d] = shape[structure.places()[p].name].at(d).get<double>();
        }
        for (std::size_t s = 0; s < stations[m].shape.size(); ++s) {
            mode.labels.push_back(as_int(places + s) + 1);
            mode.real.push_back(stations[m].shape[s]);
        }
        file.write(mode);
    }
    const std::size_t damped = write_damped(results, structure, file, lines);
    if (modes.empty() && damped == 0)
        throw Error(ExitCode::usage, "--uff55: these results have no mode; ask dttmm modes for higher frequencies");
    std::string what = counted(modes.size(), "mode", "modes");
    if (damped > 0) what += fmt::format(" and {} with damping", damped);
    return described(what, places, nodes.size() - places);
}

}  // namespace dttmm::host
