// SPDX-License-Identifier: BSD-3-Clause
//
// `dttmm response` against dense equations of random machines, by reciprocity, and against runs in time.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <fstream>
#include <random>

#include "cli/modes_run.h"
#include "cli/steady_vibration.h"
#include "support/linear_algebra.h"

namespace dttmm::host {
namespace {

/// A body, and nodes with rigid masses, all turned, on springs with dampers and loss factors in axes of their own: as the
/// text of a model and as dense matrices about the places of its frames.
class DenseMachine {
public:
    explicit DenseMachine(unsigned seed) : random_(seed) {
        constexpr int kNodes = 3;
        text_ = "format = \"dttmm/1\"\n";
        add_body();
        text_ += "[nodes]\n";
        for (int n = 0; n < kNodes; ++n) add_node(n);
        for (int n = 0; n < kNodes; ++n) add_mass(n);
        const auto size = static_cast<Eigen::Index>(6 * frames_.size());
        M_ = Eigen::MatrixXd::Zero(size, size);
        K_ = C_ = L_ = M_;
        for (size_t f = 0; f < frames_.size(); ++f)
            M_.block<6, 6>(static_cast<Eigen::Index>(6 * f), static_cast<Eigen::Index>(6 * f)) = frames_[f].mass;
        // A tree that hangs on the ground, then a loop and one more to the ground
        spring(-1, 0);
        for (int n = 1; n <= kNodes; ++n) spring(n - 1, n);
        spring(kNodes, 0);
        spring(-1, 2);
    }

    const std::string& text() const { return text_; }
    const std::vector<double> natural_frequencies() const {
        std::vector<double> found;
        for (const double lambda : test::solve_pencil(K_, M_).values) found.push_back(std::sqrt(lambda) / (2 * M_PI));
        return found;
    }

    struct Motion {
        Eigen::VectorXcd u;
        /// At a point of a frame.
        Eigen::Matrix<Complex, 6, 1> at(int frame, const Eigen::Vector3d& arm) const {
            Eigen::Matrix<Complex, 6, 1> own = u.segment<6>(6 * frame);
            own.head<3>() += by(arm).topRightCorner<3, 3>().cast<Complex>() * own.tail<3>();
            return own;
        }
    };
    /// Under a unit force or moment at the marker of the body (frame 0) or at a node, by elimination of the real equations
    /// of twice the size.
    Motion respond(double hertz, int frame, int direction) const {
        const double w = 2 * M_PI * hertz;
        const Eigen::Index n = K_.rows();
        Eigen::MatrixXd A(2 * n, 2 * n);
        A << K_ - w * w * M_, -(L_ + w * C_), L_ + w * C_, K_ - w * w * M_;
        Eigen::VectorXd load = Eigen::VectorXd::Zero(2 * n);
        load.segment<6>(6 * frame) = by(arm_of(frame)).transpose() * Eigen::Matrix<double, 6, 1>::Unit(direction);
        const Eigen::VectorXd x = test::solve(A, load);
        return {x.head(n).cast<Complex>() + Complex(0, 1) * x.tail(n).cast<Complex>()};
    }
    /// Of the marker of the body, or 0 of a node.
    Eigen::Vector3d arm_of(int frame) const { return frame == 0 ? marker_ : Eigen::Vector3d(0, 0, 0); }
    size_t spring_count() const { return springs_.size(); }
    /// Force and moment of a spring in its axes, and its deflection and rotation.
    std::pair<Eigen::Matrix<Complex, 6, 1>, Eigen::Matrix<Complex, 6, 1>> carried(size_t s, const Motion& motion,
                                                                                  double hertz) const {
        const Spring& spring = springs_[s];
        const Eigen::Matrix<Complex, 6, 1> d = spring.B.cast<Complex>() * motion.u;
        const Eigen::Matrix<Complex, 6, 1> k =
            spring.k.cast<Complex>() * Complex(1, spring.loss) + Complex(0, 2 * M_PI * hertz) * spring.c.cast<Complex>();
        return {k.cwiseProduct(d), d};
    }
    static std::string place(int frame) { return frame == 0 ? "block.top" : fmt::format("n{}", frame); }

private:
    using Vector6d = Eigen::Matrix<double, 6, 1>;
    using Matrix6d = Eigen::Matrix<double, 6, 6>;
    struct DenseFrame {
        Eigen::Vector3d place;  ///< that its motion is of
        Matrix6d mass = Matrix6d::Zero();
    };
    struct Spring {
        Eigen::Matrix<double, 6, Eigen::Dynamic> B;  ///< deflection in its axes by all motions
        Vector6d k, c;
        double loss;
    };

