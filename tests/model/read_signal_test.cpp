// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_signal.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "model/test_model.h"

namespace dttmm::host {
namespace {

using testing::HasSubstr;

/// A valid model with a load whose force is `force`, on line 15, after parameters on lines 12 to 14.
std::string with_force(const std::string& force, const char* key = "force") {
    return model_with("[parameters]\np = \"2 kN\"\nq = \"3 m\"\n[[load]]\non=\"plate\"\ndirection=[0,0,1]\n" +
                      std::string(key) + " = " + force);
}

Signal signal(const std::string& force) { return parse(with_force(force)).loads.at(0).signal; }
std::string signal_fault(const std::string& force) { return errors_of(with_force(force)); }

// Oracles below: the formulas in signal_shapes.h at points where they are simple.
TEST(ReadSignal, ANumberOrQuantityIsConstant) {
    EXPECT_EQ(signal("5").value(3), 5);
    EXPECT_EQ(signal("\"5 kN\"").value(3), 5000);
    EXPECT_EQ(signal("\"=p\"").value(3), 2000);
    EXPECT_EQ(signal("{ type = \"constant\", value = \"=2*p\" }").value(3), 4000);
}

TEST(ReadSignal, ExpressionsOfTime) {
    EXPECT_NEAR(signal("\"=p*sin(2*pi*50*t)\"").value(0.005), 2000, 1e-9);
    EXPECT_EQ(signal("{ type = \"expression\", value = \"=p*t\" }").value(4), 8000);
    EXPECT_EQ(signal("{ type = \"expression\", value = \"=p\" }").value(4), 2000);
}

TEST(ReadSignal, EveryShapeWithItsDefaults) {
    EXPECT_EQ(signal("{ type = \"step\", to = \"1 kN\", end = \"20 ms\" }").value(0.01), 500);
    EXPECT_EQ(signal("{ type = \"step\", from = 200, to = \"1 kN\", start = 1, end = 3 }").value(2), 600);
    EXPECT_NEAR(signal("{ type = \"haversine\", peak = 8, start = 1, width = 2 }").value(2), 8, 1e-15);
    EXPECT_NEAR(
        signal("{ type = \"pulse\", peak = \"60 kN\", width = \"3 ms\", start = \"10 ms\", period = \"100 ms\", count = 3 }")
            .value(0.2115),
        6e4, 1e-6);
    EXPECT_NEAR(signal("{ type = \"pulse\", peak = 4, width = 2 }").value(1), 4, 1e-15);
    EXPECT_NEAR(
        signal("{ type = \"sine\", amplitude = 3, frequency = \"50 Hz\", phase = \"90 deg\", offset = 1, start = 1 }")
            .value(1.02),
        4, 1e-12);
    EXPECT_EQ(signal("{ type = \"table\", times = [0, \"500 ms\", 1], values = [0, \"1 kN\", 500] }").value(0.25), 500);
}

TEST(ReadSignal, AMomentIsInNewtonMetres) {
    const Load load = parse(with_force("\"5 kN*m\"", "moment")).loads.at(0);
    EXPECT_TRUE(load.is_moment);
    EXPECT_EQ(load.signal.value(0), 5000);
    EXPECT_THAT(errors_of(with_force("\"5 kN\"", "moment")),
                HasSubstr("m.toml:18:10: load number 1: moment: expected a value in N*m"));
}

TEST(ReadSignal, FaultsNameTheKeyAndTheRule) {
    EXPECT_THAT(signal_fault("\"5 kg\""),
                HasSubstr("m.toml:18:9: load number 1: force: expected a value in N, got \"5 kg\""));
    EXPECT_THAT(signal_fault("\"=q\""), HasSubstr("expected a value in N, got \"=q\", which is \"3 m\" (line 14)"));
    EXPECT_THAT(signal_fault("\"=foo(t)\""), HasSubstr("unknown function \"foo\""));
    EXPECT_THAT(signal_fault("\"=1/t\""), HasSubstr("not finite at t = 0"));
    EXPECT_THAT(signal_fault("true"), HasSubstr("expected a number in N, got true or false"));
    EXPECT_THAT(signal_fault("{ to = 3 }"), HasSubstr("missing key \"type\"; one of constant, step"));
    EXPECT_THAT(signal_fault("{ type = \"stpe\" }"), HasSubstr("unknown type \"stpe\" of a signal; did you mean \"step\"?"));
    EXPECT_THAT(signal_fault("{ type = \"step\", to = 1, ende = 2 }"),
                HasSubstr("unknown key \"ende\"; did you mean \"end\"?"));
    EXPECT_THAT(signal_fault("{ type = \"step\", to = 1 }"), HasSubstr("force: missing key \"end\""));
    EXPECT_THAT(signal_fault("{ type = \"step\", to = 1, start = 3, end = 2 }"),
                HasSubstr("end must not lie before start (3 s), got 2 s"));
    EXPECT_THAT(signal_fault("{ type = \"haversine\", peak = 1, width = 0 }"), HasSubstr("width must be > 0 s, got 0"));
    EXPECT_THAT(signal_fault("{ type = \"pulse\", peak = 1, width = 1, count = 2 }"), HasSubstr("missing key \"period\""));
    EXPECT_THAT(signal_fault("{ type = \"pulse\", peak = 1, width = 1, count = 2, period = 0.5 }"),
                HasSubstr("period must be ≥ width (1 s), got 0.5 s"));
    EXPECT_THAT(signal_fault("{ type = \"pulse\", peak = 1, width = 1, count = 2.5, period = 2 }"),
                HasSubstr("count must be a whole number, got 2.5"));
    EXPECT_THAT(signal_fault("{ type = \"sine\", amplitude = 1, frequency = \"314 rad/s\" }"),
                HasSubstr("expected a value in Hz"));
    EXPECT_THAT(signal_fault("{ type = \"table\", times = [0, 1], values = [0, 1, 2] }"),
                HasSubstr("must be of one length, got 2 and 3"));
    EXPECT_THAT(signal_fault("{ type = \"table\", times = [0, 2, 2], values = [0, 1, 2] }"),
                HasSubstr("row 3 (2 s) does not come after row 2 (2 s)"));
    EXPECT_THAT(signal_fault("{ type = \"table\", times = [], values = [] }"), HasSubstr("times wants 1 number, got 0"));
    EXPECT_THAT(signal_fault("{ type = \"table\", file = \"../x.csv\" }"),
                HasSubstr("table file \"../x.csv\" is outside the model folder"));
    EXPECT_THAT(signal_fault("{ type = \"expression\", value = 3 }"),
                HasSubstr("value must be a text that begins with \"=\""));
}

TEST(ReadSignal, ATableFileLiesBesideTheModel) {
    const std::filesystem::path folder = testing::TempDir();
    std::ofstream(folder / "read_signal_test.csv") << "time,force\n0,1\n2,5\n";
    const Model model = parse_model(with_force("{ type = \"table\", file = \"read_signal_test.csv\" }"), folder / "m.toml",
                                    test_catalogue());
    EXPECT_EQ(model.loads.at(0).signal.value(1), 3);
    std::filesystem::remove(folder / "read_signal_test.csv");
}

}  // namespace
}  // namespace dttmm::host
