// SPDX-License-Identifier: BSD-3-Clause
#include "statics/static_network.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/rotation.h"
#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

/// A bar that springs hold, clamped to the ground at its root, between that and a body.
test::NetworkModel bent_bar() {
    test::NetworkModel model;
    model.node("root", DTTMM_NODE_GROUND, {0.1, -0.2, 0.3});
    model.node("middle", DTTMM_NODE_INNER, {0.7, 0.1, 0.2});
    model.node("body", DTTMM_NODE_ON_BODY, {1.4, 0.2, 0.1});
    const test::NetworkModel::Values springs = {
        {"stiffness", {4e3, 2e3, 3e3}}, {"rotational_stiffness", {70, 40, 90}}, {"damping", {0}}};
    model.element("lower", "spring_damper", {"root", "middle"}, springs);
    model.element("upper", "spring_damper", {"middle", "body"}, springs);
    return model;
}

/// The condensed equations of a network whose inside took shares of its first correction, one after the other.
std::vector<double> formed_after(const std::vector<double>& shares) {
    const test::NetworkModel model = bent_bar();
    const dttmm_network description = model.description();
    const Mechanism mechanism(description);
    StaticNetwork network(mechanism, Loading(mechanism.assembly, description));
    dttmm_motion body{};
    body.position[0] = 1.4;
    body.position[1] = 0.2;
    body.position[2] = 0.1;
    for (const int i : {0, 4, 8}) body.rotation[i] = 1;
    const uint32_t index = 0;
    const double loads[6] = {300, -500, 200, 0, 0, 0};
    network.set_loads(Vector3::Zero(), loads);
    network.form({&body, &index}, 0);
    network.correct(std::vector<Vector6>(1, Vector6::Zero()));
    for (const double share : shares) network.move({&body, &index}, share);
    network.form({&body, &index}, 0);
    std::vector<double> all(42, 0.0);
    std::vector<Vector6> wrench(1, Vector6::Zero());
    network.condense(wrench, all.data());
    std::copy_n(wrench[0].data(), 6, all.data() + 36);
    return all;
}

// Oracle: the share that counts, taken alone: dttmm_static.h says that the first may be too large.
TEST(StaticNetwork, ASmallerShareTakesThePlaceOfTheFirst) {
    const std::vector<double> once = formed_after({0.3}), twice = formed_after({1, 0.3}), other = formed_after({1});
    for (size_t i = 0; i < once.size(); ++i) EXPECT_DOUBLE_EQ(twice[i], once[i]) << i;
    EXPECT_NE(other[0], once[0]) << "the share counts";
}

/// The bar under loads, its body moved by `motion` (world axes) from where it is assembled, the inside in balance.
class LoadedBar {
public:
    LoadedBar()
        : model_(bent_bar()),
          description_(model_.description()),
          mechanism_(description_),
          network_(mechanism_, Loading(mechanism_.assembly, description_)) {
        const double loads[6] = {30, -50, 20, 60, -35, 45};
        network_.set_loads({0, 0, -9.81}, loads);
    }
    Vector6 wrench_at(const Vector6& motion) {
        const Vector3 place = Vector3(1.4, 0.2, 0.1) + motion.head<3>();
        Eigen::Map<Vector3>{body_.position} = place;
        Eigen::Map<RowMajor3>{body_.rotation} = rotation_from_vector<double>(Vector3(motion.tail<3>()));
        for (int i = 0; i < 40; ++i) {
            network_.form({&body_, &kFirst}, 0);
            network_.correct(std::vector<Vector6>(1, Vector6::Zero()));
            network_.move({&body_, &kFirst}, 1);
        }
        return network_.wrench(0);
    }
    Matrix6 stiffness() {
        std::vector<double> S(36, 0.0);
        std::vector<Vector6> wrench(1, Vector6::Zero());
        network_.form({&body_, &kFirst}, 0);
        network_.condense(wrench, S.data());
        return Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(S.data());
    }

private:
    static constexpr uint32_t kFirst = 0;
    test::NetworkModel model_;
    dttmm_network description_;
    Mechanism mechanism_;
    StaticNetwork network_;
    dttmm_motion body_{};
};

// Oracle: central differences of the wrench on the body. What balances the wrench w = [F; M] there has beside it the part
// ½ [M]× by the turn of the body, which Loading derives.
TEST(StaticNetwork, AMomentThatKeepsItsDirectionHasNoPotential) {
    LoadedBar bar;
    Matrix6 differences;
    constexpr double kSmall = 1e-5;
    for (int c = 0; c < 6; ++c)
        differences.col(c) =
            -(bar.wrench_at(kSmall * Vector6::Unit(c)) - bar.wrench_at(-kSmall * Vector6::Unit(c))) / (2 * kSmall);
    const Vector6 wrench = bar.wrench_at(Vector6::Zero());
    Matrix6 expected = differences;
    expected.bottomRightCorner<3, 3>() -= 0.5 * skew(wrench.tail<3>());
    const Matrix6 S = bar.stiffness();
    EXPECT_LT((S - expected).norm(), 1e-7 * S.norm());
    EXPECT_GT((S - S.transpose()).norm(), 1e-3 * S.norm()) << "the moment inside counts";
}

}  // namespace
}  // namespace dttmm::plugin
