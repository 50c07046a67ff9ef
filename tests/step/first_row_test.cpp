// SPDX-License-Identifier: BSD-3-Clause
//
// The first row of results: accelerations and forces at the start where hinges are rigid, whatever the step.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/QR>
#include <map>
#include <regex>
#include <utility>
#include <vector>

#include "support/random_machine.h"
#include "support/recorded_run.h"

namespace dttmm::host {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using test::RecordedRun;

/// What moves, with what is known of it at the start; world axes.
struct Part {
    double mass = 0;
    Matrix3d inertia = Matrix3d::Zero();  ///< about the centre of mass
    Vector3d position = Vector3d::Zero();
    Vector3d velocity = Vector3d::Zero(), angular_velocity = Vector3d::Zero();
    Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero();
    // Found:
    Vector3d acceleration = Vector3d::Zero(), angular_acceleration = Vector3d::Zero();

    Vector3d velocity_at(const Vector3d& point) const { return velocity + angular_velocity.cross(point - position); }
    Vector3d acceleration_at(const Vector3d& point) const {
        const Vector3d arm = point - position;
        return acceleration + angular_acceleration.cross(arm) + angular_velocity.cross(angular_velocity.cross(arm));
    }
    void push(const Vector3d& by, const Vector3d& at) {
        force += by;
        moment += (at - position).cross(by);
    }
};

/// A joint in the axes of its `from` end, which acts at a point; from −1: the ground.
struct Link {
    int from, to;
    Matrix3d axes;
    Vector3d point;
    std::vector<int> rigid;  ///< of x y z rx ry rz
    // Found, at the `from` end in these axes:
    Vector3d force = Vector3d::Zero(), moment = Vector3d::Zero();
};

/// M a + Jᵀ q = f, J a = −(second rate of the deformations at constant velocities), written out in full; least squares where
/// a massless part is free to turn.
void accelerate(std::vector<Part>& parts, std::vector<Link>& links, const Vector3d& gravity) {
    Eigen::Index rows = 0;
    for (const Link& link : links) rows += static_cast<Eigen::Index>(link.rigid.size());
    const auto size = static_cast<Eigen::Index>(6 * parts.size());
    Eigen::MatrixXd A = Eigen::MatrixXd::Zero(size + rows, size + rows);
    Eigen::VectorXd b = Eigen::VectorXd::Zero(size + rows);
    for (size_t i = 0; i < parts.size(); ++i) {
        const Part& part = parts[i];
        const auto at = static_cast<Eigen::Index>(6 * i);
        A.block<3, 3>(at, at) = part.mass * Matrix3d::Identity();
        A.block<3, 3>(at + 3, at + 3) = part.inertia;
        b.segment<3>(at) = part.force + part.mass * gravity;
        b.segment<3>(at + 3) = part.moment - part.angular_velocity.cross(part.inertia * part.angular_velocity);
    }
    Eigen::Index row = size;
    for (const Link& link : links) {
        const Part still, &from = link.from < 0 ? still : parts[static_cast<size_t>(link.from)],
                          &to = parts[static_cast<size_t>(link.to)];
        const Vector3d arm = link.point - from.position, lever = link.point - to.position;
        const Vector3d &w = from.angular_velocity, &w_to = to.angular_velocity;
        const Vector3d slide = to.velocity_at(link.point) - from.velocity_at(link.point);
        const Vector3d known = w_to.cross(w_to.cross(lever)) - w.cross(w.cross(arm)) - 2 * w.cross(slide);
        for (int d : link.rigid) {
            const Vector3d e = link.axes.col(d % 3);
            Eigen::Matrix<double, 1, 12> J = Eigen::Matrix<double, 1, 12>::Zero();
            if (d < 3) {
                J << -e.transpose(), -arm.cross(e).transpose(), e.transpose(), lever.cross(e).transpose();
                b(row) = -e.dot(known);
            } else {
                J.segment<3>(3) = -e;
                J.segment<3>(9) = e;
                b(row) = e.dot(w.cross(w_to));
            }
            for (const auto& [part, half] : {std::pair(link.from, 0), {link.to, 6}}) {
                if (part < 0) continue;
                A.block<1, 6>(row, 6 * part) += J.segment<6>(half);
                A.block<6, 1>(6 * part, row) += J.segment<6>(half).transpose();
            }
            ++row;
        }
    }
    const Eigen::VectorXd x = A.completeOrthogonalDecomposition().solve(b);
    EXPECT_LT((A * x - b).norm(), 1e-10 * b.norm()) << "the oracle contradicts itself";
    for (size_t i = 0; i < parts.size(); ++i) {
        parts[i].acceleration = x.segment<3>(static_cast<Eigen::Index>(6 * i));
        parts[i].angular_acceleration = x.segment<3>(static_cast<Eigen::Index>(6 * i + 3));
    }
    row = size;
    for (Link& link : links)
        for (int d : link.rigid) (d < 3 ? link.force : link.moment)(d % 3) = x(row++);
}

std::string list(const Vector3d& v) { return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z()); }
std::string place(const Vector3d& position, const Matrix3d& axes) {
    const Eigen::Quaterniond q(axes);
    return fmt::format("position = {}, quaternion = [{:.17g}, {:.17g}, {:.17g}, {:.17g}]", list(position), q.w(), q.x(),
                       q.y(), q.z());
}
Matrix3d turn(double angle, const Vector3d& axis) { return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix(); }