    double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
    Eigen::Vector3d vector(double size) { return {number(-size, size), number(-size, size), number(-size, size)}; }
    static std::string list(const Eigen::VectorXd& v) {
        std::string all;
        for (const double x : v) all += fmt::format("{}{:.17g}", all.empty() ? "" : ", ", x);
        return "[" + all + "]";
    }
    /// Random axes, and how the file has them.
    Eigen::Matrix3d turned(std::string& text) {
        const Eigen::Vector3d axis = vector(1);
        const double angle = number(0.3, 2.5);
        text = fmt::format("{{ axis = {}, angle = {:.17g} }}", list(axis), angle);
        return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
    }
    /// Displacement at an arm from where a motion is of.
    static Matrix6d by(const Eigen::Vector3d& arm) {
        Matrix6d B = Matrix6d::Identity();
        B.topRightCorner<3, 3>() << 0, arm.z(), -arm.y(), -arm.z(), 0, arm.x(), arm.y(), -arm.x(), 0;
        return B;
    }
    Matrix6d mass_at(double mass, const Eigen::Vector3d& inertia, const Eigen::Matrix3d& axes, const Eigen::Vector3d& arm) {
        Matrix6d M = Matrix6d::Zero();
        M.diagonal().head<3>().setConstant(mass);
        M.bottomRightCorner<3, 3>() = axes * inertia.asDiagonal() * axes.transpose();
        return by(arm).transpose() * M * by(arm);
    }
    Eigen::Vector3d inertia() { return {number(0.02, 0.03), number(0.03, 0.04), number(0.025, 0.035)}; }

    void add_body() {
        std::string rotation;
        const Eigen::Matrix3d axes = turned(rotation);
        const Eigen::Vector3d position = vector(0.4), centre = vector(0.05), marker = vector(0.2), J = inertia();
        const double mass = number(2, 4);
        text_ += fmt::format(
            "[[body]]\nname = \"block\"\nmass = {:.17g}\ninertia = {}\ncenter_of_mass = {}\nposition = {}\nrotation = "
            "{}\nmarkers.top = {}\n",
            mass, list(J), list(centre), list(position), rotation, list(marker));
        frames_.push_back({position + axes * centre, mass_at(mass, J, axes, Eigen::Vector3d(0, 0, 0))});
        marker_ = axes * (marker - centre);
    }
    void add_node(int n) {
        std::string rotation;
        node_axes_.push_back(turned(rotation));
        frames_.push_back({vector(0.5), Matrix6d::Zero()});
        text_ += fmt::format("n{} = {{ position = {}, rotation = {} }}\n", n + 1, list(frames_.back().place), rotation);
    }
    void add_mass(int n) {
        const double mass = number(0.5, 1.5);
        const Eigen::Vector3d centre = vector(0.03), J = 0.2 * inertia();
        const Eigen::Matrix3d& axes = node_axes_[static_cast<size_t>(n)];
        text_ += fmt::format(
            "[[element]]\nname = \"m{0}\"\ntype = \"rigid_body\"\nat = \"n{0}\"\nmass = {1:.17g}\ncenter_of_mass = {2}\n"
            "inertia = {{ xx = {3:.17g}, yy = {4:.17g}, zz = {5:.17g} }}\n",
            n + 1, mass, list(centre), J.x(), J.y(), J.z());
        frames_[static_cast<size_t>(n + 1)].mass = mass_at(mass, J, axes, axes * centre);
    }
    /// −1: the ground, which has an end where the other one is. Its force acts at its `to` end. From a node it has the axes
    /// of that.
    void spring(int from, int to) {
        std::string rotation;
        Eigen::Matrix3d R = turned(rotation);
        if (from > 0) R = node_axes_[static_cast<size_t>(from - 1)];
        Spring own{Eigen::Matrix<double, 6, Eigen::Dynamic>::Zero(6, K_.cols()), {}, {}, number(0.01, 0.15)};
        for (int d = 0; d < 3; ++d) {
            own.k(d) = number(2e3, 2e4);
            own.k(3 + d) = number(20, 200);
            own.c(d) = number(0, 10);
            own.c(3 + d) = number(0, 0.02);
        }
        text_ += fmt::format(
            "[[element]]\nname = \"s{}\"\ntype = \"spring_damper\"\nfrom = \"{}\"\nto = \"{}\"\n{}stiffness = {}\n"
            "rotational_stiffness = {}\ndamping = {}\nrotational_damping = {}\nloss_factor = {:.17g}\n",
            springs_.size(), from < 0 ? "ground" : place(from), place(to),
            from > 0 ? "" : fmt::format("axes = {}\n", rotation), list(own.k.head<3>()), list(own.k.tail<3>()),
            list(own.c.head<3>()), list(own.c.tail<3>()), own.loss);
        Matrix6d axes = Matrix6d::Zero();
        axes.topLeftCorner<3, 3>() = axes.bottomRightCorner<3, 3>() = R.transpose();
        const Eigen::Vector3d point = frames_[static_cast<size_t>(to)].place + arm_of(to);
        own.B.middleCols<6>(6 * to) = axes * by(point - frames_[static_cast<size_t>(to)].place);
        if (from >= 0) own.B.middleCols<6>(6 * from) = -axes * by(point - frames_[static_cast<size_t>(from)].place);
        K_ += own.B.transpose() * own.k.asDiagonal() * own.B;
        C_ += own.B.transpose() * own.c.asDiagonal() * own.B;
        L_ += own.loss * own.B.transpose() * own.k.asDiagonal() * own.B;
        springs_.push_back(std::move(own));
    }

