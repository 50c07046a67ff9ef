// SPDX-License-Identifier: BSD-3-Clause
#include "core/lanes.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>
#include <random>
#include <vector>

#include "core/rotation.h"

namespace dttmm::plugin {
namespace {

/// Numbers of four records, all different.
template <int N>
struct Records {
    double of[Lanes::kCount][N];
    Records() {
        for (int lane = 0; lane < Lanes::kCount; ++lane)
            for (int n = 0; n < N; ++n) of[lane][n] = 100 * lane + n + 0.25;
    }
};

template <int N>
void expect_there_and_back() {
    const Records<N> records;
    Lanes lanes[N];
    gather<N>({records.of[0], records.of[1], records.of[2], records.of[3]}, lanes);
    for (int n = 0; n < N; ++n)
        for (int i = 0; i < Lanes::kCount; ++i) EXPECT_EQ(lanes[n][i], records.of[i][n]) << N << ": " << n << ", lane " << i;
    constexpr double kUntouched = -7;
    double back[Lanes::kCount][N + 1];
    for (double(&record)[N + 1] : back) record[N] = kUntouched;
    scatter<N>(lanes, {back[0], back[1], back[2], back[3]});
    for (int i = 0; i < Lanes::kCount; ++i) {
        for (int n = 0; n < N; ++n) EXPECT_EQ(back[i][n], records.of[i][n]) << N << ": " << n << ", lane " << i;
        EXPECT_EQ(back[i][N], kUntouched) << N << ", lane " << i;
    }
}

// Oracle: the records themselves; lengths with every remainder by four.
TEST(Lanes, RecordsGoSideBySideAndBack) {
    expect_there_and_back<1>();
    expect_there_and_back<6>();
    expect_there_and_back<9>();
    expect_there_and_back<12>();
    expect_there_and_back<35>();
}

TEST(Lanes, AllAreBelowOnlyIfEachIs) {
    Lanes a(0.5);
    EXPECT_TRUE(all_below(a, 0.6));
    for (int i = 0; i < Lanes::kCount; ++i) {
        Lanes b = a;
        b.set(i, 0.7);
        EXPECT_FALSE(all_below(b, 0.6)) << i;
        b.set(i, std::numeric_limits<double>::quiet_NaN());
        EXPECT_FALSE(all_below(b, 0.6)) << i;
    }
}

/// Four rotation vectors: one at a time of any size, the rest small.
std::vector<std::array<Vector3, Lanes::kCount>> rotations() {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    std::vector<std::array<Vector3, Lanes::kCount>> all;
    for (double largest : {0.0, 1e-9, 1e-3, 0.09, 0.11, 1.0, 3.0})
        for (size_t which = 0; which < Lanes::kCount; ++which) {
            auto& four = all.emplace_back();
            for (size_t i = 0; i < Lanes::kCount; ++i) {
                const Vector3 axis = Vector3(normal(random), normal(random), normal(random)).normalized();
                four[i] = (i == which ? largest : 0.02) * axis;
            }
        }
    return all;
}

template <int R, int C>
auto side_by_side(const std::array<Eigen::Matrix<double, R, C>, Lanes::kCount>& each) {
    Eigen::Matrix<Lanes, R, C> four;
    for (int i = 0; i < Lanes::kCount; ++i) set_lane(four, i, each[static_cast<size_t>(i)]);
    return four;
}

// Oracle: the same of one rotation alone, to the bit, small angles and large ones mixed.
TEST(Lanes, RotationsOfFourAreThoseOfEach) {
    const std::array<Vector3, Lanes::kCount> vectors = {Vector3(1, -2, 3), Vector3(0.1, 7, 0), Vector3(-4, 5, 6),
                                                        Vector3(0, 0, 1e-3)};
    for (const auto& thetas : rotations()) {
        const auto theta = side_by_side(thetas), v = side_by_side(vectors);
        const auto R = rotation_from_vector<Lanes>(theta);
        const auto back = rotation_vector<Lanes>(R), moment = moment_of_gradient<Lanes>(theta, v);
        for (int i = 0; i < Lanes::kCount; ++i) {
            const Vector3 &one = thetas[static_cast<size_t>(i)], &of_one = vectors[static_cast<size_t>(i)];
            EXPECT_EQ(lane(R, i), rotation_from_vector(one)) << one.transpose();
            EXPECT_EQ(lane(back, i), rotation_vector(rotation_from_vector(one))) << one.transpose();
            EXPECT_EQ(lane(moment, i), moment_of_gradient(one, of_one)) << one.transpose();
        }
    }
}

}  // namespace
}  // namespace dttmm::plugin
