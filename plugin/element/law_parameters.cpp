// SPDX-License-Identifier: BSD-3-Clause
#include "element/law_parameters.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>

#include "core/error.h"
#include "core/index.h"
#include "core/state_vector.h"
#include "element/parameters.h"
#include "law/registry.h"

namespace dttmm::plugin {

const LawParameters& LawParameters::of_direction(int direction) {
    // Anew where a law was added; what was handed out stays
    static std::deque<std::vector<std::unique_ptr<const LawParameters>>> all;
    static size_t laws = 0;
    if (laws != law_types().size()) {
        laws = law_types().size();
        auto& own = all.emplace_back();
        for (int d = 0; d < 6; ++d) own.emplace_back(new LawParameters(kDirectionNames[as_size(d)], d >= 3));
        own.emplace_back(new LawParameters("", false));
    }
    return *all.back()[as_size(direction)];
}

const LawParameters& LawParameters::along_a_line() { return of_direction(6); }

LawParameters::LawParameters(const std::string& key, bool is_rotation) : key_(key), is_rotation_(is_rotation) {
    std::vector<LawParameter> numbers;
    for (const LawType& type : law_types()) {
        words_.push_back({type.name, static_cast<double>(words_.size())});
        for (const LawParameter& parameter : type.parameters) {
            const auto known = std::ranges::find(names_, parameter.name);
            if (known != names_.end()) {  // each law has a minimum of its own
                double& least = numbers[as_size(known - names_.begin())].minimum;
                least = std::min(least, parameter.minimum);
                continue;
            }
            names_.push_back(parameter.name);
            numbers.push_back(parameter);
        }
    }
    texts_.push_back(full("law"));
    for (const std::string& name : names_) texts_.push_back(full(name));
    declared_.push_back(
        {texts_[0].c_str(), "1", 1, DTTMM_PARAMETER_WORDS_ONLY, key.empty() ? 0 : kNotGiven, 0, kLargest, words_.data(),
         as_whole<uint32_t>(words_.size()),
         key.empty() ? "law of the spring" : "law of the spring in that direction, in place of a stiffness"});
    for (size_t i = 0; i < names_.size(); ++i)
        declared_.push_back(optional(texts_[1 + i].c_str(), numbers[i].unit[is_rotation], 1, numbers[i].minimum, kLargest,
                                     numbers[i].documentation));
}

std::unique_ptr<const Law> LawParameters::make(std::span<const double> values) const {
    const auto given = [&](size_t i) { return is_given(values[1 + i]); };
    if (!is_given(values[0])) {
        for (size_t i = 0; i < names_.size(); ++i)
            if (given(i))
                throw Error(DTTMM_ERROR_MODEL, fmt::format("{} needs a law: add {}", full(names_[i]), full("law")));
        return nullptr;
    }
    const LawType& type = law_types()[static_cast<size_t>(values[0])];
    std::vector<double> own;
    for (const LawParameter& parameter : type.parameters) {
        const auto i = as_size(std::ranges::find(names_, parameter.name) - names_.begin());
        if (!given(i))
            throw Error(DTTMM_ERROR_MODEL,
                        fmt::format("{} is missing: the law {} needs it", full(parameter.name), type.name));
        if (values[1 + i] < parameter.minimum)
            throw Error(DTTMM_ERROR_MODEL,
                        fmt::format("{} must be at least {:g} {}, as the law {} has it", full(parameter.name),
                                    parameter.minimum, parameter.unit[is_rotation_], type.name));
        own.push_back(values[1 + i]);
    }
    for (size_t i = 0; i < names_.size(); ++i) {
        const bool is_own =
            std::ranges::any_of(type.parameters, [&](const LawParameter& one) { return one.name == names_[i]; });
        if (given(i) && !is_own)
            throw Error(DTTMM_ERROR_MODEL,
                        fmt::format("{} does not belong to the law {}: remove it", full(names_[i]), type.name));
    }
    return type.make(own.data());
}

std::array<std::shared_ptr<const Law>, 6> laws_of_directions(std::span<const double> values) {
    std::array<std::shared_ptr<const Law>, 6> laws;
    for (int d = 0; d < 6; ++d) {
        const LawParameters& parameters = LawParameters::of_direction(d);
        const size_t count = parameters.declared().size();
        laws[as_size(d)] = parameters.make(values.first(count));
        values = values.subspan(count);
    }
    return laws;
}

void TypeWithLaws::all_directions(Add add) {
    for (int d = 0; d < 6; ++d) add(LawParameters::of_direction(d));
}

const dttmm_element_type& TypeWithLaws::get() {
    if (laws_ != law_types().size()) {
        laws_ = law_types().size();
        std::vector<dttmm_parameter>& all = all_.emplace_back(own_.begin(), own_.end());
        take_([&](const LawParameters& law) { all.insert(all.end(), law.declared().begin(), law.declared().end()); });
        type_.parameter_count = as_whole<uint32_t>(all.size());
        type_.parameters = all.data();
    }
    return type_;
}

void LawParameters::refuse_stiffness(const char* key) const {
    throw Error(DTTMM_ERROR_MODEL, fmt::format("{0}: direction {1} has a law; put 0 there, or leave {1} out", key, key_));
}

}  // namespace dttmm::plugin
