// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "model/error.h"
#include "study/study_folder.h"

namespace dttmm::host {

/// Cases by their numbers, counted from 0 here and from 1 in texts: "1-40,57". Throws Error(usage) for another form and a
/// number beyond `count`.
std::string describe_cases(const std::vector<size_t>& cases);
std::vector<size_t> parse_cases(const std::string& text, size_t count);

/// Works on cases of a study with `jobs` processes of this program, each on many cases one after the other, and goes on
/// until all have ended or the user stops it. A case whose process crashes or exceeds the limit has failed; the others of
/// that process go on in another one. One whose process is ended from outside is tried once more. Throws Error(input_output)
/// where a journal cannot be written; what has been done is kept.
void work_on(const StudyFolder& study, std::vector<size_t> cases, int jobs, bool quiet);

/// One of those processes: cases one after the other, noted in a journal of this name. Returns ok, or the code of a stop.
ExitCode serve(const StudyFolder& study, const std::vector<size_t>& cases, const std::string& journal, int attempt);

}  // namespace dttmm::host
