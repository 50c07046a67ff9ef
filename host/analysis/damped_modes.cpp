// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/damped_modes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "analysis/modal_session.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/csv_table.h"

namespace dttmm::host {

namespace {

constexpr double kTurn = 2 * std::numbers::pi;

/// Neither vibrates nor decays.
bool is_rigid(const ModalInstance::Damped& mode) { return mode.s == 0.0; }

double ratio(const ModalInstance::Damped& mode) { return std::abs(mode.s) > 0 ? (0 - mode.s.real()) / std::abs(mode.s) : 0; }

bool grows(const ModalInstance::Damped& mode) { return !is_rigid(mode) && mode.s.real() > 1e-9 * std::abs(mode.s); }

const char* in_words(const ModalInstance::Damped& mode) {
    if (grows(mode)) return mode.s.imag() == 0 ? "  grows without vibration" : "  grows";
    return mode.s.imag() == 0 ? "  decays without vibration" : "";
}

}  // namespace

double range_of_damped(const Model& model, const std::vector<ModalInstance::Mode>& modes) {
    constexpr double kBeyond = 1.02;  // a damped frequency may lie above the undamped one
    double last = 0, growth = 0;
    for (const ModalInstance::Mode& mode : modes) {
        last = std::max(last, mode.numbers.frequency);
        growth = std::max(growth, -mode.numbers.frequency);
    }
    return std::max(model.modes.below.value_or(kBeyond * last), kBeyond * growth);
}

namespace {

/// What undamped modes have and the list does not.
void warn_of_missing(const std::vector<ModalInstance::Mode>& undamped, const DampedModes& damped, Warnings& warnings) {
    const auto count = [](const auto& list, const auto& is_one) { return as_size(std::ranges::count_if(list, is_one)); };
    const size_t growing = count(undamped, [](const auto&mode) { return mode.numbers.frequency < 0; }),
                 moving = count(damped.modes, [](const auto&mode) { return !is_rigid(mode); });
    if (growing > 0 && std::ranges::none_of(damped.modes, grows)) {
        warnings.add("damped-growth",
                     fmt::format("without damping {}, and the list with damping has none: a loss factor is a law of steady "
                                 "vibrations and says nothing of what grows. The machine is not stable",
                                 counted(growing, "motion grows", "motions grow")));
        return;
    }
    const size_t vibrating = count(
        undamped, [&](const auto& mode) { return mode.numbers.frequency > 0 && mode.numbers.frequency <= damped.below; });
    if (vibrating > moving)
        warnings.note("damped-beyond",
                      fmt::format("{} without damping up to {:.6g} Hz, and {} with: damping has moved the others beyond; "
                                  "--below looks farther",
                                  counted(vibrating, "mode vibrates", "modes vibrate"), damped.below, moving));
}

}  // namespace

DampedModes find_damped_modes(ModalMachine& machine, const std::vector<ModalInstance::Mode>& undamped, double below,
                              Warnings& warnings) {
    DampedModes damped{below, {}, 0};
    machine.damp(below);
    damped.modes = machine.find_damped(below, damped.is_proved);
    if (damped.is_proved == 2)
        warnings.note("damped-modes-left-out",
                      "motions that decay without vibration are not listed within 2 % of exp(-t/stiffness_damping), where "
                      "beams have infinitely many, and where a material with rows over frequency relaxes");
    if (damped.is_proved == 0)
        warnings.add("damped-not-proved",
                     "the damped modes are not proved to be all and right: Newton's method would still change some by more "
                     "than 1e-8 of themselves (`correction` in damped.csv), or led two to one");
    warn_of_missing(undamped, damped, warnings);
    const bool is_decided = machine.nonconservative().empty();
    for (const ModalInstance::Damped& mode : damped.modes) {
        if (!grows(mode)) continue;
        const std::string how =
            fmt::format("the motion with {:.6g} Hz grows as exp({:.4g} t)", mode.s.imag() / kTurn, mode.s.real());
        if (is_decided)
            warnings.add("damped-mode-grows", how + ": the machine is not stable");
        else
            warnings.add("stability-undecided", undecided(how));
    }
    return damped;
}

std::string damped_table(const DampedModes& damped) {
    CsvTable table({{"mode", "1"},
                    {"damped_frequency", "Hz"},
                    {"frequency", "Hz"},
                    {"damping_ratio", "1"},
                    {"decay", "1/s"},
                    {"correction", "1"}});
    for (size_t m = 0; m < damped.modes.size(); ++m) {
        const ModalInstance::Damped& mode = damped.modes[m];
        const bool rigid = is_rigid(mode);
        table.add(static_cast<double>(m + 1));
        if (rigid)
            table.add(0.0).add(0.0).add(0.0).add(0.0);
        else
            table.add(mode.s.imag() / kTurn).add(std::abs(mode.s) / kTurn).add(ratio(mode)).add(0 - mode.s.real());
        table.add(mode.correction).end_row();
    }
    return table.text();
}

std::string damped_shapes(const ModalMachine& machine, const DampedModes& damped) {
    std::vector<Column> columns = {{"mode", "1"}, {"damped_frequency", "Hz"}, {"place", ""}};
    for (const std::string& direction : direction_names())
        for (const char* part : {".re", ".im"})
            columns.push_back({"u" + direction + part, direction[0] == 'r' ? "1/m" : "1"});
    CsvTable table(columns);
    for (size_t m = 0; m < damped.modes.size(); ++m)
        for (const ModalPlace& place : machine.places()) {
            table.add(static_cast<double>(m + 1)).add(damped.modes[m].s.imag() / kTurn).add(place.name);
            for (const std::complex<double>& u : machine.motion(place, damped.modes[m])) table.add(u.real()).add(u.imag());
            table.end_row();
        }
    return table.text();
}

Json describe(const DampedModes& damped) {
    Json list = Json::array();
    for (const ModalInstance::Damped& mode : damped.modes)
        list.push_back({{"damped_frequency_hz", mode.s.imag() / kTurn},
                        {"frequency_hz", std::abs(mode.s) / kTurn},
                        {"damping_ratio", is_rigid(mode) ? 0 : ratio(mode)},
                        {"decay_per_s", -mode.s.real()},
                        {"correction", mode.correction}});
    return {{"below_hz", damped.below}, {"is_proved", damped.is_proved != 0}, {"modes", list}};
}

void print_damped(const DampedModes& damped) {
    fmt::print("\nwith damping, |s| up to {:.6g} Hz\n{:>4} {:>17} {:>14} {:>9}\n", damped.below, "mode", "damped frequency",
               "|s|/2 pi", "damping");
    for (size_t m = 0; m < damped.modes.size(); ++m) {
        const ModalInstance::Damped& mode = damped.modes[m];
        if (is_rigid(mode))
            fmt::print("{:>4} {:>14} Hz {:>11} Hz {:>9}  rigid\n", m + 1, 0, 0, "");
        else
            fmt::print("{:>4} {:>14.8g} Hz {:>11.8g} Hz {:>7.4g} %{}\n", m + 1, mode.s.imag() / kTurn,
                       std::abs(mode.s) / kTurn, 100 * ratio(mode), in_words(mode));
    }
    fmt::print("{}\n", damped.is_proved ? "complete: all eigenvalues of the linear equations, improved on the exact ones"
                                        : "not proved to be complete");
}

}  // namespace dttmm::host
