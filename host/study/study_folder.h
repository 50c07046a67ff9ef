// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "analysis/request.h"
#include "model/model.h"
#include "record/column.h"
#include "study/case_table.h"
#include "study/journal.h"

namespace dttmm::host {

/// What a study is, fixed when it is made.
struct StudyPlan {
    std::string command = "run";       ///< that every case does: "run", "modes" or "response"
    Request request;                   ///< of every case, but for its parameters; the model is the copy in the folder
    std::vector<std::string> figures;  ///< as given to --figures
    std::vector<Column> columns;       ///< of the figures of a case
    std::string design;                ///< by its name; empty for a grid or a table
    CaseTable cases;
    std::vector<Parameter> parameters;  ///< all of the model, as the file has them
    double limit = 0;                   ///< of a case [s]; 0: none
    bool keeps = false;                 ///< the histories of the cases
};

/// The folder of a study, all that a worker anywhere needs:
///     study.json       what every case does, and from what it was made; never rewritten
///     cases.csv        the numbered cases; never rewritten
///     model/           the model file, the tables it names, and plugins, as they were
///     journal/         what workers have done, a file each
///     case-000001/     results of a case, where they are kept
///     results.csv, results.h5, statistics.csv, correlations.csv, sensitivities.csv, failures.csv, summary.json: what
///     collect
///                      makes of it
class StudyFolder {
public:
    /// Opens a study that is there. Throws Error(input_output) for a folder that is none, or of another format.
    explicit StudyFolder(const std::filesystem::path& path);

    /// Makes a study, or finds that it is there already with the same plan: is_new tells. Throws Error(input_output) where
    /// the folder holds another study or something else.
    static StudyFolder make(const std::filesystem::path& path, const Request& request, const StudyPlan& plan,
                            const Model& model);

    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path journal() const { return path_ / "journal"; }
    const StudyPlan& plan() const { return plan_; }
    /// How the study was asked for.
    const std::string& command_line() const { return command_line_; }
    /// Of the model.
    const std::string& title() const { return title_; }

    /// Of every case, as the journals have it.
    std::vector<CaseOutcome> outcomes() const;

private:
    std::filesystem::path path_;
    StudyPlan plan_;
    std::string title_, command_line_;
};

}  // namespace dttmm::host
