// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/stability.h"

#include <gtest/gtest.h>

#include <cmath>

#include "step/simulation.h"
#include "support/linear_algebra.h"
#include "support/models.h"

namespace dttmm::host {
namespace {

FastestMode fastest_of(const Model& model, const Plugins& plugins) {
    const World world(model.bodies);
    std::vector<BodyState> at(model.bodies.size());
    world.read_states(at);
    Networks networks(model, plugins);
    return find_fastest_mode(model, networks, at);
}

// Oracle: closed form of the symmetric plate: ω² = 4k/m in translation, 4k y²/Jx about x, 4k x²/Jy, 4k (x² + y²)/Jz.
TEST(Stability, FastestModeOfThePlateIsItsClosedForm) {
    const Plugins plugins;
    const double k = 5e5, m = test::kPlateMass;
    const Model model = test::plate_stack(plugins, 1, k, 100, 1e-3, Coupling::implicit);
    const double about_x = 4 * k * 0.08 * 0.08 / (m / 12 * (0.04 + 4e-4)),
                 about_y = 4 * k * 0.13 * 0.13 / (m / 12 * (0.09 + 4e-4)),
                 about_z = 4 * k * (0.13 * 0.13 + 0.08 * 0.08) / (m / 12 * 0.13);
    const FastestMode fastest = fastest_of(model, plugins);
    EXPECT_NEAR(fastest.omega, std::sqrt(std::max({4 * k / m, about_x, about_y, about_z})), 1e-4 * fastest.omega);
    EXPECT_EQ(fastest.body, "plate1");
    ASSERT_EQ(fastest.elements.size(), 4u);
    EXPECT_EQ(fastest.elements[0].element, "bolt1_1");
    EXPECT_NEAR(fastest.elements[0].share, 0.25, 1e-6);
}

// Oracle: the same plate turned and moved as a whole has the same frequencies.
TEST(Stability, FastestModeDoesNotDependOnTheFrame) {
    const Plugins plugins;
    Model model = test::plate_stack(plugins, 3, 5e5, 100, 1e-3, Coupling::implicit);
    const double upright = fastest_of(model, plugins).omega;
    const Eigen::Matrix3d R = Eigen::AngleAxisd(1.3, Eigen::Vector3d(1, 2, -0.5).normalized()).toRotationMatrix();
    for (Body& body : model.bodies) {
        body.position = Eigen::Vector3d(3, -1, 2) + R * body.position;
        body.rotation = R;
    }
    EXPECT_NEAR(fastest_of(model, plugins).omega, upright, 1e-4 * upright);
}

/// A rod of length l on a hinge, a spring-damper at its far end.
Model pendulum(const Plugins& plugins, double k, double c, Coupling coupling) {
    Model model;
    model.simulation.coupling = coupling;
    model.simulation.duration = 1;
    Body rod = test::box("rod", 2.3, {0.8, 0.03, 0.02}, {0.4, 0, 0});
    Marker end;
    end.name = "end";
    end.position = {0.4, 0, 0};
    rod.markers.push_back(end);
    rod.angular_velocity = {0, 0, 1e-3};
    rod.velocity = {0, 4e-4, 0};
    model.bodies = {rod};
    model.joints = {test::pin("pin", -1, 0, {0, 0, 0}, {0, 0, 1})};
    model.elements = {test::spring("bolt", plugins, {}, {0, 0}, k, c)};
    return model;
}

// Oracle: closed form. On its hinge the rod can only turn: ω² = k l²/I about the hinge; free it would be far faster.
TEST(Stability, JointsLeaveTheirMotionsOnly) {
    const Plugins plugins;
    const Model model = pendulum(plugins, 4e8, 0, Coupling::implicit);
    const Body& rod = model.bodies[0];
    const double I = rod.inertia(2, 2) + rod.mass * 0.16;
    EXPECT_NEAR(fastest_of(model, plugins).omega, std::sqrt(4e8 * 0.64 / I), 1e-6 * std::sqrt(4e8 * 0.64 / I));
}

// The limit of an explicit coupling on joints is where runs begin to diverge.
TEST(Stability, ExplicitLimitOnJointsIsWhereRunsDiverge) {
    const Plugins plugins;
    for (double c : {0.0, 6e3}) {
        Model model = pendulum(plugins, 4e8, c, Coupling::explicit_);
        model.simulation.step = 1e-4;
        const double longest = Simulation(model, plugins).explicit_limit()->longest_step;
        for (double share : {0.99, 1.01}) {
            model.simulation.step = share * longest;
            Simulation simulation(model, plugins);
            double largest = 0;
            try {
                for (int n = 0; n < 4000; ++n) {
                    simulation.step();
                    largest = std::max(largest, std::abs(simulation.bodies()[0].angular_velocity.z()));
                }
            } catch (const Error&) {
                largest = 1e9;
            }
            if (share < 1)
                EXPECT_LT(largest, 0.02) << "damping " << c;
            else
                EXPECT_GT(largest, 1) << "damping " << c;
        }
    }
}

// Of many elements none of which holds a hundredth, the largest is named all the same.
TEST(Stability, OneElementIsAlwaysNamed) {
    const Plugins plugins;
    const FastestMode fastest = fastest_of(test::plate_stack(plugins, 300, 5e5, 100, 1e-3, Coupling::implicit), plugins);
    ASSERT_EQ(fastest.elements.size(), 1200u);
    EXPECT_LT(fastest.elements[0].share, 0.01);
    const std::string text = describe(fastest);
    EXPECT_NE(text.find("made by " + fastest.elements[0].element + " ("), std::string::npos) << text;
    EXPECT_EQ(text.find(fastest.elements[1].element), std::string::npos) << text;
}

// Of four alike three are named, and the last is counted.
TEST(Stability, SharesThatAreNotNamedAreCounted) {
    const Plugins plugins;
    EXPECT_NE(describe(fastest_of(test::plate_stack(plugins, 1, 5e5, 100, 1e-3, Coupling::implicit), plugins))
                  .find("bolt1_1 (25 %), bolt1_2 (25 %), bolt1_3 (25 %) and 1 more"),
              std::string::npos);
}

// Oracle: closed form, sqrt(k/m). Beside a machine on a mount 1e10 times stiffer, a light thing on a soft spring stores next
// to no energy and yet is twice as fast.
TEST(Stability, ALightBodyBesideAHeavyOneIsNotOverheard) {
    const Plugins plugins;
    Model model;
    model.simulation.step = 1e-3;
    model.bodies = {test::box("machine", 4e6, {1, 1, 1}, {0, 0, 0}),
                    test::box("sensor", 1e-4, {0.01, 0.01, 0.01}, {2, 0, 0})};
    model.elements = {test::spring("mount", plugins, {}, {0, -1}, 4e12, 0),
                      test::spring("glue", plugins, {0, -1}, {1, -1}, 400, 0)};
    const FastestMode fastest = fastest_of(model, plugins);
    EXPECT_NEAR(fastest.omega, std::sqrt(400 / 1e-4), 1e-3 * fastest.omega);
    EXPECT_EQ(fastest.body, "sensor");
    EXPECT_EQ(fastest.elements[0].element, "glue");
    EXPECT_GT(fastest.elements[0].share, 0.999);
}

// ---- The limit of the explicit coupling
// -----------------------------------------------------------------------------------

constexpr ExplicitScheme kSchemes[] = {ExplicitScheme::fox_euler, ExplicitScheme::bdf1, ExplicitScheme::bdf2,
                                       ExplicitScheme::houbolt, ExplicitScheme::park};

/// h times the velocity formulas of theory 1.3, on x at t_n, t_{n−1}, ...; Fox-Euler's with (x_n − x_{n−2})/2h before.
std::array<double, 4> velocity_weights(ExplicitScheme scheme) {
    switch (scheme) {
        case ExplicitScheme::bdf1:
            return {1, -1, 0, 0};
        case ExplicitScheme::houbolt:
            return {11 / 6.0, -18 / 6.0, 9 / 6.0, -2 / 6.0};
        case ExplicitScheme::park:
            return {10 / 6.0, -15 / 6.0, 6 / 6.0, -1 / 6.0};
        default:
            return {1.5, -2, 0.5, 0};
    }
}

/// Largest root of M (x₊ − 2x + x₋) + h² K x + h C Σ w_i x_{n−i} = 0, by the companion matrix of the whole machine.
double spectral_radius(const Eigen::MatrixXd& M, const Eigen::MatrixXd& K, const Eigen::MatrixXd& C, double h,
                       ExplicitScheme scheme) {
    const auto n = M.rows();
    const Eigen::MatrixXd inverse = test::inverse(M), I = Eigen::MatrixXd::Identity(n, n);
    Eigen::MatrixXd step = Eigen::MatrixXd::Zero(4 * n, 4 * n);
    for (int i = 0; i < 4; ++i)
        step.block(0, i * n, n, n) = -h * inverse * C * velocity_weights(scheme)[static_cast<size_t>(i)];
    step.block(0, 0, n, n) += 2 * I - h * h * inverse * K;
    step.block(0, n, n, n) -= I;
    step.bottomLeftCorner(3 * n, 3 * n) = Eigen::MatrixXd::Identity(3 * n, 3 * n);
    return test::eigenvalues(step).cwiseAbs().maxCoeff();
}

// Oracle: all roots of the recurrence of one mass, from hardly any damping to nothing but damping. At the limit itself the
// root is −1; one part in 1e4 below it no root is outside the circle, above it one is.
TEST(Stability, TheLimitOfOneMassIsWhereARootPassesMinusOne) {
    const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
    for (ExplicitScheme scheme : kSchemes) {
        for (double zeta : {0.0, 0.02, 0.0632, 0.2, 0.5, 1.0, 30.0}) {
            // ω = 1:  h² + 2 ζ W h = 4
            const double b = zeta * alternating_weight(scheme), h = 4 / (b + std::sqrt(b * b + 4));
            const auto radius = [&](double step) { return spectral_radius(one, one, 2 * zeta * one, step, scheme); };
            EXPECT_LT(radius((1 - 1e-4) * h), 1 + 1e-12) << zeta;
            EXPECT_GT(radius((1 + 1e-4) * h), 1 + 1e-5) << zeta;
            for (double part = 0.02; part < 1; part += 0.02) EXPECT_LT(radius(part * h), 1 + 1e-12) << zeta << ", " << part;
        }
        const double h = 4 / alternating_weight(scheme);  // a damper of c/m = 1 alone; the root 1 is rest anywhere
        EXPECT_LT(spectral_radius(one, 0 * one, one, 0.999 * h, scheme), 1 + 1e-7);
        EXPECT_GT(spectral_radius(one, 0 * one, one, 1.001 * h, scheme), 1 + 1e-4);
    }
}

// Oracle: theory table 1.4, the first unstable ωh by a scan in thousandths.
TEST(Stability, TheLimitsAreThoseOfTheTable) {
    const auto limit = [](ExplicitScheme scheme, double zeta) {
        const double b = zeta * alternating_weight(scheme);
        return 4 / (b + std::sqrt(b * b + 4));
    };
    for (ExplicitScheme scheme : kSchemes) EXPECT_EQ(limit(scheme, 0), 2);
    const double zetas[] = {0, 0.02, 0.0632, 0.2, 0.5, 1};
    const double table[][6] = {{2, 1.961, 1.878, 1.640, 1.236, 0.829},   // BDF1
                               {2, 1.922, 1.763, 1.354, 0.829, 0.472},   // BDF2
                               {2, 1.896, 1.691, 1.200, 0.667, 0.363},   // Park
                               {2, 1.871, 1.623, 1.071, 0.554, 0.294}};  // Houbolt
    const ExplicitScheme schemes[] = {ExplicitScheme::bdf1, ExplicitScheme::bdf2, ExplicitScheme::park,
                                      ExplicitScheme::houbolt};
    for (size_t s = 0; s < 4; ++s)
        for (size_t z = 1; z < 6; ++z) EXPECT_NEAR(limit(schemes[s], zetas[z]), table[s][z], 7e-4);
}

ExplicitLimit limit_of(const Model& model, const Plugins& plugins) {
    const World world(model.bodies);
    std::vector<BodyState> at(model.bodies.size());
    world.read_states(at);
    Networks networks(model, plugins);
    return find_explicit_limit(model, networks, at, model.simulation.step, model.simulation.scheme);
}

constexpr double kMasses[] = {2.5, 0.7}, kStiffnesses[] = {3e5, 9e4}, kDampings[] = {0.1, 40};

/// Two masses in a row on the ground; the outer spring has nearly all the damping, so that no modes decouple.
Model two_masses(const Plugins& plugins) {
    Model model;
    model.simulation.step = 1e-3;
    model.simulation.duration = 1;
    model.simulation.coupling = Coupling::explicit_;
    model.bodies = {test::box("inner", kMasses[0], {1, 1, 1}, {0, 0, 0}),
                    test::box("outer", kMasses[1], {1, 1, 1}, {1, 0, 0})};
    model.elements = {test::spring("foot", plugins, {}, {0, -1}, kStiffnesses[0], kDampings[0]),
                      test::spring("link", plugins, {0, -1}, {1, -1}, kStiffnesses[1], kDampings[1])};
    for (size_t i = 0; i < 2; ++i)  // along x only: no lever arms
        model.elements[i].values = test::spring_values({kStiffnesses[i], 0, 0, kDampings[i]});
    return model;
}

Eigen::Matrix2d chain(const double* links) {
    return Eigen::Matrix2d{{links[0] + links[1], -links[1]}, {-links[1], links[1]}};
}

// Oracle: the same two masses as 2×2 matrices: eigenvalue, vector and shares by a dense solver, and all roots of their
// recurrence just below and just above the longest step. The power iteration is known to 1e-4.
TEST(Stability, TheLimitOfTwoMassesWithOneDampedSpring) {
    const Plugins plugins;
    Model model = two_masses(plugins);
    const Eigen::Matrix2d M = Eigen::Vector2d(kMasses[0], kMasses[1]).asDiagonal(), K = chain(kStiffnesses),
                          C = chain(kDampings);
    for (ExplicitScheme scheme : kSchemes) {
        model.simulation.scheme = scheme;
        const ExplicitLimit limit = limit_of(model, plugins);
        const double h = model.simulation.step, W = alternating_weight(scheme);
        const test::Pencil pencil = test::solve_pencil(h * h * K + W * h * C, M);
        const Eigen::Vector2d u = pencil.vectors.col(1);  // uᵀ M u = 1
        EXPECT_NEAR(limit.load, std::sqrt(pencil.values(1)), 1e-4 * limit.load);
        EXPECT_NEAR(limit.damping_share, W * h * u.dot(C * u) / pencil.values(1), 1e-3);
        EXPECT_NEAR(limit.mode.omega, std::sqrt(u.dot(K * u)), 1e-3 * limit.mode.omega);
        EXPECT_EQ(limit.mode.body, "outer");
        const double in_link = (h * h * kStiffnesses[1] + W * h * kDampings[1]) * std::pow(u(1) - u(0), 2);
        ASSERT_EQ(limit.mode.elements.size(), 2u);
        EXPECT_EQ(limit.mode.elements[0].element, "link");
        EXPECT_NEAR(limit.mode.elements[0].share, in_link / pencil.values(1), 1e-3);
        EXPECT_NEAR(limit.mode.elements[0].share + limit.mode.elements[1].share, 1, 1e-12);

        EXPECT_LT(spectral_radius(M, K, C, (1 - 1e-3) * limit.longest_step, scheme), 1);
        EXPECT_GT(spectral_radius(M, K, C, (1 + 1e-3) * limit.longest_step, scheme), 1);
    }
    EXPECT_EQ(fastest_of(model, plugins).elements[0].element, "link");
}

// Oracle: the machine itself in ODE, a part in a hundred below and above the step found for it.
TEST(Stability, ARealRunDivergesAboveTheLongestStepAndNotBelow) {
    const Plugins plugins;
    Model model = two_masses(plugins);
    model.bodies[1].velocity = {0.1, 0, 0};
    for (ExplicitScheme scheme : kSchemes) {
        model.simulation.scheme = scheme;
        model.simulation.step = 1e-3;
        const double longest = limit_of(model, plugins).longest_step;
        const auto amplitude = [&](double step) {
            model.simulation.step = step;
            Simulation simulation(model, plugins);
            for (int n = 0; n < 3000; ++n) {
                simulation.step();
                if (std::abs(simulation.bodies()[1].position.x() - 1) > 1) break;
            }
            return std::abs(simulation.bodies()[1].position.x() - 1);
        };
        EXPECT_LT(amplitude(0.99 * longest), 1e-3);
        EXPECT_GT(amplitude(1.01 * longest), 1);
    }
}

TEST(Stability, ModesAreDescribedByBodyAndElements) {
    EXPECT_EQ(describe({2 * M_PI * 30, "plate", {{"bolt1", 0.612}, {"bolt4", 0.1}}}),
              "30 Hz at body \"plate\", made by bolt1 (61 %), bolt4 (10 %)");
    EXPECT_EQ(describe({2 * M_PI * 30, "plate", {{"bolt1", 0.0021}}}), "30 Hz at body \"plate\", made by bolt1 (0.2 %)");
    EXPECT_EQ(describe({0, "plate", {}}), "0 Hz at body \"plate\"");
}

TEST(Stability, NothingElasticHasNoFastestMode) {
    const Plugins plugins;
    Model model = test::plate_stack(plugins, 2, 5e5, 100, 1e-3, Coupling::implicit);
    model.elements.clear();
    EXPECT_EQ(fastest_of(model, plugins).omega, 0);
    EXPECT_EQ(limit_of(model, plugins).load, 0);
    EXPECT_TRUE(std::isinf(limit_of(model, plugins).longest_step));
}

}  // namespace
}  // namespace dttmm::host
