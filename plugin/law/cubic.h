// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "law/law.h"
#include "law/law_type.h"

namespace dttmm::plugin {

/// Duffing's spring: f = k d + k₃ d³, hardening where k₃ > 0, softening where k₃ < 0.
class Cubic final : public Law {
public:
    /// values: k, k₃.
    explicit Cubic(std::span<const double, 2> values) : k_(values[0]), k3_(values[1]) {}
    LawOnPath along(const LawPath& path) const override;

    static const LawType kType;

private:
    double k_, k3_;
};

}  // namespace dttmm::plugin
