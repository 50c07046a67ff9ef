// SPDX-License-Identifier: BSD-3-Clause
#include "element/spring_damper.h"

#include <gtest/gtest.h>

#include <array>

#include "core/discretisation.h"
#include "core/state_vector.h"
#include "support/spring_values.h"

namespace dttmm::plugin {
namespace {

//                                   stiffness           damping         rotational stiffness  rotational damping
constexpr std::array<double, 12> kUgly = {5e5, 7.3e8, 12, 100, 0.7, 33, 2e4, 8.1e6, 3, 5, 0.01, 900};

// Oracle: the unit relations of the sign convention: x_O = x_I − q/K and θ_O = θ_I + m/K', loads pass through.
TEST(SpringDamper, StaticTransferMatrixFollowsTheSignConvention) {
    const SpringDamper joint(test::spring_values(kUgly));
    const Matrix13 U = joint.law().transfer({1, 0}, Vector6::Zero());
    Matrix13 expected = Matrix13::Identity();
    for (int d = 0; d < 3; ++d) {
        expected(state::kPosition + d, state::kForce + d) = -1 / kUgly[static_cast<size_t>(d)];
        expected(state::kAngle + d, state::kMoment + d) = 1 / kUgly[static_cast<size_t>(6 + d)];
    }
    EXPECT_EQ(U, expected);
}

// Oracle: the paper's eq. (4) and (5): Khat = k + c C, last column c (D_I − D_O)/Khat with Fox-Euler's C and D, both by
// hand.
TEST(SpringDamper, FoxEulerTransferMatrixIsThePapersEquation4) {
    const double h = 1e-3, k = 5e5, c = 100;
    const SpringDamper joint(test::spring_values({k, k, k, c, c, c, 0, 0, 0, 0, 0, 0}));
    const double x_in_1 = 1e-4, v_in_1 = 0.3, x_out_1 = -2e-4, v_out_1 = -0.1;
    const double D_in = -2 / h * x_in_1 - v_in_1, D_out = -2 / h * x_out_1 - v_out_1;
    const double k_hat = k + c * 2 / h;

    History past;
    for (auto* list : {&past.x, &past.v, &past.a}) list->fill(Vector6::Zero());
    past.x[0].setConstant(x_out_1 - x_in_1);
    past.v[0].setConstant(v_out_1 - v_in_1);
    const AffineMotion step = fox_euler(past, h);
    const Matrix13 U = joint.law().transfer({1, step.C}, c * step.D);
    for (int d = 0; d < 3; ++d) {
        EXPECT_DOUBLE_EQ(U(d, state::kForce + d), -1 / k_hat);
        EXPECT_DOUBLE_EQ(U(d, state::kOne), c * (D_in - D_out) / k_hat);
    }
}

// Oracle: the closed form q = Khat (x_I − x_O) and m = Khat' (θ_O − θ_I); the elimination has 12 unknowns. Rounding only.
TEST(SpringDamper, EliminationInSpaceEqualsTheClosedForm) {
    const SpringDamper joint(test::spring_values(kUgly));
    const StepCoefficients step{0.25, 500};
    const Vector6 known = (Vector6() << 3, -1, 0.5, 2, -7, 0.1).finished();
    const EndForces ends = solve_driven_ends(joint.law().transfer(step, known), joint.law().carried());
    for (int d = 0; d < 6; ++d) {
        const auto g = static_cast<size_t>(d < 3 ? d : 3 + d);
        const double k_hat = 0.25 * kUgly[g] + 500 * kUgly[g + 3], sign = d < 3 ? -1 : 1;
        Vector12 row = Vector12::Zero();
        row(d) = -sign * k_hat;
        row(6 + d) = sign * k_hat;
        for (int end : {0, 6}) {
            EXPECT_LT((ends.S.row(end + d).transpose() - row).cwiseAbs().maxCoeff(), 4e-16 * k_hat) << d;
            EXPECT_NEAR(ends.e(end + d), sign * known(d), 4e-16 * std::abs(known(d))) << d;
        }
    }
}

TEST(SpringDamper, ADirectionWithoutStiffnessOrDampingIsFree) {
    const SpringDamper joint(test::spring_values({1, 0, 0, 0, 2, 0, 0, 3, 0, 0, 0, 4}));
    EXPECT_EQ(joint.law().carried(), Directions(0b110011));
    EXPECT_TRUE(std::isinf(joint.law().transfer({1, 10}, Vector6::Zero())(state::kPosition + 2, state::kForce + 2)));
    const EndForces ends = solve_driven_ends(joint.law().transfer({1, 10}, Vector6::Zero()), joint.law().carried());
    EXPECT_EQ(ends.S.row(2).norm(), 0);
    EXPECT_DOUBLE_EQ(ends.S(1, 7), -20);
}

}  // namespace
}  // namespace dttmm::plugin
