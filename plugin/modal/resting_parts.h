// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "mechanism/joint.h"
#include "modal/frequency_model.h"
#include "modal/line_forces.h"
#include "statics/at_rest.h"

namespace dttmm::plugin {

/// What a section has per length at the start, per length at rest; stretch: of these. A run strains it per length at the
/// start.
void scale_to(Section& section, double stretch);

/// What a machine at rest adds to a FrequencyModel: where its frames are, the tangents of its joints there, and what the
/// forces there do as they turn with what they act on.
class RestingParts {
public:
    /// Keeps all.
    RestingParts(FrequencyModel& model, const dttmm_modal_model& description, const AtRest& rest)
        : model_(model), description_(description), rest_(rest) {}

    /// How far lines are bent, and their forces. Their joints are those of the lumps of the network that came to rest.
    void find_lines();
    LineForces forces_of(const LineSpec& line) const;
    /// Moves the frames of the assembly to where they rest; the link of every joint there.
    std::vector<const AtRest::Link*> place(Assembly& assembly) const;
    /// at: its frames, and from, to: their numbers in the model.
    void add_joint(const Joint& joint, const AtRest::Link& link, Ends at, int from, int to);
    /// What the forces of a constraint add to the bond that was added last, 12 × 12.
    void turn_constraint(const double* stiffness, double factor);
    /// What loads add that turn with the frames on which they act, or whose lever arms do. frame_of: of the assembly's
    /// frames those of the model.
    void add_loads(const Assembly& assembly, const std::vector<int>& frame_of);
    /// What the forces of a bar do as it turns with a frame.
    void add_bar_force(const LineModel& line, const LineForces& forces);
    /// What forces of a piece of a line but the axial one of its waves do: K, local axes.
    void add_deviation(const LineModel& line, const Matrix12& K);
    /// What a force that keeps its direction adds as its lever arm turns with a frame: symmetric part.
    void add_lever(int element, int frame, const Vector3& point, const Vector3& force);

private:
    Vector6 line_load(int element, uint32_t axes) const;

    FrequencyModel& model_;
    const dttmm_modal_model& description_;
    const AtRest& rest_;
};

}  // namespace dttmm::plugin
