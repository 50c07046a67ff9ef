// SPDX-License-Identifier: BSD-3-Clause
//
// `dttmm spectrum` against closed forms, against `dttmm modes` and `dttmm response` of the same machine.
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <map>
#include <numbers>
#include <sstream>

#include "cli/modes_run.h"
#include "support/csv_line.h"
#include "support/linear_algebra.h"

namespace dttmm::host {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using Complex = std::complex<double>;
constexpr double kFullTurn = 2 * std::numbers::pi;

/// A CSV file by the names of its columns; texts stay texts.
using Fields = std::vector<std::map<std::string, std::string>>;

Fields read_fields(const fs::path& file) {
    std::istringstream lines(read_text(file));
    std::string line;
    std::getline(lines, line);
    const std::vector<std::string> names = test::split_csv_line(line);
    std::getline(lines, line);
    Fields rows;
    while (std::getline(lines, line)) {
        const std::vector<std::string> cells = test::split_csv_line(line);
        EXPECT_EQ(cells.size(), names.size());
        rows.emplace_back();
        for (size_t c = 0; c < names.size(); ++c) rows.back()[names[c]] = cells[c];
    }
    return rows;
}

double number(const std::map<std::string, std::string>& row, const std::string& name) {
    const auto found = row.find(name);
    EXPECT_NE(found, row.end()) << name;
    return found == row.end() || found->second.empty() ? NAN : std::stod(found->second);
}

class SpectrumOfARun : public ::testing::Test {
protected:
    /// A history that no run has made: channels a [m] and b [N] as functions of time.
    void write_history(size_t rows, double interval, const std::function<double(double)>& a,
                       const std::function<double(double)>& b) {
        std::string text = "time,a,b\ns,m,N\n";
        for (size_t n = 0; n < rows; ++n) {
            const double t = static_cast<double>(n) * interval;
            text += fmt::format("{},{},{}\n", t, a(t), b(t));
        }
        write_text(folder_ / "history.csv", text);
    }
    Ended ask(std::vector<std::string> words, const std::string& results = "history.csv") {
        words.insert(words.begin(), {"spectrum", results, "-o", "out"});
        return run_dttmm(folder_.path(), words);
    }
    Ended spectrum(const std::vector<std::string>& words, const std::string& results = "history.csv") {
        Ended ended = ask(words, results);
        EXPECT_EQ(ended.code, 0) << ended.err;
        return ended;
    }
    std::string fault(const std::vector<std::string>& words, int code, const std::string& results = "history.csv") {
        const Ended ended = ask(words, results);
        EXPECT_EQ(ended.code, code) << ended.err;
        EXPECT_EQ(ended.err.find("internal"), std::string::npos) << ended.err;
        return ended.err;
    }
    void run(const std::string& model) {
        write_text(folder_ / "model.toml", model);
        const Ended ended = run_dttmm(folder_.path(), {"run", "model.toml", "-q", "-o", "run"});
        ASSERT_EQ(ended.code, 0) << ended.err;
    }
    Fields table(const std::string& name) { return read_fields(folder_ / "out" / name); }

    const TemporaryFolder folder_;
};

/// Masses along x on springs with dampers, free to move in all other directions; the first has a velocity.
struct Chain {
    std::vector<double> masses, springs, dampers;

