// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <memory>
#include <memory_resource>
#include <span>
#include <string>
#include <vector>

#include "core/centring.h"
#include "core/index.h"
#include "dttmm_plugin.h"
#include "mechanism/mechanism.h"
#include "statics/static_network.h"
#include "time/interior.h"

namespace dttmm::plugin {

/// Where the parts of a network stand in the arrays of the host, which has all bodies and all elements.
struct Places {
    std::vector<uint32_t> bodies, nodes, elements;
    /// Of its nodes: the body of the network that moves their fixed directions; −1: the ground holds them. Empty: all of
    /// them.
    std::vector<int> supported_by = {};
};

/// A set of elements between bodies (its ports) and the ground, solved together at every step. It owns the memory of the
/// time scheme; the bodies' motion comes from the host. Bodies, lumps and nodes may turn as they like, deformations are
/// small: every joint measures its own in axes that go with it, and the wrenches on its two ends balance exactly, lever arms
/// included, at every instant. Frames stand at the centres of mass: under Newmark's rule momentum is then kept to rounding
/// and, but for dampers and rigid directions, angular momentum (Interior::newmark_momentum).
///
/// Elements between bodies only are joints side by side. What else moves, nodes and the masses of beams, is solved for
/// inside (Interior), in time linear in the number of elements.
///
/// The phases, units and frames are those of dttmm_plugin.h; errors are thrown as Error, with the element's index in the
/// description. Bodies are those of the host, 6 numbers per body; wrenches and matrices are added to what is there.
class Network {
public:
    /// Of all bodies, or of those at the places given.
    explicit Network(const dttmm_network& description);
    Network(const dttmm_network& description, Places places);
    Network(const Network&) = delete;  // what is inside keeps its mechanism
    Network& operator=(const Network&) = delete;

    int port_count() const { return mechanism_.assembly.port_count; }
    const Places& places() const { return places_; }
    bool is_implicit() const { return mechanism_.scheme.is_implicit(); }
    void load_weights(double weights[3]) const;

    /// The blocks of its matrices; where each is in the lists of the host, in their order at first.
    std::span<const dttmm_block> blocks() const { return blocks_.list; }
    void place_block(size_t block, size_t at) { blocks_.places[block] = at; }

    void linearise(const dttmm_motion* bodies, double* wrench, double* stiffness, double* damping) const;
    /// u K u and u C u of its elements for a small motion of the bodies from where they start.
    void take_up(const double* motion, double* elastic, double* damped) const;
    /// loads: on its own inner nodes and lines; NULL: none.
    void start(const dttmm_step& step, const dttmm_motion* bodies, const double* accelerations, const double* loads);
    void begin_step(const dttmm_step& step, const double* loads);
    /// Whether it finds a motion of its own, or has laws: then iterate() comes before every evaluate().
    bool iterates() const { return interior_ || !joints_with_laws_.empty(); }
    void iterate(const dttmm_motion* trial, dttmm_progress& progress);
    void evaluate(const dttmm_motion* trial, double* wrench, double* stiffness) const;
    void commit_step(const dttmm_motion* accepted);
    void discard_step();
    /// After a commit: the mean wrench on the bodies over that step; and what stands at its start t_n when they have the
    /// velocities of `bodies` there, with the wrench on them at that instant. outputs() are of the latter; without it, of
    /// bodies that have the means of their velocities over the two steps around t_n.
    void mean_wrench(double* wrench) const;
    void stand(const dttmm_motion* bodies, const double* accelerations, double* wrench) const;
    /// Adds what of the mean wrench stems from rigid directions: their forces at the start of that step.
    void add_rigid_wrenches(double* wrench) const;

    // At rest, see dttmm_static.h
    void begin_statics();
    StaticNetwork& statics();
    const std::vector<double>& static_loads() const { return statics_->loads(); }
    void form_static(const dttmm_motion* bodies, double resistance, double* wrench, double* stiffness);
    StaticNetwork::Measure correct_static(const double* change);
    StaticNetwork::Measure move_static(const dttmm_motion* bodies, double share, double* wrench);
    /// Adds its elements, held nodes and loads, by their places in the description of the whole.
    void write_rest(AtRest& rest) const;
    void start_at_rest(const dttmm_step& step, const dttmm_motion* bodies, const double* loads);

