// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/joints_by_four.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>
#include <numeric>
#include <random>
#include <span>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "core/rotation.h"
#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

using test::NetworkModel;
using test::tube;

const Matrix3 kTilted = rotation_from_vector(Vector3(0.4, -0.8, 1.3));

/// Two beams, one of them damped, and five springs on odd axes, all of them strained and moving.
class SomeJoints {
public:
    SomeJoints(double beta, double gamma, double largest_turn) : model_(DTTMM_SCHEME_CENTRED, beta, gamma) {
        model_.node("root", DTTMM_NODE_GROUND, Vector3(0.1, 0.2, -0.3));
        model_.node("tip", DTTMM_NODE_INNER, Vector3(1.3, -0.4, 0.9), kTilted);
        model_.node("end", DTTMM_NODE_INNER, Vector3(-0.9, 1.1, 0.4));
        model_.element("slim", "beam", {"root", "tip"}, tube(14));
        model_.element("damped", "beam", {"root", "end"}, tube(11, 1e-4));
        for (int i = 0; i < 5; ++i)
            model_.element("spring" + std::to_string(i), "spring_damper", {"tip", "end"},
                           {{"stiffness", {1e4 + i, 2e4, 3e4}}, {"damping", {5, 6.0 + i, 7}}});
        mechanism_ = std::make_unique<Mechanism>(model_.description());
        mechanism_->scheme.set_step_size(1e-4);
        for (Joint& joint : mechanism_->joints) joint.set_scheme(mechanism_->scheme);
        shake(mechanism_->frames, 1e-3);
        const auto twist = [&](int) { return Twist{any(2), any(30)}; };
        mechanism_->start_joints(twist, twist);
        mechanism_->steps = 3;
        trial_ = mechanism_->before = mechanism_->frames;
        shake(trial_, 1e-4);
        shake(mechanism_->before, 1e-4);
        rates_.resize(mechanism_->joints.size());
        for (Vector6& rate : rates_) rate << any(1), any(20);
        // One frame turns far: its joints leave the small angles of the rest
        const Frame now = trial_[7];
        Eigen::Map<RowMajor3>{trial_[7].rotation} = rotation_from_vector(Vector3(largest_turn, 0, 0)) * now.axes();
    }

    const Mechanism& mechanism() const { return *mechanism_; }
    const std::vector<Frame>& trial() const { return trial_; }
    const std::vector<Vector6>& rates() const { return rates_; }  ///< of the joints' deformations at t_{n−1}
    /// All joints; or, if alike, those with both axes along their frames' and a lever, as most of a beam.
    std::vector<size_t> joints(bool alike) const {
        std::vector<size_t> list;
        for (size_t j = 0; j < mechanism_->joints.size(); ++j) {
            const JointSeat& seat = mechanism_->joints[j].seat();
            if (!alike || (seat.own->is_aligned && seat.own->is_straight && seat.has_lever)) list.push_back(j);
        }
        return list;
    }

private:
    Vector3 any(double size) { return size * Vector3(normal_(random_), normal_(random_), normal_(random_)); }
    void shake(std::vector<Frame>& frames, double size) {
        for (Frame& frame : frames) {
            Eigen::Map<Vector3>{frame.position} += any(size);
            const Matrix3 R = frame.axes();
            Eigen::Map<RowMajor3>{frame.rotation} = rotation_from_vector(any(size)) * R;
        }
    }

    NetworkModel model_;
    std::unique_ptr<Mechanism> mechanism_;
    std::vector<Frame> trial_;
    std::vector<Vector6> rates_;
    std::mt19937 random_{3};
    std::normal_distribution<double> normal_;
};

/// Whether triples of numbers, each of one unit, agree to a share of their largest; false for NaN.
bool agree(const double* a, const double* b, size_t count, double share) {
    for (size_t n = 0; n < count; n += 3) {
        double error = 0, size = 0;
        for (size_t i = n; i < std::min(n + 3, count); ++i) {
            if (!std::isfinite(a[i])) return false;
            error = std::max(error, std::abs(a[i] - b[i]));
            size = std::max(size, std::abs(b[i]));
        }
        if (!(error <= share * size)) return false;
    }
    return true;
}

