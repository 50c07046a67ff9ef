// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "loader/plugin_library.h"
#include "model/element_catalogue.h"

namespace dttmm::host {

/// The plugins of one run, the built-in one first, and the catalogue of all their element types.
class Plugins {
public:
    /// Loads the built-in plugin and those at `files`. Throws Error(plugin_failure) also when two declare the same type.
    explicit Plugins(const std::vector<std::string>& files = {});

    const ElementCatalogue& catalogue() const { return catalogue_; }
    const std::vector<PluginLibrary>& libraries() const { return libraries_; }

    /// The plugin of a catalogue type, and the type's index in that plugin's own table.
    std::pair<const PluginLibrary*, uint32_t> resolve(int type) const;

private:
    void add(PluginLibrary library);
    std::vector<PluginLibrary> libraries_;
    std::vector<std::pair<size_t, uint32_t>> places_;
    ElementCatalogue catalogue_;
};

}  // namespace dttmm::host
