// SPDX-License-Identifier: BSD-3-Clause
//
// Parameters from measurements: how near the scatter of what is found comes to the bound of Cramer and Rao, how often the
// intervals hold the truth, how often the loose bolt is found; and how long the commands take. The plate of four bolts,
// struck at a corner: accelerations of its corners, 1 s at 1 ms, noise of 1 % of the largest.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>

#include "benchmark/median.h"
#include "identify/comparison.h"
#include "identify/diagnosis.h"
#include "identify/identification.h"
#include "model/read_model.h"
#include "support/paths.h"

namespace dttmm::host {
namespace {

namespace fs = std::filesystem;

constexpr int kDraws = 500, kFaults = 100;

std::string plate() {
    std::string text = R"(format = "dttmm/1"
[parameters]
k1 = "500 N/mm"
k2 = "500 N/mm"
k3 = "500 N/mm"
k4 = "500 N/mm"
[simulation]
duration = "1 s"
step = "1 ms"
[[body]]
name = "plate"
density = "7850 kg/m^3"
box = ["300 mm", "200 mm", "20 mm"]
markers = { corner1 = [0.13, 0.08, 0], corner2 = [-0.13, 0.08, 0], corner3 = [-0.13, -0.08, 0], corner4 = [0.13, -0.08, 0] }
[[load]]
on = "plate.corner1"
direction = [0, 0, 1]
force = { type = "haversine", peak = "200 N", start = 0, width = "4 ms" }
)";
    for (int i = 1; i <= 4; ++i)
        text += fmt::format(
            "[[element]]\nname = \"bolt{0}\"\ntype = \"spring_damper\"\nfrom = \"ground\"\nto = "
            "\"plate.corner{0}\"\nstiffness "
            "= \"=k{0}\"\ndamping = 100\n",
            i);
    return text;
}

/// A test of the plate: exact data of given stiffnesses, to which every draw adds its noise.
class PlateTest {
public:
    explicit PlateTest(const fs::path& folder) : plugins_(std::vector<std::string>()) {
        request_.model = folder / "plate.toml";
        std::ofstream(request_.model) << plate();
        request_.fit.free = {"k1..k4"};
        ModelOverrides overrides;
        overrides.purpose = Purpose::modes;
        model_ = read_model(request_.model, plugins_.catalogue(), overrides);
        for (int i = 1; i <= 4; ++i) {
            ObservedHistory one{fmt::format("plate.corner{}.acceleration.z", i), "m/s^2", {}, {}};
            for (int n = 0; n <= 1000; ++n) one.times.push_back(1e-3 * n);
            one.values.assign(one.times.size(), 0);
            one.values.back() = 1;
            one.is_noise_of_user = true;
            exact_.histories.push_back(one);
        }
        unknowns_ = Unknowns(request_, model_, plugins_.catalogue(), {});
    }

    const Unknowns& unknowns() const { return unknowns_; }
    const Request& request() const { return request_; }
    const Plugins& plugins() const { return plugins_; }

    /// factor: of bolt 1's stiffness.
    void set_truth(double factor) {
        truth_ = unknowns_.start();
        truth_(0) += std::log(factor);
        const Eigen::VectorXd values = Comparison(request_, exact_, plugins_).predict(unknowns_, truth_);
        noise_ = 0.01 * values.cwiseAbs().maxCoeff();
        for (size_t c = 0; c < 4; ++c) {
            exact_.histories[c].noise = noise_;
            for (size_t n = 0; n <= 1000; ++n)
                exact_.histories[c].values[n] = values(static_cast<Eigen::Index>(1001 * c + n));
        }
    }
    const Eigen::VectorXd& truth() const { return truth_; }

