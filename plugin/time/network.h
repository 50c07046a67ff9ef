// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "core/centring.h"
#include "dttmm_plugin.h"
#include "mechanism/mechanism.h"
#include "mechanism/port_bodies.h"
#include "statics/static_network.h"
#include "time/body_joints.h"
#include "time/instant.h"
#include "time/interior.h"
#include "time/network_results.h"
#include "time/port_blocks.h"

namespace dttmm::plugin {

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
    Network(const Network&) = delete;  // its parts keep each other
    Network& operator=(const Network&) = delete;

    int port_count() const { return mechanism_.assembly.port_count; }
    const Places& places() const { return places_; }
    bool is_implicit() const { return mechanism_.scheme.is_implicit(); }
    void load_weights(double weights[3]) const;

    /// The blocks of its matrices.
    PortBlocks& blocks() { return blocks_; }
    const PortBlocks& blocks() const { return blocks_; }

    void linearise(const dttmm_motion* bodies, double* wrench, double* stiffness, double* damping) const;
    /// u K u and u C u of its elements for a small motion of the bodies from where they start.
    void take_up(const double* motion, double* elastic, double* damped) const;
    /// loads: on its own inner nodes and lines; NULL: none.
    void start(const dttmm_step& step, const dttmm_motion* bodies, const double* accelerations, const double* loads);
    void begin_step(const dttmm_step& step, const double* loads);
    /// Whether it finds a motion of its own, or has laws: then iterate() comes before every evaluate().
    bool iterates() const { return interior_ || has_laws_; }
    void iterate(const dttmm_motion* trial, dttmm_progress& progress);
    void evaluate(const dttmm_motion* trial, double* wrench, double* stiffness) const;
    void commit_step(const dttmm_motion* accepted);
    void discard_step();
    /// After a commit: the mean wrench on the bodies over that step; and what stands at its start t_n when they have the
    /// velocities of `bodies` there, with the wrench on them at that instant. outputs() are of the latter; without it, of
    /// bodies that have the means of their velocities over the two steps around t_n.
    void mean_wrench(double* wrench) const;
    void stand(const dttmm_motion* bodies, const double* accelerations, double* wrench) const;
    bool has_rigid_directions() const { return interior_ && interior_->has_rigid_directions(); }
    /// See Instant.
    void take_rates_by_increments() { instant_.take_rates_by_increments(); }
    /// Adds what of the mean wrench stems from rigid directions: their forces at the start of that step.
    void add_rigid_wrenches(double* wrench) const { instant_.add_rigid_wrenches(wrench); }
    void add_turned_dampers(double* wrench) const { instant_.add_turned_dampers(wrench); }

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

    const std::vector<dttmm_channel>& channels() const { return results_.channels(); }
    /// Its channels, and where its lines are.
    NetworkResults& results() { return results_; }
    const NetworkResults& results() const { return results_; }
    void outputs(double* values) const;
    /// See NetworkResults; at the instant of outputs().
    double* write_lines(uint32_t stations, double* positions) const;

    /// What moves inside; null where everything is joints between bodies and ground.
    const Interior* interior() const { return interior_.get(); }
    const Mechanism& mechanism() const { return mechanism_; }

private:
    Ports ports(const dttmm_motion* bodies) const { return bodies_.ports(bodies); }
    std::unique_ptr<Interior> make_interior(const dttmm_network& description);
    void begin(const dttmm_step& step, const dttmm_motion* bodies, const double* accelerations, const double* loads,
               const std::vector<Frame>* at_rest);
    void require_committed(const char* what) const;
    void require_between_steps(const char* what) const;

    template <class Self, class Visit>
    static void for_each_state(Self& self, const Visit& visit);
    static Centring centring(Network& above, Network& below, const Network& middle);
    void refuse_rough_memory() const;

    Places places_;
    Mechanism mechanism_;
    PortBodies bodies_;
    Loading loading_;
    std::unique_ptr<Interior> interior_;  ///< none where everything is joints between bodies and ground
    PortBlocks blocks_;
    std::unique_ptr<BodyJoints> joints_;  ///< if there is no interior
    bool has_laws_ = false, started_ = false, is_open_ = false;
    std::unique_ptr<StaticNetwork> statics_;  ///< since begin_statics()

    std::vector<Frame> earlier_;           ///< the ports, and the ground behind them, at t_{n−1}
    std::vector<Twist> start_velocities_;  ///< of the ports
    mutable Instant instant_;              ///< mutable: outputs() finds it where the host has not asked for it
    NetworkResults results_;
    mutable std::vector<double> dense_;  ///< working memory, so mutable: the stiffness of an interior
};

}  // namespace dttmm::plugin
