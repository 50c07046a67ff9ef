// SPDX-License-Identifier: BSD-3-Clause
#include "report/structure.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "analysis/machine_geometry.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector3d;

Vector3d vector_of(const Json& json) {
    return {json.at(0).get<double>(), json.at(1).get<double>(), json.at(2).get<double>()};
}

Matrix3d matrix_of(const Json& json) {
    Matrix3d matrix;
    for (int row = 0; row < 3; ++row) matrix.row(row) = vector_of(json.at(as_size(row)));
    return matrix;
}

/// Members of an object; none of anything else.
template <class Take>
void each(const Json& model, const char* table, const Take& take) {
    if (model.is_object() && model.contains(table) && model[table].is_object())
        for (const auto& [name, value] : model[table].items()) take(name, value);
}

}  // namespace

std::vector<Vector3d> corners_of(const InertiaBox& box) {
    constexpr std::array<std::array<double, 3>, 8> kSigns = {
        {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}}};
    std::vector<Vector3d> corners;
    for (const auto& [x, y, z] : kSigns)
        corners.emplace_back(box.centre + box.turn * (0.5 * Vector3d(x, y, z).cwiseProduct(box.edges)));
    return corners;
}

Structure::Structure(const Json& model) {
    add_owners(model);
    each(model, "elements", [&](const std::string& name, const Json& one) {
        ElementLine element{name, one.at("type").get<std::string>(), {}, 0};
        std::vector<const OwnedPoint*> ends;
        if (one.contains("at"))
            for (const Json& place : one["at"]) ends.push_back(point_of(place));
        else
            for (const char* end : {"from", "to"}) ends.push_back(one.contains(end) ? point_of(one[end]) : nullptr);
        const auto known = std::ranges::find_if(ends, [](const OwnedPoint* end) { return end != nullptr; });
        if (known == ends.end()) return;
        // An end at the ground is where the other end is at the start
        const OwnedPoint fixed{-1, at_start(**known)};
        for (const OwnedPoint* end : ends) element.points.push_back(end ? *end : fixed);
        if (one.contains("section") && one["section"].is_object())
            for (const char* shape : {"tube", "circle", "rectangle"})
                if (one["section"].contains(shape))
                    for (const Json& length : one["section"][shape])
                        if (length.is_number()) element.diameter = std::max(element.diameter, length.get<double>());
        elements_.push_back(std::move(element));
    });
    measure();
}

void Structure::add_owners(const Json& model) {
    const auto add_place = [&](const std::string& name, const OwnedPoint& point) {
        place_of_.emplace(name, as_int(places_.size()));
        places_.push_back({name, point});
    };
    const auto add_owner = [&](const std::string& name, const Json& one) -> Owner& {
        owner_of_.emplace(name, as_int(owners_.size()));
        add_place(name, {as_int(owners_.size()), Vector3d::Zero()});
        return owners_.emplace_back(
            Owner{name, vector_of(one.at("position")), Quaterniond(matrix_of(one.at("rotation"))).normalized(), {}, false});
    };
    each(model, "bodies", [&](const std::string& name, const Json& body) {
        Owner& owner = add_owner(name, body);
        const EqualBox box = equal_box(body.at("mass").get<double>(), matrix_of(body.at("inertia")));
        owner.box = InertiaBox{vector_of(body.at("center_of_mass")), Quaterniond(box.axes), box.edges};
        each(body, "markers", [&](const std::string& marker, const Json& at) {
            add_place(name + "." + marker, {as_int(owners_.size()) - 1, vector_of(at)});
        });
    });
    each(model, "nodes", [&](const std::string& name, const Json& node) {
        add_owner(name, node).is_fixed = node.contains("fixed") && node["fixed"].size() == 6;
    });
}

const OwnedPoint* Structure::point_of(const Json& name) const {
    const int place = name.is_string() ? find_place(name.get<std::string>()) : -1;
    return place < 0 ? nullptr : &places_[as_size(place)].point;
}

int Structure::find_place(std::string_view name) const {
    const auto found = place_of_.find(std::string(name));
    return found == place_of_.end() ? -1 : found->second;
}

int Structure::find_owner(std::string_view name) const {
    const auto found = owner_of_.find(std::string(name));
    return found == owner_of_.end() ? -1 : found->second;
}

Vector3d Structure::at_start(const OwnedPoint& point) const {
    if (point.owner < 0) return point.local;
    const Owner& owner = owners_[as_size(point.owner)];
    return owner.position + owner.turn * point.local;
}

void Structure::measure() {
    if (places_.empty()) return;
    Vector3d low = Vector3d::Constant(INFINITY), high = -low;
    const auto add = [&](const OwnedPoint& point) {
        const Vector3d at = at_start(point);
        low = low.cwiseMin(at);
        high = high.cwiseMax(at);
    };
    for (const NamedPlace& place : places_) add(place.point);
    for (std::size_t i = 0; i < owners_.size(); ++i)
        if (owners_[i].box)
            for (const Vector3d& corner : corners_of(*owners_[i].box)) add({as_int(i), corner});
    constexpr double kSmallest = 1e-6;  // [m] a lone node has no size
    size_ = std::max((high - low).norm(), kSmallest);
    if (!std::isfinite(size_))
        throw Error(ExitCode::input_output, "summary.json: damaged: the model has places or inertias that are no numbers");
}

}  // namespace dttmm::host
