// SPDX-License-Identifier: BSD-3-Clause
//
// What a run tells of its steps: dttmm run --trace, and the worst step in summary.json.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "cli/process.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

/// A file of a trace: names, units, rows of texts. No field but the last holds a comma.
struct Trace {
    explicit Trace(const fs::path& path) {
        std::istringstream in(read_text(path));
        std::getline(in, names);
        std::getline(in, units);
        for (std::string line; std::getline(in, line);) {
            std::istringstream fields(line);
            rows.emplace_back();
            for (std::string field; rows.back().size() < 12 && std::getline(fields, field, ',');)
                rows.back().push_back(field);
            rows.back().emplace_back();
            std::getline(fields, rows.back().back());
        }
    }
    double number(size_t row, size_t column) const { return std::stod(rows[row][column]); }

    std::string names, units;
    std::vector<std::vector<std::string>> rows;
};

enum : size_t {
    kStep,
    kTime,
    kStepSize,
    kPasses,
    kFactorisations,
    kInsideFactorisations,
    kCorrection,
    kResidual,
    kInside,
    kInsideResidual,
    kRate,
    kStops,
    kWaited
};

/// A beam from the wall to a body that falls onto its bending, undamped.
std::string beam_and_body(const std::string& simulation) {
    return "format = \"dttmm/1\"\n[simulation]\n" + simulation + R"(
gravity = [0, 0, -9.81]
[nodes]
root = { position = [0, 0, 0], fixed = ["x", "y", "z", "rx", "ry", "rz"] }
[[body]]
name = "load"
mass = 2
box = [0.1, 0.1, 0.1]
position = [0.8, 0, 0]
[[element]]
name = "beam"
type = "beam"
from = "root"
to = "load"
segments = 5
section = { circle = "12 mm" }
material = { E = "210 GPa", poisson = 0.3, density = "7850 kg/m^3" }
)";
}

// Oracle: the counts of the run's summary, and the rows among themselves.
TEST(TraceOption, TellsHowEveryStepWasFound) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", beam_and_body("step = 1e-3\nduration = 0.3"));
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--trace", "steps.csv"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const Trace trace(folder / "steps.csv");
    EXPECT_EQ(trace.names,
              "step,time,step_size,passes,factorisations,inside_factorisations,correction,residual,inside_correction,"
              "inside_residual,rate,stops,waited_for");
    EXPECT_EQ(trace.units, "1,s,s,1,1,1,m/s,N*s,m/s,N*s,1,1,");
    const nlohmann::json summary = read_json(folder / "out/summary.json");
    ASSERT_EQ(trace.rows.size(), summary["steps"].get<size_t>() + 1) << "one beyond the last row";
    double passes = 0, factorisations = 0, most = 0;
    for (size_t n = 0; n < trace.rows.size(); ++n) {
        EXPECT_EQ(trace.number(n, kStep), n);
        EXPECT_NEAR(trace.number(n, kTime), 1e-3 * static_cast<double>(n), 1e-12);
        EXPECT_EQ(trace.number(n, kStepSize), 1e-3);
        passes += trace.number(n, kPasses);
        factorisations += trace.number(n, kFactorisations);
        most = std::max(most, trace.number(n, kPasses));
        EXPECT_EQ(trace.rows[n][kWaited].empty(), trace.number(n, kPasses) == 1) << n;
        EXPECT_EQ(trace.number(n, kStops), 0);
        EXPECT_LE(trace.number(n, kInsideFactorisations), 1) << "it bends little: " << n;
    }
    EXPECT_EQ(trace.number(0, kInsideFactorisations), 1);
    EXPECT_EQ(passes, summary["coupling"]["passes"]);
    EXPECT_EQ(factorisations, summary["coupling"]["factorisations"]);
    const nlohmann::json& worst = summary["worst_step"];
    const auto row = worst["step"].get<size_t>();
    EXPECT_EQ(worst["passes"], most);
    EXPECT_EQ(trace.number(row, kPasses), most);
    for (size_t n = 0; n < row; ++n) EXPECT_LT(trace.number(n, kPasses), most) << "the first of them";
    EXPECT_THAT(worst["why"].get<std::string>(), testing::AnyOf(HasSubstr("times the one before"), HasSubstr("fell fast")));
    EXPECT_THAT(worst["waited_for"].get<std::string>(),
                testing::AnyOf("body \"load\" on element \"beam\"", "element \"beam\" (plugin built in)"));
}

