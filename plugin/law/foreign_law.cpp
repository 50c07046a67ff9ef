// SPDX-License-Identifier: BSD-3-Clause
#include "law/foreign_law.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <exception>

#include "core/error.h"

namespace dttmm::plugin {

namespace {

constexpr double kMostForce = 1e15;  // [N, N m]: the cap that the host has for wrenches on bodies

}  // namespace

LawOnPath ForeignLaw::along(const LawPath& path) const {
    std::array<double, kMostMemory> unwanted;
    dttmm_law_path asked{path.from, path.to, path.time, path.memory, path.after ? path.after : unwanted.data()};
    dttmm_law_answer answer{};
    *at_work_ = &law_;
    try {
        law_.along(values_.data(), &asked, &answer);
    } catch (const std::exception& error) {
        *at_work_ = nullptr;
        throw Error(DTTMM_ERROR_INTERNAL, fmt::format("law \"{}\": it threw a C++ exception: {}", law_.name, error.what()));
    } catch (...) {
        *at_work_ = nullptr;
        throw Error(DTTMM_ERROR_INTERNAL, fmt::format("law \"{}\": it threw a C++ exception", law_.name));
    }
    *at_work_ = nullptr;
    const double* const after = asked.after;
    const double sum = answer.force + answer.tangent + answer.mean + answer.mean_tangent + answer.stored + answer.dissipated;
    if (!std::isfinite(sum) || !std::all_of(after, after + law_.memory_count, [](double x) { return std::isfinite(x); }))
        throw Error(DTTMM_ERROR_INTERNAL,
                    fmt::format("law \"{}\": its answer is not finite (deformation from {:.6g} to {:.6g})", law_.name,
                                path.from, path.to));
    if (std::abs(answer.force) > kMostForce)
        throw Error(
            DTTMM_ERROR_INTERNAL,
            fmt::format("law \"{}\": its force is {:.3g} (deformation from {:.6g} to {:.6g}), beyond the cap of {:.0e}",
                        law_.name, answer.force, path.from, path.to, kMostForce));
    return {answer.force, answer.tangent, answer.mean, answer.mean_tangent, answer.stored, answer.dissipated};
}

}  // namespace dttmm::plugin