    std::string model(const std::string& simulation) const {
        std::string text = fmt::format("format = \"dttmm/1\"\n[simulation]\n{}", simulation);
        for (size_t i = 0; i < masses.size(); ++i) {
            text += fmt::format("[[body]]\nname = \"b{0}\"\nmass = {1}\ninertia = [1, 1, 1]\nposition = [{0}, 0, 0]\n{2}", i,
                                masses[i], i == 0 ? "velocity = [0.02, 0, 0]\n" : "");
            text += fmt::format(
                "[[element]]\nname = \"s{}\"\ntype = \"spring_damper\"\nfrom = \"{}\"\nto = \"b{}\"\nstiffness = [{}, 0, "
                "0]\ndamping = [{}, 0, 0]\n",
                i, i == 0 ? "ground" : fmt::format("b{}", i - 1), i, springs[i], dampers[i]);
        }
        return text;
    }
    /// The rates with positive imaginary part, by frequency.
    std::vector<Complex> rates() const {
        const auto n = static_cast<Eigen::Index>(masses.size());
        Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n, n), C = K, companion = Eigen::MatrixXd::Zero(2 * n, 2 * n);
        for (Eigen::Index i = 0; i < n; ++i)
            for (const auto& [matrix, value] :
                 {std::pair(&K, springs[static_cast<size_t>(i)]), {&C, dampers[static_cast<size_t>(i)]}}) {
                (*matrix)(i, i) += value;
                if (i == 0) continue;
                (*matrix)(i - 1, i - 1) += value;
                (*matrix)(i, i - 1) -= value;
                (*matrix)(i - 1, i) -= value;
            }
        companion.topRightCorner(n, n).setIdentity();
        for (Eigen::Index i = 0; i < n; ++i) {
            companion.row(n + i).head(n) = -K.row(i) / masses[static_cast<size_t>(i)];
            companion.row(n + i).tail(n) = -C.row(i) / masses[static_cast<size_t>(i)];
        }
        std::vector<Complex> found;
        for (const Complex s : test::eigenvalues(companion))
            if (s.imag() > 0) found.push_back(s);
        std::ranges::sort(found, {}, [](Complex s) { return s.imag(); });
        return found;
    }
};

const Chain kOneMassChain = {{2.5}, {9100}, {4.7}};
const Chain kThreeMasses = {{2.5, 1.7, 4.1}, {9100, 5300, 7700}, {0.61, 0.13, 0.42}};

// Oracle: closed form. A sine of a frequency between bins, an offset, a second channel of the force; levels by integrals
// over the sines, whose ends leave 1/(number of periods).
TEST_F(SpectrumOfARun, ASineBetweenBinsHasItsPeakAndItsLevels) {
    constexpr double kInterval = 0.0013, kFrequency = 41.2345;
    write_history(
        3001, kInterval, [](double t) { return 0.7 + 0.002 * std::sin(kFullTurn * kFrequency * t + 0.3); },
        [](double t) { return 500 * std::cos(kFullTurn * 12.5 * t); });
    const Ended ended = spectrum({});
    EXPECT_EQ(ended.err, "");
    EXPECT_THAT(ended.out, AllOf(HasSubstr("0.002 at 41.2345"), HasSubstr("3001 rows")));
    const nlohmann::json json = read_json(folder_ / "out/summary.json");
    EXPECT_NEAR(json["peaks"]["a"][0]["frequency_hz"].get<double>(), kFrequency, 1e-5);
    EXPECT_NEAR(json["peaks"]["a"][0]["amplitude"].get<double>(), 0.002, 1e-8);
    const Fields levels = table("levels.csv");
    ASSERT_EQ(levels.size(), 2u);
    EXPECT_NEAR(number(levels[0], "deviation"), 0.002 / std::sqrt(2), 1e-5);
    EXPECT_NEAR(number(levels[0], "mean"), 0.7, 1e-5);
    EXPECT_NEAR(number(levels[0], "rms"), std::hypot(0.7, 0.002 / std::sqrt(2)), 1e-5);
    EXPECT_NEAR(number(levels[1], "peak"), 500, 0.1);
    EXPECT_EQ(levels[1].at("unit"), "N");
    // Oracle of the table: density times resolution adds up to the mean square, with the taper's weighting of a long sine
    double sum = 0;
    for (const auto& row : table("spectrum.csv")) sum += number(row, "b.psd") / (3001 * kInterval);
    EXPECT_NEAR(sum, 500 * 500 / 2.0, 0.01 * 500 * 500 / 2);
}

