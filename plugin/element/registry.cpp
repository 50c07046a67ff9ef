// SPDX-License-Identifier: BSD-3-Clause
#include "element/registry.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "core/error.h"
#include "element/axial_spring.h"
#include "element/beam.h"
#include "element/elastic_hinge.h"
#include "element/point_mass.h"
#include "element/rigid_body.h"
#include "element/rod.h"
#include "element/rubber_mount.h"
#include "element/spring_damper.h"
#include "law/registry.h"

namespace dttmm::plugin {

namespace {

template <class E>
const dttmm_element_type& type_of() {
    if constexpr (requires { E::type(); })
        return E::type();
    else
        return E::kType;
}

/// The values of an element, as many as it takes.
struct Values {
    const double* data;
    size_t count;
    template <size_t fixed>
    operator std::span<const double, fixed>() const {
        return std::span<const double, fixed>(data, fixed == std::dynamic_extent ? count : fixed);
    }
};

template <class E>
std::unique_ptr<const Element> make(const double* values) {
    const dttmm_element_type& type = type_of<E>();
    size_t count = 0;
    for (uint32_t p = 0; p < type.parameter_count; ++p) count += type.parameters[p].count;
    return std::make_unique<const E>(Values{values, count});
}

struct Entry {
    const dttmm_element_type& (*type)();
    std::unique_ptr<const Element> (*make)(const double* values);
};
template <class E>
constexpr Entry entry{type_of<E>, make<E>};

// One line per element.
constexpr Entry kEntries[] = {
    entry<SpringDamper>,  //
    entry<ElasticHinge>,  //
    entry<PointMass>,     //
    entry<RigidBody>,     //
    entry<Beam>,          //
    entry<Rod>,           //
    entry<AxialSpring>,   //
    entry<RubberMount>,
};

/// A number in its range, what a word stands for, or nothing where nothing may be given.
bool is_allowed(const dttmm_parameter& parameter, double value) {
    for (uint32_t w = 0; w < parameter.word_count; ++w)
        if (value == parameter.words[w].value) return true;
    if (std::isnan(value)) return std::isnan(parameter.default_value) && !(parameter.flags & DTTMM_PARAMETER_REQUIRED);
    if (parameter.flags & DTTMM_PARAMETER_INTEGER && value != std::round(value)) return false;
    return std::isfinite(value) && value >= parameter.minimum && value <= parameter.maximum;
}

void check_values(const dttmm_element_type& type, const double* values) {
    for (uint32_t p = 0; p < type.parameter_count; ++p) {
        const dttmm_parameter& parameter = type.parameters[p];
        for (uint32_t i = 0; i < parameter.count; ++i, ++values) {
            if (is_allowed(parameter, *values)) continue;
            throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("{} must be finite and in [{}, {}] {}, got {}", parameter.name,
                                                          parameter.minimum, parameter.maximum, parameter.unit, *values));
        }
    }
}

}  // namespace

std::span<const dttmm_element_type> element_types() {
    static size_t laws = 0;
    static std::array<dttmm_element_type, std::size(kEntries)> types;
    if (laws != law_types().size()) {  // their parameters are in them
        laws = law_types().size();
        for (size_t t = 0; t < types.size(); ++t) types[t] = kEntries[t].type();
    }
    return types;
}

std::unique_ptr<const Element> make_element(uint32_t type, const double* values) {
    if (type >= std::size(kEntries)) throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("there is no element type {}", type));
    if (values == nullptr) throw Error(DTTMM_ERROR_ARGUMENT, "the element has no values");
    check_values(kEntries[type].type(), values);
    return kEntries[type].make(values);
}

}  // namespace dttmm::plugin
