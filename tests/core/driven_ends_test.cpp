// SPDX-License-Identifier: BSD-3-Clause
#include "core/driven_ends.h"

#include <gtest/gtest.h>

#include <random>

#include "core/error.h"
#include "core/state_vector.h"

namespace dttmm::plugin {
namespace {

/// A transfer matrix with the structure of an elastic chain and ugly numbers: static beam-like couplings, a history column.
Matrix13 ugly_transfer(unsigned seed) {
    std::mt19937 generator(seed);
    std::uniform_real_distribution<double> number(-1, 1);
    Matrix13 U = Matrix13::Identity();
    for (int i = 0; i < 6; ++i) {
        for (int j = 0; j < 12; ++j) U(i, j) += (j < 6 ? 0.3 : 1e-6) * number(generator);
        for (int j = 0; j < 12; ++j) U(6 + i, j) += (j < 6 ? 1e4 : 0.2) * number(generator);
        U(i, 12) = 1e-4 * number(generator);
        U(6 + i, 12) = 50 * number(generator);
    }
    return U;
}

Eigen::Matrix<double, 13, 1> state(const Vector6& pose, const Vector6& load) {
    Eigen::Matrix<double, 13, 1> z;
    z << pose, load.tail<3>(), load.head<3>(), 1;  // the state has moments before forces
    return z;
}

// Oracle: the transfer equation itself. With the solved end forces z_O = U z_I must hold for any end poses.
TEST(DrivenEnds, SolutionFulfilsTheTransferEquation) {
    const Matrix13 U = ugly_transfer(5);
    const EndForces ends = solve_driven_ends(U, Directions(0b111111));
    Vector12 x;
    x << 1e-3, -2e-3, 5e-4, 1e-2, -3e-3, 2e-3, -1e-3, 4e-4, 2e-3, 5e-3, 1e-3, -7e-3;
    const Vector12 q = ends.S * x + ends.e;
    const auto z_in = state(x.head<6>(), q.head<6>()), z_out = state(x.tail<6>(), q.tail<6>());
    const Eigen::Matrix<double, 13, 1> miss = U * z_in - z_out;
    EXPECT_LT(miss.head<6>().cwiseAbs().maxCoeff(), 1e-14);  // m, rad; poses are 1e-2
    EXPECT_LT(miss.tail<7>().cwiseAbs().maxCoeff(), 1e-9 * q.norm());
}

// Oracle: the 6 × 7 system of the hybrid-algorithm paper, eq. (6), written out: diag(1/k̂) q_I = x_I − x_O + D̂/k̂, q_O = q_I.
TEST(DrivenEnds, ThreeTranslationsAreThePapersSixBySevenSystem) {
    const Vector3 k_hat(5.3e5, 7.1e8, 42), history(3, -8, 0.2);  // N/m, N
    Matrix13 U = Matrix13::Identity();
    for (int d = 0; d < 3; ++d) {
        U(state::kPosition + d, state::kForce + d) = -1 / k_hat(d);
        U(state::kPosition + d, state::kOne) = history(d) / k_hat(d);
    }
    const EndForces ends = solve_driven_ends(U, Directions(0b000111));
    const Vector3 x_in(1e-3, 2e-4, -3e-2), x_out(-4e-4, 1e-4, 6e-2);
    Vector12 x = Vector12::Zero();
    x.head<3>() = x_in;
    x.segment<3>(6) = x_out;
    const Vector12 q = ends.S * x + ends.e;
    const Vector3 closed_form = k_hat.cwiseProduct(x_in - x_out) + history;
    for (int d = 0; d < 3; ++d) {
        EXPECT_NEAR(q(d), closed_form(d), 4e-16 * (k_hat(d) * 0.1 + 10));
        EXPECT_EQ(q(6 + d), q(d));
    }
    EXPECT_EQ(q.segment<3>(3).norm(), 0);
}

TEST(DrivenEnds, ARigidDirectionIsNamed) {
    Matrix13 U = ugly_transfer(6);
    for (int j = 6; j < 12; ++j) U(state::kPosition + 1, j) = 0;  // y of the output does not feel any load
    try {
        solve_driven_ends(U, Directions(0b111111));
        FAIL() << "a rigid direction was accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.status(), DTTMM_ERROR_SINGULAR);
        EXPECT_NE(std::string(error.what()).find("cannot be driven"), std::string::npos) << error.what();
    }
}

TEST(DrivenEnds, AFreeDirectionIsNamed) {
    Matrix13 U = Matrix13::Identity();
    for (int d = 0; d < 3; ++d) U(d, state::kForce + d) = d == 2 ? -std::numeric_limits<double>::infinity() : -1e-6;
    try {
        solve_driven_ends(U, Directions(0b000111));
        FAIL() << "a free direction was accepted";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("direction z: it has neither stiffness nor damping"), std::string::npos)
            << error.what();
    }
}

TEST(DrivenEnds, NothingCarriedIsNoForce) {
    const EndForces ends = solve_driven_ends(Matrix13::Identity(), Directions());
    EXPECT_EQ(ends.S.norm(), 0);
    EXPECT_EQ(ends.e.norm(), 0);
}

}  // namespace
}  // namespace dttmm::plugin
