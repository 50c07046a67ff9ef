// SPDX-License-Identifier: BSD-3-Clause
//
// Extrapolated histories of the four-bolt plate and their estimates against the exact solution: the bound must hold.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <map>

#include "analysis/convergence.h"
#include "analysis/halving.h"
#include "model/read_model.h"
#include "step/simulation.h"
#include "support/exact_linear_system.h"
#include "support/linear_algebra.h"
#include "support/models.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using test::kCorners;
using Rows = std::vector<std::map<std::string, double>>;  ///< channel → value, per row

/// The plate, its bolts, and a load of 1000 N that rises in `rise` from `start` on, or jumps there.
struct Case {
    std::string example;
    std::array<double, 4> k;
    double c, start, rise;

    double load(double time) const {
        const double s = rise > 0 ? std::clamp((time - start) / rise, 0.0, 1.0) : time < start ? 0 : 1;
        return 1000 * s * s * (3 - 2 * s);
    }
};

const Case kEqual{"four_bolt_plate", {5e5, 5e5, 5e5, 5e5}, 100, 0, 18.4e-3};
const Case kSoft{"four_bolt_plate", {4e5, 5e5, 5e5, 5e5}, 100, 0, 18.4e-3};
const Case kSoftTwentyMilliseconds{"four_bolt_plate", {4e5, 5e5, 5e5, 5e5}, 100, 0, 20e-3};
const Case kStiff{"stiff_bolts", {4e8, 5e8, 5e8, 5e8}, 1000, 0, 20e-3};

Case jump(double at) { return {"four_bolt_plate", {4e5, 5e5, 5e5, 5e5}, 100, at, 0}; }

Eigen::Matrix<double, 1, 6> lift_of(const Eigen::Vector3d& arm) {
    Eigen::Matrix<double, 1, 6> g;
    g << 0, 0, 1, arm.y(), -arm.x(), 0;
    return g;
}

/// Every channel that moves in first order of the (small) motion, at rows `every` apart.
Rows exact_rows(const Case& plate, double every, int count) {
    Eigen::MatrixXd M = Eigen::MatrixXd::Zero(6, 6), C = M, K = M;
    M.diagonal() << 9.42, 9.42, 9.42, 9.42 / 12 * (0.04 + 4e-4), 9.42 / 12 * (0.09 + 4e-4), 9.42 / 12 * 0.13;
    for (size_t i = 0; i < 4; ++i) {
        const Eigen::Vector3d r = kCorners[i];
        Eigen::Matrix<double, 3, 6> G;
        G << 1, 0, 0, 0, r.z(), -r.y(), 0, 1, 0, -r.z(), 0, r.x(), 0, 0, 1, r.y(), -r.x(), 0;
        K += plate.k[i] * G.transpose() * G;
        C += plate.c * G.transpose() * G;
    }
    const Eigen::VectorXd p = Eigen::VectorXd::Unit(6, 2);
    const Eigen::MatrixXd inverse = test::inverse(M);
    test::ExactLinearSystem motion(M, C, K, p, 1000, plate.rise);
    Rows rows;
    double reached = 0;
    for (int n = 0; n < count; ++n) {
        const double t = std::max(n * every - plate.start, 0.0);
        motion.advance(t - reached);
        reached = t;
        const Eigen::VectorXd q = motion.q(), v = motion.rate(), a = inverse * (p * plate.load(n * every) - C * v - K * q);
        std::map<std::string, double> row = {{"plate.position.z", q(2)},           {"plate.velocity.z", v(2)},
                                             {"plate.acceleration.z", a(2)},       {"plate.angular_velocity.x", v(3)},
                                             {"plate.angular_velocity.y", v(4)},   {"energy.kinetic", 0.5 * v.dot(M * v)},
                                             {"energy.strain", 0.5 * q.dot(K * q)}};
        for (size_t i = 0; i < 4; ++i) {
            const auto g = lift_of(kCorners[i]);
            row[fmt::format("bolt{}.deflection.z", i + 1)] = g * q;
            row[fmt::format("bolt{}.force.z", i + 1)] = (g * (plate.k[i] * q + plate.c * v)).value();
            row[fmt::format("plate.corner{}.acceleration.z", i + 1)] = g * a;
        }
        rows.push_back(row);
    }
    return rows;
}

