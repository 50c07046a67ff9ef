// SPDX-License-Identifier: BSD-3-Clause
#include "identify/figure_slopes.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "model/index.h"

namespace dttmm::host {
namespace {

const std::vector<Channel> kHistory = {{"time", "s"}, {Channel::Of::element, "bolt", "force", "z", "N"}};

/// A history y(t) and its derivatives in two directions, at rows dt apart.
class Rows {
public:
    Rows(const std::string& statistic, const std::function<double(double)>& y,
         const std::vector<std::function<double(double)>>& slopes, double dt, int count)
        : figures_({"bolt.force.z:" + statistic}, kHistory, std::nullopt), slopes_(figures_, as_row(slopes.size())) {
        for (int n = 0; n < count; ++n) {
            const double t = n * dt, row[] = {t, y(t)};
            Eigen::MatrixXd list(1, as_row(slopes.size()));
            for (size_t d = 0; d < slopes.size(); ++d) list(0, as_row(d)) = slopes[d](t);
            figures_.take_row(row);
            slopes_.take_row(t, std::span(row).last(1), list);
        }
    }
    FigureSlopes::Found found() const { return slopes_.find(0); }
    double value() const { return figures_.values()[0]; }

private:
    HistoryFigures figures_;
    FigureSlopes slopes_;
};

// A decaying sine of frequency w: by ln of its amplitude and by w.
constexpr double kHeight = 3.7, kTurn = 41, kFading = 2.3;
double y(double t) { return kHeight * std::exp(-kFading * t) * std::sin(kTurn * t); }
double by_amplitude(double t) { return y(t); }
double by_w(double t) { return kHeight * t * std::exp(-kFading * t) * std::cos(kTurn * t); }
/// The instant of the first maximum.
double first_maximum() { return std::atan(kTurn / kFading) / kTurn; }

// Oracle: the envelope theorem, at the instant of the peak in closed form: t' = -d(first maximum)/dw. The row of the peak is
// up to half a row away, where the derivative by w is another.
TEST(FigureSlopesOf, APeakAreThoseAtItsInstantBetweenRows) {
    const double t = first_maximum();
    for (const double dt : {4e-3, 2e-3, 1e-3}) {
        const Rows rows("peak", y, {by_amplitude, by_w}, dt, 200);
        const FigureSlopes::Found found = rows.found();
        const double cube = std::pow(kTurn * dt, 3);
        EXPECT_NEAR(found.slope(0), y(t), 0.01 * cube * kHeight);
        EXPECT_NEAR(found.slope(1), by_w(t), 0.07 * cube * kHeight * t);
        const double at_row = by_w(std::round(t / dt) * dt);
        EXPECT_GT(std::abs(at_row - by_w(t)), 20 * std::abs(found.slope(1) - by_w(t))) << "the row would be no answer";
        EXPECT_LT(std::abs(found.slope(1) - by_w(t)), found.error(1));
    }
}

TEST(FigureSlopesOf, TheInstantOfAPeak) {
    const double exact =
        1 / (kTurn * kFading) / (1 + std::pow(kTurn / kFading, 2)) - std::atan(kTurn / kFading) / (kTurn * kTurn);
    const Rows rows("time", y, {by_amplitude, by_w}, 1e-3, 200);
    EXPECT_NEAR(rows.found().slope(0), 0, 1e-12) << "more of everything moves no peak";
    EXPECT_NEAR(rows.found().slope(1) / exact, 1, 1e-3);
}

TEST(FigureSlopesOf, AMinimumHasItsOwnInstantAndSign) {
    const double t = first_maximum() + M_PI / kTurn;
    const Rows least("minimum", y, {by_amplitude, by_w}, 1e-3, 200), most("maximum", y, {by_amplitude, by_w}, 1e-3, 200);
    EXPECT_NEAR(least.found().slope(0), y(t), 1e-4);
    EXPECT_NEAR(least.found().slope(1), by_w(t), 1e-4);
    EXPECT_NEAR(most.found().slope(0), y(first_maximum()), 1e-4);
    const auto turned = [](double (*f)(double)) { return [f](double at) { return -f(at); }; };
    const Rows peak("peak", turned(y), {turned(by_amplitude), turned(by_w)}, 1e-3, 200);
    EXPECT_NEAR(peak.found().slope(0), y(first_maximum()), 1e-4) << "of the size, where the value is negative";
}

// Oracle: differences of the figures of the same rows, which are what HistoryFigures says.
TEST(FigureSlopesOf, SumsOverRowsAreThoseOfTheFigures) {
    constexpr double d = 1e-5;
    for (const char* statistic : {"mean", "rms", "final"}) {
        const Rows rows(statistic, y, {by_amplitude, by_w}, 1e-3, 157);
        const auto at = [&](double w) {
            return Rows(
                       statistic, [w](double t) { return kHeight * std::exp(-kFading * t) * std::sin(w * t); }, {}, 1e-3,
                       157)
                .value();
        };
        EXPECT_NEAR(rows.found().slope(0), rows.value(), 1e-12) << statistic;
        EXPECT_NEAR(rows.found().slope(1), (at(kTurn + d) - at(kTurn - d)) / (2 * d), 1e-8) << statistic;
        EXPECT_EQ(rows.found().error.norm(), 0) << statistic;
        EXPECT_FALSE((rows.found().reach.array() < 1e9).any()) << statistic << " has no competing extreme";
    }
}

TEST(FigureSlopesOf, EndsOfAHistoryStayWhereTheyAre) {
    const auto rises = [](double t) { return 2 + 3 * t * t; };
    const auto slope = [](double t) { return 1 + t; };
    const double end = 0.099;
    EXPECT_NEAR(Rows("peak", rises, {slope}, 1e-3, 100).found().slope(0), 1 + end, 1e-12);
    EXPECT_NEAR(Rows("minimum", rises, {slope}, 1e-3, 100).found().slope(0), 1, 1e-12);
    EXPECT_EQ(Rows("time", rises, {slope}, 1e-3, 100).found().slope(0), 0);
    const Rows flat(
        "peak", [](double) { return 5.0; }, {slope}, 1e-3, 100),
        one("rms", rises, {slope}, 1e-3, 1);
    EXPECT_TRUE(std::isfinite(flat.found().slope(0)));
    EXPECT_NEAR(one.found().slope(0), 1, 1e-12);
    for (const char* statistic : {"rms", "peak"}) {
        const Rows nothing(
            statistic, [](double) { return 0.0; }, {[](double) { return 0.0; }}, 1e-3, 100);
        EXPECT_TRUE(std::isnan(nothing.found().slope(0))) << statistic << " of nothing has no derivative";
    }
}

// The maximum lies before the last row, or after the first one, which are themselves the largest of the rows.
TEST(FigureSlopesOf, AnExtremeInTheFirstOrTheLastRowStep) {
    const double w = 3;
    const auto by_turn = [&](double t) { return t * std::cos(w * t); };
    const auto sine = [&](double t) { return std::sin(w * t); };
    const double top = M_PI / 2 / w, dt = top / 10.6;  // rows 10 and 11 on either side, row 11 the higher one
    const FigureSlopes::Found last = Rows("maximum", sine, {by_turn}, dt, 12).found();
    EXPECT_NEAR(last.slope(0), 0, 2e-3);
    EXPECT_LT(std::abs(last.slope(0)), last.error(0));
    EXPECT_GT(std::abs(by_turn(11 * dt)), 20 * std::abs(last.slope(0))) << "the row would be no answer";
    const auto falling = [&](double t) { return std::cos(w * (t - 0.4 * dt)); };
    const auto by_w = [&](double t) { return -(t - 0.4 * dt) * std::sin(w * (t - 0.4 * dt)) + 1; };
    const FigureSlopes::Found first = Rows("maximum", falling, {by_w}, dt, 12).found();
    EXPECT_NEAR(first.slope(0), 1, 2e-3);
    EXPECT_NEAR(Rows("time", sine, {by_turn}, dt, 12).found().slope(0), -top / w, 0.02 * top / w);
}

// An offset, as of a position, changes nothing of what the interpolation is worth.
TEST(FigureSlopesOf, ErrorsDoNotKnowAnOffset) {
    const auto shifted = [](double by) { return [by](double t) { return y(t) + by; }; };
    const FigureSlopes::Found own = Rows("maximum", y, {by_w}, 4e-3, 200).found(),
                              far = Rows("maximum", shifted(1000), {by_w}, 4e-3, 200).found();
    EXPECT_NEAR(far.slope(0), own.slope(0), 1e-9);
    EXPECT_NEAR(far.error(0), own.error(0), 1e-3 * own.error(0));
    EXPECT_LT(std::abs(far.slope(0) - by_w(first_maximum())), far.error(0));
}

// Oracle: a roof whose ridge stays at a row while its slopes change.
TEST(FigureSlopesOf, AKinkIsNoParabola) {
    const auto roof = [](double t) { return 30 - (t < 0.05 ? 40 * (0.05 - t) : 170 * (t - 0.05)); };
    const auto slope = [](double t) { return t < 0.05 ? t - 0.05 : 0.8 * (t - 0.05); };
    const FigureSlopes::Found found = Rows("peak", roof, {slope}, 1e-3, 100).found();
    EXPECT_NEAR(found.slope(0), 0, 1e-12);
    EXPECT_GT(found.error(0), 1e-5) << "and is doubtful";
}

// A dozen rows a period are a parabola still, and nine are one that is no kink, wherever the peak lies between them.
TEST(FigureSlopesOf, CoarseRowsAreNoKinks) {
    for (const auto& [dt, bound] : {std::pair(0.5, 0.015), std::pair(0.7, 0.06)})
        for (double phase = 0; phase < dt; phase += 0.05) {
            const auto sine = [&](double t) { return std::sin(t + phase); };
            const auto by_turn = [&](double t) { return t * std::cos(t + phase); };
            const FigureSlopes::Found found = Rows("maximum", sine, {by_turn}, dt, 8).found();
            EXPECT_NEAR(found.slope(0), 0, bound) << dt << " " << phase;
        }
}

// Oracle: two pulses of sizes a and b = 0.98 a: the second is the larger when a loses 2 %, whose slope by ln a is then 0.
TEST(FigureSlopesOf, ASecondExtremeHasItsSlopeAndReach) {
    const auto pulse = [](double t, double at) { return std::exp(-std::pow((t - at) / 0.02, 2)); };
    const Rows rows(
        "peak", [&](double t) { return 5 * pulse(t, 0.1) + 4.9 * pulse(t, 0.3); },
        {[&](double t) { return 5 * pulse(t, 0.1); }, [&](double t) { return 5 * pulse(t, 0.1) + 4.9 * pulse(t, 0.3); }},
        1e-3, 400);
    const FigureSlopes::Found found = rows.found();
    EXPECT_NEAR(found.slope(0), 5, 1e-6);
    EXPECT_NEAR(found.competing(0), 0, 1e-6);
    EXPECT_NEAR(found.reach(0), 0.02, 1e-6);
    EXPECT_NEAR(found.competing_time, 0.3, 1e-12);
    EXPECT_NEAR(found.reach(1), 1, 1e-6) << "both grow alike: it never comes to that";
}

}  // namespace
}  // namespace dttmm::host
