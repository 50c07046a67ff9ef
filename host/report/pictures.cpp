// SPDX-License-Identifier: BSD-3-Clause
#include "report/pictures.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "model/index.h"
#include "record/csv_file.h"
#include "report/base64.h"

namespace dttmm::host {

namespace {

constexpr std::size_t kMostFrames = 2000;
constexpr std::size_t kMostNumbers = 400000;  // 2.1 MB of the page

const std::vector<std::string> kAxes = {"x", "y", "z"}, kQuaternion = {"w", "x", "y", "z"};

/// A quantity of one thing: its columns in the history; none if one of them is missing.
struct Track {
    std::string group, name, quantity;
    std::vector<int> columns;
};

class Motion {
public:
    Motion(const HistoryFile& history, const Json& model);
    Json describe() const;

private:
    void find(const std::string& group, const std::string& name, const std::string& quantity,
              const std::vector<std::string>& axes);
    int column(const std::string& name) const {
        const auto found = columns_.find(name);
        return found == columns_.end() ? -1 : found->second;
    }

    const HistoryFile& history_;
    std::map<std::string, int, std::less<>> columns_;
    std::vector<Track> tracks_;
};

Motion::Motion(const HistoryFile& history, const Json& model) : history_(history) {
    for (std::size_t c = 0; c < history.columns().size(); ++c) columns_.emplace(history.columns()[c].name, as_int(c));
    const auto each = [&](const char* table, const auto& take) {
        if (model.contains(table) && model[table].is_object())
            for (const auto& [name, value] : model[table].items()) take(name);
    };
    each("bodies", [&](const std::string& name) {
        find("bodies", name, "position", kAxes);
        find("bodies", name, "quaternion", kQuaternion);
    });
    each("nodes", [&](const std::string& name) {
        find("nodes", name, "position", kAxes);
        find("nodes", name, "rotation", kAxes);
    });
    each("elements", [&](const std::string& name) {
        if (column(name + ".force") >= 0)
            tracks_.push_back({"forces", name, "force", {column(name + ".force")}});
        else
            find("forces", name, "force", kAxes);
    });
}

void Motion::find(const std::string& group, const std::string& name, const std::string& quantity,
                  const std::vector<std::string>& axes) {
    Track track{group, name, quantity, {}};
    for (const std::string& axis : axes) track.columns.push_back(column(name + "." + quantity + "." + axis));
    if (std::ranges::find(track.columns, -1) == track.columns.end()) tracks_.push_back(std::move(track));
}

Json Motion::describe() const {
    const auto of_bodies = [](const Track& track) { return track.group != "forces"; };
    if (std::ranges::none_of(tracks_, of_bodies)) return nullptr;
    std::vector<int> wanted = {0};
    for (const Track& track : tracks_) wanted.insert(wanted.end(), track.columns.begin(), track.columns.end());
    std::ranges::sort(wanted);
    const std::vector<std::vector<double>> values = history_.read(wanted);
    const auto values_of = [&](int column) -> const std::vector<double>& {
        return values[as_size(std::ranges::lower_bound(wanted, column) - wanted.begin())];
    };
    const std::size_t rows = values.front().size();
    if (rows < 2) return nullptr;
    const std::size_t most = std::clamp<std::size_t>(kMostNumbers / wanted.size(), 2, kMostFrames);
    const std::size_t every = (rows - 1) / most + 1;
    Json json = {{"times", {}}, {"every", every}};
    std::vector<double> times;
    for (std::size_t row = 0; row < rows; row += every) times.push_back(values.front()[row]);
    json["times"] = base64_of_doubles(times);
    for (const Track& track : tracks_) {
        std::vector<double> numbers;
        for (std::size_t row = 0; row < rows; row += every) {
            double square = 0;
            for (const int column : track.columns) {
                const double value = values_of(column)[row];
                if (of_bodies(track))
                    numbers.push_back(value);
                else
                    square += value * value;
            }
            if (!of_bodies(track)) numbers.push_back(std::sqrt(square));
        }
        if (of_bodies(track))
            json[track.group][track.name][track.quantity] = base64_of_floats(numbers);
        else
            json[track.group][track.name] = base64_of_floats(numbers);
    }
    return json;
}

}  // namespace

Json describe_motion(const HistoryFile& history, const Json& model) { return Motion(history, model).describe(); }

Json describe_lines(const std::filesystem::path& shapes) {
    std::error_code fault;
    if (!std::filesystem::exists(shapes, fault)) return nullptr;
    const CsvFile file(shapes);
    std::vector<std::size_t> columns;
    for (const char* name : {"mode", "x", "y", "z", "ux", "uy", "uz"}) {
        const int found = file.find(name);
        if (found < 0) return nullptr;
        columns.push_back(as_size(found));
    }
    const int element = file.find("element");
    if (element < 0 || !file.is_text(as_size(element))) return nullptr;
    std::vector<std::map<std::string, std::vector<double>>> lines;
    for (std::size_t row = 0; row < file.rows(); ++row) {
        const double mode = file.numbers(columns[0])[row];
        if (!(mode >= 1 && mode <= 1e6)) continue;
        if (lines.size() < static_cast<std::size_t>(mode)) lines.resize(static_cast<std::size_t>(mode));
        std::vector<double>& line = lines[static_cast<std::size_t>(mode) - 1][file.texts(as_size(element))[row]];
        for (std::size_t c = 1; c < columns.size(); ++c) line.push_back(file.numbers(columns[c])[row]);
    }
    Json json = Json::array();
    for (const auto& mode : lines) {
        Json& one = json.emplace_back(Json::object());
        for (const auto& [name, line] : mode) one[name] = base64_of_floats(line);
    }
    return json;
}

}  // namespace dttmm::host
