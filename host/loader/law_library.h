// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "dttmm_law.h"
#include "loader/shared_library.h"

namespace dttmm::host {

/// The force laws of a shared library. It stays loaded for good: plugins that know its laws may outlive everything else.
class LawLibrary {
public:
    /// None if the library exports no laws. Throws Error(plugin_failure) when it exports the entry but no law of this
    /// version.
    static std::vector<const dttmm_law*> laws_of(const SharedLibrary& library);

    /// Where plugins say which law they ask just now: for the report of a crash.
    static const dttmm_law* volatile* at_work() noexcept { return &at_work_; }
    /// The library that a law came from.
    static const char* file_of(const dttmm_law* law) noexcept;

private:
    static inline const dttmm_law* volatile at_work_ = nullptr;
};

}  // namespace dttmm::host
