// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>
#include <vector>

#include "core/index.h"
#include "dttmm_plugin.h"
#include "mechanism/assembly.h"
#include "mechanism/frame.h"

namespace dttmm::plugin {

/// The wrenches of the loads of a network on its frames: a pure function of the places of the frames and of the values of
/// the loads at an instant. There is no time scheme in it. It allocates nothing after it is made.
///
/// Values, as dttmm_plugin.h has them: 6 per inner node, then 6 per line load, [q_from; q_to] in N/m. The middle of a
/// segment is at the share s of its line of n segments. A segment of length l takes, about its middle,
///     force l (q_from + s (q_to − q_from)),   moment e_x × (q_to − q_from) l²/(12 n),
/// the resultant of the linear force on it. The elements between the lumps carry it on to both ends of the line: force and
/// moment there are those of the whole load, deflections are exact to second order in 1/n.
class Loading {
public:
    Loading(const Assembly& assembly, const dttmm_network& description);

    /// Numbers in an array of values.
    size_t value_count() const { return value_count_; }
    /// Whether a load may act on a frame. A load on what does not move has no effect.
    bool is_on(int frame) const { return begin_[as_size(frame)] < begin_[as_size(frame) + 1]; }
    /// The wrench on a frame that is at `at`, about its origin, world axes.
    Vector6 wrench(int frame, FrameView at, const double* values) const;
    /// The symmetric part of −∂(wrench)/∂(pose), the wrench about a point `origin` that goes with the frame: what the loads
    /// do as their lever arms turn with it, or they themselves.
    Matrix6 stiffness(int frame, FrameView at, const Vector3& origin, const double* values) const;
    /// What that leaves out, and what the symmetric part of the stiffness of all that balances the loads does. By turns
    /// R ← exp([θ]×) R the second derivative of an energy has −½ [g]× beside a symmetric part, g its gradient, here the
    /// moment M of the loads, and [M]× v = M × v: exp([a]×) exp([θ]×) = exp([a + θ + ½ a × θ + …]×). Where the loads have a
    /// potential the two cancel out. Left over is
    ///     of a moment that keeps its direction:      −½ [M]× by turns;
    ///     of a force F and moment that turn along:   ½ [F]× of forces by turns and of moments by shifts, ½ [M]×.
    /// Without them each iteration multiplies motions across a moment at the end of a bar of length L by about
    /// M L/(2 √(EI GJ)): they grow from rounding.
    Matrix6 unsymmetric_stiffness(int frame, FrameView at, const double* values) const;
    /// Adds the wrenches on all frames, in the order of Assembly::frames.
    void add_wrenches(std::span<const Frame> frames, const double* values, std::span<Vector6> wrenches) const;

private:
    /// What one load does to one frame.
    struct Action {
        int frame;
        enum class Kind { at_node, on_segment, turns_with_segment } kind;
        size_t value;  ///< where its values begin
        Vector3 arm;   ///< from the frame's origin to the node, or to the middle of the segment; axes of the frame
        bool has_arm;
        double share;   ///< s
        double length;  ///< l [m]
        double couple;  ///< l²/(12 n) [m²]
    };
    /// A load on a frame: a force at the end of an arm from its origin, and a moment or, on a segment, a couple of forces
    /// `slope` and −slope whose arm is e_x. World axes.
    struct Acting {
        Vector3 force, arm, moment, slope;
    };
    static Acting acting(const Action& action, FrameView at, const double* values);

    std::vector<Action> actions_;  ///< by frame
    std::vector<size_t> begin_;    ///< of every frame among them, and one past the last
    size_t value_count_ = 0;
};

}  // namespace dttmm::plugin
