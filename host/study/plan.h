// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "loader/plugins.h"
#include "study/study_folder.h"

namespace dttmm::host {

/// The cases that --vary, --sweep or --table ask for. model: as the file has it. Throws Error(usage) for options that do not
/// go together and for a parameter that does not exist.
CaseTable make_cases(const Request& request, const Model& model);

/// An option of another command would be read and then not count: throws Error(usage). command: run, modes or response,
/// which `what` does.
void refuse_options_beside(const Request& request, const std::string& command, const std::string& what);

/// What `dttmm study MODEL` is to do. Throws Error as make_cases does, and for figures that the model does not have.
StudyPlan make_plan(const Request& request, const Model& model, const Plugins& plugins);

}  // namespace dttmm::host
