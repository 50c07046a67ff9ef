// SPDX-License-Identifier: BSD-3-Clause
//
// Random machines at rest: against the minimum of their energy, against damped runs that come to rest, and against the
// ring-down of small vibrations.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <sstream>
#include <tuple>

#include "cli/modes_run.h"
#include "cli/static_run.h"
#include "support/linear_algebra.h"

namespace dttmm::host {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Quaterniond;
using Eigen::Vector3d;
using Eigen::VectorXd;

std::string numbers_of(const Vector3d& v) { return fmt::format("[{:.17g}, {:.17g}, {:.17g}]", v.x(), v.y(), v.z()); }

Matrix3d turn_of(const Vector3d& theta) {
    const double angle = theta.norm();
    return angle > 0 ? Eigen::AngleAxisd(angle, theta / angle).toRotationMatrix() : Matrix3d(Matrix3d::Identity());
}

Vector3d vector_of_turn(const Matrix3d& R) {
    const Eigen::AngleAxisd turn(R);
    return turn.angle() * turn.axis();
}

struct BodyPose {
    Vector3d position;  ///< of the centre of mass
    Matrix3d rotation;
};

/// Bodies in a row, joined by springs with and without rotational stiffness, cords under preload, balls and hinges, with a
/// lasting force at a point of each. Points of bodies are in their axes, from their centre of mass; of the ground in the
/// world.
struct RandomRest {
    struct Part {
        Vector3d centre;  ///< of mass, from the origin
        BodyPose start;
        double mass;
        Vector3d inertia, point, force;
    };
    struct Mount {
        int from, to;
        Vector3d at;       ///< of `to`
        Matrix3d axes;     ///< world at the start
        Vector3d k, turn;  ///< stiffness
    };
    struct Cord {
        int from, to;
        Vector3d a, b;
        double k, preload, length = 0;  ///< at the start
    };
    struct Pin {
        int from, to;
        Vector3d anchor, axis;  ///< world at the start; axis zero: a ball
    };
    Vector3d gravity;
    std::vector<Part> parts;
    std::vector<Mount> mounts;
    std::vector<Cord> cords;
    std::vector<Pin> pins;

    explicit RandomRest(unsigned seed) : random_(seed) {
        gravity = Vector3d(0, 0, -9.81) + vector(3);
        const int count = 2 + static_cast<int>(seed % 3);
        for (int b = 0; b < count; ++b) {
            Part part;
            part.centre = vector(0.1);
            part.start = {Vector3d(0.9 * b, 0.2 * b, 0.1) + vector(0.15), turn_of(vector(1.2))};
            part.mass = uniform(1, 9);
            for (int d = 0; d < 3; ++d) part.inertia(d) = part.mass * uniform(0.02, 0.03);
            part.point = vector(0.25);
            part.force = vector(25);
            parts.push_back(part);
        }
        for (int b = 0; b < count; ++b) {
            const double k = 9.81 * parts[static_cast<size_t>(b)].mass / uniform(0.01, 0.03);
            for (int i = 0; i < (b == 0 ? 3 : 2); ++i) add_mount(i == 1 && b > 0 ? b - 1 : -1, b, k);
            if (b > 0) cords.push_back({b - 1, b, vector(0.2), vector(0.2), k, uniform(-0.1, 0.3) * k * 0.02});
            if (b > 0 && (b + static_cast<int>(seed)) % 2 == 0)
                pins.push_back(
                    {b - 1, b, at(b, vector(0.2)), seed % 4 < 2 ? Vector3d(vector(1)) : Vector3d(Vector3d::Zero())});
        }
        for (Cord& cord : cords) cord.length = line(cord, start());
    }

    double uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    Vector3d vector(double size) { return {uniform(-size, size), uniform(-size, size), uniform(-size, size)}; }

