// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "core/index.h"
#include "dttmm_modal.h"
#include "law/viscoelastic.h"
#include "mechanism/assembly.h"
#include "modal/line_waves.h"
#include "statics/at_rest.h"

namespace dttmm::plugin {

/// Small motions of all frames [m, rad], or forces on them [N, N m]: 6 per frame, at its origin, world axes.
using FrameVector = std::vector<Vector6>;

/// φᵀ f over all frames.
double dot(const FrameVector& a, const FrameVector& b);

/// Both halves of a motion turned by R.
Matrix6 both(const Matrix3& R);

/// A rigid direction: by_from · u_from + by_to · u_to + by_ground · g = 0, g the motion of its end on the ground about the
/// world's origin.
struct Rigid {
    Vector6 by_from, by_to, by_ground = Vector6::Zero();
    int number = 0;  ///< among those of what it joins, before any is struck out
};

/// What joins two frames (−1: the ground), by the displacements of its two ends.
struct Joined {
    int element, from, to;
    /// Displacement of each end by the motion of its frame, in axes of its own; on the ground by a motion of the ground
    /// about the world's origin.
    Matrix6 by_from, by_to;
    std::vector<Rigid> rigid;

    /// [displacement at `from`; at `to`] by a motion of the frames and of the ground.
    Vector12 ends(const FrameVector& u, const Vector6& ground = Vector6::Zero()) const;
    /// Adds forces on its ends to those on the frames; those on the ground are the result.
    Vector6 add(const Vector12& forces, FrameVector& on_frames) const;
    /// Adds a rigid direction unless it follows from those it has; what it says of the ground goes to by_ground.
    void hold(Vector6 by_from, Vector6 by_to);
};

/// Constant stiffness and damping of the relative displacement, world axes.
struct Bond : Joined {
    Vector3 points[2];           ///< of its ends; one, but for a joint along a line
    Matrix6 stiffness, damping;  ///< world axes
    Matrix6 axes;                ///< its own, as columns in world
    Vector6 springs;             ///< stiffness in these
    /// Of a machine at rest: what the forces of the joint add as they turn with its frames, by the motion of these; null:
    /// none.
    std::shared_ptr<const EndBlocks> turning;
    /// Of a machine at rest: how its force there changes in its own axes by the relative motion; its rotation there [rad].
    Matrix6 spread = Matrix6::Zero();
    Vector3 turned = Vector3::Zero();
    double loss_factor = 0;  ///< of its stiffness
    /// Directions whose stiffness depends on the frequency; in `stiffness` they have that at rest.
    struct Material {
        int direction;  ///< of its axes
        std::shared_ptr<const Viscoelastic> law;
    };
    std::vector<Material> materials;
    int held_node = -1;         ///< node of the network that it holds in some directions
    double tension = 0;         ///< of a joint along a line at the start [N]: along its x from `from` to `to`
    std::vector<Vector6> held;  ///< directions that do not give, world axes

    /// Adds the forces of `turning` to those on the frames.
    void add_turning(const FrameVector& u, FrameVector& on_frames) const;
    /// uᵀ K u of it.
    double turning_energy(const FrameVector& u) const;
    /// Of its terms, each with its size: what rounding is a share of.
    double turning_size(const FrameVector& u) const;
};

/// A rod that lies straight between pins at its ends: its mass across itself is that of a bar, [1/3 1/6; 1/6 1/3] m.
struct Pin : Joined {
    Matrix6 mass;  ///< m in the pinned directions, local axes [kg]
};

/// An element with waves from frame to frame (−1: the ground), or a segment of one; those of an element follow each other.
struct LineModel {
    int element, from, to;
    Vector3 start, finish;  ///< its ends at the start [m, world]
    Matrix3 axes;           ///< of it, as columns in world
    Line line;
    size_t kind;  ///< lines alike share their waves
    const LineWaves* waves;
    int deviation = -1;  ///< the bond that has what its other forces at rest do; −1: none counts
    double length() const { return (finish - start).norm(); }
};

/// A machine in small vibrations about its start, as data: frames (bodies of the host, then masses and nodes of the network)
/// that bonds and lines join. Directions that the model leaves out do not move, neither in joints nor along lines.
struct FrequencyModel {
    /// See FrequencyAssembly. rest: of the elements of model.rest; else null. Throws Error naming body or element: what
    /// assemble() refuses, numbers of a body that are not finite or a mass that is not positive, lines at an angle to the
    /// directions left, a stiffness of a section that is needed and not given, nothing that moves.
    explicit FrequencyModel(const dttmm_modal_model& model, const AtRest* rest = nullptr);

