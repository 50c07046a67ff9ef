// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "dttmm_plugin.h"
#include "dttmm_support.h"
#include "model/model.h"
#include "world/world.h"

namespace dttmm::host {

/// Numbers of a support's motion, dttmm_support_motion.
inline constexpr size_t kSupportNumbers = sizeof(dttmm_support_motion) / sizeof(double);

/// Gravity and the loads of the model, and the motions of its supports. Over a step a load is weighted as the scheme weights
/// the network's forces,
///     w+ f(t_{n+1}) + w0 f(t_n) + w− f(t_{n−1}),
/// so that both stand at the same instant. Loads on nodes and elements and the weight of what is between the bodies are the
/// networks': they are handed on unweighted.
class Loads {
public:
    Loads(const Model& model, const double weights[3]);

    /// Forgets the past; t0 [s] is the start of the coming step of size h [s]. Over steps of that size supports have their
    /// velocities and accelerations at the start; 0: none.
    void start(double t0, double h = 0);

    /// Moves on to the step that starts at step.time. Before the start a load counts as at the start:
    /// the first step of the centred scheme is Newmark's.
    void begin_step(const dttmm_step& step);

    /// Loads on the networks at the end of the open step; after start, at t0: [force; moment] in world axes, 6 per node of
    /// the model, then [force per length at the `from` end; at the `to` end], 6 per load of the model, zero for the others,
    /// then the motions of supports, kSupportNumbers per node of the model, zero for the others.
    std::span<const double> on_networks() const { return network_loads_; }

    /// Adds the wrench over the open step, [force; moment about the centre of mass] in world axes, 6 per body.
    void add_over_step(const std::vector<BodyState>& now, double* wrenches) const {
        add(now, &Magnitude::over_step, wrenches);
    }

    /// Adds the wrench at the instant t_n that the step starts from.
    void add_at_start(const std::vector<BodyState>& now, double* wrenches) const { add(now, &Magnitude::now, wrenches); }

    /// Adds the mean of the wrenches at the two ends of the open step, with the lever arms of its start.
    void add_mean(const std::vector<BodyState>& now, double* wrenches) const { add(now, &Magnitude::mean, wrenches); }

    /// Work of the loads on bodies (without gravity) over the open step [J], mean load times displacement: exact for
    /// Newmark's rule. `now`: poses at its start; `after`: at its end, with the velocities over it.
    double work_over_step(const std::vector<BodyState>& now, const std::vector<BodyState>& after, double h) const;

private:
    /// Of one load: at t_{n−1}, t_n, t_{n+1}, weighted, and the mean of the last two of these instants [N, N m or N/m].
    struct Magnitude {
        double before = 0, now = 0, after = 0, over_step = 0, mean = 0;
        double after_at_to = 0;  ///< of a force per length [N/m]
    };
    struct Placed {
        Load load;
        Eigen::Vector3d arm;  ///< from the centre of mass, body axes [m]
    };
    void add(const std::vector<BodyState>& now, double Magnitude::*magnitude, double* wrenches) const;
    double magnitude(const Load& load, const Signal& signal, double time) const;
    void find_after(size_t load, double time);
    void gather_network_loads();
    void move_supports(double time);
    void add_rates_of_supports(double t0, double h);
    using Vector6 = Eigen::Matrix<double, 6, 1>;
    Vector6 motion_of(size_t support, double time) const;

    double weights_[3];
    std::vector<Eigen::Vector3d> weight_forces_;  ///< m g of every body [N]
    std::vector<Placed> loads_;
    std::vector<Magnitude> magnitudes_;
    /// A node that moves.
    struct Support {
        size_t node;
        std::string name;
        std::array<std::optional<Signal>, 6> motion;
        std::string place;
    };
    std::vector<Support> supports_;
    size_t node_count_;
    std::vector<double> network_loads_;
};

}  // namespace dttmm::host
