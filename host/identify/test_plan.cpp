// SPDX-License-Identifier: BSD-3-Clause
#include "identify/test_plan.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

#include "analysis/modal_session.h"
#include "identify/forked_map.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/atomic_file.h"
#include "record/csv_table.h"
#include "record/results_folder.h"
#include "study/design.h"

namespace dttmm::host {

namespace {

constexpr int kLines = 60;                    // of a response
constexpr double kBelow = 0.5, kAbove = 1.3;  // of the first and the last mode: where responses are looked at
constexpr double kResponseNoise = 0.01;       // of the largest acceleration under a blow
constexpr double kPlanStep = 0.01;            // of the logarithm of a stiffness
constexpr double kPlanScatter = 0.1;          // of the stiffnesses, at random points
constexpr int kPoints = 3;                    // random ones, beside the file's values
constexpr size_t kMostSensors = 4;            // looked for one after the other
constexpr size_t kMostFreedoms = 120;  // places and directions: their responses to each other are a table of the square
constexpr double kTiedPlan = 0.999;    // cosine

/// A place and direction.
struct Freedom {
    std::string name;
    std::string place;
    int direction;
};

/// Responses of all places to blows at all places, for given factors of the suspects: one number per line, blow and sensor,
/// real and imaginary part.
class ResponseTable {
public:
    ResponseTable(const Request& request, const Plugins& plugins, const std::vector<std::string>& suspects)
        : request_(request), plugins_(plugins), suspects_(suspects) {
        const Model model = read(Eigen::VectorXd::Zero(as_row(suspects.size())));
        Warnings silent(Warnings::Silent::yes);
        ModalMachine machine = make_machine(model, plugins, silent);
        for (const ModalPlace& place : machine.places())
            for (int d = 0; d < 3; ++d)
                if (!place.is_held(d) && model.modes.directions[as_size(d)] &&
                    is_chosen(fmt::format("{}.{}", place.name, "xyz"[d])))
                    freedoms_.push_back({fmt::format("{}.{}", place.name, "xyz"[d]), place.name, d});
        if (freedoms_.size() > kMostFreedoms)
            throw Error(ExitCode::resource_limit,
                        fmt::format("--plan: {} places and directions are too many to compare, at most {}; choose some with "
                                    "--channels, as --channels \"plate1*\"",
                                    freedoms_.size(), kMostFreedoms));
        const std::vector<ModalInstance::Mode> modes = machine.find_modes();
        double first = 0, last = 0;
        for (const ModalInstance::Mode& mode : modes) {
            if (first == 0) first = mode.numbers.frequency;
            last = std::max(last, mode.numbers.frequency);
        }
        if (!(first > 0)) throw Error(ExitCode::model_invalid, "--plan: nothing of the model vibrates");
        for (int i = 0; i < kLines; ++i)
            frequencies_.push_back(kBelow * first * std::pow(kAbove * last / (kBelow * first), i / (kLines - 1.0)));
    }

    const std::vector<Freedom>& freedoms() const { return freedoms_; }
    double from() const { return frequencies_.front(); }
    double to() const { return frequencies_.back(); }
    /// Of one blow and one sensor: so many numbers.
    static constexpr size_t kNumbers = 2 * kLines;

    /// logarithms: of the factors. Index: (blow · freedoms + sensor) · kNumbers.
    std::vector<double> find(const Eigen::VectorXd& logarithms) const {
        const Model model = read(logarithms);
        Warnings silent(Warnings::Silent::yes);
        ModalMachine machine = make_machine(model, plugins_, silent);
        machine.damp(to());
        const size_t count = freedoms_.size();
        std::vector<double> table(count * count * kNumbers);
        std::vector<ModalInstance::Loads> blows;
        for (const Freedom& blow : freedoms_) {
            ModalMachine::Complex6 wrench = ModalMachine::Complex6::Zero();
            wrench(blow.direction) = 1;
            blows.push_back({ModalMachine::load_at(*machine.find(blow.place), wrench)});
        }
        for (size_t line = 0; line < frequencies_.size(); ++line) {
            const double omega = 2 * std::numbers::pi * frequencies_[line];
            const auto responses = machine.respond(frequencies_[line], blows);
            for (size_t b = 0; b < count; ++b)
                for (size_t s = 0; s < count; ++s) {
                    const std::complex<double> value =
                        -omega * omega *
                        machine.motion(*machine.find(freedoms_[s].place), responses[b])(freedoms_[s].direction);
                    double* at = table.data() + (b * count + s) * kNumbers + 2 * line;
                    at[0] = value.real();
                    at[1] = value.imag();
                }
        }
        return table;
    }

private:
    bool is_chosen(const std::string& freedom) const {
        return request_.spectrum.channels.empty() ||
               std::ranges::any_of(request_.spectrum.channels, [&](const std::string& pattern) {
                   return fnmatch(pattern.c_str(), freedom.c_str(), 0) == 0;
               });
    }
    Model read(const Eigen::VectorXd& logarithms) const {
        ModelOverrides overrides = request_.overrides;
        overrides.purpose = Purpose::modes;
        for (size_t s = 0; s < suspects_.size(); ++s)
            overrides.scales.push_back({suspects_[s], std::exp(logarithms(as_row(s))), 1});
        return read_model(request_.model, plugins_.catalogue(), overrides);
    }

