// SPDX-License-Identifier: BSD-3-Clause
//
// Steady vibration: the engine on its mounts over 260 speeds of three orders, all channels; the headstock at 2000
// frequencies; a chain of bars, by the time of one frequency, beside the same equations as one dense complex matrix in
// Eigen. Reading the model is not counted.
#include <benchmark/benchmark.h>
#include <fmt/format.h>

#include <Eigen/LU>
#include <chrono>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <numeric>
#include <sstream>

#include "analysis/response_curves.h"
#include "loader/plugins.h"
#include "model/read_model.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using Clock = std::chrono::steady_clock;
constexpr double kTurn = 2 * std::numbers::pi;

Model model_of(const std::string& text, const Plugins& plugins) {
    ModelOverrides overrides;
    overrides.purpose = Purpose::modes;
    return parse_model(text, "model.toml", plugins.catalogue(), overrides);
}

std::string example(const std::string& name) {
    std::ifstream file(test::paths::source_dir() + "/examples/" + name + "/model.toml");
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
}

/// Everything that `dttmm response` needs of a model.
struct Machine {
    Machine(const std::string& text, const Plugins& plugins) : model(model_of(text, plugins)), machine(model, plugins) {}
    const Model model;
    ModalMachine machine;
    const ResponseChannels channels{model, machine};

    std::vector<int> all_channels() const {
        std::vector<int> all(channels.all().size() - 1);
        std::iota(all.begin(), all.end(), 1);
        return all;
    }
};

void engine_260_speeds_3_orders(benchmark::State& state) {
    const Plugins plugins;
    std::string text = example("engine_on_inclined_mounts");
    for (const int order : {4, 6})
        text += fmt::format(
            "[[load]]\non = \"engine.crank\"\ndirection = [1, 0, 0]\nmoment = {{ type = \"harmonic\", amplitude = "
            "\"=0.1*torque\", order = {} }}\n",
            order);
    Machine one(text, plugins);
    const Excitation excitation(one.model, one.machine);
    Warnings warnings;
    ResponseCurves curves(one.machine, one.channels, excitation, one.all_channels(), warnings);
    for (auto _ : state)
        for (const double order : {2.0, 4.0, 6.0})
            for (int i = 0; i < 260; ++i) {
                const double speed = (800 + 5200.0 * i / 259) * std::numbers::pi / 30;
                benchmark::DoNotOptimize(curves.evaluate({order * speed / kTurn, speed, order}));
            }
    state.counters["channels"] = static_cast<double>(curves.size());
}
BENCHMARK(engine_260_speeds_3_orders)->Unit(benchmark::kMillisecond);

void headstock_2000_points(benchmark::State& state) {
    const Plugins plugins;
    Machine one(example("headstock"), plugins);
    const Excitation excitation({{"face.z", one.machine.find("face"), 2}});
    const auto found = std::ranges::find(one.channels.all(), "face.position.z", &Channel::name);
    Warnings warnings;
    ResponseCurves curves(one.machine, one.channels, excitation, {static_cast<int>(found - one.channels.all().begin())},
                          warnings);
    for (auto _ : state)
        for (int i = 0; i < 2000; ++i) benchmark::DoNotOptimize(curves.evaluate({1 + i * 0.5, std::nullopt, 0}));
}
BENCHMARK(headstock_2000_points)->Unit(benchmark::kMillisecond);

/// Bars and masses in a row, held at one end, a damper at every tenth, as the modes of the same are measured.
constexpr double kLength = 0.6, kBarMass = 60, kMass = 20, kDamping = 900;
double stiffness(long bar) { return 1.6e9 * (1 + 0.02 * static_cast<double>((bar * 7) % 5)); }