    std::vector<BodyPose> start() const {
        std::vector<BodyPose> poses;
        for (const Part& part : parts) poses.push_back(part.start);
        return poses;
    }
    BodyPose first(int body) const {
        return body < 0 ? BodyPose{Vector3d::Zero(), Matrix3d::Identity()} : parts[static_cast<size_t>(body)].start;
    }

    /// Potential of springs and cords, and of weight and forces to a share [J].
    double energy(const std::vector<BodyPose>& poses, double share) const {
        double sum = 0;
        for (size_t b = 0; b < parts.size(); ++b)
            sum -= share * (parts[b].mass * gravity.dot(poses[b].position) +
                            parts[b].force.dot(poses[b].position + poses[b].rotation * parts[b].point));
        for (const Mount& m : mounts) {
            const BodyPose from = pose(m.from, poses), from0 = first(m.from), to = pose(m.to, poses), to0 = first(m.to);
            const Matrix3d turned = from.rotation * from0.rotation.transpose();
            const Vector3d p = to.position + to.rotation * m.at, p0 = to0.position + to0.rotation * m.at;
            const Vector3d d = m.axes.transpose() * (turned.transpose() * (p - from.position) - (p0 - from0.position));
            const Vector3d theta =
                m.axes.transpose() * vector_of_turn(turned.transpose() * to.rotation * to0.rotation.transpose());
            sum += 0.5 * d.dot(m.k.cwiseProduct(d)) + 0.5 * theta.dot(m.turn.cwiseProduct(theta));
        }
        for (const Cord& c : cords) {
            const double stretch = line(c, poses) - c.length + c.preload / c.k;
            sum += 0.5 * c.k * stretch * stretch;
        }
        return sum;
    }
    VectorXd closure(const std::vector<BodyPose>& poses) const {
        std::vector<double> rows;
        for (const Pin& p : pins) {
            const BodyPose f0 = first(p.from), t0 = first(p.to), f = pose(p.from, poses), t = pose(p.to, poses);
            const Vector3d gap = f.position + f.rotation * (f0.rotation.transpose() * (p.anchor - f0.position)) -
                                 t.position - t.rotation * (t0.rotation.transpose() * (p.anchor - t0.position));
            for (const double g : gap) rows.push_back(g);
            if (p.axis.isZero(0)) continue;
            const Vector3d a = p.axis.normalized(), u = a.unitOrthogonal(), w = a.cross(u);
            const Vector3d axis = t.rotation * (t0.rotation.transpose() * a);
            for (const Vector3d& across : {u, w})
                rows.push_back((f.rotation * (f0.rotation.transpose() * across)).dot(axis));
        }
        return Eigen::Map<VectorXd>(rows.data(), static_cast<Eigen::Index>(rows.size()));
    }

