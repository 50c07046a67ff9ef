// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "dttmm_static.h"
#include "mechanism/loading.h"
#include "mechanism/mechanism.h"
#include "solve/elimination.h"
#include "statics/at_rest.h"
#include "statics/hanging_frames.h"
#include "statics/loads_without_potential.h"
#include "statics/network_size.h"
#include "statics/resting_joint.h"

namespace dttmm::plugin {

/// What is inside a network at rest under lasting loads, for given poses of its ports. The equations are
///     f(x) + weight + loads − Jᵀ q = 0,     C(x) = 0,
/// f the elastic forces of the joints, C and J the deformations in their rigid directions and the derivatives of these, q
/// the forces there. Newton's iteration: the host corrects the ports by the condensed equations, the inside follows by
/// substitution, so that the two together are one Newton iteration for all frames. The matrix is the derivative at the
/// place at hand, what stems from forces that turn with their joints included. Motions are those of the frames' origins and
/// small turns, world axes. A law of a joint goes the straight way from the undeformed state to where it is.
///
/// The stiffness of forces that turn is that of the forces that the last correction led to expect, not of those that it
/// found: a slender part that turns is stretched by a linear correction, and the pull of that would hide what the bending
/// is about. Frames that hang on others as a tree go where the deformations of their joints lead. Source: Magisano, Leonetti
/// and Garcea (2017), How to improve efficiency and robustness of the Newton method in geometrically non-linear structural
/// problem, Comput. Methods Appl. Mech. Engrg. 313, 986-1005.
///
/// A small resistance s M against every correction (a proximal term: it slows the iteration down, and moves nothing once
/// forces balance) keeps motions determined that nothing holds. Where nothing has a mass it is a share of the stiffness that
/// holds a frame.
class StaticNetwork {
public:
    /// lent: a matrix of the frames inside, to work in; null: of its own.
    StaticNetwork(const Mechanism& mechanism, Loading loading, Elimination* lent = nullptr);
    StaticNetwork(const StaticNetwork&) = delete;  // joints_ refer to its frames
    StaticNetwork& operator=(const StaticNetwork&) = delete;

    /// Back to the places of the assembled machine.
    void begin();
    /// Throws Error(DTTMM_ERROR_NUMERIC) where a rotational stiffness has turned too far, by less than half a turn from the
    /// place kept before.
    void refuse_large_rotations() const;
    /// Keeps where everything is; goes back there.
    void keep() { kept_ = now_; }
    void recall();
    /// loads: values as Loading has them; NULL: none.
    void set_loads(const Vector3& gravity, const double* loads);
    /// Forms the equations where the frames are, the ports as given. resistance: s [1/s²]. Throws
    /// Error(DTTMM_ERROR_SINGULAR) naming what nothing determines.
    void form(Ports ports, double resistance);
    /// Adds the condensed equations: the wrench on the ports, 6 each, and minus its derivative, row-major over all ports.
    /// For networks with something inside.
    void condense(std::span<Vector6> wrench, double* stiffness);

    /// Without anything inside: the wrench on a port, and what every joint at a port adds to the stiffness, function(joint,
    /// blocks).
    const Vector6& formed_wrench(int port) const { return base_residual_.wrenches[as_size(port)]; }
    template <class Function>
    void for_each_at_ports(const Function& function) const {
        for (size_t k = 0; k < at_ports_.joints.size(); ++k) function(at_ports_.joints[k], at_ports_.blocks[k]);
    }

    /// As dttmm_static.h has it; its element is one of the description.
    using Measure = dttmm_static_measure;
    /// Finds the correction of the inside to one of the ports; the frames stay.
    Measure correct(std::span<const Vector6> port_change);
    /// Takes a share of it from where the equations were formed, with the ports where they are given.
    Measure move(Ports ports, double share);

    /// On a port where everything is.
    const Vector6& wrench(int port) const { return residual_.wrenches[as_size(port)]; }
    /// Where everything is.
    const std::vector<Frame>& frames() const { return now_.frames; }
    /// Forces in the rigid directions of a joint, by its directions.
    Vector6 rigid_force(size_t joint) const;
    AtRest::Link link(size_t joint) const;
    /// 6 per inner node, as set.
    const std::vector<double>& loads() const { return acting_.loads; }
    const Vector3& gravity() const { return acting_.gravity; }

private:
    bool is_inner(int frame) const { return frame >= driven_; }
    size_t at(int frame) const { return as_size(frame - driven_); }
    Ends ends(const Joint& joint) const { return {now_.frames[as_size(joint.from())], now_.frames[as_size(joint.to())]}; }
    Vector6 motion_of(int frame) const;
    void take_ports(Ports ports);
    void place_joints();
    void predict_forces(double share);
    void move_frames(Ports ports, double share);
    void solve() { unsymmetric_.solve(matrix_, correction_.u, correction_.q); }
    void add_joint(size_t joint);
    Matrix6 resistance_of(int frame) const;
    void find_residuals();
    Measure measure() const;
    double largest_turn() const;
    void add_port_motion(std::span<const Vector6> motion);

    const Mechanism& mechanism_;
    int ports_, driven_, count_;
    /// Loads on the inside.
    struct Acting {
        Loading loading;
        Vector3 gravity = Vector3::Zero();
        std::vector<double> loads;
    };
    Acting acting_;
    NetworkSize size_;

    /// All frames, and the forces of rigid directions.
    struct Place {
        std::vector<Frame> frames;
        std::vector<double> q;
    };
    Place now_, base_, kept_;  ///< base_: where the equations were formed; kept_: where to go back to
    std::optional<Elimination> own_;
    Elimination& matrix_;
    LoadsWithoutPotential unsymmetric_;
    HangingFrames hanging_;
    bool is_massless_;  ///< frames and ports
    /// A joint where its frames are now.
    struct Resting {
        PlacedJoint placed;
        RestingForce force;
    };
    std::vector<Resting> joints_;     ///< empty: not placed yet
    std::vector<Vector6> predicted_;  ///< forces along the deformations, of every joint; empty: those that act
    bool has_moved_ = false;          ///< since the equations were formed
    struct AtPorts {
        std::vector<size_t> joints;
        std::vector<EndBlocks> blocks;  ///< of these
    };
    AtPorts at_ports_;
    struct Residual {
        std::vector<Vector6> wrenches;  ///< on all frames, world, at their origins
        std::vector<double> openings;   ///< C
        double force = 0;               ///< the largest of a joint or a load [N]
        double noise = 0;               ///< what of a force may be rounding of places [N]
    };
    Residual residual_, base_residual_;
    struct Correction {
        std::vector<Vector6> u;         ///< of the inner frames
        std::vector<Vector6> of_ports;  ///< that it goes with
        std::vector<double> q;
    };
    Correction correction_;
    double resistance_ = 0;
};

}  // namespace dttmm::plugin
