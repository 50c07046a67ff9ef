// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/given_shapes.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <fstream>
#include <limits>
#include <map>
#include <set>

#include "analysis/shape_match.h"
#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/csv_table.h"
#include "record/file.h"

namespace dttmm::host {

namespace {

namespace fs = std::filesystem;

constexpr uint32_t kShapeStations = 21;   // of shapes.csv
constexpr double kNoDisplacement = 1e-6;  // shapes of `dttmm modes` are 1 where they are largest: less is rounding
constexpr std::uintmax_t kLargestShapes = 64u << 20;  // [byte]
constexpr size_t kMostColumns = 12;                   // of the table on the terminal

/// Fields of a line, without blanks around them and without their quotes.
std::vector<std::string> fields_of(const std::string& line) {
    std::vector<std::string> fields(1);
    bool is_quoted = false;
    for (const char c : line) {
        if (c == '"')
            is_quoted = !is_quoted;
        else if (c == ',' && !is_quoted)
            fields.emplace_back();
        else if (c != '\r')
            fields.back() += c;
    }
    for (std::string& field : fields) {
        const size_t begin = std::min(field.find_first_not_of(" \t"), field.size());
        field = field.substr(begin, field.find_last_not_of(" \t") + 1 - begin);
    }
    return fields;
}

bool is_number(const std::string& field) {
    double value = 0;
    const auto [end, fault] = std::from_chars(field.data(), field.data() + field.size(), value);
    return fault == std::errc() && end == field.data() + field.size() && std::isfinite(value);
}

/// "position", "velocity" and "acceleration" of one direction are displacements of a shape.
int direction_of(const std::string& quantity, const std::string& axis) {
    const size_t a = axis.size() == 1 ? std::string("xyz").find(axis) : std::string::npos;
    if (a == std::string::npos) return -1;
    if (quantity == "position" || quantity == "velocity" || quantity == "acceleration") return as_int(a);
    if (quantity == "rotation" || quantity == "angular_velocity") return as_int(a) + 3;
    return -1;
}

}  // namespace

void GivenShapes::fail(size_t line, const std::string& fault) const {
    throw Error(ExitCode::input_output, fmt::format("{}:{}: {}", file_.string(), line, fault));
}

double GivenShapes::number(size_t line, const std::string& field) const {
    if (!is_number(field)) fail(line, fmt::format("{} is no finite number", quote(field)));
    double value = 0;
    std::from_chars(field.data(), field.data() + field.size(), value);
    return value;
}

/// All that are not empty.
std::vector<GivenShapes::CsvLine> GivenShapes::read_lines() const {
    std::error_code fault;
    if (!fs::is_regular_file(file_, fault))
        throw file_error(file_, "cannot read", fs::exists(file_, fault) ? EISDIR : ENOENT);
    if (fs::file_size(file_, fault) > kLargestShapes)
        throw Error(ExitCode::input_output, fmt::format("{}: is larger than 64 MiB", file_.string()));
    std::ifstream stream(file_, std::ios::binary);
    if (!stream) throw file_error(file_, "cannot read", EACCES);
    std::vector<CsvLine> lines;
    std::string text;
    for (size_t number = 1; std::getline(stream, text); ++number)
        if (text.find_first_not_of(" \t\r") != text.npos) lines.push_back({number, fields_of(text)});
    if (lines.size() < 2) fail(1, "a line of names and at least one of numbers are wanted");
    for (const CsvLine& line : lines)
        if (line.fields.size() != lines.front().fields.size())
            fail(line.number, fmt::format("{}, but {}", counted(line.fields.size(), "field", "fields"),
                                          counted(lines.front().fields.size(), "name", "names")));
    return lines;
}

GivenShapes::GivenShapes(const fs::path& file, const ModalMachine& machine, Warnings& warnings) : file_(file) {
    const std::vector<CsvLine> lines = read_lines();
    if (lines.front().fields.front() == "mode")
        read_own(lines, machine, warnings);
    else
        read_plain(lines, machine);
}

/// modes.csv or shapes.csv: a line per mode and place, or mode, element and station.
void GivenShapes::read_own(const std::vector<CsvLine>& lines, const ModalMachine& machine, Warnings& warnings) {
    std::map<std::string, size_t> column;
    for (size_t c = 0; c < lines.front().fields.size(); ++c) column[lines.front().fields[c]] = c;
    for (const char* name : {"mode", "frequency", "ux", "uy", "uz", "urx", "ury", "urz"})
        if (!column.contains(name))
            fail(1, fmt::format("there is no column {}: this is not the modes.csv or shapes.csv of `dttmm modes`",
                                quote(name)));
    const bool by_place = column.contains("place");
    if (!by_place && !(column.contains("element") && column.contains("s"))) fail(1, "there is no column \"place\"");
    std::map<std::string, size_t> first_row;  // of a place or station
    std::map<long, size_t> shape_of;          // a mode's number
    std::map<std::string, int> stations;      // seen of an element in this mode
    std::set<std::string> unknown;
    std::vector<std::vector<double>> values;
    for (size_t i = 2; i < lines.size(); ++i) {  // behind the units
        const auto& [line, fields] = lines[i];
        const long mode = std::lround(number(line, fields[column["mode"]]));
        if (shape_of.emplace(mode, shape_of.size()).second) {
            names_.push_back(fmt::format("mode{}", mode));
            values.emplace_back();
            stations.clear();
        }
        std::string name = fields[column[by_place ? "place" : "element"]];
        const int station = by_place ? -1 : stations[name]++;
        const ModalPlace* place = by_place ? machine.find(name) : nullptr;
        if (by_place ? !place : station >= as_int(size_t{kShapeStations})) {
            if (!by_place) fail(line, fmt::format("the element {} has more than {} stations", quote(name), kShapeStations));
            unknown.insert(name);
            continue;
        }
        const std::string key = by_place ? name : fmt::format("{}@{}", name, station);
        const auto [row, is_new] = first_row.emplace(key, freedoms_.size());
        for (int d = 0; d < 6 && is_new; ++d) freedoms_.push_back({place, by_place ? "" : name, station, d});
        std::vector<double>& shape = values[shape_of[mode]];
        shape.resize(std::max(shape.size(), row->second + 6));
        constexpr const char* kNames[] = {"ux", "uy", "uz", "urx", "ury", "urz"};
        for (size_t d = 0; d < 6; ++d) shape[row->second + d] = number(line, fields[column[kNames[d]]]);
    }
    if (freedoms_.empty())
        throw Error(ExitCode::input_output, fmt::format("{}: it has no place of this model", file_.string()));
    if (!unknown.empty())
        warnings.note("mac-places",
                      fmt::format("{}: {}, as {}: left out of the MAC", file_.string(),
                                  counted(unknown.size(), "place is not in this model", "places are not in this model"),
                                  quote(*unknown.begin())));
    given_.setZero(as_row(freedoms_.size()), as_row(values.size()));
    for (size_t m = 0; m < values.size(); ++m)
        for (size_t r = 0; r < values[m].size(); ++r) given_(as_row(r), as_row(m)) = values[m][r];
}

/// "plate.corner1.z" or "plate.corner1.acceleration.z".
GivenShapes::Freedom GivenShapes::freedom_named(size_t line, const std::string& channel, const ModalMachine& machine) const {
    const size_t dot = channel.rfind('.');
    const std::string owner = channel.substr(0, dot), axis = dot == channel.npos ? "" : channel.substr(dot + 1);
    const auto direction = std::ranges::find(direction_names(), axis);
    if (const ModalPlace* place = machine.find(owner); place && direction != direction_names().end())
        return {place, "", -1, as_int(direction - direction_names().begin())};
    if (const size_t second = owner.rfind('.'); second != owner.npos) {
        const int d = direction_of(owner.substr(second + 1), axis);
        if (const ModalPlace* place = machine.find(owner.substr(0, second)); place && d >= 0) return {place, "", -1, d};
    }
    std::vector<std::string> known;
    for (const ModalPlace& place : machine.places())
        for (const std::string& d : direction_names()) known.push_back(place.name + "." + d);
    fail(line, fmt::format("{} is no place and direction of this model, as {}{}", quote(channel),
                           known.empty() ? "plate.z" : known[2], suggestion(channel, known)));
}

void GivenShapes::read_plain(const std::vector<CsvLine>& lines, const ModalMachine& machine) {
    names_.assign(lines.front().fields.begin() + 1, lines.front().fields.end());
    if (names_.empty()) fail(1, "there is no shape: names of channels come first, then a column per shape");
    size_t begin = 1;
    const auto& units = lines[1].fields;
    if (std::none_of(units.begin() + 1, units.end(), is_number)) ++begin;
    given_.resize(as_row(lines.size() - begin), as_row(names_.size()));
    std::set<std::pair<std::string, int>> seen;
    for (size_t i = begin; i < lines.size(); ++i) {
        const auto& [line, fields] = lines[i];
        freedoms_.push_back(freedom_named(line, fields.front(), machine));
        if (!seen.emplace(freedoms_.back().place->name, freedoms_.back().direction).second)
            fail(line, fmt::format("{} is there twice", quote(fields.front())));
        for (size_t m = 0; m < names_.size(); ++m) given_(as_row(i - begin), as_row(m)) = number(line, fields[m + 1]);
    }
    if (freedoms_.empty()) fail(lines.back().number, "there is no channel");
}

/// Of the machine where the given shapes are: a column per mode.
Eigen::MatrixXd GivenShapes::shapes_of(const Model& model, ModalMachine& machine,
                                       const std::vector<ModalInstance::Mode>& modes) const {
    Eigen::MatrixXd shapes = Eigen::MatrixXd::Zero(as_row(freedoms_.size()), as_row(modes.size()));
    for (size_t m = 0; m < modes.size(); ++m) {
        std::map<std::string, std::vector<ModalMachine::Vector6>> along;
        for (size_t r = 0; r < freedoms_.size(); ++r) {
            const Freedom& at = freedoms_[r];
            if (at.place) {
                shapes(as_row(r), as_row(m)) = machine.motion(*at.place, modes[m])(at.direction);
                continue;
            }
            if (!along.contains(at.element)) {
                const auto element = std::ranges::find(model.elements, at.element, &Element::name);
                if (element == model.elements.end())
                    throw Error(ExitCode::input_output,
                                fmt::format("{}: this model has no element {}", file_.string(), quote(at.element)));
                double length = 0;
                along[at.element] = machine.along(
                    as_whole<uint32_t>(m), as_whole<uint32_t>(element - model.elements.begin()), kShapeStations, length);
            }
            const auto& stations = along[at.element];
            if (!stations.empty()) shapes(as_row(r), as_row(m)) = stations[as_size(at.station)](at.direction);
        }
    }
    return shapes;
}

void GivenShapes::compare(const Model& model, ModalMachine& machine, const std::vector<ModalInstance::Mode>& modes) {
    const Eigen::MatrixXd own = shapes_of(model, machine, modes);
    mac_.setConstant(as_row(modes.size()), given_.cols(), std::numeric_limits<double>::quiet_NaN());
    for (const ModalInstance::Mode& mode : modes) frequencies_.push_back(mode.numbers.frequency);
    std::vector<Eigen::Index> displacements, rotations;
    for (size_t r = 0; r < freedoms_.size(); ++r)
        (freedoms_[r].direction < 3 ? displacements : rotations).push_back(as_row(r));
    for (Eigen::Index g = 0; g < given_.cols(); ++g) {
        const Eigen::VectorXd all = given_.col(g);
        const bool is_displaced = !displacements.empty() && all(displacements).norm() > kNoDisplacement * all.norm();
        const std::vector<Eigen::Index>& rows = is_displaced ? displacements : rotations;
        if (rows.empty() || all(rows).norm() == 0) continue;
        const Eigen::VectorXcd shape = all(rows).cast<std::complex<double>>();
        for (size_t first = 0, end = 0; first < modes.size(); first = end) {
            end = std::min(modes.size(), first + modes[first].numbers.multiplicity);
            const Eigen::MatrixXd group = own.middleCols(as_row(first), as_row(end - first))(rows, Eigen::all);
            mac_.block(as_row(first), g, as_row(end - first), 1).setConstant(mac_of(group, shape));
        }
    }
}

std::string GivenShapes::table() const {
    std::vector<Column> columns = {{"mode", "1"}, {"frequency", "Hz"}};
    for (const std::string& name : names_) columns.push_back({name, "1"});
    CsvTable table(columns);
    for (Eigen::Index m = 0; m < mac_.rows(); ++m)
        table.add(static_cast<double>(m + 1)).add(frequencies_[as_size(m)]).add_all(mac_.row(m)).end_row();
    return table.text();
}

void GivenShapes::print() const {
    if (mac_.rows() == 0) return;
    fmt::print("MAC with the shapes of {}\n", printable(file_.string()));
    if (names_.size() <= kMostColumns) {
        fmt::print("{:>4} {:>14}", "mode", "frequency");
        for (const std::string& name : names_) fmt::print(" {:>9}", printable(name));
        for (Eigen::Index m = 0; m < mac_.rows(); ++m) {
            fmt::print("\n{:>4} {:>11} Hz", m + 1, fmt::format("{:.8g}", frequencies_[as_size(m)]));
            for (Eigen::Index g = 0; g < mac_.cols(); ++g)
                fmt::print(" {:>9}", std::isnan(mac_(m, g)) ? "-" : fmt::format("{:.4f}", mac_(m, g)));
        }
        fmt::print("\n");
    }
    for (Eigen::Index g = 0; g < mac_.cols(); ++g) {
        Eigen::Index best = 0;
        const std::string name = printable(names_[as_size(g)]);
        if (std::isnan(mac_(0, g)))
            fmt::print("{} moves nothing that is compared\n", name);
        else if (mac_.col(g).maxCoeff(&best); true)
            fmt::print("{} is most like mode {} at {:.8g} Hz, MAC {:.4f}\n", name, best + 1, frequencies_[as_size(best)],
                       mac_(best, g));
    }
}

Json GivenShapes::describe() const {
    Json values = Json::array();
    for (Eigen::Index m = 0; m < mac_.rows(); ++m) {
        Json row = Json::array();
        for (const double value : mac_.row(m)) row.push_back(std::isnan(value) ? Json() : Json(value));
        values.push_back(std::move(row));
    }
    return {{"file", file_.string()}, {"shapes", names_}, {"mac", values}};
}

}  // namespace dttmm::host