class Histories {
public:
    /// rows: how many, `first_step` apart.
    Histories(const Case& plate, double first_step, int rows) : first_step_(first_step), rows_(rows) {
        const std::string path = test::paths::source_dir() + "/examples/" + plate.example + "/model.toml";
        std::ifstream file(path);
        const std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
        model_ = parse_model(text, path, plugins_.catalogue());
        for (size_t i = 0; i < 4; ++i)
            for (size_t axis = 0; axis < 3; ++axis) model_.elements[i].values.change()[axis] = plate.k[i];
        struct Load : Signal::Shape {
            explicit Load(const Case& of) : plate(of) {}
            double value(double time) const override { return plate.load(time); }
            const Case plate;
        };
        model_.loads[0].signal = Signal(std::make_shared<Load>(plate));
        model_.simulation.duration = first_step * (rows - 1);
    }

    void add() {
        model_.simulation.step = std::ldexp(first_step_, -static_cast<int>(levels_));
        model_.output.every = 1 << levels_++;
        Simulation simulation(model_, plugins_);
        channels_ = simulation.channels();
        if (!convergence_) convergence_.emplace(channels_.size());
        std::vector<double> history;
        simulation.record_to([&](std::span<const double> row) { history.insert(history.end(), row.begin(), row.end()); });
        while (simulation.index() < simulation.step_count()) simulation.step();
        ASSERT_EQ(history.size(), channels_.size() * static_cast<size_t>(rows_));
        const bool resolved = simulation.fastest_mode().omega * simulation.step_size() <= kUnresolved;
        convergence_->add(history, resolved ? 1 : kUnresolvedAllowance);
    }

    /// Largest true error of every channel that is exactly known. A row less than a step from a jump has, in every run
    /// alike, an acceleration between those before and after it: nothing to be compared.
    std::map<std::string, double> errors(const Case& plate, const Rows& exact) const {
        std::map<std::string, double> largest;
        std::vector<double> values(channels_.size()), estimates(channels_.size());
        for (size_t n = 0; n < exact.size(); ++n) {
            convergence_->evaluate_row(n, values, estimates);
            const bool at_jump = plate.rise == 0 && std::abs(values[0] - plate.start) <= model_.simulation.step;
            for (size_t c = 0; c < channels_.size(); ++c)
                if (const auto found = exact[n].find(channels_[c].name());
                    found != exact[n].end() && !(at_jump && channels_[c].unit() == "m/s^2"))
                    largest[found->first] = std::max(largest[found->first], std::abs(values[c] - found->second));
        }
        return largest;
    }
    double estimate(const std::string& channel) const {
        for (size_t c = 0; c < channels_.size(); ++c)
            if (channels_[c].name() == channel) return convergence_->estimates()[c];
        ADD_FAILURE() << channel;
        return 0;
    }

private:
    const Plugins plugins_;
    Model model_;
    double first_step_;
    int rows_;
    size_t levels_ = 0;
    std::vector<Channel> channels_;
    std::optional<Convergence> convergence_;
};

double peak(const Rows& rows, const std::string& channel) {
    double largest = 0;
    for (const auto& row : rows) largest = std::max(largest, std::abs(row.at(channel)));
    return largest;
}

