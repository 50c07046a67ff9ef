// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "solve/elimination.h"
#include "time/inside.h"

namespace dttmm::plugin {

/// K + s C + s² M of what is inside a network, in the frames' axes, s a rate [1/s], with all frames where they are in `at`:
/// springs, dampers and masses under motions that grow like exp(s t). Forces that act already have no stiffness in it.
void form_dynamic_stiffness(const Inside& inside, const std::vector<Frame>& at, double rate, Elimination& matrix);

/// A node of which the velocity is given.
struct GivenVelocity {
    size_t inner;    ///< its frame among the inner ones
    Vector3 offset;  ///< of the node, axes of the frame [m]
    Vector6 value;   ///< of the node, axes of the frame
};

/// How the inside follows motions of its ports that last: by its springs; where there are none, by dampers; where there are
/// none of either, by masses. The equations are those of a motion at a small rate. What masses resist where dampers hold,
/// and both where springs do, is a proximal term: the next solution has it about the one before, so in the end it moves
/// nothing there. Velocities given to nodes are rows with multipliers. Rows may say the same as rigid directions do, so each
/// also has a stiffness, more than any frame's own.
/// Sources: Rockafellar (1976), Monotone operators and the proximal point algorithm, SIAM J. Control Optim. 14, 877–898;
/// Hestenes (1969), Multiplier and gradient methods, J. Optim. Theory Appl. 4, 303–320.
class SlowMotion {
public:
    /// With all frames where they are in `at`. pattern: an elimination of the same frames. Where a motion is resisted by
    /// nothing, inertias are made heavier. Throws Error(DTTMM_ERROR_SINGULAR) where that does not help. Keeps the inside and
    /// `at`.
    SlowMotion(const Inside& inside, const Elimination& pattern, const std::vector<Frame>& at,
               std::vector<GivenVelocity> given = {});

    /// motion: 6 per frame in its own axes, of the ports given; it takes that of the inner frames. q: takes the forces of
    /// rigid directions.
    void follow(std::span<Vector6> motion, std::span<double> q) const;
    /// −∂(wrench)/∂(pose of the ports), world: 6P × 6P row-major.
    void write_stiffness(double* stiffness) const;

private:
    /// Of a given velocity: v_node = G v, held by the stiffness `weight`.
    struct Row {
        Matrix6 G;
        Vector6 weight;
    };
    void make_heavier();
    void hold_given();
    void load_by_ports(std::span<const Vector6> motion, bool with_dampers, std::span<Vector6> load,
                       std::span<double> q) const;
    void add_resistance(std::span<const Vector6> motion, bool with_dampers, std::span<Vector6> load) const;
    void settle(bool by_springs, std::span<Vector6> motion, std::span<double> q) const;
    double largest(std::span<const Vector6> of_inner) const;

    const Inside& inside_;
    const std::vector<Frame>& at_;
    std::vector<GivenVelocity> given_;
    std::vector<Row> rows_;  ///< of these
    Elimination matrix_;
    std::vector<Vector6> heavier_;  ///< added to the inertias; empty: nothing
    struct AtPort {
        EndBlocks springs, dampers;
    };
    std::vector<AtPort> at_ports_;  ///< of Inside::port_joints: what couples the ports to the inside
};

}  // namespace dttmm::plugin