// Oracle: the window of time is what stands in it, its ends included.
TEST_F(SpectrumOfARun, TheWindowOfTimeIsAsAskedFor) {
    write_history(
        1000, 0.01, [](double t) { return t < 4 ? std::sin(kFullTurn * 3 * t) : 2 * std::sin(kFullTurn * 11 * t); },
        [](double) { return 3; });
    EXPECT_THAT(spectrum({"--from", "5 s", "--to", "8500 ms"}).out,
                AllOf(HasSubstr("351 rows from 5 s"), HasSubstr("2 at 1")));
    EXPECT_THAT(ask({}).err,
                HasSubstr("1 channel is constant in the window, apart from round-off, and not in spectrum.csv: b"));
    EXPECT_THAT(spectrum({"--segments", "9", "--window", "flattop", "--channels", "a"}).out,
                HasSubstr("flattop, 9 segments"));
    EXPECT_THAT(read_text(folder_ / "out/spectrum.csv"), Not(HasSubstr("phase")));
    EXPECT_THAT(spectrum({"--resolution", "0.5 Hz", "--channels", "a,b"}).out, HasSubstr("resolution 0.5 Hz"));
    EXPECT_THAT(read_text(folder_ / "out/spectrum.csv"), HasSubstr("frequency,a.amplitude,a.psd\nHz,m,(m)^2/Hz\n"));
}

// Oracle: one unit in the last place of 3 is rounding; 1e-12 of it is not.
TEST_F(SpectrumOfARun, WhatMovesByRoundingOnlyIsConstant) {
    const auto note_with = [&](double size) {
        write_history(
            1000, 0.01, [](double t) { return std::sin(kFullTurn * 3 * t); },
            [=](double t) { return 3 + size * std::round(std::sin(kFullTurn * 7 * t)); });
        return ask({}).err;
    };
    EXPECT_THAT(note_with(4.5e-16), HasSubstr("1 channel is constant in the window, apart from round-off"));
    EXPECT_THAT(note_with(3e-12), Not(HasSubstr("constant")));
}

// Oracle: closed forms. Recorded is s_h with tanh(s_h h/2) = s h/2; without that shift it is s = -c/2m +- i sqrt(k/m -
// (c/2m)^2). Rows are 3 steps apart.
TEST_F(SpectrumOfARun, OneMassHasTheFrequencyOfTheSchemeAndOfTheMachine) {
    constexpr double kStep = 0.004;  // omega h = 0.24
    run(kOneMassChain.model(fmt::format("duration = 6\nstep = {}\n[output]\nstep = {}\n", kStep, 3 * kStep)));
    const Ended ended = spectrum({"--channels", "b0.position,s0.force", "--identify", "1"}, "run");
    EXPECT_THAT(ended.out, AllOf(HasSubstr("(omega h)^2/12"), HasSubstr("step 0.004 s")));
    const Fields modes = table("identified.csv");
    ASSERT_EQ(modes.size(), 1u);
    const Complex s = kOneMassChain.rates().front(), recorded = std::atanh(s * kStep / 2.0) * 2.0 / kStep;
    EXPECT_NEAR(number(modes[0], "frequency") / (recorded.imag() / kFullTurn), 1, 1e-8);
    EXPECT_NEAR(number(modes[0], "damping_ratio") / (-recorded.real() / std::abs(recorded)), 1, 1e-6);
    EXPECT_NEAR(number(modes[0], "natural_frequency") / (std::sqrt(9100 / 2.5) / kFullTurn), 1, 1e-8);
    EXPECT_NEAR(number(modes[0], "corrected_frequency") / (s.imag() / kFullTurn), 1, 1e-8);
    EXPECT_NEAR(number(modes[0], "corrected_damping_ratio") / (4.7 / (2 * std::sqrt(9100 * 2.5))), 1, 1e-6);
    const double x = std::sqrt(9100 / 2.5) * kStep;
    EXPECT_NEAR(number(modes[0], "step_shift"), -x * x / 12, 0.1 * x * x / 12);
    EXPECT_NEAR(number(modes[0], "b0.position.x.amplitude"), 0.02 / s.imag(), 1e-3 * 0.02 / s.imag());
    EXPECT_NEAR(number(modes[0], "b0.position.x.phase"), -90, 1);
}

