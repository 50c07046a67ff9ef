// SPDX-License-Identifier: BSD-3-Clause
//
// Time per step of the four-bolt plate and of stacks of such plates, recording off, beside a hand-written ODE loop with the
// same four springs and no plugin. "ratio" is the time over that loop's, both the median of rounds taken in turn in this
// very run, so that it holds on a machine whose speed drifts.
#include <benchmark/benchmark.h>
#include <ode/ode.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "benchmark/median.h"
#include "step/simulation.h"
#include "support/exact_chain.h"
#include "support/models.h"

namespace dttmm::host {
namespace {

constexpr double kStiffness = 5e5, kDamping = 100, kStep = 1e-3;

/// What one would write without dttmm: one body, four explicit springs, dWorldStep.
class BareLoop {
public:
    BareLoop() : world_(dWorldCreate()), body_(dBodyCreate(world_)) {
        dMass mass;
        dMassSetBoxTotal(&mass, test::kPlateMass, 0.3, 0.2, 0.02);
        dBodySetMass(body_, &mass);
        dWorldSetAutoDisableFlag(world_, 0);
    }
    ~BareLoop() { dWorldDestroy(world_); }
    BareLoop(const BareLoop&) = delete;
    BareLoop& operator=(const BareLoop&) = delete;

    void step() {
        const double s = std::clamp(time_ / 18.4e-3, 0.0, 1.0);
        dBodyAddForce(body_, 0, 0, 1000 * s * s * (3 - 2 * s));
        for (const Eigen::Vector3d& corner : test::kCorners) {
            dVector3 p, v;
            dBodyGetRelPointPos(body_, corner.x(), corner.y(), corner.z(), p);
            dBodyGetRelPointVel(body_, corner.x(), corner.y(), corner.z(), v);
            dBodyAddForceAtRelPos(body_, -kStiffness * (p[0] - corner.x()) - kDamping * v[0],
                                  -kStiffness * (p[1] - corner.y()) - kDamping * v[1],
                                  -kStiffness * (p[2] - corner.z()) - kDamping * v[2], corner.x(), corner.y(), corner.z());
        }
        dWorldStep(world_, kStep);
        time_ += kStep;
    }

private:
    dWorldID world_;
    dBodyID body_;
    double time_ = 0;
};

template <class Stepper>
double time_per_step(Stepper& stepper, int steps) {
    const auto start = std::chrono::steady_clock::now();
    for (int i = 0; i < steps; ++i) stepper.step();
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() / steps;
}

/// A plate that keeps moving, so that the figures are those of work: bolt 1 softer and no damping where `lively`.
Model plate(const Plugins& plugins, Coupling coupling, bool lively) {
    Model model = test::plate_stack(plugins, 1, kStiffness, lively ? 0 : kDamping, kStep, coupling);
    if (lively)
        for (size_t i = 0; i < 3; ++i) model.elements[0].values[i] *= 0.8;
    return model;
}

void time_plate(benchmark::State& state, Coupling coupling, bool lively) {
    const Plugins plugins;
    const Model model = plate(plugins, coupling, lively);
    Simulation simulation(model, plugins);
    BareLoop bare;
    std::vector<double> ours, theirs;
    time_per_step(simulation, 1000);
    for (auto _ : state) {
        theirs.push_back(time_per_step(bare, 2000));
        ours.push_back(time_per_step(simulation, 2000));
        state.SetIterationTime(2000 * ours.back());
    }
    state.counters["us_per_step"] = 1e6 * median(ours);
    state.counters["bare_us"] = 1e6 * median(theirs);
    state.counters["ratio"] = median(ours) / median(theirs);
    state.counters["passes"] =
        static_cast<double>(simulation.end_of_step().passes()) / static_cast<double>(simulation.index());
}

void plate_implicit(benchmark::State& state) { time_plate(state, Coupling::implicit, false); }
void plate_explicit(benchmark::State& state) { time_plate(state, Coupling::explicit_, false); }
void plate_implicit_soft_bolt_undamped(benchmark::State& state) { time_plate(state, Coupling::implicit, true); }
void plate_explicit_soft_bolt_undamped(benchmark::State& state) { time_plate(state, Coupling::explicit_, true); }

BENCHMARK(plate_implicit)->UseManualTime()->Iterations(101)->Unit(benchmark::kMicrosecond);
BENCHMARK(plate_explicit)->UseManualTime()->Iterations(101)->Unit(benchmark::kMicrosecond);
BENCHMARK(plate_implicit_soft_bolt_undamped)->UseManualTime()->Iterations(101)->Unit(benchmark::kMicrosecond);
BENCHMARK(plate_explicit_soft_bolt_undamped)->UseManualTime()->Iterations(101)->Unit(benchmark::kMicrosecond);

/// Largest error of a plate's lift, as a share of the static stretch of the stack.
double stack_error(const Simulation& simulation, const Model& model) {
    const auto count = static_cast<int>(model.bodies.size());
    const Eigen::VectorXd exact = test::exact_chain(count, kStiffness, kDamping, simulation.time());
    double worst = 0;
    for (int p = 0; p < count; ++p) {
        const auto i = static_cast<size_t>(p);
        worst = std::max(worst, std::abs(simulation.bodies()[i].position.z() - model.bodies[i].position.z() - exact(p)));
    }
    return worst / (1000.0 * count / (4 * kStiffness));
}

void stack_implicit(benchmark::State& state) {
    const auto count = static_cast<int>(state.range(0));
    const Plugins plugins;
    const Model model = test::plate_stack(plugins, count, kStiffness, kDamping, kStep, Coupling::implicit);
    Simulation simulation(model, plugins);
    const int steps = std::max(20, 20000 / count);
    for (int n = 0; n < 200; ++n) simulation.step();
    const double error = stack_error(simulation, model);
    std::vector<double> times;
    for (auto _ : state) {
        times.push_back(time_per_step(simulation, steps));
        state.SetIterationTime(steps * times.back());
    }
    state.counters["us_per_step"] = 1e6 * median(times);
    state.counters["us_per_plate"] = 1e6 * median(times) / count;
    state.counters["passes"] =
        static_cast<double>(simulation.end_of_step().passes()) / static_cast<double>(simulation.index());
    state.counters["error_at_0.2s"] = error;
}
BENCHMARK(stack_implicit)
    ->RangeMultiplier(10)
    ->Range(1, 1000)
    ->UseManualTime()
    ->Iterations(31)
    ->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace dttmm::host

int main(int argc, char** argv) {
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
    dCloseODE();
    return 0;
}
