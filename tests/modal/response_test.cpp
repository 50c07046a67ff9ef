// SPDX-License-Identifier: BSD-3-Clause
#include "modal/response.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <vector>

#include "modal/modal_analysis.h"
#include "support/network_model.h"

namespace dttmm::plugin {
namespace {

using test::NetworkModel;

const Matrix3 kTurned = Eigen::AngleAxisd(0.7, Vector3(0.3, -0.5, 0.8).normalized()).toRotationMatrix();

dttmm_harmonic load_on(int body, int node, const Vector3& point, const Vector6& real, const Vector6& imaginary) {
    dttmm_harmonic load{body, node, {point.x(), point.y(), point.z()}, {}, 0};
    for (size_t d = 0; d < 6; ++d) {
        load.wrench[2 * d] = real(as_row(d));
        load.wrench[2 * d + 1] = imaginary(as_row(d));
    }
    return load;
}

Complex6 complex_at(const std::vector<double>& list, size_t place) {
    Complex6 found;
    for (size_t d = 0; d < 6; ++d) found(as_row(d)) = {list[12 * place + 2 * d], list[12 * place + 2 * d + 1]};
    return found;
}

// Oracle: closed form. A mass on a spring with a damper in turned axes: it carries (k + iωc)/(k + iωc − mω²) of the force.
// Two cases, and both loads of one of them act together.
TEST(Response, ASpringCarriesWhatItDeflects) {
    constexpr double kCarried = 1.3, kHertz = 2.9;
    const Vector3 k(310, 570, 940), c(1.1, 2.3, 0.7);
    NetworkModel model;
    model.node("a", DTTMM_NODE_GROUND, Vector3(0.4, 0.1, -0.2), kTurned);
    model.node("m", DTTMM_NODE_INNER, Vector3(0.4, 0.1, -0.2)).fixed = 0b111000;
    model.element("mass", "point_mass", {"m"}, {{"mass", {kCarried}}});
    model.element("spring", "spring_damper", {"a", "m"},
                  {{"stiffness", {k.x(), k.y(), k.z()}}, {"damping", {c.x(), c.y(), c.z()}}});
    const dttmm_network network = model.description();
    ModalAnalysis analysis({&network, 0, nullptr, 0b111111, 0, nullptr});
    Vector6 first = Vector6::Zero(), second = first;
    first.head<3>() = Vector3(3, -5, 2);
    second.head<3>() = Vector3(-1, 4, 7);
    const std::array both = {load_on(-1, 1, Vector3::Zero(), first, second), load_on(-1, 1, Vector3::Zero(), second, first)};
    const std::array<std::span<const dttmm_harmonic>, 2> cases = {std::span(both).first(1), both};
    std::vector<double> elements(2 * 24 * 2);
    analysis.respond(kHertz, cases, {nullptr, nullptr, elements.data(), nullptr});
    const double w = 2 * M_PI * kHertz;
    const std::array<Eigen::Vector3cd, 2> forces = {
        first.head<3>().cast<Complex>() + Complex(0, 1) * second.head<3>().cast<Complex>(),
        Complex(1, 1) * (first + second).head<3>().cast<Complex>()};
    for (size_t n = 0; n < 2; ++n) {
        const Complex6 force = complex_at(elements, 4 * n + 2), deflection = complex_at(elements, 4 * n + 3);
        const Eigen::Vector3cd own = kTurned.transpose().cast<Complex>() * forces[n];
        for (Eigen::Index d = 0; d < 3; ++d) {
            const Complex spring(k(d), w * c(d)), x = own(d) / (spring - kCarried * w * w);
            EXPECT_LT(std::abs(force(d) - spring * x), 1e-10 * std::abs(spring * x)) << n << " " << d;
            EXPECT_LT(std::abs(deflection(d) - x), 1e-10 * std::abs(x)) << n << " " << d;
        }
    }
}

// Oracle: balance. Far below its frequencies a cantilever, exact or lumped, carries at its `from` end the force at its tip
// and its moment about that end.
TEST(Response, ACantileverCarriesTheForceAtItsTip) {
    const Vector3 foot(0.2, -0.1, 0.5), way = kTurned * Vector3(1.4, 0, 0);
    NetworkModel model;
    model.node("foot", DTTMM_NODE_GROUND, foot);
    model.node("tip", DTTMM_NODE_INNER, foot + way);
    const Vector3 up = kTurned.col(2);
    model.element("beam", "beam", {"foot", "tip"},
                  {{"section.EA", {4e6}},
                   {"section.EIy", {300}},
                   {"section.EIz", {700}},
                   {"section.GJ", {200}},
                   {"section.GAy", {5e5}},
                   {"section.GAz", {8e5}},
                   {"section.mass", {1.6}},
                   {"section.inertia", {5e-3}},
                   {"segments", {5}},
                   {"up", {up.x(), up.y(), up.z()}}});
    const dttmm_network network = model.description();
    Vector6 wrench;
    wrench << 3, -5, 2, 0.7, 1.1, -0.4;
    for (const uint32_t lumped : {0u, 1u}) {
        ModalAnalysis analysis({&network, 0, nullptr, 0b111111, lumped, nullptr});
        const std::array loads = {load_on(-1, 1, Vector3::Zero(), wrench, Vector6::Zero())};
        const std::array<std::span<const dttmm_harmonic>, 1> cases = {loads};
        std::vector<double> elements(24);
        analysis.respond(1e-4, cases, {nullptr, nullptr, elements.data(), nullptr});
        const Complex6 found = complex_at(elements, 0), moved = complex_at(elements, 1);
        const Vector3 force = wrench.head<3>(), moment = wrench.tail<3>() + way.cross(force);
        EXPECT_LT((found.head<3>().real() - kTurned.transpose() * force).norm(), 1e-8 * force.norm()) << lumped;
        EXPECT_LT((found.tail<3>().real() - kTurned.transpose() * moment).norm(), 1e-8 * moment.norm()) << lumped;
        // v = F L³/(3 EI) + F L/GA + M L²/(2 EI) in either plane
        const Vector3 f = kTurned.transpose() * force, m = kTurned.transpose() * Vector3(wrench.tail<3>());
        const double L = 1.4, y = f.y() * (L * L * L / (3 * 700) + L / 5e5) + m.z() * L * L / (2 * 700),
                     z = f.z() * (L * L * L / (3 * 300) + L / 8e5) - m.y() * L * L / (2 * 300);
        EXPECT_NEAR(moved(1).real(), y, (lumped ? 0.02 : 1e-8) * std::abs(y)) << lumped;
        EXPECT_NEAR(moved(2).real(), z, (lumped ? 0.02 : 1e-8) * std::abs(z)) << lumped;
        EXPECT_NEAR(moved(3).real(), m.x() * L / 200, 1e-8 * std::abs(m.x())) << lumped;
    }
}

// Oracle: balance. A body on a hinge is pushed along the axis beside it: nothing moves, the hinge has the whole wrench.
TEST(Response, AHingeHoldsWhatItDoesNotLetMove) {
    const Vector3 centre(0.3, -0.2, 0.6), anchor(0.1, 0.2, 0.3), axis = kTurned.col(2);
    NetworkModel model;
    model.node("body", DTTMM_NODE_ON_BODY, centre);
    const dttmm_network network = model.description();
    dttmm_constraint hinge{0, -1, {anchor.x(), anchor.y(), anchor.z()}, {}, 0b011111};
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{hinge.axes} = kTurned;
    ModalAnalysis analysis({&network, 1, &hinge, 0b111111, 0, nullptr});
    Vector6 wrench = Vector6::Zero();
    wrench.head<3>() = 7 * axis;
    const std::array loads = {load_on(0, -1, centre, wrench, Vector6::Zero())};
    const std::array<std::span<const dttmm_harmonic>, 1> cases = {loads};
    std::vector<double> bodies(12), constraints(12);
    analysis.respond(3.1, cases, {bodies.data(), nullptr, nullptr, constraints.data()});
    EXPECT_LT(complex_at(bodies, 0).norm(), 1e-15);
    Vector6 expected;
    expected << -7 * axis, -(centre - anchor).cross(7 * axis);
    EXPECT_LT((complex_at(constraints, 0) - expected.cast<Complex>()).norm(), 1e-12 * expected.norm());
}

}  // namespace
}  // namespace dttmm::plugin
