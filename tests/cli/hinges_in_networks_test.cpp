// SPDX-License-Identifier: BSD-3-Clause
//
// Hinges between parts of a network that turn without end.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "cli/static_run.h"

namespace dttmm::host {
namespace {

const Eigen::Matrix3d kAxes =
    (Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(-0.9, Eigen::Vector3d::UnitX()))
        .toRotationMatrix();

std::string list(const Eigen::Vector3d& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); }

/// A rotor on a sprung foot, turned in space: with its parts and its hinge in the network, or as bodies on a joint.
std::string rotor_on_foot(double speed, double step, bool is_network) {
    std::string text =
        fmt::format("format = \"dttmm/1\"\n[simulation]\nduration = 0.06\nstep = {}\n[output]\nstep = 0.06\n", step);
    const Eigen::Vector3d spin = speed * kAxes.col(0);
    const Eigen::AngleAxisd turn(kAxes);
    const std::string turned = fmt::format("rotation = {{ axis = {}, angle = {} }}", list(turn.axis()), turn.angle()),
                      of_foot = "{ xx = 1e-3, yy = 2e-3, zz = 1e-3 }", of_rotor = "{ xx = 0.02, yy = 0.012, zz = 0.012 }";
    if (is_network)
        text += fmt::format(R"toml([nodes]
foot = {{ position = [0, 0, 0], {0} }}
rotor = {{ position = [0, 0, 0], {0}, angular_velocity = {1} }}
[[element]]
name = "foot_part"
type = "rigid_body"
at = "foot"
mass = 0.2
inertia = {2}
[[element]]
name = "rotor_part"
type = "rigid_body"
at = "rotor"
mass = 4
inertia = {3}
[[element]]
name = "bearing"
type = "elastic_hinge"
from = "foot"
to = "rotor"
stiffness = {{ rx = "free" }}
)toml",
                            turned, list(spin), of_foot, of_rotor);
    else
        text += fmt::format(R"toml([[body]]
name = "foot"
mass = 0.2
inertia = {2}
{0}
[[body]]
name = "rotor"
mass = 4
inertia = {3}
{0}
angular_velocity = {1}
[[joint]]
name = "bearing"
type = "hinge"
between = ["foot", "rotor"]
anchor = [0, 0, 0]
axis = {4}
)toml",
                            turned, list(spin), of_foot, of_rotor, list(kAxes.col(0)));
    return text + fmt::format(R"toml([[element]]
name = "spring"
type = "spring_damper"
from = "ground"
to = "foot"
stiffness = 1e5
rotational_stiffness = 1000
[[load]]
on = "foot"
direction = {}
moment = "=5*sin(60*t)"
)toml",
                              list(kAxes.col(1) + kAxes.col(2)));
}

}  // namespace

/// Oracle: the same machine as bodies on an ideal joint, from which it differs by what steps err: of second order. A
/// rotation vector has no derivative across its axis after half a turn; the run ended there, at 1, 3, 5, ... halves, at all
/// steps from 1 to 0.05 ms.
TEST(HingesInNetworks, TurnBeyondHalfATurn) {
    for (const auto& [speed, step] : {std::pair(300., 1e-4), {115., 2e-4}, {60., 5e-4}}) {
        const auto difference = [&](double h) {
            auto network = final_row(rotor_on_foot(speed, h, true)), bodies = final_row(rotor_on_foot(speed, h, false));
            double squared = 0;
            for (const char* part : {"foot", "rotor"})
                for (const char* axis : {"x", "y", "z"}) {
                    const std::string channel = std::string(part) + ".angular_velocity." + axis;
                    squared += std::pow(network.at(channel) - bodies.at(channel), 2);
                }
            return std::sqrt(squared);
        };
        const double coarse = difference(step), fine = difference(step / 2);
        EXPECT_LT(coarse, 2e-4 * speed) << speed;
        EXPECT_LT(fine, 0.27 * coarse) << speed;
    }
}

}  // namespace dttmm::host
