// SPDX-License-Identifier: BSD-3-Clause
#include "element/point_mass.h"

#include "element/parameters.h"

namespace dttmm::plugin {

namespace {

constexpr dttmm_parameter kParameters[] = {kMassParameter};

}  // namespace

const dttmm_element_type PointMass::kType = {"point_mass", DTTMM_ENDS_AT, std::size(kParameters), kParameters,
                                             "a mass without extent at a node"};

Parts PointMass::discretise(std::span<const Pose> ends) const {
    Parts parts;
    parts.lumps.push_back({mass_, Matrix3::Zero(), ends[0]});
    parts.mounted.assign(ends.size(), 0);
    return parts;
}

}  // namespace dttmm::plugin
