// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/fourier.h"

#include <bit>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <unsupported/Eigen/FFT>

namespace dttmm::host {

namespace {

using Complex = std::complex<double>;
using Series = std::vector<Complex>;

/// The library's own transform takes N times the largest prime factor; up to this one it is the shorter way.
constexpr std::size_t kLargestFactor = 13;

bool is_smooth(std::size_t n) {
    for (std::size_t factor = 2; factor <= kLargestFactor; ++factor)
        while (n % factor == 0) n /= factor;
    return n == 1;
}

/// exp(-pi i n^2/N). The square is taken modulo 2N as a whole number: as a double it would lose the phase.
Complex chirp(std::uint64_t n, std::uint64_t size) {
    const auto square = static_cast<double>(n * n % (2 * size));  // n < 2^32: no overflow
    return std::polar(1.0, -std::numbers::pi * square / static_cast<double>(size));
}

Series transform(const Series& x) {
    Eigen::FFT<double> fft;
    Series out;
    fft.fwd(out, x);
    return out;
}

/// -2kn = (k-n)^2 - k^2 - n^2: the sum is a convolution with the conjugate chirp.
Series bluestein(const std::vector<double>& x) {
    const std::size_t size = x.size(), padded = std::bit_ceil(2 * size - 1);
    Series chirps(size), signal(padded), kernel(padded);
    for (std::size_t n = 0; n < size; ++n) {
        chirps[n] = chirp(n, size);
        signal[n] = x[n] * chirps[n];
        kernel[n] = std::conj(chirps[n]);
        if (n > 0) kernel[padded - n] = kernel[n];
    }
    Series product = transform(signal);
    const Series other = transform(kernel);
    for (std::size_t k = 0; k < padded; ++k) product[k] *= other[k];
    Eigen::FFT<double> fft;
    Series convolved;
    fft.inv(convolved, product);
    Series out(size / 2 + 1);
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = convolved[k] * chirps[k];
    return out;
}

}  // namespace

Series fourier_transform(const std::vector<double>& x) {
    if (x.size() < 2) return Series(x.begin(), x.end());
    if (!is_smooth(x.size())) return bluestein(x);
    Series out = transform(Series(x.begin(), x.end()));
    out.resize(x.size() / 2 + 1);
    return out;
}

}  // namespace dttmm::host
