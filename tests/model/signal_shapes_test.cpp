// SPDX-License-Identifier: BSD-3-Clause
#include "model/signal_shapes.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>
#include <cstdlib>
#include <new>
#include <numbers>

namespace {
std::atomic<long> allocations{0};
}

// Counts what this test program allocates. Not inlined, or the compiler takes free() for the wrong partner of new.
[[gnu::noinline]] void* operator new(std::size_t size) {
    ++allocations;
    if (void* memory = std::malloc(size)) return memory;
    throw std::bad_alloc();
}
[[gnu::noinline]] void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
    ++allocations;
    return std::malloc(size);
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace dttmm::host {
namespace {

TEST(Signal, WithoutShapeIsZero) { EXPECT_EQ(Signal().value(3), 0); }

TEST(ConstantSignal, IsConstant) { EXPECT_EQ(ConstantSignal(7).value(-1), 7); }

// Oracle: the cubic by hand: s = 1/4 gives 3/16 - 2/64 = 5/32.
TEST(StepSignal, FollowsTheCubicBetweenItsEnds) {
    const StepSignal step(100, 740, 2, 6);
    EXPECT_EQ(step.value(1), 100);
    EXPECT_EQ(step.value(2), 100);
    EXPECT_DOUBLE_EQ(step.value(3), 100 + 640 * 5.0 / 32);
    EXPECT_DOUBLE_EQ(step.value(4), 420);
    EXPECT_EQ(step.value(6), 740);
    EXPECT_EQ(step.value(9), 740);
}

TEST(StepSignal, MayJump) {
    const StepSignal step(1, 3, 2, 2);
    EXPECT_EQ(step.value(std::nextafter(2, 0)), 1);
    EXPECT_EQ(step.value(2), 3);
}

// Oracle: the formula; a haversine has half its peak at a quarter of its width and its peak in the middle.
TEST(PulseSignal, OneHaversine) {
    const PulseSignal pulse(8, 1, 0.4);
    EXPECT_EQ(pulse.value(0.9), 0);
    EXPECT_EQ(pulse.value(1), 0);
    EXPECT_NEAR(pulse.value(1.1), 4, 1e-14);
    EXPECT_NEAR(pulse.value(1.2), 8, 1e-14);
    EXPECT_NEAR(pulse.value(1.3), 4, 1e-14);
    EXPECT_EQ(pulse.value(1.5), 0);
}

TEST(PulseSignal, ATrainRepeatsAndEnds) {
    const PulseSignal train(60e3, 0.01, 0.003, 0.1, 3);
    for (const double start : {0.01, 0.11, 0.21}) EXPECT_NEAR(train.value(start + 0.0015), 60e3, 1e-7) << start;
    for (const double time : {0.0, 0.0115 - 0.1, 0.05, 0.2, 0.3115, 5.0}) EXPECT_EQ(train.value(time), 0) << time;
}

TEST(SineSignal, BeginsAtItsStart) {
    const SineSignal sine(3, 0.25, std::numbers::pi / 2, 5, 2);
    EXPECT_EQ(sine.value(1.9), 5);
    EXPECT_DOUBLE_EQ(sine.value(2), 8);
    EXPECT_NEAR(sine.value(3), 5, 1e-15);
    EXPECT_DOUBLE_EQ(sine.value(4), 2);
}

TEST(TableSignal, IsLinearBetweenAndHeldOutside) {
    const TableSignal table({1, 2, 4}, {10, 30, -10});
    EXPECT_EQ(table.value(0), 10);
    EXPECT_EQ(table.value(1), 10);
    EXPECT_EQ(table.value(1.25), 15);
    EXPECT_EQ(table.value(2), 30);
    EXPECT_EQ(table.value(3), 10);
    EXPECT_EQ(table.value(4), -10);
    EXPECT_EQ(table.value(9), -10);
    EXPECT_EQ(TableSignal({3}, {7}).value(0), 7);
}

// Oracle: the cubic by hand. a = 6 (t − 1) from 1 to 2 s, then 6 − 12 (t − 2) to 2.5 s: v = 3 and 4.5, x = 1 and 3.
TEST(IntegratedTableSignal, IntegratesAnAccelerationTwice) {
    const IntegratedTableSignal table({1, 2, 2.5}, {0, 6, 0}, 2);
    EXPECT_EQ(table.value(0.5), 0);
    EXPECT_NEAR(table.value(1.5), 0.125, 1e-15);
    EXPECT_NEAR(table.value(2), 1, 1e-15);
    EXPECT_NEAR(table.value(2.5), 1 + 3 * 0.5 + 6 * 0.125 - 12 * 0.125 / 6, 1e-15);
    EXPECT_NEAR(table.last_velocity(), 3 + 6 * 0.5 - 6 * 0.25, 1e-15);
    EXPECT_NEAR(table.value(4.5), table.value(2.5) + 2 * 4.5, 1e-14);
    EXPECT_NEAR(table.largest_velocity(), 4.5, 1e-15);
}

// Oracle: the trapezes by hand; it stands still behind the last point.
TEST(IntegratedTableSignal, IntegratesAVelocityOnce) {
    const IntegratedTableSignal table({0, 1, 3}, {2, 4, -1}, 1);
    EXPECT_NEAR(table.value(0.5), 1.25, 1e-15);
    EXPECT_NEAR(table.value(1), 3, 1e-15);
    EXPECT_NEAR(table.value(3), 6, 1e-15);
    EXPECT_NEAR(table.value(9), 6, 1e-15);
    EXPECT_EQ(table.last_velocity(), 0);
}

TEST(ExpressionSignal, EvaluatesAtTheTime) {
    const ExpressionSignal signal(Expression("a*t^2", {{"a", 3.0}}, "t"));
    EXPECT_EQ(signal.value(2), 12);
    EXPECT_EQ(signal.value(-1), 3);
}

TEST(Signal, EvaluationNeverAllocates) {
    const ExpressionSignal expression(Expression("a*sin(2*pi*50*t) + max(t, 1) + (t > 1 ? 2 : 3)", {{"a", 3.0}}, "t"));
    const TableSignal table({1, 2, 4}, {10, 30, -10});
    const PulseSignal pulse(8, 1, 0.4, 0.5, 3);
    const long before = allocations;
    double sum = 0;
    for (int i = 0; i < 1000; ++i) sum += expression.value(i * 0.003) + table.value(i * 0.005) + pulse.value(i * 0.002);
    EXPECT_EQ(allocations, before);
    EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace dttmm::host
