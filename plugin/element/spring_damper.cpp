// SPDX-License-Identifier: BSD-3-Clause
#include "element/spring_damper.h"

#include <limits>

#include "core/state_vector.h"

namespace dttmm {

namespace {

constexpr double kLargest = std::numeric_limits<double>::max();

constexpr dttmm_parameter kParameters[] = {
    {"stiffness", "N/m", 3, DTTMM_PARAMETER_SPREADS, 0, 0, kLargest, nullptr, 0,
     "in x, y, z of the from end; one number: the same in all"},
    {"damping", "N*s/m", 3, DTTMM_PARAMETER_SPREADS, 0, 0, kLargest, nullptr, 0,
     "in x, y, z of the from end; one number: the same in all"},
    {"rotational_stiffness", "N*m/rad", 3, DTTMM_PARAMETER_SPREADS, 0, 0, kLargest, nullptr, 0,
     "about x, y, z of the from end"},
    {"rotational_damping", "N*m*s/rad", 3, DTTMM_PARAMETER_SPREADS, 0, 0, kLargest, nullptr, 0,
     "about x, y, z of the from end"},
};

}  // namespace

const dttmm_element_type SpringDamper::kType = {
    "spring_damper", DTTMM_ENDS_FROM_TO, std::size(kParameters), kParameters,
    "springs and dampers in three translations and three rotations; a direction without either is free"};

SpringDamper::SpringDamper(std::span<const double, 12> values) {
    for (int i = 0; i < 3; ++i) {
        const auto at = [&](int group) { return values[static_cast<size_t>(3 * group + i)]; };
        k_(i) = at(0);
        c_(i) = at(1);
        k_(3 + i) = at(2);
        c_(3 + i) = at(3);
    }
}

Directions SpringDamper::carried() const {
    Directions carried;
    for (int d = 0; d < 6; ++d) carried[static_cast<size_t>(d)] = k_(d) > 0 || c_(d) > 0;
    return carried;
}

Matrix13 SpringDamper::transfer(const StepCoefficients& step, const Vector6& known) const {
    // f = k̂ (x_O − x_I) + known with k̂ = weight k + c C, and f = [−q; m]:
    //     x_O = x_I − (q + known)/k̂,   θ_O = θ_I + (m − known)/k̂;   q and m pass through
    // A free direction has k̂ = 0: its compliance is infinite, and so is the entry of U.
    Matrix13 U = Matrix13::Identity();
    for (int d = 0; d < 6; ++d) {
        const double k_hat = step.weight * k_(d) + c_(d) * step.C;
        const bool turns = d >= 3;
        const int pose = turns ? state::kAngle + d - 3 : state::kPosition + d;
        const int load = turns ? state::kMoment + d - 3 : state::kForce + d;
        U(pose, load) = turns ? 1 / k_hat : -1 / k_hat;
        U(pose, state::kOne) = k_hat > 0 ? -known(d) / k_hat : 0;
    }
    return U;
}

}  // namespace dttmm