// Oracle: the closed form s of the machine. Numerical damping and explicit velocities are undone too.
TEST_F(SpectrumOfARun, TheShiftsOfOtherSchemesAreUndone) {
    for (const char* scheme :
         {"spectral_radius = 0.8\n", "coupling = \"explicit\"\n", "coupling = \"explicit\"\nscheme = \"bdf1\"\n",
          "coupling = \"explicit\"\nscheme = \"houbolt\"\n", "coupling = \"explicit\"\nscheme = \"park\"\n"}) {
        run(kOneMassChain.model(fmt::format("duration = 3\nstep = 0.004\n{}", scheme)));
        spectrum({"--channels", "b0.position", "--identify", "1", "--from", "40 ms"}, "run");
        const Fields modes = table("identified.csv");
        ASSERT_EQ(modes.size(), 1u) << scheme;
        EXPECT_NEAR(number(modes[0], "natural_frequency") / (std::sqrt(9100 / 2.5) / kFullTurn), 1, 1e-6) << scheme;
        EXPECT_NEAR(number(modes[0], "corrected_damping_ratio") / (4.7 / (2 * std::sqrt(9100 * 2.5))), 1, 1e-4) << scheme;
    }
}

// Oracle: the eigenvalues of the machine, and the shapes that `dttmm modes` finds. Positions, velocities and accelerations
// together have the shape too.
TEST_F(SpectrumOfARun, ThreeMassesHaveTheirModes) {
    run(kThreeMasses.model("duration = 8\nstep = 0.002\n"));
    ASSERT_EQ(run_dttmm(folder_.path(), {"modes", "model.toml", "-q", "-o", "modes", "--count", "18"}).code, 0);
    const std::vector<Complex> rates = kThreeMasses.rates();
    for (const char* channels :
         {"b?.position", "b?.acceleration,b?.velocity", "b0.position.x,b1.velocity.x,b2.acceleration.x"}) {
        const Ended ended = spectrum({"--channels", channels, "--identify", "3", "--modes", "modes"}, "run");
        const Fields modes = table("identified.csv");
        ASSERT_EQ(modes.size(), 3u) << channels << ended.err;
        for (size_t m = 0; m < 3; ++m) {
            EXPECT_NEAR(number(modes[m], "natural_frequency") / (std::abs(rates[m]) / kFullTurn), 1, 1e-6) << channels;
            EXPECT_NEAR(number(modes[m], "corrected_damping_ratio") / (-rates[m].real() / std::abs(rates[m])), 1, 1e-4)
                << channels;
            EXPECT_GT(number(modes[m], "mac"), 0.9999) << channels;
            EXPECT_NEAR(number(modes[m], "mode_frequency"), number(modes[m], "natural_frequency"), 1e-3);
        }
        EXPECT_THAT(ended.out, HasSubstr("MAC 1.0000"));
    }
    EXPECT_THAT(ask({"--channels", "b2.position", "--identify", "2", "--modes", "modes"}, "run").err,
                AllOf(HasSubstr("single channel"), HasSubstr("1 weaker mode is there beyond the 2 asked for")));
    EXPECT_THAT(ask({"--channels", "b2.position", "--identify", "7"}, "run").err,
                HasSubstr("3 of the 7 modes asked for are found"));
    EXPECT_THAT(fault({"--channels", "s1.force", "--identify", "1", "--modes", "modes"}, 2, "run"),
                HasSubstr("no channel is a position"));
    EXPECT_THAT(fault({"--identify", "1", "--modes", "run"}, 5, "run"), HasSubstr("no results of `dttmm modes`"));
}

