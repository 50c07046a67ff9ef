// SPDX-License-Identifier: BSD-3-Clause
#include "element/beam.h"

#include <fmt/format.h>

#include "core/error.h"
#include "core/index.h"
#include "element/divided_line.h"
#include "element/parameters.h"

namespace dttmm::plugin {

namespace {

/// Between neighbouring segments, of which a link knows the shortening to second order: a bar bent by 2 rad in links of
/// 0.5 rad has its end 0.4 % of its length from where it belongs, of 0.25 rad 0.06 %.
constexpr double kMostTurn = 0.5;  // [rad]
/// Of the ends of a link against each other, of its length: the law along it is linear, and -1 leaves no length. A sheared
/// link whose ends are farther apart than it is long may have no strain at all.
constexpr double kMostShift = 0.5;

constexpr dttmm_word kTheories[] = {{"euler-bernoulli", 0}, {"timoshenko", 1}};

constexpr auto kParameters = with_section<3>(
    {{{"theory", "1", 1, DTTMM_PARAMETER_WORDS_ONLY, 1, 0, 1, kTheories, std::size(kTheories),
       "of bending, without or with shear"},
      segments_parameter("lumps in time, one at the middle of each; neighbours may turn by 0.5 rad against each other, and "
                         "under a pull N an end may lack 0.02 rad, as segments are longer than sqrt(EI/N); the strain N/EA "
                         "may be 0.5"),
      optional("up", "1", 3, -kLargest, kLargest, "local z as near to it as can be; world z, x for a vertical beam")}});

void require(double value, const char* key) {
    if (is_given(value)) return;
    const bool is_shear = key[0] == 'G' && key[1] == 'A';
    throw Error(DTTMM_ERROR_MODEL,
                fmt::format("section.{} is needed in runs and at rest{}", key,
                            is_shear ? "; without shear write theory = \"euler-bernoulli\" in its place" : ""));
}

}  // namespace

const dttmm_element_type Beam::kType = {"beam", DTTMM_ENDS_LINE, kParameters.size(), kParameters.data(),
                                        "a uniform beam: axial force, torsion, bending and shear in both planes"};

Beam::Beam(std::span<const double, 5 + kSectionValueCount> values)
    : segments_(static_cast<int>(values[1])),
      up_(values[2], values[3], values[4]),
      section_(make_section(values.last<kSectionValueCount>(),
                            values[0] > 0 ? BeamTheory::timoshenko : BeamTheory::euler_bernoulli)) {}

Parts Beam::discretise(std::span<const Pose> ends) const {
    require(section_.EIy, "EIy");
    require(section_.EIz, "EIz");
    require(section_.GJ, "GJ");
    require(section_.GAy, "GAy");
    require(section_.GAz, "GAz");
    const Matrix3 axes = beam_axes(ends[0].position, ends[1].position, up_);
    const double l = (ends[1].position - ends[0].position).norm() / segments_;
    const Section& s = section_;
    const Vector3 offset(0, s.offset_y, s.offset_z);

    Lump lump;
    lump.mass = s.mass * l;
    const double about_centre = s.inertia - s.mass * offset.squaredNorm();  // polar
    lump.inertia.diagonal() << l * about_centre, l * s.rotary_y + lump.mass * l * l / 12,
        l * s.rotary_z + lump.mass * l * l / 12;
    const auto law_of = [&](double length) {
        JointLaw law;
        const double cube = length * length * length / 12;
        law.stiffness << s.EA / length, 1 / (cube / s.EIz + length / s.GAy), 1 / (cube / s.EIy + length / s.GAz),
            s.GJ / length, s.EIy / length, s.EIz / length;
        law.damping = s.stiffness_damping * law.stiffness;
        law.loss_factor = s.loss_factor;
        // A link bends as its static line does: its sections turn by ϑ = θ x/l, and by 6 b d x (l − x)/l³ of the share
        // b = 1/(1 + Φ) of d that is bending; the rest shears all of it by γ = (1 − b) d/l. Its axial strain is normal to
        // the sections (Reissner): u' + ϑ²/2 + γ ϑ. Along x its ends are l + d_x apart, less θ²/4 of the two levers of half
        // a link: e = d_x + dθ/2 − lθ²/12 + (b − 2 b²/5) d²/l. So a pull straightens the line for any number of links.
        const auto sway = [&](double bending_stiffness, double shear_stiffness) {
            const double b = 1 / (1 + bending_stiffness / (cube * shear_stiffness / length));
            return b * (1 - 0.4 * b) / length;
        };
        law.line = {0.5, length / 12, sway(s.EIz, s.GAy), sway(s.EIy, s.GAz)};
        law.most_shift = kMostShift * length;
        law.most_turn = kMostTurn;
        return law;
    };
    return lay_out(ends, axes, segments_, lump, offset, law_of(l), law_of(0.5 * l), section_.moduli);
}

std::optional<Line> Beam::line(std::span<const Pose> ends) const {
    return Line{beam_axes(ends[0].position, ends[1].position, up_), section_};
}

}  // namespace dttmm::plugin
