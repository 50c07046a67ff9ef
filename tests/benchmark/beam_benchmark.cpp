// SPDX-License-Identifier: BSD-3-Clause
//
// A steel beam of n lumps between the ground and a body of 5 kg, its tip struck by a sudden force: time per step and lump,
// time per simulated second, and the error of the tip against the exact Timoshenko beam.
#include <benchmark/benchmark.h>
#include <fmt/format.h>
#include <ode/ode.h>

#include <algorithm>
#include <chrono>
#include <span>
#include <vector>

#include "benchmark/median.h"
#include "loader/plugins.h"
#include "model/read_model.h"
#include "step/simulation.h"
#include "support/exact_timoshenko.h"

namespace dttmm::host {
namespace {

constexpr double kStep = 0.25e-3, kForce = 100, kMass = 5, kInertia = 0.01;

Model beam_and_body(const Plugins& plugins, long lumps) {
    return parse_model(fmt::format(R"(
format = "dttmm/1"
[simulation]
duration = 10
step = {}
[nodes]
root = {{ position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
[[body]]
name = "body"
mass = {}
inertia = {{ xx = {}, yy = {}, zz = {} }}
position = [1.2, 0, 0]
[[load]]
on = "body"
direction = [0, 1, 0]
force = {}
[[element]]
name = "beam"
type = "beam"
from = "root"
to = "body"
segments = {}
section = {{ tube = ["50 mm", "30 mm"] }}
material = {{ E = "204 GPa", poisson = 0.26, density = "7800 kg/m^3" }}
)",
                                   kStep, kMass, kInertia, kInertia, kInertia, kForce, lumps),
                       "beam.toml", plugins.catalogue());
}

test::ExactTipMass exact_tip() {
    constexpr double A = M_PI / 4 * (0.05 * 0.05 - 0.03 * 0.03), E = 204e9, G = E / (2 * 1.26);
    const double I = M_PI / 64 * (0.05 * 0.05 * 0.05 * 0.05 - 0.03 * 0.03 * 0.03 * 0.03);
    return {{E * I, 0.578867 * G * A, 7800 * A, 7800 * I, 1.2}, kMass, kInertia, 12};
}

/// Largest error over 0.2 s as a share of the largest displacement.
double error_of(Simulation& simulation) {
    const test::ExactTipMass exact = exact_tip();
    double worst = 0, size = 0;
    while (simulation.time() < 0.2) {
        simulation.step();
        const double y = exact.tip(kForce, simulation.time());
        worst = std::max(worst, std::abs(simulation.bodies()[0].position.y() - y));
        size = std::max(size, std::abs(y));
    }
    return worst / size;
}

/// records: a row per step, which is thrown away.
void beam(benchmark::State& state, bool records) {
    const long lumps = state.range(0);
    const Plugins plugins;
    const Model model = beam_and_body(plugins, lumps);
    Simulation simulation(model, plugins);
    const double error = error_of(simulation);
    if (records) simulation.record_to([](std::span<const double> row) { benchmark::DoNotOptimize(row.data()); });
    const long steps = std::max(20L, 100000 / lumps);
    std::vector<double> times;
    for (auto _ : state) {
        const auto start = std::chrono::steady_clock::now();
        for (long n = 0; n < steps; ++n) simulation.step();
        times.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count() /
                        static_cast<double>(steps));
        state.SetIterationTime(static_cast<double>(steps) * times.back());
    }
    const double typical = median(times);
    state.counters["ns_per_lump_and_step"] = 1e9 * typical / static_cast<double>(lumps);
    state.counters["s_per_simulated_s"] = typical / kStep;
    state.counters["error_percent"] = 100 * error;
}
BENCHMARK_CAPTURE(beam, steps, false)
    ->RangeMultiplier(10)
    ->Range(10, 10000)
    ->UseManualTime()
    ->Iterations(15)
    ->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(beam, rows, true)->Arg(10)->Arg(1000)->UseManualTime()->Iterations(15)->Unit(benchmark::kMillisecond);

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
