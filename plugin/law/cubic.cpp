// SPDX-License-Identifier: BSD-3-Clause
#include "law/cubic.h"

#include <iterator>

namespace dttmm::plugin {

namespace {

constexpr LawParameter kParameters[] = {
    {"stiffness", {"N/m", "N*m/rad"}, 0, "k of f = k d + k3 d^3"},
    {"cubic", {"N/m^3", "N*m/rad^3"}, kAnySign, "k3 of f = k d + k3 d^3; negative: the spring softens"}};

}  // namespace

const LawType Cubic::kType = {"cubic", kParameters, make_law<Cubic, std::size(kParameters)>};

LawOnPath Cubic::along(const LawPath& path) const {
    // (b⁴ − a⁴)/(4 (b − a)) without the division
    const double a = path.from, b = path.to, squares = a * a + b * b;
    return {k_ * b + k3_ * b * b * b,
            k_ + 3 * k3_ * b * b,
            0.5 * k_ * (a + b) + 0.25 * k3_ * (a + b) * squares,
            0.5 * k_ + 0.25 * k3_ * (squares + 2 * b * (a + b)),
            0.5 * k_ * b * b + 0.25 * k3_ * b * b * b * b,
            0};
}

}  // namespace dttmm::plugin
