// SPDX-License-Identifier: BSD-3-Clause
#include "time/massless.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

using Unfixed = std::map<std::string, std::vector<double>>;

// A frame without mass between two guides that are rigid in x; those axes are turned against each other by an angle about z.
// Oracle: forces along x balance over the step, and the others at its end. Two directions that differ by more than a
// millionth of a turn are two: then forces along y balance over the step, too.
TEST(MasslessFrames, DirectionsWithinAMillionthAreOne) {
    const Unfixed guide = {{"stiffness.y", {2e4}},
                           {"stiffness.z", {3e4}},
                           {"stiffness.rx", {200}},
                           {"stiffness.ry", {300}},
                           {"stiffness.rz", {400}}};
    for (const double angle : {0.0, 0.8e-6, 1.25e-6, 0.3}) {
        test::NetworkModel model;
        const Eigen::Matrix3d turned = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
        model.node("one", DTTMM_NODE_GROUND, {0.1, 0.2, 0.3});
        model.node("other", DTTMM_NODE_GROUND, {0.1, 0.2, 0.3}, turned);
        model.node("frame", DTTMM_NODE_INNER, {0.1, 0.2, 0.3});
        model.element("first", "elastic_hinge", {"one", "frame"}, guide);
        model.element("second", "elastic_hinge", {"other", "frame"}, guide);
        const Mechanism mechanism(model.description());
        MasslessFrames massless(mechanism, {std::array{true, true}});
        massless.set_reach(std::array{0.7});
        massless.look(mechanism);
        std::vector<MasslessFrames::Residual> residuals(1);
        residuals[0].step << 1, 2, 3, 4, 5, 6;
        residuals[0].end << 10, 20, 30, 40, 50, 60;
        residuals[0].half_way = residuals[0].end;
        massless.combine(residuals);
        Vector6 expected;
        expected << 1, angle > 1e-6 ? 2 : 20, 30, 40, 50, 60;
        EXPECT_LT((residuals[0].step - expected).norm(), 1e-4) << angle << ": " << residuals[0].step.transpose();
    }
}

}  // namespace
}  // namespace dttmm::plugin
