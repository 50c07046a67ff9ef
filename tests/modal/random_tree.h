// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <Eigen/Geometry>

#include <memory>
#include <random>

#include "modal/modal_analysis.h"
#include "support/finite_elements.h"
#include "support/network_model.h"

namespace dttmm::test {

/// A random tree of beams, rods, hinges, springs and masses with ugly data, told twice: to the transfer matrices and, by
/// other words, to finite elements.
class RandomTree {
public:
    using Fe = FiniteElements;
    using Vector3 = Eigen::Vector3d;
    using Vector6 = Fe::Vector6;
    using Matrix3 = Eigen::Matrix3d;

    /// Of the directions left: all, or those of a frame in its plane or across it.
    explicit RandomTree(unsigned seed) : random_(seed) {
        const double kind = number(0, 1);
        directions_ = kind < 0.7 ? Fe::Dofs("111111") : kind < 0.85 ? Fe::Dofs("100011") : Fe::Dofs("011100");
        grow();
    }

    bool is_whole() const { return directions_.all(); }

    dttmm_modal_model model() {
        network_description_ = network_.description();
        return {&network_description_, 0, nullptr, static_cast<uint32_t>(directions_.to_ulong()), 0, nullptr};
    }

    Fe finite_elements(int count) const {
        Fe model;
        model.restrict(directions_);
        for (const auto& step : steps_) step(model, count);
        return model;
    }

    const std::string& story() const { return story_; }

private:
    double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    /// By its logarithm.
    double spread(double low, double high) { return std::exp(number(std::log(low), std::log(high))); }
    bool chance(double part) { return number(0, 1) < part; }
    int pick(int count) { return std::min(count - 1, static_cast<int>(number(0, count))); }

    Vector3 direction() {
        for (;;) {
            Vector3 d(number(-1, 1), number(-1, 1), is_whole() ? number(-1, 1) : 0);
            if (chance(0.15)) d = Vector3::Unit(pick(is_whole() ? 3 : 2));
            if (d.norm() > 0.1) return d.normalized();
        }
    }
    /// In a plane axes are those of the world, or turned in it.
    Matrix3 axes() {
        if (chance(0.4)) return Matrix3::Identity();
        if (!is_whole()) return Eigen::AngleAxisd(number(-3, 3), Vector3::UnitZ()).toRotationMatrix();
        return Eigen::AngleAxisd(number(-3, 3), direction()).toRotationMatrix();
    }
    std::vector<double> list(const Vector3& v) { return {v.x(), v.y(), v.z()}; }

    int node(const Vector3& position) {
        const int n = static_cast<int>(positions_.size());
        positions_.push_back(position);
        axes_.push_back(axes());
        network_.node(name(n), DTTMM_NODE_INNER, position, axes_.back());
        steps_.push_back([position](Fe& model, int) { model.node(position); });
        return n;
    }
    static std::string name(int node) { return fmt::format("n{}", node); }
    std::string next_name(const char* type) { return fmt::format("{}{}", type, ++element_count_); }

    struct Strength {
        NetworkModel::Values values;
        Fe::Section section;
    };

