// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "analysis/modal_machine.h"

namespace dttmm::host {

/// Motions that nothing holds: rigid-body modes.
struct FreeMotions {
    /// `dttmm check` takes up to 3 s of processor time for the shapes of 90, and over 200 s for those of 1794.
    static constexpr uint32_t kMostQuick = 100;
    /// More names than a reader reads.
    static constexpr uint32_t kMostNamed = 20;

    uint32_t count = 0;
    std::vector<std::string> names;  ///< what moves, as `dttmm modes` says it, once each; none of more than kMostNamed
    bool is_certain = true;          ///< else some may be held by so little that rounding hides it

    /// Their shapes were looked at, and are strained, but by so little.
    bool may_be_held() const { return !is_certain && !names.empty(); }
    /// "nothing holds 2 motions (cart: y 100 %; truck: rz 100 %)"
    std::string text() const;
};

/// Nothing: the plugin does not count them. Throws Error where they cannot be counted or distinguished from slow
/// vibrations.
std::optional<FreeMotions> find_free(const Model& model, ModalMachine& machine);

}  // namespace dttmm::host
