// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/fourier.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <random>

namespace dttmm::host {
namespace {

// Oracle: the sum as it is defined. Lengths: one, two, smooth odd and even ones, primes, a prime times a power of two.
TEST(Fourier, EveryLengthIsTheSum) {
    std::mt19937 random(5);
    std::normal_distribution<> normal;
    for (const size_t size : {1u, 2u, 3u, 45u, 64u, 31u, 127u, 136u, 211u}) {
        std::vector<double> x(size);
        for (double& value : x) value = normal(random);
        const auto found = fourier_transform(x);
        ASSERT_EQ(found.size(), size / 2 + 1);
        for (size_t k = 0; k < found.size(); ++k) {
            std::complex<double> sum = 0;
            for (size_t n = 0; n < size; ++n)
                sum += x[n] * std::polar(1.0, -2 * std::numbers::pi * static_cast<double>(k * n % size) /
                                                  static_cast<double>(size));
            EXPECT_LT(std::abs(found[k] - sum), 1e-13 * static_cast<double>(size)) << size << " " << k;
        }
    }
}

// Oracle: a cosine at a bin is N/2 there and rounding elsewhere. A prime near a million takes N log N, not N^2 (an hour).
TEST(Fourier, AMillionRowsOfPrimeNumberAreQuick) {
    constexpr size_t kSize = 1'000'003, kBin = 12'345;
    std::vector<double> x(kSize);
    for (size_t n = 0; n < kSize; ++n)
        x[n] = std::cos(2 * std::numbers::pi * static_cast<double>(kBin * n % kSize) / static_cast<double>(kSize));
    const auto start = std::chrono::steady_clock::now();
    const auto found = fourier_transform(x);
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 20);
    EXPECT_NEAR(found[kBin].real(), kSize / 2.0, 1e-6);
    EXPECT_LT(std::abs(found[kBin + 1]), 1e-6);
    EXPECT_LT(std::abs(found[7]), 1e-6);
}

}  // namespace
}  // namespace dttmm::host
