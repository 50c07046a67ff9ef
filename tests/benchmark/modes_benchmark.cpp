// SPDX-License-Identifier: BSD-3-Clause
//
// Natural frequencies: the eight of the hydroplane system, and the first eight of a rail of n beams on n + 1 sleepers, by
// the time of one count, which is one factorisation. Reading the model is not counted.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <chrono>

#include "analysis/modal_machine.h"
#include "benchmark/median.h"
#include "loader/plugins.h"
#include "model/read_model.h"

namespace dttmm {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_to_find_modes(const Model& model, const Plugins& plugins) {
    const auto start = Clock::now();
    ModalMachine machine(model, plugins);
    benchmark::DoNotOptimize(machine.find_modes());
    return std::chrono::duration<double>(Clock::now() - start).count();
}

void hydroplane(benchmark::State& state) {
    const Plugins plugins;
    ModelOverrides overrides;
    overrides.purpose = Purpose::modes;
    const Model model = read_model(DTTMM_SOURCE_DIR "/examples/hydroplane/model.toml", plugins.catalogue(), overrides);
    for (auto _ : state) state.SetIterationTime(seconds_to_find_modes(model, plugins));
}
BENCHMARK(hydroplane)->UseManualTime()->Unit(benchmark::kMillisecond);

/// Stiffnesses all differ a little, so that no two frequencies are equal.
Model rail(const Plugins& plugins, long beams) {
    std::string text = "format = \"dttmm/1\"\ndofs = [\"z\", \"ry\"]\n[modes]\ncount = 8\n[nodes]\n";
    for (long i = 0; i <= beams; ++i) text += fmt::format("n{} = [{}, 0, 0]\n", i, 0.6 * static_cast<double>(i));
    for (long i = 0; i < beams; ++i)
        text += fmt::format(
            "[[element]]\nname = \"b{0}\"\ntype = \"beam\"\ntheory = \"euler-bernoulli\"\nfrom = \"n{0}\"\nto = \"n{1}\"\n"
            "section = {{ EA = 1.6e9, EIy = 6.4e6, mass = 60 }}\n",
            i, i + 1);
    for (long i = 0; i <= beams; ++i)
        text += fmt::format(
            "[[element]]\nname = \"s{0}\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = \"n{0}\"\n"
            "stiffness = [0, 0, {1}]\n",
            i,
            5e7 *
                (1 + 0.02 * static_cast<double>((i * 7) % 5) + 1e-3 * static_cast<double>(i) / static_cast<double>(beams)));
    ModelOverrides overrides;
    overrides.purpose = Purpose::modes;
    return parse_model(text, "rail.toml", plugins.catalogue(), overrides);
}

void rail_of(benchmark::State& state) {
    const Plugins plugins;
    const Model model = rail(plugins, state.range(0));
    double seconds = 0;
    for (auto _ : state) {
        seconds = seconds_to_find_modes(model, plugins);
        state.SetIterationTime(seconds);
    }
    state.counters["us_per_beam"] = 1e6 * seconds / static_cast<double>(state.range(0));
}
BENCHMARK(rail_of)->Arg(100)->Arg(1000)->Arg(10000)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace dttmm

BENCHMARK_MAIN();
