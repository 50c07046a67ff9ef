// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

namespace dttmm::test {

/// Where a machine stands: all of it turned, then moved [m].
struct Placement {
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    Eigen::Vector3d way = Eigen::Vector3d::Zero();
};

/// Scale factors of a machine of the same shape. Powers of two change no digit.
struct Units {
    double length = 1, mass = 1, time = 1;

    double force() const { return mass * length / (time * time); }
    double stiffness() const { return mass / (time * time); }
    double area() const { return length * length; }
};

/// How stiff parts may be.
struct Stiffest {
    double decades = 2;  ///< of ωh
    double most = 1e9;   ///< [N/m]: what rounding of positions makes of that is a force of 1e-6 N
};
inline constexpr Stiffest kHard{3, 1e13};  ///< k h²/m up to 1e6

/// A model file drawn from a seed: bodies light and heavy in a tree, held by springs, ideal joints, beams, rods and chains
/// of these through nodes with and without masses; loops; parts stiff and soft beside the step (ωh from 0.01 to 100); loads
/// and gravity. The same seed gives the same machine wherever it stands, and by every compiler: no two numbers are drawn in
/// one expression, whose parts have no order.
class RandomMachine {
public:
    /// steps: of the run.
    explicit RandomMachine(uint64_t seed, int steps = 40, const Placement& placement = {}, const Units& units = {},
                           const Stiffest& stiffest = {})
        : random_(seed), placement_(placement), units_(units), stiffest_(stiffest) {
        constexpr double kSteps[] = {1e-4, 2e-4, 5e-4, 1e-3};
        step_ = kSteps[pick(4)];
        const bool has_gravity = chance(0.5);
        const Eigen::Vector3d gravity = turned(9.81 * direction());
        const double time = units_.time;
        text_ = fmt::format("[simulation]\nstep = {}\nduration = {}\n", time * step_, time * rounded(steps * step_, 12));
        if (has_gravity) text_ += "gravity = " + list(units_.force() / units_.mass * gravity) + "\n";
        if (chance(0.15)) text_ += "spectral_radius = 0.8\n";
        text_ += fmt::format("[output]\nstep = {}\n", time * rounded(step_, 12));
        const int bodies = 1 + pick(5);
        for (int b = 0; b < bodies; ++b) add_body();
        for (int b = 0; b < bodies; ++b) hold(b, pick(b + 1) - 1);
        for (int loop = pick(3); loop > 0 && bodies > 1; --loop) {
            const int a = pick(bodies), b = pick(bodies);
            if (a != b) add_link(a, b);
        }
        if (chance(0.3)) add_branch(pick(bodies));
        for (int load = 1 + pick(2); load > 0; --load) add_load(pick(bodies));
        text_ += "[nodes]\n" + nodes_ + parts_;
    }
    /// Without its format.
    const std::string& text() const { return text_; }
    double step() const { return units_.time * step_; }  ///< [s]

private:
    struct Body {
        Eigen::Vector3d position;
        Eigen::Quaterniond attitude;
        double mass;
        int markers = 0;
    };

