// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/line_loads.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "coupling/network_description.h"
#include "model/index.h"

namespace dttmm::host {

std::optional<size_t> segments_at(const dttmm_element_type& type) {
    size_t value = 0;
    for (uint32_t p = 0; p < type.parameter_count; value += type.parameters[p++].count)
        if (std::string_view(type.parameters[p].name) == "segments") return value;
    return std::nullopt;
}

Eigen::Vector3d way_along(const Model& model, const Element& element) {
    return frame_at_start(model, element.ends[1]).position - frame_at_start(model, element.ends[0]).position;
}

std::map<size_t, LineLoads> find_line_loads(const Model& model, const ElementCatalogue& catalogue, double time) {
    struct End {
        double along = 0;
        Eigen::Vector3d steady = Eigen::Vector3d::Zero(), turning = steady;  ///< across, world axes and those of the element
        double across() const { return steady.norm() + turning.norm(); }
    };
    std::map<size_t, std::array<End, 2>> sums;
    std::map<size_t, LineLoads> all;
    for (const Load& load : model.loads) {
        if (!load.is_per_length()) continue;
        const auto e = as_size(load.element);
        const Element& element = model.elements[e];
        const auto at = segments_at(*catalogue.types[as_size(element.type)]);
        if (!at) continue;
        const Eigen::Vector3d way = way_along(model, element);
        LineLoads& own = all[e];
        own.length = way.norm();
        own.segments = element.values[*at];
        const Eigen::Vector3d x = load.turns ? Eigen::Vector3d(Eigen::Vector3d::UnitX()) : Eigen::Vector3d(way / own.length);
        const double along = load.direction.dot(x);
        const std::array<double, 2> values = {load.signal.value(time), load.at_to().value(time)};
        for (const size_t end : {0u, 1u}) {
            End& sum = sums[e][end];
            sum.along += values[end] * along;
            (load.turns ? sum.turning : sum.steady) += values[end] * (load.direction - along * x);
        }
    }
    for (auto& [e, own] : all) {
        const auto& [from, to] = sums[e];
        own.across = std::max(from.across(), to.across());
        own.mean = End{0, 0.5 * (from.steady + to.steady), 0.5 * (from.turning + to.turning)}.across();
        own.rise = std::abs(to.along - from.along);
    }
    return all;
}

}  // namespace dttmm::host
