// SPDX-License-Identifier: BSD-3-Clause
//
// The gun of examples/gun: bodies on a slider of ODE, springs, and a beam of the plugin in one machine, against the same
// machine linearised.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>

#include "model/read_model.h"
#include "step/simulation.h"
#include "support/exact_pulses.h"
#include "support/lumped_tube.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using Eigen::Matrix2d;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// What is compared: motion of the muzzle from its start, in x and z [m] and about y [rad]; force of the mount in x and z
/// [N] and its moment about y [N m]; force of the recoil spring [N].
using Row = Eigen::Matrix<double, 7, 1>;
enum Quantity { muzzle_x, muzzle_z, muzzle_angle, mount_x, mount_z, mount_moment, recoil };
const char* const kChannels[] = {"muzzle.position.x", "muzzle.position.z", "muzzle.rotation.y",    "mount.force.x",
                                 "mount.force.z",     "mount.moment.y",    "recoil_spring.force.x"};
using GunHistory = std::vector<Row>;  ///< a row per step

Model gun(const Plugins& plugins) {
    return read_model(std::filesystem::path(test::paths::source_dir()) / "examples/gun/model.toml", plugins.catalogue());
}

GunHistory run(Model model, const Plugins& plugins) {
    model.output.every = 1;
    Simulation simulation(model, plugins);
    std::map<std::string, size_t> column;
    for (size_t c = 0; c < simulation.channels().size(); ++c) column[simulation.channels()[c].name()] = c;
    GunHistory history;
    simulation.record_to([&](std::span<const double> values) {
        Row row;
        for (Eigen::Index i = 0; i < row.size(); ++i) row(i) = values[column.at(kChannels[i])];
        row(muzzle_x) -= 1.45;
        history.push_back(row);
        EXPECT_EQ(values[column.at("muzzle.position.y")], 0) << "nothing leaves the plane";
    });
    while (simulation.index() < simulation.step_count()) simulation.step();
    return history;
}

/// The machine linearised about its start, all numbers from the model file written here again. It moves in the x-z plane.
/// Unknowns: receiver x, z, θ about y; travel s of the breechblock; x, z, θ of every lump. A point at (rx, rz) from the
/// origin of a frame moves by (x + θ rz, z − θ rx).
class LinearGun {
public:
    explicit LinearGun(int segments, double peak = 60e3, double gravity = 9.81)
        : n_(4 + 3 * segments), gravity_(gravity), machine_(n_), forces_(MatrixXd::Zero(4, n_)), rates_(forces_) {
        add_mass(frame(0), 80, 3.2);
        MatrixXd block = point(0, -0.05, 0.004);
        block(0, 3) = 1;  // and s along x
        add_mass(block, 6, 0.025);
        machine_.pulse = -peak * block.row(0);
        machine_.width = 3e-3;
        machine_.starts = {0.01, 0.11, 0.21};

        const MatrixXd mount = point(0, 0, -0.12);
        const Eigen::Vector3d k(2e6, 8e6, 6e5), c(4e3, 2e3, 300);
        machine_.add_spring(mount, k, c);
        MatrixXd travel = MatrixXd::Zero(1, n_);
        travel(0, 3) = 1;
        machine_.add_spring(travel, VectorXd::Constant(1, 60e3), VectorXd::Constant(1, 400));
        add_barrel(segments);

        muzzle_ = point(segments, 0.5 * 1.2 / segments, 0);
        forces_ << k.asDiagonal() * mount, 60e3 * travel;
        rates_ << c.asDiagonal() * mount, 400 * travel;
    }

    /// Rows at 0, step, 2 step, … of 0.5 s.
    GunHistory history(double step) const {
        test::ExactPulses motion(machine_, step);
        GunHistory rows;
        for (long n = 0; n <= std::lround(0.5 / step); ++n) {
            rows.emplace_back();
            rows.back() << muzzle_ * motion.q(), forces_ * motion.q() + rates_ * motion.rate();
            motion.advance();
        }
        return rows;
    }

private:
    /// Row of x, z, θ of frame i: 0 the receiver, 1… the lumps.
    MatrixXd frame(int i) const {
        MatrixXd G = MatrixXd::Zero(3, n_);
        G.middleCols<3>(i == 0 ? 0 : 1 + 3 * i).setIdentity();
        return G;
    }
    MatrixXd point(int i, double rx, double rz) const {
        MatrixXd G = frame(i);
        G.row(0) += rz * G.row(2);
        G.row(1) -= rx * G.row(2);
        return G;
    }
    void add_mass(const MatrixXd& G, double mass, double inertia) {
        machine_.add_mass(G, Eigen::Vector3d(mass, mass, inertia));
        machine_.constant -= mass * gravity_ * G.row(1);
    }

    void add_barrel(int segments) {
        const test::LumpedTube tube(0.05, 0.03, 1.2, 204e9, 0.26, 7800, segments);
        const double h = tube.half, damping = 2e-6;
        for (int i = 1; i <= segments; ++i) {
            add_mass(frame(i), tube.mass, tube.inertia);
            const bool first = i == 1;  // on the receiver's seat
            const MatrixXd opening = point(i, -h, 0) - (first ? point(0, 0.25, 0) : point(i - 1, h, 0));
            const Matrix2d bending = (first ? tube.left : Matrix2d(tube.right + tube.left)).inverse();
            const double axial = tube.EA / (first ? h : 2 * h);
            const MatrixXd K = opening.transpose().col(0) * axial * opening.row(0) +
                               opening.bottomRows(2).transpose() * bending * opening.bottomRows(2);
            machine_.K += K;
            machine_.C += damping * K;
        }
    }

