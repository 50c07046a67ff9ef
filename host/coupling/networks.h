// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "coupling/network_exchange.h"
#include "loader/plugins.h"
#include "model/model.h"
#include "world/world.h"

namespace dttmm::host {

/// All elements of a model as one function of the bodies' motion: poses in, wrenches out. The element laws are the plugins',
/// each of which has all of its elements in one instance. Wrenches on a body are [force; moment about the centre of mass] in
/// world axes.
class Networks {
public:
    using Block = Eigen::Matrix<double, 6, 6>;
    /// Receives −∂(wrench on body row)/∂(pose of body column), world axes, centre of mass.
    using StiffnessSink = std::function<void(int row_body, int column_body, const Block&)>;
    /// Receives the same at one instant, and −∂(wrench)/∂(velocity).
    using LinearSink = std::function<void(int row_body, int column_body, const Block& stiffness, const Block& damping)>;

    /// Creates the instances. The model must outlive them. Throws Error with the place in the model file when a plugin
    /// refuses an element, when a node joins elements of two plugins, or when plugins weight loads differently.
    Networks(const Model& model, const Plugins& plugins);

    /// True if the wrench over a step depends on the end of the step: then the coupling has to solve for it.
    bool is_implicit() const { return is_implicit_; }
    /// How loads are weighted over a step: at its end, at its start, one step before.
    const double* load_weights() const { return weights_; }
    /// Pairs of bodies whose wrenches hang on each other's motion.
    const std::vector<std::pair<int, int>>& neighbours() const { return neighbours_; }

    /// The force law at one instant (no time scheme): adds the wrenches; stiffness and damping are handed out if wanted.
    void linearise(const std::vector<BodyState>& at, double* wrenches, const LinearSink* sink);
    /// What elements take up in a small motion from the start, 6 per body: u K u and u C u.
    struct TakenUp {
        std::string element;  ///< its name; of a plugin that does not tell them apart, what all of its elements are called
        double elastic, damped;
    };
    std::vector<TakenUp> take_up(const std::vector<BodyState>& at, const double* motion);

    /// Initial conditions: poses and velocities at that instant, accelerations 6 per body (linear of the centre of mass,
    /// angular), loads as Loads::on_networks() has them.
    void start(const dttmm_step& step, const std::vector<BodyState>& at, const double* accelerations, const double* loads);

    /// loads: the same, at the end of the step.
    void begin_step(const dttmm_step& step, const double* loads);
    /// Adds the wrenches that act over the open step if the bodies end it as in `trial`. Throws Error(numerical_failure)
    /// naming element and body when one is not finite or beyond 1e15 N. Unless is_implicit(), `trial` is not looked at;
    /// otherwise the plugins' parts iterate before. stiffness: if given, receives that of the wrenches.
    void evaluate(const std::vector<BodyState>& trial, double* wrenches, const StiffnessSink* stiffness = nullptr);
    /// Throws Error(numerical_failure) if a wrench of the last evaluation was beyond 1e15 N. During an iteration it may be.
    void refuse_large_wrenches() const { exchange_.refuse_large(); }
    /// Of all parts of the plugins that find a motion of their own, how far the last evaluation has brought them.
    const std::vector<dttmm_progress>& progress() const { return progress_; }
    /// Whose part it is: `element "bolt1" (plugin ..)`.
    std::string whose_part(size_t part) const;
    void commit_step(const std::vector<BodyState>& accepted);

    // At rest, see dttmm_static.h.

    /// Back to the assembled machine. Throws Error(plugin_failure) for a plugin that knows no statics.
    void begin_statics();
    void keep_statics();
    void recall_statics();
    void set_static_loads(const Eigen::Vector3d& gravity, const double* node_loads);
    /// Adds the condensed wrenches of the equations formed at these poses, and hands out their stiffness.
    void form_static(const std::vector<BodyState>& at, double resistance, double* wrenches, const StiffnessSink& sink);
    /// Of all networks; element: its name, or none.
    struct StaticMeasure {
        double work = 0, residual = 0, force = 0, noise = 0, shift = 0, turn = 0, bend = 0;
        int falling = 0;
        std::string element;
    };
    StaticMeasure correct_static(const double* change);
    StaticMeasure move_static(const std::vector<BodyState>& at, double share, double* wrenches);
    void start_at_rest(const dttmm_step& step, const std::vector<BodyState>& at, const double* node_loads);

    /// Moves the states of two that differ from this one in numbers only to equal distances from its own: see
    /// dttmm_derivative.h. Between steps. Throws Error(plugin_failure) with the place where a plugin or an element knows no
    /// such state.
    void centre(Networks& above, Networks& below) const;

    /// Whether all plugins tell what stands at an instant.
    bool stand() const { return stand_; }
    /// Whether an element has a law that is not linear.
    bool have_laws() const { return have_laws_; }
    /// Adds the mean wrenches over the step last committed. Only if stand().
    void add_mean_wrenches(double* wrenches);
    /// Adds the wrenches at the start of that step, when the bodies have the poses and velocities of `at` there; outputs are
    /// then of that instant. accelerations: of the bodies there, 6 each; null: not known. Only if stand().
    void stand_at(const std::vector<BodyState>& at, const double* accelerations, double* wrenches);

    const std::vector<NetworkInstance>& instances() const { return exchange_.instances(); }
    /// Results of all elements, plugin after plugin, at the start of the step last committed. Throws Error(plugin_failure)
    /// for one that is not finite, and as refuse_changed_arithmetic() does.
    void outputs(double* values) const;
    size_t output_count() const;
    /// Channels of all instances but those of energies stand first among `others` too: see NetworkInstance.
    void share_channels(std::span<const Channel> others);
    /// From now on positions() tells of `stations` points of every element that bends.
    void watch_lines(uint32_t stations);
    /// Where they are, at the same instant [m, world]: 3 numbers per point, instance after instance, in the order of lines()
    /// of each. Returns the end. Throws as outputs() does.
    double* positions(double* values) const;

private:
    void take_weights();

    NetworkExchange exchange_;
    std::vector<std::pair<int, int>> neighbours_;
    double weights_[3] = {0, 1, 0};
    bool is_implicit_ = false, stand_ = true, have_laws_ = false;
    std::vector<dttmm_progress> progress_;
    std::vector<size_t> first_part_;  ///< of every instance

    double step_size_ = 0;
    // Plugins write here in calls that change nothing else, so mutable:
    mutable GuardedArray numbers_;                 ///< blocks or outputs of the instance at hand
    mutable std::vector<GuardedArray> positions_;  ///< of every instance, where lines are watched
    uint32_t stations_ = 0;
};

}  // namespace dttmm::host