/// The bound for every channel at two to `levels` histories.
void expect_bounds(const Case& plate, double first_step, int rows, int levels) {
    Histories histories(plate, first_step, rows);
    const Rows exact = exact_rows(plate, first_step, rows);
    histories.add();
    for (int level = 1; level < levels; ++level) {
        histories.add();
        const auto errors = histories.errors(plate, exact);
        EXPECT_EQ(errors.size(), 19u);
        for (const auto& [channel, error] : errors) {
            // The plate turns by 4e-4 and moves by 6e-4 of its size: the linear equations leave out the squares of that.
            EXPECT_LE(error, histories.estimate(channel) + 1e-6 * peak(exact, channel))
                << channel << ", first step " << first_step << ", level " << level << ", start " << plate.start;
        }
    }
}

/// Largest error, and estimate, of the four bolts as a share of the static force, 250 N.
std::pair<double, double> bolt_error(const Case& plate, double first_step, int rows, int levels) {
    Histories histories(plate, first_step, rows);
    for (int level = 0; level < levels; ++level) histories.add();
    const auto errors = histories.errors(plate, exact_rows(plate, first_step, rows));
    std::pair<double, double> largest;
    for (const char* bolt : {"bolt1.force.z", "bolt2.force.z", "bolt3.force.z", "bolt4.force.z"}) {
        largest.first = std::max(largest.first, errors.at(bolt) / 250);
        largest.second = std::max(largest.second, histories.estimate(bolt) / 250);
    }
    return largest;
}

// Oracle: matrix exponential.
TEST(PlateEstimate, BoundsTheErrorOfEveryChannel) {
    for (const Case& plate : {kEqual, kSoft, kSoftTwentyMilliseconds})
        for (double step : {2e-3, 1e-3, 0.8e-3, 0.5e-3}) expect_bounds(plate, step, 201, 6);
}

// Oracle: matrix exponential. omega*h begins at 21 and the fast modes are seen only after a few halvings.
TEST(PlateEstimate, BoundsTheErrorOfStiffBolts) {
    for (double step : {1e-3, 0.4e-3}) expect_bounds(kStiff, step, 101, 10);
}

// Oracle: matrix exponential. The load jumps at a row, between steps of the first runs, and where no step of any run falls.
TEST(PlateEstimate, BoundsTheErrorAfterAJump) {
    for (double at : {18e-3, 18.4e-3, 18.0001e-3, 18.71e-3, 18.3333e-3, 18.999e-3}) expect_bounds(jump(at), 1e-3, 101, 8);
}

// Oracle: matrix exponential; the figures of the README. Richardson leaves fourth order: sixteenfold per halving.
TEST(PlateEstimate, ExtrapolationLeavesFourthOrder) {
    const auto [one, one_estimate] = bolt_error(kSoft, 1e-3, 1001, 2);
    const auto [half, half_estimate] = bolt_error(kSoft, 0.5e-3, 2001, 2);
    EXPECT_NEAR(one, 6.2e-4, 1e-5);
    EXPECT_NEAR(half, 3.8e-5, 1e-6);
    EXPECT_NEAR(one_estimate, 1.2e-2, 5e-4);
    EXPECT_NEAR(half_estimate, 2.8e-3, 1e-4);
    const auto [three, three_estimate] = bolt_error(kSoft, 1e-3, 1001, 3);
    EXPECT_NEAR(three, half, 0.05 * half) << "the same last pair";
    EXPECT_NEAR(three_estimate, 1.8e-3, 1e-4);
    const auto [four, four_estimate] = bolt_error(kSoft, 1e-3, 1001, 4);
    EXPECT_NEAR(four, 2.2e-7, 2e-8) << "extrapolated twice";
    EXPECT_NEAR(four_estimate, 4.3e-5, 2e-6);
    // with the rise of 20 ms that the design's figures belong to
    EXPECT_NEAR(bolt_error(kSoftTwentyMilliseconds, 1e-3, 1001, 2).first, 2.84e-4, 5e-6);
    EXPECT_NEAR(bolt_error(kSoftTwentyMilliseconds, 0.5e-3, 2001, 2).first, 1.82e-5, 5e-7);
}

}  // namespace
}  // namespace dttmm::host
