// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <complex>
#include <vector>

namespace dttmm::host {

/// X_k = sum over n of x_n exp(-2 pi i k n/N), k = 0 .. N/2, of a real series of any length N >= 1. A length with a large
/// prime factor, as 1 000 001 rows, goes by Bluestein's convolution of a power of two: the cost is N log N for all.
/// Source: Bluestein (1970), IEEE Trans. Audio Electroacoust. 18(4), 451-455.
std::vector<std::complex<double>> fourier_transform(const std::vector<double>& x);

}  // namespace dttmm::host