struct Answer {
    std::vector<Vector6> forces, committed, before,
        mean;                        ///< wrenches on all frames; at t_{n−1}, and over the step behind it
    std::vector<Vector6> of_joints;  ///< [force; moment] of every joint at t_{n−1}, or its rates
    Mechanism after;
    double largest = 0;

    explicit Answer(const SomeJoints& model)
        : forces(model.trial().size(), Vector6::Zero()),
          committed(forces),
          before(forces),
          mean(forces),
          of_joints(model.rates()),
          after(model.mechanism()) {}

    void expect_like(const Answer& other, double share) const {
        const size_t wrenches = 6 * forces.size();
        for (const auto kind : {&Answer::forces, &Answer::committed, &Answer::before, &Answer::mean})
            EXPECT_TRUE(agree((this->*kind)[0].data(), (other.*kind)[0].data(), wrenches, share));
        EXPECT_TRUE(agree(of_joints[0].data(), other.of_joints[0].data(), 6 * of_joints.size(), share));
        EXPECT_LE(std::abs(largest - other.largest), share * other.largest);
        const auto numbers = [](const auto& state) { return reinterpret_cast<const double*>(&state); };
        for (size_t j = 0; j < after.states.size(); ++j) {
            EXPECT_TRUE(agree(numbers(after.states[j]), numbers(other.after.states[j]), JointState::kNumbers, share)) << j;
            const DamperState *mine = after.damper(j), *its = other.after.damper(j);
            if (!mine) continue;
            EXPECT_TRUE(agree(numbers(*mine), numbers(*its), DamperState::kNumbers - 2, share)) << j;
            EXPECT_LE(std::abs(mine->dissipated - its->dissipated), share * its->dissipated) << j;
            EXPECT_LE(std::abs(mine->last_loss - its->last_loss), share * its->last_loss) << j;
        }
    }
};

Answer one_by_one(const SomeJoints& model, std::span<const size_t> joints) {
    Answer answer(model);
    const Mechanism& m = model.mechanism();
    for (size_t j : joints) {
        const Joint& joint = m.joints[j];
        const auto a = static_cast<size_t>(joint.from()), b = static_cast<size_t>(joint.to());
        const Ends trial = {model.trial()[a], model.trial()[b]};
        const JointForce force = joint.over_step(m.scheme, trial, m.states[j], m.damper(j));
        answer.largest = std::max(answer.largest, force.force.squaredNorm());
        Joint::add_wrench(force, answer.forces[a].data(), answer.forces[b].data());
        JointForce committed;
        joint.advance(m.scheme, trial, m.ends(j), answer.after.states[j], answer.after.damper(j), {}, &committed);
        Joint::add_wrench(committed, answer.committed[a].data(), answer.committed[b].data());

        const JointPose at = joint.pose(m.frame_before(joint.from()), m.frame_before(joint.to()));
        const Vector6 x = m.states[j].deformation_before();
        Vector6 rate = Vector6::Zero(), mean_rate = rate;
        if (const DamperState* damper = m.damper(j)) {
            rate = model.rates()[j];
            mean_rate << damper->halves[0].delta[0], damper->halves[1].delta[0];
            mean_rate /= m.scheme.step_size();
        }
        answer.of_joints[j] = joint.force(x, rate, nullptr);
        Joint::add_wrench(at.act(answer.of_joints[j]), answer.before[a].data(), answer.before[b].data());
        JointForce mean = at.act(joint.force(x, mean_rate, nullptr, 0.5));
        mean.add(0.5, m.states[j].elastic);
        Joint::add_wrench(mean, answer.mean[a].data(), answer.mean[b].data());
    }
    return answer;
}

Answer by_four(const SomeJoints& model, std::span<const size_t> joints) {
    Answer answer(model);
    const JointsByFour four(model.mechanism(), joints);
    answer.largest = four.add_forces(model.mechanism(), model.trial(), answer.forces);
    four.advance(answer.after, model.trial(), answer.committed);
    four.add_forces_before(model.mechanism(), answer.of_joints, answer.before);
    four.add_mean_forces(model.mechanism(), answer.mean);
    return answer;
}