    /// A section by its numbers or by its shape; what they mean is told to the finite elements by textbook formulas.
    Strength strength(bool is_timoshenko) {
        Strength s;
        Fe::Section& f = s.section;
        if (chance(0.5)) {
            const double size = spread(0.01, 0.06), stiff = spread(1e9, 3e11), mass = spread(1, 60);
            f.EA = stiff * size * size;
            f.EIy = f.EA * size * size * number(0.03, 0.3);
            f.EIz = f.EA * size * size * number(0.03, 0.3);
            f.GJ = f.EA * size * size * number(0.03, 0.3);
            f.mass = mass;
            s.values = {{"section.EA", {f.EA}},
                        {"section.EIy", {f.EIy}},
                        {"section.EIz", {f.EIz}},
                        {"section.GJ", {f.GJ}},
                        {"section.mass", {mass}}};
            double own = mass * (f.EIy + f.EIz) / f.EA;
            if (is_timoshenko) {
                f.shear_y = f.EA * number(0.1, 0.4), f.shear_z = f.EA * number(0.1, 0.4);
                f.rotary_y = mass * f.EIy / f.EA, f.rotary_z = mass * f.EIz / f.EA;
                s.values["section.GAy"] = {f.shear_y}, s.values["section.GAz"] = {f.shear_z};
            }
            const bool is_offset = chance(0.4), is_told = chance(0.5);
            if (is_offset) f.mass_offset = {size * number(-1.5, 1.5), size * number(-1.5, 1.5)};
            if (is_told) own = mass * size * size * number(0.1, 1);
            f.inertia = own + mass * f.mass_offset.squaredNorm();
            if (is_offset) s.values["section.mass_offset"] = {f.mass_offset.x(), f.mass_offset.y()};
            if (is_told) s.values["section.inertia"] = {f.inertia};
        } else {
            const double E = spread(3e9, 2.5e11), nu = number(0.1, 0.45), G = E / (2 * (1 + nu)), rho = spread(800, 9000);
            double A, Iy, Iz, J, kappa;
            if (chance(0.5)) {
                const double D = spread(0.01, 0.12), d = D * number(0.1, 0.9), m = d / D, q = (1 + m * m) * (1 + m * m);
                A = std::numbers::pi / 4 * (D * D - d * d);
                Iy = Iz = std::numbers::pi / 64 * (std::pow(D, 4) - std::pow(d, 4));
                J = 2 * Iy;
                kappa = 6 * (1 + nu) * q / ((7 + 6 * nu) * q + (20 + 12 * nu) * m * m);  // Cowper
                s.values = {{"section.tube", {D, d}}};
            } else {
                // A square: J = 0.140577 b⁴
                const double b = spread(0.008, 0.1);
                A = b * b, Iy = Iz = b * b * b * b / 12, J = 0.1405770149 * b * b * b * b;
                kappa = number(0.5, 0.9);
                s.values = {{"section.rectangle", {b, b}}, {"section.shear_coefficient", {kappa}}};
            }
            s.values["material.E"] = {E}, s.values["material.poisson"] = {nu}, s.values["material.density"] = {rho};
            f.EA = E * A, f.EIy = E * Iy, f.EIz = E * Iz, f.GJ = G * J, f.mass = rho * A;
            f.inertia = rho * (Iy + Iz);
            if (is_timoshenko) f.shear_y = f.shear_z = kappa * G * A, f.rotary_y = rho * Iy, f.rotary_z = rho * Iz;
        }
        return s;
    }

    void beam(int from, int to) {
        const bool is_timoshenko = chance(0.5);
        const Strength s = strength(is_timoshenko);
        NetworkModel::Values values = s.values;
        values["theory"] = {is_timoshenko ? 1.0 : 0.0};
        Vector3 up = Vector3::Constant(std::numeric_limits<double>::quiet_NaN());
        const Vector3 x = (positions_[static_cast<size_t>(to)] - positions_[static_cast<size_t>(from)]).normalized();
        if (is_whole() && chance(0.5)) {
            do up = direction();
            while (up.cross(x).norm() < 0.1);
            values["up"] = list(up);
        }
        network_.element(next_name("beam"), "beam", {name(from), name(to)}, values);
        story_ += fmt::format("beam n{} n{} {}{}; ", from, to, is_timoshenko ? "Timoshenko" : "Euler",
                              s.section.mass_offset.norm() > 0 ? " offset" : "");
        steps_.push_back([=](Fe& model, int count) {
            if (up.hasNaN())
                model.beam(from, to, s.section, count);
            else
                model.beam(from, to, s.section, count, up);
        });
    }

