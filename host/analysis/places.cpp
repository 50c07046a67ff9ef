// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/places.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "model/error.h"
#include "model/index.h"
#include "model/units.h"
#include "model/wording.h"

namespace dttmm::host {

std::pair<const ModalPlace*, int> place_and_direction(const Model& model, const ModalMachine& machine,
                                                      const std::string& option, const std::string& text) {
    const size_t dot = text.rfind('.');
    std::vector<std::string> known;
    for (const ModalPlace& place : machine.places()) known.push_back(place.name);
    if (dot == std::string::npos)
        throw Error(ExitCode::usage,
                    fmt::format("{} {}: write place.direction, e.g. {}.z", option, quote(text), known.front()));
    const std::string name = text.substr(0, dot), direction = text.substr(dot + 1);
    const auto d = std::ranges::find(direction_names(), direction);
    if (d == direction_names().end())
        throw Error(ExitCode::usage, fmt::format("{} {}: {} is none of the directions {}", option, quote(text),
                                                 quote(direction), listed(direction_names())));
    const ModalPlace* place = machine.find(name);
    if (!place)
        throw Error(ExitCode::usage, fmt::format("{} {}: no body, marker or node {}{}", option, quote(text), quote(name),
                                                 suggestion(name, known)));
    const auto index = as_size(d - direction_names().begin());
    if (!model.modes.directions[index])
        throw Error(ExitCode::usage,
                    fmt::format("{} {}: nothing moves in {}: the model's dofs leave it out", option, quote(text), *d));
    return {place, as_int(index)};
}

double frequency_of(const std::string& option, const std::string& text) {
    try {
        const double value = parse_quantity(text, "Hz");
        if (value >= 0 && std::isfinite(value)) return value;
        throw Error(ExitCode::usage, "must be zero or more");
    } catch (const Error& error) {
        throw Error(ExitCode::usage, fmt::format("{} {}: {}", option, quote(text), error.what()));
    }
}

}  // namespace dttmm::host
