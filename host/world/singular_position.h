// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/QR>
#include <optional>
#include <utility>
#include <vector>

#include "model/model.h"
#include "world/block_factor.h"
#include "world/block_matrix.h"
#include "world/body_state.h"
#include "world/joint_system.h"

namespace dttmm::host {

/// Whether joints close a loop of bodies, the ground among them. Only then can their equations depend on each other.
bool form_loop(const std::vector<Joint>& joints);
/// The same of any links between numbered things; −1: the ground.
bool form_loop(const std::vector<std::pair<int, int>>& links);

/// Finds the steps in which a linkage passes a singular position. The linkage has one free motion more there: a combination
/// of equations w obeys wᵀ J = σ dᵀ, and σ passes through zero. With σ₀, σ₁ at the ends of a step and σ half way, a pass of
/// Newton's iteration leaves of an error along d
///     1 − σ₁/σ₀ with the matrix at t_n,     1 − σ₀ σ₁/σ² = (σ₁ − σ₀)²/4σ² with the matrix half way.
/// Where the latter is too much, one equation of the combination is let go over the step: the motion goes on by its
/// momentum, and the steps that follow close the joint, as C is of second order in what they have moved.
class SingularPosition {
public:
    /// have_loop: the joints form a loop. Only then is working memory allocated here; without one, when find() is called.
    SingularPosition(const JointSystem& joints, bool have_loop);

    /// Opens a solution of a step: all equations hold, the matrix is that at t_n.
    void open();
    /// Whether find() is worth its time, as it takes decompositions of all equations: the step before was near a singular
    /// position, or the product of the equations' distances from the span of those before, which the factor of the matrix
    /// has, changes fast from step to step, or has become small. Stores it.
    bool is_suspected(const BlockMatrix& matrix, const BlockFactor& factor);
    /// Decides about the step whose bodies stand at `now`, half way and at its end. Beyond 1000 equations nothing is near.
    void find(const JointSystem& joints, const std::vector<BodyState>& now, const std::vector<BodyState>& half,
              const std::vector<BodyState>& end);
    /// Counts the step from `time` [s] if it goes without equations.
    void count(double time);

    /// The matrix is to be taken half way. Where joints turn by more than 0.3 rad in the step nothing is near.
    bool is_near() const { return found_.is_near; }
    /// Equations that the step goes without; empty: ODE's joints hold.
    const LetGo& let_go() const { return found_.let_go; }
    bool lets_go() const { return found_.lets_go(); }
    /// σ of the equations kept, over their length: rounding of poses moves the bodies by its inverse.
    double least() const { return found_.least; }

    /// Steps so far that went without equations of joints; the first: its time [s], and a joint.
    struct Passed {
        long steps = 0;
        double time = 0;
        size_t joint = 0;
    };
    const Passed& passed() const { return passed_; }

private:
    struct Found {
        bool is_near = false;
        LetGo let_go;
        double least = 1;
        bool is_clear = false;  ///< every equation is either redundant or far from the span of the others
        bool lets_go() const;
        void clear();
    };
    void make_room(const std::vector<JointEquations>& joints, Eigen::Index equations);
    void write_columns(const std::vector<JointEquations>& joints, const std::vector<BodyState>& at, double sign,
                       Eigen::MatrixXd& columns) const;
    void decide(const std::vector<JointEquations>& joints, const std::vector<BodyState>& now,
                const std::vector<BodyState>& half, const std::vector<BodyState>& end);

    Found found_, before_;  ///< of the open step, and of its solution before
    Passed passed_;
    /// Logarithm of the product of the distances of all equations from the span of those before.
    struct Distance {
        double last, largest;
    };
    std::optional<Distance> product_;
    double longest_arm_ = 0;  ///< of all joints [m]
    // Of find():
    Eigen::MatrixXd half_, end_;
    Eigen::ColPivHouseholderQR<Eigen::MatrixXd> pivoted_;
};

}  // namespace dttmm::host
