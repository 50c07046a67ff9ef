// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdlib>
#ifdef __GLIBC__
#include <malloc.h>
#endif

namespace dttmm::host {

/// Memory that is free goes back to the system, where the library keeps it. For after work that takes much for a while, and
/// in pieces into which what comes next does not fit. Takes 2 ms for 20 MB. Less than a megabyte stays: to take it again
/// costs more.
inline void give_back_memory() {
#ifdef __GLIBC__
    constexpr std::size_t kWorthwhile = 1'000'000;  // [bytes]
    if (::mallinfo2().fordblks >= kWorthwhile) ::malloc_trim(0);
#endif
}

}  // namespace dttmm::host
