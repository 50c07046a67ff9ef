// SPDX-License-Identifier: BSD-3-Clause
#include "support/hydroplane_determinant.h"

#include <Eigen/Dense>
#include <array>
#include <cmath>
#include <initializer_list>
#include <numbers>

namespace dttmm::test {
namespace {

using Matrix8 = Eigen::Matrix<double, 8, 8>;
using Matrix48 = Eigen::Matrix<double, 4, 8>;
enum State { X, Y, Tz, Mz, Qx, Qy, Tx, Mx };
struct Spring {
    State direction;
    double stiffness;
};
struct Section {
    double EA, EI, GJ, mass, inertia, offset;
};

Matrix8 hinge(std::initializer_list<Spring> springs) {
    Matrix8 U = Matrix8::Identity();
    for (const auto& [direction, stiffness] : springs) {
        if (direction == X) U(X, Qx) = -1 / stiffness;
        if (direction == Y) U(Y, Qy) = -1 / stiffness;
        if (direction == Tz) U(Tz, Mz) = 1 / stiffness;
        if (direction == Tx) U(Tx, Mx) = 1 / stiffness;
    }
    return U;
}

/// exp(S l) in units in which the entries of S are near 1, by Taylor's series and squaring.
Matrix8 beam(double w, double length, const Section& s) {
    Matrix8 S = Matrix8::Zero();
    S(X, Qx) = -1 / s.EA;
    S(Qx, X) = s.mass * w;
    S(Y, Tz) = S(Mz, Qy) = 1;
    S(Tz, Mz) = 1 / s.EI;
    S(Qy, Y) = s.mass * w;
    S(Qy, Tx) = -s.mass * w * s.offset;
    if (s.GJ > 0) {
        S(Tx, Mx) = 1 / s.GJ;
        S(Mx, Tx) = -w * s.inertia;
        S(Mx, Y) = w * s.mass * s.offset;
    }
    const Eigen::Vector<double, 8> unit{1, 1, 1, 1e6, 1e9, 1e6, 1, 1e6};
    const Matrix8 A = unit.cwiseInverse().asDiagonal() * S * unit.asDiagonal() * length / 1024;
    Matrix8 U = Matrix8::Identity();
    for (int n = 10; n > 0; --n) U = (Matrix8::Identity() + A * U / n).eval();
    for (int k = 0; k < 10; ++k) U = (U * U).eval();
    return unit.asDiagonal() * U * unit.cwiseInverse().asDiagonal();
}

Matrix8 blades(double w, bool is_right) {
    static constexpr std::array<Section, 7> sections{{{3e8, 2e5, 1.2e5, 60, 3, 0.08},
                                                      {4e8, 3.5e5, 2e5, 70, 3.8, 0.08},
                                                      {5e8, 5.5e5, 3e5, 80, 4.6, 0.09},
                                                      {6e8, 8e5, 4.5e5, 90, 5.5, 0.09},
                                                      {7e8, 1.1e6, 6e5, 100, 6.4, 0.1},
                                                      {8e8, 1.5e6, 8e5, 110, 7.4, 0.1},
                                                      {9e8, 2e6, 1e6, 120, 8.5, 0.1}}};  // from tip to hub
    Matrix8 U = Matrix8::Identity();
    for (std::size_t i = 0; i < 7; ++i) U = (beam(w, 0.2, sections[is_right ? 6 - i : i]) * U).eval();
    return U;
}

/// (26): a beam along +Y.
Matrix8 link(double w) {
    Matrix8 R = Matrix8::Identity();
    R.block<2, 2>(X, X) << 0, 1, -1, 0;
    R.block<2, 2>(Qx, Qx) << 0, 1, -1, 0;
    return R.transpose() * beam(w, 0.6, {1.5e9, 2e5, 0, 40, 0, 0}) * R;
}

/// (29)
Matrix8 rod(double w) {
    const double EA = 1e9, mass = 30, length = 0.5, beta = std::sqrt(mass * w / EA);
    Matrix8 U = Matrix8::Identity();
    U(Y, Y) = U(Qy, Qy) = std::cos(beta * length);
    U(Y, Qy) = -std::sin(beta * length) / (beta * EA);
    U(Qy, Y) = beta * EA * std::sin(beta * length);
    return U;
}

/// (11), (12), (14): forces and moments of a further input, whose lever arm to the output is `arm`.
Matrix8 side_input(const Eigen::Vector3d& arm) {
    Matrix8 U = Matrix8::Zero();
    U(Mz, Mz) = U(Qx, Qx) = U(Qy, Qy) = U(Mx, Mx) = 1;
    U(Mz, Qy) = arm.x();
    U(Mx, Qy) = -arm.z();
    return U;
}

/// (31) to (34): motion of a body's point by that of its first input.
Matrix48 motion_at(const Eigen::Vector3d& point) {
    Matrix48 H = Matrix48::Zero();
    H(0, X) = H(1, Y) = H(2, Tz) = H(3, Tx) = 1;
    H(1, Tz) = point.x();
    H(1, Tx) = -point.z();
    return H;
}

}  // namespace

double HydroplaneDeterminant::operator()(double frequency) const {
    const double omega = 2 * std::numbers::pi * frequency, w = omega * omega;
    const double m = 150, Jxx = 8, Jzz = 10, Jxz = -0.5;  // Jxz = ∫ x z dm
    const Eigen::Vector3d b(0.3, 0, 0), c(0.15, 0, 0.1), a(0.15, 0, 0.35), d(0.15, 0, -0.2);

    const Matrix8 U_L = blades(w, false), U_R = blades(w, true);                                           // (2)
    const Matrix8 U_9 = beam(w, 0.3, {2e9, 3e6, 2.3e6, 78, 0.12, 0}), U_11 = U_9;                          // (23)
    const Matrix8 U_26 = hinge({{X, 1e8}, {Y, 5e8}}), U_27 = hinge({{Y, 5e8}}), U_30 = U_26, U_31 = U_27;  // (15), (16)
    const Matrix8 U_28 = hinge({{Y, 2e8}}), U_29 = U_28, U_25 = hinge({{X, 1e8}, {Y, 5e8}});
    const Matrix8 U_24 = hinge({{X, 1e8}, {Y, kh_}}), U_20 = hinge({{Y, 8e8}, {Tx, 5e4}});  // (17), (18)
    const Matrix8 U_22 = hinge({{X, 1e8}, {Y, 8e8}, {Tz, 2e4}, {Tx, 2e4}});                 // (19)
    const Matrix8 U_col = U_20 * link(w) * U_22 * rod(w) * U_24 * U_25;

    // (10), input at the left shaft, output b at the right one, centre of mass c
    const bool is_right = equation10_ == Equation10::corrected;
    const double J_zz = Jzz + m * (is_right ? c.x() * c.x() : c.z() * c.z());
    const double J_xx = Jxx + m * (is_right ? c.z() * c.z() : c.x() * c.x());
    const double J_xz = Jxz + (is_right ? m * c.x() * c.z() : 0);
    Matrix8 U_10 = Matrix8::Identity();
    U_10(Y, Tz) = b.x();
    U_10(Y, Tx) = -b.z();
    U_10(Mz, Y) = m * w * (b.x() - c.x());
    U_10(Mz, Tz) = m * w * b.x() * c.x() - w * J_zz;
    U_10(Mz, Qy) = b.x();
    U_10(Mz, Tx) = -m * w * b.x() * c.z() + w * J_xz;
    U_10(Qx, X) = U_10(Qy, Y) = m * w;
    U_10(Qy, Tz) = m * w * c.x();
    U_10(Qy, Tx) = -m * w * c.z();
    U_10(Mx, Y) = m * w * (c.z() - b.z());
    U_10(Mx, Tz) = -m * w * b.z() * c.x() + w * J_xz;
    U_10(Mx, Qy) = -b.z();
    U_10(Mx, Tx) = m * w * b.z() * c.z() - w * J_xx;
    const Matrix8 U_10_2 = side_input(b - a), U_10_3 = side_input(b - d), U_8_2 = side_input({0, 0, 0});  // (11), (12), (14)
    const Matrix48 H = motion_at({0, 0, 0}), H_10 = motion_at(a), H_10_ = motion_at(d);                   // (31) to (34)

    Eigen::Matrix<double, 24, 48> U_all = Eigen::Matrix<double, 24, 48>::Zero();  // (36); Z of 1, 27, 29, 25, 31, 19
    U_all.block<8, 8>(0, 0) = U_R * U_11 * U_10 * U_9 * U_L;
    U_all.block<8, 8>(0, 8) = U_R * U_11 * U_10 * U_9 * U_8_2 * U_26 * U_27;
    U_all.block<8, 8>(0, 16) = U_R * U_11 * U_10_3 * U_28 * U_29;
    U_all.block<8, 8>(0, 24) = U_R * U_11 * U_10_2 * U_col;
    U_all.block<8, 8>(0, 32) = U_R * U_8_2 * U_30 * U_31;
    U_all.block<8, 8>(0, 40) = -Matrix8::Identity();
    U_all.block<4, 8>(8, 0) = -H * U_L;  // (5)
    U_all.block<4, 8>(8, 8) = H * U_26 * U_27;
    U_all.block<4, 8>(12, 0) = -H_10 * U_9 * U_L;  // (6)
    U_all.block<4, 8>(12, 8) = -H_10 * U_9 * U_8_2 * U_26 * U_27;
    U_all.block<4, 8>(12, 24) = H * U_col;
    U_all.block<4, 8>(16, 0) = -H_10_ * U_9 * U_L;  // (7)
    U_all.block<4, 8>(16, 8) = -H_10_ * U_9 * U_8_2 * U_26 * U_27;
    U_all.block<4, 8>(16, 16) = H * U_28 * U_29;
    U_all.block<4, 8>(20, 0) = -H * U_11 * U_10 * U_9 * U_L;  // (8)
    U_all.block<4, 8>(20, 8) = -H * U_11 * U_10 * U_9 * U_8_2 * U_26 * U_27;
    U_all.block<4, 8>(20, 16) = -H * U_11 * U_10_3 * U_28 * U_29;
    U_all.block<4, 8>(20, 24) = -H * U_11 * U_10_2 * U_col;
    U_all.block<4, 8>(20, 32) = H * U_30 * U_31;

    // (37): what is not zero at the tips
    static constexpr std::array<std::array<int, 4>, 6> kept{
        {{X, Y, Tz, Tx}, {Mz, Qx, Qy, Tx}, {X, Tz, Qy, Tx}, {Mz, Qx, Qy, Mx}, {Mz, Qx, Qy, Tx}, {X, Y, Tz, Tx}}};
    Eigen::Matrix<double, 24, 24> U;
    for (int tip = 0; tip < 6; ++tip)
        for (int k = 0; k < 4; ++k)
            U.col(4 * tip + k) =
                U_all.col(8 * tip + kept[static_cast<std::size_t>(tip)][static_cast<std::size_t>(k)]).normalized();
    for (int row = 0; row < 24; ++row) U.row(row).normalize();
    return U.fullPivLu().determinant();
}

}  // namespace dttmm::test
