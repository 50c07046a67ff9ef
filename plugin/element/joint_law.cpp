// SPDX-License-Identifier: BSD-3-Clause
#include "element/joint_law.h"

#include <algorithm>

#include "core/index.h"
#include "core/state_vector.h"
#include "law/linear.h"

namespace dttmm::plugin {

void JointLaw::set(int direction, std::shared_ptr<const Law> law) {
    stiffness(direction) = law->first(0).tangent;
    if (!law->is_linear()) laws[as_size(direction)] = std::move(law);
}

size_t JointLaw::memory_before(int direction) const {
    size_t size = 0;
    for (int d = 0; d < direction; ++d)
        if (const auto& law = laws[as_size(d)]) size += law->memory_size();
    return size;
}

LawOnPath JointLaw::along(int direction, LawPath path) const {
    if (const auto& law = laws[as_size(direction)]) {
        const size_t own = memory_before(direction);
        if (path.memory) path.memory += own;
        if (path.after) path.after += own;
        return law->along(path);
    }
    const double k[] = {stiffness(direction)};
    return Linear(k).along(path);
}

double JointLaw::used(const Vector6& deformation) const {
    return std::max(deformation.head<3>().norm() / most_shift, deformation.tail<3>().norm() / most_turn);
}

bool JointLaw::has_laws() const {
    return std::ranges::any_of(laws, [](const auto& law) { return law != nullptr; });
}

Directions JointLaw::resisting() const {
    Directions resisting;
    for (int d = 0; d < 6; ++d) resisting[as_size(d)] = !rigid[as_size(d)] && (stiffness(d) > 0 || damping(d) > 0);
    return resisting;
}

Directions JointLaw::elastic() const {
    Directions elastic = resisting();
    for (size_t d = 0; d < 6; ++d)
        if (laws[d]) elastic.set(d);
    return elastic;
}

Matrix13 JointLaw::transfer(const StepCoefficients& step, const Vector6& known) const {
    // f = k̂ (x_O − x_I) + known with k̂ = weight k + c C, and f = [−q; m]:
    //     x_O = x_I − (q + known)/k̂,   θ_O = θ_I + (m − known)/k̂;   q and m pass through
    Matrix13 U = Matrix13::Identity();
    for (int d = 0; d < 6; ++d) {
        if (rigid[as_size(d)]) continue;
        const double k_hat = step.weight * stiffness(d) + damping(d) * step.C;
        const bool turns = d >= 3;
        const int pose = turns ? state::kAngle + d - 3 : state::kPosition + d;
        const int load = turns ? state::kMoment + d - 3 : state::kForce + d;
        U(pose, load) = turns ? 1 / k_hat : -1 / k_hat;
        U(pose, state::kOne) = k_hat > 0 ? -known(d) / k_hat : 0;
    }
    return U;
}

}  // namespace dttmm::plugin
