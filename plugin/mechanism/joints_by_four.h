// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "mechanism/mechanism.h"
#include "mechanism/port_bodies.h"

namespace dttmm::plugin {

/// Joints without rigid directions worked out four at a time: what a long chain, or a machine on many bolts, spends its
/// steps on. The formulas are those of a single Joint; only rounding differs, where sums run in another order or a four has
/// mixed seats. Holds copies of what of the joints never changes.
class JointsByFour {
public:
    JointsByFour() = default;
    /// joints: those that may be taken. Four go together that carry moments alike and keep rates alike.
    JointsByFour(const Mechanism& mechanism, std::span<const size_t> joints);

    /// Number of joints taken.
    size_t size() const { return Lanes::kCount * fours_.size(); }
    /// Those of the joints that were left over, ascending.
    const std::vector<size_t>& others() const { return others_; }
    /// All joints of so many that it does not take, ascending.
    std::vector<size_t> not_taken(size_t count) const;

    /// Adds their forces over the open step, when it ends with the frames at `trial`, to the wrenches on all frames; returns
    /// the largest one's square [N²].
    double add_forces(const Mechanism& mechanism, const std::vector<Frame>& trial, std::vector<Vector6>& wrench) const;
    /// The same forces when the step does end there; the joints' memory moves on. mechanism.frames: still at t_n.
    void advance(Mechanism& mechanism, const std::vector<Frame>& next, std::vector<Vector6>& wrench) const;
    /// Where all frames are ports or ground, the host has the trial, and takes the forces on its bodies.
    void add_forces(const PortBodies& ports, const dttmm_motion* trial, double* wrenches) const;
    /// Moves the joints' memory on; the host has had their forces. mechanism: that of the ports, its frames still at t_n.
    void advance(Mechanism& mechanism, const PortBodies& ports, const dttmm_motion* next) const;

    /// Adds their forces at t_{n−1} to the wrenches on all frames. rates: of the deformations then, [d; relative turn] of
    /// those joints that have dampers; takes the forces of all, [force; moment], joint axes.
    void add_forces_before(const Mechanism& mechanism, std::vector<Vector6>& rates, std::vector<Vector6>& wrench) const;
    /// Adds their mean forces over the step from there to t_n, where Newmark's rule has means of the elastic ones.
    void add_mean_forces(const Mechanism& mechanism, std::vector<Vector6>& wrench) const;

private:
    using Indices = uint32_t[Lanes::kCount];
    struct Four {
        JointPointOf<Lanes> point;
        Indices joint, from, to;  ///< from, to: frames
        Indices damper;           ///< their DamperStates
        uint32_t springs, axes;   ///< indices into those below
        bool keeps_rates;         ///< they have such
    };
    // frame(index): pointer to the numbers of a Frame; wrench(index): where to add to the wrench on it, NULL: nowhere.
    // wrench itself may be nullptr: forces are not added
    double add_forces_at(const Mechanism& mechanism, const auto& frame, const auto& wrench) const;
    void advance_at(Mechanism& mechanism, const auto& frame, const auto& wrench) const;
    void for_each_before(const Mechanism& mechanism, const auto& take) const;
    void take(const Mechanism& mechanism, std::span<const size_t> four);
    void take_springs(std::span<const Joint* const> four);
    void take_axes(std::span<const Joint* const> four);

    std::vector<Four> fours_;
    // Each four's that differ from those of the four before: few along a beam
    std::vector<SpringsOf<Lanes>> springs_;
    std::vector<JointAxesOf<Lanes>> axes_;
    std::vector<size_t> others_;
};

}  // namespace dttmm::plugin
