// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "coupling/networks.h"
#include "coupling/newton_convergence.h"
#include "coupling/step_equations.h"
#include "coupling/step_report.h"
#include "model/model.h"
#include "world/block_matrix.h"
#include "world/body_state.h"
#include "world/joint_system.h"

namespace dttmm::host {

/// Judges whether Newton's iteration has found a step: every group of bodies that elements and joints connect, and every
/// part of the plugins, by a NewtonConvergence of its own. Speeds are the largest of a point of a body, at most [m/s]; u, a
/// change of it and a correction are [v; ω] per body.
class StepConvergence {
public:
    StepConvergence(const Model& model, const Networks& networks, const JointSystem& joints);

    /// Opens a step. now: poses at t_n; equations: with the first trial.
    void begin_step(const std::vector<BodyState>& now, const StepEquations& equations);

    /// Takes the impulses q of a pass: a light body between heavy ones passes on impulses whose round-off alone moves it.
    void add_rounding(const JointSystem& joints, const BlockMatrix& matrix, const Eigen::VectorXd& q);
    /// Near a singular position the round-off of poses moves bodies by the inverse of `least`.
    void divide_rounding(double least);

    struct Judgement {
        bool is_finite = true, is_done = true, is_slow = false;
    };
    /// Takes a pass, the first is 0, by its trial and its correction. measures: of the first pass too. Where a correction is
    /// not finite, nothing else is judged.
    Judgement judge_bodies(const BodyVectors& u, const BodyVectors& correction, bool measures);
    /// Takes what the last evaluation tells of the plugins' parts; true if every one may stop.
    bool judge_parts(const Networks& networks);
    /// Then: whether one that may not has laws between bodies.
    bool waits_for_laws() const { return waits_for_laws_; }

    /// Whether a change of u is more than round-off.
    bool is_felt(const BodyVectors& u, const BodyVectors& before) const;
    /// A difference of a body's motion that counts as none, a share of the motion of its group.
    double tolerance(size_t body, double share) const;
    /// The largest speed of a point of the body, at most.
    double speed(size_t body, const Eigen::Matrix<double, 6, 1>& u) const {
        const double reach = bodies_[body].reach;
        return std::sqrt(2 * (u.head<3>().squaredNorm() + reach * reach * u.tail<3>().squaredNorm()));
    }

    /// Adds what the last pass tells: corrections, rate, and what the pass before it was not enough for.
    void add_to(StepReport& report, const BodyVectors& correction) const;
    /// The first part that has not converged, where all bodies have; −1: none.
    int part_not_done() const;
    /// Correction of a part in the last pass.
    double correction_inside(int part) const { return parts_[as_size(part)].progress().correction; }
    const std::string& name(size_t body) const { return bodies_[body].name; }
    /// A body with what holds it: `body "plate" on element "bolt1"`.
    std::string name_of(size_t body) const;

private:
    struct Judged {
        std::string name;
        std::string holder;  ///< an element or a joint that it hangs on; empty if none
        bool is_jointed;     ///< by a joint of ODE
        double mass, least;  ///< [kg]; smallest principal moment of inertia [kg m²]
        double reach;        ///< of its markers and of its mass from the centre of mass [m]
        size_t group;
    };
    /// Connected bodies.
    struct Group {
        double floor = 0;     ///< corrections smaller than this are round-off of the held bodies' positions or of impulses
        double distance = 0;  ///< of the farthest point of a held body from the world's origin [m]
        double share = 0;     ///< of the round-off of positions that appears in velocities: with joints 1
        dttmm_progress progress{};  ///< of the pass at hand
        NewtonConvergence convergence{NewtonConvergence::kBodies};
    };
    int most_corrected(size_t group, const BodyVectors& correction) const;

    std::vector<Judged> bodies_;
    std::vector<Group> groups_;
    std::vector<NewtonConvergence> parts_;
    bool waits_for_laws_ = false;
};

}  // namespace dttmm::host
