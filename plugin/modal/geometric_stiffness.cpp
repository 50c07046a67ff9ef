// SPDX-License-Identifier: BSD-3-Clause
#include "modal/geometric_stiffness.h"

#include <tuple>

#include "core/error.h"
#include "modal/dynamic_stiffness.h"

namespace dttmm::plugin {

namespace {

/// A force on a point of a frame [N, world]; of an element, or a reaction to it.
struct PointForce {
    int element, frame;
    Vector3 point, force;
};

void add_lever(FrequencyModel& model, const PointForce& acting) {
    const Matrix3 aF = skew(acting.point - model.origin(acting.frame)) * skew(acting.force);
    Matrix6 stiffness = Matrix6::Zero();
    stiffness.bottomRightCorner<3, 3>() = -0.5 * (aF + aF.transpose());
    model.levers.push_back({acting.element, acting.frame, model.mask * stiffness * model.mask});
}

std::vector<PointForce> forces_at_start(const FrequencyModel& model) {
    std::vector<PointForce> forces;
    for (const Bond& bond : model.bonds) {
        if (bond.tension == 0) continue;
        const Vector3 along = bond.axes.col(0).head<3>();
        if (bond.from >= 0) forces.push_back({bond.element, bond.from, bond.points[0], bond.tension * along});
        if (bond.to >= 0) forces.push_back({bond.element, bond.to, bond.points[1], -bond.tension * along});
    }
    return forces;
}

/// The reactions of rigid directions, as masses at rest leave them to these. Without their levers a body on a hinge would
/// turn about its centre of mass.
std::vector<PointForce> reactions_to(const std::vector<PointForce>& forces, FrequencyModel& model) {
    constexpr double kAtRest = 1e6;  // −λ M over K. The flap on a hinge has one frequency to 1e-5 from 1e4 to 1e8
    DynamicStiffness stiffness(model);
    stiffness.cut(0);
    const double stiffest = stiffness.stiffest();
    if (!stiffness.factor_far_below(stiffest > 0 ? -kAtRest * stiffest : -1))
        throw Error(DTTMM_ERROR_NUMERIC, "the reactions to the forces of its springs at the start cannot be determined");
    FrameVector r(as_size(stiffness.frame_count()), Vector6::Zero());
    for (const PointForce& acting : forces) {
        Vector6 force;
        force << acting.force, Vector3::Zero();
        const Matrix6 by = FrequencyModel::at_point(acting.point, model.origin(acting.frame));
        r[as_size(acting.frame)] += by.transpose() * force;
    }
    const std::vector<double> q = stiffness.solve(r);
    std::vector<PointForce> reactions;
    size_t row = 0;
    for (const Bond& bond : model.bonds)
        for (const Rigid& rigid : bond.rigid) {
            const double force = -q[row++];
            for (const auto& [frame, by, end] : {std::tuple(bond.from, &rigid.by_from, 0), {bond.to, &rigid.by_to, 1}})
                if (frame >= 0)
                    reactions.push_back({forces.front().element, frame, bond.points[end], force * by->head<3>()});
        }
    return reactions;
}

}  // namespace

void add_geometric_stiffness(FrequencyModel& model) {
    const std::vector<PointForce> forces = forces_at_start(model);
    if (forces.empty()) return;
    for (const PointForce& acting : forces) add_lever(model, acting);
    for (const PointForce& acting : reactions_to(forces, model)) add_lever(model, acting);
}

}  // namespace dttmm::plugin
