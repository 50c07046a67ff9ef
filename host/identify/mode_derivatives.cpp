// SPDX-License-Identifier: BSD-3-Clause
#include "identify/mode_derivatives.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

#include "analysis/modal_session.h"
#include "identify/forked_map.h"
#include "model/error.h"
#include "model/index.h"
#include "study/case_runner.h"

namespace dttmm::host {

namespace {

/// Changes of a parameter, as shares: each twice the one before. Of a beam's length the stiffness changes by the cube: what
/// three of them leave is 1e-14 of the derivative, and rounding of the smallest 1e-13 of the stiffness over it.
constexpr int kChanges = 3;
constexpr double kSmallest = 5e-4;

constexpr double kEqual = 1e-9;  // share: frequencies this near are one, whose branches have their own slopes

/// The mode of a figure "mode<n>.frequency", from 0; nothing: it is another figure.
std::optional<size_t> mode_of(const Column& figure) {
    int number = 0, length = 0;
    if (std::sscanf(figure.name.c_str(), "mode%d.frequency%n", &number, &length) != 1 || number < 1) return std::nullopt;
    return as_size(length) == figure.name.size() ? std::optional(as_size(number) - 1) : std::nullopt;
}

/// By one parameter: of every mode, of every change, slope by the logarithm [Hz].
std::vector<double> find_slopes(const FigureFunction& function, ModalMachine& machine,
                                const std::vector<ModalInstance::Mode>& modes, Eigen::Index parameter) {
    Warnings silent(Warnings::Silent::yes);
    std::vector<double> slopes(modes.size() * kChanges);
    for (size_t c = 0; c < kChanges; ++c) {
        const double change = kSmallest * std::exp2(c);
        StudyPlan plan = function.plan();
        plan.cases.values = function.nominal().transpose().replicate(2, 1);
        plan.cases.values(0, parameter) *= 1 + change;
        plan.cases.values(1, parameter) *= 1 - change;
        ModalSession above(request_of(plan, 0), function.plugins(), silent),
            below(request_of(plan, 1), function.plugins(), silent);
        for (size_t m = 0; m < modes.size();) {
            const uint32_t multiplicity = modes[m].numbers.multiplicity;
            for (const double one :
                 machine.frequency_changes(static_cast<uint32_t>(m), multiplicity, above.machine, below.machine))
                slopes[kChanges * m++ + c] = one / change;
        }
    }
    return slopes;
}

/// Of every figure the frequency next to it that a change of the parameter meets first, those equal to it left out.
void find_rivals(const std::vector<ModalInstance::Mode>& modes, const std::vector<std::optional<size_t>>& mode_of_figure,
                 const Eigen::MatrixXd& slopes, LocalSensitivity& found) {
    found.rivals.setZero(found.slopes.rows(), found.slopes.cols());
    found.reach.setConstant(found.slopes.rows(), found.slopes.cols(), std::numeric_limits<double>::infinity());
    for (Eigen::Index f = 0; f < found.slopes.rows(); ++f)
        for (size_t other = 0; mode_of_figure[as_size(f)] && other < modes.size(); ++other) {
            const double gap = std::abs(modes[other].numbers.frequency - found.figures(f));
            if (gap <= kEqual * std::abs(found.figures(f))) continue;
            for (Eigen::Index p = 0; p < slopes.cols(); ++p) {
                const double nearer = std::abs(slopes(as_row(other), p) - found.slopes(f, p));
                if (gap >= found.reach(f, p) * nearer) continue;
                found.reach(f, p) = gap / nearer;
                found.rivals(f, p) = slopes(as_row(other), p);
            }
        }
}

}  // namespace

bool are_frequencies(const FigureFunction& function) {
    return function.command() == "modes" &&
           std::ranges::all_of(function.figures(), [](const Column& one) { return mode_of(one).has_value(); });
}

bool differentiate_modes(const FigureFunction& function, int jobs, LocalSensitivity& found, std::string& reason) {
    Warnings silent(Warnings::Silent::yes);
    ModalSession session(function.plan().request, function.plugins(), silent);
    const std::vector<ModalInstance::Mode> modes = session.find_modes();
    if (modes.empty()) return true;
    try {  // with neighbours that are the machine itself
        session.machine.frequency_changes(0, modes.front().numbers.multiplicity, session.machine, session.machine);
    } catch (const Error& error) {
        reason = error.what();
        return false;
    }
    const auto parameters = as_size(function.nominal().size());
    const std::vector<TaskResult> results = map_in_processes(
        parameters, jobs, [&](size_t p) { return find_slopes(function, session.machine, modes, as_row(p)); });
    Eigen::MatrixXd slopes(as_row(modes.size()), as_row(parameters)), errors = slopes;
    for (size_t p = 0; p < parameters; ++p) {
        if (!results[p].reason.empty())
            throw Error(ExitCode::numerical_failure,
                        fmt::format("near the file's values the model has no answer: {}", results[p].reason));
        for (size_t m = 0; m < modes.size(); ++m) {
            // Neville's table of even errors
            const double* at = &results[p].numbers[kChanges * m];
            const double first = at[0] + (at[0] - at[1]) / 3, second = at[1] + (at[1] - at[2]) / 3;
            slopes(as_row(m), as_row(p)) = first + (first - second) / 15;
            errors(as_row(m), as_row(p)) = std::abs(first - second);
        }
    }
    std::vector<std::optional<size_t>> mode_of_figure;
    for (Eigen::Index f = 0; f < found.slopes.rows(); ++f) {
        const std::optional<size_t> mode = mode_of(function.figures()[as_size(f)]);
        mode_of_figure.push_back(mode && *mode < modes.size() ? mode : std::nullopt);
        if (!mode_of_figure.back()) continue;
        found.figures(f) = modes[*mode].numbers.frequency;
        found.slopes.row(f) = slopes.row(as_row(*mode));
        found.errors.row(f) = errors.row(as_row(*mode));
    }
    find_rivals(modes, mode_of_figure, slopes, found);
    return true;
}

}  // namespace dttmm::host
