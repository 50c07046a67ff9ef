// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/end_of_step.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/error.h"
#include "model/index.h"
#include "world/iteration.h"

namespace dttmm::host {

EndOfStep::EndOfStep(const Model& model, const Networks& networks, bool have_rigid_loop)
    : equations_(model, networks),
      convergence_(model, networks, equations_.joint_system()),
      joints_(model.joints),
      have_loop_(form_loop(model.joints)),
      have_rigid_loop_(have_rigid_loop),
      singular_(equations_.joint_system(), have_loop_),
      stops_(model.joints.size()),
      wrenches_(6 * model.bodies.size()) {
    for (BodyVectors* list : {&previous_u_, &base_u_, &feedback_}) *list = equations_.u();
}

std::vector<BodyState> EndOfStep::start(double h, const std::vector<BodyState>& at, const BodyVectors& accelerations) {
    trial_ = at;
    if (!joints_.empty()) half_ = at;
    equations_.start(h);
    stops_.start(equations_, at);
    std::vector<BodyState> half_step_back = at;
    for (size_t b = 0; b < at.size(); ++b) {
        const auto& a = accelerations[b];
        half_step_back[b].velocity -= 0.5 * h * a.head<3>();
        half_step_back[b].angular_velocity -= 0.5 * h * a.tail<3>();
        previous_u_[b].head<3>() = half_step_back[b].velocity - h * a.head<3>();
        previous_u_[b].tail<3>() = half_step_back[b].angular_velocity - h * a.tail<3>();
    }
    return half_step_back;
}

void EndOfStep::begin_step(const dttmm_step& step, const std::vector<BodyState>& now, const Loads& loads) {
    open_ = {step.index, step.time};
    stops_.begin_step();
    std::ranges::fill(wrenches_, 0.0);
    loads.add_over_step(now, wrenches_.data());
    equations_.begin_step(now, wrenches_);
    equations_.follow_impact(now, previous_u_, stops_.before());
    for (size_t b = 0; b < now.size(); ++b) {
        Eigen::Matrix<double, 6, 1> before;
        before << now[b].velocity, now[b].angular_velocity;
        equations_.u()[b] = 2 * before - previous_u_[b];
        previous_u_[b] = before;
    }
    convergence_.begin_step(now, equations_);
}

const BodyVectors& EndOfStep::solve(const std::vector<BodyState>& now, Networks& networks) {
    stops_.find(equations_.joint_system(), now);
    if (!find_end(now, networks)) {
        // A stop at a dead centre can hold the joints open: it lets go
        if (!stops_.let_go()) refuse(networks);
        equations_.u() = previous_u_;
        if (!find_end(now, networks)) refuse(networks);
    }
    networks.refuse_large_wrenches();
    if (open_.passes > worst_.passes) worst_ = report();
    singular_.count(open_.time);
    stops_.count(open_.time);
    if (!joints_.empty()) equations_.move(now, equations_.h(), trial_);
    equations_.write_feedback(now, feedback_);
    return feedback_;
}

/// Newton's iteration; false if kMostPassesOfStep are not enough.
bool EndOfStep::find_end(const std::vector<BodyState>& now, Networks& networks) {
    const bool has_joints = !joints_.empty();
    singular_.open();
    if (has_joints) {
        equations_.impulses().setZero();  // what redundant joints share is found anew at every step, and stays small
        linearise_joints(now);
    }
    // A pass finds the multipliers to kProximal only, and that does not show in its own correction: so two with joints.
    int first_trusted = has_joints ? 1 : 0;
    bool has_gone_back = false, has_base = false;
    for (int pass = 0; pass < kMostPassesOfStep; ++pass) {
        if (networks.is_implicit() || has_joints) equations_.move(now, equations_.h(), trial_);
        stiffness_wanted_ = stiffness_wanted_ || has_gone_back;
        if (pass == 0 || networks.is_implicit() || stiffness_wanted_) evaluate(now, networks);
        if (pass == 0 && has_joints) see_singular_position(now, networks);
        // Where springs have kinks, Newton's tangents may lead from one side to the other for ever. It goes back for laws
        // alone, with joints for those between bodies: otherwise four of 4000 stiff random machines fail, whose insides are
        // found slowly.
        const bool parts_done = convergence_.judge_parts(networks);
        const bool may_go_back =
            has_gone_back || (has_joints ? convergence_.waits_for_laws() : networks.have_laws() && !parts_done);
        if (may_go_back && has_base && go_back(now)) {
            has_gone_back = true;
            --pass;  // halving ends where the correction is no longer felt
            continue;
        }
        if (may_go_back) base_u_ = equations_.u();
        equations_.correct(now, trial_, wrenches_);
        if (may_go_back) base_residual_ = equations_.residual(now, base_u_, wrenches_);
        has_base = may_go_back;
        if (has_joints) convergence_.add_rounding(equations_.joint_system(), equations_.matrix(), equations_.impulses());
        const bool done = judge(pass, networks);
        if (!done || pass < first_trusted || !parts_done) continue;
        if (!equations_.joint_system().has_stops()) return true;
        equations_.move(now, equations_.h(), trial_);
        if (!stops_.change(equations_, trial_)) return true;
        linearise_joints(now);
        has_gone_back = has_base = false;  // a stop that lets go takes its impulse along
        first_trusted = pass + 2;
    }
    return false;
}

void EndOfStep::linearise_joints(const std::vector<BodyState>& now) {
    equations_.joint_system().linearise(now, singular_.is_near() ? half_ : now, stops_.now(), singular_.let_go());
    stiffness_wanted_ = true;
}

void EndOfStep::evaluate(const std::vector<BodyState>& now, Networks& networks) {
    std::ranges::fill(wrenches_, 0.0);
    ++passes_;
    ++open_.passes;
    if (!stiffness_wanted_) {
        networks.evaluate(trial_, wrenches_.data());
        return;
    }
    equations_.set_zero();
    const Networks::StiffnessSink add = [this](int row, int column, const BlockMatrix::Block& S) {
        equations_.add_stiffness(row, column, S);
    };
    networks.evaluate(trial_, wrenches_.data(), &add);
    if (!equations_.factor_with_inertia(now)) refuse_matrix(now);
    ++factorisations_;
    ++open_.factorisations;
    stiffness_wanted_ = false;
}

/// Takes the matrix half way near a singular position, and lets go equations of joints that do not decide about the step.
void EndOfStep::see_singular_position(const std::vector<BodyState>& now, Networks& networks) {
    if (!singular_.is_suspected(equations_.matrix(), equations_.factor())) return;
    equations_.move(now, 0.5 * equations_.h(), half_);
    singular_.find(equations_.joint_system(), now, half_, trial_);
    convergence_.divide_rounding(singular_.least());
    if (!singular_.is_near()) return;
    linearise_joints(now);
    evaluate(now, networks);
}

/// If the correction last made has made it worse: half of it. The force is a derivative of an energy, so that a part of
/// Newton's correction small enough makes it better.
bool EndOfStep::go_back(const std::vector<BodyState>& now) {
    BodyVectors& u = equations_.u();
    if (!convergence_.is_felt(u, base_u_) || equations_.residual(now, u, wrenches_) <= base_residual_) return false;
    bool is_moved = false;  // not where the two are neighbouring numbers
    for (size_t b = 0; b < u.size(); ++b) {
        const Eigen::Matrix<double, 6, 1> half = 0.5 * (u[b] + base_u_[b]);
        is_moved = is_moved || half != u[b];
        u[b] = half;
    }
    stiffness_wanted_ = true;
    return is_moved;
}

/// Whether the bodies have converged by this pass. With joints the first correction is that of multipliers from zero, and
/// measures nothing.
bool EndOfStep::judge(int pass, const Networks& networks) {
    const auto judgement = convergence_.judge_bodies(equations_.u(), equations_.correction(), pass > 1 || joints_.empty());
    if (!judgement.is_finite) {
        networks.refuse_large_wrenches();
        fail();
    }
    if (judgement.is_slow) {
        equations_.joint_system().tighten();
        stiffness_wanted_ = true;
    }
    return judgement.is_done;
}

StepReport EndOfStep::report() const {
    StepReport report = open_;
    report.stops = as_int(stops_.number());
    report.residual = equations_.lack();
    convergence_.add_to(report, equations_.correction());
    return report;
}

std::string EndOfStep::waited_for(const StepReport& report, const Networks& networks) const {
    if (report.part >= 0) return networks.whose_part(as_size(report.part));
    return report.body >= 0 ? convergence_.name_of(as_size(report.body)) : "";
}

void EndOfStep::confirm(const std::vector<BodyState>& after) const {
    for (const Joint& joint : joints_)
        for (int body : {joint.first, joint.second}) {
            if (body < 0) continue;
            const auto b = as_size(body);
            Eigen::Matrix<double, 6, 1> difference = equations_.u()[b];
            difference.head<3>() -= after[b].velocity;
            difference.tail<3>() -= after[b].angular_velocity;
            const double off = convergence_.speed(b, difference);
            if (off <= convergence_.tolerance(b, kAgreement)) continue;
            throw Error(ExitCode::numerical_failure,
                        fmt::format("t = {:.9g} s: ODE's joints move body \"{}\" otherwise than predicted, by {:.1e} m/s "
                                    "(joint \"{}\"); {}",
                                    open_.time, convergence_.name(b), off, joint.name,
                                    cure("try a smaller step, or give the lightest body on these joints more mass")));
        }
}

/// What a message advises: near a singular position of joints in a loop, or otherwise.
const char* EndOfStep::cure(const char* otherwise) const {
    return singular_.lets_go() || (singular_.is_near() && have_loop_)
               ? "the joints are near a singular position; an element in place of one joint of the loop passes it"
               : otherwise;
}

void EndOfStep::refuse_matrix(const std::vector<BodyState>& now) const {
    throw Error(
        ExitCode::numerical_failure,
        fmt::format(
            "t = {:.9g} s: the matrix of the end of the step, M + h² S, is singular, first at body "
            "\"{}\": {}",
            open_.time, convergence_.name(equations_.least_held(now)),
            joints_.empty()
                ? "its elements push it away faster than the step follows. Does one give way, past its largest force? "
                  "Otherwise try a smaller step"
                : cure("give the lightest body on its joints more mass, or make it part of its neighbour")));
}

/// Names a part that has not converged, where the bodies have; else the worst body.
void EndOfStep::refuse(const Networks& networks) const {
    networks.refuse_large_wrenches();
    const int part = convergence_.part_not_done();
    if (part < 0) fail();
    throw Error(
        ExitCode::numerical_failure,
        fmt::format("t = {:.9g} s: {}: the motion inside was not found in {} passes (last correction {:.1e} m/s); "
                    "{}",
                    open_.time, networks.whose_part(as_size(part)), open_.passes, convergence_.correction_inside(part),
                    have_rigid_loop_ ? "elements with rigid directions form a closed loop in this model. If the loop is at "
                                       "a singular position, give one of them a stiffness; otherwise try a smaller step"
                                     : "try a smaller step"));
}

void EndOfStep::fail() const {
    const BodyVectors& correction = equations_.correction();
    size_t worst = 0;
    for (size_t b = 1; b < correction.size(); ++b)
        if (!(correction[b].squaredNorm() <= correction[worst].squaredNorm())) worst = b;
    throw Error(
        ExitCode::numerical_failure,
        fmt::format(
            "t = {:.9g} s: the end of the step was not found in {} passes (last correction {:.1e} m/s), worst at {}; {}",
            open_.time, open_.passes, correction[worst].norm(), convergence_.name_of(worst), cure("try a smaller step")));
}

}  // namespace dttmm::host
