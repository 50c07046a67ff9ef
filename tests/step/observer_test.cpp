// SPDX-License-Identifier: BSD-3-Clause
//
// What the rows say, against motions and energies known in closed form.
#include "step/observer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "step/simulation.h"
#include "support/models.h"

namespace dttmm::host {
namespace {

/// Runs a model and keeps every row; values by channel name.
class Rows {
public:
    Rows(const Model& model, const Plugins& plugins) {
        Simulation simulation(model, plugins);
        channels_ = simulation.channels();
        simulation.record_to([this](std::span<const double> row) { rows_.emplace_back(row.begin(), row.end()); });
        while (simulation.index() < simulation.step_count()) simulation.step();
    }
    size_t count() const { return rows_.size(); }
    double operator()(size_t row, const std::string& channel) const {
        for (size_t c = 0; c < channels_.size(); ++c)
            if (channels_[c].name() == channel) return rows_[row][c];
        ADD_FAILURE() << "no channel " << channel;
        return NAN;
    }

private:
    std::vector<Channel> channels_;
    std::vector<std::vector<double>> rows_;
};

Model thrown_body() {
    Model model;
    model.simulation.step = 1e-3;
    model.simulation.duration = 0.5;
    model.simulation.gravity = {0, 0, -9.81};
    Body body = test::box("brick", 2, {0.2, 0.2, 0.2}, {1, 2, 3});  // a cube: it spins steadily about any axis
    body.center_of_mass = {0.05, 0.02, -0.04};
    body.velocity = {3, 1, 4};
    body.angular_velocity = {0.5, -6, 2};
    body.markers.push_back({"tip", {0.3, 0.1, -0.2}, nullptr});
    model.bodies.push_back(body);
    return model;
}

// Whoever wants some channels gets the same numbers in them: of an element, a body, an energy.
TEST(Observer, WantedChannelsAreThoseOfAllChannels) {
    const Plugins plugins;
    Model model = test::plate_stack(plugins, 2, 5e5, 100, 1e-3, Coupling::implicit);
    model.bodies[1].velocity = {0.1, -0.2, 0.3};
    model.bodies[1].angular_velocity = {0.3, -0.2, 0.5};  // so that no channel is zero
    const auto rows_of = [&](const std::vector<int>& wanted) {
        Simulation simulation(model, plugins);
        if (!wanted.empty()) simulation.want(wanted);
        std::vector<std::vector<double>> rows;
        simulation.record_to([&](std::span<const double> row) { rows.emplace_back(row.begin(), row.end()); });
        for (int i = 0; i < 20; ++i) simulation.step();
        return rows;
    };
    const std::vector<Channel> channels = Simulation(model, plugins).channels();
    const auto all = rows_of({});
    for (const auto of : {Channel::Of::element, Channel::Of::body, Channel::Of::energy}) {
        for (int c = 0; c < static_cast<int>(channels.size()); ++c) {
            const auto column = static_cast<size_t>(c);
            if (channels[column].of() != of || all.back()[column] == 0) continue;
            const auto some = rows_of({c});
            for (size_t row = 0; row < all.size(); ++row)
                EXPECT_EQ(some[row][column], all[row][column]) << channels[column].name();
            break;
        }
    }
    // The last channel of the networks, and the first behind them
    const auto last =
        std::ranges::find_if(channels, [](const Channel& one) { return one.of() == Channel::Of::body; }) - channels.begin();
    for (const auto c : {last - 1, last}) {
        const auto column = static_cast<size_t>(c);
        EXPECT_NE(all.back()[column], 0) << channels[column].name();
        EXPECT_EQ(rows_of({static_cast<int>(c)}).back()[column], all.back()[column]) << channels[column].name();
    }
}

// Oracle: networks that nobody observes. Energies are no channels of the rows.
TEST(Observer, ChannelsOfNetworksStayWhatTheyAre) {
    const Plugins plugins;
    const Model model = test::plate_stack(plugins, 2, 5e5, 100, 1e-3, Coupling::implicit);
    Simulation simulation(model, plugins);
    const Networks networks(model, plugins);
    const NetworkInstance &observed = simulation.networks().instances()[0], &own = networks.instances()[0];
    ASSERT_EQ(observed.channel_count(), own.channel_count());
    for (size_t c = 0; c < own.channel_count(); ++c) {
        EXPECT_EQ(observed.channel(c).name(), own.channel(c).name()) << c;
        EXPECT_EQ(observed.channel(c).unit(), own.channel(c).unit()) << c;
    }
}

// Oracle: free fall and steady spin in closed form, read at the body's origin and at a marker: x, v and a of both. The
// scheme is exact for the fall; the spin's centred differences are second order, (ωh)²/6 = 7e-6 of ω² r.
TEST(Observer, PositionVelocityAndAccelerationOfAThrownBody) {
    const Plugins plugins;
    const Model model = thrown_body();
    const Rows rows(model, plugins);
    const Body& body = model.bodies[0];
    const Eigen::Vector3d w = body.angular_velocity, g(0, 0, -9.81);
    ASSERT_EQ(rows.count(), 501u);
    for (size_t n : {size_t{0}, size_t{1}, size_t{250}, size_t{500}}) {
        const double t = 1e-3 * static_cast<double>(n);
        const Eigen::Matrix3d R = Eigen::AngleAxisd(t * w.norm(), w.normalized()).toRotationMatrix();
        const Eigen::Vector3d com_velocity = body.velocity + w.cross(body.center_of_mass);
        const Eigen::Vector3d com = body.position + body.center_of_mass + t * com_velocity + 0.5 * t * t * g;
        const auto check = [&](const std::string& name, const Eigen::Vector3d& from_com) {
            const Eigen::Vector3d arm = R * from_com;
            const Eigen::Vector3d x = com + arm, v = com_velocity + t * g + w.cross(arm), a = g + w.cross(w.cross(arm));
            const char* axes[] = {".x", ".y", ".z"};
            for (int i = 0; i < 3; ++i) {
                EXPECT_NEAR(rows(n, name + ".position" + axes[i]), x(i), 1e-11) << n;
                EXPECT_NEAR(rows(n, name + ".velocity" + axes[i]), v(i), 1e-10) << n;
                EXPECT_NEAR(rows(n, name + ".acceleration" + axes[i]), a(i), 1e-9) << n;
            }
        };
        check("brick", -body.center_of_mass);
        check("brick.tip", Eigen::Vector3d(0.3, 0.1, -0.2) - body.center_of_mass);
        EXPECT_NEAR(rows(n, "time"), t, 1e-15);
        EXPECT_NEAR(rows(n, "brick.angular_velocity.y"), -6, 1e-12);
        EXPECT_NEAR(std::abs(rows(n, "brick.quaternion.w")), std::abs(std::cos(0.5 * t * w.norm())), 1e-12);
        EXPECT_NEAR(rows(n, "energy.residual"), 0, 1e-9) << n;  // of about 40 J
    }
}

// Oracle: energy of a damped mass on a spring in closed form at t = 0 and conservation: what is lost is in the damper. The
// ledger of a linear machine closes to rounding at every step size, with dampers, gravity and loads: Newmark's rule has
// Δ(m v²/2 + k x²/2) = (mean load) Δx − c Δx²/h.
TEST(Observer, EnergyLedgerOfALinearMachineClosesToRounding) {
    const Plugins plugins;
    const auto residual = [&](double step) {
        Model model = test::plate_stack(plugins, 1, 5e5, 100, step, Coupling::implicit);
        model.simulation.duration = 0.2;
        model.simulation.gravity = {0, 0, -9.81};
        model.bodies[0].velocity = {0, 0, 0.3};
        const Rows rows(model, plugins);
        EXPECT_NEAR(rows(0, "energy.kinetic"), 0.5 * test::kPlateMass * 0.09, 1e-13);
        EXPECT_EQ(rows(0, "energy.residual"), 0);
        double largest = 0, items = 0;
        for (size_t n = 0; n < rows.count(); ++n) {
            largest = std::max(largest, std::abs(rows(n, "energy.residual")));
            items = std::max({items, rows(n, "energy.kinetic"), rows(n, "energy.strain"), std::abs(rows(n, "energy.work"))});
        }
        EXPECT_GT(rows(rows.count() - 1, "energy.dissipated"), 0.2);
        return largest / items;
    };
    for (const double step : {4e-3, 4e-4, 2e-5}) EXPECT_LT(residual(step), 1e-11) << step;
}

// Oracle: the initial conditions themselves. At t = 0 the springs are slack and the body is given its velocity: a = g + f/m
// with f = −c v, whatever the first step, here far too long for the damper (c h/m = 4 · 10), makes of it.
TEST(Observer, TheFirstRowIsTheInitialConditions) {
    const Plugins plugins;
    for (Coupling coupling : {Coupling::implicit, Coupling::explicit_}) {
        const double c = coupling == Coupling::implicit ? 94200 : 94.2;
        Model model = test::plate_stack(plugins, 1, 5e5, c, 1e-3, coupling);
        model.loads.clear();
        model.simulation.gravity = {0, 0, -9.81};
        model.simulation.duration = 0.05;
        model.bodies[0].velocity = {0, 0, 0.3};
        const Rows rows(model, plugins);
        EXPECT_NEAR(rows(0, "plate1.velocity.z"), 0.3, 1e-15);
        EXPECT_NEAR(rows(0, "plate1.acceleration.z"), -9.81 - 4 * c * 0.3 / test::kPlateMass, 1e-8 * c);
        EXPECT_NEAR(rows(0, "bolt1_1.force.z"), c * 0.3, 1e-10 * c);
        EXPECT_NEAR(rows(0, "energy.kinetic"), 0.5 * test::kPlateMass * 0.09, 1e-13);
        EXPECT_EQ(rows(0, "energy.dissipated"), 0);
    }
}

// Oracle: the schemes have no numerical damping and no growth: over a million steps what the ledger is off by is in the last
// tenth what it was in the first; with the explicit scheme it oscillates with (ωh)², with Newmark's it stems from the
// plate's turning alone.
TEST(Observer, AnUndampedPlateKeepsItsEnergyOverAMillionSteps) {
    const Plugins plugins;
    for (Coupling coupling : {Coupling::implicit, Coupling::explicit_}) {
        Model model = test::plate_stack(plugins, 1, 5e5, 0, 1e-3, coupling);
        model.loads.clear();
        model.bodies[0].velocity = {0.1, -0.2, 0.3};
        model.bodies[0].angular_velocity = {0.5, 0.3, -0.4};
        model.simulation.duration = 1000;
        model.output.every = 97;  // in no simple ratio to a period: 1000 sees the same phase for a hundred rows
        const Rows rows(model, plugins);
        const double energy = rows(0, "energy.kinetic") + rows(0, "energy.strain");
        double early = 0, late = 0, early_sum = 0, late_sum = 0;
        const size_t tenth = rows.count() / 10;
        ASSERT_GT(tenth, 1000u);
        for (size_t n = 0; n < tenth; ++n) {
            const double first = rows(n, "energy.residual"), last = rows(rows.count() - tenth + n, "energy.residual");
            early = std::max(early, std::abs(first));
            late = std::max(late, std::abs(last));
            early_sum += first;
            late_sum += last;
        }
        if (coupling == Coupling::explicit_) {
            EXPECT_NEAR(late_sum / early_sum, 1, 0.02);
            EXPECT_LT(late, 1.05 * early);
        }
        EXPECT_LT(late, (coupling == Coupling::explicit_ ? 0.15 : 1e-4) * energy) << early;
    }
}

// Oracle: Richardson. Two tumbling bodies on a strong spring-damper between them: what the ledger is off by at the end, with
// all energy in it that the damper took, falls by four per halving.
TEST(Observer, TwoJoinedTumblingBodiesAccountForTheirEnergyToSecondOrder) {
    const Plugins plugins;
    Model model;
    model.simulation.duration = 0.5;
    for (int i = 0; i < 2; ++i) {
        Body body = test::box(i ? "club" : "brick", 2 - i, {0.1, 0.25, 0.4}, {i + 0.0, 2, 3});
        body.rotation = Eigen::AngleAxisd(0.7 + i, Eigen::Vector3d(1, 1, 0.3).normalized()).toRotationMatrix();
        body.velocity = {0.1 - i, -0.2, 0.3 * i};
        body.angular_velocity = {0.5, 6 - 8.0 * i, 0.8 + i};
        body.markers.push_back({"end", {0.05, 0.1 - i, 0.2}, nullptr});
        model.bodies.push_back(body);
    }
    Element joint = test::spring("joint", plugins, {0, 0}, {1, 0}, 3e3, 1);
    joint.values = test::spring_values({3e3, 4e3, 5e3, 1, 2, 0.5, 20, 30, 10, 0.02, 0.01, 0.03});
    model.elements.push_back(joint);
    for (Coupling coupling : {Coupling::implicit, Coupling::explicit_}) {
        model.simulation.coupling = coupling;
        const auto residual = [&](double step) {
            model.simulation.step = step;
            const Rows rows(model, plugins);
            EXPECT_GT(rows(rows.count() - 1, "energy.dissipated"), 0.1);
            return std::abs(rows(rows.count() - 1, "energy.residual"));
        };
        const double coarse = residual(1.25e-4), fine = residual(0.625e-4);
        EXPECT_NEAR(coarse / fine, 4, 0.2);
        EXPECT_LT(coarse, 0.05);  // J, of about 50
    }
}

}  // namespace
}  // namespace dttmm::host