// Oracle: closed form. A run to a tolerance is 4/3 of the history of a step and -1/3 of that of twice the step: each mode
// stands in it twice. The vibration under a load stands in it once, and keeps its frequency.
TEST_F(SpectrumOfARun, AnExtrapolatedRunHasItsModesOnce) {
    run(kOneMassChain.model("duration = 3\ntolerance = \"1 %\"\n[output]\nstep = 0.005\n") +
        "[[load]]\non = \"b0\"\ndirection = [1, 0, 0]\nforce = \"=3*sin(2*pi*17.3*t)\"\n");
    const Ended ended = spectrum({"--channels", "b0.position,b0.velocity", "--identify", "2"}, "run");
    const Fields modes = table("identified.csv");
    ASSERT_EQ(modes.size(), 2u);
    EXPECT_NEAR(number(modes[0], "natural_frequency") / (std::sqrt(9100 / 2.5) / kFullTurn), 1, 1e-6);
    EXPECT_NEAR(number(modes[0], "corrected_damping_ratio") / (4.7 / (2 * std::sqrt(9100 * 2.5))), 1, 1e-4);
    EXPECT_NEAR(number(modes[1], "natural_frequency"), 17.3, 1e-6);
    EXPECT_TRUE(std::isnan(number(modes[1], "step_shift")));
    // The sum of both is the start: x = 0, v = 0.02 m/s.
    for (const auto& [channel, start] : {std::pair("b0.position.x", 0.0), {"b0.velocity.x", 0.02}}) {
        double sum = 0;
        for (const auto& mode : modes)
            sum += number(mode, std::string(channel) + ".amplitude") *
                   std::cos(number(mode, std::string(channel) + ".phase") * kFullTurn / 360);
        EXPECT_NEAR(sum, start, 1e-3 * number(modes[0], std::string(channel) + ".amplitude")) << channel;
    }
    EXPECT_THAT(ended.err, AllOf(HasSubstr("17.3 Hz, or a load keeps it up"), Not(HasSubstr("nearer than"))));
}

// Oracle: `dttmm response` of the same machine at the speed of each row. A rotor speeds up slowly; a force of its second
// order shakes a mass. The amplitude lags by the decay time of the mass, 0.1 s; the speed changes by 0.3 % in it.
TEST_F(SpectrumOfARun, ASlowRunUpIsTheSteadyResponse) {
    const std::string machine = kOneMassChain.model("duration = 12\nstep = 0.001\n");
    const std::string damped = machine.substr(0, machine.rfind("damping")) + "damping = [60, 0, 0]\n";
    run(damped +
        "[[body]]\nname = \"rotor\"\nmass = 1\ninertia = [1, 1, 1]\nposition = [0, 3, 0]\nangular_velocity = [0, 0, 20]\n"
        "[[load]]\non = \"rotor\"\ndirection = [0, 0, 1]\nmoment = 1.0\n"
        "[[load]]\non = \"b0\"\ndirection = [1, 0, 0]\nforce = \"=5*cos(2*(20*t + 0.5*t^2))\"\n");
    const Ended ended =
        spectrum({"--channels", "b0.position", "--orders", "1,2", "--speed", "rotor.angular_velocity.z"}, "run");
    EXPECT_THAT(ended.out, HasSubstr("b0.position.x.order2"));
    const Fields rows = table("orders.csv");
    ASSERT_GT(rows.size(), 30u);
    for (const auto& row : rows) {
        if (number(row, "time") < 1) continue;  // the start has died away
        const double omega = 2 * number(row, "rpm") * kFullTurn / 60;
        const Complex x = 5.0 / Complex(9100 - 2.5 * omega * omega, 60 * omega);
        const Complex found = std::polar(number(row, "b0.position.x.order2.amplitude"),
                                         number(row, "b0.position.x.order2.phase") / 360 * kFullTurn);
        EXPECT_LT(std::abs(found - x), 0.03 * std::abs(x)) << omega;
    }
    EXPECT_THAT(fault({"--orders", "0.01", "--speed", "rotor.angular_velocity.z"}, 2, "run"),
                HasSubstr("these orders need 200"));
    EXPECT_THAT(fault({"--orders", "1", "--speed", "b0.velocity.x"}, 2, "run"), HasSubstr("angular velocity [rad/s]"));
    EXPECT_THAT(fault({"--orders", "1", "--speed", "rotor.angular_velocity.x"}, 2, "run"), HasSubstr("stands still"));
    EXPECT_THAT(fault({"--orders", "1", "--speed", "rotor.angular_velocty.z"}, 2, "run"), HasSubstr("did you mean"));
    EXPECT_THAT(fault({"--orders", "1,-2", "--speed", "rotor.angular_velocity.z"}, 2, "run"),
                HasSubstr("orders are positive"));
    EXPECT_THAT(fault({"--orders", "1"}, 2, "run"), HasSubstr("belong together"));
}

