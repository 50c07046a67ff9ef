// SPDX-License-Identifier: BSD-3-Clause
#include "report/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/csv_file.h"

namespace dttmm::host {

namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr std::size_t kPeriod = 24;  // pieces of a period that is drawn with straight lines between: 1 % of the amplitude
constexpr std::size_t kShares = 10;  // steps from the start to an equilibrium
constexpr std::size_t kBent = 6;     // pieces of a beam that is bent as a cubic

Quaterniond turn_by(const Vector3d& theta) {
    const double angle = theta.norm();
    return angle > 0 ? Quaterniond(Eigen::AngleAxisd(angle, theta / angle)) : Quaterniond::Identity();
}

/// Rotation vector of a unit quaternion, at most half a turn.
Vector3d rotation_vector(const Quaterniond& q) {
    const Vector3d axis = q.w() < 0 ? Vector3d(-q.vec()) : Vector3d(q.vec());
    const double sine = axis.norm();
    return sine > 0 ? Vector3d(axis * (2 * std::atan2(sine, std::abs(q.w())) / sine)) : Vector3d::Zero();
}

Vector3d vector_at(const std::vector<double>& values, std::size_t place) {
    return {values[place], values[place + 1], values[place + 2]};
}

/// Everything in proportion.
Instant scaled(Instant instant, double part) {
    for (Moved& moved : instant.owners) moved.shift *= part, moved.theta *= part;
    for (BentLine& line : instant.lines)
        for (Vector3d& shift : line.shift) shift *= part;
    return instant;
}

/// Stations of a beam in a row, from where they are along the straight line between its ends at the start.
BentLine line_of(const Track& track, std::size_t row, const Vector3d& from, const Vector3d& to) {
    const std::size_t stations = track.columns.size() / 3;
    BentLine line;
    for (std::size_t s = 0; s < stations; ++s) {
        line.start.push_back(from + (to - from) * (static_cast<double>(s) / static_cast<double>(stations - 1)));
        line.shift.push_back(vector_at(track.values, 3 * (row * stations + s)) - line.start.back());
    }
    return line;
}

/// Cubic between two ends whose tangents have turned, as a beam without load has it.
std::vector<Vector3d> cubic(const Vector3d& from, const Vector3d& to, const Vector3d& from_tangent,
                            const Vector3d& to_tangent) {
    std::vector<Vector3d> points;
    for (std::size_t i = 0; i <= kBent; ++i) {
        const double t = static_cast<double>(i) / kBent;
        points.emplace_back((1 + 2 * t) * (1 - t) * (1 - t) * from + t * t * (3 - 2 * t) * to +
                            t * (1 - t) * (1 - t) * from_tangent + t * t * (t - 1) * to_tangent);
    }
    return points;
}

std::vector<std::string> names_of_cases(const CsvFile& table) {
    if (!table.columns().empty() && table.is_text(0)) return table.texts(0);
    return std::vector<std::string>(table.rows());
}

}  // namespace

Scene::Scene(const Results& results, const MotionBounds& bounds) : title_(results.title), structure_(results.model) {
    if (structure_.places().empty())
        throw Error(ExitCode::usage,
                    results.model.is_null()
                        ? "these results have no model to draw: there is no summary.json with one; the run was killed, or "
                          "these are cases: export one of them"
                        : "the model of these results has no bodies and nodes to draw");
    if (results.kind == "run")
        add_run(results, bounds);
    else if (results.kind == "modes")
        add_modes(results);
    else if (results.kind == "static")
        add_equilibria(results);
    if (films_.empty())
        throw Error(ExitCode::usage, fmt::format("these results of dttmm {} have no motion to draw; export those of run, "
                                                 "modes or static",
                                                 results.kind));
}

Instant Scene::rest() const {
    return {std::vector<Moved>(structure_.owners().size()), std::vector<BentLine>(structure_.elements().size()),
            std::vector<double>(structure_.elements().size(), NAN)};
}

