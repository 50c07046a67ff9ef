// SPDX-License-Identifier: BSD-3-Clause
#include "coupling/drives.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/error.h"
#include "model/keys.h"
#include "model/step_time.h"

namespace dttmm::host {

Drives::Drives(const Model& model) : joints_(model.joints), drives_(model.joints.size()) {
    is_empty_ = std::ranges::none_of(joints_, [](const Joint& joint) { return joint.drive.has_value(); });
}

double Drives::value(const Joint& joint, double time) const {
    const double value = joint.drive->value(time);
    if (!(std::abs(value) <= kFarthest))
        throw Error(
            ExitCode::numerical_failure,
            fmt::format("{}: joint \"{}\": its {} at t = {} s is {}, not a finite number up to {:.0e}", joint.drive_place,
                        joint.name, joint.type == JointType::hinge ? "angle" : "travel", time, value, kFarthest));
    return value;
}

const std::vector<Drive>& Drives::around(const dttmm_step& step) {
    if (is_empty_) return drives_;
    const double t = step.time, h = step.size;
    for (size_t j = 0; j < joints_.size(); ++j) {
        const Joint& joint = joints_[j];
        if (!joint.drive) continue;
        const double now = value(joint, t), end = value(joint, rounded_time(t + h));
        Drive& drive = drives_[j] = {end, (end - now) / h, 0, 0};
        if (step.index > 0) {
            const double before = value(joint, rounded_time(t - h));
            drive.rate = (end - before) / (2 * h);
            drive.acceleration = (end - 2 * now + before) / (h * h);
        } else {
            // See rate_error()
            const double soon = h / kNearer;
            drive.rate = (-3 * now + 4 * value(joint, t + soon) - value(joint, t + 2 * soon)) / (2 * soon);
            const double second = value(joint, t + 2 * h), third = value(joint, t + 3 * h);
            drive.acceleration = (2 * now - 5 * end + 4 * second - third) / (h * h);
        }
    }
    return drives_;
}

const std::vector<Drive>& Drives::at(double time) {
    for (size_t j = 0; j < joints_.size(); ++j)
        if (joints_[j].drive) drives_[j] = {value(joints_[j], time), 0, 0, 0};
    return drives_;
}

}  // namespace dttmm::host