TEST_F(SpectrumOfARun, WhatTheRowsCannotSayIsSaid) {
    write_history(
        400, 0.01, [](double t) { return std::sin(kFullTurn * 48 * t); },
        [](double t) { return std::sin(kFullTurn * 0.4 * t); });
    const std::string err = spectrum({}).err;
    EXPECT_THAT(err, AllOf(HasSubstr("a peak within the highest tenth of the band, which ends at 50 Hz: a;"),
                           HasSubstr("fewer than 3 periods: b;")));
    EXPECT_THAT(read_text(folder_ / "out/summary.json"), AllOf(HasSubstr("near-end-of-band"), HasSubstr("few-periods")));
    write_history(
        3000, 0.01,
        [](double t) { return std::exp(-0.01 * t) * (std::sin(kFullTurn * 7 * t) + std::sin(kFullTurn * 7.02 * t)); },
        [](double t) { return std::exp(-0.01 * t) * (std::sin(kFullTurn * 7 * t) - std::sin(kFullTurn * 7.02 * t)); });
    const std::string close = spectrum({"--identify", "2"}).err;
    EXPECT_THAT(close, AllOf(HasSubstr("nearer than the resolution of 0.03333 Hz"), HasSubstr("no summary.json")));
}

TEST_F(SpectrumOfARun, WrongResultsAreRefused) {
    EXPECT_THAT(fault({}, 5, "nowhere"), HasSubstr("nowhere: cannot read"));
    fs::create_directory(folder_ / "empty");
    EXPECT_THAT(fault({}, 5, "empty"), HasSubstr("no history.csv in it"));
    for (const auto& [file, word] : {std::pair("modes.csv", "`dttmm modes`"),
                                     {"sweep.csv", "case-000001"},
                                     {"frf.csv", "`dttmm frf`"},
                                     {"model.toml", "run it"}}) {
        write_text(folder_ / "empty" / file, "x");
        EXPECT_THAT(fault({}, 5, "empty"), HasSubstr(word));
        fs::remove(folder_ / "empty" / file);
    }
    for (const auto& [text, word] : {std::pair("", "no history of a run"),
                                     {"hello\nworld\n1\n", "no history of a run"},
                                     {"time,a\nms,m\n0,1\n", ":2: the second line"},
                                     {"time,a\ns\n0,1\n", ":2: the second line"},
                                     {"time,a\ns,m\n0,1\n1,x\n", ":4: \"x\" of the channel \"a\" is no finite number"},
                                     {"time,a\ns,m\n0,1\n1,nan\n2,1\n", ":4: \"nan\""},
                                     {"time,a\ns,m\n0,1\n1,inf\n", ":4: \"inf\""},
                                     {"time,a\ns,m\n0,1\n1,\n", ":4: \"\""},
                                     {"time,a\ns,m\n0,1\n1,2,3\n", ":4: 3 fields, but 2 names"},
                                     {"time,a\ns,m\n0,1\n1\n", ":4: 1 fields, but 2 names"},
                                     {"time,a\ns,m\n0,1\n", "1 row: a spectrum needs two or more"},
                                     {"time,a\ns,m\n", "0 rows"},
                                     {"time,a\ns,m\n0,1\n1,2\n3,1\n", "1 s apart at first, 2 s after t = 1 s"},
                                     {"time,a\ns,m\n0,1\n1,2\n1,1\n", "not equally spaced"},
                                     {"time,a\ns,m\n2,1\n1,2\n0,1\n", "is not within the record"}}) {
        write_text(folder_ / "history.csv", text);
        const Ended ended = ask({});
        EXPECT_THAT(ended.code, ::testing::AnyOf(2, 5)) << text;
        EXPECT_THAT(ended.err, HasSubstr(word)) << text;
    }
}

