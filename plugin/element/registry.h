// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <span>

#include "dttmm_plugin.h"
#include "element/element.h"

namespace dttmm::plugin {

/// The element library: one line per element in registry.cpp. The order is the type index of the C interface.
std::span<const dttmm_element_type> element_types();

/// Builds the element of type index `type`; `values` holds its parameters in the declared order.
/// Throws Error(DTTMM_ERROR_ARGUMENT) for an unknown type or a value that is not finite or out of its declared range.
std::unique_ptr<const Element> make_element(uint32_t type, const double* values);

}  // namespace dttmm::plugin
