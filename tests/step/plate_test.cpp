// SPDX-License-Identifier: BSD-3-Clause
//
// The four-bolt plate against the exact solution of its six linear equations of motion.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <fstream>
#include <iterator>

#include "model/read_model.h"
#include "step/simulation.h"
#include "support/exact_plate.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using Bolts = test::PlateOnBolts;
using Forces = test::PlateForces;
using test::exact_plate_forces;

const Bolts kSoft = test::kSoftBolts, kStiff = test::kStiffBolts;

/// rise: of the load, instead of the example's, as text.
Forces simulated_forces(const std::string& example, const ModelOverrides& overrides, const std::string& rise = "") {
    const Plugins plugins;
    const std::string path = std::string(test::paths::source_dir()) + "/examples/" + example + "/model.toml";
    std::ifstream file(path);
    std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
    if (!rise.empty()) text.replace(text.find("18.4 ms"), 7, rise);
    const Model model = parse_model(text, path, plugins.catalogue(), overrides);
    Simulation simulation(model, plugins);
    std::array<size_t, 4> column{};
    for (size_t c = 0; c < simulation.channels().size(); ++c)
        for (size_t i = 0; i < 4; ++i)
            if (simulation.channels()[c].name() == fmt::format("bolt{}.force.z", i + 1)) column[i] = c;
    Forces forces;
    const auto per_millisecond = static_cast<long>(std::llround(1e-3 / model.simulation.step));
    long row = 0;
    simulation.record_to([&](std::span<const double> values) {
        if (row++ % per_millisecond == 0)
            forces.push_back({values[column[0]], values[column[1]], values[column[2]], values[column[3]]});
    });
    while (simulation.index() < simulation.step_count()) simulation.step();
    return forces;
}

double error(const Forces& forces, const Forces& exact) {
    EXPECT_EQ(forces.size(), exact.size());
    return test::plate_error(forces, exact);
}

ModelOverrides soft_bolt(const std::string& step, const std::string& coupling) {
    ModelOverrides overrides;
    overrides.parameters = {{"k1", "400 N/mm"}};
    overrides.step = step;
    overrides.coupling = coupling;
    return overrides;
}

// Oracle: matrix exponential; a second-order scheme divides the error by four per halving. Written out by hand for the
// linear plate, Newmark's rule has the error 1.01466e-2 at 1 ms.
TEST(Plate, ImplicitCouplingIsSecondOrderDownToAHundredthOfAMillisecond) {
    const Forces exact = exact_plate_forces(kSoft, 1000);
    double previous = 0;
    for (const char* step : {"1 ms", "0.5 ms", "0.25 ms", "0.125 ms", "0.0625 ms", "0.03125 ms", "0.015625 ms"}) {
        const double now = error(simulated_forces("four_bolt_plate", soft_bolt(step, "implicit")), exact);
        if (previous == 0) {
            EXPECT_NEAR(now, 1.01466e-2, 1e-6);
        } else {
            EXPECT_NEAR(previous / now, 4, 0.2) << "at " << step;
        }
        previous = now;
    }
    EXPECT_LT(error(simulated_forces("four_bolt_plate", soft_bolt("0.01 ms", "implicit")), exact), 1e-6);
}

// Newmark's own, written out by hand for a load that rises in 20 ms.
TEST(Plate, ErrorAtOneMillisecondIsNewmarksForASlowerRise) {
    const Bolts bolts{kSoft.k, kSoft.c, 20e-3};
    EXPECT_NEAR(
        error(simulated_forces("four_bolt_plate", soft_bolt("1 ms", "implicit"), "20 ms"), exact_plate_forces(bolts, 1000)),
        7.2076e-3, 1e-6);
}

TEST(Plate, ExplicitCouplingOfThePaperFallsBelowOnePerMilleAtATenthOfAMillisecond) {
    const Forces exact = exact_plate_forces(kSoft, 1000);
    const double coarse = error(simulated_forces("four_bolt_plate", soft_bolt("0.2 ms", "explicit")), exact);
    const double fine = error(simulated_forces("four_bolt_plate", soft_bolt("0.1 ms", "explicit")), exact);
    EXPECT_LT(fine, 1e-3);
    EXPECT_NEAR(coarse / fine, 4, 0.4);
}

// Oracle: matrix exponential. omega*h is 21 here: the explicit coupling of the paper would throw the plate away.
TEST(Plate, ImplicitCouplingHoldsRealBoltsAtOneMillisecond) {
    const double now = error(simulated_forces("stiff_bolts", {}), exact_plate_forces(kStiff, 1000));
    EXPECT_LT(now, 1e-3);
    EXPECT_GT(now, 1e-6) << "too good to be a 1 ms step: is the oracle fed with our own numbers?";
}

// Oracle: statics (theory V8): 235.294, 264.706, 235.294, 264.706 N. The motion has decayed to e^−21 of its peak after 1 s.
TEST(Plate, ASoftBoltAndItsDiagonalPartnerCarryLess) {
    const Forces forces = simulated_forces("four_bolt_plate", soft_bolt("1 ms", "implicit"));
    EXPECT_NEAR(forces.back()[0], 4000.0 / 17, 1e-4);
    EXPECT_NEAR(forces.back()[1], 4500.0 / 17, 1e-4);
    EXPECT_NEAR(forces.back()[2], 4000.0 / 17, 1e-4);
    EXPECT_NEAR(forces.back()[3], 4500.0 / 17, 1e-4);
}

// Oracle: the exact peak on the 1 ms grid, 260.80 N; the paper prints 261 N.
TEST(Plate, SymmetricPeakIsThatOfTheExactSolution) {
    const Forces exact = exact_plate_forces({{5e5, 5e5, 5e5, 5e5}, 100, 18.4e-3}, 1000);
    ModelOverrides fine;
    fine.step = "0.05 ms";
    const Forces forces = simulated_forces("four_bolt_plate", fine);
    double peak = 0, exact_peak = 0;
    for (size_t n = 0; n < exact.size(); ++n) {
        peak = std::max(peak, forces[n][0]);
        exact_peak = std::max(exact_peak, exact[n][0]);
    }
    EXPECT_NEAR(exact_peak, 260.80, 0.005);
    EXPECT_NEAR(peak, exact_peak, 250 * 2e-5);
}

// Oracle: the same numbers twice.
TEST(Plate, RunsRepeatToTheBit) {
    EXPECT_EQ(simulated_forces("four_bolt_plate", soft_bolt("1 ms", "implicit")),
              simulated_forces("four_bolt_plate", soft_bolt("1 ms", "implicit")));
}

}  // namespace
}  // namespace dttmm::host
