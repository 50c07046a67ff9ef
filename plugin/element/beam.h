// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "dttmm_plugin.h"
#include "element/element.h"
#include "element/section.h"

namespace dttmm::plugin {

/// A straight uniform beam: axial force, torsion, and bending in both planes by Euler-Bernoulli's or Timoshenko's theory.
/// Local axes: x from the `from` end to the `to` end, z as near to `up` as can be, which is world z, for a vertical beam
/// world x.
///
/// In time it is lumped, after the bond-space paper: `segments` rigid masses, each at the middle of its segment, with the
/// inertia of the segment, on massless springs that are exactly the beam between the mass centres, and half a segment at
/// each end. A uniform massless beam of length l, seen at its middle, is a joint without coupling,
///     axial EA/l, shear 1/(l³/(12 EI) + l/κGA), torsion GJ/l, bending EI/l.
/// Frequencies err by 1277 %/segments² at the sixth bending mode of a slender tube. Large motions are allowed, as long as
/// neighbouring segments turn little against each other (0.1 rad, say): strains are small then.
/// Source: bond-space paper, eq. (7) and (8) corrected (they are no compliances as printed).
class Beam : public Element {
public:
    /// values: theory (0 Euler-Bernoulli, 1 Timoshenko), segments, up x y z, then those of make_section.
    explicit Beam(std::span<const double, 5 + kSectionValueCount> values);

    static const dttmm_element_type kType;

    const Section& section() const { return section_; }
    Parts discretise(std::span<const Pose> ends) const override;
    std::optional<Line> line(std::span<const Pose> ends) const override;

private:
    int segments_;
    Vector3 up_;  ///< not a number: not given
    Section section_;
};

}  // namespace dttmm::plugin