    /// What is to stand in [simulation], how damped, and more.
    std::string text(const std::string& simulation, double damping, const std::string& more = "") const {
        std::string text =
            fmt::format("format = \"dttmm/1\"\n[simulation]\ngravity = {}\n{}\n", numbers_of(gravity), simulation);
        std::string list;
        for (size_t b = 0; b < parts.size(); ++b) {
            const Part& part = parts[b];
            const Quaterniond q(part.start.rotation);
            list += fmt::format(
                "[[body]]\nname = \"b{}\"\nmass = {:.17g}\ninertia = {}\ncenter_of_mass = {}\nposition = {}\n"
                "quaternion = [{:.17g}, {:.17g}, {:.17g}, {:.17g}]\nmarkers.load = {}\n",
                b, part.mass, numbers_of(part.inertia), numbers_of(part.centre),
                numbers_of(part.start.position - part.start.rotation * part.centre), q.w(), q.x(), q.y(), q.z(),
                numbers_of(part.centre + part.point));
            for (size_t m = 0; m < mounts.size(); ++m)
                if (mounts[m].to == static_cast<int>(b))
                    list += fmt::format("markers.m{} = {}\n", m, numbers_of(part.centre + mounts[m].at));
            for (size_t c = 0; c < cords.size(); ++c)
                for (const auto& [body, point, end] :
                     {std::tuple(cords[c].from, cords[c].a, "a"), {cords[c].to, cords[c].b, "b"}})
                    if (body == static_cast<int>(b))
                        list += fmt::format("markers.c{}{} = {}\n", c, end, numbers_of(part.centre + point));
            list += fmt::format("[[load]]\non = \"b{}.load\"\ndirection = {}\nforce = {:.17g}\n", b, numbers_of(part.force),
                                part.force.norm());
        }
        for (size_t m = 0; m < mounts.size(); ++m) {
            const Mount& own = mounts[m];
            const Eigen::AngleAxisd axes(own.axes);
            list += fmt::format(
                "[[element]]\nname = \"m{0}\"\ntype = \"spring_damper\"\nfrom = \"{1}\"\nto = \"b{2}.m{0}\"\n"
                "axes = {{ axis = {3}, angle = {4:.17g} }}\nstiffness = {5}\nrotational_stiffness = {6}\ndamping = {7}\n"
                "rotational_damping = {8}\n",
                m, own.from < 0 ? "ground" : fmt::format("b{}", own.from), own.to, numbers_of(axes.axis()), axes.angle(),
                numbers_of(own.k), numbers_of(own.turn), numbers_of(damping * own.k), numbers_of(damping * own.turn));
        }
        for (size_t c = 0; c < cords.size(); ++c)
            list += fmt::format(
                "[[element]]\nname = \"c{0}\"\ntype = \"axial_spring\"\nfrom = \"b{1}.c{0}a\"\nto = \"b{2}.c{0}b\"\n"
                "stiffness = {3:.17g}\npreload = {4:.17g}\n",
                c, cords[c].from, cords[c].to, cords[c].k, cords[c].preload);
        for (size_t p = 0; p < pins.size(); ++p)
            list +=
                fmt::format("[[joint]]\nname = \"p{}\"\ntype = \"{}\"\nbetween = [\"b{}\", \"b{}\"]\nanchor = {}\n{}", p,
                            pins[p].axis.isZero(0) ? "ball" : "hinge", pins[p].from, pins[p].to, numbers_of(pins[p].anchor),
                            pins[p].axis.isZero(0) ? "" : fmt::format("axis = {}\n", numbers_of(pins[p].axis)));
        return text + more + list;
    }

private:
    static BodyPose pose(int body, const std::vector<BodyPose>& poses) {
        return body < 0 ? BodyPose{Vector3d::Zero(), Matrix3d::Identity()} : poses[static_cast<size_t>(body)];
    }
    double line(const Cord& c, const std::vector<BodyPose>& poses) const {
        const BodyPose f = pose(c.from, poses), t = pose(c.to, poses);
        return (t.position + t.rotation * c.b - f.position - f.rotation * c.a).norm();
    }
    Vector3d at(int body, const Vector3d& point) const {
        const BodyPose& own = parts[static_cast<size_t>(body)].start;
        return own.position + own.rotation * point;
    }
    void add_mount(int from, int to, double k) {
        Mount mount{from, to, vector(0.3), turn_of(vector(1.5)), {}, Vector3d::Zero()};
        for (int d = 0; d < 3; ++d) mount.k(d) = k * uniform(0.3, 1);
        if (uniform(0, 1) < 0.6)
            for (int d = 0; d < 3; ++d) mount.turn(d) = 0.04 * k * uniform(0.3, 1);
        mounts.push_back(mount);
    }
    std::mt19937 random_;
};

// ---- The minimum of the energy ------------------------------------------------------------------------------------------

std::vector<BodyPose> shifted(std::vector<BodyPose> poses, const VectorXd& by) {
    for (size_t b = 0; b < poses.size(); ++b) {
        const auto own = by.segment<6>(6 * static_cast<Eigen::Index>(b));
        poses[b].position += own.head<3>();
        poses[b].rotation = turn_of(own.tail<3>()) * poses[b].rotation;
    }
    return poses;
}

/// The derivative by shifts and turns, of fourth order.
template <class Function>
auto derivative_of(const Function& f, Eigen::Index n, double step) {
    std::vector<decltype(f(VectorXd(VectorXd::Zero(n))))> columns;
    for (Eigen::Index i = 0; i < n; ++i) {
        const auto at = [&](double by) { return f(VectorXd(by * step * VectorXd::Unit(n, i))); };
        columns.push_back((8 * (at(1) - at(-1)) - (at(2) - at(-2))) / (12 * step));
    }
    return columns;
}

struct EnergyMinimum {
    std::vector<BodyPose> poses;
    VectorXd frequencies;  ///< [Hz], ascending
    double turn = 0;       ///< the largest from the start [rad]
};

EnergyMinimum minimum_of(const RandomRest& machine) {
    const auto n = static_cast<Eigen::Index>(6 * machine.parts.size());
    EnergyMinimum found{machine.start(), {}, 0};
    VectorXd q = VectorXd::Zero(machine.closure(found.poses).size());
    MatrixXd H(n, n), C(q.size(), n);
    constexpr int kShares = 3, kIterations = 6;
    for (int i = 1; i <= kShares * kIterations; ++i) {
        const double share = std::min(1.0, std::ceil(static_cast<double>(i) / kIterations) / kShares);
        const auto lagrangian = [&](const VectorXd& by) {
            const std::vector<BodyPose> poses = shifted(found.poses, by);
            return machine.energy(poses, share) + q.dot(machine.closure(poses));
        };
        const auto gradient = [&](const VectorXd& by, double step) {
            const std::vector<double> g =
                derivative_of([&](const VectorXd& more) { return lagrangian(by + more); }, n, step);
            return VectorXd(Eigen::Map<const VectorXd>(g.data(), n));
        };
        const auto columns = derivative_of([&](const VectorXd& by) { return gradient(by, 4e-3); }, n, 4e-3);
        const auto closing =
            derivative_of([&](const VectorXd& by) { return machine.closure(shifted(found.poses, by)); }, n, 1e-3);
        for (Eigen::Index c = 0; c < n; ++c) {
            H.col(c) = columns[static_cast<size_t>(c)];
            C.col(c) = closing[static_cast<size_t>(c)];
        }
        MatrixXd all = MatrixXd::Zero(n + q.size(), n + q.size());
        all << 0.5 * (H + H.transpose()), C.transpose(), C, MatrixXd::Zero(q.size(), q.size());
        VectorXd lacking(n + q.size());
        lacking << -gradient(VectorXd::Zero(n), 1e-3), -machine.closure(found.poses);
        const VectorXd by = test::solve(all, lacking);
        found.poses = shifted(found.poses, by.head(n));
        q += by.tail(q.size());
    }
    MatrixXd M = MatrixXd::Zero(n, n);
    for (size_t b = 0; b < machine.parts.size(); ++b) {
        const auto at = 6 * static_cast<Eigen::Index>(b);
        const Matrix3d& R = found.poses[b].rotation;
        M.block<3, 3>(at, at) = machine.parts[b].mass * Matrix3d::Identity();
        M.block<3, 3>(at + 3, at + 3) = R * machine.parts[b].inertia.asDiagonal() * R.transpose();
        found.turn = std::max(found.turn, vector_of_turn(R * machine.parts[b].start.rotation.transpose()).norm());
    }
    // The motions that the joints leave
    const Eigen::FullPivLU<MatrixXd> closed(C);
    const MatrixXd Z = C.rows() > 0 ? MatrixXd(closed.kernel()) : MatrixXd(MatrixXd::Identity(n, n));
    const MatrixXd K = Z.transpose() * (0.5 * (H + H.transpose())) * Z, reduced = Z.transpose() * M * Z;
    found.frequencies = test::solve_pencil(K, reduced).values.cwiseAbs().cwiseSqrt() / (2 * M_PI);
    return found;
}

// Oracle: the energy of the machine, written apart from the program: its minimum under the closure of joints by Newton's
// method, its second derivatives there by differences, and their eigenproblem. The differences err by 1e-9 or so.
TEST(RandomRest, IsTheMinimumOfTheEnergyAndVibratesAsItsCurvature) {
    double most = 0;
    for (unsigned seed = 1; seed <= 12; ++seed) {
        const RandomRest machine(seed);
        const EnergyMinimum exact = minimum_of(machine);
        most = std::max(most, exact.turn);
        AtRest rest = rest_of(machine.text("", 0));
        for (size_t b = 0; b < machine.parts.size(); ++b) {
            const Vector3d origin = exact.poses[b].position - exact.poses[b].rotation * machine.parts[b].centre;
            const char* axes[] = {"x", "y", "z"};
            for (int d = 0; d < 3; ++d)
                EXPECT_NEAR(rest.row[fmt::format("b{}.position.{}", b, axes[d])], origin(d), 1e-8) << "seed " << seed;
        }
        const std::vector<double> found = frequencies_of(modes_of(machine.text("", 0), {"--count", "30"}));
        ASSERT_EQ(static_cast<Eigen::Index>(found.size()), exact.frequencies.size()) << "seed " << seed;
        for (size_t k = 0; k < found.size(); ++k) {
            const double f = exact.frequencies(static_cast<Eigen::Index>(k));
            EXPECT_NEAR(found[k], f, 1e-6 * f) << "seed " << seed << " mode " << k;
        }
    }
    EXPECT_GT(most, 0.1) << "[rad]: otherwise nothing turns";
}

// ---- The same machines in time ------------------------------------------------------------------------------------------

/// Two beams from a body to the ground, with a mass and a force where they meet.
std::string with_beams(unsigned seed, double damping) {
    RandomRest numbers(seed + 1000);
    const RandomRest machine(seed);
    const Vector3d from = machine.parts[0].start.position + machine.parts[0].start.rotation * machine.parts[0].point;
    const Vector3d middle = from + Vector3d(-0.4, 0.3, 0.2) + numbers.vector(0.1), wall = middle + Vector3d(-0.3, 0.5, -0.1);
    std::string text = fmt::format(R"([nodes]
middle = {{ position = {}, rotation = {{ axis = [1, 2, 3], angle = "25 deg" }} }}
wall = {{ position = {}, fixed = ["x", "y", "z", "rx", "ry", "rz"] }}
[[element]]
name = "lump"
type = "rigid_body"
at = "middle"
mass = 0.8
center_of_mass = [0.02, -0.03, 0.01]
inertia = {{ xx = 0.004, yy = 0.003, zz = 0.005 }}
[[load]]
on = "middle"
direction = {}
force = 15
)",
                                   numbers_of(middle), numbers_of(wall), numbers_of(numbers.vector(1)));
    for (const auto& [name, from_end, to_end, segments] :
         {std::tuple("inner", "b0.load", "middle", 3), {"outer", "middle", "wall", 4}})
        text += fmt::format(
            "[[element]]\nname = \"{}\"\ntype = \"beam\"\nfrom = \"{}\"\nto = \"{}\"\nsegments = {}\n"
            "section = {{ tube = [\"24 mm\", \"18 mm\"] }}\n"
            "material = {{ E = 3e9, poisson = 0.3, density = 1200, stiffness_damping = {} }}\n",
            name, from_end, to_end, segments, damping);
    return text;
}

