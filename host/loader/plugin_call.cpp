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

namespace {

[[noreturn]] void refuse(const char* what) {
    throw Error(ExitCode::plugin_failure, fmt::format("a plugin has changed {}", what));
}

}  // namespace

std::string describe_exception() {
    try {
        throw;
    } catch (const std::exception& error) {
        return fmt::format("it threw a C++ exception across the interface: {}", printable(error.what()));
    } catch (...) {
        return "it threw a C++ exception across the interface";
    }
}

void refuse_changed_arithmetic() {
    if (std::fegetround() != FE_TONEAREST) refuse("the rounding mode of the processor");
#ifdef __SSE2__
    // MXCSR without its six flags: all exceptions masked, round to nearest, no flush to zero, no denormals as zero
    if ((_mm_getcsr() & ~0x3fu) != 0x1f80u)
        refuse("how the processor computes: numbers below 2.2e-308 become zero (FTZ, DAZ), or exceptions trap");
#endif
    if (std::strcmp(std::setlocale(LC_NUMERIC, nullptr), "C") != 0) refuse("the locale in which numbers are written");
}

}  // namespace dttmm::host
