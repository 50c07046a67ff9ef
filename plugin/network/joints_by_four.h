// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "network/mechanism.h"

namespace dttmm {

/// Joints worked out four at a time: what a long chain spends its steps on. The formulas are those of a single Joint; sums
/// may round otherwise. Without rigid directions.
class JointsByFour {
public:
    JointsByFour() = default;
    /// joints: those that may be taken. Four go together that carry moments alike and are damped alike.
    JointsByFour(const Mechanism& mechanism, std::span<const size_t> joints);

    size_t size() const { return Lanes::kCount * fours_.size(); }
    /// Those of the joints that were left over, in their order.
    const std::vector<size_t>& others() const { return others_; }

    /// Adds their forces over the open step, when it ends with the frames at `trial`, to the wrenches on all frames; returns
    /// the largest one's square [N²].
    double add_forces(const Mechanism& mechanism, const std::vector<Frame>& trial, std::vector<Vector6>& wrench) const;
    /// The same forces when the step does end there; the joints' memory moves on.
    void advance(Mechanism& mechanism, const std::vector<Frame>& next, std::vector<Vector6>& wrench) const;

private:
    struct Four {
        size_t joint[Lanes::kCount];
        size_t from[Lanes::kCount], to[Lanes::kCount];  ///< frames
        bool is_damped;                                 ///< rates count
        SpringsOf<Lanes> springs;
        JointSeatOf<Lanes> seat;
    };
    std::vector<Four> fours_;
    std::vector<size_t> others_;
};

/// Frames that go on by u over a step h, [v; ω] in their axes at its start, to frames `to`; from, u and to are as many.
void move_frames(double h, std::span<const Frame> from, std::span<const Vector6> u, std::span<Frame> to);

}  // namespace dttmm
