// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/error_scale.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>

#include "model/index.h"

namespace dttmm::host {

namespace {

/// A channel's value times `factor` is comparable with all values of the kind.
struct Kind {
    std::string name;
    double factor = 1;
};

Kind kind_of(const Channel& channel, double L) {
    const std::string& unit = channel.unit();
    if (channel.quantity() == "quaternion" || unit == "rad") return {"m", L};
    if (unit == "rad/s") return {"m/s", L};
    if (unit == "rad/s^2") return {"m/s^2", L};
    if (unit == "N*m") return {"N", 1 / L};
    return {unit};
}

double size_of_machine(const Model& model) {
    std::vector<Eigen::Vector3d> points;
    double gyration = 0;
    for (const Body& body : model.bodies) {
        points.push_back(body.position);
        points.push_back(body.position + body.rotation * body.center_of_mass);
        for (const Marker& marker : body.markers) points.push_back(body.position + body.rotation * marker.position);
        gyration = std::max(gyration, std::sqrt(body.inertia.diagonal().maxCoeff() / body.mass));
    }
    for (const Node& node : model.nodes) points.push_back(node.position);
    Eigen::Vector3d low = points.front(), high = low;
    for (const Eigen::Vector3d& point : points) {
        low = low.cwiseMin(point);
        high = high.cwiseMax(point);
    }
    const double size = std::max((high - low).norm(), 2 * gyration);
    return size > 0 ? size : 1;  // a single node has none
}

}  // namespace

std::vector<double> error_scales(const Model& model, const FastestMode& fastest, const Recorder& seen, double h) {
    const double L = size_of_machine(model);
    const auto channel_count = as_int(seen.channels().size());
    std::vector<Kind> kinds;
    for (const Channel& channel : seen.channels()) kinds.push_back(kind_of(channel, L));

    std::map<std::string, double> largest;
    double coordinate = L;
    for (int c = 1; c < channel_count; ++c) {
        const ChannelStatistics& statistics = seen.statistics(c);
        const Kind& kind = kinds[as_size(c)];
        const double size = kind.name == "m" ? statistics.maximum - statistics.minimum : statistics.peak;
        largest[kind.name] = std::max(largest[kind.name], kind.factor * size);
        if (seen.channels()[as_size(c)].unit() == "m") coordinate = std::max(coordinate, statistics.peak);
    }

    double m = model.bodies.empty() ? 1 : 0;  // what nodes weigh is the plugin's
    for (const Body& body : model.bodies) m = std::max(m, body.mass);
    constexpr double kRest = 1e-11;  // of the largest coordinate; rounding moved machines at rest by 3e-14
    const std::optional<double>& tolerance = model.simulation.tolerance;
    const double rho = tolerance && largest["m"] <= kRest * coordinate ? kRest * coordinate / *tolerance
                                                                       : std::max(1e-9 * largest["m"], 1e-12 * coordinate),
                 omega_2 = fastest.omega * fastest.omega;
    const std::pair<const char*, double> floors[] = {{"m", rho},
                                                     {"m/s", rho / h},
                                                     {"m/s^2", rho / (h * h)},
                                                     {"N", m * omega_2 * rho},
                                                     {"J", m * (omega_2 + 1 / (h * h)) * rho * rho}};
    for (const auto& [kind, floor] : floors) largest[kind] = std::max(largest[kind], floor);

    std::vector<double> scales;
    for (const Kind& kind : kinds) scales.push_back(largest[kind.name] / kind.factor);
    return scales;
}

}  // namespace dttmm::host
