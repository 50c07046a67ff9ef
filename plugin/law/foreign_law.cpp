// SPDX-License-Identifier: BSD-3-Clause
#include "law/foreign_law.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/error.h"

namespace dttmm::plugin {

LawOnPath ForeignLaw::along(const LawPath& path) const {
    std::array<double, kMostMemory> unwanted;
    dttmm_law_path asked{path.from, path.to, path.time, path.memory, path.after ? path.after : unwanted.data()};
    dttmm_law_answer answer{};
    *at_work_ = &law_;
    law_.along(values_.data(), &asked, &answer);
    *at_work_ = nullptr;
    const double* const after = asked.after;
    const double sum = answer.force + answer.tangent + answer.mean + answer.mean_tangent + answer.stored + answer.dissipated;
    if (!std::isfinite(sum) || !std::all_of(after, after + law_.memory_count, [](double x) { return std::isfinite(x); }))
        throw Error(DTTMM_ERROR_INTERNAL,
                    fmt::format("law \"{}\": its answer is not finite (deformation from {:.6g} to {:.6g})", law_.name,
                                path.from, path.to));
    return {answer.force, answer.tangent, answer.mean, answer.mean_tangent, answer.stored, answer.dissipated};
}

}  // namespace dttmm::plugin
