// SPDX-License-Identifier: BSD-3-Clause
#include "element/axial_spring.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "core/error.h"
#include "element/divided_line.h"
#include "element/law_parameters.h"
#include "element/parameters.h"

namespace dttmm::plugin {

namespace {

constexpr dttmm_parameter kParameters[] = {
    zero_by_default("damping", "N*s/m", 0, "of the rate of its length"),
    optional("natural_length", "m", 1, 0, kLargest, "at which its law has no force; otherwise that at the start"),
    optional("preload", "N", 1, -kLargest, kLargest,
             "force at the start, positive in tension; in place of a natural length")};

/// The deformation nearest to zero at which a law has a force [m].
double deformation_at(const Law& law, double force) {
    constexpr double kNearest = 1e-12, kFarthest = 1e3, kGrowth = 1.1;  // [m]
    double largest = 0;
    if (force == 0) return 0;
    const double sign = std::copysign(1, force);
    const auto reaches = [&](double d) { return sign * law.first(sign * d).force >= std::abs(force); };
    double low = 0, high = kNearest;
    while (!reaches(high)) {
        largest = std::max(largest, sign * law.first(sign * high).force);
        low = high;
        high *= kGrowth;
        if (high > kFarthest)
            throw Error(DTTMM_ERROR_MODEL,
                        fmt::format("preload: its law has no force of {:g} N up to {:g} m; the largest is {:.3g} N", force,
                                    kFarthest, sign * largest));
    }
    for (double middle = 0.5 * (low + high); middle > low && middle < high; middle = 0.5 * (low + high))
        (reaches(middle) ? high : low) = middle;
    return sign * high;
}

}  // namespace

const dttmm_element_type& AxialSpring::type() {
    static TypeWithLaws type({"axial_spring", DTTMM_ENDS_ALONG, 0, nullptr,
                              "a spring and a damper along the line between two points, which may move far and turn"},
                             kParameters, [](auto add) { add(LawParameters::along_a_line()); });
    return type.get();
}

AxialSpring::AxialSpring(std::span<const double> values) {
    law_.damping(0) = values[0];
    if (is_given(values[1]) && is_given(values[2]))
        throw Error(DTTMM_ERROR_MODEL, "natural_length and preload say the same: leave one out");
    if (is_given(values[1])) natural_length_ = values[1];
    const std::shared_ptr<const Law> law = LawParameters::along_a_line().make(values.subspan(std::size(kParameters)));
    if (is_given(values[2])) elongation_ = deformation_at(*law, values[2]);
    law_.set(0, law);
}

Parts AxialSpring::discretise(std::span<const Pose> ends) const {
    const Matrix3 axes = beam_axes(ends[0].position, ends[1].position, Vector3::Constant(kNotGiven));
    const double length = (ends[1].position - ends[0].position).norm();
    JointLaw law = law_;
    law.axial = {length, natural_length_.value_or(length - elongation_)};
    // A natural length that is the length but for rounding of the places of its ends is no preload. Range 1.2 to 1e4
    // epsilons: HasItsNaturalLengthOrItsPreload
    constexpr double kRounding = 4 * std::numeric_limits<double>::epsilon();
    if (natural_length_ &&
        std::abs(*natural_length_ - length) <= kRounding * (ends[0].position.norm() + ends[1].position.norm()))
        law.axial->natural = length;
    return {{}, {{0, 1, std::make_shared<const JointLaw>(law), {ends[1].position, axes}}}, {}};
}

}  // namespace dttmm::plugin
