// SPDX-License-Identifier: BSD-3-Clause
//
// Joints between bodies, side by side.
#include "time/body_joints.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "core/rotation.h"
#include "support/dense_network.h"
#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

using test::DenseNetwork;
using test::NetworkModel;

constexpr double kStep = 1e-3;

/// Joints of every kind between three bodies and the ground; before them others of each kind that hardly push.
NetworkModel joined_bodies(uint32_t scheme, double gamma, int decoys) {
    NetworkModel model(scheme, 0.25 * (gamma + 0.5) * (gamma + 0.5), gamma);
    model.node("ground", DTTMM_NODE_GROUND, Vector3(0.1, 0.2, -0.3));
    model.node("a", DTTMM_NODE_ON_BODY, Vector3(0.7, -0.2, 0.4), rotation_from_vector(Vector3(0.4, -0.8, 1.3)),
               Vector3(0.3, 0.1, -0.2));
    model.node("b", DTTMM_NODE_ON_BODY, Vector3(-0.5, 0.9, 0.1), rotation_from_vector(Vector3(-1.1, 0.2, 0.6)),
               Vector3(-0.1, 0.4, 0.2));
    model.node("c", DTTMM_NODE_ON_BODY, Vector3(0.2, 0.3, -0.8));
    const std::vector<std::string> pairs[] = {{"ground", "a"}, {"a", "b"}, {"c", "b"}, {"ground", "c"}};
    const auto add = [&](const std::string& name, int i, double size) {
        NetworkModel::Values springs = {{"stiffness", {1e4 * size, 2e4 * size, (3e4 + i) * size}}};
        if (i % 2 == 0) springs["damping"] = {20 * size, 30 * size, 40 * size};
        if (i % 3 == 0) springs["rotational_stiffness"] = {400 * size, 500 * size, 600 * size};
        model.element(name, "spring_damper", pairs[i % 4], springs);
    };
    for (int i = 0; i < 6 * decoys; ++i) add("decoy" + std::to_string(i), i, 1e-13);
    for (int i = 0; i < 19; ++i) add("spring" + std::to_string(i), i, 1);
    model.element("rod", "axial_spring", {"a", "b"}, {{"stiffness", {4e3}}});
    if (scheme == DTTMM_SCHEME_CENTRED)
        model.element("stiffening", "axial_spring", {"a", "c"},
                      {{"law", {1}}, {"stiffness", {3e3}}, {"cubic", {2e5}}, {"natural_length", {0.9}}});
    return model;
}

/// The wrenches on the bodies over ten steps of a given motion.
std::vector<Eigen::VectorXd> wrenches(const NetworkModel& model) {
    const dttmm_network description = model.description();
    const auto motions = [&](double t) {
        std::vector<dttmm_motion> list;
        for (int p = 0; p < 3; ++p) {
            const dttmm_body& body = description.bodies[p];
            const double phase = 30 * t + p;
            const Vector3 way(0.01 * std::sin(phase), 0.02 * std::sin(0.7 * phase), -0.01 * std::sin(1.3 * phase)),
                turn(0.1 * std::sin(0.9 * phase), -0.05 * std::sin(phase), 0.08 * std::sin(1.1 * phase));
            dttmm_motion motion{};
            Eigen::Map<Vector3>{motion.position} = Eigen::Map<const Vector3>(body.position) + way;
            Eigen::Map<RowMajor3>{motion.rotation} = rotation_from_vector(turn) * Eigen::Map<const RowMajor3>(body.rotation);
            list.push_back(motion);
        }
        return list;
    };
    DenseNetwork network(description);
    const double accelerations[18] = {};
    network.start({0, 0, kStep}, motions(0).data(), accelerations, nullptr);
    std::vector<Eigen::VectorXd> list;
    for (uint64_t n = 0; n < 10; ++n) {
        network.begin_step({n, static_cast<double>(n) * kStep, kStep}, nullptr);
        const std::vector<dttmm_motion> end = motions(static_cast<double>(n + 1) * kStep);
        Eigen::VectorXd& wrench = list.emplace_back(18);
        network.evaluate(end.data(), wrench.data(), nullptr);
        network.commit_step(end.data());
    }
    return list;
}

// Oracle: the same joints one more or less before them, so that others go together by four, or alone.
TEST(BodyJoints, PushAlikeInWhateverCompany) {
    for (const auto& [scheme, gamma] : {std::pair<uint32_t, double>{DTTMM_SCHEME_CENTRED, 0.5},
                                        {DTTMM_SCHEME_CENTRED, 0.6},
                                        {DTTMM_SCHEME_FOX_EULER, 0.5},
                                        {DTTMM_SCHEME_PARK, 0.5}}) {
        const std::vector<Eigen::VectorXd> alone = wrenches(joined_bodies(scheme, gamma, 0));
        for (const int decoys : {1, 2, 3}) {
            const std::vector<Eigen::VectorXd> beside = wrenches(joined_bodies(scheme, gamma, decoys));
            for (size_t n = 0; n < alone.size(); ++n)
                EXPECT_LT((beside[n] - alone[n]).norm(), 1e-11 * alone[n].norm()) << scheme << ' ' << decoys << ' ' << n;
        }
    }
}

}  // namespace
}  // namespace dttmm::plugin
