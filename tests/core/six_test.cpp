// SPDX-License-Identifier: BSD-3-Clause
#include "core/six.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/types.h"

namespace dttmm::plugin {
namespace {

template <class Make>
Vector6 stored(const Make& make) {
    Eigen::Matrix<double, 8, 1> room = Eigen::Matrix<double, 8, 1>::Constant(-7);
    make().store(room.data() + 1);
    EXPECT_EQ(room(0), -7);
    EXPECT_EQ(room(7), -7);
    return room.segment<6>(1);
}

class SixOfAnySize : public testing::Test {
protected:
    Vector6 any() {
        Vector6 v;
        for (int i = 0; i < 6; ++i) v(i) = normal_(random_) * std::pow(10, i - 3);
        return v;
    }
    Matrix6 any_matrix() {
        Matrix6 A;
        for (int i = 0; i < 6; ++i) A.col(i) = any();
        return A;
    }

private:
    std::mt19937 random_{5};
    std::normal_distribution<double> normal_;
};

TEST_F(SixOfAnySize, AreLoadedAndStoredAndAdded) {
    const Vector6 a = any(), b = any();
    EXPECT_EQ(stored([&] { return Six(a.data()); }), a);
    EXPECT_EQ(stored([&] { return Six(a.data()) + Six(b.data()); }), a + b);
    EXPECT_EQ(stored([&] { return Six(a.data()) - Six(b.data()); }), a - b);
    EXPECT_EQ(stored([&] { return Six(a.data()) * 0.3; }), a * 0.3);
    EXPECT_EQ(stored([&] { return Six(a.data()) * Six(b.data()); }), a.cwiseProduct(b));
}

// Oracle: Eigen's products, which sum in another order.
TEST_F(SixOfAnySize, AreMultipliedByAMatrixAndItsTranspose) {
    for (int n = 0; n < 20; ++n) {
        const Matrix6 A = any_matrix();
        const Vector6 x = any(), y = stored([&] { return product(A.data(), x.data()); }),
                      z = stored([&] { return transposed_product(A.data(), x.data()); });
        const Vector6 size = A.cwiseAbs() * x.cwiseAbs(), transposed_size = A.transpose().cwiseAbs() * x.cwiseAbs();
        for (int i = 0; i < 6; ++i) {
            EXPECT_NEAR(y(i), A.row(i).dot(x), 1e-15 * size(i)) << i;
            EXPECT_NEAR(z(i), A.col(i).dot(x), 1e-15 * transposed_size(i)) << i;
        }
    }
}

}  // namespace
}  // namespace dttmm::plugin