std::string chain(long bars) {
    std::string text = "format = \"dttmm/1\"\ndofs = [\"x\"]\n[nodes]\nn0 = { position = [0, 0, 0], fixed = [\"x\"] }\n";
    for (long i = 1; i <= bars; ++i) text += fmt::format("n{} = [{}, 0, 0]\n", i, kLength * static_cast<double>(i));
    for (long i = 0; i < bars; ++i) {
        text += fmt::format(
            "[[element]]\nname = \"b{0}\"\ntype = \"rod\"\nfrom = \"n{0}\"\nto = \"n{1}\"\n"
            "section = {{ EA = {2}, mass = {3} }}\n[[element]]\nname = \"m{0}\"\ntype = \"point_mass\"\nat = \"n{1}\"\nmass "
            "= {4}\n",
            i, i + 1, stiffness(i), kBarMass, kMass);
        if (i % 10 == 9)
            text += fmt::format(
                "[[element]]\nname = \"c{0}\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = "
                "\"n{1}\"\ndamping = [{2}, 0, 0]\n",
                i, i + 1, kDamping);
    }
    return text;
}

/// The same equations as a dense matrix: [cot, −csc; −csc, cot] EA β of each bar, β = ω √(m/EA).
Eigen::MatrixXcd dense_chain(long bars, double hertz) {
    using Complex = std::complex<double>;
    const double w = kTurn * hertz;
    Eigen::MatrixXcd D = Eigen::MatrixXcd::Zero(bars, bars);
    for (long i = 0; i < bars; ++i) {
        const double EA = stiffness(i), beta = w * std::sqrt(kBarMass / EA);
        const double own = EA * beta / std::tan(beta * kLength), other = -EA * beta / std::sin(beta * kLength);
        D(i, i) += own - w * w * kMass + (i % 10 == 9 ? Complex(0, w * kDamping) : 0);
        if (i == 0) continue;
        D(i - 1, i - 1) += own;
        D(i - 1, i) += other;
        D(i, i - 1) += other;
    }
    return D;
}

void chain_by_the_program(benchmark::State& state) {
    const Plugins plugins;
    const long bars = state.range(0);
    Machine one(chain(bars), plugins);
    const std::string last = fmt::format("n{}", bars);
    const Excitation excitation({{last + ".x", one.machine.find(last), 0}});
    const auto found = std::ranges::find(one.channels.all(), last + ".position.x", &Channel::name);
    Warnings warnings;
    ResponseCurves curves(one.machine, one.channels, excitation, {static_cast<int>(found - one.channels.all().begin())},
                          warnings);
    // The two agree before either is measured
    const Eigen::VectorXcd load = Eigen::VectorXcd::Unit(bars, bars - 1);
    const std::complex<double> mine = curves.evaluate({77.3, std::nullopt, 0}).front(),
                               dense = dense_chain(bars, 77.3).partialPivLu().solve(load)(bars - 1);
    if (std::abs(mine - dense) > 1e-8 * std::abs(dense)) {
        fmt::print(stderr, "the chain of {} bars: {} {} against {} {}\n", bars, mine.real(), mine.imag(), dense.real(),
                   dense.imag());
        std::abort();
    }
    double hertz = 70;
    for (auto _ : state) benchmark::DoNotOptimize(curves.evaluate({hertz += 0.1, std::nullopt, 0}));
}
BENCHMARK(chain_by_the_program)->Arg(10)->Arg(100)->Arg(1000)->Unit(benchmark::kMicrosecond);

void chain_dense(benchmark::State& state) {
    const long bars = state.range(0);
    const Eigen::VectorXcd load = Eigen::VectorXcd::Unit(bars, bars - 1);
    double hertz = 70;
    for (auto _ : state) {
        const Eigen::VectorXcd u = dense_chain(bars, hertz += 0.1).partialPivLu().solve(load);
        benchmark::DoNotOptimize(u.data());
    }
}
BENCHMARK(chain_dense)->Arg(10)->Arg(100)->Arg(1000)->Unit(benchmark::kMicrosecond);

}  // namespace
}  // namespace dttmm::host

BENCHMARK_MAIN();
