// SPDX-License-Identifier: BSD-3-Clause
#include "identify/identifiability.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>

namespace dttmm::host {
namespace {

Unknowns named(const std::vector<std::string>& names) {
    Unknowns unknowns;
    for (const std::string& name : names) unknowns.add({Unknown::Of::parameter, name, "N/m", 1e5, 5e3, 2e6});
    return unknowns;
}

// Oracle: the covariance of a linear problem, (J'J)^-1.
TEST(IdentifiabilityOfUnknowns, ARegularProblemHasItsCovariance) {
    Eigen::MatrixXd J(4, 3);
    J << 30, 2, -4, 5, 41, 3, -1, 7, 25, 2, -3, 9;
    const Identifiability found = judge_identifiability(J, named({"a", "b", "c"}), {false, false, false});
    const Eigen::MatrixXd covariance = (J.transpose() * J).inverse();
    EXPECT_LT((found.covariance - covariance).norm(), 1e-15);
    for (Eigen::Index i = 0; i < 3; ++i) EXPECT_NEAR(found.deviations(i), std::sqrt(covariance(i, i)), 1e-15);
    EXPECT_TRUE(found.flat.empty());
    EXPECT_TRUE(found.tied.empty());
    EXPECT_THAT(found.is_dead, testing::ElementsAre(false, false, false));
}

// Two springs in series: only 1/k1 + 1/k2 shows, so d ln of one counts against d ln of the other.
TEST(IdentifiabilityOfUnknowns, SpringsInSeriesAreOneNumber) {
    const double k1 = 2e5, k2 = 5e5;
    const Eigen::VectorXd data = Eigen::VectorXd::LinSpaced(6, 100, 400);
    Eigen::MatrixXd J(6, 3);
    J.col(0) = data * (1 / k1) / (1 / k1 + 1 / k2);
    J.col(1) = data * (1 / k2) / (1 / k1 + 1 / k2);
    J.col(2) = data.cwiseAbs2() / 200;
    const Identifiability found = judge_identifiability(J, named({"k1", "k2", "m"}), {false, false, false});
    ASSERT_EQ(found.tied.size(), 1u);
    EXPECT_THAT(found.tied[0], testing::ElementsAre(0, 1));
    ASSERT_EQ(found.flat.size(), 1u);
    EXPECT_NEAR(found.flat[0](0) / found.flat[0](1), -k1 / k2, 1e-9) << "d ln k1/k1 = -d ln k2/k2";
    EXPECT_FALSE(std::isfinite(found.deviations(0)));
    EXPECT_FALSE(std::isfinite(found.deviations(1)));
    EXPECT_TRUE(std::isfinite(found.deviations(2))) << "the third is fixed nevertheless";
    EXPECT_EQ(describe_combination(found.flat[0], named({"k1", "k2", "m"})), "-0.4 ln k1 + ln k2");
}

TEST(IdentifiabilityOfUnknowns, WhatChangesNothingIsDeadAndABoundIsKnown) {
    Eigen::MatrixXd J = Eigen::MatrixXd::Zero(3, 3);
    J.col(0) << 10, 20, 5;
    J.col(1) << 3, -1, 8;
    const Identifiability found = judge_identifiability(J, named({"a", "b", "c"}), {false, true, false});
    EXPECT_THAT(found.is_dead, testing::ElementsAre(false, false, true));
    EXPECT_NEAR(found.deviations(0), 1 / J.col(0).norm(), 1e-15) << "as if b were given";
    EXPECT_EQ(found.deviations(1), 0);
    EXPECT_FALSE(std::isfinite(found.deviations(2)));
}

// Fewer data than unknowns.
TEST(IdentifiabilityOfUnknowns, FewerDataThanUnknownsLeaveCombinationsOpen) {
    Eigen::MatrixXd J(1, 3);
    J << 7, 9, 4;
    const Identifiability found = judge_identifiability(J, named({"a", "b", "c"}), {false, false, false});
    EXPECT_EQ(found.flat.size(), 2u);
    for (const Eigen::VectorXd& one : found.flat) EXPECT_NEAR((J * one)(0), 0, 1e-13);
}

}  // namespace
}  // namespace dttmm::host
