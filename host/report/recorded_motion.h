// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "analysis/json.h"
#include "record/csv_file.h"
#include "record/history_file.h"

namespace dttmm::host {

/// A quantity of one part over all rows. World axes.
struct Track {
    enum class Of : unsigned char { body, node, element, line };
    Of of;
    std::string name;  ///< of the part
    /// "position" [m], "quaternion" (w x y z) of a body; "position", "rotation" (vector [rad] from the start) of a node;
    /// "force" [N] of an element; "position" of the stations of a beam, end to end.
    std::string quantity;
    std::vector<int> columns;    ///< in the table
    std::vector<double> values;  ///< columns.size() per row
};

/// Of a recorded motion that is kept.
struct MotionBounds {
    std::size_t most_rows, most_numbers;
};

/// How the machine moves, as far as a table has it: the tracks of all parts of a model whose columns are all there. model:
/// member "model" of summary.json.
class RecordedMotion {
public:
    /// Of a run: rows at equal distances, so few that both bounds are kept, but at least two of many. Throws as
    /// HistoryFile::read does.
    RecordedMotion(const HistoryFile& history, const Json& model, const MotionBounds& bounds);
    /// Of equilibria: every row of static.csv. Its times are the numbers of the rows.
    RecordedMotion(const CsvFile& equilibria, const Json& model);

    const std::vector<double>& times() const { return times_; }  ///< [s], one per row
    std::size_t rows() const { return times_.size(); }
    std::size_t every() const { return every_; }  ///< rows of the file from one to the next
    const std::vector<Track>& tracks() const { return tracks_; }
    /// Null where the quantity is not recorded.
    const Track* find(Track::Of of, std::string_view name, std::string_view quantity) const;
    /// Whether the position of a body or node is recorded, in two rows at least.
    bool moves() const;

private:
    std::vector<Track> tracks_;  ///< by of, name, quantity
    std::vector<double> times_;
    std::size_t every_ = 1;
};

/// Whether a channel is the position of a station of a beam, which is recorded for pictures.
bool is_station(std::string_view channel);

/// Magnitude of a force in a row [N].
double magnitude(const Track& force, std::size_t row);

}  // namespace dttmm::host
