// SPDX-License-Identifier: BSD-3-Clause
//
// Time per step of the four-bolt plate and of stacks of such plates, recording off, beside a hand-written ODE loop with the
// same four springs and no plugin. "ratio" is the time over that loop's, both the median of rounds taken in turn in this very
// run, so that it holds on a machine whose speed drifts.
#include <benchmark/benchmark.h>
#include <ode/ode.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <vector>

#include "step/simulation.h"
#include "support/models.h"

namespace dttmm {
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

double median(std::vector<double> times) {
    std::nth_element(times.begin(), times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2), times.end());
    return times[times.size() / 2];
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
    state.counters["passes"] = static_cast<double>(simulation.end_of_step().passes()) / static_cast<double>(simulation.index());
}

void plate_implicit(benchmark::State& state) { time_plate(state, Coupling::implicit, false); }
void plate_explicit(benchmark::State& state) { time_plate(state, Coupling::explicit_, false); }
void plate_implicit_soft_bolt_undamped(benchmark::State& state) { time_plate(state, Coupling::implicit, true); }
void plate_explicit_soft_bolt_undamped(benchmark::State& state) { time_plate(state, Coupling::explicit_, true); }

BENCHMARK(plate_implicit)->UseManualTime()->Iterations(101)->Unit(benchmark::kMicrosecond);
BENCHMARK(plate_explicit)->UseManualTime()->Iterations(101)->Unit(benchmark::kMicrosecond);
BENCHMARK(plate_implicit_soft_bolt_undamped)->UseManualTime()->Iterations(101)->Unit(benchmark::kMicrosecond);
BENCHMARK(plate_explicit_soft_bolt_undamped)->UseManualTime()->Iterations(101)->Unit(benchmark::kMicrosecond);

/// Exact end displacements of the axial chain (masses m, springs 4k, dampers 4c to the one below) under the smooth rise at its
/// top: modal superposition; in each mode the load is a polynomial, so the Duhamel integral is a matrix exponential. Here the
/// chain is integrated by the trapezoidal rule at a step 100 times shorter, which is exact to 1e-4 of our own error.
double chain_error(const Simulation& simulation, const Model& model, const std::vector<double>& exact) {
    double worst = 0;
    for (size_t p = 0; p < exact.size(); ++p)
        worst = std::max(worst, std::abs(simulation.bodies()[p].position.z() - model.bodies[p].position.z() - exact[p]));
    return worst / (1000 * static_cast<double>(exact.size()) / (4 * kStiffness));  // of the static stretch of the stack
}

std::vector<double> chain_solution(int count, double end, double h) {
    // Thomas' algorithm for the constant tridiagonal matrix of the trapezoidal rule
    const double m = test::kPlateMass, k = 4 * kStiffness, c = 4 * kDamping;
    const auto n = static_cast<size_t>(count);
    const double stiff = k / 4 + c / (2 * h);
    std::vector<double> x(n), before(n), next(n), diagonal(n), factor(n);
    const auto spring = [&](const std::vector<double>& u, size_t i) {
        return (u[i] - (i > 0 ? u[i - 1] : 0)) - (i + 1 < n ? u[i + 1] - u[i] : 0);
    };
    for (size_t i = 0; i < n; ++i) {
        diagonal[i] = m / (h * h) + (i + 1 < n ? 2 : 1) * stiff;
        if (i > 0) {
            factor[i] = -stiff / diagonal[i - 1];
            diagonal[i] += factor[i] * stiff;
        }
    }
    const auto load = [](double t) {
        const double s = std::clamp(t / 18.4e-3, 0.0, 1.0);
        return 1000 * s * s * (3 - 2 * s);
    };
    const auto steps = static_cast<long>(std::llround(end / h));
    for (long step = 0; step < steps; ++step) {
        const double t = static_cast<double>(step) * h;
        for (size_t i = 0; i < n; ++i)
            next[i] = m * (2 * x[i] - before[i]) / (h * h) - k * (2 * spring(x, i) + spring(before, i)) / 4 + c * spring(before, i) / (2 * h);
        next[n - 1] += (load(t + h) + 2 * load(t) + load(t - h)) / 4;
        for (size_t i = 1; i < n; ++i) next[i] -= factor[i] * next[i - 1];
        next[n - 1] /= diagonal[n - 1];
        for (size_t i = n - 1; i-- > 0;) next[i] = (next[i] + stiff * next[i + 1]) / diagonal[i];
        before.swap(x);
        x.swap(next);
    }
    return x;
}

void stack_implicit(benchmark::State& state) {
    const auto count = static_cast<int>(state.range(0));
    const Plugins plugins;
    const Model model = test::plate_stack(plugins, count, kStiffness, kDamping, kStep, Coupling::implicit);
    Simulation simulation(model, plugins);
    const int steps = std::max(20, 20000 / count);
    for (int n = 0; n < 200; ++n) simulation.step();
    const double error = chain_error(simulation, model, chain_solution(count, 0.2, kStep / 100));
    std::vector<double> times;
    for (auto _ : state) {
        times.push_back(time_per_step(simulation, steps));
        state.SetIterationTime(steps * times.back());
    }
    state.counters["us_per_step"] = 1e6 * median(times);
    state.counters["us_per_plate"] = 1e6 * median(times) / count;
    state.counters["passes"] = static_cast<double>(simulation.end_of_step().passes()) / static_cast<double>(simulation.index());
    state.counters["error_at_0.2s"] = error;
}
BENCHMARK(stack_implicit)->RangeMultiplier(10)->Range(1, 1000)->UseManualTime()->Iterations(31)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace dttmm

int main(int argc, char** argv) {
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
    benchmark::Initialize(&argc, argv);
    benchmark::RunSpecifiedBenchmarks();
    dCloseODE();
    return 0;
}
