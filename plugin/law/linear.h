// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "law/law.h"
#include "law/law_type.h"

namespace dttmm::plugin {

/// f = k d.
class Linear final : public Law {
public:
    /// values: k.
    explicit Linear(std::span<const double, 1> values) : k_(values[0]) {}
    LawOnPath along(const LawPath& path) const override;
    bool is_linear() const override { return true; }

    static const LawType kType;

private:
    double k_;
};

}  // namespace dttmm::plugin
