// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/frame.h"

#include <gtest/gtest.h>

#include <random>
#include <span>
#include <vector>

#include "core/rotation.h"

namespace dttmm::plugin {
namespace {

// Oracle: origin and axes by hand, which round by some 1e-16 of 1 m; counts with every remainder by four, one frame among
// them that turns far.
TEST(Frame, FramesMoveByTheirVelocities) {
    constexpr double h = 1e-4;
    std::mt19937 random(11);
    std::normal_distribution<double> normal;
    const auto any = [&](double size) { return Vector3(size * Vector3(normal(random), normal(random), normal(random))); };
    std::vector<Frame> from;
    std::vector<Vector6> u(7);
    for (Vector6& one : u) {
        from.push_back(make_frame({any(0.5), rotation_from_vector(any(1))}));
        one << any(20), any(20);
    }
    u[2].tail<3>() *= 500;
    for (size_t count : {0u, 1u, 4u, 5u, 6u, 7u}) {
        std::vector<Frame> to(count);
        move_frames(h, std::span(from).first(count), std::span(u).first(count), to);
        for (size_t i = 0; i < count; ++i) {
            const Matrix3 R = from[i].axes(), axes = R * rotation_from_vector(h * u[i].tail<3>());
            EXPECT_LT((to[i].axes() - axes).norm(), 1e-15) << count << ", " << i;
            EXPECT_LT((to[i].origin() - from[i].origin() - h * R * u[i].head<3>()).norm(), 1e-15) << count << ", " << i;
        }
    }
}

}  // namespace
}  // namespace dttmm::plugin
