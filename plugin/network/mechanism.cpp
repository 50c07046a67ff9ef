// SPDX-License-Identifier: BSD-3-Clause
#include "network/mechanism.h"

#include "core/error.h"

namespace dttmm {

Mechanism::Mechanism(const dttmm_network& description)
    : assembly(assemble(description)), scheme(description.scheme, {description.beta, description.gamma}) {
    for (const JointSpec& spec : assembly.joints) {
        joints.emplace_back(spec, assembly);
        const bool wants_rates = joints.back().is_damped() || scheme.lag() != 0;
        damper_of.push_back(wants_rates ? static_cast<int>(dampers.size()) : -1);
        if (wants_rates) dampers.emplace_back();
    }
    states.resize(joints.size());
    for (const FrameSpec& frame : assembly.frames) frames.push_back(make_frame(frame.pose));
    before = frames;
}

Frame make_frame(const Pose& pose) {
    Frame frame;
    Eigen::Map<Vector3>{frame.position} = pose.position;
    Eigen::Map<RowMajor3>{frame.rotation} = pose.rotation;
    return frame;
}

}  // namespace dttmm
