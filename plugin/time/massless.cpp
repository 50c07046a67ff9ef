// SPDX-License-Identifier: BSD-3-Clause
#include "time/massless.h"

#include <algorithm>
#include <utility>

#include "core/rounding.h"
#include "time/inside_math.h"

namespace dttmm::plugin {

MasslessFrames::MasslessFrames(const Mechanism& mechanism, const std::vector<std::array<bool, 2>>& massless)
    : MasslessSet(mechanism, massless),
      settling_(mechanism.joints.size(), false),
      half_way_(mechanism.joints.size(), false) {
    MasslessGroups groups = group(mechanism, [](const Joint& joint) { return joint.rigid().any(); });
    part_of_ = std::move(groups.of);
    begin_ = std::move(groups.begin);
    for (MasslessGroup& group : groups.all) {
        Part& part = parts_.emplace_back();
        part.group = std::move(group);
        const auto size = as_row(6 * part.group.frames.size());
        part.basis.setZero(size, size);
        for (Eigen::VectorXd* v : {&part.end, &part.step, &part.half_way}) v->setZero(size);
        part.unit.setOnes(size);
    }
    for (size_t j = 0; j < mechanism.joints.size(); ++j)
        for (int frame : {mechanism.joints[j].from(), mechanism.joints[j].to()}) {
            const int i = index_of(mechanism, frame);
            if (i < 0) continue;
            settling_[j] = true;
            const bool has_damped = !parts_[as_size(part_of_[as_size(i)])].group.damped.empty();
            half_way_[j] = half_way_[j] || (has_damped && mechanism.joints[j].is_damped());
        }
}

/// A frame without a reach has that of its neighbours.
void MasslessFrames::set_reach(std::span<const double> reach) {
    for (Part& part : parts_) {
        double longest = 0;
        for (size_t i : part.group.frames) longest = std::max(longest, reach[frames()[i]]);
        for (size_t k = 0; k < part.group.frames.size() && longest > 0; ++k) {
            const double own = reach[frames()[part.group.frames[k]]];
            part.unit.segment<3>(as_row(6 * k) + 3).setConstant(1 / (own > 0 ? own : longest));
        }
    }
}

void MasslessFrames::look(const Mechanism& mechanism) {
    for (Part& part : parts_) {
        if (part.is_rigid || (part.group.rigid.empty() && part.group.damped.empty())) continue;
        part.rank = 0;
        for (const MasslessRow& row : part.group.rigid) add_to_basis(mechanism, part, row, true);
        part.rigid_rank = part.rank;
        for (const MasslessRow& row : part.group.damped) add_to_basis(mechanism, part, row, false);
        if (!mechanism.scheme.is_trapezoidal()) part.rigid_rank = part.rank;
        int unknowns = 0;
        for (size_t i : part.group.frames) unknowns += 3 * (has_none(i, 0) + has_none(i, 1));
        part.is_rigid = part.rigid_rank == unknowns;
    }
}

/// By Gram and Schmidt, twice.
void MasslessFrames::add_to_basis(const Mechanism& mechanism, Part& part, const MasslessRow& row, bool is_rigid) const {
    if (part.rank == part.basis.cols()) return;
    auto next = part.basis.col(part.rank);
    next.setZero();
    const Joint& joint = mechanism.joints[row.joint];
    for (int end : {0, 1}) {
        const int i = index_of(mechanism, end == 0 ? joint.from() : joint.to());
        if (i < 0 || std::ranges::find(part.group.frames, as_size(i)) == part.group.frames.end()) continue;
        Matrix6 G = local_columns(mechanism, row.joint, end);
        if (is_rigid) G = rigid_rows(mechanism, row.joint, G);
        for (int half : {0, 1})
            if (has_none(as_size(i), half))
                next.segment<3>(begin_[as_size(i)] + 3 * half) += G.block<1, 3>(row.direction, 3 * half).transpose();
    }
    next.array() *= part.unit.array();
    const double size = next.norm();
    for ([[maybe_unused]] const int round : {0, 1})
        for (int k = 0; k < part.rank; ++k) next -= part.basis.col(k).dot(next) * part.basis.col(k);
    const double left = next.norm();
    if (!(left > kNextToNothing * size)) return;
    next /= left;
    ++part.rank;
}

void MasslessFrames::combine(std::span<Residual> residuals) const {
    for (const Part& part : parts_) {
        if (part.is_rigid) continue;
        for (size_t k = 0; k < part.group.frames.size(); ++k) {
            const Residual& own = residuals[part.group.frames[k]];
            part.end.segment<6>(as_row(6 * k)) = own.end;
            part.step.segment<6>(as_row(6 * k)) = own.step - own.end;
            part.half_way.segment<6>(as_row(6 * k)) = own.half_way - own.end;
        }
        for (Eigen::VectorXd* v : {&part.end, &part.step, &part.half_way}) v->array() *= part.unit.array();
        for (int k = 0; k < part.rank; ++k) {
            const auto direction = part.basis.col(k);
            part.end += direction.dot(k < part.rigid_rank ? part.step : part.half_way) * direction;
        }
        part.end.array() /= part.unit.array();
        for (size_t k = 0; k < part.group.frames.size(); ++k)
            for (int half : {0, 1})
                if (has_none(part.group.frames[k], half))
                    residuals[part.group.frames[k]].step.segment<3>(3 * half) =
                        part.end.segment<3>(as_row(6 * k) + 3 * half);
    }
}

}  // namespace dttmm::plugin
