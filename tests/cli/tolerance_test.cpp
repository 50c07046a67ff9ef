// SPDX-License-Identifier: BSD-3-Clause
//
// A tolerance instead of a step, as a user asks for it.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <cmath>
#include <random>

#include "cli/process.h"
#include "cli/small_model.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const std::string kPlate = test::paths::source_dir() + "/examples/four_bolt_plate/model.toml";
const std::string kStiff = test::paths::source_dir() + "/examples/stiff_bolts/model.toml";

std::vector<double> read_dataset(const fs::path& path, const std::string& name) {
    const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    const hid_t dataset = H5Dopen2(file, name.c_str(), H5P_DEFAULT);
    EXPECT_GE(dataset, 0) << name;
    const hid_t space = H5Dget_space(dataset);
    std::vector<double> values(static_cast<size_t>(H5Sget_simple_extent_npoints(space)));
    H5Dread(dataset, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Sclose(space);
    H5Dclose(dataset);
    H5Fclose(file);
    return values;
}

class Tolerance : public testing::Test {
protected:
    Tolerance() { write_text(folder_ / "model.toml", kSmallModel); }

    Ended run(std::vector<std::string> words) {
        words.insert(words.begin(), {"run", "-o", "out"});
        return run_dttmm(folder_.path(), words);
    }
    nlohmann::json summary(const std::string& out = "out") const { return read_json(folder_ / out / "summary.json"); }
    std::vector<std::vector<double>> rows() const { return read_history(folder_ / "out/history.csv"); }

    const TemporaryFolder folder_;
};

// Oracle: a free mass under a sine of 125 Hz from rest; its acceleration is F/m sin(omega t).
TEST_F(Tolerance, AModelWithoutAStepRunsToOnePercent) {
    const std::string text =
        "format = \"dttmm/1\"\n[simulation]\nduration = \"0.4 s\"\n[[body]]\nname = \"m\"\nmass = 2\n"
        "inertia = [1, 1, 1]\n[[load]]\non = \"m\"\ndirection = [0, 0, 1]\nforce = { type = \"sine\", "
        "amplitude = 80, frequency = \"125 Hz\" }\n[[element]]\nname = \"k\"\ntype = \"spring_damper\"\n"
        "from = \"ground\"\nto = \"m\"\nstiffness = 1e-3\n";
    write_text(folder_ / "model.toml", text);
    const Ended ended = run({"model.toml"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(ended.err, "");
    EXPECT_NEAR(summary().at("tolerance").at("tolerance"), 0.01, 0);
    EXPECT_NEAR(summary()["accelerations"]["m"]["acceleration"]["z"]["peak"], 40, 0.4);
    const Ended check = run_dttmm(folder_.path(), {"check", "model.toml"});
    EXPECT_THAT(check.out, AllOf(HasSubstr("implicit coupling, 1000 steps of 0.0004 s (chosen, as no step is given), a row "
                                           "every step\n"),
                                 HasSubstr("repeated at half the step until the results are within 1 %")));
    // A step asks for just that step
    ASSERT_EQ(run({"model.toml", "--step", "1 ms"}).code, 0);
    EXPECT_FALSE(summary().contains("tolerance"));
    ASSERT_EQ(run({"model.toml", "--tolerance", "0.1 %"}).code, 0);
    EXPECT_NEAR(summary()["accelerations"]["m"]["acceleration"]["z"]["peak"], 40, 0.04);
}

// Oracle: a run to a tolerance ten thousand times tighter; the estimate must cover what the history is off by. Estimates are
// those of the files, row by row and in the summary.
TEST_F(Tolerance, TheHistoryIsWithinItsEstimateOfTheExactOne) {
    const std::vector<std::string> plate = {kPlate, "--set", "k1=400 N/mm", "--duration", "0.1 s"};
    std::vector<std::string> exact = plate, words = plate;
    exact.insert(exact.end(), {"--tolerance", "1e-7"});
    words.insert(words.end(), {"--tolerance", "0.1 %"});
    ASSERT_EQ(run(exact).code, 0);
    const auto reference = rows();
    const Ended ended = run(words);
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(ended.err, "");
    EXPECT_THAT(ended.out, AllOf(HasSubstr("asked for 0.1 %; step 0.000125 s of 0.001 s at first, observed order 2.0")));
    const auto history = rows();
    ASSERT_EQ(history.size(), 101u);
    ASSERT_EQ(reference.size(), 101u);
    const nlohmann::json result = summary(), &tolerance = result["tolerance"];
    EXPECT_EQ(result["status"], "completed");
    EXPECT_EQ(tolerance["tolerance"], 0.001);
    EXPECT_EQ(tolerance["reached"], true);
    EXPECT_EQ(tolerance["first_step"], 0.001);
    EXPECT_EQ(tolerance["step"], 1.25e-4);
    EXPECT_NEAR(tolerance["observed_order"].get<double>(), 2, 0.1);
    EXPECT_LE(tolerance["relative_error"].get<double>(), 0.001);
    ASSERT_EQ(tolerance["levels"].size(), 4u);
    EXPECT_EQ(tolerance["levels"][1]["step"], 0.0005);
    EXPECT_TRUE(tolerance["levels"][0]["relative_error"].is_null());
    EXPECT_TRUE(tolerance["levels"][1]["observed_order"].is_null());
    EXPECT_GT(tolerance["levels"][2]["relative_error"].get<double>(), 0.001) << "else it would have been enough";
    EXPECT_EQ(result["steps"], 100 + 200 + 400 + 800);

    std::istringstream names(read_text(folder_ / "out/history.csv"));
    std::string name;
    std::getline(names, name, ',');
    size_t judged = 0;
    for (size_t c = 1; c < history[0].size(); ++c) {
        std::getline(names, name, c + 1 < history[0].size() ? ',' : '\n');
        const double estimate = tolerance["error_estimate"].at(name);
        const std::vector<double> errors = read_dataset(folder_ / "out/history.h5", name + ".error");
        const std::vector<double> values = read_dataset(folder_ / "out/history.h5", name);
        ASSERT_EQ(errors.size(), history.size());
        EXPECT_EQ(errors.back(), estimate) << name;
        double largest = 0;
        for (size_t row = 0; row < history.size(); ++row) {
            const double own = 1e-8 * std::abs(reference[row][c]);
            EXPECT_LE(std::abs(history[row][c] - reference[row][c]), errors[row] + own + 1e-13) << name << " " << row;
            EXPECT_EQ(values[row], history[row][c]);
            largest = std::max(largest, errors[row]);
        }
        EXPECT_EQ(largest, estimate);
        ++judged;
    }
    EXPECT_EQ(tolerance["error_estimate"].size(), judged);
    double peak = 0;
    for (const auto& row : history) peak = std::max(peak, std::abs(row[3]));
    EXPECT_EQ(result["elements"]["bolt1"]["force"]["z"]["peak"], peak) << "peaks are of the extrapolated history";
}

// Positions of markers are not selected by themselves: the summary has them as the last run has them, and says so. Oracle:
// the plate does not turn, so its marker moves as its centre does, once both are extrapolated.
TEST_F(Tolerance, WhatIsNotSelectedIsToldToBeThatOfTheShortestStep) {
    const auto peak = [](const nlohmann::json& result, const char* place) {
        return result["positions"][place]["position"]["z"]["peak"].get<double>();
    };
    const std::vector<std::string> words = {kPlate, "--duration", "0.1 s", "--tolerance", "0.1 %"};
    ASSERT_EQ(run(words).code, 0);
    const nlohmann::json left_out = summary(), &names = left_out["tolerance"]["at_shortest_step"];
    EXPECT_THAT(names, testing::Contains("plate.corner1.position.z"));
    EXPECT_THAT(names, testing::Not(testing::Contains("plate.position.z")));
    for (const auto& name : names) EXPECT_FALSE(left_out["tolerance"]["error_estimate"].contains(name)) << name;
    EXPECT_NE(peak(left_out, "plate.corner1"), peak(left_out, "plate"));
    std::vector<std::string> selecting = words;
    selecting.insert(selecting.end(), {"--channels", "plate.position", "--channels", "plate.corner1.position"});
    ASSERT_EQ(run(selecting).code, 0);
    const nlohmann::json selected = summary();
    EXPECT_THAT(selected["tolerance"]["at_shortest_step"], testing::Not(testing::Contains("plate.corner1.position.z")));
    EXPECT_NEAR(peak(selected, "plate.corner1") / peak(selected, "plate"), 1, 1e-12);
}

// Oracle: symmetry: only z moves; what else there is is rounding, and must not keep the run from its end.
TEST_F(Tolerance, RoundingDoesNotKeepASymmetricPlateFromConverging) {
    ASSERT_EQ(run({kPlate, "--tolerance", "1e-4", "--duration", "0.1 s"}).code, 0);
    EXPECT_LE(summary()["tolerance"]["levels"].size(), 6u);
    write_text(folder_ / "model.toml", small_model_with("\"100 N\"", "\"0 N\""));
    ASSERT_EQ(run({"model.toml", "--tolerance", "1e-4"}).code, 0) << "nor a machine at rest";
    EXPECT_EQ(summary()["tolerance"]["levels"].size(), 2u);
}

// A quaternion and its negative are one rotation; taken for different, this body's would differ by 2 near half a turn.
// Oracle: nothing moves. Rounding of 1e-14 m was an error of 3 %, and steps were halved eleven times to 2e-8 s.
TEST_F(Tolerance, AMachineInEquilibriumTakesTwoRuns) {
    write_text(folder_ / "model.toml", R"(format = "dttmm/1"
[simulation]
duration = 0.02
gravity = [0, 0, -9.81]
start = "equilibrium"
[nodes]
a = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
n = [0.5, 0, 0.1]
[[body]]
name = "B"
mass = 2
inertia = [0.1, 0.2, 0.15]
position = [0.8, 0.1, 0.3]
[[element]]
name = "b1"
type = "beam"
from = "a"
to = "n"
segments = 5
section = { EA = 5e5, EIy = 30, EIz = 40, GJ = 20, GAy = 2e5, GAz = 2e5, mass = 1.2, inertia = 0.002 }
[[element]]
name = "b2"
type = "beam"
from = "n"
to = "B"
segments = 5
section = { EA = 5e5, EIy = 30, EIz = 40, GJ = 20, GAy = 2e5, GAz = 2e5, mass = 1.2, inertia = 0.002 }
)");
    for (const char* tolerance : {"1 %", "0.001 %"}) {
        const Ended ended = run({"model.toml", "--tolerance", tolerance});
        ASSERT_EQ(ended.code, 0) << ended.err;
        EXPECT_EQ(summary().at("tolerance").at("levels").size(), 2u) << tolerance;
    }
}

TEST_F(Tolerance, TheSignOfAQuaternionIsNoError) {
    write_text(folder_ / "spin.toml", R"(format = "dttmm/1"
simulation = { duration = "6 s", step = "8 ms" }
[[body]]
name = "rod"
mass = 1
inertia = [0.01, 0.05, 0.06]
angular_velocity = [3, 20, 1]
[[element]]
name = "mount"
type = "spring_damper"
from = "ground"
to = "rod"
stiffness = 1e3
)");
    ASSERT_EQ(run({"spin.toml", "--tolerance", "3 %"}).code, 0);
    const nlohmann::json whole = summary();
    for (const auto& level : whole["tolerance"]["levels"])
        if (!level["relative_error"].is_null()) {
            EXPECT_LT(level["relative_error"].get<double>(), 0.3);
        }
}

TEST_F(Tolerance, TheOptionReplacesTheModels) {
    write_text(folder_ / "model.toml", small_model_with("step = \"1 ms\"", "step = \"1 ms\"\ntolerance = \"10 %\""));
    ASSERT_EQ(run({"model.toml"}).code, 0);
    const double coarse = summary()["tolerance"]["step"];
    EXPECT_EQ(summary()["tolerance"]["tolerance"], 0.1);
    ASSERT_EQ(run({"model.toml", "--tolerance", "0.01 %"}).code, 0);
    EXPECT_EQ(summary()["tolerance"]["tolerance"], 1e-4);
    EXPECT_LT(summary()["tolerance"]["step"].get<double>(), coarse);
    EXPECT_EQ(rows().size(), 11u) << "the rows stay";
    EXPECT_THAT(run_dttmm(folder_.path(), {"check", "model.toml"}).out, HasSubstr("within 10 %"));
}

TEST_F(Tolerance, OnlySelectedChannelsAreJudgedTheOthersKeepTheirPeaks) {
    write_text(folder_ / "model.toml", small_model_with("step = \"5 ms\"", "step = \"5 ms\"\nchannels = [\"two.force.z\"]"));
    ASSERT_EQ(run({"model.toml", "--tolerance", "0.1 %"}).code, 0);
    const nlohmann::json result = summary();
    EXPECT_EQ(result["tolerance"]["error_estimate"].size(), 1u);
    EXPECT_EQ(result["tolerance"]["levels"].back()["worst_channel"], "two.force.z");
    EXPECT_GT(result["elements"]["one"]["force"]["z"]["peak"].get<double>(), 10);
    EXPECT_EQ(rows()[0].size(), 2u);
}

TEST_F(Tolerance, WrongTolerancesAreRefused) {
    for (const char* wrong : {"0", "-1 %", "nan", "2", "3 kg", "0,1 %", "fast"}) {
        const Ended ended = run({"model.toml", std::string("--tolerance=") + wrong});
        EXPECT_EQ(ended.code, 3) << wrong;
        EXPECT_THAT(ended.err, StartsWith("--tolerance: tolerance")) << wrong;
    }
    EXPECT_FALSE(fs::exists(folder_ / "out"));
}

// Oracle: a case is the run with its values, the tolerance included; another tolerance is computed anew.
TEST_F(Tolerance, ASweepPassesItOn) {
    const std::vector<std::string> words = {"model.toml", "--sweep", "mass=1 kg..5 kg:3", "-j", "2", "--tolerance"};
    const auto sweep = [&](const std::string& tolerance) {
        std::vector<std::string> all = words;
        all.push_back(tolerance);
        return run(all);
    };
    ASSERT_EQ(sweep("0.1 %").code, 0);
    ASSERT_EQ(
        run_dttmm(folder_.path(), {"run", "model.toml", "-o", "alone", "--set", "mass=3 kg", "--tolerance", "0.1 %"}).code,
        0);
    EXPECT_EQ(read_text(folder_ / "out/case-000002/history.csv"), read_text(folder_ / "alone/history.csv"));
    EXPECT_THAT(sweep("0.1 %").out, HasSubstr("(3 of them reused)"));
    EXPECT_THAT(sweep("1 %").out, HasSubstr("(0 of them reused)"));
}

// Oracle: by hand: a load that jumps between the steps of every run leaves first order.
TEST_F(Tolerance, AJumpIsSeenAsFirstOrder) {
    write_text(folder_ / "model.toml", small_model_with("\"100 N\"", "\"=100*(t > 0.01234567)\""));
    const Ended ended = run({"model.toml", "--tolerance", "0.5 %"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_NEAR(summary()["tolerance"]["observed_order"].get<double>(), 1, 0.3);
}

// Oracle: first order from 1 ms needs a step of 1e-12 s or so for 1e-9: out of reach.
TEST_F(Tolerance, WhatCannotBeReachedIsSaidAndTheBestIsKept) {
    write_text(folder_ / "model.toml", small_model_with("\"100 N\"", "\"=100*(t > 0.01234567)\""));
    const Ended ended = run({"model.toml", "--tolerance", "1e-8"});
    EXPECT_EQ(ended.code, 4);
    EXPECT_THAT(ended.err, AllOf(HasSubstr("the tolerance of 1e-06 % is not reached after 12 halvings"),
                                 HasSubstr("channel \""), HasSubstr("11 rows recorded")));
    EXPECT_EQ(rows().size(), 11u);
    EXPECT_EQ(summary()["status"], "failed");
    EXPECT_EQ(summary()["tolerance"]["reached"], false);
    EXPECT_EQ(summary()["tolerance"]["levels"].size(), 13u);
    EXPECT_EQ(read_dataset(folder_ / "out/history.h5", "one.force.z.error").size(), 11u);
}

// Oracle: the same plate, implicit: an explicit run to a tolerance begins where it is stable and ends at the same forces.
TEST_F(Tolerance, AnExplicitRunBeginsAtAStableStep) {
    const std::vector<std::string> common = {kStiff, "--duration", "20 ms", "--tolerance", "1 %"};
    std::vector<std::string> words = common;
    words.insert(words.end(), {"--coupling", "explicit"});
    const Ended ended = run(words);
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("would diverge at a step of 0.001 s; beginning with 5e-05 s"));
    EXPECT_EQ(rows().size(), 21u);
    const double peak = summary()["elements"]["bolt1"]["force"]["z"]["peak"];
    ASSERT_EQ(run(common).code, 0);
    EXPECT_NEAR(summary()["elements"]["bolt1"]["force"]["z"]["peak"].get<double>(), peak, 0.02 * peak);
}

// Oracle: by hand: 4 histories x 1e6 rows x more than 60 numbers x 8 bytes.
TEST_F(Tolerance, MoreThanMemoryHoldsIsRefusedWithTheCure) {
    const Ended ended = run({kPlate, "--tolerance", "1 %", "--duration", "1e4 s"});
    EXPECT_EQ(ended.code, 6);
    EXPECT_THAT(ended.err, AllOf(HasSubstr("longer step or fewer channels"), HasSubstr("1e+07 rows")));
    EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(Tolerance, AFailingRunKeepsWhatItHas) {
    write_text(folder_ / "faulty.toml", faulty_model());
    const Ended ended =
        run({"faulty.toml", "--tolerance", "1 %", "--plugin", test::paths::faulty_plugins() + "/nan_at_step_1000.so"});
    EXPECT_NE(ended.code, 0);
    EXPECT_THAT(ended.err, HasSubstr("in the run at a step of 0.001 s"));
    EXPECT_GT(rows().size(), 10u);
    EXPECT_EQ(summary()["status"], "failed");
    EXPECT_EQ(summary()["tolerance"]["levels"].size(), 0u);
}

// Oracle: by hand: a rotor on a free hinge turns 4 rad in 1 ms, more than half a turn, and 2 rad in half of it: there its
// spin is the same at any step.
TEST_F(Tolerance, ARunBeginsAtAStepThatFindsTheMotion) {
    const std::string model = R"(format = "dttmm/1"
simulation = { duration = "10 ms", step = "1 ms" }
output = { step = "1 ms" }
[nodes]
bearing = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
rotor = { position = [0, 0, 0], velocity = [0, 0, 0], angular_velocity = [4000, 0, 0] }
[[element]]
name = "shaft"
type = "elastic_hinge"
from = "bearing"
to = "rotor"
stiffness = { rx = "free" }
[[element]]
name = "disc"
type = "rigid_body"
at = "rotor"
mass = "1 kg"
inertia = { xx = 0.01, yy = 0.005, zz = 0.005 }
)";
    write_text(folder_ / "rotor.toml", model);
    ASSERT_EQ(run({"rotor.toml"}).code, 4);
    const Ended ended = run({"rotor.toml", "--tolerance", "1 %"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("the motion was not found at a step of 0.001 s; it begins with 0.0005 s"));
    EXPECT_EQ(summary()["tolerance"]["first_step"], 0.0005);
    EXPECT_EQ(rows().size(), 11u);
    EXPECT_NEAR(rows().back()[0], 0.01, 1e-12);
}

// Oracle: the exit code of the design. Stopped in the first run its rows are kept; later, the last finished run.
TEST_F(Tolerance, AStoppedRunKeepsItsRows) {
    std::string text = small_model_with("step = \"5 ms\"", "step = \"20 ms\"\nchannels = [\"one.force\"]");
    write_text(folder_ / "model.toml", text.replace(text.find("50 ms"), 5, "1e4 s"));
    Process process({"run", "model.toml", "-o", "out", "--tolerance", "1 %"}, folder_.path());
    ASSERT_TRUE(wait_until([&] { return fs::exists(folder_ / "out/.dttmm-results"); }));
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    process.send(SIGINT);
    const Ended ended = process.wait();
    EXPECT_EQ(ended.code, 130) << ended.err;
    EXPECT_THAT(ended.err,
                AllOf(HasSubstr("stopped by the user (in the run at a step of 0.001 s)"), HasSubstr("rows are kept")));
    const auto kept = rows();
    EXPECT_GT(kept.size(), 1u);
    EXPECT_EQ(summary()["status"], "stopped");
    EXPECT_EQ(summary()["rows"], kept.size());
    EXPECT_DOUBLE_EQ(kept.back()[0], 0.02 * static_cast<double>(kept.size() - 1));
}

TEST_F(Tolerance, StoppedLaterItKeepsTheLastFinishedRun) {
    std::string text = small_model_with("\"100 N\"", "\"=100*(t > 0.01234567)\"");
    write_text(folder_ / "model.toml", text.replace(text.find("\"50 ms\""), 7, "\"5 s\""));
    Process process({"run", "model.toml", "-o", "out", "--tolerance", "1e-7"}, folder_.path());  // 20 million steps to go
    ASSERT_TRUE(wait_until([&] { return process.processor_time() > 1.2; }));
    process.send(SIGTERM);
    const Ended ended = process.wait();
    EXPECT_EQ(ended.code, 130) << ended.err;
    EXPECT_EQ(rows().size(), 1001u) << "whole";
    const nlohmann::json tolerance = summary()["tolerance"];
    EXPECT_EQ(tolerance["reached"], false);
    EXPECT_GE(tolerance["levels"].size(), 2u);
    EXPECT_EQ(tolerance["step"], tolerance["levels"].back()["step"]);
    EXPECT_EQ(read_dataset(folder_ / "out/history.h5", "one.force.z.error").back(),
              tolerance["error_estimate"]["one.force.z"]);
}

/// Massless nodes between springs and dampers of random sizes, and a body that moves at the start.
std::string damped_nodes(std::mt19937& dice) {
    const auto uniform = [&](double from, double to) { return std::uniform_real_distribution(from, to)(dice); };
    const auto size = [&](double from, double to) { return std::pow(10, uniform(from, to)); };
    const int nodes = uniform(0, 1) < 0.5 ? 1 : 2;
    std::string text = R"(format = "dttmm/1"
[simulation]
duration = 0.05
[output]
step = 0.001
[nodes]
wall = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
)";
    for (int n = 1; n <= nodes; ++n) text += fmt::format("n{} = [0, 0, 0]\n", n);
    text += fmt::format(R"([[body]]
name = "b"
mass = {}
inertia = [0.01, 0.012, 0.015]
velocity = [{}, {}, 0]
[[load]]
on = "b"
direction = [0, 0, 1]
force = 50
)",
                        size(-1, 1), uniform(-0.5, 0.5), uniform(-0.5, 0.5));
    for (int n = 0; n <= nodes; ++n)
        text += fmt::format(R"([[element]]
name = "s{}"
type = "spring_damper"
from = "{}"
to = "{}"
stiffness = {}
damping = {}
rotational_stiffness = {}
)",
                            n, n == 0 ? "wall" : fmt::format("n{}", n), n == nodes ? "b" : fmt::format("n{}", n + 1),
                            size(3.5, 4.5), size(0, 2), size(1, 3));
    return text;
}

// Oracle: the tolerance itself, reached at a step of a sensible size: vibrations take 4 ms at least, dampers relax in 0.1
// ms. With an acceleration of the first row that is of first order, the worst of them need steps below a microsecond.
TEST_F(Tolerance, IsReachedByMasslessNodesBetweenDampers) {
    constexpr int kMachines = 120;
    std::mt19937 dice(5);
    for (int machine = 0; machine < kMachines; ++machine) {
        write_text(folder_ / "model.toml", damped_nodes(dice));
        const Ended ended = run({"model.toml", "--tolerance", "1 %"});
        ASSERT_EQ(ended.code, 0) << machine << ": " << ended.err;
        EXPECT_EQ(summary()["tolerance"]["reached"], true) << machine;
        EXPECT_GT(summary()["tolerance"]["step"], 5e-6) << machine;
    }
}

}  // namespace
}  // namespace dttmm::host
