// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "dttmm_plugin.h"
#include "model/index.h"
#include "model/keys.h"

namespace dttmm::host {

/// The element types of all loaded plugins: what an [[element]] of the model may be. The types belong to the plugins and
/// live as long as these stay loaded.
struct ElementCatalogue {
    std::vector<const dttmm_element_type*> types;
    std::vector<std::string> plugins;  ///< plugins[i] is the name of the plugin that declares types[i]

    void add(std::string_view plugin, const dttmm_element_type& type) {
        types.push_back(&type);
        plugins.emplace_back(plugin);
    }

    /// Index of the type called `name`; -1 if no plugin declares it.
    int find(std::string_view name) const {
        for (std::size_t i = 0; i < types.size(); ++i)
            if (name == types[i]->name) return as_int(i);
        return -1;
    }
};

/// Where a parameter may lie, as the tables of keys say it: "more than zero" is the smallest positive number in the
/// plugin's.
inline Bounds bounds_of(const dttmm_parameter& parameter) {
    using Limits = std::numeric_limits<double>;
    Bounds bounds;
    if (parameter.minimum > -Limits::max()) bounds.minimum = parameter.minimum;
    if (parameter.maximum < Limits::max()) bounds.maximum = parameter.maximum;
    if (parameter.minimum == Limits::min()) bounds = {0, bounds.maximum, true};
    return bounds;
}

/// Whether an element of the type has a law that is not linear: a word of its own for a parameter called `law`.
inline bool has_law(const dttmm_element_type& type, const std::vector<double>& values) {
    std::size_t at = 0;
    for (const dttmm_parameter& parameter : std::span(type.parameters, type.parameter_count)) {
        const auto* word = std::find_if(parameter.words, parameter.words + parameter.word_count,
                                        [&](const dttmm_word& one) { return one.value == values[at]; });
        at += parameter.count;
        const std::string_view name = parameter.name;
        if ((name != "law" && !name.ends_with(".law")) || word == parameter.words + parameter.word_count) continue;
        if (std::string_view(word->name) != "linear") return true;
    }
    return false;
}

/// Whether its local x lies along the line between its ends; otherwise it has the axes of its `from` end.
inline bool is_line(const dttmm_element_type& type) { return type.ends == DTTMM_ENDS_ALONG || type.ends == DTTMM_ENDS_LINE; }

/// Whether forces per length may act on it.
inline bool takes_line_loads(const dttmm_element_type& type) { return type.ends == DTTMM_ENDS_LINE; }

}  // namespace dttmm::host
