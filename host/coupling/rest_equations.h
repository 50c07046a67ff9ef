// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <string>
#include <vector>

#include "coupling/loads.h"
#include "coupling/machine_size.h"
#include "coupling/networks.h"
#include "coupling/resting_joints.h"
#include "model/model.h"

namespace dttmm::host {

/// The equations of a machine at rest under a share λ of its loads, and one iterate of their solution. Forces and moments
/// balance on all bodies and inside all networks, and joints are closed,
///     W(x) + λ (weight + loads) − Jᵀ q = 0,     C(x) = 0.
/// Motors ask for λ times what they do at t0. A correction is Newton's with the whole derivative: what turns with joints and
/// lever arms included. A small resistance s M against it keeps motions determined that nothing holds.
class RestEquations {
public:
    RestEquations(const Model& model, Networks& networks, Loads& loads);

    /// Back to the assembled machine, the loads as they are at t0 [s].
    void begin(double t0);
    /// Keeps where everything is, which throws Error(numerical_failure) when a spring has turned too far; goes back there.
    void keep();
    void recall();
    /// Takes λ.
    void set_load(double factor);
    /// Whether redundant joints share their forces anew at each correction, or change them by the least.
    void share_anew(bool anew) { shares_anew_ = anew && !joints_.equations().empty(); }
    bool shares_anew() const { return shares_anew_; }
    /// Whether a body has a load without a potential: a moment, or what turns with it.
    bool has_unsymmetric_loads() const;
    /// Takes the symmetric part alone of the derivative of loads on bodies: corrections then go downhill.
    void take_symmetric(bool symmetric) { is_symmetric_ = symmetric; }

    struct Correction {
        double work = 0;            ///< of what lacks along it [J]: negative uphill
        double size = 0, turn = 0;  ///< of bodies and insides [m, rad]
        double bend = 0;            ///< of joints, as share of what their laws hold up to
        std::string mover;          ///< what it moves most
        double rounding = 0;        ///< of the work [J]
        int falling = 0;            ///< motions inside networks that grow from where it begins, the bodies held
        double share = 1;           ///< to be taken of it
    };
    /// Finds the correction from where the machine is. resistance: s [1/s²], at least least_resistance().
    Correction correct(double resistance);
    /// Where the machine is after a share of the correction. Forces in N.
    struct Balance {
        double residual = 0;   ///< the largest that lacks
        double force = 0;      ///< the largest of an element, load or weight
        double strongest = 0;  ///< the largest, those of joints included
        double noise = 0;      ///< what of a force may be rounding of places
        double bend = 0;       ///< the largest of a joint, as share of what its law holds up to
        double turn = 0;       ///< the largest of what is inside networks, from the assembled machine [rad]
    };
    /// Takes a share of the correction last found.
    const Balance& move(double share);
    const Balance& balance() const { return balance_; }
    /// Whether no motion grows where the machine is, but for one that grows as slowly as what counts as not held.
    bool is_stable();
    /// Before the first correction that of a machine that nothing is stiff in.
    double least_resistance() const { return least_resistance_; }

    const std::vector<BodyState>& at() const { return now_.at; }
    /// The largest rotation of a body from the assembled machine, full turns too [rad].
    double largest_turn() const;
    const MachineSize& size() const { return size_; }
    /// Whether weight or a load acts at λ = 1. Weight of what is between the bodies counts as gravity does.
    bool is_loaded() const;
    double heaviest() const;  ///< body [kg]

    RestingJoints::Opening widest_opening() const { return joints_.widest_opening(now_.at, factor_, size_.span); }
    bool reach_stops() { return joints_.reach_stops(now_.at); }
    bool release_stops() { return joints_.release_stops(); }
    const std::vector<Stop>& stops() const { return joints_.stops(); }

    // As Equilibrium has them.
    std::vector<double> load_stiffness() const;
    std::vector<double> joint_stiffness() { return joints_.stiffness(now_.at); }
    Eigen::Matrix<double, 6, 12> joint_turning(size_t joint) const { return joints_.turning(joint, now_.at); }

private:
    using Vector6 = Eigen::Matrix<double, 6, 1>;
    using Triplets = std::vector<Eigen::Triplet<double>>;
    void form(double resistance);
    void solve(double resistance);
    bool has_same_pattern() const;
    void set_least_resistance(const Eigen::VectorXd& held);
    std::vector<double> loads_on(const std::vector<BodyState>& at, double factor) const;
    void add_load_stiffness(double factor, Triplets& entries) const;
    void add_turning_about(const std::vector<double>& loads, Triplets& entries) const;
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
    double factor_ = 0;        ///< λ
    bool shares_anew_ = true;  ///< redundant joints, among each other
    bool is_symmetric_ = false;

    struct Place {
        std::vector<BodyState> at;
        std::vector<Eigen::Vector3d> turned;  ///< of every body: rotation vector from the start, full turns too
    };
    Place start_, now_, kept_;
    Balance balance_;
    std::vector<double> wrenches_, change_;  ///< 6 per body
    Eigen::VectorXd right_hand_side_, solution_;
    Eigen::SparseMatrix<double> matrix_;
    struct Solver {
        Eigen::SparseMatrix<double> pattern;  ///< last analysed
        Eigen::SparseLU<Eigen::SparseMatrix<double>> lu;
    };
    Solver solver_;
    double stiffest_ = 0, least_resistance_ = 0;
};

}  // namespace dttmm::host
