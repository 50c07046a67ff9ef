// SPDX-License-Identifier: BSD-3-Clause
//
// A joint along a line between two ports.
#include <gtest/gtest.h>

#include "core/rotation.h"
#include "network/network.h"
#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

using test::NetworkModel;

struct Place {
    Vector3 position;
    Matrix3 rotation;
    dttmm_motion motion() const {
        dttmm_motion motion{};
        Eigen::Map<Vector3>{motion.position} = position;
        Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{motion.rotation} = rotation;
        return motion;
    }
    Place displaced(const Vector6& d) const {
        return {position + d.head<3>(), rotation_from_vector(Vector3(d.tail<3>())) * rotation};
    }
};

// Oracle: central differences of the wrench. Its symmetric part is the second derivative of the energy, as of any force that
// turns with what it acts on.
TEST(AxialJoint, StiffnessOfTheStepHasThatOfItsForce) {
    for (const NetworkModel::Values& law :
         {NetworkModel::Values{{"stiffness", {4e3}}, {"damping", {7}}, {"preload", {900}}},
          NetworkModel::Values{{"law", {1}}, {"stiffness", {3e3}}, {"cubic", {2e5}}, {"natural_length", {0.35}}}}) {
        const Place start[2] = {{Vector3(0.3, -0.1, 0.2), rotation_from_vector(Vector3(0.4, -0.8, 1.3))},
                                {Vector3(0.6, 0.25, -0.1), rotation_from_vector(Vector3(-1.1, 0.2, 0.6))}};
        NetworkModel model;
        const Vector3 arms[2] = {{0.07, -0.11, 0.05}, {-0.13, 0.04, 0.09}};
        for (int p : {0, 1}) {
            dttmm_node& node = model.node(p == 0 ? "a" : "b", DTTMM_NODE_PORT, start[p].position, start[p].rotation);
            Eigen::Map<Vector3>{node.arm} = arms[p];
        }
        model.element("s", "axial_spring", {"a", "b"}, law);
        Network network(model.description());
        const double accelerations[12] = {};
        const dttmm_motion motions[] = {start[0].motion(), start[1].motion()};
        network.start({0, 0, 0.01}, motions, accelerations, nullptr);
        network.begin_step({0, 0, 0.01}, nullptr);
        using Vector = Eigen::Matrix<double, 12, 1>;
        const auto wrench_at = [&](const Place& a, const Place& b) {
            const dttmm_motion trial[] = {a.motion(), b.motion()};
            Vector wrench;
            network.evaluate(trial, wrench.data(), nullptr);
            return wrench;
        };
        Vector wrench;
        Eigen::Matrix<double, 12, 12, Eigen::RowMajor> S;
        network.evaluate(motions, wrench.data(), S.data());
        // About the centres of mass, to which the symmetric part belongs
        const auto about_centres = [&](auto&& rows) {
            for (int p : {0, 1})
                rows.template middleRows<3>(6 * p + 3) +=
                    (skew(start[p].rotation * arms[p]) * rows.template middleRows<3>(6 * p)).eval();
        };
        Eigen::Matrix<double, 12, 12> difference, own = S;
        for (int i = 0; i < 12; ++i) {
            const double e = 1e-6;
            // Displaced at its centre of mass; the wrench at the port has the arm of t_n, as the host has it
            const auto moved = [&](double way) {
                Place at[2] = {start[0], start[1]};
                const int p = i / 6;
                const Vector3 arm = start[p].rotation * arms[p];
                Vector6 d = way * Vector6::Unit(i % 6);
                d.head<3>() += rotation_from_vector(Vector3(d.tail<3>())) * arm - arm;
                at[p] = start[p].displaced(d);
                Vector w = wrench_at(at[0], at[1]);
                for (int q : {0, 1})
                    w.segment<3>(6 * q + 3) += (start[q].rotation * arms[q]).cross(Vector3(w.segment<3>(6 * q)));
                return w;
            };
            difference.col(i) = -(moved(e) - moved(-e)) / (2 * e);
        }
        about_centres(own);
        own.transposeInPlace();
        about_centres(own);
        own.transposeInPlace();
        const Eigen::Matrix<double, 12, 12> expected = 0.5 * (difference + difference.transpose());
        const Eigen::Matrix<double, 12, 12> found = 0.5 * (own + own.transpose());
        EXPECT_LT((found - expected).norm(), 1e-6 * expected.norm());
    }
}

}  // namespace
}  // namespace dttmm::plugin
