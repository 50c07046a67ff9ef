// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <Eigen/Geometry>

#include "loader/plugins.h"
#include "model/model.h"
#include "support/bodies.h"
#include "support/spring_values.h"

namespace dttmm::test {

using namespace host;

inline Signal constant(double value) {
    struct Constant : Signal::Shape {
        explicit Constant(double v) : value_(v) {}
        double value(double) const override { return value_; }
        double value_;
    };
    return Signal(std::make_shared<Constant>(value));
}

/// a (3 s² − 2 s³), s = t/T clipped to 0…1: the load of the four-bolt plate.
inline Signal smooth_rise(double amplitude, double rise_time) {
    struct Rise : Signal::Shape {
        Rise(double a, double T) : a_(a), T_(T) {}
        double value(double time) const override {
            const double s = std::clamp(time / T_, 0.0, 1.0);
            return a_ * s * s * (3 - 2 * s);
        }
        double a_, T_;
    };
    return Signal(std::make_shared<Rise>(amplitude, rise_time));
}

/// A spring-damper, the same stiffness k and damping c in every translation.
inline Element spring(const std::string& name, const Plugins& plugins, const Attachment& from, const Attachment& to,
                      double k, double c) {
    Element element;
    element.name = name;
    element.type = plugins.catalogue().find("spring_damper");
    element.ends = {from, to};
    element.values = spring_values({k, k, k, c, c, c});
    element.place = name;
    return element;
}

inline constexpr double kPlateMass = 9.42;  // 300 x 200 x 20 mm of steel
inline const Eigen::Vector3d kPlateSize(0.3, 0.2, 0.02);
inline const Eigen::Vector3d kCorners[] = {{0.13, 0.08, 0}, {-0.13, 0.08, 0}, {-0.13, -0.08, 0}, {0.13, -0.08, 0}};

/// N plates above each other, each bolted to the one below (the first to the ground) by four bolts; the top one is pulled
/// up. N = 1 is the four-bolt plate.
inline Model plate_stack(const Plugins& plugins, int count, double k, double c, double step, Coupling coupling) {
    Model model;
    model.simulation.step = step;
    model.simulation.duration = 1;
    model.simulation.coupling = coupling;
    for (int p = 0; p < count; ++p) {
        Body plate = box(fmt::format("plate{}", p + 1), kPlateMass, kPlateSize, {0, 0, 0.03 * p});
        for (int i = 0; i < 4; ++i) {
            Marker corner;
            corner.name = fmt::format("corner{}", i + 1);
            corner.position = kCorners[i];
            plate.markers.push_back(corner);
        }
        model.bodies.push_back(plate);
        for (int i = 0; i < 4; ++i) {
            const Attachment below = p == 0 ? Attachment{} : Attachment{p - 1, i};
            model.elements.push_back(spring(fmt::format("bolt{}_{}", p + 1, i + 1), plugins, below, {p, i}, k, c));
        }
    }
    Load pull;
    pull.on = {count - 1, -1};
    pull.direction = Eigen::Vector3d::UnitZ();
    pull.signal = smooth_rise(1000, 18.4e-3);
    model.loads.push_back(pull);
    return model;
}

}  // namespace dttmm::test
