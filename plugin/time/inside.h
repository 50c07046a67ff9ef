// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <span>
#include <vector>

#include "core/index.h"
#include "mechanism/loading.h"
#include "mechanism/mechanism.h"
#include "mechanism/momentum.h"
#include "time/instant_balances.h"
#include "time/massless.h"

namespace dttmm::plugin {

/// The frames inside a network, who is next to whom, and how they begin: what stays as it is.
struct InnerFrames {
    bool is_inner(int frame) const { return frame >= driven; }
    /// Index of a frame among the inner ones; and the frame of such an index.
    size_t at(int frame) const { return as_size(frame - driven); }
    size_t frame_of(size_t inner) const { return as_size(driven) + inner; }
    /// From the first inner frame on, of a list of all frames.
    template <class List>
    auto inner(List& of_all) const {
        return std::span(of_all).subspan(as_size(driven));
    }

    int ports, driven, count;  ///< frames that are ports, ports and ground, and inner ones

    // Of every inner frame:
    std::vector<Inertia> inertias;
    std::vector<Matrix3> inverse_moments;  ///< of inertia, axes of the frame; zero where there is none
    std::vector<double> reach;             ///< of its joints from its origin [m], at least its radius of gyration
    std::vector<double> turn_weight;       ///< reach²: makes linear and angular velocity comparable
    std::vector<double> spin_weight;       ///< 1/reach², the same for momentum; 0 where reach is 0
    std::vector<int> receivers;            ///< frame nearby that takes over what a massless one leaves over; −1: none
    std::vector<int> load_of;              ///< index in `loaded`; −1: none

    std::vector<double> port_reach;  ///< the reach of every port
    std::vector<int> port_frames;    ///< the ports, and massless frames whose receivers they are

    std::vector<int> inner_nodes;  ///< of the description
    /// How each of them is to start.
    struct Given {
        bool moves;
        Twist velocity;
    };
    std::vector<Given> given;
    std::vector<size_t> loaded;  ///< inner frames that a load may act on, or with a massless half: the others take no load
};

/// The joints inside a network, sorted by their part in the equations.
struct InnerJoints {
    std::vector<size_t> port_joints;      ///< of the ports
    std::vector<size_t> near_joints;      ///< whose forces the ports feel
    std::vector<int> near_index;          ///< of every joint among them; −1: it is not
    std::vector<size_t> rigid_joints;     ///< with rigid directions
    std::vector<int> rigid_index;         ///< of every joint among them; −1: it has none
    std::vector<size_t> settling_joints;  ///< of massless frames
};

/// How the inside moves and what acts on it, from step to step.
struct InnerMemory {
    PastMotion past;
    std::vector<Vector6> momenta;  ///< of every inner frame over the step before t_n, world
    /// What changes for a frame that a load may act on, or with a massless half.
    struct FrameLoad {
        Vector6 load[3];     ///< at the frame's origin, world, at t_{n+1} once the step is taken, t_n, t_{n−1}
        Vector6 elastic[3];  ///< elastic forces on a massless frame, the same
        Vector6 settled;     ///< ψ of MasslessFrames at t_n, axes of the frame
        FrameLoad() {
            for (Vector6* list : {load, elastic}) std::fill_n(list, 3, Vector6::Zero());
            settled.setZero();
        }
    };
    std::vector<FrameLoad> frame_loads;  ///< of `loaded`
    std::vector<double> rigid;           ///< forces of the rigid directions over the step before t_n
    /// Of the ports over the two steps before, world [m/s, rad/s].
    std::vector<Vector6> port_u, port_u_before;
    struct Record {
        static constexpr bool kStaysOwn = true;  ///< see centring.h
        double load_work = 0;                    ///< of the loads up to t_{n−1} [J]
        double last_work = 0;                    ///< over the step from there to t_n [J]
        double is_slow = 0;                      ///< 1: some step was slow; laws are found together from then on
        double starts_at_rest = 0;               ///< 1: the run has started at rest, in balance
    };
    Record record;

    /// Shows the memory of what changes from step to step, piece by piece, as spans.
    template <class Self, class Visit>
    static void for_each_state(Self& self, const Visit& visit) {
        visit(std::span(self.past.u));
        visit(std::span(self.past.u_before));
        visit(std::span(self.past.velocity));
        visit(std::span(self.past.velocity_before));
        visit(std::span(self.momenta));
        visit(std::span(self.frame_loads));
        visit(std::span(self.rigid));
        visit(std::span(self.port_u));
        visit(std::span(self.port_u_before));
        visit(std::span(&self.record, 1));
    }
};

/// Where the open step is tried to end, and room to work in.
struct InnerTrial {
    std::vector<Frame> trial;     ///< all frames where it is tried to end
    std::vector<double> trial_q;  ///< forces of the rigid directions over it
    std::vector<Vector6> wrench;  ///< over it, on every frame at its origin at t_n, world
    /// Motion of the inner frames over the committed step, in their axes at t_n. InteriorMatrix uses both lists as working
    /// memory before that.
    std::vector<Vector6> motion;
    std::vector<double> motion_q;
};

/// The inside of a network: its frames, its joints, their memory and the trial end of the step. The parts of Interior work
/// on it. Each part says what it changes.
struct Inside : InnerFrames, InnerJoints, InnerMemory, InnerTrial {
    /// Throws Error(DTTMM_ERROR_MODEL) naming a massless node that nothing holds in some direction. Keeps the mechanism.
    Inside(const Mechanism& mechanism, const dttmm_network& description, Loading loading);
    Inside(const Inside&) = delete;  // its balances keep its massless frames
    Inside& operator=(const Inside&) = delete;

    const Mechanism& mechanism;
    MasslessFrames massless;
    InstantBalances balances;  ///< of these
    Loading loading;
    Vector3 gravity;

    double step_size() const { return mechanism.scheme.step_size(); }
    /// Where an inner frame is at t_n.
    FrameView now(size_t inner) const { return mechanism.frames[frame_of(inner)]; }
    /// Index of a joint's i-th rigid direction among all.
    size_t rigid_row(size_t joint, int i) const { return massless.rigid_begin(joint) + as_size(i); }
    /// Forces of a joint's rigid directions, taken from `q`, joint axes.
    Vector6 rigid_values(size_t joint, const std::vector<double>& q) const;
    FrameLoad& frame_load(size_t inner) { return frame_loads[as_size(load_of[inner])]; }
    const FrameLoad& frame_load(size_t inner) const { return frame_loads[as_size(load_of[inner])]; }

    /// Puts the inner frames, moving by u over the step, where it ends, into `trial`.
    void place(std::span<const Vector6> u);
    void place(size_t inner, const Vector6& u);
    /// Room for the steps to come: nothing is allocated later.
    void make_room_for_steps();
    /// Index of the element of the frame that moves most.
    int fastest_element(std::span<const Vector6> u) const;

private:
    void read_nodes(const dttmm_network& description);
    void set_reaches();
    void choose_receivers();
    void choose_near();
    void choose_loaded();
    void make_room();
};

}  // namespace dttmm::plugin
