// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/mechanism.h"

#include "core/error.h"
#include "core/index.h"

namespace dttmm::plugin {

Mechanism::Mechanism(const dttmm_network& description)
    : assembly(assemble(description)), scheme(description.scheme, {description.beta, description.gamma}) {
    for (const JointSpec& spec : assembly.joints) {
        joints.emplace_back(spec, assembly);
        const bool keeps_rates = joints.back().is_damped() || joints.back().has_laws() || scheme.lag() != 0;
        damper_of.push_back(keeps_rates ? as_int(dampers.size()) : -1);
        if (keeps_rates) dampers.emplace_back();
        const size_t memory = spec.law->memory_before(6);
        memory_of.push_back(memory > 0 ? as_int(law_memory.size()) : -1);
        law_memory.resize(law_memory.size() + memory);
    }
    states.resize(joints.size());
    for (const FrameSpec& frame : assembly.frames) frames.push_back(make_frame(frame.pose));
    before = frames;
    law_memory_before = law_memory;
    Joint::Strained unused;
    for (size_t j = 0; j < joints.size(); ++j)
        if (joints[j].has_laws()) joints[j].start_laws(ends(j), pose(j), law_memory_of(j), unused);
}

}  // namespace dttmm::plugin
