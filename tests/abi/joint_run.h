// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cstring>
#include <map>
#include <string>
#include <vector>

#include "dttmm_plugin.h"

namespace dttmm::test {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

inline constexpr double kStep = 1.3e-3;

/// A prescribed motion of the two ends of a joint: each turns about an axis of its own while it swings, nothing along or
/// about a world axis. Velocities and accelerations at n = 0 are those of the instant, later ones those over the step
/// before.
class EndMotion {
public:
    explicit EndMotion(int end)
        : sign_(end == 0 ? 1 : -1.3), axis_(Eigen::Vector3d(0.3 + end, -0.7, 0.5 - end).normalized()) {}

    dttmm_motion at(uint64_t n) const {
        const double t = static_cast<double>(n) * kStep;
        dttmm_motion motion{};
        Eigen::Map<Eigen::Vector3d>{motion.position} = position(t);
        Eigen::Map<RowMajor3>{motion.rotation} = rotation(t);
        Eigen::Map<Eigen::Vector3d>{motion.velocity} =
            n == 0 ? velocity() : Eigen::Vector3d((position(t) - position(t - kStep)) / kStep);
        Eigen::Map<Eigen::Vector3d>{motion.angular_velocity} = spin() * axis_;
        return motion;
    }
    Eigen::Vector3d position(double t) const { return sign_ * start_ + t * velocity() + 0.5 * t * t * acceleration(); }
    Eigen::Matrix3d rotation(double t) const {
        return Eigen::AngleAxisd(sign_ * 0.9 + t * spin(), axis_).toRotationMatrix();
    }
    Eigen::Vector3d acceleration() const { return {-3.1, sign_ * 8.7, 2.9}; }

private:
    Eigen::Vector3d velocity() const { return {0.21 * sign_, -0.34, 0.55 + 0.1 * sign_}; }
    double spin() const { return 2.3 * sign_; }
    double sign_;
    Eigen::Vector3d axis_, start_{0.31, -0.12, 0.23};
};

/// Which ends of a joint move; the others are on the ground.
struct Ends {
    bool from_moves, to_moves;
};

/// What a joint answers at one step.
struct Answer {
    std::vector<double> wrench, stiffness;
    std::map<std::string, double> outputs;
    std::vector<double> mean, standing;  ///< mean wrench over the step, wrench at its start
    bool operator==(const Answer&) const = default;
};

/// One joint of a plugin, led along the prescribed motion through the C interface.
class JointRun {
public:
    JointRun(const dttmm_plugin& table, uint32_t type, const std::vector<double>& values, uint32_t scheme, Ends ends)
        : table_(table) {
        const EndMotion motions[] = {EndMotion(0), EndMotion(1)};
        dttmm_node nodes[2]{};
        dttmm_body bodies[2]{};
        for (int end : {0, 1}) {
            const bool moves = end == 0 ? ends.from_moves : ends.to_moves;
            const dttmm_motion at = motions[end].at(0);
            const auto body = static_cast<uint32_t>(ports_.size());
            nodes[end] = {
                end == 0 ? "from" : "to", moves ? DTTMM_NODE_ON_BODY : DTTMM_NODE_GROUND, body, {}, {}, 0, 0, {}, {}};
            std::memcpy(nodes[end].position, at.position, sizeof at.position);
            std::memcpy(nodes[end].rotation, at.rotation, sizeof at.rotation);
            if (!moves) continue;
            bodies[body] = {nodes[end].name, {}, {}, 1, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
            std::memcpy(bodies[body].position, at.position, sizeof at.position);
            std::memcpy(bodies[body].rotation, at.rotation, sizeof at.rotation);
            ports_.push_back(motions[end]);
            // Off the centre of mass, its axes turned
            Eigen::Map<Eigen::Vector3d>{nodes[end].position} +=
                Eigen::Map<const RowMajor3>(at.rotation) * Eigen::Vector3d(-0.03 + 0.1 * end, -0.07, 0.05 - 0.02 * end);
            Eigen::Map<RowMajor3> axes(nodes[end].rotation);
            axes = (axes * Eigen::AngleAxisd(0.6 - end, Eigen::Vector3d(0.4, 0.5, -0.7).normalized())).eval();
        }
        const uint32_t from_to[] = {0, 1};
        const dttmm_element element{"joint", type, 2, from_to, values.data()};
        const dttmm_network network{static_cast<uint32_t>(ports_.size()),
                                    bodies,
                                    2,
                                    nodes,
                                    1,
                                    &element,
                                    scheme,
                                    0.27,
                                    0.53,
                                    {},
                                    0,
                                    nullptr,
                                    0,
                                    nullptr,
                                    nullptr,
                                    0};
        check(table_.create(&network, &instance_, &error_));
        for (uint32_t c = 0; c < table_.channel_count(instance_); ++c)
            names_.emplace_back(table_.channels(instance_)[c].name);
        start();
    }
    ~JointRun() { table_.destroy(instance_); }
    JointRun(const JointRun&) = delete;
    JointRun& operator=(const JointRun&) = delete;

    dttmm_instance* instance() { return instance_; }

    /// The force law at the motion of step n.
    Answer linearise(uint64_t n) {
        Answer answer = make_answer();
        std::vector<double> damping(answer.stiffness.size());
        check(table_.linearise(instance_, motions(n).data(), answer.wrench.data(), answer.stiffness.data(), damping.data(),
                               &error_));
        answer.stiffness.insert(answer.stiffness.end(), damping.begin(), damping.end());
        return answer;
    }
    /// Step n, from begin to commit.
    Answer step(uint64_t n) {
        const dttmm_step step{n, static_cast<double>(n) * kStep, kStep};
        Answer answer = make_answer();
        check(table_.begin_step(instance_, &step, nullptr, &error_));
        check(table_.evaluate(instance_, motions(n + 1).data(), answer.wrench.data(), answer.stiffness.data(), &error_));
        check(table_.commit_step(instance_, motions(n + 1).data(), &error_));
        answer.mean.resize(answer.wrench.size());
        answer.standing.resize(answer.wrench.size());
        check(table_.mean_wrench(instance_, answer.mean.data(), &error_));
        std::vector<dttmm_motion> standing = motions(n);  // with velocities of their own
        for (size_t p = 0; p < standing.size(); ++p)
            for (size_t i = 0; i < 3; ++i) {
                standing[p].velocity[i] = 0.3 * static_cast<double>(i) - 0.2 + 0.1 * static_cast<double>(p);
                standing[p].angular_velocity[i] = 0.5 - 0.4 * static_cast<double>(i * p);
            }
        check(table_.stand(instance_, standing.data(), nullptr, answer.standing.data(), &error_));
        EXPECT_EQ(table_.channel_count(instance_), names_.size());
        std::vector<double> values(names_.size());
        check(table_.outputs(instance_, values.data(), &error_));
        for (size_t c = 0; c < values.size(); ++c) answer.outputs[names_[c]] = values[c];
        return answer;
    }

private:
    void start() {
        const dttmm_step step{0, 0, kStep};
        std::vector<double> accelerations;
        for (const EndMotion& port : ports_) {
            const Eigen::Vector3d a = port.acceleration(), alpha(7, -11, 5);
            accelerations.insert(accelerations.end(), a.data(), a.data() + 3);
            accelerations.insert(accelerations.end(), alpha.data(), alpha.data() + 3);
        }
        check(table_.start(instance_, &step, motions(0).data(), accelerations.data(), nullptr, &error_));
    }
    std::vector<dttmm_motion> motions(uint64_t n) const {
        std::vector<dttmm_motion> at;
        for (const EndMotion& port : ports_) at.push_back(port.at(n));
        return at;
    }
    Answer make_answer() const {
        uint32_t count = 0;
        table_.blocks(instance_, &count);
        return {std::vector<double>(6 * ports_.size()), std::vector<double>(36 * size_t{count}), {}, {}, {}};
    }
    void check(dttmm_status status) { ASSERT_EQ(status, DTTMM_OK) << error_.text; }

    const dttmm_plugin& table_;
    dttmm_instance* instance_ = nullptr;
    dttmm_error error_{};
    std::vector<EndMotion> ports_;
    std::vector<std::string> names_;  ///< of the channels
};

}  // namespace dttmm::test
