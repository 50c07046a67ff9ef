// SPDX-License-Identifier: BSD-3-Clause
#include "identify/suspects.h"

namespace dttmm::host {

namespace {

constexpr double kLowestFactor = 0.01, kHighestFactor = 100;  // of a suspect

Unknown factor_of(Unknown::Of of, const std::string& element) {
    Unknown unknown{
        of, element + (of == Unknown::Of::stiffness ? ".stiffness" : ".damping"), "1", 1, kLowestFactor, kHighestFactor};
    unknown.element = element;
    return unknown;
}

}  // namespace

Unknowns Suspects::unknowns(const Unknowns& common, const std::vector<std::string>& elements, bool are_alike,
                            bool with_damping) const {
    Unknowns all = common;
    for (const std::string& element : elements) {
        Unknown stiffness = factor_of(Unknown::Of::stiffness, element);
        if (are_alike) stiffness.shared = elements;
        all.add(stiffness);
        if (are_alike) break;
    }
    std::vector<std::string> damped;
    for (const std::string& element : elements)
        if (is_damped(element)) damped.push_back(element);
    for (const std::string& element : damped) {
        if (!with_damping) break;
        Unknown damping = factor_of(Unknown::Of::damping, element);
        if (are_alike) damping.shared = damped;
        all.add(damping);
        if (are_alike) break;
    }
    return all;
}

}  // namespace dttmm::host
