// SPDX-License-Identifier: BSD-3-Clause
#include "law/viscoelastic.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

namespace dttmm::plugin {
namespace {

using Complex = std::complex<double>;
using Memory = std::array<double, Law::kMostMemory>;

Viscoelastic rubber() {
    std::vector<DynamicStiffnessRow> rows;
    for (const auto& [f, k, degrees] :
         {std::array{1.0, 1000.0, 4.0}, {5.0, 1090.0, 5.5}, {20.0, 1180.0, 6.5}, {80.0, 1310.0, 8.0}, {200.0, 1420.0, 9.0}})
        rows.push_back({2 * std::numbers::pi * f, k, degrees * std::numbers::pi / 180});
    return Viscoelastic(std::move(rows));
}

// Oracle: energy. What the mean force does along a path is stored or lost; at rest, of slow paths and over times far from
// and near those of the terms.
TEST(Viscoelastic, StoresOrLosesWhatTheMeanForceDoes) {
    const Viscoelastic law = rubber();
    for (const double time : {0.0, 1e-7, 1e-4, 3e-3, 0.2, 50.0}) {
        Memory memory{}, after{};
        double at = 0;
        for (const double to : {0.01, -0.02, -0.02 + 1e-9, 0.03, 0.03, 0.0}) {
            if (time == 0 && to == at) continue;
            const double before = law.at(at, memory.data()).stored;
            const LawOnPath path = law.along({at, to, time, memory.data(), after.data()});
            EXPECT_NEAR(path.mean * (to - at), path.stored - before + path.dissipated, 1e-15) << time << " " << to;
            EXPECT_GE(path.dissipated, 0);
            EXPECT_EQ(law.at(to, after.data()).force, path.force);
            memory = after;
            at = to;
        }
    }
}

// Oracle: central differences.
TEST(Viscoelastic, HasTheTangentsOfItsForces) {
    const Viscoelastic law = rubber();
    Memory memory{};
    for (size_t j = 0; j < law.memory_size(); ++j) memory[j] = 0.3 * std::cos(static_cast<double>(j) + 1);
    constexpr double e = 1e-6;
    for (const double time : {1e-5, 4e-3, 0.3})
        for (const double to : {-0.02, 0.01, 0.015}) {
            const auto along = [&](double end) { return law.along({0.01, end, time, memory.data()}); };
            const LawOnPath path = along(to), more = along(to + e), less = along(to - e);
            EXPECT_NEAR(path.tangent, (more.force - less.force) / (2 * e), 1e-5);
            EXPECT_NEAR(path.mean_tangent, (more.mean - less.mean) / (2 * e), 1e-5);
        }
}

// Oracle: an identity. Two halves of a path with one rate are the whole path; a path that takes no time and has no length
// changes nothing.
TEST(Viscoelastic, GoesOnWhereItStopped) {
    const Viscoelastic law = rubber();
    Memory memory{}, half{}, whole{}, twice{};
    memory[0] = 0.4;
    (void)law.along({0.01, 0.02, 4e-3, memory.data(), half.data()});
    const LawOnPath second = law.along({0.02, 0.03, 4e-3, half.data(), twice.data()});
    const LawOnPath once = law.along({0.01, 0.03, 8e-3, memory.data(), whole.data()});
    EXPECT_NEAR(second.force, once.force, 1e-12);
    for (size_t j = 0; j < law.memory_size(); ++j) EXPECT_NEAR(twice[j], whole[j], 1e-13);
    (void)law.along({0.01, 0.01, 0, memory.data(), half.data()});
    EXPECT_EQ(half, memory);
}

// Oracle: its series at that frequency. Under d = sin ωt in small steps the force becomes Im(K e^(iωt)).
TEST(Viscoelastic, VibratesWithTheStiffnessOfItsSeries) {
    const Viscoelastic law = rubber();
    for (const double f : {2.0, 30.0}) {
        const double omega = 2 * std::numbers::pi * f, h = 1 / f / 2000;
        Memory memory{}, after{};
        double at = 0, force = 0;
        const int steps = 2000 * static_cast<int>(std::ceil(8 * f));  // 8 s: the slowest term has 0.5 s
        for (int n = 1; n <= steps; ++n) {
            const double to = std::sin(omega * n * h);
            force = law.along({at, to, h, memory.data(), after.data()}).force;
            memory = after;
            at = to;
        }
        const Complex K = law.series().at(omega);
        EXPECT_NEAR(force, (K * std::polar(1.0, omega * steps * h)).imag(), 1e-5 * std::abs(K));
    }
}

// Oracle: its rows, and straight lines of magnitude and angle between them.
TEST(Viscoelastic, HasItsRowsInVibration) {
    const Viscoelastic law = rubber();
    const auto expect = [&](double f, double k, double degrees) {
        const Complex K = law.stiffness_at(2 * std::numbers::pi * f);
        EXPECT_NEAR(std::abs(K), k, 1e-9) << f;
        EXPECT_NEAR(std::arg(K) * 180 / std::numbers::pi, degrees, 1e-9) << f;
    };
    expect(1, 1000, 4);
    expect(0.25, 1000, 1);
    expect(0, 1000, 0);
    expect(3, 1045, 4.75);
    expect(80, 1310, 8);
    expect(140, 1365, 8.5);
    expect(200, 1420, 9);
    EXPECT_NEAR(law.highest(), 400 * std::numbers::pi, 1e-9);
}

}  // namespace
}  // namespace dttmm::plugin
