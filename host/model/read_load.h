// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "model/attachments.h"
#include "model/element_catalogue.h"
#include "model/name_registry.h"

namespace dttmm::host {

/// What a load may act on.
struct LoadPlaces {
    const Attachments& attachments;
    const std::vector<Element>& elements;
    const NameRegistry& element_names;  ///< those of elements with faults too
    const ElementCatalogue& catalogue;
};

/// The [[load]] entries of the file. Loads with faults, which are reported, are left out.
std::vector<Load> read_loads(const TableReader& file, const LoadPlaces& places);

}  // namespace dttmm::host
