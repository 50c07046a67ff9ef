// SPDX-License-Identifier: BSD-3-Clause
#include "network/mechanism.h"

#include "core/error.h"

namespace dttmm {

Mechanism::Mechanism(const dttmm_network& description)
    : assembly(assemble(description)), scheme(description.scheme, {description.beta, description.gamma}) {
    for (const JointSpec& spec : assembly.joints) {
        joints.emplace_back(spec, assembly);
        turn_of.push_back(joints.back().turns() ? static_cast<int>(turns.size()) : -1);
        if (joints.back().turns()) turns.emplace_back();
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
