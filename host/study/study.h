// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "analysis/request.h"
#include "model/error.h"

namespace dttmm::host {

/// `dttmm study`, by its words:
///     MODEL            makes a study of the model and works on all its cases, or goes on with one that is there
///     status FOLDER    how far it is
///     collect FOLDER   its tables, from what has been done so far
///     retry FOLDER     works again on the cases that failed, and on those not done
///     work FOLDER CASES    what a worker anywhere does: "1-40,57"
/// Returns ok, cases_failed, or the code of a stop. Throws Error for a fault of the words, the model or the folder.
ExitCode run_study(const Request& request);

}  // namespace dttmm::host
