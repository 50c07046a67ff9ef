// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

namespace dttmm::host {

/// A model that is part of the program.
struct Template {
    const char* name;
    const char* text;
};

/// Those that `dttmm help` shows: host/help/<name>.toml.
std::span<const Template> help_models();
/// Those that `dttmm new --from` copies: examples/<folder>/model.toml.
std::span<const Template> new_models();

}  // namespace dttmm::host
