// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>

#include "element/element.h"
#include "element/parameters.h"
#include "element/section.h"

namespace dttmm::plugin {

// What beams and rods share: straight elements that are divided into segments in time.

/// Local axes of a straight element. Throws Error(DTTMM_ERROR_MODEL) where it has no length or `up` lies along it; an `up`
/// that is not a number leaves the choice as above.
Matrix3 beam_axes(const Vector3& from, const Vector3& to, const Vector3& up);

/// The parameter `segments`.
constexpr dttmm_parameter segments_parameter(const char* documentation) {
    return {"segments", "1", 1, DTTMM_PARAMETER_INTEGER, 10, 1, 100000, nullptr, 0, documentation};
}

/// Parameters of an element with those of its section behind them.
template <size_t first>
constexpr auto with_section(const std::array<dttmm_parameter, first>& own) {
    std::array<dttmm_parameter, first + kSectionParameters.size()> all{};
    std::copy(own.begin(), own.end(), all.begin());
    std::copy(kSectionParameters.begin(), kSectionParameters.end(), all.begin() + first);
    return all;
}

/// Half a segment, a whole one, …, and half a one again: lumps at the middle of their segments on joints at the middle of
/// the spans between them.
/// lump: of a segment, offset: of its centre from the axis, local axes. whole, half: laws of a link between two lumps, and
/// between a lump and an end.
Parts lay_out(std::span<const Pose> ends, const Matrix3& axes, int segments, const Lump& lump, const Vector3& offset,
              const JointLaw& whole, const JointLaw& half, const SectionModuli& moduli = {});

}  // namespace dttmm::plugin
