// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/end_of_step.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <utility>

#include "model/diagnostics.h"
#include "model/error.h"
#include "model/index.h"
#include "world/rotation_step.h"

namespace dttmm::host {

namespace {

/// What a message says near a singular position of the joints.
constexpr const char* kSingularCure =
    "the joints are near a singular position; an element in place of one joint of the loop passes it";

/// Numbers the groups of bodies that elements connect: group of every body, from 0.
std::vector<size_t> find_groups(size_t count, const std::vector<std::pair<int, int>>& neighbours) {
    std::vector<size_t> group(count);
    std::iota(group.begin(), group.end(), size_t{0});
    const auto root = [&](size_t b) {
        while (group[b] != b) b = group[b] = group[group[b]];
        return b;
    };
    for (const auto& [i, j] : neighbours) group[root(as_size(i))] = root(as_size(j));
    std::map<size_t, size_t> numbers;
    std::vector<size_t> numbered;
    for (size_t b = 0; b < count; ++b) numbered.push_back(numbers.try_emplace(root(b), numbers.size()).first->second);
    return numbered;
}

/// What holds each body, e.g. `element "bolt1"`, or nothing: the forces of elements and joints carry the rounding of the
/// body's position.
std::vector<std::string> find_holders(const Model& model) {
    std::vector<std::string> holders(model.bodies.size());
    const auto hold = [&](int body, const char* kind, const std::string& name) {
        if (body >= 0 && holders[as_size(body)].empty()) holders[as_size(body)] = fmt::format("{} \"{}\"", kind, name);
    };
    for (const Joint& joint : model.joints)
        for (int body : {joint.first, joint.second}) hold(body, "joint", joint.name);
    for (const Element& element : model.elements)
        for (const Attachment& end : element.ends) hold(end.body, "element", element.name);
    return holders;
}

/// Pairs of bodies that share an element or a joint.
std::vector<std::pair<int, int>> find_neighbours(const Model& model, const Networks& networks) {
    std::vector<std::pair<int, int>> neighbours = networks.neighbours();
    for (const Joint& joint : model.joints)
        if (joint.first >= 0 && joint.second >= 0) neighbours.emplace_back(joint.first, joint.second);
    return neighbours;
}

/// Distance from the centre of mass to the farthest marker, at least the largest radius of gyration.
double reach_of(const Body& body) {
    double reach = Inertia(body).gyration_bound();
    for (const Marker& marker : body.markers) reach = std::max(reach, (marker.position - body.center_of_mass).norm());
    return reach;
}

}  // namespace

EndOfStep::EndOfStep(const Model& model, const Networks& networks)
    : descriptions_(model.joints),
      system_(model.bodies, model.joints),
      matrix_(as_int(model.bodies.size()), networks.neighbours(), system_.nodes()),
      factor_(matrix_),
      instant_matrix_(as_int(model.bodies.size()), {}, system_.nodes()),
      instant_factor_(instant_matrix_) {
    const size_t n = model.bodies.size();
    const std::vector<std::string> holders = find_holders(model);
    const std::vector<size_t> group = find_groups(n, find_neighbours(model, networks));
    for (size_t b = 0; b < n; ++b) {
        const Body& body = model.bodies[b];
        const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(body.inertia).eigenvalues()(0);
        const double reach = std::max(reach_of(body), system_.longest_arm(as_int(b)));
        inverse_moments_.push_back(body.inertia.inverse());
        bodies_.push_back({Inertia(body), body.name, holders[b], least, reach, group[b]});
    }
    groups_.resize(n == 0 ? 0 : 1 + *std::max_element(group.begin(), group.end()));
    parts_.assign(networks.progress().size(), NewtonConvergence(NewtonConvergence::kInside));
    for (auto* list : {&u_, &previous_u_, &base_u_, &correction_, &free_momentum_, &feedback_})
        list->assign(n, Vector6::Zero());
    wrenches_.resize(6 * n);
    for (Eigen::VectorXd* list : {&right_hand_side_, &solution_, &multipliers_, &instant_multipliers_})
        list->setZero(matrix_.size());
    joints_turn_ = std::ranges::any_of(
        descriptions_, [](const Joint& joint) { return joint.type != JointType::slider && joint.type != JointType::fixed; });
    for (Eigen::VectorXd* list : {&instant_rows_, &instant_solution_, &proximal_rows_})
        list->setZero(instant_matrix_.size());
    instant_.at.resize(n);
    instant_.accelerations.resize(n);
}

std::vector<BodyState> EndOfStep::start(const dttmm_step& step, const std::vector<BodyState>& at, Networks& networks,
                                        Loads& loads) {
    h_ = step.size;
    time_ = step.time;
    trial_ = half_ = at;
    steps_ = 0;
    stiffness_wanted_ = true;
    std::fill(groups_.begin(), groups_.end(), Group{});
    std::fill(parts_.begin(), parts_.end(), NewtonConvergence(NewtonConvergence::kInside));
    singular_ = {};
    passed_ = {};

    loads.start(step.time);
    std::fill(wrenches_.begin(), wrenches_.end(), 0.0);
    networks.linearise(at, wrenches_.data(), nullptr);
    loads.add_at_start(at, wrenches_.data());
    refuse_opening_joints(at);
    system_.linearise(at, at, std::vector<Stop>(descriptions_.size()));
    factor_instant(at);
    find_accelerations(at);
    start_ = at;
    std::vector<BodyState> half_step_back = at;
    for (size_t b = 0; b < at.size(); ++b) {
        const Vector6& a = instant_.accelerations[b];
        half_step_back[b].velocity -= 0.5 * h_ * a.head<3>();
        half_step_back[b].angular_velocity -= 0.5 * h_ * a.tail<3>();
        previous_u_[b].head<3>() = half_step_back[b].velocity - h_ * a.head<3>();
        previous_u_[b].tail<3>() = half_step_back[b].angular_velocity - h_ * a.tail<3>();
    }
    networks.start(step, at, instant_.accelerations.empty() ? nullptr : instant_.accelerations.front().data(),
                   loads.on_nodes());
    return half_step_back;
}

// ---- What stands at an instant ------------------------------------------------------------------------------------------

/// M and the joints as last linearised. Without joints there is nothing to factor.
void EndOfStep::factor_instant(const std::vector<BodyState>& at) {
    if (system_.empty()) return;
    instant_matrix_.set_zero();
    for (size_t b = 0; b < at.size(); ++b)
        instant_matrix_.add(as_int(b), as_int(b), bodies_[b].inertia.block(at[b].rotation));
    system_.write_start_to(instant_matrix_);
    if (!instant_factor_.factor(instant_matrix_))
        throw Error(
            ExitCode::numerical_failure,
            fmt::format("t = {:.9g} s: the equations of the joints at this instant are singular: very unequal masses "
                        "on joints, or a singular position?",
                        time_));
}

/// Solves with the proximal E of redundant joints taken out again.
void EndOfStep::solve_instant(Eigen::VectorXd& rows, Eigen::VectorXd& x) const {
    constexpr int kProximalPasses = 4;
    x.setZero();
    for (int pass = 0; pass < kProximalPasses; ++pass) {
        proximal_rows_ = rows;
        for (size_t j = 0; j < descriptions_.size(); ++j) {
            const auto q = Eigen::seqN(instant_matrix_.joint_index(as_int(j)), system_.joints()[j].count());
            proximal_rows_(q) += instant_matrix_.upper().diagonal()(q).cwiseProduct(x(q));
        }
        instant_factor_.solve(proximal_rows_, x);
    }
}

/// Velocities of instant_ out of those over the step that begins there, under the mean wrenches_ over it.
void EndOfStep::find_velocities(const std::vector<BodyState>& after) {
    instant_rows_.setZero();
    for (size_t b = 0; b < after.size(); ++b) {
        BodyState& at = instant_.at[b];
        const Eigen::Map<const Vector6> mean(&wrenches_[6 * b]);
        const double mass = bodies_[b].inertia.mass;
        const Eigen::Vector3d velocity = after[b].velocity - 0.5 * h_ / mass * mean.head<3>();
        const Eigen::Vector3d L = momentum_over_step(b, at.rotation, after[b].angular_velocity) - 0.5 * h_ * mean.tail<3>();
        if (system_.empty()) {
            at.velocity = velocity;
            at.angular_velocity = at.rotation * (inverse_moments_[b] * (at.rotation.transpose() * L));
        } else {
            instant_rows_.segment<6>(instant_matrix_.index(as_int(b))) << mass * velocity, L;
        }
    }
    if (system_.empty()) return;
    solve_instant(instant_rows_, instant_solution_);
    for (size_t b = 0; b < after.size(); ++b) {
        const auto u = instant_solution_.segment<6>(instant_matrix_.index(as_int(b)));
        instant_.at[b].velocity = u.head<3>();
        instant_.at[b].angular_velocity = u.tail<3>();
    }
}

/// Accelerations at an instant under wrenches_:  M a + Jᵀ q = f,  I α + … = m − ω × I ω,  J a = −C̈ at constant velocities.
void EndOfStep::find_accelerations(const std::vector<BodyState>& at) {
    for (size_t b = 0; b < at.size(); ++b) {
        const Eigen::Vector3d& w = at[b].angular_velocity;
        const Eigen::Matrix3d& R = at[b].rotation;
        Vector6 f = Eigen::Map<const Vector6>(&wrenches_[6 * b]);
        f.tail<3>() -= w.cross(bodies_[b].inertia.turned(R, w));
        if (system_.empty())
            instant_.accelerations[b] << f.head<3>() / bodies_[b].inertia.mass,
                R * (inverse_moments_[b] * (R.transpose() * f.tail<3>()));
        else
            instant_rows_.segment<6>(instant_matrix_.index(as_int(b))) = f;
    }
    if (system_.empty()) return;
    system_.write_curvatures(instant_matrix_, at, instant_rows_);
    solve_instant(instant_rows_, instant_solution_);
    instant_multipliers_ = h_ * instant_solution_;
    for (size_t b = 0; b < at.size(); ++b)
        instant_.accelerations[b] = instant_solution_.segment<6>(instant_matrix_.index(as_int(b)));
}

/// Whether a stop changes the speed of its coordinate over the step: it has not been at rest on it.
bool EndOfStep::has_impact(const std::vector<BodyState>& now, const std::vector<BodyState>& after) const {
    for (size_t j = 0; j < stops_.size(); ++j) {
        if (!stops_[j].acts) continue;
        const double before = system_.coordinate_speed(j, now), then = system_.coordinate_speed(j, after);
        if (std::abs(before) > 2 * Stop::kPlay / h_ || std::abs(then) > 2 * Stop::kPlay / h_) return true;
    }
    return false;
}

const Instant& EndOfStep::find_instant(const std::vector<BodyState>& now, const std::vector<BodyState>& after,
                                       Networks& networks, const Loads& loads) {
    const bool is_impact = has_impact(now, after);
    const bool is_newmark = networks.stand() && networks.is_implicit() && !is_impact && !joints_turn_;
    for (size_t b = 0; b < now.size(); ++b) {
        BodyState& at = instant_.at[b] = now[b];
        at.velocity = 0.5 * (now[b].velocity + after[b].velocity);
        at.angular_velocity = 0.5 * (now[b].angular_velocity + after[b].angular_velocity);
        instant_.accelerations[b] << (after[b].velocity - now[b].velocity) / h_,
            (after[b].angular_velocity - now[b].angular_velocity) / h_;
    }
    for (size_t j = 0; j < descriptions_.size(); ++j) {  // the two matrices have orders of their own
        const int count = system_.joints()[j].count();
        instant_multipliers_.segment(instant_matrix_.joint_index(as_int(j)), count) =
            multipliers_.segment(matrix_.joint_index(as_int(j)), count);
    }
    if (!networks.stand()) return instant_;
    factor_instant(now);
    std::fill(wrenches_.begin(), wrenches_.end(), 0.0);
    if (networks.is_implicit()) networks.add_mean_wrenches(wrenches_.data());
    if (steps_ == 1) {
        instant_.at = start_;  // the initial conditions
    } else if (is_newmark) {
        loads.add_mean(now, wrenches_.data());
        find_velocities(after);
    }
    std::fill(wrenches_.begin(), wrenches_.end(), 0.0);
    networks.stand_at(instant_.at, nullptr, wrenches_.data());
    if (is_impact) return instant_;
    loads.add_at_start(now, wrenches_.data());
    find_accelerations(instant_.at);
    if (steps_ == 1 && !instant_.accelerations.empty())
        networks.stand_at(instant_.at, instant_.accelerations.front().data(), wrenches_.data());
    return instant_;
}

void EndOfStep::refuse_opening_joints(const std::vector<BodyState>& at) const {
    constexpr double kTolerated = 1e-9;
    double scale = 0;
    for (size_t b = 0; b < at.size(); ++b) scale = std::max({scale, at[b].velocity.norm(), at[b].angular_velocity.norm()});
    for (size_t j = 0; j < descriptions_.size(); ++j)
        if (const double speed = system_.opening_speed(j, at); speed > kTolerated * scale)
            throw ModelError(fmt::format(
                "{}: joint \"{}\": the velocities of its bodies at the start would open it at {:.3g} m/s (or rad/s); "
                "give both bodies velocities that the joint allows",
                descriptions_[j].place, descriptions_[j].name, speed));
}

/// Angular momentum half way through a step that starts at R with the angular velocity w:
///     L = R_{½} J R_{½}ᵀ w = exp(h w~/2) R J Rᵀ w,   for the exponential leaves w alone
Eigen::Vector3d EndOfStep::momentum_over_step(size_t body, const Eigen::Matrix3d& R, const Eigen::Vector3d& w) const {
    return RotationStep(0.5 * h_ * w).apply(bodies_[body].inertia.turned(R, w));
}

void EndOfStep::predict(const std::vector<BodyState>& now) {
    for (size_t b = 0; b < now.size(); ++b) {
        Vector6 before;
        before << now[b].velocity, now[b].angular_velocity;
        u_[b] = 2 * before - previous_u_[b];
        previous_u_[b] = before;
    }
}

/// The bodies after a part t of the step with the velocities of the trial.
void EndOfStep::move(const std::vector<BodyState>& now, double t, std::vector<BodyState>& to) const {
    for (size_t b = 0; b < now.size(); ++b) {
        to[b].velocity = u_[b].head<3>();
        to[b].angular_velocity = u_[b].tail<3>();
        to[b].position = now[b].position + t * to[b].velocity;
        to[b].rotation = RotationStep(t * to[b].angular_velocity).apply(now[b].rotation);
    }
}

void EndOfStep::evaluate(const std::vector<BodyState>& now, Networks& networks) {
    std::fill(wrenches_.begin(), wrenches_.end(), 0.0);
    ++passes_;
    ++open_.passes;
    if (!stiffness_wanted_) {
        networks.evaluate(trial_, wrenches_.data());
        return;
    }
    matrix_.set_zero();
    const Networks::StiffnessSink add = [this](int row, int column, const BlockMatrix::Block& S) {
        // Symmetric part: away from rest S is not quite symmetric
        matrix_.add(row, column, 0.5 * h_ * h_ * S);
        matrix_.add(column, row, 0.5 * h_ * h_ * S.transpose());
    };
    networks.evaluate(trial_, wrenches_.data(), &add);
    factor(now);
    ++factorisations_;
    ++open_.factorisations;
    stiffness_wanted_ = false;
}

/// Adds inertia and joints to the stiffness in the matrix, and factors.
void EndOfStep::factor(const std::vector<BodyState>& now) {
    for (size_t b = 0; b < now.size(); ++b) matrix_.add(as_int(b), as_int(b), bodies_[b].inertia.block(now[b].rotation));
    system_.write_to(matrix_);
    if (!factor_.factor(matrix_))
        throw Error(ExitCode::numerical_failure,
                    fmt::format("t = {:.9g} s: the matrix of the end of the step, M + h² S, is singular, first at body "
                                "\"{}\": {}",
                                time_, bodies_[least_held(now)].name,
                                system_.empty() ? "its elements push it over faster than the step follows; try a smaller one"
                                : singular_.is_near ? kSingularCure
                                                    : "very unequal masses on joints?"));
}

/// The body whose stiffness takes most from its inertia.
size_t EndOfStep::least_held(const std::vector<BodyState>& now) const {
    size_t least = 0;
    double least_share = std::numeric_limits<double>::infinity();
    for (size_t b = 0; b < now.size(); ++b) {
        const Vector6 held = matrix_.diagonal(as_int(b)).diagonal();
        const double share = held.cwiseQuotient(bodies_[b].inertia.block(now[b].rotation).diagonal()).minCoeff();
        if (share >= least_share) continue;
        least = b;
        least_share = share;
    }
    return least;
}

/// One correction δ = K⁻¹ (P− + h f − P(u)), applied to u; with joints, likewise of u and q.
void EndOfStep::correct(const std::vector<BodyState>& now) {
    for (size_t b = 0; b < now.size(); ++b) {
        Vector6 r = free_momentum_[b] + h_ * Eigen::Map<const Vector6>(&wrenches_[6 * b]);
        r.head<3>() -= bodies_[b].inertia.mass * u_[b].head<3>();
        r.tail<3>() -= momentum_over_step(b, now[b].rotation, u_[b].tail<3>());
        right_hand_side_.segment<6>(matrix_.index(as_int(b))) = r;
    }
    if (!system_.empty()) {
        system_.add_impulses(matrix_, multipliers_, right_hand_side_);
        system_.write_openings(matrix_, trial_, h_, right_hand_side_);
    }
    factor_.solve(right_hand_side_, solution_);
    if (!system_.empty()) multipliers_ += solution_;
    for (size_t b = 0; b < now.size(); ++b) {
        correction_[b] = solution_.segment<6>(matrix_.index(as_int(b)));
        u_[b] += correction_[b];
    }
}

/// What the equations of motion lack at the trial, as twice the energy that it would give the bodies at rest [J].
double EndOfStep::lack(const std::vector<BodyState>& now) const {
    double sum = 0;
    for (size_t b = 0; b < now.size(); ++b) {
        Vector6 r = free_momentum_[b] + h_ * Eigen::Map<const Vector6>(&wrenches_[6 * b]);
        r.head<3>() -= bodies_[b].inertia.mass * u_[b].head<3>();
        r.tail<3>() -= momentum_over_step(b, now[b].rotation, u_[b].tail<3>());
        sum += r.dot(bodies_[b].inertia.block(now[b].rotation).ldlt().solve(r));
    }
    return sum;
}

void EndOfStep::remember(const std::vector<BodyState>& now) {
    base_u_ = u_;
    base_lack_ = lack(now);
}

/// If the correction last made has made it worse: half of it. The force is a derivative of an energy, so that a part of
/// Newton's correction small enough makes it better.
bool EndOfStep::go_back(const std::vector<BodyState>& now) {
    bool is_felt = false;
    for (size_t b = 0; b < u_.size(); ++b)
        is_felt = is_felt || speed_of(b, u_[b] - base_u_[b]) > groups_[bodies_[b].group].floor;
    if (!is_felt || lack(now) <= base_lack_) return false;
    for (size_t b = 0; b < u_.size(); ++b) u_[b] = 0.5 * (u_[b] + base_u_[b]);
    stiffness_wanted_ = true;
    return true;
}

/// Opens the books of a step: what rounding feigns, and how far the rates of convergence of old are trusted.
void EndOfStep::open_groups(const std::vector<BodyState>& now) {
    const double least_contraction = system_.empty() ? 0 : JointSystem::kProximal;
    for (Group& group : groups_) {
        group.scale = 0.98 * group.size();
        group.convergence.open(least_contraction);
        group.floor = 0;
    }
    for (NewtonConvergence& part : parts_) part.open();
    const double rounding = kRounding / h_;
    for (size_t b = 0; b < now.size(); ++b) {
        Group& group = groups_[bodies_[b].group];
        group.floor = std::max(group.floor, kRounding * speed_of(b, u_[b]));
        if (!bodies_[b].holder.empty())
            group.floor = std::max(group.floor, rounding * std::hypot(now[b].position.norm(), bodies_[b].reach));
    }
}

/// A light body between heavy ones passes on impulses whose rounding alone moves it.
void EndOfStep::raise_floors() {
    for (size_t j = 0; j < descriptions_.size(); ++j) {
        const double* q = multipliers_.data() + matrix_.joint_index(as_int(j));
        for (const auto side : {JointEquations::kFirst, JointEquations::kSecond}) {
            if (system_.joints()[j].bodies()[side] < 0) continue;
            const Coupled& body = bodies_[as_size(system_.joints()[j].bodies()[side])];
            const Vector6 impulse = system_.impulse(j, side, q);
            const double p = impulse.head<3>().norm(), L = impulse.tail<3>().norm() + body.reach * p;
            const double speed = kRounding * (p / body.inertia.mass + body.reach * L / body.least);
            Group& group = groups_[body.group];
            group.floor = std::max(group.floor, speed);
        }
    }
}

/// Whether the bodies have converged by this pass. With joints the first correction is that of multipliers from zero, and
/// measures nothing.
bool EndOfStep::judge(int pass) {
    for (Group& group : groups_) {
        group.progress = {};
        group.speed = 0;
    }
    for (size_t b = 0; b < u_.size(); ++b) {
        Group& group = groups_[bodies_[b].group];
        group.speed = std::max(group.speed, speed_of(b, u_[b]));
        const double correction = speed_of(b, correction_[b]);
        if (!std::isfinite(correction)) fail(pass);
        group.progress.correction = std::max(group.progress.correction, correction);
    }
    bool done = true, slow = false;
    for (Group& group : groups_) {
        group.progress.previous = pass > 1 || system_.empty() ? group.convergence.progress().correction : 0;
        group.progress.motion = group.size();
        group.progress.enough = group.floor;
        group.convergence.take(group.progress);
        done = done && group.convergence.is_done();
        slow = slow || group.convergence.is_slow();
    }
    if (slow) {
        if (pass > 2) system_.tighten();  // a new matrix was not enough
        stiffness_wanted_ = true;
    }
    return done;
}

void EndOfStep::begin_step(const dttmm_step& step, const std::vector<BodyState>& now, const Loads& loads) {
    time_ = step.time;
    ++steps_;
    open_ = {step.index, step.time};
    std::fill(wrenches_.begin(), wrenches_.end(), 0.0);
    loads.add_over_step(now, wrenches_.data());
    for (size_t b = 0; b < now.size(); ++b) {
        // R of the step before: L = exp(−h w~/2) R J Rᵀ w with R at its end
        const Eigen::Vector3d& w = now[b].angular_velocity;
        const Eigen::Vector3d L = bodies_[b].inertia.turned(now[b].rotation, w);
        free_momentum_[b] = h_ * Eigen::Map<const Vector6>(&wrenches_[6 * b]);
        free_momentum_[b].head<3>() += bodies_[b].inertia.mass * now[b].velocity;
        free_momentum_[b].tail<3>() += RotationStep(-0.5 * h_ * w).apply(L);
    }
    predict(now);
    open_groups(now);
}

const Feedback& EndOfStep::solve(const std::vector<BodyState>& now, Networks& networks, const std::vector<Stop>& stops) {
    stops_ = stops;
    if (!find_end(now, networks)) {
        // A stop at a dead centre can hold the joints open: it lets go
        if (std::ranges::none_of(stops_, &Stop::acts)) refuse(networks);
        for (Stop& stop : stops_) stop.acts = false;
        for (size_t b = 0; b < now.size(); ++b) u_[b] << now[b].velocity, now[b].angular_velocity;
        if (!find_end(now, networks)) refuse(networks);
    }
    if (open_.passes > worst_.passes) worst_ = report();
    remember_let_go();
    if (!system_.empty()) move(now, h_, trial_);
    form_feedback(now);
    return feedback_;
}

/// Newton's iteration; false if kMostPasses are not enough.
bool EndOfStep::find_end(const std::vector<BodyState>& now, Networks& networks) {
    const bool has_joints = !system_.empty();
    const JointSystem::SingularPosition before = std::exchange(singular_, {});
    if (has_joints) {
        foreseen_.assign(stops_.size(), false);
        multipliers_.setZero();  // what redundant joints share is then found anew at every step, and stays small
        linearise_joints(now);
    }
    // A pass finds the multipliers to kProximal only, and that does not show in its own correction: so two with joints.
    int first_trusted = has_joints ? 1 : 0;
    bool has_gone_back = false;
    for (int pass = 0; pass < kMostPasses; ++pass) {
        if (networks.is_implicit() || has_joints) move(now, h_, trial_);
        stiffness_wanted_ = stiffness_wanted_ || has_gone_back;
        if (pass == 0 || networks.is_implicit() || stiffness_wanted_) evaluate(now, networks);
        if (pass == 0 && has_joints) see_singular_position(now, networks, before);
        // Where springs have kinks, Newton's tangents may lead from one side to the other for ever
        const bool parts_done = judge_parts(networks);
        const bool may_go_back = !has_joints && (!parts_done || has_gone_back);
        if (may_go_back && pass > 0 && go_back(now)) {
            has_gone_back = true;
            --pass;  // halving ends where the correction is no longer felt
            continue;
        }
        if (may_go_back) remember(now);
        correct(now);
        if (has_joints) raise_floors();
        const bool done = judge(pass);
        if (!done || pass < first_trusted || !parts_done) continue;
        if (!revise_stops(now)) return true;
        first_trusted = pass + 2;
    }
    return false;
}

/// Takes the matrix half way near a singular position, and lets go equations of joints that do not decide about the step.
void EndOfStep::see_singular_position(const std::vector<BodyState>& now, Networks& networks,
                                      const JointSystem::SingularPosition& before) {
    if (!system_.may_be_near_singular(matrix_, factor_) && !before.is_near) return;
    move(now, 0.5 * h_, half_);
    singular_ = system_.find_singular_position(now, half_, trial_);
    // ODE's joints are not ours where they stand open: the step that closes them does without
    const bool is_open = std::ranges::any_of(before.let_go, [](unsigned equations) { return equations != 0; });
    if (is_open && singular_.let_go.empty()) singular_.let_go.assign(descriptions_.size(), 0);
    for (Group& group : groups_) group.floor /= singular_.least;
    if (!singular_.is_near) return;
    linearise_joints(now);
    evaluate(now, networks);
}

void EndOfStep::remember_let_go() {
    const auto joint = std::ranges::find_if(singular_.let_go, [](unsigned equations) { return equations != 0; });
    if (joint == singular_.let_go.end()) return;
    if (passed_.steps++ == 0) passed_ = {1, time_, static_cast<size_t>(joint - singular_.let_go.begin())};
}

void EndOfStep::linearise_joints(const std::vector<BodyState>& now) {
    system_.linearise(now, singular_.is_near ? half_ : now, stops_, singular_.let_go);
    stiffness_wanted_ = true;
}

/// Takes what the last evaluation says of the plugins' parts; true if every one may stop.
bool EndOfStep::judge_parts(const Networks& networks) {
    bool done = true;
    for (size_t p = 0; p < parts_.size(); ++p) {
        parts_[p].take(networks.progress()[p]);
        done = done && parts_[p].is_done();
    }
    return done;
}

StepReport EndOfStep::report() const {
    StepReport report = open_;
    report.stops = as_int(std::ranges::count_if(stops_, &Stop::acts));
    int longest = 0;  // passes that did not do
    const auto take = [&](const NewtonConvergence& convergence) {
        const dttmm_progress& last = convergence.progress();
        if (last.previous > 0) report.rate = std::max(report.rate, last.correction / last.previous);
        const bool is_longest = convergence.passes_not_done() > longest;
        longest = std::max(longest, convergence.passes_not_done());
        return is_longest;
    };
    for (size_t g = 0; g < groups_.size(); ++g) {
        report.correction = std::max(report.correction, groups_[g].progress.correction);
        if (take(groups_[g].convergence)) report.body = as_int(farthest_off(g));
    }
    for (size_t p = 0; p < parts_.size(); ++p) {
        const dttmm_progress& last = parts_[p].progress();
        report.inside_correction = std::max(report.inside_correction, last.correction);
        report.inside_residual = std::max(report.inside_residual, last.residual);
        if (!take(parts_[p])) continue;
        report.part = as_int(p);
        report.body = -1;
    }
    return report;
}

/// The body of a group that the last pass corrected most.
size_t EndOfStep::farthest_off(size_t group) const {
    size_t body = bodies_.size();
    for (size_t b = 0; b < bodies_.size(); ++b)
        if (bodies_[b].group == group &&
            (body == bodies_.size() || speed_of(b, correction_[b]) > speed_of(body, correction_[body])))
            body = b;
    return body;
}

std::string EndOfStep::waited_for(const StepReport& report, const Networks& networks) const {
    if (report.part >= 0) return networks.whose_part(as_size(report.part));
    return report.body >= 0 ? name_of(as_size(report.body)) : "";
}

/// With what holds it.
std::string EndOfStep::name_of(size_t body) const {
    return fmt::format("body \"{}\"{}", bodies_[body].name,
                       bodies_[body].holder.empty() ? "" : " on " + bodies_[body].holder);
}

/// Names a part that has not converged, where the bodies have; else the worst body.
void EndOfStep::refuse(const Networks& networks) const {
    const bool bodies_done = std::ranges::all_of(groups_, [](const Group& group) { return group.convergence.is_done(); });
    const auto part = std::ranges::find_if_not(parts_, &NewtonConvergence::is_done);
    if (!bodies_done || part == parts_.end()) fail(kMostPasses);
    throw Error(
        ExitCode::numerical_failure,
        fmt::format("t = {:.9g} s: {}: the motion inside was not found in {} passes (last correction {:.1e} m/s); "
                    "try a smaller step",
                    time_, networks.whose_part(as_size(part - parts_.begin())), kMostPasses, part->progress().correction));
}

/// Adds the first stop that the motion found would run through, so that it ends there, and lets go those that would pull;
/// true if anything has changed.
bool EndOfStep::revise_stops(const std::vector<BodyState>& now) {
    if (!system_.has_stops()) return false;
    move(now, h_, trial_);
    bool changed = false;
    double first = std::numeric_limits<double>::infinity();  // share of the step after which a stop is reached
    size_t reached = stops_.size();
    Stop stop_reached;
    const double weak = kRounding * multipliers_.cwiseAbs().maxCoeff();
    for (size_t j = 0; j < stops_.size(); ++j) {
        const JointEquations& joint = system_.joints()[j];
        if (!joint.has_stops()) continue;
        if (stops_[j].acts) {
            // The impulse −q on the coordinate must have the sign of the stop's side
            const double q = multipliers_(matrix_.joint_index(as_int(j)) + joint.lasting());
            if (!foreseen_[j] || stops_[j].side * q <= weak) continue;
            stops_[j].acts = foreseen_[j] = false;
            changed = true;
            continue;
        }
        const double start = joint.coordinate(now);
        double way = joint.coordinate(trial_) - start;
        if (joint.turns()) way = std::remainder(way, 2 * M_PI);
        for (int side : {1, -1}) {
            const double stop = joint.stops()[side > 0 ? 0 : 1];
            if (side * (start + way - stop) >= -Stop::kPlay || side * (start - stop) < 0) continue;
            const double share = (stop - start) / way;
            if (share >= first) continue;
            first = share;
            reached = j;
            stop_reached = {true, (stop - side * Stop::kPlay - start) / h_, side};
        }
    }
    if (reached < stops_.size() && !changed) {
        stops_[reached] = stop_reached;
        foreseen_[reached] = changed = true;
    }
    if (changed) linearise_joints(now);
    return changed;
}

void EndOfStep::confirm(const std::vector<BodyState>& after) const {
    for (size_t j = 0; j < descriptions_.size(); ++j) {
        for (int body : {descriptions_[j].first, descriptions_[j].second}) {
            if (body < 0) continue;
            const auto b = as_size(body);
            Vector6 difference = u_[b];
            difference.head<3>() -= after[b].velocity;
            difference.tail<3>() -= after[b].angular_velocity;
            const Group& group = groups_[bodies_[b].group];
            const double off = speed_of(b, difference), floor = group.convergence.progress().enough;
            if (off <= std::max(kAgreement * group.size(), 100 * floor)) continue;
            throw Error(
                ExitCode::numerical_failure,
                fmt::format("t = {:.9g} s: ODE's joints move body \"{}\" otherwise than foretold, by {:.1e} m/s (joint "
                            "\"{}\"); {}",
                            time_, bodies_[b].name, off, descriptions_[j].name,
                            singular_.is_near ? kSingularCure : "a step too long for the turning, or very unequal masses?"));
        }
    }
}

double EndOfStep::stop_work(const std::vector<BodyState>& now, const std::vector<BodyState>& after) const {
    double work = 0;
    for (size_t j = 0; j < descriptions_.size(); ++j) {
        const JointEquations& joint = system_.joints()[j];
        if (!joint.has_stops()) continue;
        const double q = multipliers_(matrix_.joint_index(as_int(j)) + joint.lasting());
        work -= q * 0.5 * (system_.coordinate_speed(j, now) + system_.coordinate_speed(j, after));
    }
    return work;
}

Eigen::Matrix<double, 6, 1> EndOfStep::joint_wrench(size_t joint, const std::vector<BodyState>& now) const {
    // What acts on the second body acts back on the first; both about the anchor
    const JointEquations& equations = system_.joints()[joint];
    const double* q = instant_multipliers_.data() + instant_matrix_.joint_index(as_int(joint));
    const auto side = equations.bodies()[JointEquations::kFirst] >= 0 ? JointEquations::kFirst : JointEquations::kSecond;
    const auto body = as_size(equations.bodies()[side]);
    Vector6 wrench = (side == JointEquations::kFirst ? 1 : -1) / h_ * system_.impulse(joint, side, q);
    wrench.tail<3>() += (now[body].position - equations.anchor(now)).cross(wrench.head<3>());
    return wrench;
}

void EndOfStep::form_feedback(const std::vector<BodyState>& now) {
    const double per_step = 1 / h_;
    for (size_t b = 0; b < now.size(); ++b) {
        const Eigen::Vector3d angular_acceleration = per_step * (u_[b].tail<3>() - now[b].angular_velocity);
        feedback_[b].head<3>() = bodies_[b].inertia.mass * per_step * (u_[b].head<3>() - now[b].velocity);
        feedback_[b].tail<3>() = bodies_[b].inertia.turned(now[b].rotation, angular_acceleration);
    }
    if (system_.empty()) return;
    // ODE's joints add their impulses themselves, but for stops that it does not see yet
    right_hand_side_.setZero();
    solution_ = multipliers_;
    for (size_t j = 0; j < foreseen_.size(); ++j)
        if (foreseen_[j]) solution_(matrix_.joint_index(as_int(j)) + system_.joints()[j].lasting()) = 0;
    system_.add_impulses(matrix_, solution_, right_hand_side_);
    for (size_t b = 0; b < now.size(); ++b) feedback_[b] -= per_step * right_hand_side_.segment<6>(matrix_.index(as_int(b)));
}

void EndOfStep::fail(int passes) const {
    size_t worst = 0;
    for (size_t b = 1; b < correction_.size(); ++b)
        if (!(correction_[b].squaredNorm() <= correction_[worst].squaredNorm())) worst = b;
    throw Error(
        ExitCode::numerical_failure,
        fmt::format(
            "t = {:.9g} s: the end of the step was not found in {} passes (last correction {:.1e} m/s), worst at {}; {}",
            time_, passes, correction_[worst].norm(), name_of(worst),
            singular_.is_near ? kSingularCure : "try a smaller step"));
}

}  // namespace dttmm::host
