// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <vector>

#include "model/index.h"
#include "model/model.h"
#include "world/block_matrix.h"
#include "world/body_state.h"

namespace dttmm::host {

/// What an ideal joint forbids, as equations C = 0 of the poses of its two bodies, C = 0 at the start. Two kinds:
///     anchor    d·(p₂ − p₁) = 0    the anchor points keep together along d, fixed in the world or (slider) on the first
///     body
///
///     angle     u₁·w₂ = 0          a direction on the first body stays at right angles to one on the second
///
/// ball: 3 anchors. hinge: 3 anchors, 2 angles. universal: 3 anchors, 1 angle. slider: 2 anchors, 3 angles. fixed: 3 and 3.
/// A hinge and a slider have a coordinate, 0 at the start: the angle [rad, −π..π] of the second body about the axis, or its
/// travel along it [m], seen from the first. A motor makes it one equation more, coordinate = what the motor asks for. With
/// stops, one equation more holds the coordinate while a stop acts.
/// Velocities and wrenches are [of the centre of mass; angular] and [force; moment about it], world axes.
class JointEquations {
public:
    using Rows = BlockMatrix::Rows;
    using Values = BlockMatrix::Values;

    enum Side : size_t { kFirst, kSecond };
    static constexpr Side kSides[] = {kFirst, kSecond};
    /// The derivatives of the equations by the velocities of the bodies, by side.
    using Jacobian = std::array<Rows, 2>;

    JointEquations(const Joint& joint, const std::vector<Body>& bodies);

    const std::array<int, 2>& bodies() const { return bodies_; }  ///< by side; −1: the ground
    /// Equations, that of the stops, the last, included.
    int count() const { return lasting() + (has_stops_ ? 1 : 0); }
    /// Equations that always hold.
    int lasting() const { return as_int(anchors_.size() + angles_.size()) + (is_driven_ ? 1 : 0); }
    /// A motor keeps the coordinate; then there are no stops.
    bool is_driven() const { return is_driven_; }
    /// The equation of the coordinate: of the motor, or of the stops.
    int coordinate_row() const { return lasting() - (is_driven_ ? 1 : 0); }
    /// Whether a lasting equation is one of lengths [m], not of angles.
    bool is_of_length(int row) const {
        return row < as_int(anchors_.size()) || (is_driven_ && row == coordinate_row() && !turns_);
    }
    bool has_stops() const { return has_stops_; }
    /// Coordinate of the lower stop, side 1, or of the upper, side −1 [rad, m].
    double stop(int side) const { return stops_[side > 0 ? 0 : 1]; }

    /// C [m, rad] of the lasting equations. driven_to: the coordinate that the motor asks for; angles differ by half a turn
    /// at most.
    Values residual(const std::vector<BodyState>& at, double driven_to = 0) const;
    /// ∂Ċ/∂(velocities), the last row that of the coordinate where there are stops or a motor; zero for the ground.
    Jacobian jacobian(const std::vector<BodyState>& at) const;
    /// C̈ of all equations while both bodies keep their velocities.
    Values curvature(const std::vector<BodyState>& at) const;

    /// From the centre of mass of the body on a side to the anchor [m].
    double arm(Side side) const { return (side == kFirst ? arm_first_ : arm_second_).norm(); }
    /// Where the anchor is in the world [m], on the first body.
    Eigen::Vector3d anchor(const std::vector<BodyState>& at) const;
    /// The axes of the first body, in which the joint's force is reported.
    Eigen::Matrix3d axes(const std::vector<BodyState>& at) const { return state(kFirst, at).rotation; }
    bool has_coordinate() const { return has_coordinate_; }
    bool turns() const { return turns_; }  ///< the coordinate is an angle
    double coordinate(const std::vector<BodyState>& at) const;
    /// How far one coordinate is from another, `to` − `from`, of angles at most half a turn [rad, m].
    double way(double from, double to) const { return turns_ ? std::remainder(to - from, 2 * M_PI) : to - from; }
    /// The rate of a coordinate that has stops or a motor, with the velocities of `moving` in the positions `at` [rad/s,
    /// m/s].
    double coordinate_speed(const std::vector<BodyState>& at, const std::vector<BodyState>& moving) const;

private:
    struct AnchorEquation {
        Eigen::Vector3d d;
        bool on_first;  ///< d is fixed on the first body, in its axes; else in the world
    };
    struct AngleEquation {
        Eigen::Vector3d u, w;  ///< in the axes of the first and of the second body
    };
    const BodyState& state(Side side, const std::vector<BodyState>& at) const;
    Eigen::Vector3d direction(const AnchorEquation& equation, const BodyState& first) const;

    std::array<int, 2> bodies_;
    std::vector<AnchorEquation> anchors_;
    std::vector<AngleEquation> angles_;
    Eigen::Vector3d arm_first_, arm_second_;  ///< from the centres of mass to the anchor, body axes [m]
    bool has_coordinate_, turns_, has_stops_, is_driven_;
    std::array<double, 2> stops_;
    Eigen::Vector3d axis_, zero_, quarter_;  ///< on the first body: the axis, where angle 0 points, a quarter turn on
    Eigen::Vector3d pointer_;                ///< on the second body: what shows the angle
};

}  // namespace dttmm::host
