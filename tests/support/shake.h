// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Dense>

#include "support/bodies.h"
#include "world/joint_equations.h"
#include "world/rotation_step.h"
#include "world/world.h"

namespace dttmm::test {

/// The motion over a step of the SHAKE scheme by dense algebra: u = u₋ + h M⁻¹ w − M⁻¹ Jᵀ q with the joints closed at its
/// end, poses included. now: velocities over the step before. Oracle of World.
inline std::vector<BodyState> shake(const std::vector<Body>& bodies, const std::vector<Joint>& joints,
                                    const std::vector<BodyState>& now,
                                    const std::vector<Eigen::Matrix<double, 6, 1>>& wrenches, double h) {
    const auto n = static_cast<Eigen::Index>(bodies.size());
    Eigen::VectorXd u(6 * n);
    Eigen::MatrixXd M = Eigen::MatrixXd::Zero(6 * n, 6 * n), J(0, 6 * n);
    for (Eigen::Index b = 0; b < n; ++b) {
        const auto& state = now[static_cast<size_t>(b)];
        M.block<6, 6>(6 * b, 6 * b) = Inertia(bodies[static_cast<size_t>(b)]).block(state.rotation);
        u.segment<6>(6 * b) << state.velocity, state.angular_velocity;
        u.segment<6>(6 * b) += h * M.block<6, 6>(6 * b, 6 * b).inverse() * wrenches[static_cast<size_t>(b)];
    }
    std::vector<BodyState> end = now;
    for (int pass = 0; pass < 30; ++pass) {
        for (size_t b = 0; b < end.size(); ++b) {
            const auto motion = u.segment<6>(6 * static_cast<Eigen::Index>(b));
            end[b].velocity = motion.head<3>();
            end[b].angular_velocity = motion.tail<3>();
            end[b].position = now[b].position + h * end[b].velocity;
            end[b].rotation = RotationStep(h * end[b].angular_velocity).apply(now[b].rotation);
        }
        J.resize(0, 6 * n);
        Eigen::VectorXd lacking(0);
        for (size_t j = 0; j < joints.size(); ++j) {
            const JointEquations joint(joints[j], bodies);
            const auto jacobian = joint.jacobian(now);
            const int rows = joint.lasting();
            const Eigen::Index first = J.rows();
            J.conservativeResize(first + rows, Eigen::NoChange);
            J.bottomRows(rows).setZero();
            for (const size_t side : {0u, 1u})
                if (const int body = joint.bodies()[side]; body >= 0)
                    J.block(first, 6 * body, rows, 6) = jacobian[side].topRows(rows);
            lacking.conservativeResize(first + rows);
            lacking.tail(rows) = joint.residual(end) / -h;
        }
        const Eigen::MatrixXd mobility = J * M.inverse() * J.transpose();
        u += M.inverse() * J.transpose() * mobility.completeOrthogonalDecomposition().solve(lacking);
    }
    return end;
}

}  // namespace dttmm::test
