// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

namespace dttmm::host {

/// A statement about a model or a result that its user must know.
struct Warning {
    std::string code;  ///< of its kind, in kebab-case, the same in every version: "free-body"
    std::string text;  ///< place or subject, fault, cure

    bool operator==(const Warning&) const = default;
};

}  // namespace dttmm::host
