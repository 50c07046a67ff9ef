// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/free_motions.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "analysis/mode_energies.h"
#include "model/wording.h"

namespace dttmm::host {

std::string FreeMotions::text() const {
    const std::string motions = fmt::format("{}holds {}", is_certain ? "nothing " : "nothing, or too little to be seen, ",
                                            counted(count, "motion", "motions"));
    return names.empty() ? motions : fmt::format("{} ({})", motions, fmt::join(names, "; "));
}

std::optional<FreeMotions> find_free(const Model& model, ModalMachine& machine) {
    const std::optional<uint32_t> count = machine.count_free();
    if (!count) return std::nullopt;
    FreeMotions free{*count, {}, *count == 0 || model.elements.empty()};
    const bool is_loose = model.elements.empty() && model.joints.empty();  // all of it
    if (free.count == 0 || is_loose || free.count > FreeMotions::kMostNamed) return free;
    const std::vector<ModalInstance::Mode> modes = machine.find_modes(machine.count_growing() + free.count, 0);
    for (uint32_t m = 0; m < modes.size(); ++m) {
        if (modes[m].numbers.frequency != 0) continue;
        const std::string name = motion_in_words(model, machine, modes[m], energies_of(model, machine, modes[m], m));
        if (std::ranges::find(free.names, name) == free.names.end()) free.names.push_back(name);
    }
    free.is_certain = std::ranges::all_of(modes, [](const ModalInstance::Mode& mode) {
        return mode.numbers.frequency != 0 || mode.numbers.bracket == 0;  // the shapes are strained by nothing
    });
    return free;
}

}  // namespace dttmm::host
