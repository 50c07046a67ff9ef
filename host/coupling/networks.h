// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "coupling/network_description.h"
#include "loader/network_instance.h"
#include "loader/plugins.h"
#include "model/model.h"
#include "world/world.h"

namespace dttmm::host {

/// All elastic networks of a model as one function of the bodies' motion: body poses in, body wrenches out. It knows where
/// the ports sit on the bodies; the element laws are the plugins'. Wrenches on a body are [force; moment about the centre of
/// mass] in world axes, with the lever arms of t_n.
class Networks {
public:
    using Block = Eigen::Matrix<double, 6, 6>;
    /// Receives −∂(wrench on body row)/∂(pose of body column), world axes, centre of mass.
    using StiffnessSink = std::function<void(int row_body, int column_body, const Block&)>;
    /// Receives the same of one network at one instant, and −∂(wrench)/∂(velocity).
    using LinearSink =
        std::function<void(size_t network, int row_body, int column_body, const Block& stiffness, const Block& damping)>;

    /// Splits the model into networks and creates each in its plugin. Throws Error with the place in the model file when a
    /// plugin refuses one, when one would need two plugins, or when networks of different plugins weight loads differently.
    Networks(const Model& model, const Plugins& plugins);

    /// True if the wrench over a step depends on the end of the step: then the coupling has to solve for it.
    bool is_implicit() const { return is_implicit_; }
    /// How loads are weighted over a step: at its end, at its start, one step before.
    const double* load_weights() const { return weights_; }
    /// Pairs of bodies that share a network.
    const std::vector<std::pair<int, int>>& neighbours() const { return neighbours_; }

    /// The force law at one instant (no time scheme): adds the wrenches of the networks; stiffness and damping are
    /// handed out if wanted.
    void linearise(const std::vector<BodyState>& at, double* wrenches, const LinearSink* sink);
    /// How messages call a network: by its element, `bolt1`, or `network of element "barrel"` if it has several.
    std::string name(size_t network) const;

    /// Initial conditions: poses and velocities at that instant, accelerations 6 per body (linear of the centre of mass,
    /// angular), loads 6 per node of the model.
    void start(const dttmm_step& step, const std::vector<BodyState>& at, const double* accelerations,
               const double* node_loads);

    /// node_loads: 6 per node of the model, at the end of the step.
    void begin_step(const dttmm_step& step, const double* node_loads);
    /// Adds the wrenches that act over the open step if the bodies end it as in `trial`. Throws Error(numerical_failure)
    /// naming element and body when one is not finite or beyond 1e15 N. Unless is_implicit(), `trial` is not looked at;
    /// otherwise the networks are told to expect it first.
    void evaluate(const std::vector<BodyState>& trial, double* wrenches);
    /// The same, and hands out the stiffness of that wrench.
    void evaluate(const std::vector<BodyState>& trial, double* wrenches, const StiffnessSink& stiffness);
    /// The first network whose last answer wants another trial before the step is committed; kNone: none does.
    static constexpr size_t kNone = std::numeric_limits<size_t>::max();
    size_t rough() const { return rough_; }
    void commit_step(const std::vector<BodyState>& accepted);

    /// Whether all plugins tell what stands at an instant.
    bool stand() const { return stand_; }
    /// Adds the mean wrenches over the step last committed, which began with the bodies at `at`. Only if stand().
    void add_mean_wrenches(const std::vector<BodyState>& at, double* wrenches);
    /// Adds the wrenches at the start of that step, when the bodies have the poses and velocities of `at` there; outputs are
    /// then of that instant. Only if stand().
    void stand_at(const std::vector<BodyState>& at, double* wrenches);

    const std::vector<NetworkInstance>& instances() const { return instances_; }
    /// Results of all networks, one after the other, at the start of the step last committed. Throws Error(plugin_failure)
    /// for one that is not finite, and as refuse_changed_arithmetic() does.
    void outputs(double* values) const;
    size_t output_count() const;

private:
    /// A marker on a body that a network is attached to.
    struct Port {
        int body;
        Eigen::Vector3d arm;       ///< from the centre of mass, body axes [m]
        bool turned;               ///< the marker's axes are not the body's
        Eigen::Matrix3d rotation;  ///< marker axes in body axes
    };
    /// Where a network's ports, its wrenches and its inner nodes begin in the arrays below.
    struct Slot {
        size_t port, wrench, inner_node;
        bool is_loaded;  ///< on an inner node
    };

    void add_network(const Model& model, const Plugins& plugins, const std::vector<size_t>& elements,
                     const std::vector<bool>& is_loaded);
    template <class Action>
    void tell_place(size_t network, Action&& action) const;
    template <class Action>
    static void tell_time(double time, Action&& action);
    const double* gather_loads(size_t network, const double* node_loads);
    Port port_at(const Model& model, const NetworkDescription::Port& port) const;
    void gather(const std::vector<BodyState>& motion, double step_size);
    void scatter(size_t network, double* wrenches) const;
    int body_of(size_t network, int port) const { return ports_[slots_[network].port + static_cast<size_t>(port)].body; }
    Block seen_from_bodies(size_t network, const std::vector<double>& port_matrix, int row, int column) const;
    void hand_out(size_t network, const std::vector<double>& port_stiffness, const StiffnessSink& sink) const;
    void check_guards(size_t network, const double* begin, const double* end, const char* array) const;
    double* make_room(size_t network, std::vector<double>& matrix) const;
    void check_matrix(size_t network, const std::vector<double>& matrix, const char* name) const;
    [[noreturn]] void refuse_wrench(size_t network, size_t port) const;
    void refuse_mixed_weights() const;

    std::vector<NetworkInstance> instances_;
    std::vector<Slot> slots_;
    std::vector<Port> ports_;
    std::vector<size_t> inner_nodes_;               ///< indices into Model::nodes
    std::vector<std::vector<std::string>> places_;  ///< in the model file, of the elements of every network
    std::vector<std::string> body_names_;
    std::vector<std::pair<int, int>> neighbours_;
    double weights_[3] = {0, 1, 0};
    bool is_implicit_ = false, stand_ = true;
    size_t rough_ = kNone;

    double step_size_ = 0;
    double time_ = 0;
    std::vector<dttmm_motion> motions_;       ///< of every port, as last gathered
    std::vector<Eigen::Vector3d> arms_;       ///< of every port from the centre of mass, world axes, at t_n
    std::vector<Eigen::Vector3d> next_arms_;  ///< the same as last gathered
    std::vector<double> wrenches_;            ///< of every port; a guard word before the first network's part and after each
    /// Of the network at hand, the matrices between two guard words.
    std::vector<double> stiffness_, damping_, loads_;
    mutable std::vector<double> outputs_;  ///< of all networks, between two guard words
};

}  // namespace dttmm::host