/// Masses a, c and d in a chain of hinges, between a and c over the massless node b, all apart and turned; a spring with a
/// damper holds a, another joins c to the body p. q is a body on a hinge at c.
class HingedMasses {
public:
    HingedMasses(bool moves, bool has_gravity, bool has_body_on_hinge) : has_q_(has_body_on_hinge) {
        if (has_gravity) gravity_ = {0.7, -9.3, 2.1};
        const double v = moves ? 1 : 0;
        parts_.resize(has_q_ ? 6 : 5);
        Part &a = parts_[0], &b = parts_[1], &c = parts_[2], &d = parts_[3], &p = parts_[4];
        a.mass = 1.3;
        a.inertia =
            in_world(A_, (Matrix3d() << 0.011, 0.001, -0.002, 0.001, 0.013, 0.0015, -0.002, 0.0015, 0.017).finished());
        a.position = a_ + A_ * centre_of_a_;
        b.position = b_;
        c.mass = 0.45;
        c.inertia = in_world(C_, Vector3d(0.004, 0.0052, 0.0061).asDiagonal());
        c.position = c_ + C_ * centre_of_c_;
        d.mass = 0.21;
        d.position = d_;
        p.mass = 2.2;
        p.inertia = in_world(P_, Vector3d(0.02, 0.03, 0.025).asDiagonal());
        p.position = p_;

        a.angular_velocity = v * Vector3d(1.7, -2.3, 0.9);
        a.velocity = v * Vector3d(0.3, 0.8, -0.5);
        b.angular_velocity = a.angular_velocity + v * 3.1 * A_.col(2);
        b.velocity = a.velocity_at(b_);
        c.angular_velocity = b.angular_velocity - v * 2.2 * B_.col(0);
        c.velocity = b.velocity_at(c_) + v * 0.6 * B_.col(0) + c.angular_velocity.cross(c.position - c_);
        d.angular_velocity = c.angular_velocity;
        d.velocity = c.velocity_at(d_);
        p.angular_velocity = v * Vector3d(0.4, 0.5, -1.2);
        p.velocity = v * Vector3d(-0.7, 0.1, 0.35);
        links_ = {{0, 1, A_, b_, {0, 1, 2, 3, 4}}, {1, 2, B_, c_, {1, 2, 4, 5}}, {2, 3, C_, d_, {0, 1, 2, 3, 4}}};
        if (has_q_) {
            Part& q = parts_[5];
            q.mass = 0.9;
            q.inertia = in_world(Q_, Vector3d(0.007, 0.009, 0.012).asDiagonal());
            q.position = q_;
            q.angular_velocity = c.angular_velocity + v * 1.4 * C_.col(1);
            q.velocity = c.velocity_at(marker_q()) + q.angular_velocity.cross(q_ - marker_q());
            links_.push_back({2, 5, C_, marker_q(), {0, 1, 2, 3, 5}});
        }

        // Springs are without force at the start, dampers act by the rates
        const auto damp = [&](int from, int to, const Matrix3d& axes, const Vector3d& point, const Vector3d& by_rate,
                              const Vector3d& by_turning) {
            Part still;
            Part &first = from < 0 ? still : parts_[static_cast<size_t>(from)], &second = parts_[static_cast<size_t>(to)];
            const Vector3d rate = axes.transpose() * (second.velocity_at(point) - first.velocity_at(point)),
                           turning = axes.transpose() * (second.angular_velocity - first.angular_velocity);
            const Vector3d force = axes * by_rate.cwiseProduct(rate), moment = axes * by_turning.cwiseProduct(turning);
            first.push(force, point);
            second.push(-force, point);
            first.moment += moment;
            second.moment -= moment;
        };
        damp(-1, 0, W_, a_, {4, 3, 7}, {0.2, 0.3, 0.1});
        damp(1, 2, B_, c_, {5, 0, 0}, {0.04, 0, 0});
        damp(2, 4, C_, marker_p(), {9, 2, 6}, {0.5, 0.1, 0.3});
        b.push(kLoadOnB, b_);
        d.push(kLoadOnD, d_);
        a.push(kLoadOnA, a_);
        accelerate(parts_, links_, gravity_);
    }

