// SPDX-License-Identifier: BSD-3-Clause
//
// `dttmm modes --mac`.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "cli/modes_run.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

using ::testing::HasSubstr;

/// Two masses along x; the second is a body that may turn about x too, which nothing moves otherwise.
const char* const kTwoInARow = R"(format = "dttmm/1"
dofs = ["x", "rx"]
[nodes]
one = [1, 0, 0]
[[body]]
name = "two"
mass = 3
inertia = [0.2, 1, 1]
markers.end = [0.2, 0, 0]
[[element]]
name = "first"
type = "spring_damper"
from = "ground"
to = "one"
stiffness = 800
rotational_stiffness = 7
[[element]]
name = "second"
type = "spring_damper"
from = "one"
to = "two"
stiffness = 500
rotational_stiffness = 900
[[element]]
name = "mass"
type = "rigid_body"
at = "one"
mass = 2
inertia = { xx = 0.1, yy = 1, zz = 1 }
)";

class GivenShapesOfModes : public ::testing::Test {
protected:
    Ended modes(const std::string& model, const std::string& shapes, std::vector<std::string> words = {}) {
        write_text(folder_ / "model.toml", model);
        write_text(folder_ / "given.csv", shapes);
        words.insert(words.begin(), {"modes", "model.toml", "-o", "out", "--mac", "given.csv"});
        return run_dttmm(folder_.path(), words);
    }
    std::string fault(const std::string& shapes, int code = 5) {
        const Ended ended = modes(kTwoInARow, shapes);
        EXPECT_EQ(ended.code, code) << ended.err;
        EXPECT_FALSE(std::filesystem::exists(folder_ / "out"));
        return ended.err;
    }
    const TemporaryFolder folder_;
};

// Oracle: by hand. K u = ω² M u of two masses has the shapes (1, s); with (1, g): (1 + s g)²/((1 + s²)(1 + g²)). Scale does
// not matter, nor whether a channel is a place or an acceleration. A shape of rotations alone is compared with these.
TEST_F(GivenShapesOfModes, TheMacIsTheSquareOfTheCosineByHand) {
    const Ended ended = modes(kTwoInARow,
                              "channel,a,b,turn\n,m,m,rad\none.x,2,0,0\ntwo.acceleration.x,1.4,-3,0\none.rx,0,0,1\n"
                              "two.rotation.x,0,0,1.1\n");
    ASSERT_EQ(ended.code, 0) << ended.err;
    const auto rows = read_history(folder_ / "out/mac.csv");
    ASSERT_EQ(rows.size(), 4u);
    // λ of 2 λ² ·3 − (1300·3 + 500·2) λ + 1300·500 − 500² = 0
    const double half = 4900.0 / 12, root = std::sqrt(half * half - 400000.0 / 6);
    size_t along = 0;
    for (const auto& row : rows) {
        const double lambda = std::pow(2 * M_PI * row[1], 2);
        double s = 0;
        for (const double exact : {half - root, half + root})
            if (std::abs(lambda - exact) < 1e-6 * exact) s = (1300 - 2 * exact) / 500;
        const bool is_along = s != 0;
        along += is_along;
        const auto mac = [&](double x, double y) { return std::pow(x + s * y, 2) / ((1 + s * s) * (x * x + y * y)); };
        EXPECT_NEAR(row[2], is_along ? mac(2, 1.4) : 0, 1e-9);
        EXPECT_NEAR(row[3], is_along ? mac(0, -3) : 0, 1e-9);
        if (is_along) {
            EXPECT_NEAR(row[4], 0, 1e-9);
        }
    }
    EXPECT_EQ(along, 2u);
    EXPECT_THAT(ended.out, HasSubstr("MAC with the shapes of given.csv"));
    EXPECT_THAT(ended.out, HasSubstr("turn is most like mode"));
    EXPECT_EQ(read_json(folder_ / "out/summary.json")["mac"]["shapes"].size(), 3u);
}

