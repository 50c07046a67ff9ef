// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/json.h"
#include "record/csv_file.h"
#include "report/curve_set.h"

namespace dttmm::host {

/// What a report shows of results.
struct ReportChoice {
    std::vector<std::string> patterns;  ///< of channels of a run, as in --channels; none: all
    std::size_t most_points = 4000;     ///< of a curve
};

/// One results folder of any command, or the history.csv of a run, as the page reads it: kind, summary.json, model, curves,
/// tables, motion, shapes, notes. Throws Error(input_output) for what is no results of dttmm, and says what it is; for a
/// damaged file of results, with its place; Error(usage) for a pattern without a channel.
Json describe_results(const std::filesystem::path& path, const ReportChoice& choice);

/// Throws Error(usage) where two of these paths name the same results, as "results/pump" and "results/pump/history.csv" do:
/// one curve would cover the other. Else as describe_results does.
void refuse_repeated_results(const std::vector<std::string>& paths);

/// Where a file made of results stands unless -o says otherwise: results/pump.html for results/pump. Never in the results
/// folder, also for ".": a command that replaces results would take it for a foreign file there.
std::filesystem::path path_beside(const std::string& results, const char* ending);

/// Results with all their digits, for other programs.
struct Results {
    std::filesystem::path folder;
    std::string kind;        ///< "run", "modes", "static", "frf", "response", "spectrum", "sweep", "study"
    std::string title;       ///< of the model; empty where it is not known
    std::string written;     ///< "2026-11-25 08:03 UTC"; empty where it is not known
    Json summary;            ///< summary.json without the two below; null where there is none
    Json model;              ///< its member "model"; null where there is none
    std::string model_text;  ///< the model file
    std::vector<CurveSet> sets;
    std::vector<std::string> notes;  ///< what is missing of them
};

/// The same as read_curve_sets, and what is known beside. Throws as describe_results does.
Results read_results(const std::filesystem::path& path);

/// All tables of a results folder that are no curves: every other CSV file in it, by name. Throws Error(input_output) for
/// a damaged one, with its place.
std::vector<CsvFile> read_tables(const std::filesystem::path& folder);

/// All curves of the same, whole: one set per file, of orders over speed one per order. Throws as describe_results does.
std::vector<CurveSet> read_curve_sets(const std::filesystem::path& path);

}  // namespace dttmm::host
