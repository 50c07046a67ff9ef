// SPDX-License-Identifier: BSD-3-Clause
//
// The free tube of examples/free_tube, struck at one end: no body, two free nodes.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <complex>
#include <filesystem>
#include <map>
#include <numbers>

#include "model/read_model.h"
#include "step/simulation.h"
#include "support/exact_pulses.h"
#include "support/exact_timoshenko.h"
#include "support/linear_algebra.h"
#include "support/lumped_tube.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kTubeLength = 1.2, kWidth = 1e-3;
constexpr int kSegments = 40;

/// Values of channels by name, a row per step.
std::map<std::string, std::vector<double>> run(const Parameters::Overrides& parameters, double step, double duration) {
    const Plugins plugins;
    ModelOverrides overrides;
    overrides.parameters = parameters;
    Model model = read_model(std::filesystem::path(test::paths::source_dir()) / "examples/free_tube/model.toml",
                             plugins.catalogue(), overrides);
    model.simulation.step = step;
    model.simulation.duration = duration;
    Simulation simulation(model, plugins);
    std::map<std::string, std::vector<double>> columns;
    simulation.record_to([&](std::span<const double> row) {
        for (size_t c = 0; c < row.size(); ++c) columns[simulation.channels()[c].name()].push_back(row[c]);
    });
    while (simulation.index() < simulation.step_count()) simulation.step();
    return columns;
}

test::LumpedTube tube() { return {0.05, 0.03, kTubeLength, 204e9, 0.26, 7800, kSegments}; }

/// Bending of the lumps in one plane, z and θ about y of each; the blow, of 1 N, is on the left face of the first.
test::LinearMachine lumps(double damping = 0) {
    const test::LumpedTube parts = tube();
    const Eigen::Index n = 2 * kSegments;
    test::LinearMachine machine(n);
    const auto face = [&](Eigen::Index i, double x) {
        MatrixXd G = MatrixXd::Zero(2, n);
        G(0, 2 * i) = G(1, 2 * i + 1) = 1;
        G(0, 2 * i + 1) = -x;
        return G;
    };
    for (Eigen::Index i = 0; i < kSegments; ++i) {
        machine.add_mass(face(i, 0), Eigen::Vector2d(parts.mass, parts.inertia));
        if (i == 0) continue;
        const MatrixXd opening = face(i, -parts.half) - face(i - 1, parts.half);
        machine.K += opening.transpose() * (parts.right + parts.left).inverse() * opening;
    }
    machine.C = damping * machine.K;
    machine.pulse = face(0, -parts.half).row(0);
    machine.width = kWidth;
    machine.starts = {0};
    return machine;
}

// Oracle: the lumps' own linear motion, exact in time, under a blow of 1 N which leaves rotations at 1e-5. Second order: the
// sixth vibration is late by (ω h)²/12 of its phase. Damping of 2 us takes out what is too fast for that in 10 ms, from 6
// kHz on.
TEST(FreeTube, MovesAsItsLumpsDo) {
    double error[2];
    for (int halving = 0; halving < 2; ++halving) {
        const double step = 5e-6 / (1 << halving);
        const auto columns = run({{"blow", "1 N"}, {"damping", "2 us"}}, step, 0.01);
        test::ExactPulses motion(lumps(2e-6), step);
        double largest = 0;
        error[halving] = 0;
        for (double z : columns.at("right.velocity.z")) {
            const double exact = motion.rate()(2 * kSegments - 2) - tube().half * motion.rate()(2 * kSegments - 1);
            largest = std::max(largest, std::abs(exact));
            error[halving] = std::max(error[halving], std::abs(z - exact));
            motion.advance();
        }
        error[halving] /= largest;
    }
    EXPECT_LT(error[0], 0.0015);
    EXPECT_NEAR(error[0] / error[1], 4, 0.2);
}