TEST_F(SpectrumOfARun, WrongWordsAreRefused) {
    write_history(
        60, 0.5, [](double t) { return std::sin(t); }, [](double t) { return t; });
    EXPECT_THAT(fault({"--channels", "c.force"}, 2), AllOf(HasSubstr("matches no channel"), HasSubstr("nearest")));
    for (const auto& [from, to] : {std::pair("-1 s", "9 s"), {"3 s", "31 s"}, {"9 s", "4 s"}, {"4 s", "4 s"}})
        EXPECT_THAT(fault({"--from", from, "--to", to}, 2), HasSubstr("not within the record, which is from 0 s to 29.5 s"));
    EXPECT_THAT(fault({"--from", "1 s", "--to", "1.2 s"}, 2), HasSubstr("has 1 row"));
    EXPECT_THAT(fault({"--from", "1 kg"}, 2), HasSubstr("--from \"1 kg\""));
    EXPECT_THAT(fault({"--window", "han"}, 2), HasSubstr("did you mean \"hann\""));
    EXPECT_THAT(fault({"--segments", "100"}, 2), HasSubstr("60 rows are too few"));
    EXPECT_THAT(fault({"--segments", "2", "--resolution", "1 Hz"}, 2), HasSubstr("give one of them"));
    for (const char* resolution : {"0.001 Hz", "3 Hz", "0 Hz", "-1 Hz"})
        EXPECT_THAT(fault({"--resolution", resolution}, 2), HasSubstr("a resolution of 0.0333333 Hz at best"));
    EXPECT_THAT(fault({"--identify", "40"}, 2), HasSubstr("60 rows of 2 channels tell at most"));
    EXPECT_THAT(fault({"--modes", "x"}, 2), HasSubstr("give --identify N"));
}

// A killed run leaves a torn last row: it is left out, and that is said.
TEST_F(SpectrumOfARun, ATornRowIsLeftOut) {
    write_text(folder_ / "history.csv", "time,a\ns,m\n0,1\n1,2\n2,0.5\n3,1\n4,0.");
    const Ended ended = spectrum({});
    EXPECT_THAT(ended.err, HasSubstr("the last row is not whole"));
    EXPECT_THAT(ended.out, HasSubstr("4 rows"));
}

// A million rows, of a prime number: 15 s on a slow machine.
TEST_F(SpectrumOfARun, AMillionRowsAreQuick) {
    write_history(
        1'000'003, 0.001, [](double t) { return std::sin(kFullTurn * 48.7 * t); },
        [](double t) { return std::exp(-0.01 * t) * std::sin(kFullTurn * 3.3 * t); });
    const Ended ended = spectrum({"--identify", "2"});
    EXPECT_LT(ended.seconds, 60);
    const Fields modes = table("identified.csv");
    ASSERT_EQ(modes.size(), 2u);
    EXPECT_NEAR(number(modes[0], "frequency"), 3.3, 1e-6);
    EXPECT_NEAR(number(modes[1], "frequency"), 48.7, 1e-6);
}

}  // namespace
}  // namespace dttmm::host
