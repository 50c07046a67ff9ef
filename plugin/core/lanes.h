// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstddef>

/// Compiles a function and what it inlines twice more, for processors with AVX2 and with AVX-512, whose 32 registers hold
/// what others must put aside; chosen when the library is loaded. All give the same bits: the build forbids contraction, so
/// that no product is fused. Once under the address sanitizer: the checks are the same in all, and slow to compile.
/// DTTMM_NARROW: the same without, for a test that compares the bits.
#if defined(__x86_64__) && defined(__GLIBC__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(DTTMM_NARROW)
#define DTTMM_WIDE [[gnu::flatten, gnu::target_clones("arch=x86-64-v4", "avx2", "default")]]
#else
#define DTTMM_WIDE
#endif

namespace dttmm::plugin {

/// Four numbers side by side: a scalar with which a formula for one thing works out four.
struct alignas(4 * sizeof(double)) Lanes {
    static constexpr int kCount = 4;
    using Values [[gnu::vector_size(kCount * sizeof(double))]] = double;

    Lanes() = default;
    /// User-provided, so that Lanes pass through memory: whether registers pass them depends on the processor compiled for.
    [[gnu::always_inline]] Lanes(const Lanes& other) : values(other.values) {}
    [[gnu::always_inline]] Lanes& operator=(const Lanes& other) { return values = other.values, *this; }
    [[gnu::always_inline]] Lanes(double all) : values{all, all, all, all} {}
    [[gnu::always_inline]] explicit Lanes(const Values& four) : values(four) {}
    [[gnu::always_inline]] double operator[](int lane) const { return values[lane]; }
    [[gnu::always_inline]] void set(int lane, double value) { values[lane] = value; }

    [[gnu::always_inline]] Lanes& operator+=(const Lanes& other) { return values += other.values, *this; }
    [[gnu::always_inline]] Lanes& operator-=(const Lanes& other) { return values -= other.values, *this; }
    [[gnu::always_inline]] Lanes& operator*=(const Lanes& other) { return values *= other.values, *this; }
    [[gnu::always_inline]] friend Lanes operator+(Lanes a, const Lanes& b) { return a += b; }
    [[gnu::always_inline]] friend Lanes operator-(Lanes a, const Lanes& b) { return a -= b; }
    [[gnu::always_inline]] friend Lanes operator*(Lanes a, const Lanes& b) { return a *= b; }
    [[gnu::always_inline]] friend Lanes operator-(const Lanes& a) { return Lanes(Values(-a.values)); }

