// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>
#include <vector>

#include "model/index.h"

namespace dttmm::host {

/// Numbers that a plugin writes, between guard words: one that writes past them is found out.
class GuardedArray {
public:
    explicit GuardedArray(size_t size = 0) { resize(size); }

    /// All zero. Allocates only to grow.
    void resize(size_t size) {
        size_ = size;
        words_.assign(size + 2 * kGuards, 0.0);
        for (size_t i = 0; i < kGuards; ++i) {
            std::memcpy(&words_[i], &kPattern, sizeof kPattern);
            std::memcpy(&words_[kGuards + size + i], &kPattern, sizeof kPattern);
        }
    }
    /// Room for so many: resize() then allocates nothing up to there.
    void reserve(size_t size) { words_.reserve(size + 2 * kGuards); }
    size_t size() const { return size_; }
    double* data() { return words_.data() + kGuards; }
    const double* data() const { return words_.data() + kGuards; }
    double operator[](size_t i) const { return words_[kGuards + i]; }

    /// Where it was written past: "start" or "end"; NULL: nowhere.
    const char* overrun() const {
        const char* at = nullptr;
        for (size_t i = 0; i < kGuards; ++i) {
            if (std::memcmp(&words_[i], &kPattern, sizeof kPattern) != 0) at = "start";
            if (std::memcmp(&words_[kGuards + size_ + i], &kPattern, sizeof kPattern) != 0) return "end";
        }
        return at;
    }

private:
    static constexpr size_t kGuards = 8;
    static constexpr uint64_t kPattern = 0x7ffadadadadadadaULL;  ///< a quiet NaN
    std::vector<double> words_;
    size_t size_ = 0;
};

}  // namespace dttmm::host