    size_t state_size() const;
    void save_state(void* buffer, size_t size) const;
    void restore_state(const void* buffer, size_t size);
    /// See dttmm_derivative.h. Throws where centre() cannot be done.
    static void refuse_centre(Network& above, Network& below, const Network& middle);
    static void centre(Network& above, Network& below, const Network& middle);

    const std::vector<dttmm_channel>& channels() const { return results_.channels; }
    /// Its channels in pieces: of each element, then all others; and where each begins among the outputs, at first one after
    /// the other.
    size_t piece_count() const { return results_.places.size(); }
    std::span<const dttmm_channel> piece(size_t piece) const {
        return std::span(results_.channels)
            .subspan(results_.piece_begin[piece], results_.piece_begin[piece + 1] - results_.piece_begin[piece]);
    }
    void place_outputs(size_t piece, size_t at) { results_.places[piece] = at; }
    /// Where another has them; their names stay.
    void forget_channels() { std::vector<dttmm_channel>().swap(results_.channels); }
    void outputs(double* values) const;
    /// Its elements of several joints, which bend between their ends.
    std::vector<uint32_t> lines() const;
    /// Where `stations` equally spaced points of each are, ends included, at the instant of outputs() [m, world]. Returns
    /// the end of the positions.
    double* write_lines(uint32_t stations, double* positions) const;

    /// What moves inside; null where everything is joints between bodies and ground.
    const Interior* interior() const { return interior_.get(); }
    const Mechanism& mechanism() const { return mechanism_; }

private:
    Ports ports(const dttmm_motion* bodies) const { return {bodies, places_.bodies.data()}; }
    FrameView seen(int frame, const dttmm_motion* bodies) const {
        if (frame < port_count()) return bodies[places_.bodies[as_size(frame)]];
        return mechanism_.frame(frame);
    }
    Ends seen(const Joint& joint, const dttmm_motion* bodies) const {
        return {seen(joint.from(), bodies), seen(joint.to(), bodies)};
    }
    Twist velocity(int frame, const dttmm_motion* bodies) const {
        return frame < port_count() ? ports(bodies).twist(frame) : Twist{};
    }
    Twist acceleration(int frame, const double* of_bodies) const {
        if (frame >= port_count()) return {};
        const double* a = of_bodies + 6 * places_.bodies[as_size(frame)];
        return {Eigen::Map<const Vector3>(a), Eigen::Map<const Vector3>(a + 3)};
    }
    double* on_body(int frame, double* wrench) const {
        return frame < port_count() ? wrench + 6 * places_.bodies[as_size(frame)] : nullptr;
    }
    void add_wrench(const Joint& joint, const JointForce& force, double* wrench) const {
        Joint::add_wrench(force, on_body(joint.from(), wrench), on_body(joint.to(), wrench));
    }
    void choose_blocks();
    void add_stiffness(size_t joint, const EndBlocks& blocks, double* stiffness) const;
    void add_dense(const double* matrix, double* stiffness) const;
    void linearise_joints(const dttmm_motion* bodies, double* wrench, double* stiffness, double* damping) const;
    void evaluate_joints(const dttmm_motion* bodies, double* wrench, double* stiffness) const;
    void evaluate_linear_joints(const dttmm_motion* bodies, double* wrench, double* stiffness) const;
    void evaluate_joints_with_laws(const dttmm_motion* bodies, double* wrench, double* stiffness) const;
    double find_worst_prediction(const dttmm_motion* bodies);
    void add_joint_stiffness(size_t joint, Ends at, double* stiffness) const;
    void begin(const dttmm_step& step, const dttmm_motion* bodies, const double* accelerations, const double* loads,
               const std::vector<Frame>* at_rest);
    void start_joints(const dttmm_motion* bodies, const double* accelerations);
    void commit_joints(const dttmm_motion* bodies);

