// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/material_fits.h"

#include <fmt/format.h>

#include <cmath>
#include <span>

#include "model/index.h"
#include "model/read_modes.h"

namespace dttmm::host {

bool has_rows(const dttmm_element_type& type, const std::vector<double>& values) {
    size_t at = 0;
    for (const dttmm_parameter& parameter : std::span(type.parameters, type.parameter_count)) {
        if (parameter.flags & DTTMM_PARAMETER_TABLE && std::isfinite(values[at])) return true;
        at += parameter.count;
    }
    return false;
}

void report_fits(const Model& model, const Plugins& plugins, Warnings& warnings) {
    constexpr double kPoor = 0.1;  // of the stiffness: as much as rubber parts scatter
    dttmm_fit worst{};
    const Element* of = nullptr;
    size_t direction = 0, count = 0;
    for (const Element& element : model.elements) {
        if (!has_rows(*plugins.catalogue().types[as_size(element.type)], element.values)) continue;
        const auto [plugin, type] = plugins.resolve(element.type);
        ++count;
        for (uint32_t d = 0; d < 6; ++d)
            if (const dttmm_fit fit = plugin->fit(type, element.values, d); fit.terms > 0 && fit.misfit > worst.misfit) {
                worst = fit;
                of = &element;
                direction = d;
            }
    }
    if (!of) return;
    const std::string text = fmt::format(
        "{}: element \"{}\": in {} a Maxwell series of {} terms stands for its rows; it is off by {:.2g} % at most, at "
        "{:.6g} Hz{}",
        of->place, of->name, kDirections[direction], worst.terms, 100 * worst.misfit, worst.frequency,
        count > 1 ? fmt::format("; those of {} more are not farther off", count - 1) : "");
    if (worst.misfit > kPoor)
        warnings.add("poor-fit",
                     text +
                         ": no material behaves like these rows in time, look at them again; `dttmm response` has "
                         "them as they are");
    else
        warnings.note("fitted-rows", text);
}

}  // namespace dttmm::host
