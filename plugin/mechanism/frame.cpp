// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/frame.h"

#include <cassert>

#include "core/rotation.h"

namespace dttmm::plugin {

Frame make_frame(const Pose& pose) {
    Frame frame;
    Eigen::Map<Vector3>{frame.position} = pose.position;
    Eigen::Map<RowMajor3>{frame.rotation} = pose.rotation;
    return frame;
}

DTTMM_WIDE void move_frames(double h, std::span<const Frame> from, std::span<const Vector6> u, std::span<Frame> to) {
    assert(u.size() == from.size() && to.size() == from.size());
    const auto move = [h]<class Real>(const FrameOf<Real>& now, const Eigen::Matrix<Real, 6, 1>& velocity,
                                      FrameOf<Real>& next) {
        const Vector3Of<Real> way = now.axes() * velocity.template head<3>();
        const Vector3Of<Real> turn = Real(h) * velocity.template tail<3>();
        Eigen::Map<Vector3Of<Real>>{next.position} = now.origin() + Real(h) * way;
        Eigen::Map<RowMajor3Of<Real>>{next.rotation}.noalias() = now.axes() * rotation_from_vector<Real>(turn);
    };
    size_t i = 0;
    for (; i + Lanes::kCount <= from.size(); i += Lanes::kCount) {
        const FrameOf<Lanes> now = gather_records<FrameOf>([&](size_t k) -> auto& { return from[i + k]; });
        Eigen::Matrix<Lanes, 6, 1> velocity;
        gather<6>({u[i].data(), u[i + 1].data(), u[i + 2].data(), u[i + 3].data()}, velocity.data());
        FrameOf<Lanes> next;
        move(now, velocity, next);
        scatter_records(
            next, [&](size_t k) -> auto& { return to[i + k]; });
    }
    for (; i < from.size(); ++i) move(from[i], u[i], to[i]);
}

}  // namespace dttmm::plugin
