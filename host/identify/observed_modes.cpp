// SPDX-License-Identifier: BSD-3-Clause
#include "identify/observed_modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "analysis/places.h"
#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

/// Column of a file, row among the freedoms, and what makes it the model's.
struct ShapeColumn {
    size_t column;
    std::ptrdiff_t row;
    double factor;
};

/// A complex shape is turned so that it is as real as it can be. Returns whether it is zero wherever it was measured: then
/// it tells nothing and is left out.
bool take_shape(const MeasuredMode& mode, const std::vector<ShapeColumn>& columns, Eigen::Index freedoms,
                ObservedMode& own) {
    std::complex<double> squares = 0;
    for (const ShapeColumn& one : columns) {
        const std::complex<double>& value = mode.shape[one.column];
        if (std::isfinite(std::abs(value))) squares += value * value;
    }
    const std::complex<double> turn = std::polar(1.0, -0.5 * std::arg(squares));
    own.shape.setConstant(freedoms, kNotMeasured);
    double largest = 0;
    bool is_measured = false;
    for (const ShapeColumn& one : columns) {
        const std::complex<double>& value = mode.shape[one.column];
        if (!std::isfinite(std::abs(value))) continue;
        is_measured = true;
        own.shape(one.row) = one.factor * (turn * value).real();
        largest = std::max(largest, std::abs(own.shape(one.row)));
    }
    if (largest > 0)
        own.shape /= largest;
    else
        own.shape.resize(0);
    return is_measured && largest == 0;
}

}  // namespace

std::optional<ObservedFreedom> find_freedom(ModelNames& names, const std::string& name) {
    const auto place_of = [&](const std::string& text) { return names.machine().find(text); };
    const auto& directions = direction_names();
    const size_t dot = name.rfind('.');
    if (dot == name.npos) {
        const auto free = names.modal_model().modes.directions;
        if (!place_of(name) || free.count() != 1) return std::nullopt;
        for (int d = 0; d < 6; ++d)
            if (free[as_size(d)]) return ObservedFreedom{name, d};
    }
    std::string owner = name.substr(0, dot), axis = name.substr(dot + 1);
    const size_t second = owner.rfind('.');
    if (second != owner.npos && !place_of(owner)) {
        const std::string quantity = owner.substr(second + 1);
        if (quantity == "rotation" || quantity == "angular_velocity") axis = "r" + axis;
        owner.resize(second);
    }
    const auto direction = std::ranges::find(directions, axis);
    if (!place_of(owner) || direction == directions.end()) return std::nullopt;
    return ObservedFreedom{owner, as_int(direction - directions.begin())};
}

void add_modes(const Measurement& measurement, const NoiseLevel& noise, ModelNames& names, ColumnMaps& maps,
               Observations& observations, Warnings& warnings) {
    std::vector<ShapeColumn> columns;
    size_t unknown = 0;
    std::string example;
    for (size_t i = 0; i < measurement.shape_names.size(); ++i) {
        const std::string& column = measurement.shape_names[i];
        const MeasuredChannel* map = maps.find(column);
        const std::optional<ObservedFreedom> freedom = find_freedom(names, map ? map->channel : column);
        if (!freedom && map)
            throw Error(ExitCode::usage, fmt::format("{}: {} is no place and direction of the model, as plate.z", map->place,
                                                     quote(map->channel)));
        if (!freedom) {
            if (unknown++ == 0) example = column;
            continue;
        }
        maps.claim(fmt::format("{}.{}", freedom->place, direction_names()[as_size(freedom->direction)]), quote(column));
        const auto known = std::ranges::find_if(observations.freedoms, [&](const ObservedFreedom& one) {
            return one.place == freedom->place && one.direction == freedom->direction;
        });
        columns.push_back(
            {i, known - observations.freedoms.begin(), (map && map->is_reversed ? -1 : 1) / (map ? map->gain : 1)});
        if (known == observations.freedoms.end()) observations.freedoms.push_back(*freedom);
    }
    if (unknown > 0)
        warnings.note("unmapped",
                      fmt::format("{} of the shapes, as {}: not used; --map COLUMN=PLACE.DIRECTION says what it is",
                                  counted(unknown, "column is no place and direction of the model",
                                          "columns are no places and directions of the model"),
                                  quote(example)));
    observations.are_frequencies_known = observations.are_frequencies_known || noise.is_known();
    std::map<int, int> rows_of_number;
    size_t zeros = 0;
    std::string first_zero;
    for (size_t i = 0; i < measurement.modes.size(); ++i) {
        const MeasuredMode& mode = measurement.modes[i];
        ObservedMode own;
        own.place = mode.place;
        own.frequency = mode.frequency / observations.clock;
        own.damping = mode.damping;
        own.number = mode.number > 0 ? mode.number : as_int(i + 1);
        own.row_of_number = rows_of_number[own.number]++;
        own.deviation = noise.absolute > 0 ? noise.absolute / own.frequency : noise.share;
        if (mode.frequency_deviation > 0) {
            own.deviation = mode.frequency_deviation / mode.frequency;
            observations.are_frequencies_known = true;
        }
        if (take_shape(mode, columns, as_row(observations.freedoms.size()), own) && zeros++ == 0)
            first_zero = fmt::format("{} of {:.6g} Hz", mode.place, mode.frequency);
        observations.modes.push_back(std::move(own));
    }
    if (zeros > 0)
        warnings.add(
            "zero-shapes",
            fmt::format("{}, as {}: not used. Without a shape a mode is taken for the model's mode of its number; "
                        "delete the row if its frequency is no mode of the model",
                        counted(zeros, "shape is zero at all sensors", "shapes are zero at all sensors"), first_zero));
}

void complete_shapes(Observations& observations) {
    for (ObservedMode& mode : observations.modes)
        if (mode.shape.size() > 0)
            mode.shape.conservativeResizeLike(Eigen::VectorXd::Constant(as_row(observations.freedoms.size()), kNotMeasured));
}

}  // namespace dttmm::host
