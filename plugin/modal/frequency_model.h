// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/SparseCore>
#include <complex>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/index.h"
#include "dttmm_modal.h"
#include "mechanism/assembly.h"
#include "modal/line_waves.h"
#include "solve/elimination.h"

namespace dttmm::plugin {

/// A machine in small vibrations about its start: frames (bodies of the host, masses and nodes of the network, points along
/// the lines) that joints and lines join. Its dynamic stiffness at λ = ω²,
///     D(λ) = K − λ M + Σ lines,     J u = 0 in rigid directions,
/// is factored by the elimination of the time solver, from the tips inwards (Riccati's form of the transfer equations),
/// which also counts the negative eigenvalues. As lines are cut into pieces that do not vibrate with their ends held, that
/// is the number of natural frequencies below ω, each with its multiplicity. Source: Wittrick and Williams (1971), Q. J.
/// Mech. Appl. Math. 24, 263–284, with J0 = 0.
///
/// Motions are 6 per frame: of its origin (a mass: its centre, in a reduced state its first node), world axes. Directions
/// that the model does not leave are zero and what would happen in them is not looked at, neither in joints nor along lines.
class FrequencyModel {
public:
    using Motion = std::vector<Vector6>;
    using Frequency = std::complex<double>;

    /// Throws Error naming body or element: what assemble() refuses, numbers of a body that are not finite or a mass that is
    /// not positive, lines at an angle to the directions left, a stiffness of a section that is needed and not given,
    /// nothing that moves.
    explicit FrequencyModel(const dttmm_modal_model& model);

    /// Cuts the lines so that frequencies below ω [rad/s] can be counted; comes before all that follows. Throws Error naming
    /// the element that would take too many pieces, or what nothing holds and has no mass.
    void cut(double omega);
    /// So often they were cut otherwise than before: motions of one count are of the same frames.
    int cuts() const { return cuts_; }

    /// Sets D(λ), λ = ω² [1/s²], and factors it; the number of natural frequencies below ω. Nothing: λ belongs to one of
    /// them, to rounding. Without −∂D/∂λ it is quicker, and only counts.
    std::optional<int> factor(double lambda, bool with_mass = true);

    // At the λ last set:
    /// D⁻¹ r on the motions that rigid directions allow.
    void solve(Motion& r) const;
    /// −∂D/∂λ u, and D u with the forces of rigid directions left out.
    Motion mass_times(const Motion& u) const;
    Motion stiffness_times(const Motion& u) const;

    /// Largest stiffness [N/m] and total mass [kg]: what rounding makes of a rigid-body mode.
    double largest_stiffness() const;
    double total_mass() const { return total_mass_; }
    /// All moves as a whole in direction d about the world's origin, the ground too: the motion of the frames, the forces D
    /// r and the momenta −∂D/∂λ r on them, and twice the kinetic energy, that of clamped lines included. See dttmm_mode.
    struct Whole {
        Motion motion, forces, momenta;
        double mass;  ///< [kg, kg m²]
    };
    Whole move_whole(int direction) const;
    bool is_elastic() const;
    /// Force of an element at the start whose stiffness is in D [N]; 0: none.
    double force_at_start(size_t element) const;
    bool has_start_forces() const { return !start_forces_.empty(); }
    /// Throws Error(DTTMM_ERROR_MODEL) if motions grow faster than λ < 0 allows [1/s²].
    void refuse_growing(double lambda);
    bool has_lines() const { return !lines_.empty(); }
    /// ω² of a motion by its strain and kinetic energy, as far as the elements tell them, and what of it may be rounding
    /// [1/s²].
    struct Quotient {
        double lambda, unsure;
    };
    Quotient strain_quotient(const Motion& u) const;
    int frame_count() const { return as_int(positions_.size()); }
    int body_count() const { return body_count_; }
    Directions directions() const { return directions_; }

