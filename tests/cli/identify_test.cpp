// SPDX-License-Identifier: BSD-3-Clause
//
// `dttmm identify` as a user has it: data with secret values go in, the values and what is known of them come out.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <tuple>

#include "cli/measured_models.h"
#include "cli/process.h"

namespace dttmm::host {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Identify : public testing::Test {
protected:
    Ended identify(const std::vector<std::string>& words) const {
        std::vector<std::string> all = {"identify", "model.toml", "-o", "out"};
        all.insert(all.end(), words.begin(), words.end());
        return run_dttmm(folder_.path(), all);
    }
    nlohmann::json found() const { return read_json(folder_ / "out/identify.json"); }
    static double value(const nlohmann::json& json, const std::string& name, size_t solution = 0) {
        return json["solutions"][solution]["parameters"][name]["value"].get<double>();
    }
    static bool covers(const nlohmann::json& json, const std::string& name, double truth) {
        const nlohmann::json& own = json["solutions"][0]["parameters"][name];
        return own["low"].get<double>() < truth && truth < own["high"].get<double>();
    }
    /// Runs the model with other values and keeps the accelerations of the corners as data.csv.
    void measure(const std::vector<std::string>& settings, double noise, unsigned seed = 1,
                 const char* step = "1 ms") const {
        std::vector<std::string> words = {
            "run", "model.toml", "-q", "-o", "secret", "--channels", "plate.corner*.acceleration.z"};
        words.insert(words.end(), {"--step", step, "--output-step", "1 ms"});
        for (const std::string& one : settings) words.insert(words.end(), {"--set", one});
        const Ended ended = run_dttmm(folder_.path(), words);
        ASSERT_EQ(ended.code, 0) << ended.err;
        write_text(folder_ / "data.csv", with_noise(read_text(folder_ / "secret/history.csv"), noise, seed));
    }
    /// The history of the run in secret/, each row (time first) as `change` makes it.
    std::string changed_history(const std::function<void(std::vector<double>& row)>& change) const {
        const std::string history = read_text(folder_ / "secret/history.csv");
        std::string text = history.substr(0, history.find('\n', history.find('\n') + 1) + 1);
        for (std::vector<double> row : read_history(folder_ / "secret/history.csv")) {
            change(row);
            for (size_t c = 0; c < row.size(); ++c) text += fmt::format("{}{:.17g}", c > 0 ? "," : "", row[c]);
            text += "\n";
        }
        return text;
    }
    const TemporaryFolder folder_;
};

// Frequencies and shapes that Georgia Tech measured on a frame of four weighed floors; without shapes six sets of stiffness
// meet the four frequencies exactly. Data: github ywang-structures/Structural-Model-Updating, FourStoryStructure.
constexpr double kFrameMass = 5.4703, kFrameStiffness = 1751.27;
const std::vector<double> kFrameFrequencies = {0.88289843, 2.74773779, 4.29976448, 5.52947434};
constexpr const char* kFrameShapes =
    "mode,f_Hz,floor1,floor2,floor3,floor4\n1,0.88289843,-0.37813,-0.71911,-0.96369,-1.00000\n"
    "2,2.74773779,-1.00000,-0.72017,0.26341,0.83509\n3,4.29976448,1.00000,-0.99711,-0.36039,0.63237\n"
    "4,5.52947434,-0.16876,0.43459,-1.00000,0.69536\n";

// Oracle: the six exact solutions of the inverse problem, found by other means: research of the same data.
TEST_F(Identify, FrequenciesOfAMeasuredFrameHaveSixSolutionsAndAllAreTold) {
    write_text(folder_ / "model.toml", shear_frame({kFrameMass, kFrameMass, kFrameMass, kFrameMass},
                                                   {kFrameStiffness, kFrameStiffness, kFrameStiffness, kFrameStiffness}));
    write_text(folder_ / "data.csv", fmt::format("frequency\nHz\n{}\n", fmt::join(kFrameFrequencies, "\n")));
    const Ended ended = identify({"--measured", "data.csv", "--free", "k1..k4"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("6 sets of values explain the data about equally well"));
    const nlohmann::json json = found();
    const std::vector<std::vector<double>> known = {{.623, .965, 1.130, 1.132}, {.718, .808, .903, 1.469},
                                                    {1.399, .591, .547, 1.701}, {1.850, .419, 1.557, .638},
                                                    {3.179, .497, .525, .927},  {3.256, .433, .758, .719}};
    ASSERT_EQ(json["solutions"].size(), known.size());
    for (const auto& one : known) {
        int matches = 0;
        for (size_t s = 0; s < known.size(); ++s) {
            double worst = 0;
            for (size_t i = 0; i < 4; ++i)
                worst = std::max(worst, std::abs(value(json, fmt::format("k{}", i + 1), s) / kFrameStiffness - one[i]));
            matches += worst < 1e-3;
        }
        EXPECT_EQ(matches, 1) << one[0];
    }
    for (size_t s = 0; s < known.size(); ++s) EXPECT_LT(json["solutions"][s]["chi2"].get<double>(), 1e-16);
    EXPECT_EQ(json["solutions"][0]["points"], 4);
}

// Shapes tell which of the six it is. Oracle: the same fit by other means, k/k0 = .710 .808 .912 1.470, chi2 34.9.
TEST_F(Identify, ShapesTellWhichSolutionIsTrue) {
    write_text(folder_ / "model.toml", shear_frame({kFrameMass, kFrameMass, kFrameMass, kFrameMass},
                                                   {kFrameStiffness, kFrameStiffness, kFrameStiffness, kFrameStiffness}));
    write_text(folder_ / "data.csv", kFrameShapes);
    const Ended ended = identify({"--measured", "data.csv", "--free", "k1..k4"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const nlohmann::json json = found();
    ASSERT_EQ(json["solutions"].size(), 1u);
    const double known[] = {.710, .808, .912, 1.470};
    for (size_t i = 0; i < 4; ++i) EXPECT_NEAR(value(json, fmt::format("k{}", i + 1)) / kFrameStiffness, known[i], 1e-3);
    EXPECT_NEAR(json["solutions"][0]["chi2"].get<double>(), 34.9, 0.05);
    EXPECT_EQ(json["fit"]["degrees_of_freedom"], 20 - 4 - 4) << "each shape has a scale of its own";
    for (const auto& mode : json["modes"]) EXPECT_GT(mode["mac"].get<double>(), 0.99);
    EXPECT_THAT(ended.out, HasSubstr("assumed"));
}

// What was given is not called assumed.
TEST_F(Identify, OnlyTheNoiseThatIsAssumedIsCalledSo) {
    write_text(folder_ / "model.toml", shear_frame({2, 3}, {5000, 4000}));
    const auto noise_of = [&](const char* data) {
        write_text(folder_ / "data.csv", data);
        const Ended ended = identify({"--measured", "data.csv", "--free", "k1,k2"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        const size_t at = ended.out.find("noise of the data");
        return at == std::string::npos ? ended.out : ended.out.substr(at, ended.out.find('\n', at) - at);
    };
    EXPECT_EQ(noise_of("mode,frequency,frequency.deviation,floor1,floor2\n1,4.03,0.01,0.52,1\n2,11.5,0.03,1,-0.35\n"),
              "noise of the data: as given; assumed: 3 % of shapes");
    EXPECT_EQ(noise_of("mode,frequency,floor1,floor2\n1,4.03,0.52,1\n2,11.5,1,-0.35\n"),
              "noise of the data: assumed: 0.5 % of frequencies, 3 % of shapes");
    EXPECT_EQ(noise_of("frequency\n4.03\n11.5\n"), "noise of the data: assumed: 0.5 % of frequencies");
}

// Two storeys whose two frequencies k1, k2 meet as well as 2 k2, k1/2 do: where both are near, one interval holds them.
// Oracle: the profile of chi2 of the closed form.
TEST_F(Identify, IntervalsHoldASecondSolutionNearBy) {
    const double m = 1, k2 = 1e4, noise = 0.005;
    for (const double apart : {1.02, 1.1, 1.16, 1.25, 1.4}) {
        const double k1 = 2e4 * apart;
        const auto frequencies = [&](double a, double b) {
            const double half = (a + 2 * b) / (2 * m), root = std::sqrt(half * half - a * b / (m * m));
            return std::pair(std::sqrt(half - root) / (2 * M_PI), std::sqrt(half + root) / (2 * M_PI));
        };
        const auto [f1, f2] = frequencies(k1, k2);
        const auto profile = [&](double a) {
            double least = std::numeric_limits<double>::infinity();
            for (double b = 5e3; b < 2e4; b *= 1.0002) {
                const auto [g1, g2] = frequencies(a, b);
                least = std::min(least, std::pow((g1 / f1 - 1) / noise, 2) + std::pow((g2 / f2 - 1) / noise, 2));
            }
            return least;
        };
        write_text(folder_ / "model.toml", shear_frame({m, m}, {k1, k2}));
        write_text(folder_ / "data.csv",
                   fmt::format("frequency,frequency.deviation\nHz,Hz\n{:.17g},{:.17g}\n{:.17g},{:.17g}\n", f1, noise * f1,
                               f2, noise * f2));
        const Ended ended = identify({"--measured", "data.csv", "--free", "k1,k2"});
        ASSERT_EQ(ended.code, 0) << ended.err;
        const nlohmann::json json = found();
        for (const auto& solution : json["solutions"])
            for (const char* end : {"low", "high"})
                EXPECT_NEAR(profile(solution["parameters"]["k1"][end].get<double>()) / 3.8415, 1, 0.12)
                    << apart << " " << end;
        for (const auto& solution : json["solutions"])
            EXPECT_TRUE(solution["parameters"]["k1"]["limits_converged"].get<bool>()) << apart;
        EXPECT_EQ(covers(json, "k1", k1) && covers(json, "k1", 2e4), apart < 1.3) << apart;
    }
}

// A stiffness that does not feel its parameter near the file's value, and does 1 % away, where the slope is taken. The
// interval of the slope is 3e9 times too short, more than the search can make up for.
TEST_F(Identify, ASearchForLimitsThatDoesNotConvergeIsTold) {
    std::string model = shear_frame({1}, {1e4});
    model.replace(model.find("\"=k1\""), 4, "\"=k1*(1 + 0.5*max(-1, min(1, ((p - 1)/0.008)^21)))");
    model.insert(model.find("k1 ="), "p = 1\n");
    write_text(folder_ / "model.toml", model);
    const double f = std::sqrt(1e4) / (2 * M_PI);
    write_text(folder_ / "data.csv", fmt::format("frequency,frequency.deviation\nHz,Hz\n{:.17g},{:.17g}\n", f, 1e-11 * f));
    const Ended ended = identify({"--measured", "data.csv", "--free", "p", "--starts", "1"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, AllOf(HasSubstr("The search for the limits of p did not converge: the interval is a guess."),
                                 HasSubstr("limits not converged)")));
    const nlohmann::json own = found()["solutions"][0]["parameters"]["p"];
    EXPECT_FALSE(own["limits_converged"].get<bool>());
    EXPECT_THAT(found()["verdict"].get<std::string>(), HasSubstr("limits of p did not converge"));
}

// Eighteen storeys, three modes at six floors. Data: the same repository, EighteenStoryStructure.
TEST_F(Identify, MoreUnknownsThanDataAreNotPrintedAsKnown) {
    std::vector<double> masses, stiffnesses;
    for (const double weight : {208, 208, 208, 208, 208, 208, 208, 208, 208, 208, 208, 206, 206, 206, 206, 206, 206, 202})
        masses.push_back(1000 * weight / 9.8);
    for (const double k : {1155, 1092, 1073, 1028, 1028, 990, 963, 938, 876, 840, 824, 788, 712, 660, 619, 562, 491, 363})
        stiffnesses.push_back(1e5 * k);
    write_text(folder_ / "model.toml", shear_frame(masses, stiffnesses));
    write_text(folder_ / "data.csv",
               "mode,f_Hz,damping_ratio,floor3,floor6,floor9,floor12,floor15,floor18\n1,0.86518,0.01157,0.19734,0.39201,0."
               "57867,0.75192,0.90247,1.0\n"
               "2,2.68683,0.00428,-0.60842,-0.89503,-0.75114,-0.22072,0.50538,1.0\n3,4.84910,0.00988,0.90396,0.62024,-0."
               "46043,-0.96784,-0.04979,1.0\n");
    const Ended ended = identify({"--measured", "data.csv", "--free", "k1..k18"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, AllOf(HasSubstr("Under-determined"), Not(HasSubstr("k7 ="))));
    const nlohmann::json json = found();
    EXPECT_TRUE(json["underdetermined"].get<bool>());
    for (const auto& [name, own] : json["solutions"][0]["parameters"].items())
        EXPECT_TRUE(own["low"].is_null() && own["high"].is_null()) << name;
}

// Oracle: two frequencies that the frame of other stiffnesses has: three values meet them in a line.
TEST_F(Identify, MoreUnknownsThanDataMeetTheData) {
    write_text(folder_ / "model.toml", shear_frame({1.2, 0.8, 1.7}, {1.3e4, 0.9e4, 2.2e4}));
    const Ended modes = run_dttmm(folder_.path(), {"modes", "model.toml", "--count", "2", "-o", "true"});
    ASSERT_EQ(modes.code, 0) << modes.err;
    const nlohmann::json all = read_json(folder_ / "true/summary.json")["modes"];
    write_text(folder_ / "data.csv", fmt::format("frequency\nHz\n{:.17g}\n{:.17g}\n", all[0]["frequency_hz"].get<double>(),
                                                 all[1]["frequency_hz"].get<double>()));
    write_text(folder_ / "model.toml", shear_frame({1.2, 0.8, 1.7}, {1.7e4, 1.2e4, 1.6e4}));
    const Ended ended = identify({"--measured", "data.csv", "--free", "k1..k3"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("Under-determined: 2 data for 3 unknowns"));
    EXPECT_LT(found()["solutions"][0]["chi2"].get<double>(), 1e-12);
}

// Oracle: the secret values; data without noise give them to rounding, whatever the start.
TEST_F(Identify, ExactHistoriesReturnTheSecretValues) {
    write_text(folder_ / "model.toml", struck_plate());
    measure({"k1=400 N/mm", "k2=520 N/mm", "k3=610 N/mm", "k4=455 N/mm", "c=0.13 N*s/mm"}, 0);
    const Ended ended = identify({"--measured", "data.csv", "--free", "k1..k4,c"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const nlohmann::json json = found();
    const std::pair<const char*, double> truth[] = {{"k1", 4e5}, {"k2", 5.2e5}, {"k3", 6.1e5}, {"k4", 4.55e5}, {"c", 130}};
    for (const auto& [name, secret] : truth) EXPECT_NEAR(value(json, name) / secret, 1, 1e-7) << name;
    ASSERT_EQ(json["solutions"].size(), 1u);
    EXPECT_EQ(json["solutions"][0]["points"], 4 * 501);
}

// Oracle: the secret values lie within the intervals, whose width is that of the Cramer-Rao bound of this test at half the
// duration: 0.3 to 0.5 % in one standard deviation for a second and dampings of their own, less here.
TEST_F(Identify, NoiseGivesIntervalsThatHoldTheSecretValues) {
    write_text(folder_ / "model.toml", struck_plate());
    measure({"k1=400 N/mm", "k3=550 N/mm"}, 0.01, 7);
    for (const std::vector<std::string>& noise : {std::vector<std::string>{}, {"--noise", "0.99 m/s^2"}}) {
        std::vector<std::string> words = {"--measured", "data.csv", "--free", "k1..k4,c"};
        words.insert(words.end(), noise.begin(), noise.end());
        const Ended ended = identify(words);
        ASSERT_EQ(ended.code, 0) << ended.err;
        const nlohmann::json json = found();
        EXPECT_THAT(json["verdict"].get<std::string>(), testing::StartsWith("The model explains the data"));
        EXPECT_EQ(json["fit"]["noise_is_independent"].get<bool>(), !noise.empty());
        const std::pair<const char*, double> truth[] = {{"k1", 4e5}, {"k2", 5e5}, {"k3", 5.5e5}, {"k4", 5e5}, {"c", 100}};
        for (const auto& [name, secret] : truth) {
            EXPECT_NEAR(value(json, name) / secret, 1, 0.015) << name;
            EXPECT_TRUE(covers(json, name, secret)) << name;
            const double deviation = json["solutions"][0]["parameters"][name]["deviation"].get<double>() / secret;
            EXPECT_GT(deviation, 0.001) << name;
            EXPECT_LT(deviation, 0.006) << name;
        }
    }
}

// The step is too long for the motion: identical data fit, but against exact motion the stiffness would be wrong.
TEST_F(Identify, ATimeStepThatShiftsTheAnswerIsTold) {
    write_text(folder_ / "model.toml", struck_plate());
    measure({"k1=400 N/mm"}, 0.01, 1, "0.02 ms");
    EXPECT_THAT(identify({"--measured", "data.csv", "--free", "k1"}).out, HasSubstr("want a smaller --step"));
    EXPECT_GT(std::abs(value(found(), "k1") / 4e5 - 1), 0.01) << "as it says";
    const Ended fine = identify({"--measured", "data.csv", "--free", "k1", "--step", "0.0625 ms"});
    EXPECT_THAT(fine.out, Not(HasSubstr("smaller --step")));
    EXPECT_TRUE(covers(found(), "k1", 4e5));
}

// Oracle: data of a step so small that they are exact: what is wrong with the answer is the shift that is printed.
TEST_F(Identify, TheShiftByTheTimeStepIsThatOfTheAnswer) {
    write_text(folder_ / "model.toml", struck_plate());
    measure({"k1=400 N/mm"}, 0, 1, "0.01 ms");
    ASSERT_EQ(identify({"--measured", "data.csv", "--free", "k1..k4,c", "--step", "0.25 ms", "--starts", "1"}).code, 0);
    const nlohmann::json json = found();
    const std::pair<const char*, double> truth[] = {{"k1", 4e5}, {"k2", 5e5}, {"k3", 5e5}};
    for (const auto& [name, secret] : truth) {
        const double wrong = std::log(value(json, name) / secret);
        ASSERT_GT(std::abs(wrong), 1e-4) << name;
        EXPECT_NEAR(json["shift_by_time_step"][name].get<double>() / wrong, 1, 0.1) << name;
    }
}

// Oracle: a delay d turns a response by exp(-i w d); gain and clock as they are defined.
TEST_F(Identify, GainAndDelayOfResponsesAreFound) {
    write_text(folder_ / "model.toml", shear_frame({2}, {5000}));
    const double k = 4500, delay = 8e-4, gain = 1.07;
    std::string text = "frequency,floor1.position.x.re,floor1.position.x.im\n";
    for (int i = 1; i <= 60; ++i) {
        const double f = 0.2 * i, omega = 2 * std::numbers::pi * f;
        const std::complex<double> H = gain * std::polar(1 / (k - 2 * omega * omega), -omega * delay);
        text += fmt::format("{},{:.17g},{:.17g}\n", f, H.real(), H.imag());
    }
    write_text(folder_ / "data.csv", text);
    ASSERT_EQ(identify({"--measured", "data.csv", "--in", "floor1.x", "--free", "k1", "--nuisance", "gain,delay"}).code, 0);
    EXPECT_NEAR(value(found(), "k1"), k, 1e-4 * k);
    EXPECT_NEAR(value(found(), "delay"), delay, 1e-7);
    EXPECT_NEAR(value(found(), "gain"), gain, 1e-5);
}

// Oracle: planted gain, delay and clock.
TEST_F(Identify, GainDelayAndClockOfTheMeasurementAreFound) {
    write_text(folder_ / "model.toml", struck_plate());
    ASSERT_EQ(run_dttmm(folder_.path(), {"run", "model.toml", "-q", "-o", "secret", "--step", "0.1 ms", "--channels",
                                         "plate.corner*.acceleration.z", "--set", "k1=430 N/mm"})
                  .code,
              0);
    const double gain = 0.93, delay = 7e-4, clock = 1.019;  // true time = clock (time of the file - delay)
    const std::string text = changed_history([&](std::vector<double>& row) {
        for (double& value : row) value *= gain;
        row[0] = row[0] / gain / clock + delay;
    });
    write_text(folder_ / "data.csv", text);
    const Ended ended =
        identify({"--measured", "data.csv", "--free", "k1", "--nuisance", "gain,delay,clock", "--step", "0.1 ms"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const nlohmann::json json = found();
    EXPECT_NEAR(value(json, "k1"), 4.3e5, 1e-4 * 4.3e5);
    EXPECT_NEAR(value(json, "gain"), gain, 1e-4);
    EXPECT_NEAR(value(json, "delay"), delay, 1e-6);
    EXPECT_NEAR(value(json, "clock"), clock, 1e-4);
}

// Three blows in three files: their scatter is the noise, and chi2 judges by it. Oracle: the noise that was added, through
// the root of 3; the secret values.
TEST_F(Identify, RepeatsGiveTheNoise) {
    write_text(folder_ / "model.toml", struck_plate());
    std::vector<std::string> words = {"--free", "k1,k2", "--starts", "1"};
    double largest = 0;
    for (const unsigned seed : {21U, 22U, 23U}) {
        measure({"k1=450 N/mm"}, 0.02, seed);
        const std::string name = fmt::format("blow{}.csv", seed);
        std::filesystem::rename(folder_ / "data.csv", folder_ / name);
        words.insert(words.end(), {"--measured", name});
    }
    for (const auto& row : read_history(folder_ / "secret/history.csv"))
        for (size_t c = 1; c < row.size(); ++c) largest = std::max(largest, std::abs(row[c]));
    const Ended ended = identify(words);
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("plate.corner1.acceleration.z: the mean of 3 repeats is used"));
    const nlohmann::json json = found();
    EXPECT_THAT(json["verdict"].get<std::string>(), testing::StartsWith("The model explains the data"));
    EXPECT_TRUE(json["fit"]["noise_is_independent"].get<bool>());
    for (const nlohmann::json& channel : json["data"]) {
        EXPECT_EQ(channel["noise_from"], "data");
        EXPECT_EQ(channel["points"], 501);
        EXPECT_NEAR(channel["noise"].get<double>() * std::sqrt(3) / (0.02 * largest), 1, 4 / std::sqrt(2 * 1002));
    }
    for (const auto& [name, truth] : {std::pair("k1", 4.5e5), std::pair("k2", 5e5)}) {
        const double deviation = json["solutions"][0]["parameters"][name]["deviation"].get<double>();
        EXPECT_NEAR(value(json, name), truth, 3.3 * deviation) << name << ", one draw in a thousand";
        EXPECT_LT(deviation / truth, 0.006) << name;
    }
    write_text(folder_ / "model.toml", struck_plate("plate.corner3"));
    EXPECT_THAT(identify(words).out, testing::StartsWith("No set of values explains the data"));
}

// Modes of two tests, in another order of columns. Oracle: the same modes written as their means, with their noise, by hand.
TEST_F(Identify, ModesOfTwoTestsAreRepeats) {
    write_text(folder_ / "model.toml", shear_frame({2, 3}, {5000, 4000}));
    write_text(folder_ / "a.csv", "mode,f_Hz,floor1,floor2\n1,4.031,0.52,1\n2,11.48,1,-0.35\n");
    write_text(folder_ / "b.csv", "mode,f_Hz,floor2,floor1\n1,4.036,-1,-0.516\n2,11.455,-0.342,1\n");
    ASSERT_EQ(identify({"--measured", "a.csv", "--measured", "b.csv", "--free", "k1,k2"}).code, 0);
    const nlohmann::json both = found();
    EXPECT_EQ(both["solutions"][0]["points"], 2 + 4);
    write_text(folder_ / "mean.csv", fmt::format("mode,f_Hz,floor1,floor2\n1,{:.12g},0.518,1\n2,{:.12g},1,-0.346\n",
                                                 std::sqrt(4.031 * 4.036), std::sqrt(11.48 * 11.455)));
    const double scatter = std::sqrt((std::pow(std::log(4.036 / 4.031), 2) + std::pow(std::log(11.48 / 11.455), 2)) / 4);
    ASSERT_EQ(identify({"--measured", "mean.csv", "--free", "k1,k2", "--noise",
                        fmt::format("{:.12g} %", 100 * scatter / std::sqrt(2))})
                  .code,
              0);
    const nlohmann::json mean = found();
    EXPECT_NEAR(both["solutions"][0]["chi2"].get<double>() / mean["solutions"][0]["chi2"].get<double>(), 1, 1e-5);
    EXPECT_EQ(both["data"][0]["noise_from"], "data");
    for (const char* name : {"k1", "k2"}) {
        EXPECT_NEAR(value(both, name) / value(mean, name), 1, 1e-6) << name;
        // Student's quantile of 2 differences instead of the normal one
        const auto width = [&](const nlohmann::json& of) {
            const nlohmann::json& own = of["solutions"][0]["parameters"][name];
            return std::log(own["high"].get<double>() / own["low"].get<double>());
        };
        EXPECT_NEAR(width(both) / width(mean), 4.30265 / 1.95996, 0.1) << name;
    }
}

// Three masses on two springs, free: f² = (a ± √(a² − b)) / 8π² of masses 2, 3, 4 kg. A test numbers its modes from 1 on,
// the model has the first one at 0 Hz. Oracle: closed form of the secret values.
TEST_F(Identify, ModesOfAFreeMachineArePairedAboveZero) {
    const double m[] = {2, 3, 4}, k1 = 6000, k2 = 3500;
    write_text(folder_ / "model.toml", R"(format = "dttmm/1"
dofs = ["x", "y", "z"]
[parameters]
k1 = 5000
k2 = 4000
[[body]]
name = "a"
mass = 2
inertia = [1, 1, 1]
[[body]]
name = "b"
mass = 3
inertia = [1, 1, 1]
[[body]]
name = "c"
mass = 4
inertia = [1, 1, 1]
[[element]]
name = "ab"
type = "spring_damper"
from = "a"
to = "b"
stiffness = ["=k1", 0, 0]
[[element]]
name = "bc"
type = "spring_damper"
from = "b"
to = "c"
stiffness = ["=k2", 0, 0]
)");
    const double sum = k1 / m[0] + (k1 + k2) / m[1] + k2 / m[2];
    const double product = k1 * k2 * (m[0] + m[1] + m[2]) / (m[0] * m[1] * m[2]), root = std::sqrt(sum * sum / 4 - product);
    std::string shapes = "mode,frequency,a.x,b.x,c.x\n", numbers = "mode,frequency\n";
    for (const double square : {sum / 2 - root, sum / 2 + root}) {
        const double f = std::sqrt(square) / (2 * M_PI), b = 1 - m[0] * square / k1, c = b * k2 / (k2 - m[2] * square);
        shapes += fmt::format("{},{:.17g},1,{:.17g},{:.17g}\n", shapes.size() < 30 ? 1 : 2, f, b, c);
        numbers += fmt::format("{},{:.17g}\n", numbers.size() < 20 ? 8 : 9, f);
    }
    write_text(folder_ / "shapes.csv", shapes);
    write_text(folder_ / "numbers.csv", numbers);
    for (const char* file : {"shapes.csv", "numbers.csv"}) {
        const Ended ended = identify({"--measured", file, "--free", "k1,k2"});
        ASSERT_EQ(ended.code, 0) << ended.err;
        EXPECT_EQ(found()["modes"][0]["mode"], 8) << file << ended.out;
        EXPECT_EQ(found()["modes"][1]["mode"], 9) << file;
        if (file[0] == 'n') continue;  // two frequencies alone have two solutions
        EXPECT_NEAR(value(found(), "k1") / k1, 1, 1e-6) << ended.out;
        EXPECT_NEAR(value(found(), "k2") / k2, 1, 1e-6);
    }
    write_text(folder_ / "wrong.csv", "frequency\n8\n12\n");
    const Ended wrong = identify({"--measured", "wrong.csv", "--free", "k1,k2"});
    EXPECT_NE(wrong.code, 0);
    EXPECT_THAT(wrong.err, HasSubstr("mode 1 of the model has 0 Hz"));
}

// A recorder whose clock is 1.9 % off, and hum in every channel. Oracle: planted clock and stiffness; without the hum the
// model does not explain the data.
TEST_F(Identify, TheClockIsFoundFromMainsHum) {
    const std::string plain = struck_plate(), hum = "[measured]\nhum = \"50 Hz\"\n";
    write_text(folder_ / "model.toml", plain);
    ASSERT_EQ(run_dttmm(folder_.path(), {"run", "model.toml", "-q", "-o", "secret", "--step", "0.2 ms", "--duration",
                                         "1.5 s", "--channels", "plate.corner*.acceleration.z", "--set", "k1=430 N/mm"})
                  .code,
              0);
    const double clock = 1.019;  // true time = clock times that of the file
    const std::string text = changed_history([&](std::vector<double>& row) {
        for (size_t c = 1; c < row.size(); ++c)
            row[c] += 0.8 * std::sin(2 * std::numbers::pi * 50 * row[0] + 0.3 + 1.1 * static_cast<double>(c - 1));
        row[0] /= clock;
    });
    write_text(folder_ / "data.csv", with_noise(text, 1e-3, 4));
    const std::vector<std::string> words = {"--measured", "data.csv", "--free", "k1,k2",
                                            "--starts",   "1",        "--step", "0.2 ms"};
    EXPECT_THAT(identify(words).out, testing::StartsWith("No set of values explains"));
    write_text(folder_ / "model.toml", plain + hum);
    const Ended ended = identify(words);
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("the mains hum of 50 Hz is at 50.9"));
    const nlohmann::json json = found();
    // Four times the bound of Cramer and Rao for 7500 samples with a noise of an eighth of the hum, behind Hann's window
    EXPECT_NEAR(json["clock"].get<double>(), clock, 1e-4);
    EXPECT_THAT(json["verdict"].get<std::string>(), testing::StartsWith("The model explains the data"));
    EXPECT_NEAR(value(json, "k1") / 4.3e5, 1, 1e-3);
    EXPECT_NEAR(value(json, "k2") / 5e5, 1, 1e-3);
    write_text(folder_ / "model.toml", plain + hum + "clock = 1.01\n");
    EXPECT_THAT(identify(words).err, HasSubstr("leave out hum or clock"));
}

// Units and signs of the file do not change the answer, by --map or by [measured].
TEST_F(Identify, UnitsSignsAndNamesOfTheFileDoNotMatter) {
    write_text(folder_ / "model.toml", struck_plate());
    measure({"k2=440 N/mm"}, 0.01, 3);
    ASSERT_EQ(identify({"--measured", "data.csv", "--free", "k1,k2"}).code, 0);
    const nlohmann::json plain = found();
    std::string text = "t,ch1,ch2,ch3,ch4\nms,g,,mm/s^2,m/s^2\n";
    for (const auto& row : read_history(folder_ / "data.csv"))
        text += fmt::format("{:.17g},{:.17g},{:.17g},{:.17g},{:.17g}\n", 1e3 * row[0], -row[1] / 9.80665, row[2],
                            1e3 * row[3], row[4]);
    write_text(folder_ / "other.csv", text);
    const auto check = [&](const Ended& ended) {
        ASSERT_EQ(ended.code, 0) << ended.err;
        const nlohmann::json json = found();
        for (const char* name : {"k1", "k2"}) EXPECT_NEAR(value(json, name) / value(plain, name), 1, 1e-6) << name;
    };
    check(identify({"--measured", "other.csv", "--free", "k1,k2", "--map", "ch1 = -plate.corner1.acceleration.z", "--map",
                    "ch2 = plate.corner2.acceleration.z", "--map", "ch3=plate.corner3.acceleration.z", "--map",
                    "ch4=plate.corner4.acceleration.z"}));
    write_text(folder_ / "model.toml", struck_plate() + R"([measured]
file = "other.csv"
channel = [
  { column = "ch1", is = "-plate.corner1.acceleration.z" },
  { column = "ch2", is = "plate.corner2.acceleration.z", unit = "m/s^2" },
  { column = "ch3", is = "plate.corner3.acceleration.z" },
  { column = "ch4", is = "plate.corner4.acceleration.z" },
]
)");
    check(identify({"--free", "k1,k2"}));
}

// The same run as a MAT file and as a universal file.
TEST_F(Identify, FilesOfOtherProgramsGiveTheSameAnswer) {
    write_text(folder_ / "model.toml", struck_plate());
    measure({"k1=400 N/mm"}, 0);
    ASSERT_EQ(run_dttmm(folder_.path(), {"export", "secret", "--mat", "--uff58"}).code, 0);
    for (const char* file : {"secret.mat", "secret.uff"}) {
        const Ended ended = identify({"--measured", file, "--free", "k1,k2", "--starts", "1"});
        ASSERT_EQ(ended.code, 0) << ended.err;
        EXPECT_NEAR(value(found(), "k1"), 4e5, 1e-4 * 4e5) << file;
        EXPECT_EQ(found()["solutions"][0]["points"], 4 * 501) << file;
    }
}

// Responses of `dttmm response` go in as they came out. Oracle: the secret values, from far away: the logarithm leads there.
TEST_F(Identify, ExactResponsesReturnTheSecretValues) {
    write_text(folder_ / "model.toml", struck_plate());
    ASSERT_EQ(run_dttmm(folder_.path(), {"response",
                                         "model.toml",
                                         "-q",
                                         "-o",
                                         "secret",
                                         "--in",
                                         "plate.corner1.z",
                                         "--out",
                                         "plate.corner[123].acceleration.z",
                                         "--from",
                                         "20 Hz",
                                         "--to",
                                         "180 Hz",
                                         "--points",
                                         "80",
                                         "--set",
                                         "k1=250 N/mm",
                                         "--set",
                                         "k2=900 N/mm",
                                         "--set",
                                         "c=0.03 N*s/mm"})
                  .code,
              0);
    const Ended ended = identify({"--measured", "secret/response.csv", "--in", "plate.corner1.z", "--free", "k1..k4,c"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const nlohmann::json json = found();
    const std::pair<const char*, double> truth[] = {{"k1", 2.5e5}, {"k2", 9e5}, {"k3", 5e5}, {"k4", 5e5}, {"c", 30}};
    for (const auto& [name, secret] : truth) EXPECT_NEAR(value(json, name) / secret, 1, 1e-7) << name;
    EXPECT_EQ(identify({"--measured", "secret/response.csv", "--free", "k1"}).code, 2) << "what drove it is not said";
}

// At a driving point the response and the force have one node and direction. Oracle: the secret value.
TEST_F(Identify, TheForceAtADrivingPointHasThePlaceOfTheResponse) {
    write_text(folder_ / "model.toml", struck_plate());
    ASSERT_EQ(run_dttmm(folder_.path(), {"response", "model.toml", "-q", "-o", "secret", "--in", "plate.corner1.z", "--out",
                                         "plate.corner[12].acceleration.z", "--from", "20 Hz", "--to", "180 Hz", "--points",
                                         "80", "--set", "k1=400 N/mm"})
                  .code,
              0);
    ASSERT_EQ(run_dttmm(folder_.path(), {"export", "secret", "--uff58"}).code, 0);
    const Ended own = identify({"--measured", "secret.uff", "--free", "k1", "--starts", "1"});
    ASSERT_EQ(own.code, 0) << own.err;
    EXPECT_NEAR(value(found(), "k1"), 4e5, 1e-6 * 4e5);
    // The file of another program has numbers of nodes and no names of the model
    std::string text = read_text(folder_ / "secret.uff");
    for (size_t at = 0; (at = text.find("plate.corner", at)) != std::string::npos;) text.replace(at, 12, "sensorAtPlac");
    write_text(folder_ / "other.uff", text);
    const Ended other = identify({"--measured", "other.uff", "--free", "k1", "--starts", "1", "--map",
                                  "2.z = plate.corner1.acceleration.z", "--map", "3.z = plate.corner2.acceleration.z"});
    ASSERT_EQ(other.code, 0) << other.err;
    EXPECT_NEAR(value(found(), "k1"), 4e5, 1e-6 * 4e5);
}

// Oracle: without the shape the answer is that of a file that has nothing at these sensors.
TEST_F(Identify, AShapeOfZerosIsLeftOutWithAWord) {
    write_text(folder_ / "model.toml", shear_frame({1.2, 0.8, 1.7}, {1.3e4, 0.9e4, 2.2e4}));
    const auto identify_with = [&](const char* second) {
        write_text(folder_ / "data.csv", fmt::format("mode,f_Hz,floor1,floor2,floor3\n1,7.1,0.39,0.86,1\n2,21.9,{}\n"
                                                     "3,36.7,-0.23,1,-0.34\n",
                                                     second));
        return identify({"--measured", "data.csv", "--free", "k1..k3", "--starts", "1"});
    };
    const Ended zero = identify_with("0,0,0");
    ASSERT_EQ(zero.code, 0) << zero.err;
    EXPECT_THAT(zero.err, AllOf(HasSubstr("1 shape is zero at all sensors, as data.csv:3 of 21.9 Hz: not used"),
                                HasSubstr("taken for the model's mode of its number")));
    const nlohmann::json with_zeros = found();
    EXPECT_EQ(with_zeros["warnings"][0]["code"], "zero-shapes");
    const Ended empty = identify_with(",,");
    ASSERT_EQ(empty.code, 0) << empty.err;
    EXPECT_THAT(empty.err, Not(HasSubstr("zero")));
    for (const char* name : {"k1", "k2", "k3"}) EXPECT_EQ(value(with_zeros, name), value(found(), name)) << name;
}

// Frequencies where the curves bend are at unequal distances, and stand with the digits that 13 columns hold. Oracle: the
// secret values, and that nothing but rounding is left: no model error is seen in it.
TEST_F(Identify, AnExportedResponseIsExplainedByItsOwnModel) {
    write_text(folder_ / "model.toml", struck_plate());
    ASSERT_EQ(run_dttmm(folder_.path(),
                        {"response", "model.toml", "-q", "-o", "secret", "--in", "plate.corner1.z", "--out",
                         "plate.corner*.acceleration.z", "--from", "1 Hz", "--to", "200 Hz", "--set", "k1=400 N/mm"})
                  .code,
              0);
    ASSERT_EQ(run_dttmm(folder_.path(), {"export", "secret", "--uff58"}).code, 0);
    const Ended ended = identify({"--measured", "secret.uff", "--free", "k1,k2,c", "--starts", "1"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, AllOf(HasSubstr("The model explains the data"), Not(HasSubstr("correlated:"))));
    EXPECT_NEAR(value(found(), "k1"), 4e5, 1e-8 * 4e5);
}

// Oracle: the secret value. Nine digits of the frequencies are asked for, and the file has eleven.
TEST_F(Identify, ExportedModesAreExplainedByTheirOwnModel) {
    write_text(folder_ / "model.toml", struck_plate());
    ASSERT_EQ(
        run_dttmm(folder_.path(), {"modes", "model.toml", "-q", "-o", "secret", "--count", "6", "--set", "k1=400 N/mm"})
            .code,
        0);
    ASSERT_EQ(run_dttmm(folder_.path(), {"export", "secret", "--uff55"}).code, 0);
    std::vector<std::string> words = {"--measured", "secret.uff", "--free", "k1", "--starts", "1", "--noise", "1e-9"};
    for (int node = 1; node <= 5; ++node)
        for (const char* axis : {"x", "y", "z"}) {
            const std::string place = node == 1 ? "plate" : fmt::format("plate.corner{}", node - 1);
            words.insert(words.end(), {"--map", fmt::format("{0}.{1} = {2}.{1}", node, axis, place)});
        }
    const Ended ended = identify(words);
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, HasSubstr("The model explains the data"));
    EXPECT_NEAR(value(found(), "k1"), 4e5, 1e-8 * 4e5);
}

// A machine that moves in z alone: what `dttmm response` wrote of x and y is zero. Oracle: the secret value.
TEST_F(Identify, ResponsesOfZerosAreLeftOut) {
    const auto model = [](double stiffness) {
        std::string text = SprungMasses{{4}, {stiffness}, {20}}.model();
        text.replace(text.find("dofs = [\"z\"]"), 12, "dofs = [\"x\", \"y\", \"z\"]");
        return text.replace(text.find("stiffness = [0, 0"), 17, "stiffness = [9e4, 8e4");
    };
    const auto fit_response_of = [&](const char* channels) {
        write_text(folder_ / "model.toml", model(60000));
        const Ended ended =
            run_dttmm(folder_.path(), {"response", "model.toml", "-q", "-o", "secret", "--in", "b0.z", "--out", channels,
                                       "--from", "4 Hz", "--to", "60 Hz", "--points", "40"});
        EXPECT_EQ(ended.code, 0) << ended.err;
        write_text(folder_ / "model.toml", model(50000));
        return identify({"--measured", "secret/response.csv", "--in", "b0.z", "--free", "s0.stiffness", "--starts", "1"});
    };
    const Ended ended = fit_response_of("b0.acceleration");
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr("2 responses are zero at all frequencies"));
    EXPECT_EQ(found()["solutions"][0]["points"], 2 * 40);
    EXPECT_NEAR(value(found(), "s0.stiffness"), 1.2, 1e-6);
    const Ended none = fit_response_of("b0.acceleration.x");
    EXPECT_EQ(none.code, 5) << none.out;
    EXPECT_THAT(none.err, AllOf(HasSubstr("1 response is zero at all frequencies"), HasSubstr("nothing to fit")));
}

// Equal bolts and a blow at the centre: the direction + - + - shows at second order only, and a mass that nothing uses
// never.
// Descents from the nearest starting points all end in false minima. Oracle: two masses on springs, in closed form.
TEST_F(Identify, ResponsesAreSearchedUntilTheyAreExplained) {
    for (const auto& [file, lower, upper] : {std::tuple(SprungMasses{{15.5, 5.6}, {64000, 252000}, {1.93, 40.25}}, 2.5, 0.3),
                                             {{{9.3, 5.6}, {59000, 75000}, {9.25, 4.89}}, 2.5, 0.3},
                                             {{{8.5, 10.6}, {133000, 148000}, {12.46, 20.48}}, 1.6, 0.4}}) {
        SprungMasses secret = file;
        secret.stiffnesses[0] *= lower;
        secret.stiffnesses[1] *= upper;
        write_text(folder_ / "model.toml", file.model());
        write_text(folder_ / "data.csv", secret.response(80, 0.01, 26));
        const Ended ended = identify({"--measured", "data.csv", "--free", "s0.stiffness,s1.stiffness", "--in", "b0.z",
                                      "--noise", "1 %", "--jobs", "1"});
        ASSERT_EQ(ended.code, 0) << ended.err;
        EXPECT_NEAR(value(found(), "s0.stiffness") / lower, 1, 0.02) << ended.out;
        EXPECT_NEAR(value(found(), "s1.stiffness") / upper, 1, 0.02) << ended.out;
    }
}

TEST_F(Identify, DeadParametersAndFlatDirectionsAreTold) {
    write_text(folder_ / "model.toml", struck_plate("plate"));
    measure({}, 0.01, 5);
    const Ended ended = identify({"--measured", "data.csv", "--free", "k1..k4,idle", "--starts", "3"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const nlohmann::json json = found();
    EXPECT_EQ(json["dead"], nlohmann::json({"idle"}));
    ASSERT_EQ(json["flat_in_file"].size(), 1u);
    EXPECT_THAT(json["flat_in_file"][0].get<std::string>(),
                testing::AnyOf("ln k1 - ln k2 + ln k3 - ln k4", "-ln k1 + ln k2 - ln k3 + ln k4"));
    EXPECT_THAT(ended.out, AllOf(HasSubstr("Nothing that was measured changes with idle"),
                                 HasSubstr("At the file's values the data do not fix")));
}

// One sensor at the centre sees the four bolts alike.
TEST_F(Identify, TiedParametersAreTold) {
    write_text(folder_ / "model.toml", struck_plate("plate"));
    measure({"k1=430 N/mm"}, 0.01, 5);
    const Ended ended =
        identify({"--measured", "data.csv", "--free", "k1..k3", "--starts", "3", "--map",
                  "plate.corner1.acceleration.z=plate.acceleration.z", "--channels", "plate.acceleration.z"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(found()["tied"], nlohmann::json({{"k1", "k2", "k3"}}));
    EXPECT_TRUE(found()["solutions"][0]["parameters"]["k1"]["low"].is_null());
}

TEST_F(Identify, ABoundThatHoldsIsTold) {
    write_text(folder_ / "model.toml", struck_plate());
    measure({"k1=300 N/mm"}, 0.01, 5);
    const Ended ended = identify({"--measured", "data.csv", "--free", "k1,k2", "--bounds", "k1 = 400 N/mm..2"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_EQ(found()["at_bound"], nlohmann::json({"k1"}));
    EXPECT_NEAR(value(found(), "k1"), 4e5, 1e-6);
}

// A prior is one more datum. Oracle: of a normal datum and a normal prior the mean weighted with 1/variance.
TEST_F(Identify, APriorCountsAsOneMoreDatum) {
    write_text(folder_ / "model.toml", shear_frame({2}, {5000}));
    const double measured = 8.5, share = 0.01;
    write_text(folder_ / "data.csv", fmt::format("frequency,frequency.deviation\n{},{}\n", measured, share * measured));
    const double k = 2 * std::pow(2 * std::numbers::pi * measured, 2);
    const Ended ended = identify({"--measured", "data.csv", "--free", "k1", "--prior", "k1 ~ lognormal(5000 N/m, 5 %)"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const double own = std::sqrt(std::log1p(0.05 * 0.05)), mean = std::log(5000) - own * own / 2,
                 datum = 1 / std::pow(2 * share, 2), prior = 1 / (own * own);
    EXPECT_NEAR(std::log(value(found(), "k1")), (datum * std::log(k) + prior * mean) / (datum + prior), 1e-6);
}

// A model that cannot explain the data says so: the frequencies of another machine.
TEST_F(Identify, WhatTheModelCannotExplainIsTold) {
    write_text(folder_ / "model.toml", shear_frame({2, 3, 1.5}, {5000, 7000, 4000}));
    write_text(folder_ / "data.csv", "frequency,frequency.deviation\n5,0.01\n30,0.01\n31,0.01\n");
    const Ended ended = identify({"--measured", "data.csv", "--free", "k1"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    EXPECT_THAT(ended.out, AllOf(HasSubstr("No set of values explains the data"), HasSubstr("measured 30 Hz")));
    EXPECT_FALSE(found()["fit"]["explained"].get<bool>());
}

// Masses and stiffnesses by one factor leave all frequencies as they are: no value is known, also where one ends at a bound.
TEST_F(Identify, AScaleThatTheDataCannotShowIsNoValue) {
    std::string model = shear_frame({2, 3}, {5000, 7000});
    model.replace(model.find("mass = 2"), 8, "mass = \"=m\"");
    model.replace(model.find("mass = 3"), 8, "mass = \"=1.5*m\"");
    model.replace(model.find("[parameters]\n"), 13, "[parameters]\nm = \"2 kg\"\n");
    write_text(folder_ / "model.toml", model);
    ASSERT_EQ(run_dttmm(folder_.path(),
                        {"modes", "model.toml", "-q", "-o", "secret", "--set", "k1=3000 N/m", "--set", "k2=8000 N/m"})
                  .code,
              0);
    const Ended ended = identify({"--measured", "secret/modes.csv", "--free", "k1,k2,m", "--starts", "12"});
    ASSERT_EQ(ended.code, 0) << ended.err;
    const nlohmann::json json = found();
    EXPECT_GE(json["flat"].size(), 1u) << ended.out;
    EXPECT_EQ(json["solutions"].size(), 1u) << "a continuum is no list of solutions";
    for (const auto& [name, own] : json["solutions"][0]["parameters"].items())
        EXPECT_TRUE(own["low"].is_null() && own["high"].is_null()) << name;
}

// A sensor with an offset, and a record too short to judge the model by what is left.
TEST_F(Identify, OffsetsAndRecordsTooShortAreTold) {
    write_text(folder_ / "model.toml", struck_plate());
    measure({"k1=450 N/mm"}, 0.01, 9);
    std::string shifted = "time,plate.corner1.acceleration.z,plate.corner2.acceleration.z\n", cut = shifted;
    for (const auto& row : read_history(folder_ / "data.csv")) {
        shifted += fmt::format("{:.17g},{:.17g},{:.17g}\n", row[0], row[1] + 1.5, row[2]);
        if (row[0] < 0.0155) cut += fmt::format("{:.17g},{:.17g},{:.17g}\n", row[0], row[1], row[2]);
    }
    write_text(folder_ / "shifted.csv", shifted);
    EXPECT_THAT(identify({"--measured", "shifted.csv", "--free", "k1,k2", "--starts", "1"}).out,
                AllOf(testing::StartsWith("No set of values explains"),
                      HasSubstr("What is left of plate.corner1.acceleration.z has a mean")));
    write_text(folder_ / "cut.csv", cut);
    EXPECT_THAT(identify({"--measured", "cut.csv", "--free", "k1", "--starts", "1"}).out,
                AllOf(HasSubstr("cannot be judged"), HasSubstr("give --noise")));
}

// Of one average a coherence is 1 whatever the noise: it would make the data exact. One above 1 is none.
TEST_F(Identify, ACoherenceWantsAverages) {
    write_text(folder_ / "model.toml", shear_frame({2}, {5000}));
    const auto file = [&](double coherence) {
        std::string text = "frequency,floor1.position.x.re,floor1.position.x.im,floor1.position.x.coherence\n";
        for (int i = 1; i <= 40; ++i) {
            const double f = 0.15 * i, h = 1 / (4500 - 2 * std::pow(2 * std::numbers::pi * f, 2));
            text += fmt::format("{},{:.17g},{:.17g},{}\n", f, h * (1 + 0.002 * ((i * 7) % 5 - 2)),
                                h * 0.002 * ((i * 3) % 5 - 2), coherence);
        }
        write_text(folder_ / "data.csv", text);
        return identify({"--measured", "data.csv", "--in", "floor1.x", "--free", "k1"});
    };
    const Ended one = file(1);
    EXPECT_THAT(one.err, HasSubstr("of one average it is always 1"));
    EXPECT_TRUE(covers(found(), "k1", 4500)) << one.out;
    EXPECT_EQ(file(1.2).code, 5);
}

TEST_F(Identify, RefusesWrongInputWithItsCure) {
    write_text(folder_ / "model.toml", struck_plate());
    measure({}, 0);
    const auto fault = [&](const std::vector<std::string>& words, int code) {
        const Ended ended = identify(words);
        EXPECT_EQ(ended.code, code) << ended.err << ended.out;
        return ended.err;
    };
    const std::string free = "--free";
    EXPECT_THAT(fault({"--measured", "data.csv"}, 2), HasSubstr("--free"));
    EXPECT_THAT(fault({free, "k1"}, 2), HasSubstr("--measured"));
    EXPECT_THAT(fault({"--measured", "none.csv", free, "k1"}, 5), HasSubstr("none.csv"));
    EXPECT_THAT(fault({"--measured", "data.csv", free, "k9"}, 2), HasSubstr("k9"));
    EXPECT_THAT(fault({"--measured", "data.csv", free, "k1,k1"}, 2), HasSubstr("twice"));
    EXPECT_THAT(fault({"--measured", "data.csv", free, "bolt7.stiffness"}, 2), HasSubstr("bolt7"));
    EXPECT_THAT(fault({"--measured", "data.csv", free, "k1", "--bounds", "1..1"}, 2), HasSubstr("must differ"));
    EXPECT_THAT(fault({"--measured", "data.csv", free, "k1", "--bounds", "2..3"}, 2), HasSubstr("leave out"));
    EXPECT_THAT(fault({"--measured", "data.csv", free, "k1", "--nuisance", "glue"}, 2), HasSubstr("one of gain"));
    EXPECT_THAT(fault({"--measured", "data.csv", free, "k1", "--noise", "0"}, 2), HasSubstr("more than 0"));
    EXPECT_THAT(fault({"--measured", "data.csv", free, "k1", "--map", "ch9=plate.corner1.acceleration.z"}, 2),
                HasSubstr("ch9"));
    EXPECT_THAT(
        fault({"--measured", "data.csv", free, "k1", "--map", "plate.corner1.acceleration.z=plate.corner2.acceleration.z"},
              2),
        HasSubstr("already"));
    EXPECT_THAT(
        fault({"--measured", "data.csv", free, "k1", "--map", "plate.corner1.acceleration.z=plato.acceleration.z"}, 2),
        HasSubstr("no channel"));
    write_text(folder_ / "wrong.csv", "time,plate.corner1.acceleration.z\ns,kg\n0,1\n0.1,2\n");
    EXPECT_THAT(fault({"--measured", "wrong.csv", free, "k1"}, 5), HasSubstr("wrong.csv"));
    write_text(folder_ / "wrong.csv", "time,plate.corner1.acceleration.z\n0,1\n0.1,1\n0.2,1\n");
    EXPECT_THAT(fault({"--measured", "wrong.csv", free, "k1"}, 5), HasSubstr("constant"));
    write_text(folder_ / "wrong.csv", "time,plat.corner1.acceleration.z\n0,1\n0.1,2\n0.2,1\n");
    EXPECT_THAT(fault({"--measured", "wrong.csv", free, "k1"}, 2), HasSubstr("did you mean"));
}

}  // namespace
}  // namespace dttmm::host
