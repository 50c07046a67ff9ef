// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "solve/elimination.h"
#include "time/inside.h"
#include "time/slow_motion.h"

namespace dttmm::plugin {

/// How a network begins: where all its frames are, and their velocities.
class InnerStart {
public:
    /// The ports where they are, the inside where it is described with the velocities given to nodes, the rest such as to
    /// strain the network least. pattern: an elimination of what is inside. Keeps the inside.
    InnerStart(const Inside& inside, const Elimination& pattern, Ports ports);
    /// At rest, all frames where they are given.
    InnerStart(const Inside& inside, const std::vector<Frame>& frames);

    const std::vector<Frame>& frames() const { return frames_; }
    const Twist& velocity(int frame) const { return velocities_[as_size(frame)]; }
    /// Of the inner frames.
    std::span<const Twist> inner_velocities() const { return inside_.inner(velocities_); }

    /// Throws Error(DTTMM_ERROR_MODEL) naming a node whose given velocity rigid directions, or other nodes on its rigid
    /// body, have not left as it is.
    void refuse_forbidden_velocities() const;
    /// Gives massless frames between dampers the velocities at which these balance, unless they are given. h: the step [s],
    /// 0 where there is none yet.
    void balance(double h);
    /// What a joint does; without rigid directions.
    JointForce force(size_t joint) const;
    /// Sets momenta and motions of the step before the start, under the wrenches of the joints on all frames, and returns
    /// the accelerations of the inner frames then.
    std::vector<Twist> set_inertias(Inside& inside, std::span<const Vector6> wrenches) const;

private:
    std::vector<GivenVelocity> given_velocities() const;

    const Inside& inside_;
    std::vector<Frame> frames_;
    std::vector<Twist> velocities_;
};

}  // namespace dttmm::plugin
