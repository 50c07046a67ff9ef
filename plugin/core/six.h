// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "core/lanes.h"

namespace dttmm::plugin {

/// Six numbers in registers, four and two: a motion or a wrench on its way through a chain. Its products with 6 × 6 matrices
/// are what a chain's solution consists of; to be used in a function marked DTTMM_WIDE.
struct Six {
    using Two [[gnu::vector_size(2 * sizeof(double))]] = double;

    Lanes head;
    Two tail;

    [[gnu::always_inline]] explicit Six(const double* numbers) {
        __builtin_memcpy(&head.values, numbers, sizeof head.values);
        __builtin_memcpy(&tail, numbers + 4, sizeof tail);
    }
    [[gnu::always_inline]] Six(const Lanes& four, const Two& two) : head(four), tail(two) {}
    /// As that of Lanes.
    [[gnu::always_inline]] Six(const Six& other) : head(other.head), tail(other.tail) {}
    [[gnu::always_inline]] Six& operator=(const Six& other) { return head = other.head, tail = other.tail, *this; }

    [[gnu::always_inline]] void store(double* numbers) const {
        __builtin_memcpy(numbers, &head.values, sizeof head.values);
        __builtin_memcpy(numbers + 4, &tail, sizeof tail);
    }
    [[gnu::always_inline]] friend Six operator+(const Six& a, const Six& b) { return {a.head + b.head, a.tail + b.tail}; }
    [[gnu::always_inline]] friend Six operator-(const Six& a, const Six& b) { return {a.head - b.head, a.tail - b.tail}; }
    [[gnu::always_inline]] friend Six operator*(const Six& a, double b) { return {a.head * b, a.tail * b}; }
    /// Number by number.
    [[gnu::always_inline]] friend Six operator*(const Six& a, const Six& b) { return {a.head * b.head, a.tail * b.tail}; }
};

/// A x and Aᵀ x, A as 36 numbers column by column.
[[gnu::always_inline]] inline Six product(const double* A, const double* x) {
    const Six even = Six(A) * x[0] + Six(A + 12) * x[2] + Six(A + 24) * x[4];
    const Six odd = Six(A + 6) * x[1] + Six(A + 18) * x[3] + Six(A + 30) * x[5];
    return even + odd;
}
[[gnu::always_inline]] inline Six transposed_product(const double* A, const double* x) {
    using Four = Lanes::Values;
    using Two = Six::Two;
    const Six all(x), c0 = Six(A) * all, c1 = Six(A + 6) * all, c2 = Six(A + 12) * all, c3 = Six(A + 18) * all,
                      c4 = Six(A + 24) * all, c5 = Six(A + 30) * all;
    // Sums of neighbours in two of them at a time
    const auto fours = [](const Six& a, const Six& b) __attribute__((always_inline)) {
        const Four &x4 = a.head.values, &y4 = b.head.values;
        return Lanes(Four(__builtin_shufflevector(x4, y4, 0, 4, 2, 6) + __builtin_shufflevector(x4, y4, 1, 5, 3, 7)));
    };
    const auto twos = [](const Six& a, const Six& b) __attribute__((always_inline)) {
        return Two(__builtin_shufflevector(a.tail, b.tail, 0, 2) + __builtin_shufflevector(a.tail, b.tail, 1, 3));
    };
    const Lanes s01 = fours(c0, c1), s23 = fours(c2, c3), s45 = fours(c4, c5);
    const Two t01 = twos(c0, c1), t23 = twos(c2, c3), t45 = twos(c4, c5);
    const Four head = __builtin_shufflevector(s01.values, s23.values, 0, 1, 4, 5) +
                      __builtin_shufflevector(s01.values, s23.values, 2, 3, 6, 7) +
                      __builtin_shufflevector(t01, t23, 0, 1, 2, 3);
    const Two tail =
        __builtin_shufflevector(s45.values, s45.values, 0, 1) + __builtin_shufflevector(s45.values, s45.values, 2, 3) + t45;
    return {Lanes(head), tail};
}

}  // namespace dttmm::plugin
