// SPDX-License-Identifier: BSD-3-Clause
#include "element/spring_damper.h"

#include "element/parameters.h"

namespace dttmm::plugin {

namespace {

constexpr dttmm_parameter kParameters[] = {
    spread3("stiffness", "N/m", "in x, y, z of the from end; one number: the same in all"),
    spread3("damping", "N*s/m", "in x, y, z of the from end; one number: the same in all"),
    spread3("rotational_stiffness", "N*m/rad", "about x, y, z of the from end"),
    spread3("rotational_damping", "N*m*s/rad", "about x, y, z of the from end"),
};

}  // namespace

const dttmm_element_type SpringDamper::kType = {
    "spring_damper", DTTMM_ENDS_FROM_TO, std::size(kParameters), kParameters,
    "springs and dampers in three translations and three rotations; a direction without either is free"};

SpringDamper::SpringDamper(std::span<const double, 12> values) {
    for (int i = 0; i < 3; ++i) {
        const auto at = [&](int group) { return values[static_cast<size_t>(3 * group + i)]; };
        law_.stiffness(i) = at(0);
        law_.damping(i) = at(1);
        law_.stiffness(3 + i) = at(2);
        law_.damping(3 + i) = at(3);
    }
}

}  // namespace dttmm::plugin
