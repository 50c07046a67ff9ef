// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

/// Compiles a function, with all that it calls, once more for processors that add four numbers at a time. Results are the
/// same to the bit: no products are fused with sums.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__)
#define DTTMM_WIDE [[gnu::flatten, gnu::target_clones("avx2", "default")]]
#else
#define DTTMM_WIDE
#endif

namespace dttmm {

/// Four numbers side by side, to which the same is done: a scalar for the formulas of one thing to work on four.
struct alignas(4 * sizeof(double)) Lanes {
    static constexpr int kCount = 4;
    using Values [[gnu::vector_size(kCount * sizeof(double))]] = double;

    Lanes() = default;
    /// Not trivial, so that no register carries it from function to function: which ones do hangs on the processor.
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

/// N numbers of each of four records, from[lane][n], side by side: to[n][lane]; and the way back.
template <int N>
[[gnu::always_inline]] inline void gather(const double* const (&from)[Lanes::kCount], Lanes* to) {
    using Mask [[gnu::vector_size(4 * sizeof(long))]] = long;
    constexpr int kBlocks = N / 4 * 4;
    for (int n = 0; n < kBlocks; n += 4) {
        Lanes::Values a, b, c, d;
        __builtin_memcpy(&a, from[0] + n, sizeof a);
        __builtin_memcpy(&b, from[1] + n, sizeof b);
        __builtin_memcpy(&c, from[2] + n, sizeof c);
        __builtin_memcpy(&d, from[3] + n, sizeof d);
        const Lanes::Values ab = __builtin_shuffle(a, b, Mask{0, 4, 2, 6}), AB = __builtin_shuffle(a, b, Mask{1, 5, 3, 7});
        const Lanes::Values cd = __builtin_shuffle(c, d, Mask{0, 4, 2, 6}), CD = __builtin_shuffle(c, d, Mask{1, 5, 3, 7});
        to[n].values = __builtin_shuffle(ab, cd, Mask{0, 1, 4, 5});
        to[n + 1].values = __builtin_shuffle(AB, CD, Mask{0, 1, 4, 5});
        to[n + 2].values = __builtin_shuffle(ab, cd, Mask{2, 3, 6, 7});
        to[n + 3].values = __builtin_shuffle(AB, CD, Mask{2, 3, 6, 7});
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
        const double* columns[4];
        for (int k = 0; k < 4; ++k) columns[k] = reinterpret_cast<const double*>(&from[n + k]);
        Lanes rows[4];
        gather<4>(columns, rows);
        for (int lane = 0; lane < 4; ++lane) __builtin_memcpy(to[lane] + n, &rows[lane], sizeof rows[lane]);
    }
    for (int n = kBlocks; n < N; ++n)
        for (int lane = 0; lane < 4; ++lane) to[lane][n] = from[n][lane];
}

}  // namespace dttmm

template <>
struct Eigen::NumTraits<dttmm::Lanes> : Eigen::GenericNumTraits<dttmm::Lanes> {
    enum { IsSigned = 1, RequireInitialization = 0 };
};
