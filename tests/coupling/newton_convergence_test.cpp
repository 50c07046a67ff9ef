// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/newton_convergence.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

namespace dttmm::host {
namespace {

// Oracle for all of them: the rules of the header, applied by hand.

TEST(Contraction, EstimatesWhatRemainsOfACorrection) {
    Contraction contraction;
    EXPECT_EQ(contraction.left(0.3), 0.3) << "nothing is known";
    contraction.measure(0.1, 2);
    EXPECT_DOUBLE_EQ(contraction.left(0.9), 0.1);
    EXPECT_DOUBLE_EQ(contraction.left(2), 2 * 0.1 / 0.9);
    EXPECT_DOUBLE_EQ(contraction.left(6), 3 * 6 * 0.1 / 0.9) << "a larger one contracts less in proportion";
    EXPECT_EQ(contraction.left(200), 200);
    contraction.forget(0);
    EXPECT_DOUBLE_EQ(contraction.left(0.9), 0.2);
    contraction.measure(1e-9, 2);
    contraction.forget(0.01);
    EXPECT_DOUBLE_EQ(contraction.left(1), 0.01) << "no better than what is trusted at best";
    contraction.measure(1.5, 1);
    EXPECT_EQ(contraction.left(0.9), 0.9) << "it grows";
}

/// A part that moves at 1 m/s under impulses of 1 N s.
dttmm_progress part(double correction, double previous, double residual = 0) {
    return {correction, previous, 1, 1e-15, residual, 1, 0, -1};
}

/// The pass by which it is done, from 1 on; 0: by none.
int pass_done(NewtonConvergence& convergence, const std::vector<dttmm_progress>& passes) {
    convergence.open();
    for (size_t n = 0; n < passes.size(); ++n) {
        convergence.take(passes[n]);
        if (convergence.is_done()) return static_cast<int>(n) + 1;
    }
    return 0;
}

TEST(NewtonConvergence, EndsWhereAMillionthOfTheFirstCorrectionRemains) {
    NewtonConvergence inside(NewtonConvergence::kInside);
    // 1e-3 of 1e-2 remains after the second pass, about 1e-5 after it: 1e-8 wants one more
    EXPECT_EQ(pass_done(inside, {part(1e-2, 0), part(1e-5, 1e-2), part(1e-8, 1e-5)}), 3);
    NewtonConvergence fast(NewtonConvergence::kInside);
    EXPECT_EQ(pass_done(fast, {part(1e-2, 0), part(1e-6, 1e-2)}), 2);
    NewtonConvergence large(NewtonConvergence::kInside);
    EXPECT_EQ(pass_done(large, {part(1e3, 0), part(1e-1, 1e3), part(1e-5, 1e-1)}), 3) << "of the motion, 1 m/s";
}

TEST(NewtonConvergence, KeepsTheRateForTheNextStep) {
    NewtonConvergence inside(NewtonConvergence::kInside);
    EXPECT_EQ(pass_done(inside, {part(1e-2, 0), part(1e-9, 1e-2)}), 2);
    EXPECT_EQ(pass_done(inside, {part(1e-2, 0)}), 1) << "2e-7 of it remains";
    EXPECT_EQ(pass_done(inside, {part(1e-1, 0), part(1e-8, 1e-1)}), 2) << "ten times as large: 4e-6 of it may remain";
}

// A second correction that is exactly zero says no more than one of eps times the first: trust is halved from there.
TEST(NewtonConvergence, TrustsARateOfZeroForSomeStepsOnly) {
    NewtonConvergence bodies(NewtonConvergence::kBodies);
    EXPECT_EQ(pass_done(bodies, {part(1e-2, 0), part(0, 1e-2)}), 2);
    int steps = 0;
    while (steps < 100 && pass_done(bodies, {part(1e-2, 0)}) == 1) ++steps;
    EXPECT_GE(steps, 10);
    EXPECT_LE(steps, 20) << "2^n eps is 1e-12 by then";
}

TEST(NewtonConvergence, TrustsNoRateOfAnotherMatrix) {
    NewtonConvergence inside(NewtonConvergence::kInside);
    pass_done(inside, {part(1e-2, 0), part(1e-9, 1e-2)});
    dttmm_progress first = part(1e-2, 0), second = part(1e-9, 1e-2), none = part(0, 0);
    first.is_new = second.is_new = none.is_new = 1;
    EXPECT_EQ(pass_done(inside, {first, second}), 2);
    EXPECT_EQ(pass_done(inside, {part(1e-2, 0), part(1e-9, 1e-2)}), 2) << "nor of that step in the next";
    EXPECT_EQ(pass_done(inside, {none, none}), 2) << "not at first, be it at rest";
}

TEST(NewtonConvergence, WantsTheMomentumToo) {
    NewtonConvergence inside(NewtonConvergence::kInside);
    EXPECT_EQ(pass_done(inside, {part(1e-2, 0, 1), part(1e-9, 1e-2, 1e-3), part(1e-12, 1e-9, 1e-6)}), 3)
        << "1e-6 of 1e-3 remains after the second pass";
    NewtonConvergence fast(NewtonConvergence::kInside);
    EXPECT_EQ(pass_done(fast, {part(1e-2, 0, 1), part(1e-9, 1e-2, 0.9e-4)}), 2);
}

TEST(NewtonConvergence, TakesForRoundingWhatNoLongerFalls) {
    const auto noise = [](double size, double residual) {
        std::vector<dttmm_progress> passes{part(size, 0, residual)};
        for (int n = 0; n < 8; ++n) passes.push_back(part(size, size, residual));
        return passes;
    };
    NewtonConvergence small(NewtonConvergence::kInside), large(NewtonConvergence::kInside),
        unbalanced(NewtonConvergence::kInside);
    EXPECT_EQ(pass_done(small, noise(0.5e-9, 1e-9)), 5);
    EXPECT_EQ(pass_done(small, noise(0.2e-9, 1e-9)), 1) << "half of what was noise in the step before is noise";
    EXPECT_EQ(pass_done(large, noise(2e-9, 1e-9)), 0);
    EXPECT_EQ(pass_done(unbalanced, noise(0.5e-9, 1e-6)), 0);
}

// A soft direction moves far for the rounding of stiff forces, beside which nothing moves.
TEST(NewtonConvergence, TakesForRoundingWhatMovesWithForcesInBalance) {
    const auto ends_at = [](double residual, double impulse, double last) {
        NewtonConvergence inside(NewtonConvergence::kInside);
        std::vector<dttmm_progress> passes;
        double previous = 0;
        for (const double correction : {3e-6, 2e-6, 3e-6, 2e-6, last}) {
            passes.push_back({correction, previous, 0, 1e-15, residual, impulse, 0, -1});
            previous = correction;
        }
        return pass_done(inside, passes);
    };
    EXPECT_EQ(ends_at(0, 1, 1.1e-6), 5);
    EXPECT_EQ(ends_at(0, 1, 0.9e-6), 0) << "it falls";
    EXPECT_EQ(ends_at(1e-18, 1, 1.1e-6), 0) << "something is left";
    EXPECT_EQ(ends_at(0, 0, 1.1e-6), 0) << "there are no forces, or nobody has looked at them";
}

TEST(NewtonConvergence, FindsBodiesToRounding) {
    NewtonConvergence bodies(NewtonConvergence::kBodies);
    EXPECT_EQ(pass_done(bodies, {part(1e-2, 0), part(1e-7, 1e-2), part(1e-12, 1e-7)}), 3);
    NewtonConvergence linear(NewtonConvergence::kBodies);
    EXPECT_EQ(pass_done(linear, {part(1e-2, 0), part(1e-16, 1e-2)}), 2);
    EXPECT_EQ(pass_done(linear, {part(1e-2, 0)}), 1) << "what is at rounding at the second pass tells of the first";
}

// What follows holds every limit between 0.8 and 1.25 times itself: at half and at twice of it a line fails.

constexpr double kBelow = 0.8, kAbove = 1.25;

/// By how many passes a contraction from the correction `first` is done where `left` of it remain after the second,
/// c²/first.
int done_with_left(const NewtonConvergence::Limits& limits, double first, double left) {
    NewtonConvergence convergence(limits);
    const double second = std::sqrt(first * left);
    return pass_done(convergence, {{first, 0, 1, 1e-30, 0, 1, 0, -1}, {second, first, 1, 1e-30, 0, 1, 0, -1}});
}

TEST(NewtonConvergence, LimitsOfTheMotion) {
    const double epsilon = std::numeric_limits<double>::epsilon();
    EXPECT_EQ(done_with_left(NewtonConvergence::kBodies, 1e-3, kBelow * 40 * epsilon), 2);
    EXPECT_EQ(done_with_left(NewtonConvergence::kBodies, 1e-3, kAbove * 40 * epsilon), 0);
    EXPECT_EQ(done_with_left(NewtonConvergence::kInside, 1e3, kBelow * 1e-6), 2);
    EXPECT_EQ(done_with_left(NewtonConvergence::kInside, 1e3, kAbove * 1e-6), 0);
}

TEST(NewtonConvergence, LimitOfTheFirstCorrection) {
    EXPECT_EQ(done_with_left(NewtonConvergence::kInside, 1e-3, kBelow * 1e-9), 2);
    EXPECT_EQ(done_with_left(NewtonConvergence::kInside, 1e-3, kAbove * 1e-9), 0);
}

TEST(NewtonConvergence, LimitOfTheMomentum) {
    const auto done = [](double left) {  // of an impulse of 1 N s, after a residual of as much
        NewtonConvergence inside(NewtonConvergence::kInside);
        return pass_done(inside, {part(1e-2, 0, 1), part(1e-9, 1e-2, std::sqrt(left))});
    };
    EXPECT_EQ(done(kBelow * 1e-8), 2);
    EXPECT_EQ(done(kAbove * 1e-8), 0);
}

TEST(NewtonConvergence, LimitsOfWhatNoLongerFalls) {
    const auto done = [](const NewtonConvergence::Limits& limits, double size, double motion) {
        NewtonConvergence convergence(limits);
        std::vector<dttmm_progress> passes;
        for (int n = 0; n < 9; ++n) passes.push_back({size, n == 0 ? 0 : size, motion, 1e-15, 1e-9, 1, 0, -1});
        return pass_done(convergence, passes);
    };
    for (const auto& limits : {NewtonConvergence::kBodies, NewtonConvergence::kInside}) {
        EXPECT_EQ(done(limits, kBelow * 1e-9, 1), 5);
        EXPECT_EQ(done(limits, kAbove * 1e-9, 1), 0);
        EXPECT_EQ(done(limits, kBelow * 10 * 1e-15, 1e-9), 5) << "near rounding, of what hardly moves";
        EXPECT_EQ(done(limits, kAbove * 10 * 1e-15, 1e-9), 0);
    }
}

TEST(NewtonConvergence, LimitsOfASlowIteration) {
    const auto is_slow = [](double rate, double correction) {
        NewtonConvergence bodies(NewtonConvergence::kBodies);
        bodies.open();
        bodies.take(part(correction / rate, 0));
        bodies.take(part(correction, correction / rate));
        return bodies.is_slow();
    };
    EXPECT_FALSE(is_slow(kBelow * 0.1, 1e-3));
    EXPECT_TRUE(is_slow(kAbove * 0.1, 1e-3));
    EXPECT_FALSE(is_slow(0.5, kBelow * 10 * 1e-15)) << "near rounding";
    EXPECT_TRUE(is_slow(0.5, kAbove * 10 * 1e-15));
}

TEST(NewtonConvergence, ASlowIterationWantsAnotherMatrix) {
    NewtonConvergence bodies(NewtonConvergence::kBodies);
    bodies.open();
    bodies.take(part(1e-2, 0));
    EXPECT_FALSE(bodies.is_slow());
    bodies.take(part(2e-3, 1e-2));
    EXPECT_TRUE(bodies.is_slow());
    bodies.take(part(1e-4, 2e-3));
    EXPECT_FALSE(bodies.is_slow());
    bodies.take(part(0.5e-14, 1e-14));
    EXPECT_FALSE(bodies.is_slow()) << "near rounding";
}

}  // namespace
}  // namespace dttmm::host
