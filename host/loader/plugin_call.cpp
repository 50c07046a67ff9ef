// SPDX-License-Identifier: BSD-3-Clause
#include "loader/plugin_call.h"

#include <fmt/format.h>

#include <cfenv>
#include <clocale>
#include <cstring>
#include <exception>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

#include "model/error.h"
#include "model/wording.h"

namespace dttmm::host {

std::string describe_exception() {
    try {
        throw;
    } catch (const std::exception& error) {
        return fmt::format("it threw a C++ exception across the interface: {}", printable(error.what()));
    } catch (...) {
        return "it threw a C++ exception across the interface";
    }
}

const char* restore_mode() {
    const bool rounds = std::fegetround() != FE_TONEAREST;
    bool computes = false;
#ifdef __SSE2__
    computes = (_mm_getcsr() & ~0x3fu) != 0x1f80u;
#endif
    if (!rounds && !computes) return nullptr;
    std::fesetenv(FE_DFL_ENV);
#ifdef __SSE2__
    _mm_setcsr(0x1f80u);
#endif
    return rounds ? "the rounding mode of the processor"
                  : "how the processor computes: numbers below 2.2e-308 become zero (FTZ, DAZ), or exceptions trap";
}

void refuse_changed_arithmetic(const std::string& who) {
    const char* what = restore_mode();
    if (!what && std::strcmp(std::setlocale(LC_NUMERIC, nullptr), "C") != 0) {
        std::setlocale(LC_NUMERIC, "C");
        what = "the locale in which numbers are written";
    }
    if (what) throw Error(ExitCode::plugin_failure, fmt::format("{} has changed {}", who, what));
}

}  // namespace dttmm::host