    std::string text(double step) const {
        const Part &a = parts_[0], &c = parts_[2], &p = parts_[4];
        std::string text = fmt::format(
            R"toml(
[simulation]
duration = {0}
step = {0}
gravity = {1}
[output]
step = {0}
[nodes]
wall = {{ {2}, fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
a = {{ {3}, velocity = {4}, angular_velocity = {5} }}
b = {{ {6} }}
c = {{ {7}, velocity = {8}, angular_velocity = {9} }}
d = {{ {10} }}
)toml",
            step, list(gravity_), place({-0.2, 0.1, 0.05}, W_), place(a_, A_), list(a.velocity_at(a_)),
            list(a.angular_velocity), place(b_, B_), place(c_, C_), list(c.velocity_at(c_)), list(c.angular_velocity),
            place(d_, Matrix3d::Identity()));
        text += body("p", p, P_, kMarkerP);
        if (has_q_) text += body("q", parts_[5], Q_, kMarkerQ);
        text += fmt::format(R"toml(
[[element]]
name = "s1"
type = "spring_damper"
from = "wall"
to = "a"
stiffness = [3000, 2000, 5000]
damping = [4, 3, 7]
rotational_stiffness = [10, 14, 20]
rotational_damping = [0.2, 0.3, 0.1]
[[element]]
name = "h1"
type = "elastic_hinge"
from = "a"
to = "b"
stiffness = {{ rz = "free" }}
[[element]]
name = "h2"
type = "elastic_hinge"
from = "b"
to = "c"
stiffness = {{ x = 700, rx = 30 }}
damping = {{ x = 5, rx = 0.04 }}
[[element]]
name = "h3"
type = "elastic_hinge"
from = "c"
to = "d"
stiffness = {{ rz = 20 }}
[[element]]
name = "s2"
type = "spring_damper"
from = "c"
to = "p.m"
stiffness = [2000, 1500, 2500]
damping = [9, 2, 6]
rotational_stiffness = 12
rotational_damping = [0.5, 0.1, 0.3]
[[element]]
name = "ma"
type = "rigid_body"
at = "a"
mass = 1.3
center_of_mass = {}
inertia = {{ xx = 0.011, yy = 0.013, zz = 0.017, xy = 0.001, xz = -0.002, yz = 0.0015 }}
[[element]]
name = "mc"
type = "rigid_body"
at = "c"
mass = 0.45
center_of_mass = {}
inertia = {{ xx = 0.004, yy = 0.0052, zz = 0.0061 }}
[[element]]
name = "md"
type = "point_mass"
at = "d"
mass = 0.21
)toml",
                            list(centre_of_a_), list(centre_of_c_));
        if (has_q_)
            text += R"toml(
[[element]]
name = "h4"
type = "elastic_hinge"
from = "c"
to = "q.m"
stiffness = { ry = "free" }
)toml";
        for (const auto& [node, load] : {std::pair("a", kLoadOnA), {"b", kLoadOnB}, {"d", kLoadOnD}})
            text += fmt::format("[[load]]\non = \"{}\"\ndirection = {}\nforce = {:.17g}\n", node, list(load.normalized()),
                                load.norm());
        return text;
    }

    /// Of nodes and bodies, by name.
    std::map<std::string, Vector3d> accelerations() const {
        std::map<std::string, Vector3d> result = {{"a", parts_[0].acceleration_at(a_)},
                                                  {"b", parts_[1].acceleration_at(b_)},
                                                  {"c", parts_[2].acceleration_at(c_)},
                                                  {"d", parts_[3].acceleration_at(d_)},
                                                  {"p", parts_[4].acceleration}};
        if (has_q_) result["q"] = parts_[5].acceleration;
        return result;
    }
    const std::vector<Link>& links() const { return links_; }

