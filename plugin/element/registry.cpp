// SPDX-License-Identifier: BSD-3-Clause
#include "element/registry.h"

#include <fmt/format.h>

#include <array>
#include <cmath>

#include "core/error.h"
#include "element/axial_spring.h"
#include "element/beam.h"
#include "element/elastic_hinge.h"
#include "element/mass.h"
#include "element/spring_damper.h"

namespace dttmm::plugin {

namespace {

using Maker = std::unique_ptr<const Element> (*)(const double* values);

template <class E, size_t value_count>
std::unique_ptr<const Element> make(const double* values) {
    return std::make_unique<const E>(std::span<const double, value_count>(values, value_count));
}

/// Of an element whose number of values the table of laws decides.
template <class E>
std::unique_ptr<const Element> make_counted(const double* values) {
    uint32_t count = 0;
    for (uint32_t p = 0; p < E::type().parameter_count; ++p) count += E::type().parameters[p].count;
    return std::make_unique<const E>(std::span(values, count));
}

// One line per element, in both tables.
std::span<const dttmm_element_type> types() {
    static const std::array all = {SpringDamper::type(), ElasticHinge::kType, PointMass::kType,   RigidBody::kType,
                                   Beam::kType,          Rod::kType,          AxialSpring::type()};
    return all;
}
constexpr std::array kMakers = {make_counted<SpringDamper>, make<ElasticHinge, 12>, make<PointMass, 1>,
                                make<RigidBody, 10>,        make<Beam, 26>,         make<Rod, 22>,
                                make_counted<AxialSpring>};

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

std::span<const dttmm_element_type> element_types() { return types(); }

std::unique_ptr<const Element> make_element(uint32_t type, const double* values) {
    if (type >= kMakers.size()) throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("there is no element type {}", type));
    if (values == nullptr) throw Error(DTTMM_ERROR_ARGUMENT, "the element has no values");
    check_values(types()[type], values);
    return kMakers[type](values);
}

}  // namespace dttmm::plugin
