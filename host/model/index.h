// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cassert>
#include <concepts>
#include <cstddef>
#include <utility>

namespace dttmm::host {

/// Sizes and indices of one kind as those of another: a size of the standard library, an int, a row of Eigen. None may be
/// out of its range.
template <std::integral To>
constexpr To as_whole(std::integral auto number) {
    assert(std::in_range<To>(number));
    return static_cast<To>(number);
}
constexpr std::size_t as_size(std::integral auto number) { return as_whole<std::size_t>(number); }
constexpr int as_int(std::integral auto number) { return as_whole<int>(number); }
constexpr std::ptrdiff_t as_row(std::integral auto number) { return as_whole<std::ptrdiff_t>(number); }

}  // namespace dttmm::host
