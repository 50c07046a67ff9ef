// SPDX-License-Identifier: BSD-3-Clause
//
// Random machines in time: what holds for all of them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <string>

#include "model/error.h"
#include "support/random_machine.h"
#include "support/recorded_run.h"

namespace dttmm::host {
namespace {

using test::Placement;
using test::RandomMachine;
using test::RecordedRun;
using test::Units;

constexpr uint64_t kMachines = 60;
constexpr int kShort = 25;  // steps

// Oracle: objectivity. A machine that stands elsewhere, turned as a whole, moves in the same way, turned. What is left of
// the difference is what the solver leaves over: a millionth of what a step changes.
TEST(RandomMachines, MoveInTheSameWayWhereverTheyStand) {
    const Placement elsewhere{Eigen::AngleAxisd(2.1, Eigen::Vector3d(0.3, -0.8, 0.5).normalized()).toRotationMatrix(),
                              Eigen::Vector3d(2, -1.5, 1)};
    size_t compared = 0;
    for (uint64_t seed = 1; seed <= kMachines; ++seed) {
        try {
            const RecordedRun here(RandomMachine(seed, kShort).text()), there(RandomMachine(seed, kShort, elsewhere).text());
            double largest = 0, apart = 0;
            for (size_t n = 0; n < here.count(); ++n)
                for (int b = 0; here.has(fmt::format("b{}.position.x", b)); ++b) {
                    const std::string channel = fmt::format("b{}.position", b);
                    const Eigen::Vector3d way = here.vector(n, channel) - here.vector(0, channel),
                                          other = there.vector(n, channel) - there.vector(0, channel);
                    largest = std::max(largest, way.norm());
                    apart = std::max(apart, (elsewhere.turn * way - other).norm());
                }
            EXPECT_LT(apart, 1e-6 * largest + 1e-14) << seed << ": of " << largest << " m";
            ++compared;
        } catch (const Error&) {  // a rigid direction that both its ends hold
        }
    }
    EXPECT_GT(compared, kMachines * 9 / 10);
}

/// Of a channel, in metres, kilograms and seconds.
double unit_of(const std::string& unit, const Units& units) {
    const double speed = units.length / units.time;
    const std::map<std::string, double> all = {{"s", units.time},
                                               {"m", units.length},
                                               {"m/s", speed},
                                               {"m/s^2", speed / units.time},
                                               {"rad/s", 1 / units.time},
                                               {"rad/s^2", 1 / (units.time * units.time)},
                                               {"N", units.force()},
                                               {"N*m", units.force() * units.length},
                                               {"J", units.force() * units.length},
                                               {"Pa", units.force() / units.area()},
                                               {"rad", 1},
                                               {"", 1},
                                               {"1", 1}};
    return all.at(unit);
}

/// Largest difference of a number in a unit, of the largest number in that unit: places from the start on. Means of
/// neighbouring rows are compared: the rounding of a stiff undamped part alternates from row to row, and grows.
std::map<std::string, double> differences(const RecordedRun& one, const RecordedRun& other, const Units& units) {
    std::map<std::string, double> largest, apart;
    for (size_t n = 1; n < one.count(); ++n)
        for (size_t c = 0; c < one.units().size(); ++c) {
            const std::string& unit = one.units()[c];
            const auto mean = [&](const RecordedRun& run) {
                const auto& rows = run.rows();
                return 0.5 * (rows[n - 1][c] + rows[n][c]) - (unit == "m" ? rows[0][c] : 0);
            };
            const double x = mean(one), y = mean(other) / unit_of(unit, units);
            EXPECT_TRUE(std::isfinite(y));
            largest[unit] = std::max(largest[unit], std::abs(x));
            apart[unit] = std::max(apart[unit], std::abs(x - y));
        }
    for (auto& [unit, size] : apart) size /= std::max(largest[unit], 1e-300);
    return apart;
}

/// A machine against itself at another scale. Bounds are some four times what rounding makes of 60 machines at six scales.
void expect_similar(const RecordedRun& one, uint64_t seed, const Units& units) {
    const RecordedRun other(RandomMachine(seed, kShort, {}, units).text());
    ASSERT_EQ(one.count(), other.count());
    const std::map<std::string, double> bounds = {{"m", 5e-7},     {"rad", 1e-6}, {"J", 1.5e-6},  {"N", 2.5e-5},
                                                  {"N*m", 1.5e-5}, {"Pa", 6e-6},  {"m/s^2", 3e-4}};
    for (const auto& [unit, apart] : differences(one, other, units)) {
        // Velocities at an instant are left out: those of nodes with next to no mass on stiff parts are rounding
        if (unit == "m/s" || unit == "rad/s") continue;
        const auto bound = bounds.find(unit);
        EXPECT_LT(apart, bound == bounds.end() ? 1e-9 : bound->second)
            << seed << ", " << unit << ", scaled by " << units.length << ", " << units.mass << ", " << units.time;
    }
}

// Oracle: similarity. A machine of the same shape, larger or heavier or slower by powers of two, moves in the same way: no
// number of the solver with the unit of a metre, a kilogram or a second decides.
TEST(RandomMachines, MoveInTheSameWayAtEveryScale) {
    size_t compared = 0;
    for (uint64_t seed = 1; seed <= kMachines; ++seed) {
        std::optional<RecordedRun> one;
        try {
            one.emplace(RandomMachine(seed, kShort).text());
        } catch (const Error&) {  // a rigid direction that both its ends hold
            continue;
        }
        for (const Units& units : {Units{1, 0x1p-20, 1}, Units{1, 0x1p20, 1}, Units{0x1p10, 1, 1}, Units{0x1p-10, 1, 1},
                                   Units{1, 1, 0x1p8}, Units{0x1p-10, 0x1p-20, 0x1p-10}})
            expect_similar(*one, seed, units);
        ++compared;
    }
    EXPECT_GT(compared, kMachines * 9 / 10);
}

// Oracle: similarity. With a millionth of the mass: massless nodes on rigid directions beside bodies.
TEST(RandomMachines, OfMilligramsMoveLikeThoseOfKilograms) {
    for (const uint64_t seed : {67u, 102u, 109u, 202u, 210u, 230u, 248u}) {
        const RecordedRun one(RandomMachine(seed, kShort).text());
        for (const Units& units : {Units{1, 0x1p-20, 1}, Units{1, 0x1p-21, 1}, Units{0x1p-10, 0x1p-20, 0x1p-10}})
            expect_similar(one, seed, units);
    }
}

}  // namespace
}  // namespace dttmm::host
