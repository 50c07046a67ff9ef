// SPDX-License-Identifier: BSD-3-Clause
#include "element/rod.h"

#include "core/error.h"
#include "core/index.h"
#include "element/divided_line.h"
#include "element/parameters.h"

namespace dttmm::plugin {

namespace {

constexpr auto kParameters = with_section<1>({segments_parameter("lumps in time: one mass at the middle of each")});

}  // namespace

const dttmm_element_type Rod::kType = {"rod", DTTMM_ENDS_LINE, kParameters.size(), kParameters.data(),
                                       "a uniform bar with axial waves, rigid otherwise"};

Rod::Rod(std::span<const double, 1 + kSectionValueCount> values)
    : segments_(static_cast<int>(values[0])),
      section_(make_section(values.last<kSectionValueCount>(), BeamTheory::euler_bernoulli)) {
    if (section_.offset_y != 0 || section_.offset_z != 0)
        throw Error(DTTMM_ERROR_MODEL, "section.mass_offset: a rod's mass is on its axis; make it a beam");
}

std::optional<Line> Rod::line(std::span<const Pose> ends) const {
    const Vector3 up = Vector3::Constant(kNotGiven);
    return Line{beam_axes(ends[0].position, ends[1].position, up), section_, true};
}

Parts Rod::discretise(std::span<const Pose> ends) const {
    const Vector3 up = Vector3::Constant(kNotGiven);
    const Matrix3 axes = beam_axes(ends[0].position, ends[1].position, up);
    const double l = (ends[1].position - ends[0].position).norm() / segments_;
    Lump lump;
    lump.mass = section_.mass * l;
    const double polar = is_given(section_.inertia) ? section_.inertia : 0;
    lump.inertia.diagonal() << l * polar, lump.mass * l * l / 12, lump.mass * l * l / 12;
    const auto law_of = [&](double length) {
        JointLaw law;
        law.stiffness(0) = section_.EA / length;
        law.damping(0) = section_.stiffness_damping * law.stiffness(0);
        law.loss_factor = section_.loss_factor;
        for (size_t d = 1; d < 6; ++d) law.rigid.set(d);
        return law;
    };
    return lay_out(ends, axes, segments_, lump, Vector3::Zero(), law_of(l), law_of(0.5 * l), section_.moduli);
}

}  // namespace dttmm::plugin
