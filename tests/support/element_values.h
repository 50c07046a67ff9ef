// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "dttmm_plugin.h"

namespace dttmm::test {

using Given = std::map<std::string, std::vector<double>>;

/// Numbers of a list of parameters in the declared order: its defaults, and in their place what is given by name.
inline std::vector<double> values_of(std::span<const dttmm_parameter> parameters, Given given) {
    std::vector<double> values;
    for (const dttmm_parameter& parameter : parameters) {
        const auto own = given.find(parameter.name);
        if (own == given.end()) {
            values.insert(values.end(), parameter.count, parameter.default_value);
            continue;
        }
        if (own->second.size() != parameter.count) throw std::logic_error("wrong number of numbers: " + own->first);
        values.insert(values.end(), own->second.begin(), own->second.end());
        given.erase(own);
    }
    if (!given.empty()) throw std::logic_error("no such parameter: " + given.begin()->first);
    return values;
}

inline std::vector<double> values_of(const dttmm_element_type& type, const Given& given) {
    return values_of(std::span(type.parameters, type.parameter_count), given);
}

/// `more` added to `base`, in place of what is there of the same name.
inline Given with(Given base, const Given& more) {
    for (const auto& [name, values] : more) base[name] = values;
    return base;
}

}  // namespace dttmm::test
