// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mechanism/joints_by_four.h"
#include "mechanism/port_bodies.h"
#include "time/port_blocks.h"

namespace dttmm::plugin {

/// A network of joints between bodies and ground, side by side: nothing moves between them, so the host's trial says all.
class BodyJoints {
public:
    /// Keeps all; the mechanism of the bodies is the same, the blocks are those of its joints.
    BodyJoints(Mechanism& mechanism, const PortBodies& bodies, const PortBlocks& blocks);

    /// See Network.
    void linearise(const dttmm_motion* motions, double* wrench, double* stiffness, double* damping) const;
    void start(const dttmm_motion* motions, const double* accelerations);
    void evaluate(const dttmm_motion* motions, double* wrench, double* stiffness) const;
    /// By how much laws do otherwise at this trial than their gains at the trial before let expect, as share of their force.
    /// Newton's corrections are trusted where that is little: a kink between two trials makes another force of the last one.
    double find_worst_prediction(const dttmm_motion* motions);
    /// earlier: takes the frames at t_{n−1} as they were.
    void commit(const dttmm_motion* motions, std::vector<Frame>& earlier);
    const JointsByFour& by_four() const { return by_four_; }

private:
    void evaluate_singles(const dttmm_motion* motions, double* wrench) const;
    void add_stiffness_of_linear(const dttmm_motion* motions, double* stiffness) const;
    void evaluate_with_laws(const dttmm_motion* motions, double* wrench, double* stiffness) const;
    void add_stiffness(size_t joint, Ends at, double* stiffness) const;

    Mechanism& mechanism_;
    PortBodies bodies_;
    const PortBlocks& blocks_;
    std::vector<size_t> linear_, with_laws_;
    JointsByFour by_four_;  ///< the linear ones, but for the others that it leaves
    /// A direction with a law at the trial last looked at: its deformation, force over the step and gain.
    struct LawLook {
        size_t joint;
        int direction;
        double x, force, gain;
    };
    std::vector<LawLook> law_looks_;
};

}  // namespace dttmm::plugin