// Oracle: identity. Shapes compared with themselves have 1 where they belong together, of a double mode for both of its
// shapes; along beams as well as at places.
TEST_F(GivenShapesOfModes, OwnShapesAreAlike) {
    for (const char* example : {"hydroplane", "headstock"}) {
        const std::string model =
            (std::filesystem::path(test::paths::source_dir()) / "examples" / example / "model.toml").string();
        ASSERT_EQ(run_dttmm(folder_.path(), {"modes", model, "-q", "-o", "first"}).code, 0);
        for (const char* file : {"modes.csv", "shapes.csv"}) {
            const Ended ended = run_dttmm(
                folder_.path(), {"modes", model, "--json", "-o", "second", "--mac", (folder_ / "first" / file).string()});
            ASSERT_EQ(ended.code, 0) << ended.err;
            const auto json = nlohmann::json::parse(ended.out);
            const auto rows = read_history(folder_ / "second/mac.csv");
            ASSERT_EQ(rows.size(), json["modes"].size());
            for (size_t m = 0; m < rows.size(); ++m) EXPECT_NEAR(rows[m][2 + m], 1, 1e-9) << example << file << m;
        }
    }
}

// Oracle: any mixture of the two shapes of a double mode is a shape of it.
TEST_F(GivenShapesOfModes, AMixtureOfADoubleModeIsAlike) {
    const std::string model = R"(format = "dttmm/1"
dofs = ["y", "z"]
[nodes]
m = [0, 0, 0]
n = [1, 0, 0]
[[element]]
name = "s"
type = "spring_damper"
from = "ground"
to = "m"
stiffness = [0, 900, 900]
[[element]]
name = "t"
type = "spring_damper"
from = "m"
to = "n"
stiffness = [0, 400, 400]
[[element]]
name = "mass"
type = "point_mass"
at = "m"
mass = 2
[[element]]
name = "end"
type = "point_mass"
at = "n"
mass = 1.5
)";
    ASSERT_EQ(modes(model, "channel,x\nm.y,1\n", {"-q"}).code, 0);
    const auto json = modes_of(model);
    const double a = json["modes"][0]["shape"]["m"][1].get<double>(), b = json["modes"][0]["shape"]["n"][1].get<double>(),
                 c = json["modes"][0]["shape"]["m"][2].get<double>(), d = json["modes"][0]["shape"]["n"][2].get<double>();
    const double at_m = std::hypot(a, c), at_n = std::copysign(std::hypot(b, d), a * b + c * d);
    const Ended ended = modes(
        model,
        fmt::format("channel,mixed\nm.y,{}\nn.y,{}\nm.z,{}\nn.z,{}\n", 0.6 * at_m, 0.6 * at_n, -0.8 * at_m, -0.8 * at_n),
        {"-q"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const auto rows = read_history(folder_ / "out/mac.csv");
    ASSERT_EQ(rows.size(), 4u);
    EXPECT_NEAR(rows[0][2], 1, 1e-9);
    EXPECT_NEAR(rows[1][2], 1, 1e-9);
    EXPECT_LT(rows[2][2], 0.9);
}

// Oracle: the wanted responses: file, line, rule and cure.
TEST_F(GivenShapesOfModes, WrongFilesAreRefused) {
    EXPECT_THAT(fault("channel,a\nonw.x,1\n"), HasSubstr("given.csv:2: \"onw.x\" is no place and direction of this model"));
    EXPECT_THAT(fault("channel,a\nonw.x,1\n"), HasSubstr("did you mean \"one.x\"?"));
    EXPECT_THAT(fault("channel,a\none.x,1\ntwo.x,1e\n"), HasSubstr("given.csv:3: \"1e\" is no finite number"));
    EXPECT_THAT(fault("channel,a\none.x,1,2\n"), HasSubstr("given.csv:2: 3 fields, but 2 names"));
    EXPECT_THAT(fault("channel,a\none.x,1\none.position.x,1\n"), HasSubstr("is there twice"));
    EXPECT_THAT(fault("channel,a\n"), HasSubstr("given.csv:1: "));
    EXPECT_THAT(fault("mode,frequency,place\n1,1,one\n"), HasSubstr("no column \"ux\""));
    EXPECT_EQ(run_dttmm(folder_.path(), {"modes", "model.toml", "-o", "out", "--mac", "nowhere.csv"}).code, 5);
}

}  // namespace
}  // namespace dttmm::host
