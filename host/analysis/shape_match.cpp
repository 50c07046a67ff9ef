// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/shape_match.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "analysis/recorded_run.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

constexpr double kSameMac = 0.01;            // shapes nearer than this are not told apart by it, but by frequency
constexpr double kMultipleFrequency = 1e-6;  // share: modes listed with one frequency mix freely

constexpr double kStill = 1e-6;  // a shape is 1 where it is largest: less is rounding, it does not move the channels

struct ShapeQuantity {
    const char* name;
    int derivative;
    bool is_rotation;
};
constexpr ShapeQuantity kShapeQuantities[] = {{"position", 0, false},
                                              {"velocity", 1, false},
                                              {"acceleration", 2, false},
                                              {"rotation", 0, true},
                                              {"angular_velocity", 1, true}};

Json read_mode_shapes(const std::filesystem::path& folder) {
    Json json = read_json_file(folder / "summary.json");
    if (!json.is_object() || json.value("format", "") != "dttmm-modes/1" || !json.contains("modes"))
        throw Error(ExitCode::input_output,
                    fmt::format("{}: there are no results of `dttmm modes` in it; name their folder", folder.string()));
    return json;
}

/// Its rank counts the directions in which the shapes move.
Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decompose(const Eigen::MatrixXd& shapes) {
    Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> decomposition;
    decomposition.setThreshold(kStill / shapes.norm());
    decomposition.compute(shapes);
    return decomposition;
}

}  // namespace

double mac_of(const Eigen::MatrixXd& shapes, const Eigen::VectorXcd& shape) {
    const auto qr = decompose(shapes);
    const Eigen::MatrixXd basis = Eigen::MatrixXd(qr.householderQ()).leftCols(qr.rank());
    return (basis.transpose().cast<std::complex<double>>() * shape).squaredNorm() / shape.squaredNorm();
}

Eigen::VectorXd nearest_mixture(const Eigen::MatrixXd& shapes, const Eigen::VectorXd& shape) {
    return decompose(shapes).solve(shape);
}

ShapeMatch::ShapeMatch(const std::filesystem::path& folder, const std::vector<Column>& channels) {
    const Json json = read_mode_shapes(folder);
    std::unordered_map<std::string, int> index_of;
    for (size_t c = 0; c < channels.size(); ++c) index_of.emplace(channels[c].name, as_int(c));
    struct Row {
        std::string place;
        size_t direction;
    };
    std::vector<Row> rows;
    const Json& modes = json["modes"];
    for (const bool is_rotation : {false, true}) {
        if (!used_.empty() || modes.empty()) break;
        for (const auto& [place, shape] : modes[0]["shape"].items())
            for (const ShapeQuantity& quantity : kShapeQuantities)
                for (size_t axis = 0; axis < 3 && quantity.is_rotation == is_rotation; ++axis) {
                    const auto found = index_of.find(fmt::format("{}.{}.{}", place, quantity.name, "xyz"[axis]));
                    if (found == index_of.end()) continue;
                    used_.push_back({found->second, quantity.derivative});
                    rows.push_back({place, axis + (is_rotation ? 3 : 0)});
                }
    }
    if (used_.empty())
        throw Error(ExitCode::usage,
                    fmt::format("--modes {}: no channel is a position, velocity or acceleration of a place that "
                                "these modes have; record some of them",
                                folder.string()));
    shapes_.resize(as_row(used_.size()), as_row(modes.size()));
    for (size_t m = 0; m < modes.size(); ++m) {
        frequencies_.push_back(modes[m]["frequency_hz"].get<double>());
        for (size_t r = 0; r < rows.size(); ++r)
            shapes_(as_row(r), as_row(m)) = modes[m]["shape"][rows[r].place][rows[r].direction].get<double>();
    }
}

ModeMatch ShapeMatch::match(const Eigen::VectorXcd& shape, std::complex<double> rate) const {
    Eigen::VectorXcd own(as_row(used_.size()));
    for (size_t r = 0; r < used_.size(); ++r) own(as_row(r)) = shape(used_[r].channel) / std::pow(rate, used_[r].derivative);
    const double frequency = std::abs(rate) / (2 * std::numbers::pi);
    std::vector<ModeMatch> found;
    double best = 0;
    for (size_t first = 0, end = 0; first < frequencies_.size(); first = end) {
        for (end = first + 1; end < frequencies_.size() && std::abs(frequencies_[end] - frequencies_[first]) <=
                                                               kMultipleFrequency * std::abs(frequencies_[first]);)
            ++end;
        const Eigen::MatrixXd group = shapes_.middleCols(as_row(first), as_row(end - first));
        found.push_back({first + 1, frequencies_[first], mac_of(group, own)});
        best = std::max(best, found.back().mac);
    }
    ModeMatch nearest;
    for (const ModeMatch& one : found)
        if (one.mac >= best - kSameMac &&
            (nearest.mode == 0 || std::abs(one.frequency - frequency) < std::abs(nearest.frequency - frequency)))
            nearest = one;
    return nearest;
}

}  // namespace dttmm::host