// Oracle: a double pendulum, whose lower hinge turns against the upper bar by far more than 0.01 rad; and the one equation
// of a body on a spring, in which a speed counts √2 times: (m + h² k/4) δ = r.
TEST(TraceOption, CountsMatricesInsideAndTheMomentumThatLacks) {
    const TemporaryFolder folder;
    write_text(folder / "pendulum.toml", R"(format = "dttmm/1"
[simulation]
step = 5e-3
duration = 0.5
gravity = [0, 0, -9.81]
[nodes]
top = [0, 0, 0]
end = [0.6, 0, 0]
below = [0.6, 0, 0]
centre = [0.6, 0, -0.3]
[[element]]
name = "hinge"
type = "elastic_hinge"
from = "ground"
to = "top"
stiffness.ry = "free"
[[element]]
name = "bob"
type = "rigid_body"
at = ["top", "end"]
mass = 2
inertia = { xx = 0.1, yy = 0.1, zz = 0.1 }
[[element]]
name = "knee"
type = "elastic_hinge"
from = "end"
to = "below"
stiffness.ry = "free"
[[element]]
name = "shank"
type = "rigid_body"
at = ["below", "centre"]
mass = 1
inertia = { xx = 0.03, yy = 0.03, zz = 0.03 }
)");
    ASSERT_EQ(run_dttmm(folder.path(), {"run", "pendulum.toml", "-o", "out", "--trace", "steps.csv"}).code, 0);
    const Trace pendulum(folder / "steps.csv");
    double matrices = 0;
    for (size_t n = 0; n < pendulum.rows.size(); ++n) matrices += pendulum.number(n, kInsideFactorisations);
    EXPECT_GT(matrices, 50);

    write_text(folder / "body.toml", R"(format = "dttmm/1"
[simulation]
step = 1e-3
duration = 0.05
[[body]]
name = "b"
mass = 2
inertia = [1, 1, 1]
velocity = [0, 0, 3]
[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "b"
stiffness = 4e6
)");
    ASSERT_EQ(run_dttmm(folder.path(), {"run", "body.toml", "-o", "out", "--trace", "steps.csv"}).code, 0);
    const Trace body(folder / "steps.csv");
    int compared = 0;
    for (size_t n = 1; n < body.rows.size(); ++n) {
        if (body.number(n, kResidual) < 1e-10) continue;
        ++compared;
        EXPECT_NEAR(body.number(n, kResidual) / body.number(n, kCorrection), (2 + 1e-6 * 4e6 / 4) / std::sqrt(2), 0.03) << n;
    }
    EXPECT_GT(compared, 30);
}

// Oracle: the step named by the error, which stops at 50 passes.
TEST(TraceOption, KeepsTheStepThatFails) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", R"(format = "dttmm/1"
[simulation]
step = 0.02
duration = 2
[[body]]
name = "rotor"
mass = 1
inertia = { xx = 0.01, yy = 0.02, zz = 0.03 }
angular_velocity = [40, 80, 1]
markers.rim = [0.3, 0.1, 0.2]
[[element]]
name = "post"
type = "spring_damper"
from = "ground"
to = "rotor.rim"
stiffness = 3e5
)");
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--trace", "steps.csv"});
    ASSERT_EQ(ended.code, 4) << ended.err;
    const Trace trace(folder / "steps.csv");
    ASSERT_FALSE(trace.rows.empty());
    std::ostringstream time;
    time << "t = " << trace.number(trace.rows.size() - 1, kTime) << " s";
    EXPECT_THAT(ended.err, HasSubstr(time.str()));
    EXPECT_EQ(trace.number(trace.rows.size() - 1, kPasses), 50) << ended.err;
    EXPECT_EQ(trace.rows.back()[kWaited], "\"body \"\"rotor\"\" on element \"\"post\"\"\"");
}

