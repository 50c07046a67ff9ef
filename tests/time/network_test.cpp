// SPDX-License-Identifier: BSD-3-Clause
#include "time/network.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <functional>
#include <random>

#include "core/error.h"
#include "core/rotation.h"
#include "support/dense_network.h"
#include "support/network_model.h"
#include "support/spring_values.h"

namespace dttmm::plugin {
namespace {

using test::DenseNetwork;

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajorX = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Values = std::vector<double>;

//                       stiffness           damping         rotational stiffness   rotational damping
const Values kUgly = test::spring_values({5e5, 7.3e6, 1.2e4, 100, 0.7, 330, 2e3, 8.1e4, 300, 5, 0.01, 90});
const Values kSoft = test::spring_values({1e3, 2e3, 3e3, 4, 5, 6, 0, 0, 0, 0, 0, 0});

/// A pose and twist that a test moves around.
struct StartFrame {
    Vector3 position;
    Matrix3 rotation;
    Vector3 velocity = Vector3::Zero();
    Vector3 angular_velocity = Vector3::Zero();

    dttmm_motion motion() const {
        dttmm_motion m;
        Eigen::Map<Vector3>{m.position} = position;
        Eigen::Map<RowMajor3>{m.rotation} = rotation;
        Eigen::Map<Vector3>{m.velocity} = velocity;
        Eigen::Map<Vector3>{m.angular_velocity} = angular_velocity;
        return m;
    }
    /// The frame after a step of size h.
    StartFrame after(double h) const {
        return {position + h * velocity, rotation_from_vector(h * angular_velocity) * rotation, velocity, angular_velocity};
    }
    StartFrame displaced(const Vector6& d) const {
        return {position + d.head<3>(), rotation_from_vector(d.tail<3>()) * rotation, velocity, angular_velocity};
    }
};

const StartFrame kLeft{Vector3(0.3, -0.1, 0.2), rotation_from_vector(Vector3(0.4, -0.8, 1.3)), Vector3(0.2, -0.3, 0.1),
                       Vector3(0.5, 0.9, -0.4)};
const StartFrame kRight{Vector3(0.7, 0.25, -0.3), rotation_from_vector(Vector3(-1.1, 0.2, 0.6)), Vector3(-0.1, 0.4, 0.6),
                        Vector3(-0.8, 0.3, 0.7)};

constexpr uint32_t kFromTo[] = {0, 1};

dttmm_node node(const char* name, uint32_t kind, const StartFrame& frame, uint32_t body = 0) {
    dttmm_node n{name, kind, body, {}, {}, 0, 0, {}, {}};
    Eigen::Map<Vector3>{n.position} = frame.position;
    Eigen::Map<RowMajor3>{n.rotation} = frame.rotation;
    return n;
}

/// A body with its centre of mass at a node.
dttmm_body body(const dttmm_node& node) {
    dttmm_body b{node.name, {}, {}, 1, {1, 0, 0, 0, 1, 0, 0, 0, 1}};
    std::copy_n(node.position, 3, b.position);
    std::copy_n(node.rotation, 9, b.rotation);
    return b;
}

/// A network of up to three nodes and two elements, the description kept alive for the call of the constructor only.
DenseNetwork make_network(uint32_t scheme, bool grounded_left, const Values& values = kUgly, Centred centred = {}) {
    const dttmm_node nodes[] = {node("left", grounded_left ? DTTMM_NODE_GROUND : DTTMM_NODE_ON_BODY, kLeft),
                                node("right", DTTMM_NODE_ON_BODY, kRight, grounded_left ? 0 : 1)};
    const dttmm_body bodies[] = {body(nodes[0]), body(nodes[1])};
    const dttmm_element elements[] = {{"joint", 0, 2, kFromTo, values.data()}};
    const uint32_t count = grounded_left ? 1 : 2;
    return DenseNetwork({count,
                         bodies + 2 - count,
                         2,
                         nodes,
                         1,
                         elements,
                         scheme,
                         centred.beta,
                         centred.gamma,
                         {},
                         0,
                         nullptr,
                         0,
                         nullptr,
                         nullptr,
                         0});
}

/// Two parallel elements, the second the other way round: three ports, two elements, so that a swapped index shows.
DenseNetwork make_pair(uint32_t scheme, const Values& first = kUgly, const Values& second = kSoft) {
    const StartFrame third{Vector3(-0.2, 0.1, 0.9), rotation_from_vector(Vector3(0.1, 0.2, 0.3))};
    const dttmm_node nodes[] = {node("left", DTTMM_NODE_ON_BODY, kLeft), node("right", DTTMM_NODE_ON_BODY, kRight, 1),
                                node("third", DTTMM_NODE_ON_BODY, third, 2)};
    const dttmm_body bodies[] = {body(nodes[0]), body(nodes[1]), body(nodes[2])};
    const uint32_t third_to_right[] = {2, 1};
    const dttmm_element elements[] = {{"a", 0, 2, kFromTo, first.data()}, {"b", 0, 2, third_to_right, second.data()}};
    return DenseNetwork({3, bodies, 3, nodes, 2, elements, scheme, 0.25, 0.5, {}, 0, nullptr, 0, nullptr, nullptr, 0});
}

/// The deformation by definition, written anew: the `to` end in the axes of the `from` end, less the same at rest.
Vector6 deformation_of(const StartFrame& from, const StartFrame& to) {
    Vector6 d;
    d.head<3>() = from.rotation.transpose() * (to.position - from.position) -
                  kLeft.rotation.transpose() * (kRight.position - kLeft.position);
    const Matrix3 rest = kLeft.rotation.transpose() * kRight.rotation;
    const Eigen::AngleAxisd turn(Matrix3(from.rotation.transpose() * to.rotation * rest.transpose()));
    d.tail<3>() = turn.angle() * turn.axis();
    return d;
}

/// Rotation of the `to` end relative to the `from` end, identity at rest, and the vector between two of them.
Matrix3 attitude_of(const StartFrame& from, const StartFrame& to) {
    return from.rotation.transpose() * to.rotation * (kLeft.rotation.transpose() * kRight.rotation).transpose();
}
Vector3 turn_between(const Matrix3& before, const Matrix3& after) {
    const Eigen::AngleAxisd turn(Matrix3(after * before.transpose()));
    return turn.angle() * turn.axis();
}

/// J⁻ᵀ(θ) k ∘ θ as the gradient of ½ θᵀ k θ by the turn, by central differences (1e-9).
Vector3 elastic_moment(const Vector3& k, const Matrix3& attitude) {
    const auto energy = [&](const Vector3& turn) {
        const Vector3 theta = turn_between(Matrix3::Identity(), rotation_from_vector(turn) * attitude);
        return 0.5 * theta.dot(k.cwiseProduct(theta));
    };
    Vector3 m;
    for (int i = 0; i < 3; ++i) m(i) = (energy(1e-5 * Vector3::Unit(i)) - energy(-1e-5 * Vector3::Unit(i))) / 2e-5;
    return m;
}

Vector6 stiffness_of(const Values& v) { return (Vector6() << v[0], v[1], v[2], v[6], v[7], v[8]).finished(); }
Vector6 damping_of(const Values& v) { return (Vector6() << v[3], v[4], v[5], v[9], v[10], v[11]).finished(); }

dttmm_status status_of(const std::function<void()>& call) {
    try {
        call();
        return DTTMM_OK;
    } catch (const Error& error) {
        return error.status();
    }
}

// ---- The force law at one instant ---------------------------------------------------------------------------------------

// Oracle: f = k d + c d' with d' by central difference of the deformation along the motion; force on `to` is −R_from f.
TEST(Network, LinearisedWrenchIsTheForceLaw) {
    const DenseNetwork network = make_network(DTTMM_SCHEME_CENTRED, false);
    const StartFrame left = kLeft.displaced((Vector6() << 0.01, -0.02, 0.03, 0.04, -0.05, 0.06).finished()), right = kRight;
    const double e = 1e-5;
    const Vector6 rate =
        (deformation_of(left.after(e), right.after(e)) - deformation_of(left.after(-e), right.after(-e))) / (2 * e);
    Vector6 f = stiffness_of(kUgly).cwiseProduct(deformation_of(left, right));
    f.head<3>() += damping_of(kUgly).head<3>().cwiseProduct(rate.head<3>());
    const dttmm_motion ports[] = {left.motion(), right.motion()};
    Vector12 wrench;
    network.linearise(ports, wrench.data(), nullptr, nullptr);
    EXPECT_LT((wrench.segment<3>(6) + left.rotation * f.head<3>()).norm(), 1e-8 * f.head<3>().norm());
    // A rotation's moment is the gradient of ½ θᵀ k θ, and damps the relative angular velocity.
    const Vector3 relative = left.rotation.transpose() * (right.angular_velocity - left.angular_velocity);
    const Vector3 m = elastic_moment(stiffness_of(kUgly).tail<3>(), attitude_of(left, right)) +
                      damping_of(kUgly).tail<3>().cwiseProduct(relative);
    EXPECT_LT((wrench.tail<3>() + left.rotation * m).norm(), 1e-8 * m.norm());
}

// Oracle: central differences of the wrench by pose and by velocity, port by port; their error is about 1e-9.
TEST(Network, LinearisedStiffnessAndDampingAreDerivativesOfTheWrench) {
    const DenseNetwork network = make_network(DTTMM_SCHEME_CENTRED, false, kUgly);
    // At rest the force vanishes, so that only the law varies, not the direction in which a finite force acts.
    StartFrame ports[] = {kLeft, kRight};
    ports[0].velocity = ports[0].angular_velocity = ports[1].velocity = ports[1].angular_velocity = Vector3::Zero();
    const auto wrench_at = [&](const StartFrame& left, const StartFrame& right) {
        const dttmm_motion motion[] = {left.motion(), right.motion()};
        Vector12 wrench;
        network.linearise(motion, wrench.data(), nullptr, nullptr);
        return wrench;
    };
    const dttmm_motion motion[] = {ports[0].motion(), ports[1].motion()};
    Vector12 wrench;
    Eigen::Matrix<double, 12, 12, Eigen::RowMajor> S, D;
    network.linearise(motion, wrench.data(), S.data(), D.data());
    for (int p = 0; p < 2; ++p)
        for (int i = 0; i < 6; ++i) {
            const double e = 1e-6;
            StartFrame plus[] = {ports[0], ports[1]}, minus[] = {ports[0], ports[1]};
            plus[p] = ports[p].displaced(e * Vector6::Unit(i));
            minus[p] = ports[p].displaced(-e * Vector6::Unit(i));
            const Vector12 by_pose = -(wrench_at(plus[0], plus[1]) - wrench_at(minus[0], minus[1])) / (2 * e);
            EXPECT_LT((S.col(6 * p + i) - by_pose).norm(), 1e-6 * S.norm()) << "pose " << i << " of port " << p;

            plus[p] = minus[p] = ports[p];
            (i < 3 ? plus[p].velocity(i) : plus[p].angular_velocity(i - 3)) += 1;
            (i < 3 ? minus[p].velocity(i) : minus[p].angular_velocity(i - 3)) -= 1;
            const Vector12 by_velocity = -(wrench_at(plus[0], plus[1]) - wrench_at(minus[0], minus[1])) / 2;
            EXPECT_LT((D.col(6 * p + i) - by_velocity).norm(), 1e-12 * D.norm()) << "velocity " << i << " of port " << p;
        }
    EXPECT_LT((S - S.transpose()).norm(), 1e-14 * S.norm()) << "the stiffness of a conservative joint at rest is symmetric";
}

// ---- Time steps ---------------------------------------------------------------------------------------------------------

constexpr double kStep = 1.7e-3;

/// Starts at rest in kLeft, kRight and takes two steps along the ports' velocities, so that the history is not trivial.
void advance_twice(DenseNetwork& network, StartFrame& left, StartFrame& right) {
    const dttmm_motion start[] = {left.motion(), right.motion()};
    const double accelerations[18] = {};
    network.start({0, 0, kStep}, start, accelerations, nullptr);
    for (uint64_t n = 0; n < 2; ++n) {
        left = left.after(kStep);
        right = right.after(kStep);
        const dttmm_motion accepted[] = {left.motion(), right.motion()};
        network.begin_step({n, static_cast<double>(n) * kStep, kStep}, nullptr);
        network.commit_step(accepted);
    }
}

/// What an elastic joint does to its ends at one instant, written anew: force and moment on `to` and the moment on `from`.
struct Push {
    Vector3 force, moment, on_from;
};
Push push_at(const StartFrame& left, const StartFrame& right) {
    const Vector6 k = stiffness_of(kUgly), d = deformation_of(left, right);
    const Vector3 theta = d.tail<3>();
    const Vector3 force = left.rotation * k.head<3>().cwiseProduct(d.head<3>());
    const Vector3 moment =
        left.rotation * Vector3(rotation_vector_rate(theta).transpose() * k.tail<3>().cwiseProduct(theta));
    return {force, moment, moment + (right.position - left.position).cross(force)};
}

// Oracle: the centred formula of the design written out for one joint, β and γ odd: the even part of the weights with the
// elastic wrenches of three instants, each in the axes and over the arm of its own; the odd part and the damper by the
// increments of the deformation over the two steps, in the axes and over the arm of t_{n+1} and of t_{n−1}.
TEST(Network, CentredWrenchIsTheWeightedForceLaw) {
    const Centred centred{0.31, 0.56};
    DenseNetwork network = make_network(DTTMM_SCHEME_CENTRED, false, kUgly, centred);
    StartFrame left = kLeft, right = kRight;
    const StartFrame before_left = kLeft.after(kStep), before_right = kRight.after(kStep);
    advance_twice(network, left, right);
    const StartFrame next_left = left.after(kStep).displaced((Vector6() << 1e-3, 2e-3, -1e-3, 3e-3, -2e-3, 1e-3).finished());
    const StartFrame next_right = right.after(kStep);
    const Vector3 d_after = deformation_of(next_left, next_right).head<3>(), d_now = deformation_of(left, right).head<3>(),
                  d_before = deformation_of(before_left, before_right).head<3>();
    const Matrix3 Q = attitude_of(left, right);
    const Vector3 turn_after = turn_between(Q, attitude_of(next_left, next_right)),
                  turn_before = turn_between(attitude_of(before_left, before_right), Q);
    const Vector6 c = damping_of(kUgly), k = stiffness_of(kUgly);
    const double odd = 0.5 * (0.56 - 0.5), even = 0.31 - odd;
    Vector3 F = Vector3::Zero(), M = F, on_from = F;
    const auto add_rates = [&](double weight, const StartFrame& from, const StartFrame& to, const Vector3& slide,
                               const Vector3& turn) {
        const Vector6 per_increment = weight / kStep * c + odd * k;
        const Vector3 force = from.rotation * per_increment.head<3>().cwiseProduct(slide),
                      moment = from.rotation * per_increment.tail<3>().cwiseProduct(turn);
        F += force;
        M += moment;
        on_from += moment + (to.position - from.position).cross(force);
    };
    add_rates(0.56, next_left, next_right, d_after - d_now, turn_after);
    add_rates(0.44, before_left, before_right, d_now - d_before, turn_before);
    const auto add = [&](double weight, const Push& push) {
        F += weight * push.force;
        M += weight * push.moment;
        on_from += weight * push.on_from;
    };
    add(even, push_at(next_left, next_right));
    add(1 - 2 * even, push_at(left, right));
    add(even, push_at(before_left, before_right));

    network.begin_step({2, 2 * kStep, kStep}, nullptr);
    const dttmm_motion trial[] = {next_left.motion(), next_right.motion()};
    Vector12 wrench;
    network.evaluate(trial, wrench.data(), nullptr);
    EXPECT_LT((wrench.segment<3>(6) + F).norm(), 1e-11 * F.norm());
    EXPECT_LT((wrench.segment<3>(9) + M).norm(), 1e-11 * M.norm());
    EXPECT_LT((wrench.segment<3>(0) - F).norm(), 1e-11 * F.norm());
    EXPECT_LT((wrench.segment<3>(3) - on_from).norm(), 1e-11 * on_from.norm());
}

/// −∂(wrench)/∂(trial pose) by central differences, and as evaluate() gives it, with three ports at rest where `way` times
/// their velocities takes them.
std::pair<Eigen::MatrixXd, Eigen::MatrixXd> stiffnesses(const Values& first, const Values& second, double way) {
    DenseNetwork network = make_pair(DTTMM_SCHEME_CENTRED, first, second);
    const StartFrame third{Vector3(-0.2, 0.1, 0.9), rotation_from_vector(Vector3(0.1, 0.2, 0.3)), Vector3(0.3, 0.1, 0.2),
                           Vector3(0.2, 0.7, -0.5)};
    std::array<StartFrame, 3> ports = {kLeft, kRight, third};
    for (StartFrame& port : ports) {
        port = port.after(way);
        port.velocity = port.angular_velocity = Vector3::Zero();
    }
    const double accelerations[18] = {};
    const auto motions = [](const std::array<StartFrame, 3>& at) {
        return std::array<dttmm_motion, 3>{at[0].motion(), at[1].motion(), at[2].motion()};
    };
    network.start({0, 0, kStep}, motions(ports).data(), accelerations, nullptr);
    network.begin_step({0, 0, kStep}, nullptr);

    const auto wrench_at = [&](const std::array<StartFrame, 3>& at) {
        Eigen::Matrix<double, 18, 1> wrench;
        network.evaluate(motions(at).data(), wrench.data(), nullptr);
        return wrench;
    };
    Eigen::Matrix<double, 18, 1> wrench;
    Eigen::Matrix<double, 18, 18, Eigen::RowMajor> S;
    network.evaluate(motions(ports).data(), wrench.data(), S.data());
    Eigen::MatrixXd difference(18, 18);
    for (size_t p = 0; p < 3; ++p)
        for (int i = 0; i < 6; ++i) {
            const double e = 1e-6;
            auto plus = ports, minus = ports;
            plus[p] = ports[p].displaced(e * Vector6::Unit(i));
            minus[p] = ports[p].displaced(-e * Vector6::Unit(i));
            difference.col(static_cast<int>(6 * p) + i) = -(wrench_at(plus) - wrench_at(minus)) / (2 * e);
        }
    return {difference, S};
}

// Oracle: central differences. At rest no force acts and the law is all there is.
TEST(Network, StiffnessOfTheStepIsTheDerivativeOfItsWrench) {
    const auto [difference, S] = stiffnesses(kUgly, kSoft, 0);
    EXPECT_LT((S - difference).norm(), 1e-7 * S.norm());
}

// Oracle: the same with springs far out of rest. Their forces have an energy, so that but for the axes to which small turns
// are referred the derivative is symmetric, and its symmetric part the second derivative of the energy.
TEST(Network, StiffnessOfTheStepHasThatOfTheForcesThatAct) {
    const Values kPulled = test::spring_values({5e5, 7.3e6, 1.2e4}), kFar = test::spring_values({1e3, 2e3, 3e3});
    const auto [difference, S] = stiffnesses(kPulled, kFar, 0.5);
    EXPECT_LT((S - 0.5 * (difference + difference.transpose())).norm(), 1e-7 * S.norm());
    EXPECT_LT((S - S.transpose()).norm(), 1e-14 * S.norm());
}

// Oracle: the explicit wrench is k d_n + c d'_n with the scheme's formula for d'; Fox-Euler with the host's velocity
// v_{n−1} = (d_n − d_{n−2})/2h gives (2/h)(d_n − d_{n−1}) − v_{n−1}. It must not look at the trial.
TEST(Network, ExplicitWrenchIsTheForceLawAtTheStartOfTheStep) {
    DenseNetwork network = make_network(DTTMM_SCHEME_FOX_EULER, false);
    StartFrame left = kLeft, right = kRight;
    const Vector6 d0 = deformation_of(left, right), d1 = deformation_of(left.after(kStep), right.after(kStep));
    const Matrix3 Q0 = attitude_of(left, right), Q1 = attitude_of(left.after(kStep), right.after(kStep));
    advance_twice(network, left, right);
    const Vector6 d2 = deformation_of(left, right);
    const Vector6 rate = 2 / kStep * (d2 - d1) - (d2 - d0) / (2 * kStep);
    Vector6 f = stiffness_of(kUgly).cwiseProduct(d2) + damping_of(kUgly).cwiseProduct(rate);
    const Matrix3 Q2 = attitude_of(left, right);
    const Vector3 last = turn_between(Q1, Q2), before = turn_between(Q0, Q1);
    const Vector3 turn_rate = 2 / kStep * last - (last + before) / (2 * kStep);
    f.tail<3>() = rotation_vector_rate(d2.tail<3>()).transpose() * stiffness_of(kUgly).tail<3>().cwiseProduct(d2.tail<3>()) +
                  damping_of(kUgly).tail<3>().cwiseProduct(turn_rate);

    network.begin_step({2, 2 * kStep, kStep}, nullptr);
    Vector12 near, far;
    Eigen::Matrix<double, 12, 12, Eigen::RowMajor> S;
    const dttmm_motion here[] = {left.motion(), right.motion()};
    const dttmm_motion there[] = {left.after(1).motion(), right.after(3).motion()};
    network.evaluate(here, near.data(), S.data());
    network.evaluate(there, far.data(), nullptr);
    EXPECT_EQ(near, far);
    EXPECT_EQ(S.norm(), 0);
    EXPECT_LT((near.segment<3>(6) + left.rotation * f.head<3>()).norm(), 1e-10 * f.head<3>().norm());
    EXPECT_LT((near.segment<3>(9) + left.rotation * f.tail<3>()).norm(), 1e-9 * f.tail<3>().norm());
}

// Oracle: objectivity. A machine that turns as a whole, however fast, neither stretches nor damps anything.
TEST(Network, ARigidMotionOfTheWholeCausesNoWrench) {
    for (uint32_t scheme : {DTTMM_SCHEME_CENTRED, DTTMM_SCHEME_FOX_EULER, DTTMM_SCHEME_PARK}) {
        DenseNetwork network = make_network(scheme, false);
        const Vector3 w = Vector3(3, -50, 20), v = Vector3(5, 2, -1), center = Vector3(0.1, 0.2, 0.3);
        const auto moved = [&](const StartFrame& frame, double t) {
            const Matrix3 R = rotation_from_vector(t * w);
            return StartFrame{center + t * v + R * (frame.position - center), R * frame.rotation,
                              v + w.cross(R * (frame.position - center)), w};
        };
        const dttmm_motion start[] = {moved(kLeft, 0).motion(), moved(kRight, 0).motion()};
        double accelerations[12] = {};
        for (int p = 0; p < 2; ++p)
            Eigen::Map<Vector3>{accelerations + 6 * p} = w.cross(w.cross((p ? kRight : kLeft).position - center));
        network.start({0, 0, kStep}, start, accelerations, nullptr);
        for (uint64_t n = 0; n < 3; ++n) {
            const double t = static_cast<double>(n + 1) * kStep;
            const dttmm_motion trial[] = {moved(kLeft, t).motion(), moved(kRight, t).motion()};
            network.begin_step({n, t - kStep, kStep}, nullptr);
            Vector12 wrench;
            network.evaluate(trial, wrench.data(), nullptr);
            EXPECT_LT(wrench.cwiseAbs().maxCoeff(), 1e-6)
                << "step " << n << ", scheme " << scheme;  // N; k d is 1e6 N per metre
            network.commit_step(trial);
        }
    }
}

// Oracle: evaluate is pure. Any calls in any order leave the answer, the committed future and the outputs bit for bit alike.
TEST(Network, EvaluateLeavesNoTrace) {
    DenseNetwork quiet = make_network(DTTMM_SCHEME_CENTRED, false), busy = make_network(DTTMM_SCHEME_CENTRED, false);
    StartFrame left = kLeft, right = kRight, left2 = kLeft, right2 = kRight;
    advance_twice(quiet, left, right);
    advance_twice(busy, left2, right2);
    const dttmm_motion trial[] = {left.after(kStep).motion(), right.after(kStep).motion()};
    quiet.begin_step({2, 2 * kStep, kStep}, nullptr);
    busy.begin_step({2, 2 * kStep, kStep}, nullptr);
    for (double far : {1.0, -3.0, 0.2}) {
        const dttmm_motion elsewhere[] = {left.after(far).motion(), right.after(-far).motion()};
        Vector12 ignored;
        busy.evaluate(elsewhere, ignored.data(), nullptr);
    }
    Vector12 once, again;
    quiet.evaluate(trial, once.data(), nullptr);
    busy.evaluate(trial, again.data(), nullptr);
    EXPECT_EQ(once, again);
    busy.discard_step();
    busy.begin_step({2, 2 * kStep, kStep}, nullptr);
    quiet.commit_step(trial);
    busy.commit_step(trial);
    std::array<double, 14> a{}, b{};
    quiet.outputs(a.data());
    busy.outputs(b.data());
    EXPECT_EQ(a, b);
}

// Oracle: a run that is put back to a saved state repeats itself bit for bit.
TEST(Network, RestoredStateRepeatsTheFutureToTheBit) {
    for (uint32_t scheme : {DTTMM_SCHEME_CENTRED, DTTMM_SCHEME_HOUBOLT}) {
        DenseNetwork network = make_network(scheme, true);
        const dttmm_motion start[] = {kRight.motion()};
        const double accelerations[6] = {1, 2, 3, 4, 5, 6};
        network.start({0, 0, kStep}, start, accelerations, nullptr);
        std::vector<unsigned char> saved(network.state_size());
        const auto run = [&](StartFrame at, uint64_t from, uint64_t to) {
            std::vector<Vector6> wrenches;
            for (uint64_t n = from; n < to; ++n) {
                at = at.after(kStep);
                at.velocity += Vector3(0.01, -0.02, 0.005);
                const dttmm_motion trial[] = {at.motion()};
                Vector6 wrench;
                network.begin_step({n, static_cast<double>(n) * kStep, kStep}, nullptr);
                network.evaluate(trial, wrench.data(), nullptr);
                network.commit_step(trial);
                wrenches.push_back(wrench);
            }
            return std::pair(wrenches, at);
        };
        const StartFrame middle = run(kRight, 0, 5).second;
        network.save_state(saved.data(), saved.size());
        const auto first = run(middle, 5, 12).first;
        network.restore_state(saved.data(), saved.size());
        EXPECT_EQ(run(middle, 5, 12).first, first);
        EXPECT_EQ(status_of([&] { network.restore_state(saved.data(), saved.size() - 1); }), DTTMM_ERROR_ARGUMENT);
    }
}

// Oracle: by hand at the start of the last step: f = k d + c (d₊ − d₋)/2h, strain energy ½ k d², dissipated c d'² h per
// step.
TEST(Network, OutputsStandAtTheStartOfTheLastStep) {
    DenseNetwork network = make_network(DTTMM_SCHEME_CENTRED, false, kSoft);
    StartFrame left = kLeft, right = kRight;
    const Vector6 d0 = deformation_of(left, right), d1 = deformation_of(left.after(kStep), right.after(kStep));
    EXPECT_EQ(status_of([&] { network.outputs(nullptr); }), DTTMM_ERROR_PHASE);
    advance_twice(network, left, right);
    const Vector6 d2 = deformation_of(left, right);
    std::array<double, 14> out{};
    network.outputs(out.data());
    const Vector3 k = stiffness_of(kSoft).head<3>(), c = damping_of(kSoft).head<3>();
    const Vector3 rate = (d2 - d0).head<3>() / (2 * kStep), d = d1.head<3>();
    const Vector3 f = k.cwiseProduct(d) + c.cwiseProduct(rate);
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(out[static_cast<size_t>(i)], f(i), 1e-11 * f.norm());
        EXPECT_NEAR(out[static_cast<size_t>(6 + i)], d(i), 1e-15);
        EXPECT_EQ(out[static_cast<size_t>(3 + i)], 0);
    }
    EXPECT_NEAR(out[12], 0.5 * d.dot(k.cwiseProduct(d)), 1e-14);
    EXPECT_GT(out[13], 0);
    ASSERT_EQ(network.channels().size(), 14u);
    EXPECT_STREQ(network.channels()[2].name, "force.z");
    EXPECT_STREQ(network.channels()[2].unit, "N");
}

// ---- What is refused ----------------------------------------------------------------------------------------------------

TEST(Network, CallsOutOfOrderAreRefusedAndChangeNothing) {
    DenseNetwork network = make_network(DTTMM_SCHEME_CENTRED, false);
    const dttmm_motion ports[] = {kLeft.motion(), kRight.motion()};
    const double accelerations[12] = {};
    double wrench[12];
    EXPECT_EQ(status_of([&] { network.begin_step({0, 0, kStep}, nullptr); }), DTTMM_ERROR_PHASE);
    EXPECT_EQ(status_of([&] { network.evaluate(ports, wrench, nullptr); }), DTTMM_ERROR_PHASE);
    EXPECT_EQ(status_of([&] {
                  dttmm_progress progress;
                  network.iterate(ports, progress);
              }),
              DTTMM_ERROR_PHASE);
    network.start({0, 0, kStep}, ports, accelerations, nullptr);
    EXPECT_EQ(status_of([&] { network.commit_step(ports); }), DTTMM_ERROR_PHASE);
    EXPECT_EQ(status_of([&] { network.discard_step(); }), DTTMM_ERROR_PHASE);
    EXPECT_EQ(status_of([&] { network.begin_step({0, 0, 2 * kStep}, nullptr); }), DTTMM_ERROR_ARGUMENT);
    network.begin_step({0, 0, kStep}, nullptr);
    EXPECT_EQ(status_of([&] { network.begin_step({0, 0, kStep}, nullptr); }), DTTMM_ERROR_PHASE);
    EXPECT_EQ(status_of([&] { network.start({0, 0, kStep}, ports, accelerations, nullptr); }), DTTMM_ERROR_PHASE);
    EXPECT_EQ(status_of([&] { network.save_state(nullptr, network.state_size()); }), DTTMM_ERROR_PHASE);
    network.discard_step();
    EXPECT_EQ(status_of([&] { network.start({0, 0, 0}, ports, accelerations, nullptr); }), DTTMM_ERROR_ARGUMENT);
}

TEST(Network, StructuralFaultsAreFoundWhenBuilt) {
    const dttmm_node good[] = {node("a", DTTMM_NODE_GROUND, kLeft), node("b", DTTMM_NODE_ON_BODY, kRight),
                               node("c", DTTMM_NODE_GROUND, kLeft)};
    const uint32_t grounds[] = {0, 2}, same[] = {1, 1}, beyond[] = {0, 3};
    const auto status = [&](const dttmm_node* nodes, dttmm_element element, uint32_t scheme = 0, double beta = 0.25) {
        const dttmm_body mass = body(good[1]);
        return status_of([&] {
            DenseNetwork({1, &mass, 3, nodes, 1, &element, scheme, beta, 0.5, {}, 0, nullptr, 0, nullptr, nullptr, 0});
        });
    };
    EXPECT_EQ(status(good, {"e", 0, 2, kFromTo, kUgly.data()}), DTTMM_OK);
    EXPECT_EQ(status(good, {"e", 0, 2, grounds, kUgly.data()}), DTTMM_ERROR_MODEL) << "both ends on the ground";
    EXPECT_EQ(status(good, {"e", 0, 2, same, kUgly.data()}), DTTMM_ERROR_MODEL) << "both ends the same node";
    EXPECT_EQ(status(good, {"e", 0, 2, beyond, kUgly.data()}), DTTMM_ERROR_MODEL) << "no such node";
    EXPECT_EQ(status(good, {"e", 99, 2, kFromTo, kUgly.data()}), DTTMM_ERROR_ARGUMENT) << "no such type";
    EXPECT_EQ(status(good, {"e", 0, 2, kFromTo, nullptr}), DTTMM_ERROR_ARGUMENT) << "no values";
    EXPECT_EQ(status(good, {"e", 0, 2, kFromTo, kUgly.data()}, 17), DTTMM_ERROR_ARGUMENT) << "no such scheme";
    EXPECT_EQ(status(good, {"e", 0, 2, kFromTo, kUgly.data()}, 0, 0.0), DTTMM_ERROR_ARGUMENT) << "beta 0";
    EXPECT_EQ(status(good, {"e", 0, 1, kFromTo, kUgly.data()}), DTTMM_ERROR_MODEL) << "one end";
    dttmm_node inner[] = {good[0], good[1], good[2]};
    inner[1].kind = DTTMM_NODE_INNER;
    EXPECT_EQ(status(inner, {"e", 0, 2, kFromTo, kUgly.data()}), DTTMM_OK) << "an inner node";
    EXPECT_EQ(status(inner, {"e", 0, 2, kFromTo, kUgly.data()}, 1), DTTMM_ERROR_MODEL) << "the same, explicit";
    dttmm_node skewed[] = {good[0], good[1], good[2]};
    skewed[1].rotation[4] += 0.1;
    EXPECT_EQ(status(skewed, {"e", 0, 2, kFromTo, kUgly.data()}), DTTMM_ERROR_ARGUMENT) << "axes not orthonormal";
    dttmm_node astray[] = {good[0], good[1], good[2]};
    astray[1].body = 1;
    EXPECT_EQ(status(astray, {"e", 0, 2, kFromTo, kUgly.data()}), DTTMM_ERROR_ARGUMENT) << "no such body";
}

// Oracle: a rotor that turns at a steady ω feels −c ω from a rotational damper, at every angle: half turns are no event.
TEST(Network, ARotationalDamperMayTurnForEver) {
    const double c = 0.7, w = 40, h = 0.01;  // 0.4 rad a step: a turn every 16 steps
    const Values values = test::spring_values({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, c});
    for (uint32_t scheme : {DTTMM_SCHEME_CENTRED, DTTMM_SCHEME_FOX_EULER}) {
        DenseNetwork network = make_network(scheme, true, values);
        const Vector3 axis = kLeft.rotation.col(2);
        StartFrame rotor{kRight.position, kRight.rotation, Vector3::Zero(), w * axis};
        const dttmm_motion start[] = {rotor.motion()};
        const double accelerations[6] = {};
        network.start({0, 0, h}, start, accelerations, nullptr);
        for (uint64_t n = 0; n < 50; ++n) {
            rotor = rotor.after(h);
            const dttmm_motion trial[] = {rotor.motion()};
            network.begin_step({n, static_cast<double>(n) * h, h}, nullptr);
            Vector6 wrench;
            network.evaluate(trial, wrench.data(), nullptr);
            EXPECT_LT((wrench.tail<3>() + c * w * axis).norm(), 1e-10 * c * w) << "step " << n << ", scheme " << scheme;
            network.commit_step(trial);
        }
    }
}

// A rotational spring has lost its meaning beyond its range: the step is refused and can be discarded.
TEST(Network, ARotationalSpringRefusesLargeRotations) {
    DenseNetwork network = make_network(DTTMM_SCHEME_CENTRED, true);
    const dttmm_motion start[] = {kRight.motion()};
    const double accelerations[6] = {};
    network.start({0, 0, kStep}, start, accelerations, nullptr);
    network.begin_step({0, 0, kStep}, nullptr);
    const dttmm_motion far[] = {kRight.displaced((Vector6() << 0, 0, 0, 0, 2.6, 0).finished()).motion()};
    EXPECT_EQ(status_of([&] { network.commit_step(far); }), DTTMM_ERROR_NUMERIC);
    network.discard_step();
}

// Oracle: statics. A beam with a hinge that is rigid in three directions at its end holds a body: over the first step the
// body feels all of the force that it feels at rest, and again over the second.
TEST(Network, FromRestTheFirstStepHasTheWholeForceOfRigidDirections) {
    test::NetworkModel model;
    const Matrix3 turned = rotation_from_vector(Vector3(0.4, -0.8, 1.3));
    model.node("root", DTTMM_NODE_GROUND, {0.1, -0.2, 0.3}, turned);
    model.node("pin", DTTMM_NODE_INNER, {0.7, 0.1, 0.2}, turned);
    model.node("body", DTTMM_NODE_ON_BODY, {0.7, 0.1, 0.2}, turned, {0.2, 0.1, -0.3});
    test::NetworkModel::Values section = test::tube(3, 1e-5);
    section["up"] = {0.1, 0.2, 1};
    model.element("beam", "beam", {"root", "pin"}, section);
    model.element("hinge", "elastic_hinge", {"pin", "body"},
                  {{"stiffness.y", {3e5}}, {"stiffness.rx", {4e3}}, {"stiffness.rz", {7e3}}});
    model.set_gravity({3, -4, -8});
    const dttmm_network description = model.description();
    DenseNetwork network(description);
    dttmm_motion body{};
    std::copy_n(description.bodies[0].position, 3, body.position);
    std::copy_n(description.bodies[0].rotation, 9, body.rotation);
    network.begin_statics();
    network.statics().set_loads(Vector3(3, -4, -8), nullptr);
    Vector6 wrench, mean;
    std::vector<double> stiffness(36);
    const std::vector<double> held(6, 0.0);
    for (int pass = 0; pass < 10; ++pass) {
        wrench.setZero();
        network.form_static(&body, 0, wrench.data(), stiffness.data());
        network.correct_static(held.data());
        wrench.setZero();
        network.move_static(&body, 1, wrench.data());
    }
    ASSERT_GT(wrench.head<3>().norm(), 1);
    const double h = 1e-3;
    network.start_at_rest({0, 0, h}, &body, nullptr);
    for (uint64_t n : {0u, 1u}) {
        network.begin_step({n, static_cast<double>(n) * h, h}, nullptr);
        Vector6 felt;
        network.evaluate(&body, felt.data(), nullptr);
        EXPECT_LT((felt - wrench).norm(), 1e-6 * wrench.norm()) << n << ": " << felt.transpose();
        network.commit_step(&body);
        network.mean_wrench(mean.data());
        EXPECT_LT((mean - wrench).norm(), 1e-6 * wrench.norm()) << n << ": " << mean.transpose();
    }
}

// A free joint is no fault: it carries nothing.
TEST(Network, AnElementWithoutStiffnessCarriesNothing) {
    const Values kFree = test::spring_values({});
    DenseNetwork network = make_network(DTTMM_SCHEME_CENTRED, false, kFree);
    StartFrame left = kLeft, right = kRight;
    advance_twice(network, left, right);
    network.begin_step({2, 2 * kStep, kStep}, nullptr);
    const dttmm_motion trial[] = {left.after(1).motion(), right.motion()};
    Vector12 wrench;
    network.evaluate(trial, wrench.data(), nullptr);
    EXPECT_EQ(wrench.norm(), 0);
}

}  // namespace
}  // namespace dttmm::plugin