private:
    static Matrix3d in_world(const Matrix3d& axes, const Matrix3d& tensor) { return axes * tensor * axes.transpose(); }
    Vector3d marker_p() const { return p_ + P_ * kMarkerP; }
    Vector3d marker_q() const { return q_ + Q_ * kMarkerQ; }
    static std::string body(const char* name, const Part& part, const Matrix3d& axes, const Vector3d& marker) {
        std::string at = place(part.position, axes);
        at.replace(at.find(", quaternion"), 1, "\n");
        const Vector3d inertia = (axes.transpose() * part.inertia * axes).diagonal();
        return fmt::format(
            "[[body]]\nname = \"{}\"\nmass = {}\ninertia = {}\n{}\nvelocity = {}\nangular_velocity = {}\nmarkers.m = {}\n",
            name, part.mass, list(inertia), at, list(part.velocity), list(part.angular_velocity), list(marker));
    }

    inline static const Vector3d kLoadOnA{1.5, -7, 3}, kLoadOnB{6, 4, -9}, kLoadOnD{-2, 3, 1.2};
    inline static const Vector3d kMarkerP{-0.1, 0.04, 0.03}, kMarkerQ{0.05, -0.08, 0.02};
    const Vector3d a_{0.1, 0.02, -0.03}, b_{0.31, 0.11, 0.04}, c_{0.42, -0.07, 0.13}, d_{0.55, 0.04, 0.3},
        p_{0.6, -0.2, 0.1}, q_{0.5, -0.3, 0.25}, centre_of_a_{0.03, -0.05, 0.02}, centre_of_c_{-0.02, 0.01, 0.04};
    const Matrix3d W_ = turn(0.3, {1, 1, -2}), A_ = turn(0.9, {1, 2, 3}), B_ = turn(-1.3, {2, -1, 1}),
                   C_ = turn(2.1, {-1, 1, 0.5}), P_ = turn(0.5, {0, 1, 1}), Q_ = turn(-0.8, {3, 1, -2});
    bool has_q_;
    Vector3d gravity_ = Vector3d::Zero();
    std::vector<Part> parts_;
    std::vector<Link> links_;
};

void expect_first_row(bool has_body_on_hinge) {
    for (const bool moves : {false, true})
        for (const bool has_gravity : {false, true}) {
            const HingedMasses machine(moves, has_gravity, has_body_on_hinge);
            for (const double step : {5e-3, 1e-4, 1e-6}) {
                const RecordedRun rows(machine.text(step));
                const std::string which = fmt::format("moves {} gravity {} step {}: ", moves, has_gravity, step);
                const auto expected = machine.accelerations();
                double largest = 0;
                for (const auto& [name, a] : expected) largest = std::max(largest, a.norm());
                for (const auto& [name, a] : expected) {
                    const Vector3d found = rows.vector(0, name + ".acceleration");
                    EXPECT_LT((found - a).norm(), 1e-10 * largest)
                        << which << name << ": " << found.transpose() << " for " << a.transpose();
                }
                for (size_t l = 0; l < machine.links().size(); ++l) {
                    const Link& link = machine.links()[l];
                    const std::string name = fmt::format("h{}", l + 1);
                    for (int d : link.rigid) {
                        const double found = rows.vector(0, name + (d < 3 ? ".force" : ".moment"))(d % 3),
                                     q = (d < 3 ? link.force : link.moment)(d % 3);
                        EXPECT_NEAR(found, q, 1e-10 * (link.force.norm() + link.moment.norm())) << which << name << " " << d;
                    }
                }
            }
        }
}

