// SPDX-License-Identifier: BSD-3-Clause
#include "model/element_scale.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/error.h"
#include "model/units.h"
#include "model/wording.h"

namespace dttmm::host {

namespace {

bool is_of(const dttmm_parameter& parameter, ScaledPart part) {
    const auto is_any = [&](std::initializer_list<const char*> units) {
        return std::ranges::any_of(units, [&](const char* unit) { return measures(parameter.unit, unit); });
    };
    if (std::string_view(parameter.unit) == "1") return false;
    return part == ScaledPart::damping ? is_any({"N*s/m", "N*m*s/rad"}) : is_any({"N/m", "N*m/rad", "N/m^3", "Pa"});
}

/// Calls act(number) for all numbers of a kind that are there and not zero.
template <class Numbers, class Act>
void for_each_of(const Element& element, Numbers& values, const ElementCatalogue& catalogue, ScaledPart part,
                 const Act& act) {
    const dttmm_element_type& type = *catalogue.types[as_size(element.type)];
    size_t at = 0;
    for (uint32_t p = 0; p < type.parameter_count; at += type.parameters[p++].count) {
        if (!is_of(type.parameters[p], part)) continue;
        for (size_t i = at; i < at + type.parameters[p].count; ++i)
            if (std::isfinite(values[i]) && values[i] != 0) act(values[i]);
    }
}

}  // namespace

bool has_part(const Element& element, const ElementCatalogue& catalogue, ScaledPart part) {
    bool has = false;
    for_each_of(element, element.values, catalogue, part, [&](double) { has = true; });
    return has;
}

void scale_element(Model& model, const ElementCatalogue& catalogue, const ElementScale& scale) {
    const auto element = std::ranges::find(model.elements, scale.element, &Element::name);
    if (element == model.elements.end())
        throw Error(ExitCode::model_invalid, fmt::format("there is no element {}", quote(scale.element)));
    for (const auto& [part, factor] :
         {std::pair(ScaledPart::stiffness, scale.stiffness), std::pair(ScaledPart::damping, scale.damping)}) {
        if (factor == 1) continue;
        if (!has_part(*element, catalogue, part))
            throw Error(ExitCode::model_invalid, fmt::format("element {} has no {}", quote(scale.element),
                                                             part == ScaledPart::stiffness ? "stiffness" : "damping"));
        for_each_of(*element, element->values.change(), catalogue, part, [f = factor](double& value) { value *= f; });
    }
}

}  // namespace dttmm::host
