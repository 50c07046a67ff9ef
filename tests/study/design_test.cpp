// SPDX-License-Identifier: BSD-3-Clause
#include "study/design.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <tuple>

#include "model/error.h"

namespace dttmm::host {
namespace {

constexpr int kDesigned = 700, kColumns = 5;

// Oracle: the definition: every case has a cell of its own in each column.
TEST(DesignOfCases, ALatinHypercubeHasACasePerCell) {
    const Eigen::MatrixXd u = make_probabilities(Design::latin, kDesigned, kColumns, 3);
    for (int p = 0; p < kColumns; ++p) {
        std::set<int> cells;
        for (int i = 0; i < kDesigned; ++i) cells.insert(static_cast<int>(u(i, p) * kDesigned));
        EXPECT_EQ(cells.size(), static_cast<size_t>(kDesigned));
        EXPECT_EQ(*cells.rbegin(), kDesigned - 1);
    }
}

TEST(DesignOfCases, TheSeedDecides) {
    for (const Design design : {Design::latin, Design::sobol, Design::random}) {
        const Eigen::MatrixXd u = make_probabilities(design, kDesigned, kColumns, 3);
        EXPECT_EQ(u, make_probabilities(design, kDesigned, kColumns, 3));
        EXPECT_NE(u, make_probabilities(design, kDesigned, kColumns, 4));
        EXPECT_GT(u.minCoeff(), 0);
        EXPECT_LT(u.maxCoeff(), 1);
    }
}

// Oracle: a net of 2^m points has one in each of 2^m equal cells of every parameter, and of every pair of the first two.
TEST(DesignOfCases, ASobolSequenceIsANet) {
    const Eigen::MatrixXd u = make_probabilities(Design::sobol, 256, kColumns, 9);
    for (int p = 0; p < kColumns; ++p) {
        std::set<int> cells;
        for (int i = 0; i < 256; ++i) cells.insert(static_cast<int>(u(i, p) * 256));
        EXPECT_EQ(cells.size(), 256u) << p;
    }
    std::set<int> squares;
    for (int i = 0; i < 256; ++i) squares.insert(16 * static_cast<int>(16 * u(i, 0)) + static_cast<int>(16 * u(i, 1)));
    EXPECT_EQ(squares.size(), 256u);
}

// Oracle: the mean of a product over the unit cube, 1/32; at 1024 points a Sobol sequence errs by less than a tenth of what
// independent draws do, (7/12)/32/sqrt(1024) or so.
TEST(DesignOfCases, ASobolSequenceIntegratesWell) {
    const auto error_of = [](Design design, std::uint64_t seed) {
        const Eigen::MatrixXd u = make_probabilities(design, 1024, kColumns, seed);
        return std::abs(u.rowwise().prod().mean() - 1.0 / 32);
    };
    double sobol = 0, random = 0;
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        sobol += error_of(Design::sobol, seed) / 20;
        random += error_of(Design::random, seed) / 20;
    }
    EXPECT_LT(sobol, 0.1 * random);
    EXPECT_GT(random, 2e-4);
}

// Oracle: Spearman's coefficient of the columns is the number given; every column keeps its numbers. Of 4000 cases drawn at
// random it scatters by 0.016 at most. Sobol' points are spread evenly: 16384 tell 0.7 from 6/π asin(0.7/2) = 0.683, which
// would be the coefficient with that correlation of the normal scores.
TEST(DesignOfCases, RanksAreCorrelatedAndNumbersKept) {
    for (const auto& [design, cases, tolerance] :
         {std::tuple{Design::latin, 4000, 0.03}, {Design::sobol, 16384, 1e-3}, {Design::random, 4000, 0.03}}) {
        const Eigen::MatrixXd before = make_probabilities(design, cases, 3, 11);
        Eigen::MatrixXd after = before;
        Eigen::Matrix3d wanted;
        wanted << 1, 0.7, -0.4, 0.7, 1, 0, -0.4, 0, 1;
        correlate(after, wanted);
        for (int p = 0; p < 3; ++p) {
            const Eigen::VectorXd a = before.col(p), b = after.col(p);
            std::multiset<double> one(a.begin(), a.end()), other(b.begin(), b.end());
            EXPECT_EQ(one, other);
            for (int q = 0; q < p; ++q) {
                const Eigen::ArrayXd x = after.col(p).array() - 0.5, y = after.col(q).array() - 0.5;
                const double spearman = (x * y).sum() / std::sqrt(x.square().sum() * y.square().sum());
                EXPECT_NEAR(spearman, wanted(p, q), tolerance);
            }
        }
    }
}

TEST(DesignOfCases, CorrelationsThatContradictEachOtherAreRefused) {
    Eigen::MatrixXd u = make_probabilities(Design::latin, 10, 3, 1);
    Eigen::Matrix3d impossible;
    impossible << 1, 0.9, 0.9, 0.9, 1, -0.9, 0.9, -0.9, 1;
    EXPECT_THROW(correlate(u, impossible), Error);
    // The ranks of three columns can have these, -0.5 + 0.01 between any two, but not through normal scores:
    // 1 - 2 * 2 sin(0.49 π/6) = -0.015 is the least eigenvalue
    impossible << 1, -0.49, -0.49, -0.49, 1, -0.49, -0.49, -0.49, 1;
    EXPECT_THROW(correlate(u, impossible), Error);
}

}  // namespace
}  // namespace dttmm::host
