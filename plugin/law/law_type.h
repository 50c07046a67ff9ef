// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <limits>
#include <memory>
#include <span>

#include "law/law.h"

namespace dttmm::plugin {

/// The least value of a parameter of either sign.
inline constexpr double kAnySign = -std::numeric_limits<double>::max();

/// A number that a law needs, as the model file gives it.
struct LawParameter {
    const char* name;
    const char* unit[2];  ///< in a translation, in a rotation; as UDUNITS-2 reads it
    double minimum;       ///< SI
    const char* documentation;
};

/// A law as data: what it is called, what it needs, how it is made of it.
struct LawType {
    const char* name;
    std::span<const LawParameter> parameters;
    std::function<std::unique_ptr<const Law>(const double* values)> make;
};

template <class L, std::size_t count>
std::unique_ptr<const Law> make_law(const double* values) {
    return std::make_unique<const L>(std::span<const double, count>(values, count));
}

}  // namespace dttmm::plugin
