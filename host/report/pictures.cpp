// SPDX-License-Identifier: BSD-3-Clause
#include "report/pictures.h"

#include <map>
#include <string>
#include <vector>

#include "model/index.h"
#include "record/csv_file.h"
#include "report/base64.h"
#include "report/recorded_motion.h"

namespace dttmm::host {

namespace {

constexpr MotionBounds kBounds = {2000, 400000};  // 2.1 MB of the page

}  // namespace

Json describe_motion(const HistoryFile& history, const Json& model) {
    const RecordedMotion motion(history, model, kBounds);
    if (!motion.moves()) return nullptr;
    Json json = {{"times", base64_of_doubles(motion.times())}, {"every", motion.every()}};
    for (const Track& track : motion.tracks()) {
        if (track.of == Track::Of::line) {
            json["lines"][track.name] = base64_of_floats(track.values);
        } else if (track.of != Track::Of::element) {
            const char* group = track.of == Track::Of::body ? "bodies" : "nodes";
            json[group][track.name][track.quantity] = base64_of_floats(track.values);
        } else {
            std::vector<double> sizes;
            for (std::size_t row = 0; row < motion.rows(); ++row) sizes.push_back(magnitude(track, row));
            json["forces"][track.name] = base64_of_floats(sizes);
        }
    }
    return json;
}

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
