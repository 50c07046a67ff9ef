// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/loads.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "model/error.h"
#include "support/models.h"
#include "support/states.h"

namespace dttmm::host {
namespace {

Signal parabola() {
    struct Parabola : Signal::Shape {
        double value(double t) const override { return 100 + 30 * t + 7 * t * t; }
    };
    return Signal(std::make_shared<Parabola>());
}

Model loaded_bodies() {
    Model model;
    model.simulation.gravity = {0.1, -0.2, -9.81};
    Body first = test::box("first", 2, {0.1, 0.2, 0.3}, {0, 0, 0});
    Body second = test::box("second", 5, {0.1, 0.2, 0.3}, {1, 2, 3});
    second.center_of_mass = {0.01, 0.02, 0.03};
    second.rotation = Eigen::AngleAxisd(0.6, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    second.markers.push_back({"tip", {0.4, -0.1, 0.2}, nullptr});
    model.bodies = {first, second};
    Load force{{1, 0}, Eigen::Vector3d(1, 2, -2) / 3, false, parabola(), ""};
    Load moment{{0, -1}, Eigen::Vector3d::UnitY(), true, test::constant(4), ""};
    model.loads = {force, moment};
    return model;
}

// Oracle: by hand: m g on every body; the force at the marker with its moment about the centre of mass; the moment alone.
TEST(Loads, AddUpToTheWrenchOnEachBody) {
    const Model model = loaded_bodies();
    const double weights[] = {0.25, 0.5, 0.25}, h = 0.01;
    Loads loads(model, weights);
    loads.start(0);
    loads.begin_step({0, 0, h});
    loads.begin_step({1, h, h});
    std::vector<double> wrenches(12, 0.0);
    loads.add_over_step(test::start_states(model), wrenches.data());

    const auto f = [](double t) { return 100 + 30 * t + 7 * t * t; };
    const Eigen::Vector3d force = (f(0) + 2 * f(h) + f(2 * h)) / 4 * Eigen::Vector3d(1, 2, -2) / 3;
    const Eigen::Vector3d arm =
        model.bodies[1].rotation * (Eigen::Vector3d(0.4, -0.1, 0.2) - model.bodies[1].center_of_mass);
    const Eigen::Map<const Eigen::Vector3d> f0(&wrenches[0]), m0(&wrenches[3]), f1(&wrenches[6]), m1(&wrenches[9]);
    EXPECT_LT((f0 - 2 * model.simulation.gravity).norm(), 1e-14);
    EXPECT_LT((m0 - Eigen::Vector3d(0, 4, 0)).norm(), 1e-14);
    EXPECT_LT((f1 - 5 * model.simulation.gravity - force).norm(), 1e-13);
    EXPECT_LT((m1 - arm.cross(force)).norm(), 1e-13);
}

// Oracle: Newmark's first step takes ¾ of the load at its start and ¼ of that at its end.
TEST(Loads, BeforeTheStartALoadCountsAsAtTheStart) {
    Model model = loaded_bodies();
    model.simulation.gravity.setZero();
    model.loads.pop_back();
    const double weights[] = {0.25, 0.5, 0.25}, h = 0.3;
    Loads loads(model, weights);
    loads.start(0.2);
    loads.begin_step({0, 0.2, h});
    std::vector<double> wrenches(12, 0.0);
    loads.add_over_step(test::start_states(model), wrenches.data());
    const auto f = [](double t) { return 100 + 30 * t + 7 * t * t; };
    EXPECT_NEAR(wrenches[6], (0.75 * f(0.2) + 0.25 * f(0.5)) / 3, 1e-12);
}

// Oracle: force times displacement of its point, moment times rotation, by hand; the force is the mean of both ends of the
// step.
TEST(Loads, WorkIsTheMeanForceTimesTheWayOfItsPoint) {
    Model model = loaded_bodies();
    model.bodies[1].velocity = {1, 2, 3};
    model.bodies[1].angular_velocity = {-3, 0.5, 2};
    model.bodies[0].angular_velocity = {0, 7, 0};
    const double weights[] = {0, 1, 0};
    Loads loads(model, weights);
    loads.start(0);
    loads.begin_step({0, 0, 0.01});
    const std::vector<BodyState> at = test::start_states(model);
    std::vector<BodyState> after = at;
    const Eigen::Vector3d marker = Eigen::Vector3d(0.4, -0.1, 0.2) - model.bodies[1].center_of_mass;
    after[1].position += Eigen::Vector3d(0.02, 0.01, -0.03);
    after[1].rotation = Eigen::AngleAxisd(0.3, Eigen::Vector3d(0.6, 0, 0.8)) * at[1].rotation;
    const Eigen::Vector3d way = Eigen::Vector3d(0.02, 0.01, -0.03) + after[1].rotation * marker - at[1].rotation * marker;
    const double f = 0.5 * (model.loads[0].signal.value(0) + model.loads[0].signal.value(0.01));
    EXPECT_NEAR(loads.work_over_step(at, after, 0.01), f * Eigen::Vector3d(1, 2, -2).dot(way) / 3 + 0.01 * 4 * 7, 1e-11);
}

TEST(Loads, AValueThatIsNotFiniteIsRefused) {
    Model model = loaded_bodies();
    model.loads[0].signal = test::constant(std::numeric_limits<double>::quiet_NaN());
    const double weights[] = {0, 1, 0};
    Loads loads(model, weights);
    EXPECT_THROW(loads.start(0), Error);
}

// Oracle: the signals themselves. Loads on nodes are handed on as they are, at the end of the step, and move no body.
TEST(Loads, LoadsOnNodesAreThoseAtTheEndOfTheStep) {
    Model model;
    model.bodies.push_back(test::box("block", 2, {1, 1, 1}, {0, 0, 0}));
    model.nodes.resize(3);
    for (int n : {0, 2, 2}) {
        Load load;
        load.on = {-1, -1, n};
        load.direction = n == 0 ? Eigen::Vector3d(0.6, 0, 0.8) : Eigen::Vector3d(0, 1, 0);
        load.is_moment = n == 0;
        load.signal = test::smooth_rise(10, 0.3);
        model.loads.push_back(load);
    }
    const double weights[] = {0.25, 0.5, 0.25}, h = 0.1;
    Loads loads(model, weights);
    const auto expect_loads = [&](double t) {
        const double f = model.loads[0].signal.value(t);
        const double expected[] = {0, 0, 0, 0.6 * f, 0, 0.8 * f, 0, 0, 0, 0, 0, 0, 0, 2 * f, 0, 0, 0, 0};
        for (size_t i = 0; i < 18; ++i) EXPECT_NEAR(loads.on_networks()[i], expected[i], 1e-14) << i << " at " << t;
    };
    loads.start(0.05);
    expect_loads(0.05);
    loads.begin_step({0, 0.05, h});
    expect_loads(0.15);
    std::vector<double> wrench(6);
    const std::vector<BodyState> at(1);
    loads.add_over_step(at, wrench.data());
    EXPECT_EQ(wrench, std::vector<double>(6));
    EXPECT_EQ(loads.work_over_step(at, at, 0.1), 0);
}

}  // namespace
}  // namespace dttmm::host