// Oracle: a damped run that comes to rest. Its dampers hold up what remains of its motion: exp(−20) of the start or less.
TEST(RandomRest, IsWhereADampedRunEnds) {
    for (unsigned seed = 1; seed <= 6; ++seed) {
        const RandomRest machine(seed);
        AtRest rest = rest_of(machine.text("duration = 1", 0.04, with_beams(seed, 0.02)));
        const std::map<std::string, double> run =
            final_row(machine.text("duration = 60\nstep = \"4 ms\"\nspectral_radius = 0.6", 0.04, with_beams(seed, 0.02)));
        size_t compared = 0;
        for (const auto& [name, value] : run) {
            if (name.find("position") == std::string::npos && name.find("middle.rotation") == std::string::npos) continue;
            EXPECT_NEAR(rest.row[name], value, 1e-6) << "seed " << seed << " " << name;
            ++compared;
        }
        EXPECT_GT(compared, 10u);
    }
}

// ---- Ring-down ----------------------------------------------------------------------------------------------------------

/// What a sum of vibrations at given ω [rad/s] leaves of histories, one per column, as share of them.
double remainder_of(const VectorXd& t, const MatrixXd& histories, const std::vector<double>& omegas) {
    const auto modes = static_cast<Eigen::Index>(omegas.size());
    MatrixXd A(t.size(), 2 * modes);
    for (Eigen::Index m = 0; m < modes; ++m) {
        const Eigen::ArrayXd phase = omegas[static_cast<size_t>(m)] * t.array();
        A.col(2 * m) = phase.cos();
        A.col(2 * m + 1) = phase.sin();
    }
    const MatrixXd fit = A.colPivHouseholderQr().solve(histories);
    return (histories - A * fit).norm() / histories.norm();
}

