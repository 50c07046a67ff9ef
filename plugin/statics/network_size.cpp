// SPDX-License-Identifier: BSD-3-Clause
#include "statics/network_size.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/index.h"

namespace dttmm::plugin {

namespace {

double find_span(const Mechanism& mechanism) {
    Eigen::AlignedBox3d box;
    for (const FrameSpec& frame : mechanism.assembly.frames) box.extend(frame.pose.position);
    const double span = box.diagonal().norm();
    return span > 0 ? span : 1;
}

std::vector<double> find_reaches(const Mechanism& mechanism, double span) {
    constexpr double kPoint = 1e-9;  // of the span: rounding of places
    const std::vector<Frame> frames = described_frames(mechanism);
    const auto driven = as_size(mechanism.assembly.driven_count);
    std::vector<double> reaches;
    for (size_t f = driven; f < frames.size(); ++f) {
        const FrameSpec& frame = mechanism.assembly.frames[f];
        reaches.push_back(frame.mass > 0 ? std::sqrt(frame.inertia.trace() / frame.mass) : 0);
    }
    for (const Joint& joint : mechanism.joints)
        for (int end : {0, 1})
            if (const auto f = as_size(joint.frame(end)); f >= driven)
                reaches[f - driven] = std::max(
                    reaches[f - driven], joint.arm(end, frames[as_size(joint.from())], frames[as_size(joint.to())]).norm());
    for (double& reach : reaches)
        if (reach <= kPoint * span) reach = span;
    return reaches;
}

}  // namespace

NetworkSize::NetworkSize(const Mechanism& mechanism) : span(find_span(mechanism)), reach(find_reaches(mechanism, span)) {}

}  // namespace dttmm::plugin