    /// Displacement of a node of the network [6, world] that goes with its frame.
    Vector6 node_motion(size_t node, const Motion& u) const;
    Matrix6 by_centre(int body) const;   ///< displacement of a body's centre of mass by the motion of its frame
    Matrix6 by_node(size_t node) const;  ///< by the motion of its frame, which there is
    size_t node_count() const { return assembly_.nodes.size(); }
    /// Strain energy of every element for a motion of amplitude u, and what of it may be rounding [J].
    struct Strain {
        double energy = 0, unsure = 0;
    };
    std::vector<Strain> strain_energies(const Motion& u, size_t elements) const;
    /// Displacement along an element at stations, ends included; its length, 0 if it is no line.
    double along(size_t element, const Motion& u, size_t count, double* shape) const;
    /// Points of the machine and how they move [6, world]: centres of mass of the bodies, nodes, stations along the lines.
    /// The points do not depend on the order in which the model lists its parts.
    struct Station {
        Vector3 position;  ///< at the start [m, world]
        Vector6 motion;
    };
    std::vector<Station> stations(const Motion& u) const;
    /// Largest displacement [m] and rotation [rad] of frames and nodes, and of stations along the lines.
    std::pair<double, double> largest(const Motion& u) const;

    /// Motion [m, rad] under a harmonic wrench [N, N m] at a point [m, world] of a frame (−1: the ground, nothing moves),
    /// damped; 6 per frame. Throws Error(DTTMM_ERROR_SINGULAR) at a natural frequency without damping.
    std::vector<Eigen::Matrix<Frequency, 6, 1>> respond(double omega, int frame, const Vector3& point,
                                                        const Vector6& wrench) const;
    /// Frame that a node moves with; −1: the ground.
    int frame_of_node(size_t node) const { return frame_of_[as_size(assembly_.nodes[node].frame)]; }
    Vector3 position_of_node(size_t node) const;  ///< at the start [m, world]

    /// Displacement at a point by the motion of a frame, world axes.
    static Matrix6 at_point(const Vector3& point, const Vector3& origin);

    // The parts it is made of:
    /// A rigid direction: by_from · u_from + by_to · u_to = 0. Unlike a bond's, by_from holds its minus sign.
    struct Rigid {
        Vector6 by_from, by_to;
    };
    /// A coupling of two frames (−1: the ground) by constant stiffness and damping of their relative displacement.
    struct Bond {
        int element, from, to;
        Vector3 points[2];                                           ///< of its ends; one, but for a joint along a line
        Matrix6 by_from = Matrix6::Zero(), by_to = Matrix6::Zero();  ///< relative displacement = by_to u_to − by_from u_from
        Matrix6 stiffness, damping;                                  ///< world axes
        Matrix6 axes;                                                ///< its own, as columns in world
        Vector6 springs;                                             ///< stiffness in these
        std::vector<Rigid> rigid;
        std::vector<Vector6> held;  ///< directions that do not give, world axes
    };
    struct Mass {
        int frame;
        Matrix6 block;  ///< [kg, kg m², kg m] by the motion of the frame
    };
    /// What a force that acts at the start on a point of a frame adds to the stiffness as its lever arm turns.
    struct Lever {
        int element, frame;
        Matrix6 stiffness;  ///< symmetric part, by the motion of the frame
    };
    /// A piece that stands on the ground with an end or both.
    struct HeldPiece {
        size_t piece, line;
        Matrix6 start, finish;  ///< displacement of such an end in local axes if the ground moved; zero of the other
    };
    /// An element with waves from frame to frame (−1: the ground).
    struct LineModel {
        int element, from, to;
        Vector3 start, finish;  ///< its ends at the start [m, world]
        Matrix3 axes;           ///< of it, as columns in world
        const LineWaves* waves;
        Line line;
        size_t kind;  ///< lines alike share their waves
        int first_piece = 0, count = 0;
        double length() const { return (finish - start).norm(); }
    };
    /// A rod that lies straight between pins at its ends: its mass across itself as that of a bar, [1/3 1/6; 1/6 1/3] m.
    struct Pin {
        int from, to;            ///< frames; −1: the ground
        Matrix6 by_from, by_to;  ///< displacement of its ends in local axes
        Matrix6 mass;            ///< m in the pinned directions, local axes [kg]
        Matrix6 start, finish;   ///< displacement of an end on the ground if that moved; zero of the other
    };
    bool has_pins() const { return !pins_.empty(); }
    const std::vector<Bond>& bonds() const { return bonds_; }
    const std::vector<LineModel>& lines() const { return lines_; }
    const std::vector<Mass>& masses() const { return masses_; }
    const std::vector<Lever>& levers() const { return levers_; }
    int own_frame_count() const { return as_int(own_frames_); }  ///< without points along lines
    const Vector3& position(int frame) const { return positions_[as_size(frame)]; }
    const std::string& name(int frame) const { return names_[as_size(frame)]; }

private:
    /// A piece of a line between two frames.
    struct Piece {
        int from, to;
        Matrix6 by_from, by_to;  ///< displacement of its ends in local axes
        std::vector<Rigid> rigid;
    };
    class DynamicStiffness;
    /// K + iω C − ω² M, lines included, 6 rows per frame, and the rows of the rigid directions.
    Eigen::SparseMatrix<Frequency> dynamic_stiffness(double omega) const;
    void add_bodies(const dttmm_modal_model& model);
    void refer_to_inputs();
    void add_joint(int element, int from, int to, const JointLaw& law, const Pose& pose);
    /// A force that acts on a frame at the start: where from its origin [m], and what [N], world.
    struct StartForce {
        int frame;
        Vector3 arm, force;
    };
    void add_lever(int element, const StartForce& acting);
    void add_reactions();
    void add_force(const Bond& bond, const JointLaw& law, const Vector3& along, Vector6& stiffness);
    void add_line(const LineSpec& line);
    void add_rigid(std::vector<Rigid>& rows, const Rigid& row) const;
    Matrix6 masked(const Matrix6& by) const;
    Matrix6 local_end(const Matrix3& axes, const Vector3& point, int frame) const;
    void cut_line(LineModel& line, int count);
    void build();
    void set_matrices(double lambda, bool with_mass = true);
    static Vector6 relative(const Bond& bond, const Motion& u);
    static Vector12 ends_of(const Piece& piece, const Motion& u);
    void add_pins(double factor, const Motion& u, Motion& out) const;
    static void add_piece(const Piece& piece, const Matrix12& D, const Motion& u, Motion& out);
    [[noreturn]] void refuse(const Elimination::Fault& fault) const;
    std::vector<Rigid>& rigid_of(int link);
    bool is_redundant(int link, int i);
    template <class Body>
    void for_each_piece(const Body& body) const;

