// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <string>
#include <vector>

#include "model/read_model.h"
#include "step/simulation.h"

namespace dttmm::test {

using namespace host;

/// A run in memory: its rows of results, channels by name.
class RecordedRun {
public:
    /// text: a model without its format.
    explicit RecordedRun(const std::string& text, const std::vector<std::string>& libraries = {}) {
        const Plugins plugins(libraries);
        const Model model = parse_model("format = \"dttmm/1\"\n" + text, "model.toml", plugins.catalogue());
        Simulation simulation(model, plugins);
        for (size_t c = 0; c < simulation.channels().size(); ++c) columns_[simulation.channels()[c].name()] = c;
        for (const Channel& channel : simulation.channels()) units_.push_back(channel.unit());
        simulation.record_to([&](std::span<const double> row) { rows_.emplace_back(row.begin(), row.end()); });
        while (simulation.index() < simulation.step_count()) simulation.step();
    }
    size_t count() const { return rows_.size(); }
    const std::vector<std::vector<double>>& rows() const { return rows_; }
    /// Of every number of a row.
    const std::vector<std::string>& units() const { return units_; }
    bool has(const std::string& channel) const { return columns_.count(channel) > 0; }
    double operator()(size_t n, const std::string& channel) const { return rows_[n][columns_.at(channel)]; }
    Eigen::Vector3d vector(size_t n, const std::string& channel) const {
        const size_t c = columns_.at(channel + ".x");
        return {rows_[n][c], rows_[n][c + 1], rows_[n][c + 2]};
    }
    Eigen::Vector3d last(const std::string& channel) const { return vector(count() - 1, channel); }
    /// Of a body: its axes in those of the world.
    Eigen::Matrix3d attitude(size_t n, const std::string& body) const {
        const auto part = [&](const char* name) { return (*this)(n, body + ".quaternion." + name); };
        return Eigen::Quaterniond(part("w"), part("x"), part("y"), part("z")).toRotationMatrix();
    }
    /// Of a node: from the axes at the start to those of a row, in the world's.
    Eigen::Matrix3d turned(size_t n, const std::string& node) const {
        const Eigen::Vector3d v = vector(n, node + ".rotation");
        return Eigen::AngleAxisd(v.norm(), v.stableNormalized()).toRotationMatrix();
    }
    /// Largest way between two points that a vector reaches in a share of the rows.
    double spread(const std::string& channel, double begin, double end) const {
        const auto at = [&](double share) { return static_cast<size_t>(share * static_cast<double>(count())); };
        Eigen::Vector3d least = vector(at(begin), channel), most = least;
        for (size_t n = at(begin); n < at(end); ++n) {
            least = least.cwiseMin(vector(n, channel));
            most = most.cwiseMax(vector(n, channel));
        }
        return (most - least).norm();
    }

private:
    std::map<std::string, size_t> columns_;
    std::vector<std::string> units_;
    std::vector<std::vector<double>> rows_;
};

}  // namespace dttmm::test
