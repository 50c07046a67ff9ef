// SPDX-License-Identifier: BSD-3-Clause
#include "law/linear.h"

#include <iterator>

namespace dttmm::plugin {

namespace {

constexpr LawParameter kParameters[] = {{"stiffness", {"N/m", "N*m/rad"}, 0, "k of f = k d"}};

}  // namespace

const LawType Linear::kType = {"linear", kParameters, make_law<Linear, std::size(kParameters)>};

LawOnPath Linear::along(const LawPath& path) const {
    return {k_ * path.to, k_, 0.5 * k_ * (path.from + path.to), 0.5 * k_, 0.5 * k_ * path.to * path.to, 0};
}

}  // namespace dttmm::plugin
