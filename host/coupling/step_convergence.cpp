// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/step_convergence.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <map>
#include <numeric>

#include "model/diagnostics.h"
#include "model/index.h"
#include "world/inertia.h"
#include "world/iteration.h"

namespace dttmm::host {

namespace {

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

StepConvergence::StepConvergence(const Model& model, const Networks& networks, const JointSystem& joints)
    : parts_(networks.progress().size(), NewtonConvergence(NewtonConvergence::kInside)) {
    const std::vector<std::string> holders = find_holders(model);
    const std::vector<size_t> group = find_groups(model.bodies.size(), find_neighbours(model, networks));
    for (size_t b = 0; b < model.bodies.size(); ++b) {
        const Body& body = model.bodies[b];
        const double least = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(body.inertia).eigenvalues()(0);
        const double reach = std::max(reach_of(body), joints.longest_arm(as_int(b)));
        bodies_.push_back({body.name, holders[b], false, body.mass, least, reach, group[b]});
    }
    for (const Joint& joint : model.joints)
        for (int body : {joint.first, joint.second})
            if (body >= 0) bodies_[as_size(body)].is_jointed = true;
    groups_.resize(group.empty() ? 0 : 1 + *std::ranges::max_element(group));
}

void StepConvergence::begin_step(const std::vector<BodyState>& now, const StepEquations& equations) {
    const bool has_joints = !equations.joint_system().empty();
    for (Group& group : groups_) {
        group.convergence.open(has_joints ? JointSystem::kProximal : 0);
        group.floor = group.distance = group.share = 0;
    }
    for (NewtonConvergence& part : parts_) part.open();
    for (size_t b = 0; b < now.size(); ++b) {
        Group& group = groups_[bodies_[b].group];
        group.floor = std::max(group.floor, kRounding * speed(b, equations.u()[b]));
        if (bodies_[b].holder.empty()) continue;
        group.distance = std::max(group.distance, std::hypot(now[b].position.norm(), bodies_[b].reach));
        group.share = std::max(group.share, bodies_[b].is_jointed ? 1 : equations.stiffness_share(b));
    }
    for (Group& group : groups_)
        group.floor = std::max(group.floor, group.share * kRounding * group.distance / equations.h());
}

void StepConvergence::add_rounding(const JointSystem& joints, const BlockMatrix& matrix, const Eigen::VectorXd& q) {
    for (size_t j = 0; j < joints.joints().size(); ++j)
        for (const auto side : JointEquations::kSides) {
            const int index = joints.joints()[j].bodies()[side];
            if (index < 0) continue;
            const Judged& body = bodies_[as_size(index)];
            const auto impulse = joints.impulse(j, side, q.data() + matrix.joint_index(as_int(j)));
            const double p = impulse.head<3>().norm(), L = impulse.tail<3>().norm() + body.reach * p;
            Group& group = groups_[body.group];
            group.floor = std::max(group.floor, kRounding * (p / body.mass + body.reach * L / body.least));
        }
}

void StepConvergence::divide_rounding(double least) {
    for (Group& group : groups_) group.floor /= least;
}

StepConvergence::Judgement StepConvergence::judge_bodies(const BodyVectors& u, const BodyVectors& correction,
                                                         bool measures) {
    for (Group& group : groups_) group.progress = {};
    for (size_t b = 0; b < u.size(); ++b) {
        Group& group = groups_[bodies_[b].group];
        group.progress.motion = std::max(group.progress.motion, speed(b, u[b]));
        const double change = speed(b, correction[b]);
        if (!std::isfinite(change)) return {false, false, false};
        group.progress.correction = std::max(group.progress.correction, change);
    }
    Judgement judgement;
    for (Group& group : groups_) {
        group.progress.previous = measures ? group.convergence.progress().correction : 0;
        group.progress.enough = group.floor;
        group.convergence.take(group.progress);
        judgement.is_done = judgement.is_done && group.convergence.is_done();
        judgement.is_slow = judgement.is_slow || group.convergence.is_slow();
    }
    return judgement;
}

bool StepConvergence::judge_parts(const Networks& networks) {
    bool done = true;
    waits_for_laws_ = false;
    for (size_t p = 0; p < parts_.size(); ++p) {
        parts_[p].take(networks.progress()[p]);
        if (parts_[p].is_done()) continue;
        done = false;
        waits_for_laws_ = waits_for_laws_ || networks.progress()[p].is_new < 0;
    }
    return done;
}

bool StepConvergence::is_felt(const BodyVectors& u, const BodyVectors& before) const {
    for (size_t b = 0; b < u.size(); ++b)
        if (speed(b, u[b] - before[b]) > groups_[bodies_[b].group].floor) return true;
    return false;
}

double StepConvergence::tolerance(size_t body, double share) const {
    const Group& group = groups_[bodies_[body].group];
    return std::max(share * group.convergence.progress().motion, kNearRounding * group.convergence.progress().enough);
}

void StepConvergence::add_to(StepReport& report, const BodyVectors& correction) const {
    int longest = 0;  // passes that did not do
    const auto take = [&](const NewtonConvergence& convergence) {
        const dttmm_progress& last = convergence.progress();
        if (last.previous > 0 && last.correction > last.enough)
            report.rate = std::max(report.rate, last.correction / last.previous);
        const bool is_longest = convergence.passes_not_done() > longest;
        longest = std::max(longest, convergence.passes_not_done());
        return is_longest;
    };
    for (size_t g = 0; g < groups_.size(); ++g) {
        report.correction = std::max(report.correction, groups_[g].progress.correction);
        if (take(groups_[g].convergence)) report.body = most_corrected(g, correction);
    }
    for (size_t p = 0; p < parts_.size(); ++p) {
        const dttmm_progress& last = parts_[p].progress();
        report.inside_correction = std::max(report.inside_correction, last.correction);
        report.inside_residual = std::max(report.inside_residual, last.residual);
        report.inside_factorisations += std::max(last.is_new, 0);
        if (!take(parts_[p])) continue;
        report.part = as_int(p);
        report.body = -1;
    }
}

int StepConvergence::most_corrected(size_t group, const BodyVectors& correction) const {
    int most = -1;
    for (size_t b = 0; b < bodies_.size(); ++b)
        if (bodies_[b].group == group &&
            (most < 0 || speed(b, correction[b]) > speed(as_size(most), correction[as_size(most)])))
            most = as_int(b);
    return most;
}

int StepConvergence::part_not_done() const {
    const bool bodies_done = std::ranges::all_of(groups_, [](const Group& group) { return group.convergence.is_done(); });
    const auto part = std::ranges::find_if_not(parts_, &NewtonConvergence::is_done);
    return bodies_done && part != parts_.end() ? as_int(part - parts_.begin()) : -1;
}

std::string StepConvergence::name_of(size_t body) const {
    return fmt::format("body \"{}\"{}", bodies_[body].name,
                       bodies_[body].holder.empty() ? "" : " on " + bodies_[body].holder);
}

}  // namespace dttmm::host