    double uniform(double low, double high) { return low + (high - low) * static_cast<double>(random_() >> 11) * 0x1p-53; }
    double power(double low, double high) { return std::pow(10, uniform(low, high)); }
    int pick(int count) { return static_cast<int>(uniform(0, count)); }
    bool chance(double share) { return uniform(0, 1) < share; }
    Eigen::Vector3d vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }
    Eigen::Vector3d direction() {
        for (;;) {
            const Eigen::Vector3d v = vector(1);
            if (v.norm() > 0.1 && v.norm() < 1) return v.normalized();
        }
    }
    Eigen::Vector3d direction(double low, double high) {
        const Eigen::Vector3d along = direction();
        return uniform(low, high) * along;
    }
    Eigen::Quaterniond rotation() {
        const Eigen::Vector3d axis = direction();
        return Eigen::Quaterniond(Eigen::AngleAxisd(uniform(0, 3), axis));
    }
    static std::string list(const Eigen::Vector3d& v) {
        return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z());
    }
    Eigen::Vector3d turned(const Eigen::Vector3d& v) const { return placement_.turn * v; }
    Eigen::Vector3d placed(const Eigen::Vector3d& x) const { return units_.length * (placement_.turn * x + placement_.way); }
    static double rounded(double x, int digits) { return std::stod(fmt::format("{:.{}g}", x, digits)); }
    std::string attitude(const Eigen::Quaterniond& own) const {
        Eigen::Quaterniond q(placement_.turn * own.toRotationMatrix());
        q.normalize();
        return fmt::format("[{:.17g}, {:.17g}, {:.17g}, {:.17g}]", q.w(), q.x(), q.y(), q.z());
    }

    void add_body() {
        Body body;
        const auto b = static_cast<double>(bodies_.size());
        body.position = Eigen::Vector3d(1.3 * b, 0.4 * std::sin(3 * b), 0.3 * b) + vector(0.3);
        body.attitude = rotation();
        body.mass = power(-1, 2);
        const double depth = uniform(0.1, 0.5), height = uniform(0.1, 0.5), length = uniform(0.1, 0.5);
        parts_ += fmt::format(
            "[[body]]\nname = \"b{}\"\nmass = {:.17g}\nbox = [{:.17g}, {:.17g}, {:.17g}]\nposition = {}\n"
            "quaternion = {}\nmarkers = {{ ",
            bodies_.size(), units_.mass * body.mass, units_.length * length, units_.length * height, units_.length * depth,
            list(placed(body.position)), attitude(body.attitude));
        for (int m = 0; m < kMarkers; ++m) {
            markers_.push_back(vector(0.25));
            parts_ += fmt::format("{}m{} = {}", m > 0 ? ", " : "", m, list(units_.length * markers_.back()));
        }
        parts_ += " }\n";
        bodies_.push_back(body);
    }
    Eigen::Vector3d place(int body, int marker) const {
        const Body& own = bodies_[static_cast<size_t>(body)];
        return own.position + own.attitude * markers_[static_cast<size_t>(kMarkers * body + marker)];
    }
    std::string end(int body, int marker) const { return body < 0 ? "ground" : fmt::format("b{}.m{}", body, marker); }

    /// A node; its name.
    std::string add_node(const Eigen::Vector3d& at, bool is_fixed) {
        const std::string name = fmt::format("n{}", node_count_++);
        nodes_ += fmt::format("{} = {{ position = {}, quaternion = {}{} }}\n", name, list(placed(at)), attitude(rotation()),
                              is_fixed ? ", fixed = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]" : "");
        return name;
    }
    std::string element(const char* type) {
        return fmt::format("[[element]]\nname = \"e{}\"\ntype = \"{}\"\n", element_count_++, type);
    }
    /// A stiffness whose ωh is somewhere between soft and hard for a mass.
    double stiffness(double mass) {
        return std::min(stiffest_.most, mass * std::pow(power(-2, stiffest_.decades) / step_, 2));
    }

    void add_spring(int from_body, int to_body) {
        const std::string to = end(to_body, pick(kMarkers)), from = end(from_body, pick(kMarkers));
        const double mass = bodies_[static_cast<size_t>(to_body)].mass;
        const double k = stiffness(mass), arm = uniform(0.05, 0.2), damping = chance(0.5) ? power(-5, -3) : 0;
        const auto three = [&](double size) {
            const double z = uniform(0.2, 1), y = uniform(0.2, 1), x = uniform(0.2, 1);
            return Eigen::Vector3d(size * x, size * y, size * z);
        };
        const Eigen::Vector3d way = units_.stiffness() * three(k),
                              turn = units_.stiffness() * units_.area() * three(k * arm * arm);
        parts_ +=
            element("spring_damper") + fmt::format("from = \"{}\"\nto = \"{}\"\nstiffness = {}\nrotational_stiffness = {}\n",
                                                   from, to, list(way), list(turn));
        if (damping > 0)
            parts_ += fmt::format("damping = {}\nrotational_damping = {}\n", list(units_.time * (damping * way)),
                                  list(units_.time * (damping * turn)));
    }
    void add_beam(const std::string& from, const std::string& to) {
        const double outer = power(-2.2, -1.2);
        const bool is_rod = chance(0.1);
        const double damping = chance(0.5) ? power(-6, -4) : 0.0, density = power(3, 4), E = power(9.5, 11.5),
                     inner = uniform(0, 0.8) * outer;
        const int segments = 1 + pick(6);
        parts_ +=
            element(is_rod ? "rod" : "beam") +
            fmt::format(
                "from = \"{}\"\nto = \"{}\"\nsegments = {}\nsection = {{ tube = [{:.17g}, {:.17g}] }}\n"
                "material = {{ E = {:.17g}, poisson = 0.3, density = {:.17g}, stiffness_damping = {} }}\n",
                from, to, segments, units_.length * outer, units_.length * inner, units_.stiffness() / units_.length * E,
                units_.mass / std::pow(units_.length, 3) * density, units_.time * rounded(damping, 3));
        if (!is_rod) parts_ += fmt::format("up = {}\n", list(turned(direction())));
    }
    /// A chain of beams through nodes, some with masses.
    void add_chain(int from, int to) {
        const Eigen::Vector3d finish = place(to, pick(kMarkers));
        Eigen::Vector3d at = from < 0 ? Eigen::Vector3d(finish + direction(0.4, 1.2)) : place(from, 0);
        std::string here = from < 0 ? add_node(at, true) : end(from, 0);
        for (int more = pick(3); more > 0; --more) {
            const Eigen::Vector3d next = 0.5 * (at + place(to, 1)) + vector(0.2);
            const std::string node = add_node(next, false);
            add_beam(here, node);
            if (chance(0.4)) {
                parts_ +=
                    element("point_mass") + fmt::format("at = \"{}\"\nmass = {:.17g}\n", node, units_.mass * power(-2, 1));
            } else if (chance(0.5)) {
                const double mass = power(-1, 1), size = mass * std::pow(uniform(0.05, 0.2), 2),
                             inertia = units_.mass * units_.area();
                parts_ += element("rigid_body") +
                          fmt::format(
                              "at = \"{}\"\nmass = {:.17g}\ncenter_of_mass = {}\ninertia = {{ xx = {:.17g}, yy = "
                              "{:.17g}, zz = {:.17g} }}\n",
                              node, units_.mass * mass, list(units_.length * vector(0.1)), inertia * size,
                              inertia * (1.2 * size), inertia * (1.5 * size));
            }
            here = node;
            at = next;
        }
        if (chance(0.25)) {
            const std::string node = add_node(place(to, 1) + vector(0.1), false);
            add_beam(here, node);
            const double unit = units_.stiffness();
            const std::string others =
                chance(0.5) ? fmt::format("x = {}", unit * 3e6) : fmt::format("y = {}, z = {}", unit * 4e5, unit * 7e6);
            const double k = stiffness(bodies_[static_cast<size_t>(to)].mass) * 0.01;
            parts_ +=
                element("elastic_hinge") + fmt::format("from = \"{}\"\nto = \"{}\"\nstiffness = {{ {} = {:.17g}, {} }}\n",
                                                       node, end(to, 1), kAxes[pick(3)], unit * units_.area() * k, others);
        } else {
            add_beam(here, end(to, 1));
        }
    }
    void add_joint(int from, int to) {
        constexpr const char* kTypes[] = {"ball", "hinge", "slider", "universal"};
        const int type = pick(4);
        const Eigen::Vector3d axis = direction(), second = axis.cross(direction()).normalized();
        parts_ += fmt::format("[[joint]]\nname = \"j{}\"\ntype = \"{}\"\nbetween = [\"{}\", \"b{}\"]\nanchor = {}\n",
                              joint_count_++, kTypes[type], from < 0 ? "ground" : fmt::format("b{}", from), to,
                              list(placed(place(to, 2) + vector(0.1))));
        if (type > 0) parts_ += "axis = " + list(turned(axis)) + "\n";
        if (type == 3) parts_ += "axis2 = " + list(turned(second)) + "\n";
    }
    void add_link(int from, int to) {
        if (chance(0.6))
            add_spring(from, to);
        else
            add_chain(from, to);
    }
    void hold(int body, int by) {
        if (chance(0.25)) add_joint(by, body);
        if (chance(0.25)) return add_chain(by, body);
        for (int count = 1 + pick(4); count > 0; --count) add_spring(by, body);
    }
    /// A beam that sticks out.
    void add_branch(int body) {
        const std::string node = add_node(place(body, 3) + direction(0.3, 0.8), false);
        add_beam(end(body, 3), node);
        if (chance(0.5))
            parts_ += element("point_mass") + fmt::format("at = \"{}\"\nmass = {:.17g}\n", node, units_.mass * power(-2, 0));
    }
    void add_load(int body) {
        const double size = units_.force() * (bodies_[static_cast<size_t>(body)].mass * power(-1, 1));
        const std::string signal =
            chance(0.5) ? fmt::format("{{ type = \"sine\", amplitude = {:.17g}, frequency = {:.17g} }}", size,
                                      uniform(0.005, 0.03) / step_ / units_.time)
                        : fmt::format("{{ type = \"haversine\", peak = {:.17g}, width = {:.17g}, start = 0 }}", size,
                                      units_.time * (uniform(20, 60) * step_));
        parts_ +=
            fmt::format("[[load]]\non = \"b{}\"\ndirection = {}\nforce = {}\n", body, list(turned(direction())), signal);
    }

    static constexpr int kMarkers = 4;
    static constexpr const char* kAxes[] = {"rx", "ry", "rz"};
    std::mt19937_64 random_;
    Placement placement_;
    Units units_;
    Stiffest stiffest_;
    double step_;
    std::vector<Body> bodies_;
    std::vector<Eigen::Vector3d> markers_;
    int node_count_ = 0, element_count_ = 0, joint_count_ = 0;
    std::string text_, nodes_, parts_;
};

}  // namespace dttmm::test
