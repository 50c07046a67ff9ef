// SPDX-License-Identifier: BSD-3-Clause
#include "element/beam.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <array>

#include "core/error.h"
#include "core/state_vector.h"
#include "element/parameters.h"

namespace dttmm::plugin {

namespace {

constexpr double kShortest = 1e-6;  // [m]
/// Between neighbouring segments, of which a link knows the shortening to second order: a bar bent by 2 rad in links of
/// 0.5 rad has its end 0.4 % of its length from where it belongs, of 0.25 rad 0.06 %.
constexpr double kMostTurn = 0.5;  // [rad]

constexpr dttmm_word kTheories[] = {{"euler-bernoulli", 0}, {"timoshenko", 1}};

constexpr dttmm_parameter segments(const char* documentation) {
    return {"segments", "1", 1, DTTMM_PARAMETER_INTEGER, 10, 1, 100000, nullptr, 0, documentation};
}

template <size_t first>
constexpr auto with_section(const std::array<dttmm_parameter, first>& own) {
    std::array<dttmm_parameter, first + kSectionParameters.size()> all{};
    std::copy(own.begin(), own.end(), all.begin());
    std::copy(kSectionParameters.begin(), kSectionParameters.end(), all.begin() + first);
    return all;
}

constexpr auto kBeamParameters = with_section<3>(
    {{{"theory", "1", 1, DTTMM_PARAMETER_WORDS_ONLY, 1, 0, 1, kTheories, std::size(kTheories),
       "of bending, without or with shear"},
      segments("lumps in time, one at the middle of each; neighbours may turn by 0.5 rad against each other"),
      optional("up", "1", 3, -kLargest, kLargest, "local z as near to it as can be; world z, x for a vertical beam")}});
constexpr auto kRodParameters = with_section<1>({segments("lumps in time: one mass at the middle of each")});

/// Half a segment, a whole one, …, and half a one again: lumps at the middle of their segments on joints at the middle of
/// the spans between them.
Parts lay_out(std::span<const Pose> ends, const Matrix3& axes, int segments, const Lump& lump, const Vector3& offset,
              const auto& law_of_length) {
    const Vector3 start = ends[0].position, way = ends[1].position - start;
    const double length = way.norm() / segments;
    const auto point = [&](double segment) { return Vector3(start + segment / segments * way); };
    Parts parts;
    for (int i = 0; i < segments; ++i) {
        parts.lumps.push_back(lump);
        parts.lumps.back().pose = {point(i + 0.5) + axes * offset, axes};
    }
    const auto law = std::make_shared<const JointLaw>(law_of_length(length)),
               law_of_half = std::make_shared<const JointLaw>(law_of_length(0.5 * length));
    for (int i = 0; i <= segments; ++i) {
        const bool half = i == 0 || i == segments;
        const double middle = i == 0 ? 0.25 : i == segments ? segments - 0.25 : i;
        parts.joints.push_back(
            {i == 0 ? 0 : 1 + i, i == segments ? 1 : 2 + i, half ? law_of_half : law, {point(middle), axes}});
    }
    return parts;
}

void require(double value, const char* key) {
    if (!is_given(value)) throw Error(DTTMM_ERROR_MODEL, fmt::format("section.{} is needed in time", key));
}

}  // namespace

const dttmm_element_type Beam::kType = {"beam", DTTMM_ENDS_ALONG, kBeamParameters.size(), kBeamParameters.data(),
                                        "a uniform beam: axial force, torsion, bending and shear in both planes"};

const dttmm_element_type Rod::kType = {"rod", DTTMM_ENDS_ALONG, kRodParameters.size(), kRodParameters.data(),
                                       "a uniform bar with axial waves, rigid otherwise"};

Beam::Beam(std::span<const double, 5 + kSectionValueCount> values)
    : segments_(static_cast<int>(values[1])),
      up_(values[2], values[3], values[4]),
      section_(make_section(values.last<kSectionValueCount>(),
                            values[0] > 0 ? BeamTheory::timoshenko : BeamTheory::euler_bernoulli)) {}

Rod::Rod(std::span<const double, 1 + kSectionValueCount> values)
    : segments_(static_cast<int>(values[0])),
      section_(make_section(values.last<kSectionValueCount>(), BeamTheory::euler_bernoulli)) {
    if (section_.offset_y != 0 || section_.offset_z != 0)
        throw Error(DTTMM_ERROR_MODEL, "section.mass_offset: a rod's mass is on its axis; make it a beam");
}

Matrix3 beam_axes(const Vector3& from, const Vector3& to, const Vector3& up) {
    const double length = (to - from).norm();
    if (!(length >= kShortest))
        throw Error(
            DTTMM_ERROR_MODEL,
            fmt::format("its ends are {:.3g} m apart; it needs a length of at least {:g} m. An end on \"ground\" lies "
                        "where the other end is: to clamp it elsewhere give it a node with all of fixed = [\"x\", "
                        "\"y\", \"z\", \"rx\", \"ry\", \"rz\"]",
                        length, kShortest));
    const Vector3 x = (to - from) / length;
    Vector3 z;
    if (up.array().isNaN().any()) {
        const bool is_vertical = x.head<2>().norm() < 1e-6;
        z = is_vertical ? Vector3::UnitX() : Vector3::UnitZ();
    } else {
        if (!(up.norm() > 0) || x.cross(up.normalized()).norm() < 1e-6)
            throw Error(DTTMM_ERROR_MODEL, "up: it must have a length and must not lie along the beam");
        z = up.normalized();
    }
    // Square to rounding even where z and x are nearly one
    Vector3 y = z.cross(x).normalized();
    y = (y - x * x.dot(y)).normalized();
    Matrix3 axes;
    axes << x, y, x.cross(y);
    return axes;
}

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
    return lay_out(ends, axes, segments_, lump, offset, [&](double length) {
        JointLaw law;
        const double cube = length * length * length / 12;
        law.stiffness << s.EA / length, 1 / (cube / s.EIz + length / s.GAy), 1 / (cube / s.EIy + length / s.GAz),
            s.GJ / length, s.EIy / length, s.EIz / length;
        law.damping = s.stiffness_damping * law.stiffness;
        // A link bends as its static line does: u' = θ x/l from its curvature, and of what d adds b = 1/(1 + Φ) is bending,
        // 6 d x (l − x)/l³, the rest shear, d/l. The line is longer than its way along x by ∫ u'²/2, and that way is l + d_x
        // less θ²/4 of the two levers of half a link: e = d_x + dθ/2 − lθ²/12 + (1 + b²/5) d²/(2l). So a pull straightens
        // the line for any number of links.
        const auto sway = [&](double bending_stiffness, double shear_stiffness) {
            const double b = 1 / (1 + bending_stiffness / (cube * shear_stiffness / length));
            return (1 + b * b / 5) / (2 * length);
        };
        law.line = {0.5, length / 12, sway(s.EIz, s.GAy), sway(s.EIy, s.GAz)};
        law.most_turn = kMostTurn;
        return law;
    });
}

std::optional<Line> Beam::line(std::span<const Pose> ends) const {
    return Line{beam_axes(ends[0].position, ends[1].position, up_), section_};
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
    return lay_out(ends, axes, segments_, lump, Vector3::Zero(), [&](double length) {
        JointLaw law;
        law.stiffness(0) = section_.EA / length;
        law.damping(0) = section_.stiffness_damping * law.stiffness(0);
        for (size_t d = 1; d < 6; ++d) law.rigid.set(d);
        return law;
    });
}

}  // namespace dttmm::plugin
