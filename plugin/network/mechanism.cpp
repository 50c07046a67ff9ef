// SPDX-License-Identifier: BSD-3-Clause
#include "network/mechanism.h"

#include "core/error.h"

namespace dttmm::plugin {

Mechanism::Mechanism(const dttmm_network& description)
    : assembly(assemble(description)), scheme(description.scheme, {description.beta, description.gamma}) {
    for (const JointSpec& spec : assembly.joints) {
        joints.emplace_back(spec, assembly);
        const bool keeps_rates = joints.back().is_damped() || joints.back().has_laws() || scheme.lag() != 0;
        damper_of.push_back(keeps_rates ? static_cast<int>(dampers.size()) : -1);
        if (keeps_rates) dampers.emplace_back();
    }
    states.resize(joints.size());
    for (const FrameSpec& frame : assembly.frames) frames.push_back(make_frame(frame.pose));
    before = frames;
}

}  // namespace dttmm::plugin
