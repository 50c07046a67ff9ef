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

/// What one would write without dttmm: a stack of bodies, four explicit springs below each, dWorldStep.
class BareLoop {
public:
    explicit BareLoop(int count) : world_(dWorldCreate()) {
        dMass mass;
        dMassSetBoxTotal(&mass, test::kPlateMass, 0.3, 0.2, 0.02);
        for (int p = 0; p < count; ++p) {
            bodies_.push_back(dBodyCreate(world_));
            dBodySetMass(bodies_.back(), &mass);
        }
        dWorldSetAutoDisableFlag(world_, 0);
    }
    ~BareLoop() { dWorldDestroy(world_); }
    BareLoop(const BareLoop&) = delete;
    BareLoop& operator=(const BareLoop&) = delete;

    void step() {
        const double s = std::clamp(time() / 18.4e-3, 0.0, 1.0);
        dBodyAddForce(bodies_.back(), 0, 0, 1000 * s * s * (3 - 2 * s));
        for (size_t p = 0; p < bodies_.size(); ++p)
            for (const Eigen::Vector3d& corner : test::kCorners)
                add_bolt(bodies_[p], p > 0 ? bodies_[p - 1] : nullptr, corner);
        dWorldStep(world_, kStep);
        ++steps_;
    }
    double lift(size_t plate) const { return dBodyGetPosition(bodies_[plate])[2]; }
    double time() const { return steps_ * kStep; }

private:
    static void add_bolt(dBodyID body, dBodyID below, const Eigen::Vector3d& corner) {
        dVector3 p, v, q = {corner.x(), corner.y(), corner.z()}, w = {0, 0, 0};
        dBodyGetRelPointPos(body, corner.x(), corner.y(), corner.z(), p);
        dBodyGetRelPointVel(body, corner.x(), corner.y(), corner.z(), v);
        if (below) {
            dBodyGetRelPointPos(below, corner.x(), corner.y(), corner.z(), q);
            dBodyGetRelPointVel(below, corner.x(), corner.y(), corner.z(), w);
        }
        const double f[] = {kStiffness * (p[0] - q[0]) + kDamping * (v[0] - w[0]),
                            kStiffness * (p[1] - q[1]) + kDamping * (v[1] - w[1]),
                            kStiffness * (p[2] - q[2]) + kDamping * (v[2] - w[2])};
        dBodyAddForceAtRelPos(body, -f[0], -f[1], -f[2], corner.x(), corner.y(), corner.z());
        if (below) dBodyAddForceAtRelPos(below, f[0], f[1], f[2], corner.x(), corner.y(), corner.z());
    }

    dWorldID world_;
    std::vector<dBodyID> bodies_;
    int steps_ = 0;
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
        for (size_t i = 0; i < 3; ++i) model.elements[0].values.change()[i] *= 0.8;
    return model;
}

void time_plate(benchmark::State& state, Coupling coupling, bool lively) {
    const Plugins plugins;
    const Model model = plate(plugins, coupling, lively);
    Simulation simulation(model, plugins);
    BareLoop bare(1);
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

/// Largest error of a plate's lift, as a share of the static stretch of the stack. lift(p): that of a plate.
template <class Lift>
double stack_error(int count, double time, const Lift& lift) {
    const Eigen::VectorXd exact = test::exact_chain(count, kStiffness, kDamping, time);
    double worst = 0;
    for (int p = 0; p < count; ++p) worst = std::max(worst, std::abs(lift(static_cast<size_t>(p)) - exact(p)));
    return worst / (1000.0 * count / (4 * kStiffness));
}

void stack_implicit(benchmark::State& state) {
    const auto count = static_cast<int>(state.range(0));
    const Plugins plugins;
    const Model model = test::plate_stack(plugins, count, kStiffness, kDamping, kStep, Coupling::implicit);
    Simulation simulation(model, plugins);
    BareLoop bare(count);
    const int steps = std::max(20, 20000 / count);
    for (int n = 0; n < 200; ++n) {
        simulation.step();
        bare.step();
    }
    const double error = stack_error(count, simulation.time(), [&](size_t p) {
        return simulation.bodies()[p].position.z() - model.bodies[p].position.z();
    });
    const double bare_error = stack_error(count, bare.time(), [&](size_t p) { return bare.lift(p); });
    std::vector<double> ours, theirs;
    for (auto _ : state) {
        theirs.push_back(time_per_step(bare, steps));
        ours.push_back(time_per_step(simulation, steps));
        state.SetIterationTime(steps * ours.back());
    }
    state.counters["us_per_step"] = 1e6 * median(ours);
    state.counters["bare_us"] = 1e6 * median(theirs);
    state.counters["ratio"] = median(ours) / median(theirs);
    state.counters["passes"] =
        static_cast<double>(simulation.end_of_step().passes()) / static_cast<double>(simulation.index());
    state.counters["error_at_0.2s"] = error;
    state.counters["bare_error"] = bare_error;
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