    Observations draw(unsigned seed) const {
        Observations drawn = exact_;
        std::mt19937_64 engine(seed);
        std::normal_distribution<double> normal(0, noise_);
        for (ObservedHistory& one : drawn.histories)
            for (double& value : one.values) value += normal(engine);
        return drawn;
    }

private:
    Request request_;
    Plugins plugins_;
    Model model_;
    Observations exact_;
    Unknowns unknowns_;
    Eigen::VectorXd truth_;
    double noise_ = 0;
};

void measure_scatter(PlateTest& test) {
    test.set_truth(1);
    const auto count = test.truth().size();
    Eigen::VectorXd squares = Eigen::VectorXd::Zero(count), sums = squares;
    Eigen::VectorXi covered = Eigen::VectorXi::Zero(count);
    Eigen::MatrixXd bound;
    for (unsigned draw = 0; draw < kDraws; ++draw) {
        const Observations data = test.draw(draw + 1);
        Comparison comparison(test.request(), data, test.plugins());
        const Identifier identifier(comparison, test.unknowns(), {}, 0);
        if (draw == 0) {
            const Eigen::MatrixXd J = identifier.residuals().jacobian(test.truth());
            bound = (J.transpose() * J).inverse();
        }
        const Solution found = identifier.polish(test.unknowns().start());
        const Eigen::VectorXd error = found.x - test.truth();
        sums += error;
        squares += error.cwiseAbs2();
        for (Eigen::Index i = 0; i < count; ++i) {
            const auto k = static_cast<size_t>(i);
            covered(i) +=
                found.low[k] && found.high[k] && *found.low[k] <= test.truth()(i) && test.truth()(i) <= *found.high[k];
        }
    }
    fmt::print("{} draws, 1 % noise\n{:<4} {:>12} {:>12} {:>8} {:>10} {:>12}\n", kDraws, "", "deviation", "bound", "ratio",
               "mean", "covered");
    for (Eigen::Index i = 0; i < count; ++i) {
        const double mean = sums(i) / kDraws, deviation = std::sqrt(squares(i) / kDraws - mean * mean),
                     least = std::sqrt(bound(i, i));
        fmt::print("k{:<3} {:>10.4f} % {:>10.4f} % {:>8.3f} {:>8.4f} % {:>10.1f} %\n", i + 1, 100 * deviation, 100 * least,
                   deviation / least, 100 * mean, 100.0 * covered(i) / kDraws);
    }
}

void measure_faults(PlateTest& test, double factor) {
    test.set_truth(factor);
    int first = 0, alone = 0, unseen = 0;
    const Unknowns none;
    for (unsigned draw = 0; draw < kFaults; ++draw) {
        const Observations data = test.draw(1000 + draw);
        Comparison comparison(test.request(), data, test.plugins());
        const Diagnosis found =
            Diagnostician(comparison, none, {{"bolt1", "bolt2", "bolt3", "bolt4"}, {true, true, true, true}}, 0).diagnose();
        unseen += found.candidates.empty();
        const bool is_first = !found.candidates.empty() && found.candidates[0].elements == std::vector<std::string>{"bolt1"};
        first += is_first;
        alone += is_first && found.candidates.size() == 1;
    }
    fmt::print("bolt 1 {:.4g} % softer: it first in {} of {}, alone in {}, no change seen in {}\n", 100 * (1 - factor),
               first, kFaults, alone, unseen);
}

/// Wall time of a command [s], the median of several.
void measure_command(const char* what, const std::string& words) {
    std::vector<double> all;
    constexpr int kRuns = 5;
    for (int i = 0; i < kRuns; ++i) {
        const auto start = std::chrono::steady_clock::now();
        const int code = std::system(fmt::format("{} {} -q 2>/dev/null", test::paths::command(), words).c_str());
        const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
        all.push_back(code == 0 ? seconds : -1);
    }
    fmt::print("{:<70} {:8.2f} s\n", what, median(all));
}

void measure_times(const fs::path& folder) {
    const std::string at = folder.string(), stack = std::string(test::paths::source_dir()) + "/examples/stack";
    std::string model = plate();
    for (int i = 1; i <= 4; ++i) {
        const size_t found = model.find("damping = 100");
        model.replace(found, 13, fmt::format("damping = \"=c{}\"", i));
    }
    const size_t parameters = model.find("[simulation]");
    model.insert(parameters, "c1 = \"100 N*s/m\"\nc2 = \"100 N*s/m\"\nc3 = \"100 N*s/m\"\nc4 = \"100 N*s/m\"\n");
    std::ofstream(folder / "eight.toml") << model;
    measure_command(
        "a run of the plate, 1 s",
        fmt::format("run {}/eight.toml --set 'k1=450 N/mm' -o {}/run --channels 'plate.corner*.acceleration.z'", at, at));
    measure_command(
        "four stiffnesses and four dampings from it, one start",
        fmt::format("identify {0}/eight.toml --measured {0}/run/history.csv --free k1..k4,c1..c4 --starts 1 -o {0}/one",
                    at));
    measure_command(
        "the same from 64 starting points",
        fmt::format("identify {0}/eight.toml --measured {0}/run/history.csv --free k1..k4,c1..c4 -o {0}/many", at));
    measure_command(
        "diagnosis among its four bolts",
        fmt::format("diagnose {0}/eight.toml --measured {0}/run/history.csv --suspects 'bolt*' -o {0}/four", at));
    measure_command("a run of the stack of examples/stack",
                    fmt::format("run {} -o {}/stack --channels 'plate*.acceleration.z'", stack, at));
    measure_command(
        "diagnosis among its forty bolts",
        fmt::format("diagnose {} --measured {}/stack/history.csv --suspects 'bolt*' -o {}/forty", stack, at, at));
}

}  // namespace
}  // namespace dttmm::host

int main() {
    using namespace dttmm::host;
    const fs::path folder = fs::temp_directory_path() / fmt::format("dttmm-benchmark-{}", std::random_device()());
    fs::create_directories(folder);
    measure_times(folder);
    PlateTest test(folder);
    for (const double factor : {0.98, 0.998}) measure_faults(test, factor);
    measure_scatter(test);
    fs::remove_all(folder);
}
