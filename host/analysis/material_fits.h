// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "loader/plugins.h"
#include "model/model.h"
#include "record/warnings.h"

namespace dttmm::host {

/// Whether an element of the type has rows over frequency.
bool has_rows(const dttmm_element_type& type, const std::vector<double>& values);

/// Reports how well the Maxwell series agree that stand for measured rows: a note of the worst direction of all elements; a
/// warning where it is off by more than a tenth.
void report_fits(const Model& model, const Plugins& plugins, Warnings& warnings);

}  // namespace dttmm::host