    std::mt19937 random_;
    std::string text_;
    std::vector<DenseFrame> frames_;
    std::vector<Eigen::Matrix3d> node_axes_;
    Eigen::Vector3d marker_;
    std::vector<Spring> springs_;
    Eigen::MatrixXd K_, C_, L_, M_;  ///< L: loss factors times stiffness
};

// Oracle: the dense equations (K (1 + iη) + iωC − ω²M) u = f of the same machine, assembled and solved here: motions,
// forces, moments and deflections of all elements to 1e-8 between the natural frequencies and to 1e-6 at them.
TEST_F(SteadyVibration, RandomMachinesAgainstDenseEquations) {
    for (unsigned seed = 1; seed <= 4; ++seed) {
        const DenseMachine machine(seed);
        const std::vector<double> natural = machine.natural_frequencies();
        ASSERT_EQ(natural.size(), 24u);
        for (size_t k : {0u, 1u, 5u, 11u, 23u})
            for (const bool at_peak : {true, false}) {
                const double f = at_peak ? natural[k] : k + 1 < natural.size() ? 0.5 * (natural[k] + natural[k + 1]) : 80;
                const double tolerance = at_peak ? 1e-6 : 1e-8;
                const int from = static_cast<int>((k + seed) % 4), direction = static_cast<int>((2 * k + seed) % 6);
                constexpr const char* kDirections[] = {"x", "y", "z", "rx", "ry", "rz"};
                const Table table = response(
                    machine.text(), {"--in", DenseMachine::place(from) + "." + kDirections[direction], "--from",
                                     fmt::format("{:.17g} Hz", f), "--to", "500 Hz", "--points", "2", "--out", "*", "-q"});
                ASSERT_EQ(table.rows.size(), 2u);
                const auto motion = machine.respond(f, from, direction);
                const auto compare = [&](const std::string& name, const Eigen::Vector3cd& expected) {
                    for (Eigen::Index a = 0; a < 3; ++a)
                        EXPECT_LT(std::abs(table.amplitude(0, name + "." + "xyz"[a]) - expected(a)),
                                  tolerance * expected.norm())
                            << seed << " " << f << " " << name;
                };
                const Complex iw(0, 2 * M_PI * f);
                for (int frame = 0; frame < 4; ++frame) {
                    const Eigen::Matrix<Complex, 6, 1> u = motion.at(frame, machine.arm_of(frame));
                    compare(DenseMachine::place(frame) + ".position", u.head<3>());
                    compare(DenseMachine::place(frame) + ".acceleration", iw * iw * u.head<3>());
                    compare(frame == 0 ? "block.rotation" : DenseMachine::place(frame) + ".rotation", u.tail<3>());
                }
                for (size_t s = 0; s < machine.spring_count(); ++s) {
                    const auto [force, deflection] = machine.carried(s, motion, f);
                    compare(fmt::format("s{}.force", s), force.head<3>());
                    compare(fmt::format("s{}.moment", s), force.tail<3>());
                    compare(fmt::format("s{}.deflection", s), deflection.head<3>());
                    compare(fmt::format("s{}.rotation", s), deflection.tail<3>());
                }
            }
    }
}

// Oracle: Maxwell and Betti. What a unit load at one place does at another, this does to the first one; with beams of exact
// waves, material damping and loss factors between the turned parts too.
TEST_F(SteadyVibration, ResponsesAreReciprocal) {
    for (unsigned seed = 11; seed <= 13; ++seed) {
        const std::string text = DenseMachine(seed).text() + R"([[element]]
name = "strut"
type = "beam"
from = "n1"
to = "n3"
section = { EA = 4e5, EIy = 30, EIz = 50, GJ = 20, GAy = 1e5, GAz = 1.4e5, mass = 0.7, inertia = 2e-3, mass_offset = [0.01, -0.02] }
material = { stiffness_damping = "40 us" }
[[element]]
name = "bar"
type = "beam"
from = "n2"
to = "block.top"
section = { EA = 3e5, EIy = 40, EIz = 20, GJ = 30, mass = 0.4, inertia = 1e-3 }
theory = "euler-bernoulli"
material = { loss_factor = 0.07 }
)";
        struct Port {
            const char *in, *out;
        };
        const Port ports[] = {{"block.top.x", "block.top.position.x"},
                              {"block.rz", "block.rotation.z"},
                              {"n1.y", "n1.position.y"},
                              {"n2.rx", "n2.rotation.x"},
                              {"n3.z", "n3.position.z"}};
        std::vector<std::string> words = {"--from", "3 Hz", "--to", "61.7 Hz", "--points", "6", "-q"};
        for (const Port& port : ports) words.insert(words.end(), {"--in", port.in, "--out", port.out});
        const Table table = response(text, words);
        ASSERT_EQ(table.rows.size(), 6u);
        for (size_t row = 0; row < 6; ++row)
            for (const Port& a : ports)
                for (const Port& b : ports) {
                    const Complex there = table.amplitude(row, fmt::format("{}/{}", a.out, b.in).c_str()),
                                  back = table.amplitude(row, fmt::format("{}/{}", b.out, a.in).c_str());
                    EXPECT_LT(std::abs(there - back), 1e-9 * std::abs(there)) << seed << " " << a.in << " " << b.in;
                    EXPECT_GT(std::abs(there), 0);
                }
    }
}

// ---- Against runs --------------------------------------------------------------------------------------------------------

/// The frequency whose response a run at the step h has at f: of Newmark's rule, (2/h) tan(ωh/2).
double stepped(double f, double h) { return std::tan(kHalfTurn * f * h) / (kHalfTurn * h); }

// Oracle: what the scheme does to a frequency. A run at ω is the response at (2/h) tan(ωh/2), exactly but for large
// motions. With r = ω over a natural frequency it differs from that at ω by (ωh)²/6 r²/|1 − r²| in forces and by
// (ωh)²/6/|1 − r²| in accelerations: by less than (ωh)²/6 in forces below 0.7 of the natural frequencies, in accelerations
// above 1.42 of them. Forces in turned axes, a force that turns with its body and a moment act together on inclined mounts.
TEST_F(SteadyVibration, ARunIsTheResponseOfItsStep) {
    const auto loads = [](const std::string& frequency) {
        std::string text;
        for (const auto& [where, size] :
             {std::pair("on = \"block.top\"\ndirection = [0.3, -0.2, 1]", "amplitude = 0.3, phase = \"35 deg\""),
              {"on = \"block.three\"\naxes = \"body\"\ndirection = [0, 0.6, 0.8]", "amplitude = 0.2, phase = \"-70 deg\""},
              {"on = \"block.top\"\ndirection = [1, 0.5, 0]", "amplitude = \"0.02 N*m\""}})
            text += fmt::format("[[load]]\n{}\nharmonic = {{ {}{} }}\n", where, size, frequency);
        return text;
    };
    const std::vector<std::string> forces = {"mount1.force", "mount2.force", "mount4.force", "mount3.deflection"},
                                   accelerations = {"block.acceleration", "block.top.acceleration"};
    struct Drive {
        double hertz, step;
        const std::vector<std::string>& within;  ///< channels within (ωh)²/6
    };
    for (const auto& [hertz, step, within] : {Drive{2.5, 0.01, forces}, Drive{2.5, 0.005, forces},
                                              Drive{40, 0.001, accelerations}, Drive{40, 0.0005, accelerations}}) {
        const Table run = history(turned_block(loads(fmt::format(", frequency = \"{} Hz\"", hertz)), 4, step));
        std::vector<std::string> words = {"-q", "--points", "2", "--to", "100 Hz"};
        for (const auto* channels : {&forces, &accelerations})
            for (const std::string& channel : *channels) words.insert(words.end(), {"--out", channel});
        auto at_step = words;
        words.insert(words.end(), {"--from", fmt::format("{} Hz", hertz)});
        at_step.insert(at_step.end(), {"--from", fmt::format("{:.17g} Hz", stepped(hertz, step))});
        const Table exact = response(turned_block(loads(""), 4, step), words),
                    discrete = response(turned_block(loads(""), 4, step), at_step);
        const double w = 2 * kHalfTurn * hertz, bound = w * w * step * step / 6;
        for (const auto* channels : {&forces, &accelerations})
            for (const std::string& channel : *channels) {
                double difference = 0,
                       size = 0;  // of the vector: one component may be what two resonances leave of each other
                for (const char* axis : {".x", ".y", ".z"}) {
                    const std::string name = channel + axis;
                    const Complex got = amplitude_of(run, name, w, 4 - 2.0), wanted = exact.amplitude(0, name);
                    EXPECT_LT(std::abs(got - discrete.amplitude(0, name)), 0.03 * bound * std::abs(wanted))
                        << name << " " << step;
                    difference = std::hypot(difference, std::abs(got - wanted));
                    size = std::hypot(size, std::abs(wanted));
                }
                if (channels == &within) {
                    EXPECT_LT(difference, bound * size) << channel << " " << step;
                }
            }
    }
}

// Oracle: the same of an unbalance, whose force turns about an inclined axis.
TEST_F(SteadyVibration, ARunUnderAnUnbalanceIsTheResponseOfItsStep) {
    std::string text = turned_block(
        "[[load]]\non = \"block.two\"\ndirection = [0.1, 1, 0.3]\nunbalance = \"3 g*m\"\nzero = [1, 0, 0]\n", 4, 0.01);
    text.replace(text.find("420 rpm"), 7, "150 rpm");
    const Table exact = response(text, {"-q", "--out", "mount*.force"});
    ASSERT_EQ(exact.rows.size(), 1u);
    const double w = 5 * kHalfTurn;
    for (const double step : {0.01, 0.005}) {
        std::string own = text;
        own.replace(own.find("step = \"0.01 s\""), 15, fmt::format("step = {}", step));
        const Table run = history(own);
        for (int mount = 1; mount <= 4; ++mount)
            for (const char* axis : {".x", ".y", ".z"}) {
                const std::string name = fmt::format("mount{}.force{}", mount, axis);
                const Complex got = amplitude_of(run, name, w, 4 - 2.0), expected = exact.amplitude(0, name);
                EXPECT_LT(std::abs(got - expected), w * w * step * step / 6 * std::abs(expected)) << name << " " << step;
            }
    }
}

// Oracle: the same of supports that move, in displacement and rotation.
TEST_F(SteadyVibration, ARunOnMovingSupportsIsTheResponseOfItsStep) {
    const auto text = [](const std::string& frequency, double step) {
        const auto moves = [&](double amplitude, double phase) {
            return fmt::format("{{ type = \"harmonic\", amplitude = {}, phase = \"{} deg\"{} }}", amplitude, phase,
                               frequency);
        };
        std::string all = on_feet(fmt::format(", motion = {{ x = {}, ry = {} }}", moves(2e-5, 20), moves(1e-4, 50)),
                                  fmt::format(", motion = {{ z = {} }}", moves(3e-5, -70)),
                                  fmt::format(", motion = {{ y = {} }}", moves(-2e-5, 10)));
        return all.replace(all.find("\"0.4 ms\""), 8, fmt::format("{:.17g}", step));
    };
    constexpr double kHertz = 2.5;
    const std::vector<std::string> channels = {"one.force", "two.force", "mast.force"};
    for (const double step : {0.01, 0.005}) {
        const Table run = history(text(", frequency = \"2.5 Hz\"", step));
        std::vector<std::string> words = {"-q", "--points", "2", "--to", "10 Hz", "--beams", "lumped", "--from", "2.5 Hz"};
        for (const std::string& channel : channels) words.insert(words.end(), {"--out", channel});
        const Table exact = response(text("", step), words);
        const double w = 2 * kHalfTurn * kHertz, bound = w * w * step * step / 6;
        for (const std::string& channel : channels) {
            double largest = 0;
            for (const char* axis : {".x", ".y", ".z"})
                largest = std::max(largest, std::abs(exact.amplitude(0, channel + axis)));
            for (const char* axis : {".x", ".y", ".z"}) {
                const Complex got = amplitude_of(run, channel + axis, w, 4 - 2.0);
                EXPECT_LT(std::abs(got - exact.amplitude(0, channel + axis)), bound * largest) << channel << axis << step;
            }
        }
    }
}

// Oracle: a long run under generated white noise of the same density, 2σ² h up to half the rate of steps. Its RMS scatters
// by 1.5 % for 120 s of this damping.
TEST_F(SteadyVibration, ALongRunUnderNoiseHasTheRms) {
    constexpr double kStep = 1e-3, kDuration = 120, kDensity = 0.5;
    std::mt19937 random(5);
    std::normal_distribution<double> noise(0, std::sqrt(kDensity / (2 * kStep)));
    std::string table = "s,N\n";
    for (int i = 0; i <= std::lround(kDuration / kStep); ++i)
        table += fmt::format("{:.6f},{:.9g}\n", i * kStep, noise(random));
    write_text(folder_ / "noise.csv", table);
    const std::string load = "[[load]]\non = \"block.top\"\ndirection = [0.3, -0.2, 1]\n";
    const std::vector<std::string> channels = {"mount1.force.x", "mount2.force.z", "mount4.deflection.y", "mount3.force.z"};
    const Table run = history(turned_block(load + "force = { type = \"table\", file = \"noise.csv\" }\n", kDuration, kStep) +
                              "[output]\nstep = \"5 ms\"\nchannels = [\"mount*\"]\n");
    std::vector<std::string> words = {"-q"};
    for (const std::string& channel : channels) words.insert(words.end(), {"--out", channel});
    const Ended ended =
        ask(turned_block(load + fmt::format("psd = {{ frequencies = [0, 500], values = [{0}, {0}] }}\n", kDensity),
                         kDuration, kStep),
            words);
    ASSERT_EQ(ended.code, 0) << ended.err;
    const std::string rms = read_text(folder_ / "out1/rms.csv");
    for (const std::string& channel : channels) {
        double square = 0;
        size_t count = 0;
        const size_t column = run.column(channel), time = run.column("time");
        for (const auto& row : run.rows)
            if (row[time] > 1) square += row[column] * row[column], ++count;
        const size_t at = rms.find(channel + ",");
        ASSERT_NE(at, rms.npos) << rms;
        const double expected = std::stod(rms.substr(rms.find(',', rms.find(',', at) + 1) + 1));
        EXPECT_NEAR(std::sqrt(square / static_cast<double>(count)), expected, 0.05 * expected) << channel;
    }
}

}  // namespace
}  // namespace dttmm::host
