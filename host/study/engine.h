// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "study/study_folder.h"

namespace dttmm::host {

/// What else than this machine works on cases: --on "parallel:host1,host2", "slurm:-p long --time=60".
struct Engine {
    enum class Kind : unsigned char { parallel, slurm };
    Kind kind = Kind::parallel;
    std::string options;  ///< hosts of GNU parallel, options of sbatch
};

/// Throws Error(usage).
Engine parse_engine(const std::string& text);

/// Hands the cases to GNU parallel, a chunk per job, and waits for it. hosts: parted by commas; none: this machine. The
/// hosts see the folder of the study and this program under the same paths. Throws Error(input_output) where there is no GNU
/// parallel or where it fails; what has been done is kept.
void run_by_parallel(const StudyFolder& study, const std::vector<size_t>& cases, const std::string& hosts, int jobs);

/// Submits a job array and returns how many tasks it has. A task works on a chunk of cases; there are at most as many as
/// the site allows in an array (MaxArraySize). Throws Error(input_output) where sbatch is not there or refuses.
size_t submit_to_slurm(const StudyFolder& study, const std::vector<size_t>& cases, const std::string& options);

}  // namespace dttmm::host