    void rod(int from, int to) {
        const double EA = spread(1e5, 1e9), mass = spread(0.5, 20), inertia = spread(1e-4, 1e-2);
        const Vector3 way = positions_[static_cast<size_t>(to)] - positions_[static_cast<size_t>(from)];
        network_.element(next_name("rod"), "rod", {name(from), name(to)},
                         {{"section.EA", {EA}}, {"section.mass", {mass}}, {"section.inertia", {inertia}}});
        story_ += fmt::format("rod n{} n{}; ", from, to);
        const bool is_bar = is_whole();
        steps_.push_back([=](Fe& model, int count) {
            model.rod(from, to, EA, mass, count, is_bar ? Fe::Across::rigid_bar : Fe::Across::unchanged);
            const Vector3 e = way.normalized();
            if (is_bar) model.mass(from, 0, {0, 0, 0}, inertia * way.norm() * e * e.transpose());
        });
    }

    /// Elastic, rigid or free by direction; −1: the ground.
    void hinge(int from, int to, double rigid, double free) {
        NetworkModel::Values values;
        Vector6 k;
        static const std::array<const char*, 6> keys = {"x", "y", "z", "rx", "ry", "rz"};
        std::string text;
        for (int d = 0; d < 6; ++d) {
            const double what = number(0, 1);
            const bool is_rigid = what < rigid, is_free = !is_rigid && what < rigid + free;
            k(d) = is_rigid ? Fe::kRigid : is_free ? 0 : d < 3 ? spread(1e4, 1e8) : spread(1e2, 1e6);
            values[fmt::format("stiffness.{}", keys[static_cast<size_t>(d)])] = {k(d)};
            text += is_rigid ? "r" : is_free ? "-" : "e";
        }
        join("elastic_hinge", from, to, values, k, text);
    }

    void spring(int from, int to) {
        const Vector6 k = (Vector6() << spread(1e3, 1e7), spread(1e3, 1e7), chance(0.2) ? 0 : spread(1e3, 1e7),
                           spread(10, 1e5), chance(0.2) ? 0 : spread(10, 1e5), spread(10, 1e5))
                              .finished();
        join("spring_damper", from, to,
             {{"stiffness", list(k.head<3>())}, {"rotational_stiffness", list(k.tail<3>())}, {"damping", {number(0, 100)}}},
             k, "");
    }

    void join(const char* type, int from, int to, const NetworkModel::Values& values, const Vector6& k,
              const std::string& text) {
        std::string first = from < 0 ? fmt::format("ground{}", ++ground_count_) : name(from);
        if (from < 0) network_.node(first, DTTMM_NODE_GROUND, positions_[static_cast<size_t>(to)]);
        network_.element(next_name(type), type, {first, name(to)}, values);
        story_ += fmt::format("{} {} n{} {}; ", type, first, to, text);
        const Matrix3 R = from < 0 ? Matrix3(Matrix3::Identity()) : axes_[static_cast<size_t>(from)];
        steps_.push_back([=](Fe& model, int) { model.joint(from, to, k, R); });
    }