    const Request& request_;
    const Plugins& plugins_;
    const std::vector<std::string>& suspects_;
    std::vector<Freedom> freedoms_;
    std::vector<double> frequencies_;
};

/// A blow with its sensors, worst over the points that were looked at.
struct PlannedBlow {
    std::string blow;
    std::vector<std::string> sensors;
    double worst = 0;  ///< standard deviation of the logarithm of a stiffness; infinite: not fixed
    std::vector<std::vector<std::string>> ties;
};

/// Information of every blow and sensor about the stiffnesses, at one point.
using Information = std::vector<Eigen::MatrixXd>;

Information find_information(const ResponseTable& table, const Eigen::VectorXd& at, int jobs) {
    const auto count = as_size(at.size()), freedoms = table.freedoms().size();
    const std::vector<TaskResult> results = map_in_processes(2 * count + 1, jobs, [&](size_t task) {
        Eigen::VectorXd x = at;
        if (task > 0) x(as_row((task - 1) / 2)) += task % 2 == 1 ? kPlanStep : -kPlanStep;
        return table.find(x);
    });
    for (const TaskResult& result : results)
        if (!result.reason.empty()) throw Error(ExitCode::numerical_failure, result.reason);
    Information information;
    for (size_t b = 0; b < freedoms; ++b) {
        double largest = 0;
        const size_t first = b * freedoms * ResponseTable::kNumbers, numbers = freedoms * ResponseTable::kNumbers;
        for (size_t i = first; i < first + numbers; ++i) largest = std::max(largest, std::abs(results[0].numbers[i]));
        for (size_t s = 0; s < freedoms; ++s) {
            Eigen::MatrixXd J(as_row(ResponseTable::kNumbers), as_row(count));
            for (size_t k = 0; k < count; ++k)
                for (size_t i = 0; i < ResponseTable::kNumbers; ++i) {
                    const size_t own = first + s * ResponseTable::kNumbers + i;
                    J(as_row(i), as_row(k)) =
                        (results[2 * k + 1].numbers[own] - results[2 * k + 2].numbers[own]) / (2 * kPlanStep);
                }
            if (largest > 0) J /= kResponseNoise * largest;
            information.push_back(J.transpose() * J);
        }
    }
    return information;
}

/// Of the logarithms; infinite where the information does not fix them.
double worst_deviation(const Eigen::MatrixXd& information) {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(information);
    constexpr double kRank = 1e-10;  // squares of derivatives that are known to 1e-5
    if (!(solver.eigenvalues()(0) > kRank * solver.eigenvalues()(information.rows() - 1)))
        return std::numeric_limits<double>::infinity();
    return std::sqrt(information.inverse().diagonal().maxCoeff());
}

PlannedBlow plan_blow(const ResponseTable& table, size_t blow, const std::vector<Information>& points,
                      const std::vector<std::string>& suspects) {
    const size_t freedoms = table.freedoms().size();
    PlannedBlow planned;
    planned.blow = table.freedoms()[blow].name;
    std::vector<Eigen::MatrixXd> sums(points.size(),
                                      Eigen::MatrixXd::Zero(as_row(suspects.size()), as_row(suspects.size())));
    std::vector<size_t> taken;
    while (taken.size() < std::min(kMostSensors, freedoms)) {
        double best = -std::numeric_limits<double>::infinity();
        size_t chosen = freedoms;
        for (size_t s = 0; s < freedoms; ++s) {
            if (std::ranges::find(taken, s) != taken.end()) continue;
            double volume = 0;  // logarithm of the determinant, the least informed direction kept finite
            for (size_t p = 0; p < points.size(); ++p) {
                const Eigen::MatrixXd sum = sums[p] + points[p][blow * freedoms + s];
                const double scale = std::max(1e-300, sum.diagonal().maxCoeff());
                const Eigen::VectorXd values =
                    Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(sum, Eigen::EigenvaluesOnly).eigenvalues();
                for (const double value : values) volume += std::log(std::max(value, 1e-12 * scale));
            }
            if (volume > best) {
                best = volume;
                chosen = s;
            }
        }
        taken.push_back(chosen);
        planned.sensors.push_back(table.freedoms()[chosen].name);
        for (size_t p = 0; p < points.size(); ++p) sums[p] += points[p][blow * freedoms + chosen];
    }
    for (const Eigen::MatrixXd& sum : sums) planned.worst = std::max(planned.worst, worst_deviation(sum));
    for (size_t i = 0; i < suspects.size(); ++i)
        for (size_t j = i + 1; j < suspects.size(); ++j) {
            const bool is_tied = std::ranges::any_of(sums, [&](const Eigen::MatrixXd& F) {
                const auto a = as_row(i), b = as_row(j);
                return std::abs(F(a, b)) >= kTiedPlan * std::sqrt(F(a, a) * F(b, b));
            });
            if (is_tied) planned.ties.push_back({suspects[i], suspects[j]});
        }
    return planned;
}

}  // namespace

ExitCode plan_test(const Request& request, const Plugins& plugins, const std::vector<std::string>& suspects) {
    const ResponseTable table(request, plugins, suspects);
    const auto count = as_row(suspects.size());
    std::vector<Information> points = {find_information(table, Eigen::VectorXd::Zero(count), request.jobs)};
    const Eigen::MatrixXd shares = make_probabilities(Design::sobol, kPoints, count, 1);
    for (int p = 0; p < kPoints; ++p)
        points.push_back(
            find_information(table, kPlanScatter * (2 * shares.row(p).transpose().array() - 1).matrix(), request.jobs));
    std::vector<PlannedBlow> plan;
    for (size_t b = 0; b < table.freedoms().size(); ++b) plan.push_back(plan_blow(table, b, points, suspects));
    std::ranges::stable_sort(plan, [](const PlannedBlow& a, const PlannedBlow& b) {
        return a.worst != b.worst ? a.worst < b.worst : a.ties.size() < b.ties.size();
    });
    const ResultsFolder folder(results_path(request, "-diagnose"));
    CsvTable csv({{"blow", ""}, {"sensors", ""}, {"worst_deviation", "1"}, {"ties", ""}});
    const auto words = [](const PlannedBlow& one) {
        std::string text;
        for (const auto& pair : one.ties) text += fmt::format("{}{} and {}", text.empty() ? "" : ", ", pair[0], pair[1]);
        return text;
    };
    for (const PlannedBlow& one : plan)
        csv.add(one.blow).add(fmt::format("{}", fmt::join(one.sensors, " "))).add(one.worst).add(words(one)).end_row();
    write_atomically(folder.file("plan.csv"), csv.text());
    if (request.quiet) return ExitCode::ok;
    fmt::print(
        "responses from {:.4g} to {:.4g} Hz, noise {:g} % of the largest acceleration; the file's stiffnesses and {} random "
        "points within {:g} %\n",
        table.from(), table.to(), 100 * kResponseNoise, kPoints, 100 * kPlanScatter);
    fmt::print("{:<24} {:>22}  {}\n", "blow at", "worst stiffness to", "accelerometers, the most useful first");
    constexpr size_t kShown = 8;
    for (size_t i = 0; i < std::min(kShown, plan.size()); ++i) {
        const PlannedBlow& one = plan[i];
        fmt::print("{:<24} {:>22}  {}{}\n", one.blow, one.worst < 1 ? fmt::format("{:.2g} %", 100 * one.worst) : "not fixed",
                   fmt::join(one.sensors, ", "), one.ties.empty() ? "" : fmt::format("; tied: {}", words(one)));
    }
    fmt::print("results in {}\n", folder.describe("plan.csv"));
    return ExitCode::ok;
}

}  // namespace dttmm::host
