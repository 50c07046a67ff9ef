// SPDX-License-Identifier: BSD-3-Clause
#include "law/registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <string_view>
#include <vector>

#include "core/error.h"
#include "law/cubic.h"
#include "law/foreign_law.h"
#include "law/linear.h"

namespace dttmm::plugin {

namespace {

std::vector<LawType>& all() {
    static std::vector<LawType> types = {Linear::kType, Cubic::kType};  // one word per law
    return types;
}

bool is_key(const char* name) {
    if (!name || !*name) return false;
    const std::string_view text(name);
    return text != "law" && (text[0] < '0' || text[0] > '9') && std::ranges::all_of(text, [](unsigned char c) {
               return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
           });
}

/// Keys of an axial_spring, beside which the parameters of its law stand, and of every element.
constexpr std::string_view kTaken[] = {"name",    "type",        "from",           "to",     "axes", "at", "motion",
                                       "damping", "loss_factor", "natural_length", "preload"};

[[noreturn]] void refuse(const dttmm_law& law, const char* fault) {
    throw Error(DTTMM_ERROR_ARGUMENT, fmt::format("law \"{}\": {}", is_key(law.name) ? law.name : "?", fault));
}

/// A number means the same in every law that has a parameter of that name: the keys of all laws stand in one table.
bool is_known_otherwise(const dttmm_law_parameter& parameter) {
    for (const LawType& type : all())
        for (const LawParameter& other : type.parameters)
            if (std::string_view(other.name) == parameter.name &&
                (std::string_view(other.unit[0]) != parameter.unit ||
                 std::string_view(other.unit[1]) != parameter.rotation_unit))
                return true;
    return false;
}

void check(const dttmm_law& law) {
    if (law.major != DTTMM_LAW_MAJOR || law.size < sizeof(dttmm_law)) refuse(law, "it is of another version");
    if (!is_key(law.name))
        refuse(law, "its name must be letters, digits and underscores, without a digit first, and not \"law\"");
    if (!law.along || (law.parameter_count > 0 && !law.parameters)) refuse(law, "it is not whole");
    if (law.memory_count > Law::kMostMemory) refuse(law, "it remembers more than 256 numbers");
    if (law.parameter_count > 100) refuse(law, "it has more than 100 parameters");
    for (const dttmm_law_parameter& parameter : std::span(law.parameters, law.parameter_count)) {
        if (!is_key(parameter.name) || !parameter.unit || !parameter.rotation_unit || !std::isfinite(parameter.minimum))
            refuse(law, "a parameter is not well declared");
        if (std::ranges::count_if(std::span(law.parameters, law.parameter_count), [&](const dttmm_law_parameter& other) {
                return other.name && std::string_view(other.name) == parameter.name;
            }) > 1)
            refuse(law, "two of its parameters have one name");
        if (std::ranges::find(kTaken, std::string_view(parameter.name)) != std::end(kTaken))
            refuse(law, "a parameter has the name of a key of elements: rename it");
        if (is_known_otherwise(parameter))
            refuse(law, "another law has a parameter of the same name with another unit: rename it");
    }
}

}  // namespace

std::span<const LawType> law_types() { return all(); }

void add_law(const dttmm_law& law, const dttmm_law* volatile* at_work) {
    static std::deque<std::pair<const dttmm_law*, std::vector<LawParameter>>> added;
    if (std::ranges::any_of(added, [&](const auto& one) { return one.first == &law; })) return;
    check(law);
    if (std::ranges::any_of(all(), [&](const LawType& type) { return std::string_view(type.name) == law.name; }))
        refuse(law, "there is another law of this name");
    std::vector<LawParameter>& parameters = added.emplace_back(&law, std::vector<LawParameter>{}).second;
    for (const dttmm_law_parameter& one : std::span(law.parameters, law.parameter_count))
        parameters.push_back(
            {one.name, {one.unit, one.rotation_unit}, one.minimum, one.documentation ? one.documentation : ""});
    all().push_back({law.name, parameters, [&law, at_work](const double* values) -> std::unique_ptr<const Law> {
                         return std::make_unique<const ForeignLaw>(law, at_work, values);
                     }});
}

}  // namespace dttmm::plugin
