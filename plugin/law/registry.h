// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "dttmm_law.h"
#include "law/law_type.h"

namespace dttmm::plugin {

/// All laws that the model file may name: those built in, then those that were added. The span is good until one is added.
std::span<const LawType> law_types();

/// Adds a law of a library that stays loaded; one that is there already is not added again. Throws
/// Error(DTTMM_ERROR_ARGUMENT): not whole, another version, a name or key that is none, a name that is taken.
void add_law(const dttmm_law& law, const dttmm_law* volatile* at_work);

}  // namespace dttmm::plugin
