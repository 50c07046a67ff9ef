// SPDX-License-Identifier: BSD-3-Clause
#include "mechanism/mechanism.h"

#include <memory>
#include <unordered_map>

#include "core/error.h"
#include "core/index.h"

namespace dttmm::plugin {

Mechanism::Mechanism(const dttmm_network& description, std::span<const int> supported_by)
    : assembly(assemble(description, Waves::lumped, nullptr, supported_by)),
      scheme(description.scheme, {description.beta, description.gamma}) {
    const size_t count = assembly.joints.size();
    int damper_count = 0;
    std::unordered_map<const JointLaw*, std::shared_ptr<JointKind>> kinds;
    joints.reserve(count);
    damper_of.reserve(count);
    memory_of.reserve(count);
    for (const JointSpec& spec : assembly.joints) {
        std::shared_ptr<JointKind>& kind = kinds[spec.law.get()];
        if (!kind) kind = std::make_shared<JointKind>(spec.law);
        joints.emplace_back(spec, assembly, kind);
        const bool keeps_rates = joints.back().is_damped() || joints.back().has_laws() || scheme.lag() != 0;
        damper_of.push_back(keeps_rates ? damper_count++ : -1);
        const size_t memory = spec.law->memory_before(6);
        memory_of.push_back(memory > 0 ? as_int(law_memory.size()) : -1);
        law_memory.resize(law_memory.size() + memory);
    }
    states.resize(count);
    dampers.resize(as_size(damper_count));
    frames = described_frames(*this);
    before = frames;
    law_memory_before = law_memory;
    Joint::Strained unused;
    for (size_t j = 0; j < joints.size(); ++j)
        if (joints[j].has_laws()) joints[j].start_laws(ends(j), pose(j), law_memory_of(j), unused);
}

std::vector<Frame> described_frames(const Mechanism& mechanism) {
    std::vector<Frame> frames;
    frames.reserve(mechanism.assembly.frames.size());
    for (const FrameSpec& frame : mechanism.assembly.frames) frames.push_back(make_frame(frame.pose));
    return frames;
}

}  // namespace dttmm::plugin