Instant Scene::recorded(const RecordedMotion& motion, std::size_t row) const {
    Instant instant = rest();
    for (std::size_t i = 0; i < structure_.owners().size(); ++i) {
        const Owner& owner = structure_.owners()[i];
        Moved& moved = instant.owners[i];
        const Track::Of of = owner.box ? Track::Of::body : Track::Of::node;
        if (const Track* track = motion.find(of, owner.name, "position"))
            moved.shift = vector_at(track->values, 3 * row) - owner.position;
        if (const Track* track = motion.find(of, owner.name, "rotation")) moved.theta = vector_at(track->values, 3 * row);
        if (const Track* track = motion.find(of, owner.name, "quaternion")) {
            const double* q = &track->values[4 * row];
            moved.theta = rotation_vector(Quaterniond(q[0], q[1], q[2], q[3]).normalized() * owner.turn.inverse());
        }
    }
    for (std::size_t e = 0; e < structure_.elements().size(); ++e) {
        const ElementLine& element = structure_.elements()[e];
        if (const Track* force = motion.find(Track::Of::element, element.name, "force"))
            instant.forces[e] = magnitude(*force, row);
        if (const Track* track = motion.find(Track::Of::line, element.name, "position"))
            instant.lines[e] = line_of(*track, row, structure_.at_start(element.points.front()),
                                       structure_.at_start(element.points.back()));
    }
    return instant;
}

void Scene::note_still(const RecordedMotion& motion) {
    std::vector<std::string> still, straight;
    for (const Owner& owner : structure_.owners()) {
        const Track::Of of = owner.box ? Track::Of::body : Track::Of::node;
        if (owner.is_fixed) continue;
        if (!motion.find(of, owner.name, "position"))
            still.push_back(owner.name);
        else if (!motion.find(of, owner.name, owner.box ? "quaternion" : "rotation"))
            straight.push_back(owner.name);
    }
    if (!still.empty()) notes_.push_back(fmt::format("no position is recorded of {}: drawn at the start", listed(still)));
    if (!straight.empty()) notes_.push_back(fmt::format("no rotation is recorded of {}: drawn without", listed(straight)));
}

void Scene::add_run(const Results& results, const MotionBounds& bounds) {
    const auto motion =
        std::make_shared<const RecordedMotion>(HistoryFile(results.folder / "history.csv"), results.model, bounds);
    if (!motion->moves())
        throw Error(ExitCode::usage, motion->rows() < 2
                                         ? "this run has fewer than two rows: there is no motion to draw"
                                         : "this run has recorded no position of a body or node; run with --for-report");
    films_.push_back({Film::Kind::run, "run", motion->times(), 0,
                      [this, motion](std::size_t row) { return recorded(*motion, row); }, motion->rows() - 1});
    note_still(*motion);
    if (motion->every() > 1)
        notes_.push_back(fmt::format("one row in {} is shown: faster vibrations are not seen", motion->every()));
}

void Scene::add_modes(const Results& results) {
    const Json& modes = results.summary.at("modes");
    std::vector<Instant> shapes(modes.size(), rest());
    for (std::size_t m = 0; m < modes.size(); ++m)
        for (const auto& [name, shape] : modes[m].at("shape").items())
            if (const int owner = structure_.find_owner(name); owner >= 0) {
                Moved& moved = shapes[m].owners[as_size(owner)];
                for (std::size_t d = 0; d < 3; ++d) {
                    moved.shift[as_row(d)] = shape.at(d).get<double>();
                    moved.theta[as_row(d)] = shape.at(d + 3).get<double>();
                }
            }
    std::error_code fault;
    if (std::filesystem::exists(results.folder / "shapes.csv", fault)) {
        const CsvFile file(results.folder / "shapes.csv");
        std::vector<std::size_t> columns;
        for (const char* name : {"mode", "x", "y", "z", "ux", "uy", "uz", "element"}) {
            const int found = file.find(name);
            if (found < 0)
                throw Error(ExitCode::input_output,
                            fmt::format("{}: damaged: there is no column {}", file.path().string(), quote(name)));
            columns.push_back(as_size(found));
        }
        std::unordered_map<std::string, std::size_t> element_of;
        for (std::size_t e = 0; e < structure_.elements().size(); ++e) element_of[structure_.elements()[e].name] = e;
        for (std::size_t row = 0; row < file.rows(); ++row) {
            const double mode = file.numbers(columns[0])[row];
            const auto element = element_of.find(file.texts(columns[7])[row]);
            if (!(mode >= 1 && mode <= static_cast<double>(modes.size())) || element == element_of.end()) continue;
            BentLine& line = shapes[static_cast<std::size_t>(mode) - 1].lines[element->second];
            const auto number = [&](std::size_t c) { return file.numbers(columns[c])[row]; };
            line.start.emplace_back(number(1), number(2), number(3));
            line.shift.emplace_back(number(4), number(5), number(6));
        }
    }
    std::vector<double> times;
    for (std::size_t i = 0; i <= kPeriod; ++i) times.push_back(static_cast<double>(i) / kPeriod);
    for (std::size_t m = 0; m < modes.size(); ++m) {
        const double frequency = modes[m].at("frequency_hz").get<double>();
        const auto at = [shape = shapes[m]](std::size_t i) {
            return scaled(shape, i == kPeriod / 4 ? 1 : std::sin(2 * std::numbers::pi * static_cast<double>(i) / kPeriod));
        };
        films_.push_back(
            {Film::Kind::mode, fmt::format("mode {}: {:.6g} Hz", m + 1, frequency), times, frequency, at, kPeriod / 4});
    }
}

