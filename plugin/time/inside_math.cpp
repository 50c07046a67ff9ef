// SPDX-License-Identifier: BSD-3-Clause
#include "time/inside_math.h"

namespace dttmm::plugin {

Matrix6 mass_matrix(const Inertia& inertia) {
    Matrix6 M = Matrix6::Zero();
    M.topLeftCorner<3, 3>().diagonal().setConstant(inertia.mass);
    M.bottomRightCorner<3, 3>() = inertia.moment;
    return M;
}

Matrix6 local_columns(const Mechanism& mechanism, size_t j, int end) {
    const Joint& joint = mechanism.joints[j];
    return local_columns(joint, mechanism.pose(j), end, mechanism.frame(joint.frame(end)));
}

Matrix6 local_columns(const Joint& joint, const JointPose& pose, int end, FrameView frame) {
    Matrix6 G = end == 0 ? joint.by_from(pose) : joint.by_to(pose);
    for (int c : {0, 3}) G.middleCols<3>(c) = (G.middleCols<3>(c) * frame.axes()).eval();
    return G;
}

Matrix6 rigid_rows(const Mechanism& mechanism, size_t j, const Matrix6& columns) {
    return rigid_rows(mechanism.joints[j], mechanism.theta(j), columns);
}

namespace {

void set_rows(const Joint& joint, size_t j, const JointPose& pose, const Vector3& theta, Ends frames, Elimination& matrix) {
    const Matrix6 rows[2] = {rigid_rows(joint, theta, local_columns(joint, pose, 0, frames.from)),
                             rigid_rows(joint, theta, local_columns(joint, pose, 1, frames.to))};
    for_each_rigid(joint, [&](int i, int d) {
        matrix.set_rigid(as_int(j), i, rows[0].row(d).transpose(), rows[1].row(d).transpose());
    });
}

}  // namespace

void set_rigid_rows(const Mechanism& mechanism, size_t j, const JointPose& pose, const Vector3& theta, Elimination& matrix) {
    set_rows(mechanism.joints[j], j, pose, theta, mechanism.ends(j), matrix);
}

void set_rigid_rows(const Mechanism& mechanism, size_t j, const std::vector<Frame>& at, Elimination& matrix) {
    const Joint& joint = mechanism.joints[j];
    const Ends frames = ends(joint, at);
    set_rows(joint, j, joint.pose(frames), joint.rotation(frames.from, frames.to), frames, matrix);
}

void factor_or_refuse(const Mechanism& mechanism, Elimination& matrix, dttmm_status status) {
    if (const auto fault = matrix.factor()) refuse_singular(mechanism, *fault, status);
}

}  // namespace dttmm::plugin
