// SPDX-License-Identifier: BSD-3-Clause
#include "element/elastic_hinge.h"

#include "core/error.h"
#include "core/index.h"
#include "core/state_vector.h"
#include "element/law_parameters.h"
#include "element/parameters.h"

namespace dttmm::plugin {

namespace {

constexpr dttmm_word kWords[] = {{"free", 0}, {"rigid", kRigid}};

constexpr dttmm_parameter stiffness(const char* name, const char* unit) {
    return {name, unit, 1, 0, kRigid, 0, kLargest, kWords, std::size(kWords), "in that direction of the from end, or free"};
}
constexpr dttmm_parameter damping(const char* name, const char* unit) {
    return zero_by_default(name, unit, 0, "beside the stiffness");
}

constexpr dttmm_parameter kParameters[] = {
    stiffness("stiffness.x", "N/m"),
    stiffness("stiffness.y", "N/m"),
    stiffness("stiffness.z", "N/m"),
    stiffness("stiffness.rx", "N*m/rad"),
    stiffness("stiffness.ry", "N*m/rad"),
    stiffness("stiffness.rz", "N*m/rad"),
    damping("damping.x", "N*s/m"),
    damping("damping.y", "N*s/m"),
    damping("damping.z", "N*s/m"),
    damping("damping.rx", "N*m*s/rad"),
    damping("damping.ry", "N*m*s/rad"),
    damping("damping.rz", "N*m*s/rad"),
    zero_by_default("loss_factor", "1", 0, kLossFactorHelp),
};

constexpr size_t kLossFactor = 12, kLinearValues = 13;

}  // namespace

const dttmm_element_type& ElasticHinge::type() {
    static TypeWithLaws type({"elastic_hinge", DTTMM_ENDS_FROM_TO, 0, nullptr,
                              "a joint elastic, rigid or free per direction; what is not named is rigid"},
                             kParameters, TypeWithLaws::all_directions);
    return type.get();
}

ElasticHinge::ElasticHinge(std::span<const double> values) {
    law_.loss_factor = values[kLossFactor];
    const auto laws = laws_of_directions(values.subspan(kLinearValues));
    for (size_t d = 0; d < 6; ++d) {
        law_.rigid[d] = std::isinf(values[d]) && !laws[d];  // as what is not named is
        law_.damping(as_int(d)) = values[6 + d];
        if (law_.rigid[d] && values[6 + d] > 0)
            throw Error(DTTMM_ERROR_MODEL, std::string("damping.") + kDirectionNames[d] +
                                               ": the hinge is rigid in that direction; give it a stiffness, or \"free\"");
        if (law_.rigid[d]) continue;
        if (!laws[d]) {
            law_.stiffness(as_int(d)) = values[d];
            continue;
        }
        if (std::isfinite(values[d]) && values[d] > 0) LawParameters::of_direction(as_int(d)).refuse_stiffness("stiffness");
        law_.set(as_int(d), laws[d]);
    }
}

}  // namespace dttmm::plugin
