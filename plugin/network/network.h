// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "core/discretisation.h"
#include "dttmm_plugin.h"
#include "element/element.h"

namespace dttmm {

/// A connected set of elements between ports and the ground, solved together at every step. It owns the memory of the time
/// scheme; the ports' motion comes from the host. Rotations are large, deformations small: an element measures its
/// deformation in the axes of its `from` end, and the wrenches on its two ends balance exactly, lever arm included, at the
/// poses of t_n, so that the host's momentum and angular momentum are kept to rounding.
///
/// The phases, units and frames are those of dttmm_plugin.h; errors are thrown as Error, with the element's index.
class Network {
public:
    explicit Network(const dttmm_network& description);

    int port_count() const { return port_count_; }
    bool is_implicit() const { return scheme_ == DTTMM_SCHEME_CENTRED; }
    void load_weights(double weights[3]) const;

    void linearise(const dttmm_motion* ports, double* wrench, double* stiffness, double* damping) const;
    void start(const dttmm_step& step, const dttmm_motion* ports, const double* accelerations);
    void begin_step(const dttmm_step& step);
    void evaluate(const dttmm_motion* trial, double* wrench, double* stiffness) const;
    void commit_step(const dttmm_motion* accepted);
    void discard_step();

    size_t state_size() const;
    void save_state(void* buffer, size_t size) const;
    void restore_state(const void* buffer, size_t size);

    const std::vector<dttmm_channel>& channels() const { return channels_; }
    void outputs(double* values) const;

private:
    /// One end of a joint: a port, or a point of the ground (port −1) that keeps this pose for ever.
    struct End {
        int port;
        Vector3 ground_position;
        Matrix3 ground_rotation;
    };

    /// An element at work: its data, its reference configuration and its solved force law at the current step size.
    struct Joint {
        End from, to;
        Vector6 stiffness, damping;
        bool turns;                 ///< carries a rotation: only then is the relative rotation worked out
        Vector3 reference_position; ///< of the `to` end seen from the `from` end, in its axes, at rest
        Matrix3 reference_rotation; ///< rest value of R_fromᵀ R_to
        Vector6 law;                ///< k̂: −∂f/∂d of the solved transfer equations [N/m, N m/rad]
        std::unique_ptr<const Element> element;
    };

    /// What changes from step to step, joint by joint; plain numbers, so that saving is copying.
    struct JointState {
        Vector6 d[4];       ///< deformation at t_n, t_{n−1}, t_{n−2}, t_{n−3}
        Vector6 known;      ///< part of the force over the open step that does not depend on its end
        double dissipated;  ///< energy lost to damping up to t_{n−1} [J]
        double power;       ///< at t_{n−1} [W]
    };
    struct PortState {
        Vector3 position;
        Matrix3 rotation;
    };
    struct Clock {
        double step_size = 0;
        uint64_t steps = 0;  ///< committed since the start
    };

    /// Pose of an end in the world, and the relative motion of two ends as their joint sees it.
    struct EndPose {
        Vector3 position;
        Matrix3 rotation;
    };
    EndPose committed_pose(const End& end) const;
    static EndPose pose_of(const End& end, const dttmm_motion* ports);
    static Vector6 deformation(const Joint& joint, const EndPose& from, const EndPose& to);
    static Vector6 deformation_rate(const Joint& joint, const dttmm_motion* ports);
    static Vector6 deformation_acceleration(const Joint& joint, const dttmm_motion* ports, const double* accelerations);

    /// Adds the wrenches of a joint force `f` (axes R_from) to its ports; `arm` leads from the `from` end to the `to` end.
    static void add_wrench(const Joint& joint, const Matrix3& R_from, const Vector3& arm, const Vector6& f, double* wrench);
    /// Adds −∂(wrench)/∂(pose) or −∂(wrench)/∂(velocity) of a joint whose force changes by `gain` times the deformation's
    /// change: poses (or velocities) change at R_from_trial, arm_trial; forces act at R_from, arm.
    void add_stiffness(const Joint& joint, const Vector6& gain, const EndPose& from, const EndPose& to, const Matrix3& R_from,
                       const Vector3& arm, double* stiffness) const;

    std::vector<End> place_ends(const dttmm_network& description);
    void build_joint(const dttmm_network& description, const std::vector<End>& ends, uint32_t index);
    void solve_laws();
    void recall(JointState& state, const Joint& joint) const;
    AffineMotion explicit_motion(const JointState& state) const;

    uint32_t scheme_;
    Centred centred_;
    int port_count_ = 0;
    std::vector<Joint> joints_;
    std::vector<std::string> names_;
    std::vector<dttmm_channel> channels_;

    std::vector<JointState> joint_states_;
    std::vector<PortState> port_states_;
    Clock clock_;
    bool started_ = false, open_ = false;
};

}  // namespace dttmm
