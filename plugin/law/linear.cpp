// SPDX-License-Identifier: BSD-3-Clause
#include "law/linear.h"

#include <iterator>

namespace dttmm::plugin {

namespace {

constexpr LawParameter kParameters[] = {{"stiffness", {"N/m", "N*m/rad"}, 0, "k of f = k d"}};

}  // namespace

const LawType Linear::kType = {"linear", kParameters, make_law<Linear, std::size(kParameters)>};

LawOnPath Linear::along(double from, double to) const {
    return {k_ * to, k_, 0.5 * k_ * (from + to), 0.5 * k_, 0.5 * k_ * to * to};
}

}  // namespace dttmm::plugin
