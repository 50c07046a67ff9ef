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
#include "support/paths.h"

namespace dttmm::host {
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
    const Model model =
        read_model(test::paths::source_dir() + "/examples/hydroplane/model.toml", plugins.catalogue(), overrides);
    for (auto _ : state) state.SetIterationTime(seconds_to_find_modes(model, plugins));
}
BENCHMARK(hydroplane)->UseManualTime()->Unit(benchmark::kMillisecond);

/// Bars and masses in a row, held at one end, their stiffnesses a little different: waves along it.
Model chain(const Plugins& plugins, long bars) {
    std::string text =
        "format = \"dttmm/1\"\ndofs = [\"x\"]\n[modes]\ncount = 8\n[nodes]\nn0 = { position = [0, 0, 0], fixed = [\"x\"] "
        "}\n";
    for (long i = 1; i <= bars; ++i) text += fmt::format("n{} = [{}, 0, 0]\n", i, 0.6 * static_cast<double>(i));
    for (long i = 0; i < bars; ++i)
        text += fmt::format(
            "[[element]]\nname = \"b{0}\"\ntype = \"rod\"\nfrom = \"n{0}\"\nto = \"n{1}\"\n"
            "section = {{ EA = {2}, mass = 60 }}\n[[element]]\nname = \"m{0}\"\ntype = \"point_mass\"\nat = \"n{1}\"\nmass "
            "= 20\n",
            i, i + 1, 1.6e9 * (1 + 0.02 * static_cast<double>((i * 7) % 5)));
    ModelOverrides overrides;
    overrides.purpose = Purpose::modes;
    return parse_model(text, "chain.toml", plugins.catalogue(), overrides);
}

void chain_of(benchmark::State& state) {
    const Plugins plugins;
    const Model model = chain(plugins, state.range(0));
    double seconds = 0;
    for (auto _ : state) {
        seconds = seconds_to_find_modes(model, plugins);
        state.SetIterationTime(seconds);
    }
    state.counters["us_per_element"] = 0.5e6 * seconds / static_cast<double>(state.range(0));
}
BENCHMARK(chain_of)->Arg(50)->Arg(500)->Arg(5000)->UseManualTime()->Unit(benchmark::kMillisecond)->Iterations(1);

}  // namespace
}  // namespace dttmm::host

BENCHMARK_MAIN();
