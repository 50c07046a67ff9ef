// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "core/rotation.h"
#include "mechanism/assembly.h"
#include "mechanism/joint_kinematics.h"
#include "mechanism/scheme.h"
#include "mechanism/springs.h"

namespace dttmm::plugin {

/// The frames of a joint at an instant.
struct Ends {
    FrameView from, to;
};

/// What unit forces in the rigid directions of a joint do over a step.
struct RigidMap {
    Matrix3 force = Matrix3::Zero(), arm = Matrix3::Zero(), lever = Matrix3::Zero(), moment = Matrix3::Zero();
    /// Adds an instant: the joint, and what a turn opens of its rotations then.
    void add(double weight, const JointPose& pose, const Matrix3& opening_of_turn) {
        force += weight * pose.axes;
        arm += weight * (skew(pose.arm) * pose.axes);
        lever += weight * (skew(pose.lever) * pose.axes);
        moment += weight * (pose.axes * opening_of_turn.transpose());
    }
    JointForce of(const Vector6& q) const {
        const Vector3 slide = q.head<3>(), turn = moment * q.tail<3>();
        return {force * slide, arm * slide + turn, lever * slide + turn};
    }
};

/// −∂(wrench)/∂(pose) of the two ends of a joint, [row][column], `from` first; world axes, at the frames' origins.
struct EndBlocks {
    Matrix6 at[2][2];
};

/// What the laws of a joint remember at t_n, and at t_{n−1}; NULL where none has a memory.
struct LawMemory {
    double *now = nullptr, *before = nullptr;
};

/// What all joints of one law have alike, as those along a beam.
struct JointKind {
    explicit JointKind(std::shared_ptr<const JointLaw> law);
    /// Solves the transfer equations for the law at the scheme's step size.
    void set_scheme(const Scheme& scheme);

    std::shared_ptr<const JointLaw> law;
    SpringsOf<double> springs;
    bool is_damped, is_axial, has_laws;
    int hinge_axis = -1;   ///< about which alone it turns, its other two rotations being rigid; -1: none
    double step_size = 0;  ///< `solved` is for [s]
    Vector3 solved[2];     ///< k̂ = ∂f/∂d of the solved transfer equations, translations, rotations [N/m, N m/rad]
    std::shared_ptr<const JointAxesOf<double>> last_axes;  ///< of the joint made last: the next has the same, mostly
};

/// Where a joint is between its two frames, how it is deformed, and what forces there do to the frames. It measures its
/// deformation in its axes, which go with the `from` frame. The axes of a joint along a line follow the line.
class JointGeometry {
public:
    static constexpr double kLargestRotation = 2.5;  ///< rad

    /// kind: of the law of `spec`.
    JointGeometry(const JointSpec& spec, const Assembly& assembly, std::shared_ptr<JointKind> kind);

    int element() const { return element_; }
    int from() const { return from_; }
    int to() const { return to_; }
    int frame(int end) const { return end == 0 ? from_ : to_; }
    /// Whether it carries a moment: otherwise rotations are not worked out.
    bool turns() const { return kind_->springs.turns; }
    Directions rigid() const { return kind_->law->rigid; }
    const JointLaw& law() const { return *kind_->law; }
    const JointHalf& translation_half() const { return kind_->springs.halves[0]; }
    const JointHalf& rotation_half() const { return kind_->springs.halves[1]; }
    const JointSeat& seat() const { return seat_; }
    bool is_line() const { return kind_->springs.is_line; }
    const SpringsOf<double>& springs() const { return kind_->springs; }
    const JointKind& kind() const { return *kind_; }
    bool is_axial() const { return kind_->is_axial; }

