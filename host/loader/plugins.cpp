// SPDX-License-Identifier: BSD-3-Clause
#include "loader/plugins.h"

#include <fmt/format.h>

#include "loader/law_library.h"
#include "model/error.h"
#include "model/index.h"

namespace dttmm::host {

Plugins::Plugins(const std::vector<std::string>& files) {
    std::vector<PluginLibrary> plugins = {PluginLibrary::built_in()};
    std::vector<const dttmm_law*> laws;
    for (const std::string& file : files) {
        const SharedLibrary library(file);
        const std::vector<const dttmm_law*> own = LawLibrary::laws_of(library);
        laws.insert(laws.end(), own.begin(), own.end());
        if (own.empty() || library.symbol(DTTMM_PLUGIN_ENTRY)) plugins.push_back(PluginLibrary::load(library));
    }
    // Before the element types are read: these have the parameters of the laws
    for (const dttmm_law* law : laws)
        for (const PluginLibrary& plugin : plugins) plugin.add_law(*law);
    for (PluginLibrary& plugin : plugins) add(std::move(plugin));
}

void Plugins::add(PluginLibrary library) {
    const dttmm_plugin& table = library.table();
    for (uint32_t t = 0; t < table.element_type_count; ++t) {
        const dttmm_element_type& type = table.element_types[t];
        if (const int other = catalogue_.find(type.name); other >= 0)
            throw Error(ExitCode::plugin_failure,
                        fmt::format("plugin {}: its element type \"{}\" is already declared by plugin {}", library.name(),
                                    type.name, catalogue_.plugins[as_size(other)]));
        catalogue_.add(library.name(), type);
        places_.emplace_back(libraries_.size(), t);
    }
    libraries_.push_back(std::move(library));
}

std::pair<const PluginLibrary*, uint32_t> Plugins::resolve(int type) const {
    const auto& [library, index] = places_[as_size(type)];
    return {&libraries_[library], index};
}

}  // namespace dttmm::host
