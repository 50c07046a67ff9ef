// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "coupling/loads.h"
#include "coupling/networks.h"
#include "coupling/rest_equations.h"
#include "model/error.h"
#include "model/model.h"

namespace dttmm::host {

/// A machine at rest.
struct RestState {
    std::vector<BodyState> at;  ///< velocities zero
    int iterations = 0;         ///< in all
    int load_steps = 0;         ///< that were accepted
    double residual = 0;        ///< the largest force that lacks [N]
    double force = 0;           ///< the largest of an element, load or weight [N]
    std::string open;           ///< a joint that is open by more than rounding, and how far; empty: none
    /// The largest rotation of a part from the assembled machine; of a body full turns on its way count too [rad].
    double turn = 0;
    /// The share of the load at which the path of equilibria ends that the machine follows as the load grows from zero; to
    /// 1/1024 of itself. None: the path leads to the whole load, or there is none from the assembled machine.
    std::optional<double> path_ends_at = std::nullopt;
    /// Whether the machine could be followed under a growing load at all, where that was tried.
    bool has_path = true;
    bool is_loaded = true;  ///< by weight or a load
    double noise = 0;       ///< what of a force may be rounding of places [N]

    /// Whether there are forces: without loads those within rounding are none.
    bool has_forces() const { return force > (is_loaded ? 0 : kNoise * noise); }
    /// What lacks, as share of the largest force. Rounding of places by the largest stiffness is a force too.
    double unbalanced() const { return has_forces() ? residual / force : 0; }
    static constexpr double kNoise = 16;  ///< times `noise`: that of one element; some come together at a body
};

/// Finds where a machine rests under its weight and its loads as they are at t0: RestEquations with λ = 1, stops that push
/// or are not reached. Newton's iteration from the assembled machine. The full load is tried at once; where the iteration
/// does not end, in steps of λ that are halved until it does. The resistance grows where a correction would go uphill,
/// towards an equilibrium that does not last, or too far.
class Equilibrium {
public:
    Equilibrium(const Model& model, Networks& networks, Loads& loads);

    /// t0 [s]. Throws Error(numerical_failure) with the largest λ that has an equilibrium, and what moves on beyond it.
    /// Afterwards the networks can start at rest there.
    const RestState& find(double t0);

    // Of the machine at rest: what its loads add to the stiffness as their lever arms turn, 36 per body; and the forces of
    // ideal joints, 144 per joint by the motion of [first; second body], row-major.
    std::vector<double> load_stiffness() const { return equations_.load_stiffness(); }
    std::vector<double> joint_stiffness() { return equations_.joint_stiffness(); }
    /// How the force and moment of a joint on its first body, in the axes of that body, change while its reactions keep
    /// their size: by small motions of [first; second] body at their centres of mass, world axes.
    Eigen::Matrix<double, 6, 12> joint_turning(size_t joint) const { return equations_.joint_turning(joint); }
    const std::vector<Stop>& stops() const { return equations_.stops(); }

private:
    struct Attempt {
        bool is_converged = false;
        double correction = 0;        ///< the last one [m]
        double way = 0;               ///< of all corrections together [m]
        std::string mover;            ///< what it moves most
        RestingJoints::Opening open;  ///< of joints, where nothing moves any longer
    };
    enum class Steps { any, smooth };  ///< smooth: to the equilibrium that the growing load leads to, not to another one
    void search(double t0);
    bool descend(double t0);
    std::optional<Error> accept(const Attempt& attempt);
    double follow(double t0);
    void begin(double t0);
    double raise_load(double t0, Steps steps, double done);
    bool pass_kink(double done, double step);
    std::string describe(const RestingJoints::Opening& open) const;
    Attempt iterate(double factor, int most_iterations);
    RestEquations::Correction correct();
    double bend() const { return equations_.balance().bend; }

    const Model& model_;
    bool has_elements_;
    RestEquations equations_;
    RestState state_;
    double resistance_ = 0;
    double farthest_ = 0;   ///< that one correction may move something [m]
    double most_bend_ = 0;  ///< that one correction may move the ends of a joint, as share of what its law holds up to
    bool bends_ = false;    ///< a correction moves them: there are joints whose laws hold up to something
    bool falls_ = false;    ///< inside a network a motion grows from where the last correction began
    Steps steps_ = Steps::any;
    bool is_smooth_ = true;  ///< no correction since begin() may have jumped
};

}  // namespace dttmm::host
