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
#include "identify/small_changes.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

namespace {

/// The mode of a figure "mode<n>.frequency", from 0; nothing: it is another figure.
std::optional<size_t> mode_of(const Column& figure) {
    int number = 0, length = 0;
    if (std::sscanf(figure.name.c_str(), "mode%d.frequency%n", &number, &length) != 1 || number < 1) return std::nullopt;
    return as_size(length) == figure.name.size() ? std::optional(as_size(number) - 1) : std::nullopt;
}

/// Slopes of the modes by ln of one parameter and their bends [Hz], as SmallChanges has them.
std::vector<double> slopes_of_modes(const FigureFunction& function, ModalMachine& machine,
                                    const std::vector<ModalInstance::Mode>& modes, Eigen::Index parameter) {
    Warnings silent(Warnings::Silent::yes);
    std::vector<double> slopes;
    for (const double change : SmallChanges::kShares) {
        ModalSession above(function.request_with(parameter, 1 + change), function.plugins(), silent),
            below(function.request_with(parameter, 1 - change), function.plugins(), silent);
        for (size_t m = 0; m < modes.size(); m += modes[m].numbers.multiplicity) {
            const uint32_t multiplicity = modes[m].numbers.multiplicity;
            if (multiplicity == 0 || m + multiplicity > modes.size())
                throw Error(ExitCode::plugin_failure, fmt::format("the multiplicity of mode {} is {}", m + 1, multiplicity));
            const auto changes = [&](ModalMachine& far, ModalMachine& near) {
                return machine.frequency_changes(as_whole<uint32_t>(m), multiplicity, far, near);
            };
            const std::vector<double> both = changes(above.machine, below.machine), up = changes(above.machine, machine),
                                      down = changes(machine, below.machine);
            for (uint32_t i = 0; i < multiplicity; ++i) {
                slopes.push_back(both[i] / change);
                slopes.push_back(2 * std::abs(up[i] - down[i]) / change);
            }
        }
    }
    return slopes;
}

/// A frequency found, with those equal to it: which of the modes they are.
struct Cluster {
    size_t first, end;
    bool has(size_t mode) const { return mode >= first && mode < end; }
};
Cluster cluster_of(const std::vector<ModalInstance::Mode>& modes, size_t mode) {
    size_t first = 0;
    while (first + modes[first].numbers.multiplicity <= mode) first += modes[first].numbers.multiplicity;
    return {first, first + modes[first].numbers.multiplicity};
}

/// Of a figure the frequency, among those found, that a change of each parameter meets first. Where it is near, what a shape
/// has of the other one changes the slope by as much.
void look_beside(const std::vector<ModalInstance::Mode>& modes, size_t mode, const Eigen::MatrixXd& slopes, Eigen::Index f,
                 LocalSensitivity& found) {
    const Cluster own = cluster_of(modes, mode);
    const double frequency = modes[mode].numbers.frequency;
    for (size_t other = 0; other < modes.size(); ++other) {
        if (own.has(other)) continue;
        const double gap = std::abs(modes[other].numbers.frequency - frequency);
        for (Eigen::Index p = 0; p < slopes.cols(); ++p) {
            const double nearer = std::abs(slopes(as_row(other), p) - found.slopes(f, p));
            found.errors(f, p) =
                std::max(found.errors(f, p), modes[mode].numbers.bracket * std::abs(frequency) / gap * nearer);
            if (gap >= found.reach(f, p) * nearer) continue;
            found.reach(f, p) = gap / nearer;
            found.competing(f, p) = slopes(as_row(other), p);
        }
    }
}

}  // namespace

bool is_natural_frequency(const Column& figure) { return mode_of(figure).has_value(); }

bool differentiate_modes(const FigureFunction& function, int jobs, LocalSensitivity& found, std::string& reason) {
    Warnings silent(Warnings::Silent::yes);
    ModalSession session(function.plan().request, function.plugins(), silent);
    const std::vector<ModalInstance::Mode> modes = session.find_modes();
    const auto parameters = as_size(function.nominal().size());
    const std::vector<TaskResult> results = map_in_processes(
        parameters, jobs, [&](size_t p) { return slopes_of_modes(function, session.machine, modes, as_row(p)); });
    reason = first_reason(results);
    if (!reason.empty()) return false;
    const auto [slopes, errors] = SmallChanges(results, modes.size());
    for (Eigen::Index f = 0; f < found.slopes.rows(); ++f) {
        const std::optional<size_t> mode = mode_of(function.figures()[as_size(f)]);
        if (!mode || *mode >= modes.size()) continue;
        found.figures(f) = modes[*mode].numbers.frequency;
        found.slopes.row(f) = slopes.row(as_row(*mode));
        found.errors.row(f) = errors.row(as_row(*mode));
        look_beside(modes, *mode, slopes, f, found);
    }
    return true;
}

}  // namespace dttmm::host