    Assembly assembly_;
    Directions directions_;
    Matrix6 mask_;
    int body_count_ = 0;
    double total_mass_ = 0;
    std::vector<int> frame_of_;       ///< of the assembly's frames
    std::vector<Vector3> positions_;  ///< of the frames
    std::vector<Vector3> centres_;    ///< of mass, of the bodies
    std::vector<std::string> names_;
    std::vector<int> elements_;  ///< one that hangs on each frame
    size_t own_frames_ = 0;      ///< without those along the lines
    std::vector<Mass> masses_, bar_masses_;
    std::vector<Lever> levers_;
    std::vector<std::pair<int, double>> start_forces_;  ///< by element
    std::vector<StartForce> acting_;
    bool has_reactions_ = false;  ///< those of rigid directions to them are among the levers
    std::vector<Bond> bonds_;
    std::vector<LineModel> lines_;
    std::vector<Piece> pieces_;
    std::vector<HeldPiece> held_pieces_;
    std::vector<Pin> pins_;
    struct Kind {
        std::vector<double> key;
        std::unique_ptr<LineWaves> waves;
        std::map<int, std::pair<Matrix12, Matrix12>> at_lambda;  ///< stiffness and mass of one of so many pieces
    };
    std::vector<Kind> kinds_;
    std::vector<int> counts_;  ///< of pieces of a line of each kind
    bool is_cut_ = false;      ///< into these
    int cuts_ = 0;
    std::optional<Elimination> elimination_;
    double lambda_ = 0;
};

/// Mass of a rod of a length [m] as a rigid body but for its axis x, about its middle, local axes: by [velocity; angular
/// velocity]. Without an inertia of its own it has none about x, as in time.
Matrix6 bar_mass(const Section& section, double length);

}  // namespace dttmm::plugin