// Oracle: M a + Jᵀ q = f as a dense system. Rounding only separates them, whatever the step.
TEST(FirstRow, HingedMassesAccelerateAsADenseSystem) { expect_first_row(false); }

// Oracle: the same with a body on a hinge at a mass: the network and the bodies accelerate together.
TEST(FirstRow, ABodyOnAHingeAtAMassAcceleratesWithIt) { expect_first_row(true); }

// Oracle: continuity. In random machines with massless nodes on rods and hinges, some beside dampers that relax much faster
// than the step, the first row goes on to the second. n2 of the first changes by 0.08 m/s^2 in a microsecond at the start:
// at 6.80 then, it is at 3.68 after 0.1 ms, with steps of 1 us. So the steps are shorter than that.
TEST(FirstRow, NodesOnRigidMassesGoOnToTheSecondRow) {
    for (const uint64_t seed : {5u, 46u, 56u}) {
        const std::string text =
            std::regex_replace(test::RandomMachine(seed, 5).text(), std::regex("\nduration = [^\n]*"), "\nduration = 5e-5");
        const RecordedRun rows(std::regex_replace(text, std::regex("\nstep = [^\n]*"), "\nstep = 1e-5"));
        for (const std::string node : {"n1", "n2", "n5", "n6"}) {
            if (text.find("\n" + node + " = ") == std::string::npos) continue;
            EXPECT_LT((rows.vector(0, node + ".acceleration") - rows.vector(1, node + ".acceleration")).norm(), 3)
                << seed << " " << node;
        }
    }
}

// Oracle: a shorter step is no harder. Where joints hold bodies that springs pull with some kN the corrections stay at 2 to
// 5 times the rounding of a body's place over the step, and so they did 50 times.
TEST(FirstRow, ShortStepsEndAtRounding) {
    const std::string text = test::RandomMachine(20, 60).text();
    for (const double step : {3e-5, 4e-6, 5e-7}) {
        const std::string shorter = fmt::format("\n$1 = {}", step), run = fmt::format("\nduration = {}", 60 * step);
        const RecordedRun rows(std::regex_replace(std::regex_replace(text, std::regex("\n(step) = [^\n]*"), shorter),
                                                  std::regex("\nduration = [^\n]*"), run));
        EXPECT_EQ(rows.count(), 61u);
    }
}

// Oracle: at rest nothing speeds up. All accelerations there are rounding, and so is what bodies and network have to settle.
TEST(FirstRow, NothingSpeedsUpAtRest) {
    std::string text = test::RandomMachine(673, 2).text();
    text.erase(text.find("[[load]]"));
    text.insert(text.find("[simulation]\n") + 13, "start = \"equilibrium\"\n");
    const size_t gravity = text.find("gravity = [") + 11, end = text.find(',', gravity);
    const double g = std::stod(text.substr(gravity, end - gravity));
    for (int i = 0; i < 25; ++i) {
        std::string other = text;
        other.replace(gravity, end - gravity, fmt::format("{:.17g}", g * (1 + 1e-11 * i)));
        const RecordedRun rows(other);
        for (const char* part : {"b0", "b1", "b2", "n1"})
            EXPECT_LT(rows.vector(0, std::string(part) + ".acceleration").norm(), 1e-3) << i << " " << part;
    }
}

// Oracle: the instant knows no step. Beams' ends on rods that lead to masses and to a body, in random machines.
TEST(FirstRow, ANodeOnARodAtABodyHasOneAccelerationAtEveryStep) {
    for (const auto& [seed, node] : {std::pair{5u, "n2"}, {379u, "n0"}, {561u, "n0"}}) {
        const std::string text = test::RandomMachine(seed).text();
        const auto first = [&](const char* step) {
            const std::string other = std::string("\n$1 = ") + step;
            return RecordedRun(std::regex_replace(text, std::regex("\n(step|duration) = [^\n]*"), other))
                .vector(0, std::string(node) + ".acceleration");
        };
        const Vector3d fine = first("1e-6");
        for (const char* step : {"1e-5", "1e-4", "5e-4"})
            EXPECT_LT((first(step) - fine).norm(), 1e-9 * fine.norm())
                << seed << " " << step << ": " << first(step).transpose();
    }
}

}  // namespace
}  // namespace dttmm::host
