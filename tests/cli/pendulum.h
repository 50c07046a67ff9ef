// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <string>

namespace dttmm::host {

/// A body upside down on a hinge, which a spring holds so that it vibrates with a frequency [Hz] under a gravity of
/// 9.81 m/s^2 along -z; negative: it grows, at 2 pi times that rate.
inline std::string pendulum(double frequency) {
    constexpr double kBody = 4.9, kHeight = 0.51, kAboutCentre = 0.127;
    const double omega = 2 * M_PI * frequency;
    const double stiffness = (kAboutCentre + kBody * kHeight * kHeight) * omega * std::abs(omega) + kBody * 9.81 * kHeight;
    return fmt::format(R"toml([[body]]
name = "p"
mass = {0}
inertia = [{1}, {1}, {1}]
position = [5, 0, {2}]
[[joint]]
name = "hinge"
type = "hinge"
between = ["ground", "p"]
anchor = [5, 0, 0]
axis = [0, 1, 0]
[[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "p"
rotational_stiffness = [0, {3:.17g}, 0]
)toml",
                       kBody, kAboutCentre, kHeight, stiffness);
}

}  // namespace dttmm::host
