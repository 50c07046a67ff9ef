// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/momentum.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/rotation.h"

namespace dttmm::plugin {
namespace {

constexpr double kStepOfMomentum = 3e-4;
const Vector3 kSomeGravity(0.3, -1.2, -9.7);

/// Frames with everything about them, all different; one turns far.
class SomeFrames : public testing::Test {
protected:
    static constexpr size_t kCount =
        11;  // two fours and every remainder, taken in turn; the one that turns far in the first

    SomeFrames() {
        for (size_t i = 0; i < kCount; ++i) {
            const Matrix3 A = Matrix3::Identity() + 0.2 * skew(any(1));
            inertias.push_back({0.3 + 0.2 * static_cast<double>(i), 1e-3 * A * A.transpose()});
            frames.push_back(make_frame({any(0.5), rotation_from_vector(any(1))}));
            momenta.push_back(six(2, 0.01));
            wrenches.push_back(six(3e3, 40));
            u.push_back(six(3, 20));
        }
        u[2].tail<3>() *= 300;
    }

    Vector3 any(double size) { return size * Vector3(normal_(random_), normal_(random_), normal_(random_)); }
    Vector6 six(double linear, double angular) {
        Vector6 v;
        v << any(linear), any(angular);
        return v;
    }
    template <class T>
    static std::span<const T> first(const std::vector<T>& list, size_t count) {
        return std::span(list).first(count);
    }

    std::vector<Inertia> inertias;
    std::vector<Frame> frames;
    std::vector<Vector6> momenta, wrenches, u;

private:
    std::mt19937 random_{17};
    std::normal_distribution<double> normal_;
};

/// Agree as vectors of forces and of moments.
void expect_near(const Vector6& a, const Vector6& b, double share, size_t i) {
    for (int half : {0, 3})
        EXPECT_LT((a - b).segment<3>(half).norm(), share * b.segment<3>(half).norm()) << half << ", " << i;
}

// Oracle: the formula with whole matrices, frame by frame.
TEST_F(SomeFrames, LackWhatTheirMomentumDoesNotGive) {
    for (size_t count = 0; count <= kCount; ++count) {
        std::vector<Vector6> r(count);
        find_imbalance(kStepOfMomentum, kSomeGravity, first(inertias, count), first(momenta, count), first(frames, count),
                       first(wrenches, count), first(u, count), r);
        for (size_t i = 0; i < count; ++i) {
            const Matrix3 R = frames[i].axes();
            const Vector3 v = u[i].head<3>(), w = u[i].tail<3>();
            Vector6 expected;
            expected << R.transpose() * (momenta[i].head<3>() + kStepOfMomentum * wrenches[i].head<3>() +
                                         kStepOfMomentum * inertias[i].mass * kSomeGravity) -
                            inertias[i].mass * v,
                R.transpose() * (momenta[i].tail<3>() + kStepOfMomentum * wrenches[i].tail<3>()) -
                    rotation_from_vector(0.5 * kStepOfMomentum * w) * inertias[i].moment * w;
            expect_near(r[i], expected, 1e-13, i);
        }
    }
}

// Oracle: momenta about the world's origin, which wrenches and weight alone change.
TEST_F(SomeFrames, TakeAStep) {
    for (size_t count = 0; count <= kCount; ++count) {
        std::vector<Vector6> moved(momenta.begin(), momenta.begin() + static_cast<long>(count));
        std::vector<Twist> velocities(count);
        take_step(kStepOfMomentum, kSomeGravity, first(inertias, count), first(frames, count), first(wrenches, count),
                  first(u, count), moved, velocities);
        for (size_t i = 0; i < count; ++i) {
            const Matrix3 R = frames[i].axes();
            const Vector3 x = frames[i].origin(), next = x + kStepOfMomentum * R * u[i].head<3>();
            const Vector3 force = wrenches[i].head<3>() + inertias[i].mass * kSomeGravity, p = moved[i].head<3>();
            EXPECT_LT((p - momenta[i].head<3>() - kStepOfMomentum * force).norm(), 1e-14 * p.norm());
            // x × P of the step before counts from where the frame is now, as P is along its way here
            const Vector3 before = x.cross(momenta[i].head<3>()) + momenta[i].tail<3>();
            const Vector3 now = next.cross(p) + moved[i].tail<3>();
            const Vector3 change = kStepOfMomentum * (wrenches[i].tail<3>() + x.cross(force));
            EXPECT_LT((now - before - change).norm(), 1e-13 * (now.norm() + change.norm())) << i;
            EXPECT_LT((velocities[i].linear - R * u[i].head<3>()).norm(), 1e-14 * u[i].head<3>().norm());
            EXPECT_LT((velocities[i].angular - R * u[i].tail<3>()).norm(), 1e-14 * u[i].tail<3>().norm());
        }
    }
}

TEST_F(SomeFrames, HaveALargestMotion) {
    std::vector<double> weights;
    double largest = 0;
    for (size_t i = 0; i < kCount; ++i) {
        weights.push_back(0.01 * static_cast<double>(kCount - i));
        largest = std::max(largest, std::sqrt(u[i].head<3>().squaredNorm() + weights[i] * u[i].tail<3>().squaredNorm()));
    }
    EXPECT_NEAR(largest_size(u, weights), largest, 1e-14 * largest);
    EXPECT_EQ(largest_size({}, {}), 0);
    for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
        for (const int at : {0, 3, 4, 5}) {
            std::vector<Vector6> spoilt = u;
            spoilt[1](at) = bad;
            EXPECT_FALSE(std::isfinite(largest_size(spoilt, weights))) << bad << " at " << at;
        }
}

TEST_F(SomeFrames, FollowTheirPorts) {
    std::vector<double> responses, change;
    for (int i = 0; i < 12; ++i) change.push_back(0.1 * i - 0.4);
    for (size_t i = 0; i < 72 * kCount; ++i) responses.push_back(std::sin(static_cast<double>(i)));
    std::vector<Vector6> sum(kCount);
    add_changes(u, momenta, responses, change, sum);
    for (size_t i = 0; i < kCount; ++i) {
        const Eigen::Map<const Eigen::Matrix<double, 6, 12>> response(&responses[72 * i]);
        const Vector6 expected = u[i] + momenta[i] + response * Eigen::Map<const Vector12>(change.data());
        expect_near(sum[i], expected, 1e-14, i);
    }
    add_changes(u, momenta, responses, {}, sum);
    for (size_t i = 0; i < kCount; ++i) EXPECT_EQ(sum[i], u[i] + momenta[i]);
    std::vector<Vector6> in_place = u;
    add_changes(in_place, momenta, responses, {}, in_place);
    EXPECT_EQ(in_place, sum);
}

}  // namespace
}  // namespace dttmm::plugin