    void declare_channels(const dttmm_network& description);
    void declare_inner(const dttmm_network& description);
    void declare_reactions(const dttmm_network& description);
    void declare(const std::string& name, const char* unit, uint32_t of, uint32_t index, uint32_t role);
    void declare_vectors(const std::string& prefix, std::initializer_list<std::pair<const char*, const char*>> vectors,
                         uint32_t of, uint32_t index, uint32_t role);
    Twist velocity_at_start(int frame) const;
    Vector6 rate_at_start(size_t joint) const;
    void find_mean_wrenches() const;
    void find_forces() const;
    void stand_by_port_velocities() const;
    void stand_by_centred_velocities() const;
    void add_wrenches(double* wrench) const;
    bool has_limit(int joint) const { return std::isfinite(mechanism_.joints[as_size(joint)].law().most_turn); }
    struct ChainView;
    struct ReactionView;
    double* write_reaction(double* out, const ReactionView& reaction) const;
    double* write_joint(double* out, size_t joint) const;
    double* write_chain(double* out, size_t element, const ChainView& chain) const;
    double* write_node(double* out, size_t node) const;
    Vector3 section_position(size_t element, const ChainView& chain, int section) const;
    double* write_energies(double* out, int first, int last) const;

    template <class Self, class Visit>
    static void for_each_state(Self& self, const Visit& visit);
    static Centring centring(Network& above, Network& below, const Network& middle);
    void refuse_rough_memory() const;

    Places places_;
    Mechanism mechanism_;
    Loading loading_;
    std::unique_ptr<Interior> interior_;  ///< none where everything is joints between bodies and ground
    bool started_ = false, is_open_ = false;

    /// The blocks of its matrices.
    struct Blocks {
        std::vector<dttmm_block> list;
        std::vector<size_t> places;  ///< in the lists of the host
        struct OfJoint {
            int at[2][2];
        };
        std::vector<OfJoint> of_joints;     ///< of each joint in `list`, −1: none; if there is no interior
        mutable std::vector<double> dense;  ///< working memory, so mutable: the stiffness of an interior
    };
    Blocks blocks_;

    std::vector<size_t> linear_joints_, joints_with_laws_;
    /// A direction with a law at the trial last looked at: its deformation, force over the step and gain.
    struct LawLook {
        size_t joint;
        int direction;
        double x, force, gain;
    };
    std::vector<LawLook> law_looks_;

    std::unique_ptr<StaticNetwork> statics_;  ///< since begin_statics()

    std::vector<Frame> earlier_;           ///< the ports, and the ground behind them, at t_{n−1}
    std::vector<Twist> start_velocities_;  ///< of the ports
    /// What stands at t_n, the start of the step last committed.
    struct Instant {
        std::vector<Twist> port_velocities;
        std::vector<Vector6> forces;    ///< of them, their axes
        std::vector<Vector6> wrenches;  ///< on the frames, at their origins, world
        bool is_known = false;
        bool by_increments = false;  ///< the host has not said how the ports move then
    };
    mutable Instant instant_;  ///< mutable: outputs() finds it where the host has not asked for it

    /// A beam or rod as results show it: its joints, its ends and its axes.
    struct ChainView {
        int from_node = 0, to_node = 0;
        Matrix3 from_axes = Matrix3::Identity();  ///< of the element in those of the frame at its `from` end
        Matrix3 to_axes = Matrix3::Identity();    ///< the same at rest in those at its `to` end
        Vector3 rest = Vector3::Zero();           ///< from end to end, axes of the element
        SectionModuli moduli;
    };
    /// A node with fixed directions as results show it.
    struct ReactionView {
        int node, frame;  ///< frame: of what holds it
        bool has_force, has_moment;
        bool has_place;  ///< nothing but its support moves it
    };
    struct Results {
        std::vector<ReactionView> reactions;
        std::vector<ChainView> chains;  ///< of the elements with several joints
        std::vector<int> nodes;         ///< with channels
        std::vector<dttmm_channel> channels;
        /// Of channels: a long beam has 10^5.
        std::unique_ptr<std::pmr::monotonic_buffer_resource> names = std::make_unique<std::pmr::monotonic_buffer_resource>();
        std::vector<size_t> piece_begin, places;
    };
    Results results_;
};

}  // namespace dttmm::plugin
