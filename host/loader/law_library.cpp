// SPDX-License-Identifier: BSD-3-Clause
#include "loader/law_library.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <utility>

#include "loader/plugin_call.h"
#include "model/error.h"

namespace dttmm::host {

namespace {

constexpr uint32_t kMostLaws = 1000;

/// The laws in use and their libraries. Read by signal handlers.
std::deque<std::pair<const dttmm_law*, SharedLibrary>>& known() {
    static auto& laws = *new std::deque<std::pair<const dttmm_law*, SharedLibrary>>;  // never gone: exit() may be reported
    return laws;
}

}  // namespace

std::vector<const dttmm_law*> LawLibrary::laws_of(const SharedLibrary& library) {
    const auto entry = reinterpret_cast<dttmm_law_entry_function>(library.symbol(DTTMM_LAW_ENTRY));
    if (!entry) return {};
    std::vector<const dttmm_law*> laws;
    const PluginCall at_work(library.name());
    for (uint32_t i = 0; i < kMostLaws; ++i) {
        const dttmm_law* law = nullptr;
        try {
            law = entry(DTTMM_LAW_MAJOR, i);
        } catch (...) {
            throw Error(ExitCode::plugin_failure, fmt::format("plugin {}: {}", library.name(), describe_exception()));
        }
        if (!law) break;
        if (std::ranges::find(laws, law) != laws.end() || i + 1 == kMostLaws)
            throw Error(
                ExitCode::plugin_failure,
                fmt::format("plugin {}: its list of laws does not end; return NULL behind the last", library.name()));
        laws.push_back(law);
        known().emplace_back(law, library);
    }
    if (laws.empty())
        throw Error(ExitCode::plugin_failure,
                    fmt::format("plugin {}: it has no law of version {} of the interface", library.name(), DTTMM_LAW_MAJOR));
    return laws;
}

const char* LawLibrary::file_of(const dttmm_law* law) noexcept {
    for (const auto& [one, library] : known())
        if (one == law) return library.name().c_str();
    return "?";
}

}  // namespace dttmm::host
