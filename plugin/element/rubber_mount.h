// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "dttmm_plugin.h"
#include "element/single_joint.h"

namespace dttmm::plugin {

/// A mount of rubber: in each direction a stiffness and a loss angle that depend on the frequency, from measured rows. A
/// direction without rows is free. See law/viscoelastic.h for what it is in time.
class RubberMount : public SingleJoint {
public:
    static constexpr uint32_t kMostRows = 64;

    /// values: of every direction its rows. Throws Error(DTTMM_ERROR_MODEL) for a loss angle of 90 degrees or more.
    explicit RubberMount(std::span<const double> values);

    static const dttmm_element_type kType;
};

}  // namespace dttmm::plugin
