// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <vector>

#include "mechanism/assembly.h"
#include "support/linear_algebra.h"

namespace dttmm::test {

using namespace plugin;

/// The linear motion of a network about its start, exactly: masses and springs assembled here into dense matrices, world
/// axes, six unknowns per frame inside; massless unknowns either follow at once (no dampers on them) or by their own
/// first-order equations. Moves by a matrix exponential under a load p (3 s² − 2 s³), s = t/T clipped, on one node; T = 0:
/// all of it from the start.
class ExactNetwork {
public:
    ExactNetwork(const Assembly& assembly, int node, const Eigen::Matrix<double, 6, 1>& load, double rise)
        : assembly_(assembly), driven_(assembly.driven_count), rise_(rise) {
        const Eigen::Index n = 6 * assembly.inner_count();
        M_.setZero(n, n);
        C_.setZero(n, n);
        K_.setZero(n, n);
        for (int f = 0; f < assembly.inner_count(); ++f) {
            const FrameSpec& frame = assembly.frames[static_cast<size_t>(driven_ + f)];
            M_.block<3, 3>(6 * f, 6 * f) = frame.mass * Matrix3::Identity();
            M_.block<3, 3>(6 * f + 3, 6 * f + 3) = frame.pose.rotation * frame.inertia * frame.pose.rotation.transpose();
        }
        for (const JointSpec& joint : assembly.joints) add(joint);
        Eigen::VectorXd p = Eigen::VectorXd::Zero(n);
        const NodeSpec& spec = assembly.nodes[static_cast<size_t>(node)];
        const FrameSpec& frame = assembly.frames[static_cast<size_t>(spec.frame)];
        frame_ = spec.frame - driven_;
        arm_ = frame.pose.rotation * spec.offset;
        p.segment<3>(6 * frame_) = load.head<3>();
        p.segment<3>(6 * frame_ + 3) = load.tail<3>() + arm_.cross(Eigen::Vector3d(load.head<3>()));
        build(p);
    }

    void advance(double dt) {
        const double rising = std::clamp(rise_ - time_, 0.0, dt);
        move(rate_, rising);
        move(after_, dt - rising);
        time_ += dt;
    }

    /// Displacement of the loaded node [m].
    Eigen::Vector3d displacement() const {
        const Eigen::VectorXd x = unknowns();
        return x.segment<3>(6 * frame_) + Eigen::Vector3d(x.segment<3>(6 * frame_ + 3)).cross(arm_);
    }
    /// Of all frames inside, 6 each.
    Eigen::VectorXd unknowns() const {
        Eigen::VectorXd x(M_.rows());
        const Eigen::Index a = static_cast<Eigen::Index>(massive_.size());
        for (Eigen::Index i = 0; i < a; ++i) x(massive_[static_cast<size_t>(i)]) = state_(i);
        const Eigen::VectorXd light = follows_
                                          ? Eigen::VectorXd(follow_ * state_.head(a))
                                          : Eigen::VectorXd(state_.segment(2 * a, static_cast<Eigen::Index>(light_.size())));
        for (size_t i = 0; i < light_.size(); ++i) x(light_[i]) = light(static_cast<Eigen::Index>(i));
        return x;
    }
    const Eigen::MatrixXd& M() const { return M_; }
    const Eigen::MatrixXd& K() const { return K_; }

private:
    /// Motion of the point P with a frame: v + ω × (P − origin); the relative one of both ends, in the joint's axes.
    void add(const JointSpec& joint) {
        Eigen::MatrixXd G = Eigen::MatrixXd::Zero(6, M_.rows());
        for (const auto& [index, sign] : {std::pair(joint.from, -1.0), std::pair(joint.to, 1.0)}) {
            if (index < driven_) continue;
            const Eigen::Vector3d arm = joint.pose.position - assembly_.frames[static_cast<size_t>(index)].pose.position;
            Eigen::Matrix<double, 6, 6> point = Eigen::Matrix<double, 6, 6>::Identity();
            point.topRightCorner<3, 3>() = -skew(arm);
            G.middleCols<6>(6 * (index - driven_)) += sign * point;
        }
        for (int half : {0, 3}) G.middleRows<3>(half) = (joint.pose.rotation.transpose() * G.middleRows<3>(half)).eval();
        K_ += stiffness_of(G, joint.law->stiffness);
        C_ += stiffness_of(G, joint.law->damping);
    }

