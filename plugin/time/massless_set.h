// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "core/index.h"
#include "mechanism/mechanism.h"

namespace dttmm::plugin {

/// A unit force on massless frames: a direction of a joint.
struct MasslessRow {
    size_t joint;
    int direction;
    size_t index;  ///< of a rigid one among those of all joints
};

/// Massless frames that joints of a kind join.
struct MasslessGroup {
    std::vector<size_t> frames;              ///< indices into MasslessSet::frames()
    std::vector<size_t> joints;              ///< of its frames
    std::vector<MasslessRow> rigid, damped;  ///< of these; damped: where they have no ratio in common
    double relaxation = 0;                   ///< that ratio of damping to stiffness [s]
};

/// A group of every massless frame, and its first unknown there, 6 each.
struct MasslessGroups {
    std::vector<MasslessGroup> all;
    std::vector<int> of, begin;
};

/// Which of the frames inside a network have no mass or no inertia, and what joins them.
class MasslessSet {
public:
    /// massless: translation and rotation of every inner frame.
    MasslessSet(const Mechanism& mechanism, const std::vector<std::array<bool, 2>>& massless);

    /// Inner frames with a massless half, in the order of every list of them.
    const std::vector<size_t>& frames() const { return frames_; }
    /// Of an inner frame; −1: it has none.
    int index_of(size_t frame) const { return index_[frame]; }
    /// Of a frame of the mechanism; −1: it is driven, or has none.
    int index_of(const Mechanism& mechanism, int frame) const {
        const int inner = frame - mechanism.assembly.driven_count;
        return inner < 0 ? -1 : index_[as_size(inner)];
    }
    bool is_massless(size_t frame, int half) const { return index_[frame] >= 0 && has_none(as_size(index_[frame]), half); }
    /// The same, by index in frames().
    bool has_none(size_t i, int half) const { return massless_[i][as_size(half)]; }
    /// Of a joint, its first rigid direction among those of all.
    size_t rigid_begin(size_t joint) const { return rigid_begin_[joint]; }

    /// The frames that joints with joins(joint) join.
    template <class Joins>
    MasslessGroups group(const Mechanism& mechanism, const Joins& joins) const {
        std::vector<std::array<int, 2>> pairs;
        for (const Joint& joint : mechanism.joints)
            if (joins(joint)) pairs.push_back({index_of(mechanism, joint.from()), index_of(mechanism, joint.to())});
        return group_by(mechanism, pairs);
    }

private:
    MasslessGroups group_by(const Mechanism& mechanism, const std::vector<std::array<int, 2>>& pairs) const;
    void find_joints(const Mechanism& mechanism, MasslessGroups& groups) const;
    void find_rows(const Mechanism& mechanism, MasslessGroup& group) const;

    std::vector<size_t> frames_;
    std::vector<int> index_;
    std::vector<std::array<bool, 2>> massless_;
    std::vector<size_t> rigid_begin_;
};

}  // namespace dttmm::plugin