TEST(TraceOption, HasAllRunsToATolerance) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", beam_and_body("step = 2e-3\nduration = 0.1\ntolerance = \"5 %\""));
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--trace", "steps.csv"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const Trace trace(folder / "steps.csv");
    std::map<double, size_t, std::greater<>> count;
    for (size_t n = 0; n < trace.rows.size(); ++n) ++count[trace.number(n, kStepSize)];
    const nlohmann::json levels = read_json(folder / "out/summary.json")["tolerance"]["levels"];
    ASSERT_EQ(count.size(), levels.size());
    size_t level = 0;
    for (const auto& [step, rows] : count) {
        EXPECT_EQ(step, levels[level]["step"]);
        EXPECT_EQ(rows, levels[level]["steps"].get<size_t>() + 1) << "one beyond the last row";
        ++level;
    }
}

TEST(TraceOption, IsForOneRunAndAFileThatCanBeWritten) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", beam_and_body("step = 1e-3\nduration = 0.01"));
    const Ended sweep = run_dttmm(folder.path(), {"run", "model.toml", "--sweep", "x=1,2", "--trace", "steps.csv"});
    EXPECT_EQ(sweep.code, 2);
    EXPECT_THAT(sweep.err, HasSubstr("--trace is for one run"));
    const Ended nowhere = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out", "--trace", "no/steps.csv"});
    EXPECT_EQ(nowhere.code, 5);
    EXPECT_THAT(nowhere.err, HasSubstr("no/steps.csv: cannot open for writing"));
}

// Half of a correction of one unit in the last place is the correction again: a search that halves it must end.
TEST(TraceOption, ACorrectionThatIsRoundingIsNotHalvedForEver) {
    const TemporaryFolder folder;
    write_text(folder / "model.toml", R"(format = "dttmm/1"
[simulation]
duration = 0.21683845921910663
step = 0.021683845921910663
[[body]]
name = "b0"
density = 16921.433355758552
box = [0.07608962986730869, 0.07896636973130591, 0.10045714993506248]
position = [0.6411103053793618, 0.3635826690469397, 0.017434978794432968]
angular_velocity = [0.28001482860074406, 0.3956933835695285, 0.8546169707834902]
markers = { m3 = [-0.18084574777884305, 0.05176099776629451, -0.07440106305198242] }
[[body]]
name = "b1"
mass = 70.6003578295053
inertia = { xx = 1.078018503218193, yy = 0.5329107278696236, zz = 0.9320648668369151, xy = -0.10029706738914412, xz = -0.09176810806597682, yz = -0.13780563565963017 }
position = [-0.3717783760545176, -0.5733826180500012, -0.33937577577111255]
rotation = { axis = [0.8912203704141716, -0.3067560751219843, -0.3341062132534838], angle = -2.340170632310611 }
markers = { m3 = [0.22118948743342332, -0.0980577545509896, -0.0010118551629012486] }
[[element]]
name = "bb"
type = "spring_damper"
from = "b0.m3"
to = "b1.m3"
damping = [32.03094654037087, 23.574897932152904, 18.56514129743172]
rotational_damping = [1.6819413727410357, 0.40350396163490043, 0.7464519946940343]
x = { law = "cubic", stiffness = 8348.984585197566, cubic = 2216927.0390563947 }
)");
    const Ended ended = run_dttmm(folder.path(), {"run", "model.toml", "-o", "out"});
    EXPECT_EQ(ended.code, 4);
    const std::string before = "was not found in ";
    const size_t at = ended.err.find(before);
    ASSERT_NE(at, std::string::npos) << ended.err;
    const int passes = std::stoi(ended.err.substr(at + before.size()));
    EXPECT_GE(passes, 50);
    EXPECT_LE(passes, 50 * 54) << "a number can be halved 53 times until its neighbour is met";
}

}  // namespace
}  // namespace dttmm::host
