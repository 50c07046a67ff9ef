// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"

namespace dttmm::host {

/// `dttmm check-law FILE`: asks every law of a library what it does on random paths, with random parameters or those of
/// --set, and prints which rules of dttmm_law.h it breaks. Throws Error(plugin_failure) where one does, or for a library
/// without laws.
void check_law(const Request& request);

}  // namespace dttmm::host
