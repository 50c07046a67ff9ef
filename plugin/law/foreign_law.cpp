// SPDX-License-Identifier: BSD-3-Clause
#include "law/foreign_law.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cfenv>
#include <cmath>
#include <exception>
#include <limits>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

#include "core/error.h"

namespace dttmm::plugin {

namespace {

/// A trial may be far off; squares of this are numbers. Where a step ends the host takes 1e15 N at most.
constexpr double kMostForce = 1e100;  // [N, N m]

/// Of forces that are one: far beyond rounding, far below what misleads.
constexpr double kEqual = 1e-6;

/// Where a law writes its memory. Numbers behind it must stay; those of it must be written, for they begin as NaN.
class Scratch {
public:
    explicit Scratch(size_t count) : count_(count) {
        std::fill_n(numbers_.begin(), count, std::numeric_limits<double>::quiet_NaN());
        std::fill_n(numbers_.begin() + count, kGuard, kUntouched);
    }
    double* data() { return numbers_.data(); }
    bool is_overrun() const {
        return std::any_of(numbers_.begin() + count_, numbers_.begin() + count_ + kGuard,
                           [](double x) { return x != kUntouched; });
    }
    bool is_finite() const {
        return std::all_of(numbers_.begin(), numbers_.begin() + count_, [](double x) { return std::isfinite(x); });
    }
    void copy_to(double* to) const { std::copy_n(numbers_.begin(), count_, to); }

private:
    static constexpr size_t kGuard = 32;
    static constexpr double kUntouched = -7.25;
    size_t count_;
    std::array<double, Law::kMostMemory + kGuard> numbers_;
};

/// Whether a law has changed how the processor rounds, what it does with numbers below 2.2e-308, or what traps. The host has
/// the default of all; it is put right again.
bool restore_arithmetic() {
#ifdef __SSE2__
    constexpr unsigned kFlags = 0x3f, kDefault = 0x1f80;
    if ((_mm_getcsr() & ~kFlags) == kDefault) [[likely]]
        return false;
#else
    if (std::fegetround() == FE_TONEAREST) return false;
#endif
    std::fesetenv(FE_DFL_ENV);
    return true;
}

}  // namespace

LawOnPath ForeignLaw::along(const LawPath& path) const {
    Scratch after(law_.memory_count);
    const dttmm_law_path asked{path.from, path.to, path.time, path.memory, after.data()};
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
    if (restore_arithmetic())
        throw Error(DTTMM_ERROR_INTERNAL, fmt::format("law \"{}\": it has changed how the processor computes", law_.name));
    if (after.is_overrun())
        throw Error(DTTMM_ERROR_INTERNAL,
                    fmt::format("law \"{}\": it writes more than the {} numbers of its memory (deformation from {:.6g} to "
                                "{:.6g})",
                                law_.name, law_.memory_count, path.from, path.to));
    const double sum = answer.force + answer.tangent + answer.mean + answer.mean_tangent + answer.stored + answer.dissipated;
    if (!std::isfinite(sum) || !after.is_finite())
        throw Error(DTTMM_ERROR_INTERNAL,
                    fmt::format("law \"{}\": its answer is not finite (deformation from {:.6g} to {:.6g})", law_.name,
                                path.from, path.to));
    if (path.from == path.to &&
        std::abs(answer.mean - answer.force) > kEqual * std::max(std::abs(answer.mean), std::abs(answer.force)))
        throw Error(DTTMM_ERROR_INTERNAL,
                    fmt::format("law \"{}\": on a path of no length its mean force is {:.6g} and its force {:.6g} "
                                "(deformation {:.6g}); they must be equal, as `dttmm check-law` finds",
                                law_.name, answer.mean, answer.force, path.to));
    if (std::abs(answer.force) > kMostForce)
        throw Error(
            DTTMM_ERROR_INTERNAL,
            fmt::format("law \"{}\": its force is {:.3g} (deformation from {:.6g} to {:.6g}), beyond the cap of {:.0e}",
                        law_.name, answer.force, path.from, path.to, kMostForce));
    if (path.after) after.copy_to(path.after);
    return {answer.force, answer.tangent, answer.mean, answer.mean_tangent, answer.stored, answer.dissipated};
}

}  // namespace dttmm::plugin