    struct Frame {
        Vector3 position;  ///< of its origin at the start [m, world]: a mass: its centre, in a reduced state its first node
        std::string name;  ///< for messages
        int element;       ///< one that hangs on it; −1: none
    };
    struct Node {
        int frame;         ///< that it goes with; −1: the ground
        Vector3 position;  ///< at the start [m, world]
    };
    struct Mass {
        int frame;
        Matrix6 block;  ///< [kg, kg m², kg m] by the motion of the frame
    };
    /// What forces that act at the start add to the stiffness as they turn with a frame. See geometric_stiffness.h.
    struct Lever {
        int element, frame;
        Matrix6 stiffness;    ///< by the motion of the frame, symmetric
        bool is_bar = false;  ///< of the forces along a rod that the frame turns
    };

    /// Nodes of the network that an element joins first and second; of a mass the one that it sits on, twice.
    struct EndNodes {
        int from, to;
    };

    Directions directions;
    Matrix6 mask;  ///< 1 in these
    size_t element_count;
    std::vector<Frame> frames;
    std::vector<Vector3> centres;  ///< of mass, of the bodies
    std::vector<Node> nodes;       ///< of the network
    std::vector<uint32_t> fixed;   ///< directions in which each of them is held, as bits
    std::vector<Mass> masses;
    std::vector<Bond> bonds;
    std::vector<std::unique_ptr<LineWaves>> kinds;
    std::vector<LineModel> lines;
    std::vector<Pin> pins;
    std::vector<EndNodes> ends;    ///< of every element
    std::vector<bool> are_axial;   ///< elements that carry a force along the line between their ends and nothing else
    std::vector<int> constraints;  ///< the bond of each; −1: it holds nothing
    std::vector<Lever> levers;
    double total_mass = 0;  ///< [kg]
    bool is_at_rest = false;
    /// A line at rest: how far it is bent, as share of its radius of gyration, and whether it is therefore lumps.
    struct RestingLine {
        double share = 0;
        bool is_lumped = false;
        /// Where its segments meet, both ends included: places [m], and [force; moment] on what follows less, world axes.
        std::vector<Vector3> points;
        std::vector<Vector6> forces;
        std::array<Vector3, 2> ends;            ///< where the sections at its start and end look, world
        std::vector<Matrix3> axes_of_segments;  ///< as columns in world
        Vector6 at_from = Vector6::Zero();      ///< the same at its `from` end, in the axes of that end
        Matrix3 axes = Matrix3::Identity();     ///< these, as columns in world
        Vector3 turned = Vector3::Zero();       ///< rotation of its `to` end in them [rad]
        /// Of the loads along it, their sums over a length like that at its start and at its end [N]: of those that turn
        /// with it, in its axes, and of the others, world axes.
        Vector6 turning = Vector6::Zero(), steady = Vector6::Zero();
    };
    std::vector<RestingLine> resting;  ///< of every element of a machine at rest

    /// Something stores energy: an element, or forces at rest that turn with what they act on.
    bool is_elastic() const;
    /// What forces at rest add to the stiffness of a frame against turning, over its inertia about the joints that it hangs
    /// on: the largest of all frames [1/s²]. 0: none.
    double stiffest_turning() const;
    /// The largest stiffness of joints against turning over the inertia of all masses about one of them [1/s²]; 0: none.
    double stiffest_hinge() const;
    /// Of a frame: the stiffness of its joints against turning over its inertia, the largest [1/s²]; 0: none.
    double stiffest_rotor() const;
    double turning_stiffness(const Bond& bond) const;  ///< the largest about an axis [N m/rad]
    /// Of joints: what their stiffness against turning makes of the rotation of both their frames, not of the difference,
    /// for a motion of amplitude u: twice an energy [J].
    double turning_of_springs(const FrameVector& u) const;
    /// Force of an element at the start whose stiffness is in the model [N], positive in tension; 0: none.
    double force_at_start(size_t element) const;
    /// Displacement at a point by the motion of a frame with that origin, world axes.
    static Matrix6 at_point(const Vector3& point, const Vector3& origin);
    /// The same in directions that the model leaves.
    Matrix6 masked_at(const Vector3& point, const Vector3& origin) const { return mask * at_point(point, origin) * mask; }
    const std::string& name(int frame) const { return frames[as_size(frame)].name; }
    Vector3 origin(int frame) const { return frame < 0 ? Vector3(Vector3::Zero()) : frames[as_size(frame)].position; }
    Matrix6 by_centre(int body) const;   ///< of a body's centre of mass by the motion of its frame
    Matrix6 by_node(size_t node) const;  ///< by the motion of its frame, which there is
    Vector6 node_motion(size_t node, const FrameVector& u) const;
    /// Whether a line is a bar that its frames turn: a rod where no direction is left out.
    bool is_bar(const LineModel& line) const { return line.line.stretches_only && directions.all(); }
};

/// Mass of a rod of a length [m] as a rigid body but for its axis x, about its middle, local axes: by [velocity; angular
/// velocity]. Without an inertia of its own it has none about x, as in time.
Matrix6 bar_mass(const Section& section, double length);

}  // namespace dttmm::plugin
