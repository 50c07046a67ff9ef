// SPDX-License-Identifier: BSD-3-Clause
#include "element/divided_line.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "element/line_parts.h"

namespace dttmm::plugin {
namespace {

using namespace test_lines;
using testing::HasSubstr;

/// Text of the error with which an element refuses.
template <class Call>
std::string axes_refusal(const Call& call) {
    try {
        call();
        return "not refused";
    } catch (const Error& error) {
        EXPECT_EQ(error.status(), DTTMM_ERROR_MODEL);
        return error.what();
    }
}

// Oracle: the rule in words, x along, z as near to world z as can be; for simple directions the axes written down.
TEST(BeamAxes, ZIsAsNearToTheWorldsAsCanBe) {
    const auto axes = [](const Vector3& way) { return beam_axes(kFrom, kFrom + way, kNotGiven3); };
    Matrix3 along_y, down_x;
    along_y << 0, -1, 0, 1, 0, 0, 0, 0, 1;          // x → Y, y → −X, z → Z
    down_x << -0.6, 0, 0.8, 0, -1, 0, 0.8, 0, 0.6;  // columns: x = (−0.6, 0, 0.8), y, z
    EXPECT_LT((axes({2, 0, 0}) - Matrix3::Identity()).norm(), 1e-15);
    EXPECT_LT((axes({0, 0.3, 0}) - along_y).norm(), 1e-15);
    EXPECT_LT((axes({-3, 0, 4}) - down_x).norm(), 1e-15);
    for (const Vector3& way : {Vector3(1, 2, 3), Vector3(-1, 0.4, -7), Vector3(1e-3, -2e-3, 1e-4), Vector3(1, 1, 1e5)}) {
        const Matrix3 R = axes(way);
        EXPECT_LT((R.transpose() * R - Matrix3::Identity()).norm(), 1e-14);
        EXPECT_GT(R.determinant(), 0);
        EXPECT_LT((R.col(0) - way.normalized()).norm(), 1e-12);
        EXPECT_LT(std::abs(R(2, 1)), 1e-12) << "y is horizontal";
        EXPECT_GT(R(2, 2), 0);
    }
}

// For a vertical beam z is the world's x, upwards and downwards.
TEST(BeamAxes, OfAVerticalBeamZIsTheWorldsX) {
    for (double way : {0.7, -0.7}) {
        const Matrix3 R = beam_axes(kFrom, kFrom + Vector3(0, 0, way), kNotGiven3);
        EXPECT_EQ(R.col(2), Vector3::UnitX());
        EXPECT_LT((R.col(0) - Vector3(0, 0, way / 0.7)).norm(), 1e-15);
        EXPECT_LT((R.col(1) - Vector3(0, -way / 0.7, 0)).norm(), 1e-15);
    }
}

// `up` of any length, and not square to the beam: z is what of it is square, y square to both.
TEST(BeamAxes, UpIsWhereZPoints) {
    const Vector3 up(-30, 12, 7), way = kTo - kFrom;
    const Matrix3 R = beam_axes(kFrom, kTo, up);
    EXPECT_LT((R.col(0) - way.normalized()).norm(), 1e-15);
    EXPECT_LT(std::abs(R.col(1).dot(up)), 1e-13);
    EXPECT_GT(R.col(2).dot(up), 0);
    EXPECT_LT((R.transpose() * R - Matrix3::Identity()).norm(), 1e-14);
    EXPECT_GT(R.determinant(), 0);
    // Nearly along the beam, as far as that is allowed
    const Matrix3 S = beam_axes(kFrom, kTo, way + 2e-6 * Vector3(1, 0, 0));
    EXPECT_LT((S.transpose() * S - Matrix3::Identity()).norm(), 1e-14);
    EXPECT_GT(S.col(2).x(), 0);
}

TEST(BeamAxes, NoLengthAndNoUpAreRefused) {
    EXPECT_THAT(axes_refusal([] { beam_axes(kFrom, kFrom, kNotGiven3); }), HasSubstr("0 m apart"));
    EXPECT_THAT(axes_refusal([] { beam_axes(kFrom, kFrom + Vector3(0, 9e-7, 0), kNotGiven3); }), HasSubstr("9e-07 m apart"));
    EXPECT_THAT(axes_refusal([] { beam_axes(kFrom, kTo, 3 * (kTo - kFrom)); }), HasSubstr("up:"));
    EXPECT_THAT(axes_refusal([] { beam_axes(kFrom, kTo, kFrom - kTo); }), HasSubstr("must not lie along the beam"));
    EXPECT_THAT(axes_refusal([] { beam_axes(kFrom, kTo, Vector3::Zero()); }), HasSubstr("must have a length"));
    EXPECT_NO_THROW(beam_axes(kFrom, kFrom + Vector3(0, 2e-6, 0), kNotGiven3));
}

}  // namespace
}  // namespace dttmm::plugin