void Scene::add_equilibria(const Results& results) {
    const CsvFile table(results.folder / "static.csv");
    const RecordedMotion motion(table, results.model);
    const std::vector<std::string> cases = names_of_cases(table);
    std::vector<double> times;
    for (std::size_t i = 0; i <= kShares; ++i) times.push_back(static_cast<double>(i) / kShares);
    for (std::size_t row = 0; row < motion.rows(); ++row) {
        const Instant whole = recorded(motion, row);
        const auto is_number = [](const Moved& moved) { return moved.shift.allFinite() && moved.theta.allFinite(); };
        if (!std::ranges::all_of(whole.owners, is_number)) {
            notes_.push_back(fmt::format("left out: load case {} has no equilibrium", quote(cases[row])));
            continue;
        }
        films_.push_back({Film::Kind::equilibrium, cases[row].empty() ? "equilibrium" : "equilibrium " + cases[row], times,
                          0, [whole](std::size_t i) { return scaled(whole, static_cast<double>(i) / kShares); }, kShares});
    }
    note_still(motion);
}

Vector3d Scene::place(const OwnedPoint& point, const Instant& instant, double factor) const {
    if (point.owner < 0) return point.local;
    const Owner& owner = structure_.owners()[as_size(point.owner)];
    const Moved& moved = instant.owners[as_size(point.owner)];
    return owner.position + factor * moved.shift + turn_by(factor * moved.theta) * (owner.turn * point.local);
}

Vector3d Scene::linear_shift(const OwnedPoint& point, const Instant& instant) const {
    if (point.owner < 0) return Vector3d::Zero();
    const Moved& moved = instant.owners[as_size(point.owner)];
    return moved.shift + moved.theta.cross(structure_.owners()[as_size(point.owner)].turn * point.local);
}

Placement Scene::place(const Instant& instant, double factor) const {
    Placement placement;
    for (std::size_t i = 0; i < structure_.owners().size(); ++i)
        placement.owners.push_back({place(OwnedPoint{as_int(i), Vector3d::Zero()}, instant, factor),
                                    turn_by(factor * instant.owners[i].theta) * structure_.owners()[i].turn});
    for (std::size_t e = 0; e < structure_.elements().size(); ++e) {
        const ElementLine& element = structure_.elements()[e];
        const BentLine& bent = instant.lines[e];
        std::vector<Vector3d>& line = placement.lines.emplace_back();
        for (std::size_t s = 0; s < bent.start.size(); ++s) line.emplace_back(bent.start[s] + factor * bent.shift[s]);
        if (!line.empty()) continue;
        for (const OwnedPoint& point : element.points) line.push_back(place(point, instant, factor));
        if (!element.is_beam()) continue;
        const auto tangent = [&](const OwnedPoint& end) -> Vector3d {
            const Vector3d start = structure_.at_start(element.points[1]) - structure_.at_start(element.points[0]);
            return end.owner < 0 ? start : Vector3d(turn_by(factor * instant.owners[as_size(end.owner)].theta) * start);
        };
        line = cubic(line[0], line[1], tangent(element.points[0]), tangent(element.points[1]));
    }
    return placement;
}

Scene::Largest Scene::largest(const Instant& instant) const {
    Largest most;
    const auto take = [&](const OwnedPoint& point) {
        most.shift = std::max(most.shift, linear_shift(point, instant).norm());
    };
    for (const NamedPlace& place : structure_.places()) take(place.point);
    for (std::size_t i = 0; i < structure_.owners().size(); ++i) {
        most.angle = std::max(most.angle, instant.owners[i].theta.norm());
        if (structure_.owners()[i].box)
            for (const Vector3d& corner : corners_of(*structure_.owners()[i].box)) take({as_int(i), corner});
    }
    for (const BentLine& line : instant.lines)
        for (const Vector3d& shift : line.shift) most.shift = std::max(most.shift, shift.norm());
    return most;
}

}  // namespace dttmm::host
