// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "dttmm_plugin.h"
#include "element/single_joint.h"

namespace dttmm::plugin {

/// A hinge, bearing, guide or clevis: every direction a spring with a damper, rigid, or free. What is not named is rigid.
/// A direction may have a law of its own. Its axes are those of the `from` end; the force acts at the `to` end.
class ElasticHinge : public SingleJoint {
public:
    /// values: stiffness x y z [N/m] rx ry rz [N m/rad], infinite where rigid and 0 where free; damping likewise; then those
    /// of the other parameters. Throws Error(DTTMM_ERROR_MODEL).
    explicit ElasticHinge(std::span<const double> values);

    /// Of each direction: its law and what laws need.
    static const dttmm_element_type& type();
};

}  // namespace dttmm::plugin