    Eigen::Index n_;
    double gravity_;
    test::LinearMachine machine_;
    MatrixXd muzzle_, forces_, rates_;  ///< of the four forces, by q and by q'
};

/// Largest difference of each quantity; `stride`: rows of the second per row of the first.
Row difference(const GunHistory& one, const GunHistory& two, size_t stride = 1) {
    Row most = Row::Zero();
    EXPECT_EQ(two.size(), (one.size() - 1) * stride + 1);
    for (size_t n = 0; n < one.size(); ++n) most = most.cwiseMax((one[n] - two[n * stride]).cwiseAbs());
    return most;
}
/// What each is measured by: its largest value, displacements and forces of either direction that of both.
Row scale(const GunHistory& history) {
    Row most = difference(history, GunHistory(history.size(), Row::Zero()));
    most(muzzle_x) = most(muzzle_z) = std::max(most(muzzle_x), most(muzzle_z));
    most(mount_x) = most(mount_z) = std::max(most(mount_x), most(mount_z));
    return most;
}

/// The gun with gravity and shots at a share of their size.
Model weak_gun(const Plugins& plugins, double share) {
    struct Weak : Signal::Shape {
        Weak(const Signal& signal, double factor) : signal_(signal), factor_(factor) {}
        double value(double time) const override { return factor_ * signal_.value(time); }
        Signal signal_;
        double factor_;
    };
    Model model = gun(plugins);
    model.simulation.gravity *= share;
    model.loads[0].signal = Signal(std::make_shared<Weak>(model.loads[0].signal, share));
    return model;
}

// Oracle: the linearised machine, to 1 % of the largest displacement of the muzzle, 15.4 mm, of its largest angle, 14 mrad,
// and of the largest forces. But for the vertical force of the mount: the shots keep the direction of the world's x, so that
// 60 kN on a receiver inclined by 2.7 mrad have 160 N across the slide, which the linearised machine does not know.
TEST(Gun, FollowsTheLinearisedMachine) {
    const Plugins plugins;
    const GunHistory exact = LinearGun(24).history(1e-4);
    const Row error = difference(exact, run(gun(plugins), plugins)), all = scale(exact);
    EXPECT_NEAR(all(muzzle_z), 15.4e-3, 0.1e-3);
    for (Eigen::Index i = 0; i < error.size(); ++i)
        EXPECT_LT(error(i), (i == mount_z ? 0.02 : 0.01) * all(i)) << kChannels[i];
}

// Oracle: the same. What linearising leaves out are products of two motions: the breechblock 94 mm back in the receiver
// shifts weight and inertia, an inclined barrel is shorter by ½ ∫ θ² dx. So the error, in units of the largest motion, falls
// as the load does, down to the error of the step, 4/3 of what halving it changes.
TEST(Gun, DifferenceFromTheLinearisedMachineVanishesWithTheLoad) {
    const Plugins plugins;
    const auto relative_error = [&](double share) {
        const GunHistory exact = LinearGun(24, 60e3 * share, 9.81 * share).history(1e-4);
        return Row(difference(exact, run(weak_gun(plugins, share), plugins)).cwiseQuotient(scale(exact)));
    };
    Model half = weak_gun(plugins, 0.01);
    half.simulation.step *= 0.5;
    const GunHistory history = run(weak_gun(plugins, 0.01), plugins);
    const Row of_step = 4.0 / 3 * difference(history, run(half, plugins), 2).cwiseQuotient(scale(history));
    EXPECT_LT(of_step.maxCoeff(), 2e-3);
    const Row whole = relative_error(1);
    for (double share : {0.1, 0.01}) {
        const Row error = relative_error(share);
        for (Eigen::Index i = 0; i < error.size(); ++i)
            EXPECT_LT(error(i), share * whole(i) + of_step(i)) << kChannels[i] << ", " << share;
    }
}

// Half the step and twice the segments: the history stays, to 1 % of its largest value.
TEST(Gun, StepAndSegmentsAreFineEnough) {
    const Plugins plugins;
    const GunHistory history = run(gun(plugins), plugins);
    Model half = gun(plugins), fine = gun(plugins);
    half.simulation.step *= 0.5;
    const auto barrel = std::ranges::find(fine.elements, "barrel", &Element::name);
    const size_t segments = 1;  // its place among the values
    ASSERT_EQ(barrel->values[segments], 24);
    barrel->values.change()[segments] = 48;
    const Row by_step = difference(history, run(half, plugins), 2).cwiseQuotient(scale(history));
    const Row by_segments = difference(history, run(fine, plugins)).cwiseQuotient(scale(history));
    EXPECT_LT(by_step.maxCoeff(), 0.01);
    EXPECT_LT(by_segments.maxCoeff(), 0.01);
}

}  // namespace
}  // namespace dttmm::host
