// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <vector>

#include "dttmm_plugin.h"
#include "model/model.h"
#include "world/world.h"

namespace dttmm::host {

/// Gravity and the loads of the model. Over a step a load is weighted as the scheme weights the network's forces,
///     w+ f(t_{n+1}) + w0 f(t_n) + w− f(t_{n−1}),
/// so that both stand at the same instant. Loads on nodes and the weight of what is between the bodies are the networks':
/// they are handed on unweighted.
class Loads {
public:
    Loads(const Model& model, const double weights[3]);

    /// Forgets the past; t0 [s] is the start of the coming step.
    void start(double t0);

    /// Moves on to the step that starts at step.time. Before the start a load counts as at the start:
    /// the first step of the centred scheme is Newmark's.
    void begin_step(const dttmm_step& step);

    /// Loads on the nodes, [force; moment] in world axes, 6 per node of the model: at the end of the open step; after start,
    /// at t0.
    const double* on_nodes() const { return node_loads_.data(); }

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
    /// Of one load: at t_{n−1}, t_n, t_{n+1}, weighted, and the mean of the last two of these instants [N or N m].
    struct Magnitude {
        double before = 0, now = 0, after = 0, over_step = 0, mean = 0;
    };
    struct Placed {
        Load load;
        Eigen::Vector3d arm;  ///< from the centre of mass, body axes [m]
    };
    void add(const std::vector<BodyState>& now, double Magnitude::*magnitude, double* wrenches) const;
    double magnitude(size_t load, double time) const;
    void gather_node_loads();

    double weights_[3];
    std::vector<Eigen::Vector3d> weight_forces_;  ///< m g of every body [N]
    std::vector<Placed> loads_;
    std::vector<Magnitude> magnitudes_;
    std::vector<double> node_loads_;
};

}  // namespace dttmm::host