// Oracle: momentum and angular momentum. The blow's impulse S = ½ F̂ w sets the centre moving at S/m and the tube turning at
// S L/2 / J, as if at the middle of the blow; damping takes the ringing out and no momentum. The turning is large here, 64
// mrad.
TEST(FreeTube, FliesAndTurnsAsTheBlowHasIt) {
    const auto columns = run({{"damping", "0.1 ms"}}, 2e-5, 0.3);
    const test::LumpedTube parts = tube();
    const double impulse = 0.5 * 1000 * kWidth, mass = kTubeLength * parts.mass_per_length,
                 J = mass * kTubeLength * kTubeLength / 12 + kTubeLength * parts.rotary;
    const double v = impulse / mass, w = impulse * kTubeLength / 2 / J, time = 0.3 - kWidth / 2;
    const double arm = kTubeLength / 2, angle = w * time;
    const auto last = [&](const char* name) { return columns.at(name).back(); };
    // The end moves a little while it is struck, which the lever of the blow feels: (1e-4 m/0.6 m)²
    EXPECT_NEAR(last("left.position.z"), v * time + arm * std::sin(angle), 1e-8);
    EXPECT_NEAR(last("right.position.z"), v * time - arm * std::sin(angle), 1e-8);
    EXPECT_NEAR(last("left.position.x"), arm - arm * std::cos(angle), 1e-8);
    EXPECT_NEAR(last("left.velocity.z"), v + arm * w * std::cos(angle), 1e-6);
    EXPECT_NEAR(last("left.velocity.x"), arm * w * std::sin(angle), 1e-6);
    EXPECT_NEAR(last("right.rotation.y"), angle, 1e-7);
    EXPECT_NEAR(last("energy.kinetic"), 0.5 * mass * v * v + 0.5 * J * w * w, 1e-7);
}

/// Magnitude of the Fourier transform of rows `step` apart at an angular frequency, Hann's window.
double content(const std::vector<double>& rows, double step, double omega) {
    std::complex<double> sum = 0;
    const auto count = static_cast<double>(rows.size());
    for (size_t n = 0; n < rows.size(); ++n) {
        const double window = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (static_cast<double>(n) + 0.5) / count);
        sum += window * rows[n] * std::polar(1.0, -omega * step * static_cast<double>(n));
    }
    return std::abs(sum);
}

/// Where that is largest near `omega`, by golden sections.
double peak(const std::vector<double>& rows, double step, double omega, double width) {
    double low = omega - width, high = omega + width;
    const double share = 0.5 * (std::sqrt(5.0) - 1);
    while (high - low > 1e-7 * omega) {
        const double one = high - share * (high - low), two = low + share * (high - low);
        if (content(rows, step, one) < content(rows, step, two))
            low = one;
        else
            high = two;
    }
    return 0.5 * (low + high);
}

// Oracle: eigenfrequencies ω of the lumps' matrices, which the centred scheme shifts to tan(ω_d h/2) = ω h/2; and those of
// the exact beam, from which the lumps' lie 1277 %/N² at most.
TEST(FreeTube, RingsAtItsLumpsFrequencies) {
    const double step = 1e-5;
    const auto columns = run({{"blow", "1 N"}}, step, 0.2);
    std::vector<double> after(columns.at("right.acceleration.z").begin() + 100, columns.at("right.acceleration.z").end());
    const test::LinearMachine machine = lumps();
    const VectorXd squares = test::solve_pencil(machine.K, machine.M).values;
    const test::LumpedTube parts = tube();
    const std::vector<double> exact =
        test::ExactTimoshenko{parts.EI, parts.shear, parts.mass_per_length, parts.rotary, kTubeLength}.free_frequencies(6,
                                                                                                                        120);
    for (Eigen::Index mode = 0; mode < 6; ++mode) {
        const double omega = std::sqrt(squares(2 + mode)), shifted = 2 / step * std::atan(omega * step / 2);
        const double heard = peak(after, step, shifted, 60);
        EXPECT_NEAR(heard, shifted, 1e-5 * shifted) << mode;
        EXPECT_LT(std::abs(omega / exact[static_cast<size_t>(mode)] - 1), 12.77 / (kSegments * kSegments)) << mode;
    }
}

}  // namespace
}  // namespace dttmm::host
