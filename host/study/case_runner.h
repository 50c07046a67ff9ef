// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "loader/plugins.h"
#include "record/column.h"
#include "study/journal.h"
#include "study/study_folder.h"

namespace dttmm::host {

/// The figures that the cases of a study have, by the model as the file has it. Throws Error for a model that cannot be
/// worked on, and for a figure that it does not have.
std::vector<Column> find_figures(const StudyPlan& plan, const Plugins& plugins);

/// What a case asks for: the request of the study with the parameters of the case.
Request request_of(const StudyPlan& plan, size_t index);

/// Works on one case of a study in this process. A case that fails is an outcome too. Throws Error(stopped_by_user) when it
/// is stopped before its end, Error(input_output) where a file of the study cannot be written.
CaseOutcome run_case(const StudyPlan& plan, size_t index, const Plugins& plugins, const std::filesystem::path& folder);

}  // namespace dttmm::host