/// Of a list, those that go by four.
std::vector<size_t> taken(const SomeJoints& model, const std::vector<size_t>& joints) {
    const JointsByFour four(model.mechanism(), joints);
    std::vector<size_t> list;
    std::ranges::set_difference(joints, four.others(), std::back_inserter(list));
    return list;
}

/// γ, how far one frame turns [rad], whether only joints that sit alike.
class ByFour : public ::testing::TestWithParam<std::tuple<double, double, bool>> {};

// Oracle: one joint after the other. Positions of 1 m round by 2e-16 m, the smallest deformations are of 1e-4 m or so.
TEST_P(ByFour, JointsAnswerAsOneByOne) {
    const auto [gamma, turn, alike] = GetParam();
    const SomeJoints model(0.25 * (gamma + 0.5) * (gamma + 0.5), gamma, turn);
    const std::vector<size_t> joints = taken(model, model.joints(alike));
    // Of 15 + 12 + 5 joints; alike without the first and the last of either beam and the springs: 13 + 10
    ASSERT_EQ(joints.size(), alike ? 12U + 8U : 12U + 12U + 4U);
    const Answer together = by_four(model, joints);
    together.expect_like(one_by_one(model, joints), 1e-10);
    double largest = 0;
    for (size_t j : joints) largest = std::max(largest, together.after.states[j].theta.norm());
    EXPECT_EQ(largest > 0.1, turn > 0) << "no joint leaves the small angles";
}

INSTANTIATE_TEST_SUITE_P(JointsByFour, ByFour,
                         ::testing::Combine(::testing::Values(0.5, 0.6), ::testing::Values(0.0, 0.5, 2.0),
                                            ::testing::Bool()));

/// Three bodies of the host, not in its order, and the ground; springs among them with and without moments and dampers.
NetworkModel three_bodies(uint32_t scheme, double gamma) {
    NetworkModel model(scheme, 0.25 * (gamma + 0.5) * (gamma + 0.5), gamma);
    model.node("a", DTTMM_NODE_ON_BODY, Vector3(0.7, -0.2, 0.4), kTilted, Vector3(0.3, 0.1, -0.2));
    model.node("b", DTTMM_NODE_ON_BODY, Vector3(-0.5, 0.9, 0.1), kTilted.transpose(), Vector3(-0.1, 0.4, 0.2));
    model.node("c", DTTMM_NODE_ON_BODY, Vector3(0.2, 0.3, -0.8));
    model.node("ground", DTTMM_NODE_GROUND, Vector3(0.1, 0.2, -0.3));
    const std::vector<std::string> pairs[] = {{"ground", "a"}, {"a", "b"}, {"c", "b"}};
    for (int i = 0; i < 21; ++i) {
        NetworkModel::Values values = {{"stiffness", {1e4 + 7 * i, 2e4, 3e4}}};
        if (i % 4 < 2) values["damping"] = {5, 6.0 + i, 7};
        if (i % 2 == 0) values["rotational_stiffness"] = {400, 500.0 + i, 600};
        if (i % 4 == 0) values["rotational_damping"] = {0.4, 0.5, 0.6 + i};
        model.element("spring" + std::to_string(i), "spring_damper", pairs[i % 3], values);
    }
    return model;
}

class ByFourOnBodies : public ::testing::TestWithParam<std::pair<uint32_t, double>> {};

