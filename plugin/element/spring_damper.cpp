// SPDX-License-Identifier: BSD-3-Clause
#include "element/spring_damper.h"

#include "core/index.h"
#include "element/law_parameters.h"
#include "element/parameters.h"

namespace dttmm::plugin {

namespace {

constexpr dttmm_parameter kParameters[] = {
    spread3("stiffness", "N/m", "in x, y, z of the from end; one number: the same in all"),
    spread3("damping", "N*s/m", "in x, y, z of the from end; one number: the same in all"),
    spread3("rotational_stiffness", "N*m/rad", "about x, y, z of the from end"),
    spread3("rotational_damping", "N*m*s/rad", "about x, y, z of the from end"),
    zero_by_default("loss_factor", "1", 0, kLossFactorHelp),
};
constexpr size_t kLossFactor = 12, kLinearValues = 13;

}  // namespace

const dttmm_element_type& SpringDamper::type() {
    static TypeWithLaws type(
        {"spring_damper", DTTMM_ENDS_FROM_TO, 0, nullptr,
         "springs and dampers in three translations and three rotations; a direction without either is free"},
        kParameters, TypeWithLaws::all_directions);
    return type.get();
}

SpringDamper::SpringDamper(std::span<const double> values) {
    for (int i = 0; i < 3; ++i) {
        const auto at = [&](int group) { return values[as_size(3 * group + i)]; };
        law_.stiffness(i) = at(0);
        law_.damping(i) = at(1);
        law_.stiffness(3 + i) = at(2);
        law_.damping(3 + i) = at(3);
    }
    law_.loss_factor = values[kLossFactor];
    const auto laws = laws_of_directions(values.subspan(kLinearValues));
    for (int d = 0; d < 6; ++d) {
        if (!laws[as_size(d)]) continue;
        if (law_.stiffness(d) > 0)
            LawParameters::of_direction(d).refuse_stiffness(d < 3 ? "stiffness" : "rotational_stiffness");
        law_.set(d, laws[as_size(d)]);
    }
}

}  // namespace dttmm::plugin
