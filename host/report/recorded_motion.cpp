// SPDX-License-Identifier: BSD-3-Clause
#include "report/recorded_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <unordered_map>

#include "model/index.h"

namespace dttmm::host {

namespace {

const std::vector<std::string> kAxes = {"x", "y", "z"}, kQuaternion = {"w", "x", "y", "z"};

/// Finds columns by the names of channels, which it makes of parts, quantities and axes.
class TrackFinder {
public:
    TrackFinder(const std::vector<Column>& columns, const Json& model) {
        for (std::size_t c = 0; c < columns.size(); ++c) columns_.emplace(columns[c].name, as_int(c));
        each(model, "bodies", [&](const std::string& name) {
            find(Track::Of::body, name, "position", kAxes);
            find(Track::Of::body, name, "quaternion", kQuaternion);
        });
        each(model, "nodes", [&](const std::string& name) {
            find(Track::Of::node, name, "position", kAxes);
            find(Track::Of::node, name, "rotation", kAxes);
        });
        each(model, "elements", [&](const std::string& name) {
            if (const int c = column(name + ".force"); c >= 0)
                tracks_.push_back({Track::Of::element, name, "force", {c}, {}});
            else
                find(Track::Of::element, name, "force", kAxes);
            find_line(name);
        });
    }

    std::vector<Track> take() {
        const auto key = [](const Track& track) { return std::tie(track.of, track.name, track.quantity); };
        std::ranges::sort(tracks_, {}, key);
        return std::move(tracks_);
    }

private:
    template <class Take>
    static void each(const Json& model, const char* table, const Take& take) {
        if (model.contains(table) && model[table].is_object())
            for (const auto& [name, value] : model[table].items()) take(name);
    }

    int column(const std::string& name) const {
        const auto found = columns_.find(name);
        return found == columns_.end() ? -1 : found->second;
    }

    /// Columns of all axes; none if one is missing.
    std::vector<int> columns_of(const std::string& stem, const std::vector<std::string>& axes) const {
        std::vector<int> found;
        for (const std::string& axis : axes) found.push_back(column(stem + "." + axis));
        return std::ranges::find(found, -1) == found.end() ? found : std::vector<int>{};
    }

    void find(Track::Of of, const std::string& name, const std::string& quantity, const std::vector<std::string>& axes) {
        std::vector<int> found = columns_of(name + "." + quantity, axes);
        if (!found.empty()) tracks_.push_back({of, name, quantity, std::move(found), {}});
    }

    /// Stations are numbered from 0 on.
    void find_line(const std::string& name) {
        Track line{Track::Of::line, name, "position", {}, {}};
        for (int station = 0;; ++station) {
            const std::vector<int> found = columns_of(fmt::format("{}.station{}.position", name, station), kAxes);
            if (found.empty()) break;
            line.columns.insert(line.columns.end(), found.begin(), found.end());
        }
        if (line.columns.size() > 3) tracks_.push_back(std::move(line));
    }

    std::unordered_map<std::string, int> columns_;
    std::vector<Track> tracks_;
};

}  // namespace

RecordedMotion::RecordedMotion(const HistoryFile& history, const Json& model, const MotionBounds& bounds)
    : tracks_(TrackFinder(history.columns(), model).take()) {
    std::vector<int> wanted = {0};
    for (const Track& track : tracks_) wanted.insert(wanted.end(), track.columns.begin(), track.columns.end());
    std::ranges::sort(wanted);
    const std::vector<std::vector<double>> values = history.read(wanted);
    const std::size_t rows = values.front().size();
    const std::size_t most = std::max<std::size_t>(std::min(bounds.most_numbers / wanted.size(), bounds.most_rows), 2);
    every_ = rows < 2 ? 1 : (rows - 1) / most + 1;
    for (std::size_t row = 0; row < rows; row += every_) times_.push_back(values.front()[row]);
    for (Track& track : tracks_) {
        std::vector<const std::vector<double>*> of_track;
        for (const int column : track.columns)
            of_track.push_back(&values[as_size(std::ranges::lower_bound(wanted, column) - wanted.begin())]);
        track.values.reserve(times_.size() * of_track.size());
        for (std::size_t row = 0; row < rows; row += every_)
            for (const std::vector<double>* column : of_track) track.values.push_back((*column)[row]);
    }
}

RecordedMotion::RecordedMotion(const CsvFile& equilibria, const Json& model)
    : tracks_(TrackFinder(equilibria.columns(), model).take()) {
    for (std::size_t row = 0; row < equilibria.rows(); ++row) times_.push_back(static_cast<double>(row));
    std::erase_if(tracks_, [&](const Track& track) {  // a column of texts has no numbers
        return std::ranges::any_of(track.columns, [&](int c) { return equilibria.is_text(as_size(c)); });
    });
    for (Track& track : tracks_)
        for (std::size_t row = 0; row < equilibria.rows(); ++row)
            for (const int column : track.columns) track.values.push_back(equilibria.numbers(as_size(column))[row]);
}

const Track* RecordedMotion::find(Track::Of of, std::string_view name, std::string_view quantity) const {
    const auto key = [](const Track& track) {
        return std::tuple(track.of, std::string_view(track.name), std::string_view(track.quantity));
    };
    const auto wanted = std::tuple(of, name, quantity);
    const auto found = std::ranges::lower_bound(tracks_, wanted, {}, key);
    return found != tracks_.end() && key(*found) == wanted ? &*found : nullptr;
}

bool RecordedMotion::moves() const {
    return rows() >= 2 && std::ranges::any_of(tracks_, [](const Track& track) { return track.of != Track::Of::element; });
}

bool is_station(std::string_view channel) {
    constexpr std::string_view kStation = ".station";
    const std::size_t at = channel.find(kStation), end = channel.find(".position.", at);
    return at != channel.npos && end != channel.npos && end > at + kStation.size() &&
           channel.substr(at + kStation.size(), end - at - kStation.size()).find_first_not_of("0123456789") == channel.npos;
}

double magnitude(const Track& force, std::size_t row) {
    const std::size_t width = force.columns.size();
    double square = 0;
    for (std::size_t i = 0; i < width; ++i) square += force.values[row * width + i] * force.values[row * width + i];
    return std::sqrt(square);
}

}  // namespace dttmm::host