// Oracle: a small run about the equilibrium is a sum of vibrations at the frequencies of `modes`, with tan(ω_h h/2) = ωh/2.
// What is left of it grows with their error: it is ten times as much where all are 1e-5 too high, so that they are right to
// 1e-6.
TEST(RandomRest, VibratesAsASmallRunRings) {
    constexpr double kStep = 5e-4;
    for (unsigned seed = 1; seed <= 6; ++seed) {
        const RandomRest machine(seed);
        const std::string kick =
            "[output]\nchannels = [\"b*.velocity\", \"b*.angular_velocity\", \"middle.velocity\"]\n"
            "[[load]]\non = \"b0.load\"\ndirection = [1, 0.7, -0.4]\n"
            "force = { type = \"haversine\", peak = 0.02, start = 0, width = 0.02 }\n";
        const std::string text = machine.text(fmt::format("duration = 3\nstep = {}\nstart = \"equilibrium\"", kStep), 0,
                                              with_beams(seed, 0) + kick);
        std::vector<double> omegas;
        for (const double f : frequencies_of(modes_of(text, {"--beams", "lumped", "--below", "400 Hz"})))
            omegas.push_back(2 / kStep * std::atan(M_PI * f * kStep));
        const TemporaryFolder folder;
        write_text(folder / "model.toml", text);
        const Ended run = run_dttmm(folder.path(), {"run", "model.toml", "-o", "run", "-q"});
        ASSERT_EQ(run.code, 0) << run.err;
        const auto rows = read_history(folder / "run/history.csv");
        constexpr size_t kFirst = 41;  // the kick has ended
        const auto count = static_cast<Eigen::Index>(rows.size() - kFirst);
        MatrixXd all(count, static_cast<Eigen::Index>(rows[0].size()));
        for (Eigen::Index r = 0; r < count; ++r)
            all.row(r) = Eigen::Map<const Eigen::RowVectorXd>(rows[kFirst + static_cast<size_t>(r)].data(), all.cols());
        const VectorXd t = all.col(0).array() - all(0, 0);
        const double remainder = remainder_of(t, all.rightCols(all.cols() - 1), omegas);
        for (double& omega : omegas) omega *= 1 + 1e-5;
        const double shifted = remainder_of(t, all.rightCols(all.cols() - 1), omegas);
        EXPECT_LT(remainder, 0.1 * shifted) << "seed " << seed << " " << remainder << " " << shifted;
    }
}

}  // namespace
}  // namespace dttmm::host
