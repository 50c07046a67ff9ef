// SPDX-License-Identifier: BSD-3-Clause
#include "model/read_position.h"

#include <fmt/format.h>

namespace dttmm::host {
namespace {

constexpr double kFar = 1e4;  // [m]

}  // namespace

void check_position(const ReadContext& context, Place place, const std::string& label, const Eigen::Vector3d& position) {
    const double distance = position.cwiseAbs().maxCoeff();
    if (distance <= kFar) return;
    if (distance > kFarthest)
        return context.diagnostics.error(
            place, fmt::format("{}: position must be within {} m of the origin in every direction, got {} m", label,
                               kFarthest, distance));
    context.diagnostics.warning(
        place, "far-from-origin",
        fmt::format("{}: position is {} m from the origin: small motions lose digits; move the origin", label, distance));
}

}  // namespace dttmm::host