    /// Kinematics at given frames: its pose; its attitude; its rotation θ.
    JointPose pose(FrameView from, FrameView to) const {
        if (is_axial()) [[unlikely]]
            return axial_pose(from, to);
        return seat_.pose(from, to);
    }
    JointPose pose(Ends at) const { return pose(at.from, at.to); }
    /// From the origin of its `from` frame (0) or `to` frame (1) to the point where its force acts on that [m], world axes.
    Vector3 arm(int end, FrameView from, FrameView to) const {
        return end == 1 ? seat_.lever(to) : is_axial() ? arm_of_line(from) : seat_.arm(from, to);
    }
    Matrix3 attitude(FrameView from, FrameView to) const { return seat_.axes(from).transpose() * seat_.axes_at_to(to); }
    Vector3 rotation(FrameView from, FrameView to) const {
        return turns() ? rotation_vector(attitude(from, to)) : Vector3(Vector3::Zero());
    }
    /// Its deformation [d; θ] in a pose between its frames.
    Vector6 deformation(const JointPose& pose, FrameView from, FrameView to) const;
    /// Rates and second rates, [strains; relative turn], joint axes.
    Vector6 rate(FrameView from, const Twist& from_velocity, FrameView to, const Twist& to_velocity) const;
    /// The same where its pose and deformation are known already.
    Vector6 rate(const JointPose& pose, const Twist& from_velocity, const Twist& to_velocity,
                 const Vector6& deformation) const;
    Vector6 acceleration(FrameView from, const Twist& from_velocity, const Twist& from_acceleration, FrameView to,
                         const Twist& to_velocity, const Twist& to_acceleration) const;
    /// Angular velocity of its axes, in these.
    Vector3 turning(FrameView from, const Twist& from_velocity, FrameView to, const Twist& to_velocity) const;

    /// What is open of its rigid directions in a pose between its frames: d, and how far the axis of a hinge tilts; of
    /// others the rotation vector, whose derivative across an axis vanishes after half a turn about it.
    Vector6 opening(const JointPose& pose, FrameView from, FrameView to) const;
    /// Columns of the rotations in it by the relative turn; its transpose makes moments of forces in rigid rotations.
    Matrix3 opening_of_turn(const Vector3& theta) const {
        return kind_->hinge_axis < 0 ? rotation_vector_rate(theta) : Matrix3(Matrix3::Identity());
    }
    bool is_hinge() const { return kind_->hinge_axis >= 0; }

    /// Columns of [d; θ], joint axes, by the pose of the `from` or the `to` frame, world axes; for small relative rotations.
    Matrix6 by_from(const JointPose& pose) const;
    Matrix6 by_to(const JointPose& pose) const;

    /// Columns of the strains by d and ε.
    Matrix36 strain_columns(const Vector6& deformation) const;
    /// From the first point of its line to the second, world axes.
    Vector3 way(FrameView from, FrameView to) const { return seat_.arm(from, to) - arm_of_line(from); }

    /// Of forces that grow with the deformation by `answer` (joint axes).
    EndBlocks stiffness(const JointPose& pose, const Matrix6& answer) const;
    /// Of a force already acting (world axes), which turns with the joint; symmetric part.
    EndBlocks acting_stiffness(const JointPose& pose, FrameView from, FrameView to, const Vector3& force) const;

    /// Throws Error(DTTMM_ERROR_NUMERIC) when a rotational stiffness has turned too far.
    void refuse_large_rotation(FrameView from, FrameView to) const;
    void refuse_large_rotation(const Vector3& theta) const { refuse_rotation(theta.norm()); }
    void refuse_large_rotation(const JointState& state) const {
        if (!(state.theta.squaredNorm() <= kLargestRotation * kLargestRotation)) [[unlikely]]
            refuse_rotation(state.theta.norm());
    }

protected:
    std::shared_ptr<JointKind> kind_;
    JointSeat seat_;

private:
    [[gnu::noinline, gnu::cold]] JointPose axial_pose(FrameView from, FrameView to) const;
    /// From the `from` origin to the first point of its line, which lies on its x from the second, world axes.
    Vector3 arm_of_line(FrameView from) const {
        return from.axes() * (seat_.own->from_axes * (seat_.rest - law().axial->length * Vector3::UnitX()));
    }
    /// Of the lever of the `to` end.
    Matrix3 lever_rows(const JointPose& pose) const;
    EndBlocks axial_stiffness(FrameView from, FrameView to, const Vector3& force) const;
    void refuse_rotation(double angle) const;

    int element_, from_, to_;
};

}  // namespace dttmm::plugin