    /// A body on a node or on two of them.
    void body(int first, int second) {
        const double mass = spread(0.1, 300), size = spread(0.02, 0.4);
        // Of three principal moments that a mass can have
        const Vector3 square(number(0.1, 1), number(0.1, 1), number(0.1, 1));
        Matrix3 inertia =
            mass * size * size *
            Vector3(square.y() + square.z(), square.z() + square.x(), square.x() + square.y()).asDiagonal().toDenseMatrix();
        Vector3 centre = size * Vector3(number(-1, 1), number(-1, 1), number(-1, 1));
        if (is_whole()) {
            const Matrix3 turn = Eigen::AngleAxisd(number(-3, 3), direction()).toRotationMatrix();
            inertia = turn * inertia * turn.transpose();
        } else {
            centre.z() = 0;
        }
        std::vector<std::string> ends = {name(first)};
        if (second >= 0) ends.push_back(name(second));
        network_.element(next_name("body"), "rigid_body", ends,
                         {{"mass", {mass}},
                          {"center_of_mass", list(centre)},
                          {"inertia.xx", {inertia(0, 0)}},
                          {"inertia.yy", {inertia(1, 1)}},
                          {"inertia.zz", {inertia(2, 2)}},
                          {"inertia.xy", {inertia(0, 1)}},
                          {"inertia.xz", {inertia(0, 2)}},
                          {"inertia.yz", {inertia(1, 2)}}});
        story_ += fmt::format("body n{} n{}; ", first, second);
        const Matrix3 R = axes_[static_cast<size_t>(first)];
        steps_.push_back([=](Fe& model, int) {
            if (second >= 0) model.rigid_link(first, second);
            model.mass(first, mass, R * centre, R * inertia * R.transpose());
        });
    }

    void fix(int node, Fe::Dofs dofs) {
        network_.fix(name(node), static_cast<uint32_t>(dofs.to_ulong()));
        story_ += fmt::format("fix n{} {}; ", node, dofs.to_string());
        steps_.push_back([=](Fe& model, int) { model.fix(node, dofs); });
    }

    void grow() {
        node({number(-1, 1), number(-1, 1), is_whole() ? number(-1, 1) : 0});
        const double start = number(0, 1);
        const bool is_clamped = start < 0.4;
        if (is_clamped)
            fix(0, Fe::Dofs().set());
        else if (start < 0.6)
            spring(-1, 0), body(0, -1);
        else if (start < 0.8)
            hinge(-1, 0, 0.3, 0.3), body(0, -1);
        else
            body(0, -1);
        const int members = 2 + pick(5);
        bool has_waves = false;
        for (int m = 0; m < members; ++m) {
            const int from = pick(static_cast<int>(positions_.size()));
            const Vector3 at = positions_[static_cast<size_t>(from)];
            const double kind = number(0, 1);
            const bool is_last = m + 1 == members;
            if (kind < 0.55 || (is_last && !has_waves)) {
                const int to = node(at + spread(0.1, 3) * direction());
                beam(from, to);
                has_waves = true;
                if (chance(0.2)) body(to, -1);
                if (chance(0.1)) spring(-1, to);
                if (chance(0.1)) fix(to, partly());
            } else if (kind < 0.8) {
                const int to = node(chance(0.6) ? at : Vector3(at + spread(0.05, 0.4) * direction()));
                hinge(from, to, 0.45, 0.15);
                grow_mass(to);
            } else if (kind < 0.9) {
                const int to = node(chance(0.6) ? at : Vector3(at + spread(0.05, 0.4) * direction()));
                spring(from, to);
                grow_mass(to);
            } else {
                const int to = node(at + spread(0.1, 1) * direction());
                rod(from, to);
                grow_mass(to);
            }
        }
    }

    /// What a node needs that hangs on something that gives: a body, or a beam that goes on.
    void grow_mass(int at) {
        if (chance(0.5)) {
            int second = -1;
            if (chance(0.3)) second = node(positions_[static_cast<size_t>(at)] + spread(0.05, 0.5) * direction());
            body(at, second);
        } else {
            beam(at, node(positions_[static_cast<size_t>(at)] + spread(0.1, 2) * direction()));
        }
    }

    Fe::Dofs partly() {
        Fe::Dofs dofs(static_cast<unsigned long>(1 + pick(62)));
        return dofs;
    }

    std::mt19937_64 random_;
    Fe::Dofs directions_;
    NetworkModel network_;
    dttmm_network network_description_{};
    std::vector<Vector3> positions_;
    std::vector<Matrix3> axes_;
    std::vector<std::function<void(Fe&, int)>> steps_;
    std::string story_;
    int element_count_ = 0, ground_count_ = 0;
};

}  // namespace dttmm::test
