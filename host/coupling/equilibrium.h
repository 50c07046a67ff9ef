// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <optional>
#include <string>
#include <vector>

#include "coupling/loads.h"
#include "coupling/machine_size.h"
#include "coupling/networks.h"
#include "coupling/resting_joints.h"
#include "model/model.h"

namespace dttmm::host {

/// A machine at rest.
struct RestState {
    std::vector<BodyState> at;  ///< velocities zero
    int iterations = 0;         ///< in all
    int load_steps = 0;         ///< that were accepted
    double residual = 0;        ///< the largest force that lacks [N]
    double force = 0;           ///< the largest of an element, load or weight [N]
    std::string open;           ///< a joint that is open by more than rounding, and how far; empty: none
    double turn = 0;  ///< the largest rotation of a body on its way from the assembled machine, full turns too [rad]
    /// The share of the load at which the path of equilibria ends that the machine follows as the load grows from zero; to
    /// 1/1024 of itself. None: the path leads to the whole load, or there is none from the assembled machine.
    std::optional<double> path_ends_at = std::nullopt;
    bool is_loaded = true;  ///< by weight or a load
    double noise = 0;       ///< what of a force may be rounding of places [N]

    /// Whether there are forces: without loads those within rounding are none.
    bool has_forces() const { return force > (is_loaded ? 0 : kNoise * noise); }
    /// What lacks, as share of the largest force. Rounding of places by the largest stiffness is a force too.
    double unbalanced() const { return has_forces() ? residual / force : 0; }
    static constexpr double kNoise = 16;  ///< times `noise`: that of one element; some come together at a body
};

/// Finds where a machine rests under its weight and its loads as they are at t0: forces and moments balance on all bodies
/// and inside all networks, joints are closed, stops push or are not reached,
///     W(x) + λ (weight + loads) − Jᵀ q = 0,     C(x) = 0,     λ = 1.
/// Motors ask for λ times what they do at t0. Newton's iteration from the assembled machine with the whole derivative: what
/// turns with joints and lever arms included. The full load is tried at once; where the iteration does not end, in steps of
/// λ that are halved until it does. A small resistance s M against every correction keeps motions determined that nothing
/// holds; it grows where a correction would go uphill, towards an equilibrium that does not last, or too far.
class Equilibrium {
public:
    Equilibrium(const Model& model, Networks& networks, Loads& loads);

    /// t0 [s]. Throws Error(numerical_failure) with the largest λ that has an equilibrium, and what moves on beyond it.
    /// Afterwards the networks can start at rest there.
    const RestState& find(double t0);

    // Of the machine at rest: what its loads add to the stiffness as their lever arms turn, 36 per body; and the forces of
    // ideal joints, 144 per joint by the motion of [first; second body], row-major.
    std::vector<double> load_stiffness() const;
    std::vector<double> joint_stiffness() { return joints_.stiffness(state_.at); }
    /// How the force and moment of a joint on its first body, in the axes of that body, change while its reactions keep
    /// their size: by small motions of [first; second] body at their centres of mass, world axes.
    Eigen::Matrix<double, 6, 12> joint_turning(size_t joint) const { return joints_.turning(joint, state_.at); }
    const std::vector<Stop>& stops() const { return joints_.stops(); }

private:
    using Vector6 = Eigen::Matrix<double, 6, 1>;
    using Triplets = std::vector<Eigen::Triplet<double>>;
    struct Attempt {
        bool is_converged = false;
        double correction = 0;        ///< the last one [m]
        std::string mover;            ///< what it moves most
        RestingJoints::Opening open;  ///< of joints, where nothing moves any longer
    };
    struct Correction {
        double work = 0;            ///< of what lacks along it [J]: negative uphill
        double size = 0, turn = 0;  ///< of bodies and insides [m, rad]
        double bend = 0;            ///< of joints, as share of what their laws hold up to
        std::string mover;
        double rounding = 0;  ///< of the work [J]
        double share = 1;     ///< to be taken of it
    };
    enum class Steps { any, smooth };  ///< smooth: to the equilibrium that the growing load leads to, not to another one
    void search(double t0);
    double follow(double t0);
    void begin(double t0);
    double raise_load(double t0, Steps steps);
    std::string describe(const RestingJoints::Opening& open) const;
    double heaviest() const;
    Attempt iterate(double factor);
    Correction correct(double factor);
    bool is_stable(double factor);
    Correction try_resistance(double factor);
    void solve(double factor);
    void form(double factor);
    void set_least_resistance(const Eigen::VectorXd& held);
    void add_loads(double factor, const std::vector<BodyState>& at, std::vector<double>& wrenches) const;
    void add_load_stiffness(double factor, Triplets& entries) const;
    bool has_same_pattern() const;
    bool is_loaded() const;
    double lacking(double factor, double share);
    double reach(size_t body) const { return size_.reach[body]; }
    /// Added to the inertia of a body in the resistance [kg m²]. The motion of a chain follows from how its links turn. By
    /// inertia alone the links at its ends would turn first, as in a fall, and the next after them; with this all turn at
    /// once: a moment of weight over the machine's length turns each by about as much.
    double turning_mass(size_t body) const { return size_.mass * size_.span * reach(body); }

    const Model& model_;
    Networks& networks_;
    Loads& loads_;
    RestingJoints joints_;
    MachineSize size_;

    RestState state_;
    std::vector<BodyState> start_, kept_;
    std::vector<Eigen::Vector3d> turned_, kept_turned_;  ///< of every body: rotation vector from the start, full turns too
    std::vector<double> wrenches_;
    Eigen::VectorXd right_hand_side_, solution_;
    std::vector<double> change_;                    ///< 6 per body
    Eigen::SparseMatrix<double> matrix_, pattern_;  ///< pattern_: last analysed
    Eigen::SparseLU<Eigen::SparseMatrix<double>> lu_;
    bool shares_anew_ = true;  ///< redundant joints, among each other
    double resistance_ = 0, least_resistance_ = 0, stiffest_ = 0;
    double farthest_ = 0;   ///< that one correction may move something [m]
    double most_bend_ = 0;  ///< that one correction may turn the ends of a joint, as share of what its law holds up to
    double bend_ = 0;       ///< the largest there is
    double noise_ = 0;
    Steps steps_ = Steps::any;
    bool is_smooth_ = true;  ///< no correction since begin() may have jumped
    double strongest_ = 0;   ///< of all forces, those of joints included [N]
};

}  // namespace dttmm::host
