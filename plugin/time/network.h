// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "dttmm_plugin.h"
#include "mechanism/mechanism.h"
#include "time/interior.h"

namespace dttmm::plugin {

/// A connected set of elements between ports and the ground, solved together at every step. It owns the memory of the time
/// scheme; the ports' motion comes from the host. Bodies, lumps and nodes may turn as they like, deformations are small:
/// every joint measures its own in axes that go with it, and the wrenches on its two ends balance exactly, lever arms
/// included, at every instant. Frames stand at the centres of mass, those of the ports too, which dttmm_node.arm tells:
/// under Newmark's rule momentum is then kept to rounding and, but for dampers and rigid directions, angular momentum
/// (Interior::newmark_momentum).
///
/// Elements between bodies only are joints side by side. What else moves, nodes and the masses of beams, is solved for
/// inside (Interior), in time linear in the number of elements.
///
/// The phases, units and frames are those of dttmm_plugin.h; errors are thrown as Error, with the element's index.
class Network {
public:
    explicit Network(const dttmm_network& description);

    int port_count() const { return mechanism_.assembly.port_count; }
    bool is_implicit() const { return mechanism_.scheme.is_implicit(); }
    void load_weights(double weights[3]) const;

    void linearise(const dttmm_motion* ports, double* wrench, double* stiffness, double* damping) const;
    void start(const dttmm_step& step, const dttmm_motion* ports, const double* accelerations, const double* loads);
    void begin_step(const dttmm_step& step, const double* loads);
    bool expect(const dttmm_motion* nodes);
    void evaluate(const dttmm_motion* trial, double* wrench, double* stiffness) const;
    void commit_step(const dttmm_motion* accepted);
    void discard_step();
    /// After a commit: the mean wrench on the ports over that step; and what stands at its start t_n when the ports have the
    /// velocities of `ports` there, with the wrench on them at that instant. outputs() are of the latter;
    /// without it, of ports that have the means of their velocities over the two steps around t_n.
    void mean_wrench(double* wrench) const;
    void stand(const dttmm_motion* ports, double* wrench) const;

    size_t state_size() const;
    void save_state(void* buffer, size_t size) const;
    void restore_state(const void* buffer, size_t size);

    const std::vector<dttmm_channel>& channels() const { return channels_; }
    void outputs(double* values) const;

    /// What moves inside; null where everything is joints between bodies and ground.
    const Interior* interior() const { return interior_.get(); }
    const Mechanism& mechanism() const { return mechanism_; }

private:
    std::vector<dttmm_motion> at_centres(const dttmm_motion* nodes) const;
    void look(const dttmm_motion* nodes) const;
    void refer_wrench(size_t port, FrameView at, double* wrench) const;
    void refer_matrix(size_t port, FrameView at, double* matrix) const;
    std::span<const FrameView> trial_ports() const;
    FrameView seen(int frame, const dttmm_motion* ports) const {
        if (frame < port_count()) return ports[frame];
        return mechanism_.frame(frame);
    }
    Twist velocity(int frame, const dttmm_motion* ports) const {
        return frame < port_count() ? twist(ports[frame]) : Twist{};
    }
    FrameView trial(int frame) const {
        if (frame >= port_count()) return mechanism_.frame(frame);
        const Port& port = ports_[static_cast<size_t>(frame)];
        return {port.centre.data(), port.rotation};
    }
    void add_wrench(const Joint& joint, const JointForce& force, double* wrench) const;
    void add_stiffness(const Joint& joint, const EndBlocks& blocks, double* stiffness) const;
    void linearise_joints(const dttmm_motion* ports, double* wrench, double* stiffness, double* damping) const;
    void evaluate_joints(double* wrench, double* stiffness) const;
    void evaluate_linear_joints(double* wrench, double* stiffness) const;
    void evaluate_joints_with_laws(double* wrench, double* stiffness) const;
    bool laws_follow_prediction();
    void add_joint_stiffness(size_t joint, Ends at, double* stiffness) const;
    void start_joints(const dttmm_motion* ports, const double* accelerations);
    void commit_joints();

    void declare_channels(const dttmm_network& description);
    void declare(const std::string& name, const char* unit, uint32_t of, uint32_t index, uint32_t role);
    void declare_vectors(const std::string& prefix, std::initializer_list<std::pair<const char*, const char*>> vectors,
                         uint32_t of, uint32_t index, uint32_t role);
    Twist velocity_at_start(int frame) const;
    Vector6 rate_at_start(size_t joint) const;
    void find_mean_wrenches() const;
    void stand_by_port_velocities() const;
    void stand_by_centred_velocities() const;
    void write_wrenches(double* wrench) const;
    bool has_limit(int joint) const { return std::isfinite(mechanism_.joints[static_cast<size_t>(joint)].law().most_turn); }
    double* write_joint(double* out, size_t joint) const;
    double* write_chain(double* out, size_t element) const;
    double* write_node(double* out, size_t node) const;
    double* write_energies(double* out, int first, int last) const;

    template <class Self, class Visit>
    static void for_each_state(Self& self, const Visit& visit);

    Mechanism mechanism_;
    std::unique_ptr<Interior> interior_;  ///< none where everything is joints between bodies and ground
    /// A port and the centre of mass of its body where it was last seen, which serves within one call only.
    struct Port {
        Vector3 arm;             ///< from there to the port, its axes [m]
        Vector3 centre;          ///< world [m]
        const double* rotation;  ///< in the memory of the caller
    };
    mutable std::vector<Port> ports_;
    mutable std::vector<FrameView> trial_ports_;
    bool started_ = false, open_ = false;
    bool has_laws_ = false;  ///< a joint is not linear
    /// A direction with a law at the trial last looked at: its deformation, force over the step and gain.
    struct LawLook {
        size_t joint;
        int direction;
        double x, force, gain;
    };
    std::vector<LawLook> law_looks_;
    bool is_first_look_ = false;  ///< nothing was asked of the open step
    // At t_n, the start of the step last committed:
    mutable std::vector<Twist> port_velocities_;
    mutable std::vector<JointPose> poses_;   ///< of the joints
    mutable std::vector<Vector6> forces_;    ///< of them, their axes
    mutable std::vector<Vector6> wrenches_;  ///< on the frames, at their origins, world
    mutable bool stands_ = false;            ///< the above are those of that instant
    mutable bool by_increments_ = false;     ///< the host has not said how the ports move then
    std::vector<Frame> earlier_;             ///< the ports, and the ground behind them, at t_{n−1}
    std::vector<Twist> start_velocities_;    ///< of the ports

    /// A beam or rod as results show it: its joints, its ends and its axes.
    struct ChainView {
        int from_node = 0, to_node = 0;
        Matrix3 from_axes = Matrix3::Identity();  ///< of the element in those of the frame at its `from` end
        Matrix3 to_axes = Matrix3::Identity();    ///< the same at rest in those at its `to` end
        Vector3 rest = Vector3::Zero();           ///< from end to end, axes of the element
    };
    std::vector<ChainView> chains_;  ///< of every element; unused where it has one joint or none
    std::vector<int> shown_nodes_;   ///< nodes with channels
    std::vector<dttmm_channel> channels_;
};

}  // namespace dttmm::plugin
