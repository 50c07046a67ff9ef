// SPDX-License-Identifier: BSD-3-Clause
//
// Counts every malloc of the executable that includes this, once. Under the address sanitizer, which has a malloc of its
// own, there is nothing to count and this is empty.
#pragma once

#include <cstddef>

#ifndef __SANITIZE_ADDRESS__

namespace {
long allocations = 0;
}

extern "C" {
void* __libc_malloc(size_t);
void* __libc_calloc(size_t, size_t);
void* __libc_realloc(void*, size_t);
__attribute__((visibility("default"))) void* malloc(size_t size) {
    ++allocations;
    return __libc_malloc(size);
}
__attribute__((visibility("default"))) void* calloc(size_t count, size_t size) {
    ++allocations;
    return __libc_calloc(count, size);
}
__attribute__((visibility("default"))) void* realloc(void* old, size_t size) {
    ++allocations;
    return __libc_realloc(old, size);
}
}

#endif
