// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/SparseCore>
#include <numbers>
#include <vector>

#include "model/index.h"
#include "model/model.h"
#include "world/joint_system.h"

namespace dttmm::host {

/// A body moved by [shift; turn], world axes.
BodyState moved(const BodyState& from, const Eigen::Matrix<double, 6, 1>& by);

/// The derivative by a turn φ, at φ = 0, of what is a polynomial of degree two in the rotation, as forces of joints and
/// loads are. odd(φ) = ½ (f(φ) − f(−φ)) is then a₁ sin φ + a₂ sin 2φ, and a₁ + 2 a₂ is exact.
template <class Odd>
auto slope_by_turn(const Odd& odd) {
    auto slope = odd(std::numbers::pi / 4);
    slope = 2 * slope + (1 - std::numbers::sqrt2) * odd(std::numbers::pi / 2);
    return slope;
}

/// The ideal joints of a machine at rest: their equations and forces Jᵀ q beside those of the bodies, and their stops. Each
/// function gets the places of the bodies.
class RestingJoints {
public:
    using Vector6 = Eigen::Matrix<double, 6, 1>;
    using Triplets = std::vector<Eigen::Triplet<double>>;

    explicit RestingJoints(const Model& model);

    const std::vector<JointEquations>& equations() const { return system_.joints(); }
    const std::vector<Stop>& stops() const { return stops_; }
    /// Equations in all: 6 per body, then those of the joints.
    int rows() const { return rows_; }
    /// Without forces, no stop acting, motors as they are at t0 [s].
    void start(double t0);
    /// keep() stores stops and forces; recall() restores them.
    void keep();
    void recall();

    /// Adds equations and forces of all joints under a share of what motors do. held: how stiffly bodies are held at their
    /// centres of mass at most [N/m]. Both by row. shares_anew: what redundant joints share is the least that balances, not
    /// the least change; joints then stay open by what the proximal term makes of their forces. `at` is changed during the
    /// call and restored.
    void add(std::vector<BodyState>& at, double factor, const std::vector<double>& held, bool shares_anew, Triplets& entries,
             Eigen::VectorXd& right_hand_side) const;
    /// Work of the forces of the joints in the motion of a solution, in parts: work(w). matrix: of the equations; what it
    /// has on its diagonal yields to the change of a force.
    template <class Work>
    void for_each_work(const Eigen::SparseMatrix<double>& matrix, const Eigen::VectorXd& solution,
                       const Eigen::VectorXd& right_hand_side, const Work& work) const {
        for (Eigen::Index row = rows_ - q_.size(); row < rows_; ++row) {
            const double force = q_(row - rows_ + q_.size()) + solution(row);
            work(-force * right_hand_side(row));
            work(force * matrix.coeff(row, row) * solution(row));
        }
    }
    /// Takes a share of the change of the forces in a solution.
    void change(double share, const Eigen::VectorXd& solution) { q_ += share * solution.tail(q_.size()); }
    /// Takes the forces off the wrenches on the bodies; the largest of them [N].
    double take_off(const std::vector<BodyState>& at, std::vector<double>& wrenches) const;
    /// The joint that is open farthest under a share of what motors do, in shares of an extent [m] or as an angle [rad].
    struct Opening {
        double share = 0;
        size_t joint = 0;
        double size = 0;  ///< [m, rad]
        bool is_length = true;
    };
    Opening widest_opening(const std::vector<BodyState>& at, double factor, double extent) const;
    /// Makes stops act that are passed; true if one more does.
    bool reach_stops(const std::vector<BodyState>& at);
    /// Lets go the stops that would pull; true if there is one.
    bool release_stops();

    /// What the forces add to the stiffness, 144 per joint by the motion of [first; second body], row-major.
    std::vector<double> stiffness(std::vector<BodyState>& at) const;
    /// How the force and moment of a joint on its first body, in the axes of that body, change while its reactions keep
    /// their size: by small motions of [first; second] body at their centres of mass, world axes.
    Eigen::Matrix<double, 6, 12> turning(size_t joint, const std::vector<BodyState>& start) const;

private:
    int first_row(size_t joint) const { return first_row_[joint]; }
    int first_force(size_t joint) const { return first_row_[joint] - rows_ + as_int(q_.size()); }
    void add_stiffness(size_t joint, std::vector<BodyState>& at, Triplets& entries) const;
    Eigen::VectorXd reactions(size_t joint) const;
    Vector6 wrench(size_t joint, const std::vector<BodyState>& at) const;

    const Model& model_;
    JointSystem system_;
    std::vector<int> first_row_;  ///< of every joint's equations
    int rows_;
    Eigen::VectorXd q_, kept_q_;
    std::vector<Stop> stops_, kept_stops_;
};

}  // namespace dttmm::host