// Oracle: one joint after the other, over two steps.
TEST_P(ByFourOnBodies, JointsAnswerAsOneByOne) {
    const auto [scheme, gamma] = GetParam();
    const NetworkModel model = three_bodies(scheme, gamma);
    Mechanism mechanism(model.description());
    mechanism.scheme.set_step_size(1e-4);
    for (Joint& joint : mechanism.joints) joint.set_scheme(mechanism.scheme);
    std::mt19937 random(5);
    std::normal_distribution<double> normal;
    const auto any = [&](double size) {
        const double x = normal(random), y = normal(random), z = normal(random);
        return Vector3(size * Vector3(x, y, z));
    };
    const auto twist = [&](int frame) { return frame < 3 ? Twist{any(2), any(30)} : Twist{}; };
    mechanism.start_joints(twist, twist);
    Mechanism single = mechanism;
    std::vector<size_t> all(mechanism.joints.size());
    std::iota(all.begin(), all.end(), size_t{0});
    const JointsByFour four(mechanism, all);
    std::vector<size_t> taken;
    std::ranges::set_difference(all, four.others(), std::back_inserter(taken));
    ASSERT_EQ(taken.size(), four.size());
    ASSERT_EQ(taken.size(), 16U);

    const std::vector<uint32_t> bodies = {2, 4, 0};
    const PortBodies ports{mechanism, bodies}, own_ports{single, bodies};
    std::vector<dttmm_motion> motions(5);
    for (const int step : {1, 2}) {
        SCOPED_TRACE(step);
        for (size_t p = 0; p < 3; ++p) {
            dttmm_motion& motion = motions[bodies[p]];
            const Frame at = mechanism.frames[p];
            Eigen::Map<Vector3>{motion.position} = at.origin() + any(1e-3);
            Eigen::Map<RowMajor3>{motion.rotation} = rotation_from_vector(any(1e-3)) * at.axes();
        }
        std::vector<double> together(30), alone(30);
        four.add_forces(ports, motions.data(), together.data());
        for (size_t j : taken) {
            const Joint& joint = single.joints[j];
            const Ends trial = own_ports.seen(joint, motions.data());
            own_ports.add_wrench(joint, joint.over_step(single.scheme, trial, single.states[j], single.damper(j)),
                                 alone.data());
            joint.advance(single.scheme, trial, single.ends(j), single.states[j], single.damper(j), {}, nullptr);
        }
        EXPECT_TRUE(agree(together.data(), alone.data(), 30, 1e-10));
        for (size_t i = 0; i < 30; ++i) EXPECT_EQ(together[i] == 0, i / 6 == 1 || i / 6 == 3) << "of a body that is no port";
        four.advance(mechanism, ports, motions.data());
        for (size_t j : taken) {
            EXPECT_TRUE(agree(numbers_of(mechanism.states[j]), numbers_of(single.states[j]), JointState::kNumbers, 1e-10))
                << j;
            const DamperState *mine = mechanism.damper(j), *its = single.damper(j);
            if (!mine) continue;
            EXPECT_TRUE(agree(numbers_of(*mine), numbers_of(*its), DamperState::kNumbers - 2, 1e-10)) << j;
            EXPECT_NEAR(mine->last_loss, its->last_loss, 1e-10 * its->last_loss) << j;
            EXPECT_NEAR(mine->dissipated, its->dissipated, 1e-10 * its->dissipated) << j;
            if (j % 4 < 2) {
                EXPECT_EQ(mine->dissipated > 0, step == 2) << j;
            }
        }
        for (Mechanism* moved : {&mechanism, &single})
            for (size_t p = 0; p < 3; ++p) moved->frames[p] = ports.seen(static_cast<int>(p), motions.data()).copy();
    }
}

INSTANTIATE_TEST_SUITE_P(JointsByFour, ByFourOnBodies,
                         ::testing::Values(std::pair{uint32_t{DTTMM_SCHEME_CENTRED}, 0.5},
                                           std::pair{uint32_t{DTTMM_SCHEME_CENTRED}, 0.6},
                                           std::pair{uint32_t{DTTMM_SCHEME_FOX_EULER}, 0.5},
                                           std::pair{uint32_t{DTTMM_SCHEME_PARK}, 0.5}));

TEST(JointsByFour, EveryJointIsTakenOrLeft) {
    const SomeJoints model(0.25, 0.5, 0);
    const std::vector<size_t> all = model.joints(false), some(all.begin(), all.begin() + 3);
    const JointsByFour four(model.mechanism(), all);
    EXPECT_EQ(four.size() + four.others().size(), all.size());
    EXPECT_TRUE(std::ranges::is_sorted(four.others()));
    EXPECT_EQ(JointsByFour(model.mechanism(), some).others(), some);
    EXPECT_EQ(JointsByFour(model.mechanism(), {}).size(), 0U);
}

}  // namespace
}  // namespace dttmm::plugin