    Values values;
};

/// Whether all of the numbers are below a bound; false for NaN.
[[gnu::always_inline]] inline bool all_below(double a, double bound) { return a < bound; }
[[gnu::always_inline]] inline bool all_below(const Lanes& a, double bound) {
    const auto below = a.values < Lanes(bound).values;
    return (below[0] & below[1] & below[2] & below[3]) != 0;
}

/// One lane of a vector or matrix.
template <int R, int C>
Eigen::Matrix<double, R, C> lane(const Eigen::Matrix<Lanes, R, C>& four, int i) {
    return four.unaryExpr([i](const Lanes& a) { return a[i]; });
}
template <int R, int C>
void set_lane(Eigen::Matrix<Lanes, R, C>& four, int i, const Eigen::Matrix<double, R, C>& one) {
    for (int r = 0; r < R; ++r)
        for (int c = 0; c < C; ++c) four(r, c).set(i, one(r, c));
}

/// The rows of a 4 × 4 matrix become its columns.
[[gnu::always_inline]] inline void transpose(Lanes::Values& a, Lanes::Values& b, Lanes::Values& c, Lanes::Values& d) {
    const Lanes::Values ab = __builtin_shufflevector(a, b, 0, 4, 2, 6), AB = __builtin_shufflevector(a, b, 1, 5, 3, 7);
    const Lanes::Values cd = __builtin_shufflevector(c, d, 0, 4, 2, 6), CD = __builtin_shufflevector(c, d, 1, 5, 3, 7);
    a = __builtin_shufflevector(ab, cd, 0, 1, 4, 5);
    b = __builtin_shufflevector(AB, CD, 0, 1, 4, 5);
    c = __builtin_shufflevector(ab, cd, 2, 3, 6, 7);
    d = __builtin_shufflevector(AB, CD, 2, 3, 6, 7);
}

/// N numbers of each of four records, from[lane][n], side by side: to[n][lane]; and back. Written out: g++ 12 takes
/// small arrays through memory.
template <int N>
[[gnu::always_inline]] inline void gather(const double* const (&from)[Lanes::kCount], Lanes* to) {
    constexpr int kBlocks = N / 4 * 4;
    for (int n = 0; n < kBlocks; n += 4) {
        Lanes::Values a, b, c, d;
        __builtin_memcpy(&a, from[0] + n, sizeof a);
        __builtin_memcpy(&b, from[1] + n, sizeof b);
        __builtin_memcpy(&c, from[2] + n, sizeof c);
        __builtin_memcpy(&d, from[3] + n, sizeof d);
        transpose(a, b, c, d);
        to[n].values = a;
        to[n + 1].values = b;
        to[n + 2].values = c;
        to[n + 3].values = d;
    }
    for (int n = kBlocks; n < N; ++n) {
        const double four[] = {from[0][n], from[1][n], from[2][n], from[3][n]};
        __builtin_memcpy(&to[n].values, four, sizeof four);
    }
}
template <int N>
[[gnu::always_inline]] inline void scatter(const Lanes* from, double* const (&to)[Lanes::kCount]) {
    constexpr int kBlocks = N / 4 * 4;
    for (int n = 0; n < kBlocks; n += 4) {
        Lanes::Values a = from[n].values, b = from[n + 1].values, c = from[n + 2].values, d = from[n + 3].values;
        transpose(a, b, c, d);
        __builtin_memcpy(to[0] + n, &a, sizeof a);
        __builtin_memcpy(to[1] + n, &b, sizeof b);
        __builtin_memcpy(to[2] + n, &c, sizeof c);
        __builtin_memcpy(to[3] + n, &d, sizeof d);
    }
    for (int n = kBlocks; n < N; ++n)
        for (int lane = 0; lane < 4; ++lane) to[lane][n] = from[n][lane];
}

/// Whether a record is nothing but kNumbers numbers in a row, so that it may be read as an array of them.
template <template <class> class Record>
inline constexpr bool kIsPlain = sizeof(Record<double>) == Record<double>::kNumbers * sizeof(double) &&
                                 sizeof(Record<Lanes>) == Record<double>::kNumbers * sizeof(Lanes);

/// The numbers of a record.
template <class Record>
const double* numbers_of(const Record& record) {
    return reinterpret_cast<const double*>(&record);
}
template <class Record>
double* numbers_of(Record& record) {
    return reinterpret_cast<double*>(&record);
}

/// Four records side by side; record(k): the k-th, a Record<double>&. And the way back.
template <template <class> class Record>
[[gnu::always_inline]] inline Record<Lanes> gather_records(const auto& record) {
    static_assert(kIsPlain<Record>);
    Record<Lanes> four;
    gather<Record<double>::kNumbers>(
        {numbers_of(record(0)), numbers_of(record(1)), numbers_of(record(2)), numbers_of(record(3))},
        reinterpret_cast<Lanes*>(&four));
    return four;
}
template <template <class> class Record>
[[gnu::always_inline]] inline void scatter_records(const Record<Lanes>& four, const auto& record) {
    static_assert(kIsPlain<Record>);
    scatter<Record<double>::kNumbers>(reinterpret_cast<const Lanes*>(&four), {numbers_of(record(0)), numbers_of(record(1)),
                                                                              numbers_of(record(2)), numbers_of(record(3))});
}

}  // namespace dttmm::plugin

/// Plain numbers: nothing to construct.
template <>
struct Eigen::NumTraits<dttmm::plugin::Lanes> : Eigen::GenericNumTraits<dttmm::plugin::Lanes> {
    enum { IsSigned = 1, RequireInitialization = 0 };
};