    void build(const Eigen::VectorXd& p) {
        for (Eigen::Index i = 0; i < M_.rows(); ++i)
            (M_.row(i).isZero(0) ? light_ : massive_).push_back(static_cast<int>(i));
        const Eigen::MatrixXd Maa = M_(massive_, massive_), Kaa = K_(massive_, massive_), Caa = C_(massive_, massive_),
                              Kam = K_(massive_, light_), Cam = C_(massive_, light_), Kmm = K_(light_, light_),
                              Cmm = C_(light_, light_);
        const Eigen::Index a = Maa.rows(), m = Kmm.rows();
        const Eigen::MatrixXd W = test::inverse(Maa);
        follows_ = Cmm.isZero(0);
        const Eigen::Index n = follows_ ? 2 * a : 2 * a + m;
        rate_.setZero(n + 4, n + 4);
        rate_.block(0, a, a, a).setIdentity();
        Eigen::VectorXd push = Eigen::VectorXd::Zero(n);
        push.segment(a, a) = W * p(massive_);
        if (follows_) {
            follow_ = m > 0 ? Eigen::MatrixXd(-test::inverse(Kmm) * Kam.transpose()) : Eigen::MatrixXd(0, a);
            rate_.block(a, 0, a, a) = -W * (Kaa + Kam * follow_);
            rate_.block(a, a, a, a) = -W * Caa;
        } else {
            // C_mm x_m' = p_m − K_mm x_m − K_ma x_a − C_ma v_a
            const Eigen::MatrixXd inverse = test::inverse(Cmm);
            rate_.block(2 * a, 0, m, a) = -inverse * Kam.transpose();
            rate_.block(2 * a, a, m, a) = -inverse * Cam.transpose();
            rate_.block(2 * a, 2 * a, m, m) = -inverse * Kmm;
            push.segment(2 * a, m) = inverse * p(light_);
            rate_.block(a, 0, a, a) = -W * (Kaa + Cam * rate_.block(2 * a, 0, m, a));
            rate_.block(a, a, a, a) = -W * (Caa + Cam * rate_.block(2 * a, a, m, a));
            rate_.block(a, 2 * a, a, m) = -W * (Kam + Cam * rate_.block(2 * a, 2 * a, m, m));
            push.segment(a, a) -= W * Cam * push.segment(2 * a, m);
        }
        for (int power = 1; power <= 3; ++power) rate_(n + power, n + power - 1) = power;
        after_ = rate_;
        if (rise_ > 0) {
            rate_.block(0, n + 2, n, 1) = 3 / (rise_ * rise_) * push;
            rate_.block(0, n + 3, n, 1) = -2 / (rise_ * rise_ * rise_) * push;
        }
        after_.block(0, n, n, 1) = push;
        state_.setZero(n + 4);
        state_(n) = 1;
    }

    void move(const Eigen::MatrixXd& A, double dt) {
        if (dt <= 1e-15) return;
        if (!(dt == known_dt_ && &A == known_)) {
            exponential_ = exponential(A * dt);
            known_dt_ = dt;
            known_ = &A;
        }
        state_ = (exponential_ * state_).eval();
    }

    const Assembly& assembly_;
    int driven_, frame_ = 0;
    Eigen::Vector3d arm_;
    double rise_, time_ = 0, known_dt_ = 0;
    bool follows_ = true;
    Eigen::MatrixXd M_, C_, K_, follow_, rate_, after_, exponential_;
    std::vector<int> massive_, light_;
    const Eigen::MatrixXd* known_ = nullptr;
    Eigen::VectorXd state_;
};

}  // namespace dttmm::test
