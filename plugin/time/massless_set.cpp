// SPDX-License-Identifier: BSD-3-Clause
#include "time/massless_set.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/rounding.h"

namespace dttmm::plugin {

MasslessSet::MasslessSet(const Mechanism& mechanism, const std::vector<std::array<bool, 2>>& massless)
    : index_(massless.size(), -1) {
    for (size_t i = 0; i < massless.size(); ++i) {
        if (!massless[i][0] && !massless[i][1]) continue;
        index_[i] = as_int(frames_.size());
        frames_.push_back(i);
        massless_.push_back(massless[i]);
    }
    size_t rigid_count = 0;
    for (const Joint& joint : mechanism.joints) {
        rigid_begin_.push_back(rigid_count);
        rigid_count += joint.rigid().count();
    }
}

/// By union and find.
MasslessGroups MasslessSet::group_by(const Mechanism& mechanism, const std::vector<std::array<int, 2>>& pairs) const {
    MasslessGroups groups;
    std::vector<int> root(frames_.size());
    std::iota(root.begin(), root.end(), 0);
    const auto find = [&](int i) {
        while (root[as_size(i)] != i) i = root[as_size(i)];
        return i;
    };
    for (const auto& [a, b] : pairs)
        if (a >= 0 && b >= 0) root[as_size(find(a))] = find(b);
    groups.of.assign(frames_.size(), -1);
    groups.begin.assign(frames_.size(), 0);
    for (int i = 0; i < as_int(frames_.size()); ++i) {
        int& group = groups.of[as_size(find(i))];
        if (group < 0) {
            group = as_int(groups.all.size());
            groups.all.emplace_back();
        }
        groups.of[as_size(i)] = group;
        MasslessGroup& own = groups.all[as_size(group)];
        groups.begin[as_size(i)] = 6 * as_int(own.frames.size());
        own.frames.push_back(as_size(i));
    }
    find_joints(mechanism, groups);
    for (MasslessGroup& group : groups.all) find_rows(mechanism, group);
    return groups;
}

/// The joints of the frames of every group.
void MasslessSet::find_joints(const Mechanism& mechanism, MasslessGroups& groups) const {
    for (size_t j = 0; j < mechanism.joints.size(); ++j)
        for (int frame : {mechanism.joints[j].from(), mechanism.joints[j].to()}) {
            const int i = index_of(mechanism, frame);
            if (i < 0) continue;
            std::vector<size_t>& list = groups.all[as_size(groups.of[as_size(i)])].joints;
            if (list.empty() || list.back() != j) list.push_back(j);
        }
}

/// Rigid directions at the frames of a group, and its common ratio of damping to stiffness or else its damped directions.
void MasslessSet::find_rows(const Mechanism& mechanism, MasslessGroup& group) const {
    double lowest = INFINITY, highest = 0;
    for (size_t j : group.joints) {
        const Joint& joint = mechanism.joints[j];
        size_t index = rigid_begin_[j];
        for (int d = 0; d < 6; ++d) {
            const JointHalf& half = d < 3 ? joint.translation_half() : joint.rotation_half();
            const double k = half.stiffness(d % 3), c = half.damping(d % 3);
            if (joint.rigid()[as_size(d)]) {
                group.rigid.push_back({j, d, index++});
            } else if (k > 0 || c > 0) {
                lowest = std::min(lowest, c / k);
                highest = std::max(highest, c / k);
                if (c > 0) group.damped.push_back({j, d, 0});
            }
        }
    }
    // Where something is rigid, directions that turn against each other take part in one balance: ψ is not the load's alone
    if (group.rigid.empty() && std::isfinite(highest) && highest - lowest <= kRoundingOfSums * highest) {
        group.relaxation = highest;
        group.damped.clear();
    }
}

}  // namespace dttmm::plugin
