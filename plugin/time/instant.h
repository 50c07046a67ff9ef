// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mechanism/joints_by_four.h"
#include "mechanism/port_bodies.h"
#include "time/interior.h"

namespace dttmm::plugin {

/// What stands in a network at t_n, the start of the step last committed: velocities, forces of the joints in their axes and
/// wrenches on the frames at their origins, world.
class Instant {
public:
    /// interior: NULL: nothing moves inside; by_four: joints worked out four at a time. Keeps all three.
    Instant(const PortBodies& bodies, Interior* interior, const JointsByFour& by_four);

    /// The mean wrenches over the step; velocities inside go with them.
    void find_mean_wrenches();
    /// By the velocities that the ports have at the instant. accelerations: of the bodies, NULL: not known.
    void find(const dttmm_motion* motions, const double* accelerations);
    /// For a host that does not say how the ports move then. earlier_frames: the ports at t_{n−1}; start: their velocities
    /// at the start of the run.
    void find_by_centred_velocities(const std::vector<Frame>& earlier_frames, const std::vector<Twist>& start);
    /// From now on rates of deformations are those of their increments, but in the first row, which has the initial
    /// velocities. For all networks of a machine that has rigid directions in one of them, or mean velocities of bodies.
    void take_rates_by_increments() { has_rates_by_increments_ = true; }
    bool is_known() const { return is_known_; }
    void forget() { is_known_ = false; }

    void add_wrenches(double* wrench) const;
    /// What of the mean wrenches stems from rigid directions.
    void add_rigid_wrenches(double* wrench) const;
    /// What makes the mean wrenches those of dampers in the mean of the axes at both ends of the step: they act in those at
    /// its start, where velocities are found.
    void add_turned_dampers(double* wrench) const;

    const Vector6& force(size_t joint) const { return forces_[joint]; }
    const Vector6& wrench(int frame) const { return wrenches_[as_size(frame)]; }

private:
    Twist velocity(int frame) const;
    JointPose pose(size_t joint) const;
    Vector6 rate_over_step(size_t joint) const;
    Vector6 deformation_rate(size_t joint, const JointPose& pose) const;
    void add_wrench(size_t joint, const JointForce& force);
    void find_forces();
    void find_by_port_velocities();

    PortBodies bodies_;
    const Mechanism& mechanism_;
    Interior* interior_;
    const JointsByFour& by_four_;
    std::vector<size_t> others_, damped_by_four_;  ///< joints that do not go by four; those with dampers that do
    bool has_rates_by_increments_;
    std::vector<Twist> port_velocities_;
    std::vector<Vector6> forces_, wrenches_;
    bool is_known_ = false;
    bool by_increments_ = false;  ///< the host has not said how the ports move then
};

}  // namespace dttmm::plugin
