// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/loading.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "core/index.h"
#include "core/rotation.h"

namespace dttmm::plugin {

Loading::Loading(const Assembly& assembly, const dttmm_network& description) {
    for (uint32_t n = 0; n < description.node_count; ++n) {
        if (description.nodes[n].kind != DTTMM_NODE_INNER) continue;
        const NodeSpec& node = assembly.nodes[n];
        if (node.frame >= assembly.driven_count)
            actions_.push_back(
                {node.frame, Action::Kind::at_node, value_count_, node.offset, !node.offset.isZero(0), 0, 0, 0});
        value_count_ += 6;
    }
    for (uint32_t k = 0; k < description.line_load_count; ++k, value_count_ += 6) {
        const dttmm_line_load& load = description.line_loads[k];
        const auto kind = load.axes == DTTMM_AXES_ELEMENT ? Action::Kind::turns_with_segment : Action::Kind::on_segment;
        for (const SegmentsSpec& line : assembly.segments) {
            if (line.element != as_int(load.element)) continue;
            const double l = line.length;
            for (int i = 0; i < line.count; ++i)
                actions_.push_back({line.first + i, kind, value_count_, line.arm, !line.arm.isZero(0),
                                    (i + 0.5) / line.count, l, l * l / (12 * line.count)});
        }
    }
    std::ranges::stable_sort(actions_, {}, &Action::frame);
    begin_.assign(assembly.frames.size() + 1, 0);
    for (const Action& action : actions_) ++begin_[as_size(action.frame) + 1];
    for (size_t f = 1; f < begin_.size(); ++f) begin_[f] += begin_[f - 1];
}

inline Loading::Acting Loading::acting(const Action& action, FrameView at, const double* values) {
    const Eigen::Map<const Vector3> first(values + action.value), second(values + action.value + 3);
    const Vector3 arm = action.has_arm ? Vector3(at.axes() * action.arm) : Vector3(Vector3::Zero());
    if (action.kind == Action::Kind::at_node) return {first, arm, second, Vector3::Zero()};
    const Vector3 change = second - first;
    Acting load{action.length * (first + action.share * change), arm, Vector3::Zero(), action.couple * change};
    if (action.kind == Action::Kind::turns_with_segment) {
        load.force = (at.axes() * load.force).eval();
        load.slope = (at.axes() * load.slope).eval();
    }
    return load;
}

Vector6 Loading::wrench(int frame, FrameView at, const double* values) const {
    Vector6 sum = Vector6::Zero();
    for (size_t a = begin_[as_size(frame)]; a < begin_[as_size(frame) + 1]; ++a) {
        const Acting load = acting(actions_[a], at, values);
        sum.head<3>() += load.force;
        sum.tail<3>() += load.moment + load.arm.cross(load.force) + Vector3(at.axes().col(0)).cross(load.slope);
    }
    return sum;
}

Matrix6 Loading::stiffness(int frame, FrameView at, const Vector3& origin, const double* values) const {
    Matrix6 sum = Matrix6::Zero();
    for (size_t a = begin_[as_size(frame)]; a < begin_[as_size(frame) + 1]; ++a) {
        const Acting load = acting(actions_[a], at, values);
        if (actions_[a].kind == Action::Kind::turns_with_segment) {
            const Matrix3 half = 0.5 * skew(load.force);
            sum.topRightCorner<3, 3>() += half;
            sum.bottomLeftCorner<3, 3>() += half.transpose();
            continue;
        }
        const Vector3 arm = load.arm + at.origin() - origin;
        const Matrix3 turned = skew(arm) * skew(load.force) + skew(Vector3(at.axes().col(0))) * skew(load.slope);
        sum.bottomRightCorner<3, 3>() -= 0.5 * (turned + turned.transpose());
    }
    return sum;
}

Matrix6 Loading::unsymmetric_stiffness(int frame, FrameView at, const double* values) const {
    Matrix6 sum = Matrix6::Zero();
    for (size_t a = begin_[as_size(frame)]; a < begin_[as_size(frame) + 1]; ++a) {
        const Acting load = acting(actions_[a], at, values);
        if (actions_[a].kind == Action::Kind::at_node) {
            sum.bottomRightCorner<3, 3>() -= 0.5 * skew(load.moment);
        } else if (actions_[a].kind == Action::Kind::turns_with_segment) {
            const Vector3 moment = load.arm.cross(load.force) + Vector3(at.axes().col(0)).cross(load.slope);
            const Matrix3 half = 0.5 * skew(load.force);
            sum.topRightCorner<3, 3>() += half;
            sum.bottomLeftCorner<3, 3>() += half;
            sum.bottomRightCorner<3, 3>() += 0.5 * skew(moment);
        }
    }
    return sum;
}

void Loading::add_wrenches(std::span<const Frame> frames, const double* values, std::span<Vector6> wrenches) const {
    for (size_t f = 0; f + 1 < begin_.size(); ++f)
        if (is_on(as_int(f))) wrenches[f] += wrench(as_int(f), frames[f], values);
}

}  // namespace dttmm::plugin
