// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <span>

#include "law/law_type.h"

namespace dttmm::plugin {

/// All laws that the model file may name.
std::span<const LawType> law_types();

}  // namespace dttmm::plugin
