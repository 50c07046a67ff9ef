// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/trace_file.h"

#include <fmt/format.h>

#include <iterator>

#include "record/csv_writer.h"

namespace dttmm::host {

namespace {

constexpr size_t kMostWaiting = 64 * 1024;  // bytes

const std::vector<Column> kColumns = {{"step", "1"},
                                      {"time", "s"},
                                      {"step_size", "s"},
                                      {"passes", "1"},
                                      {"factorisations", "1"},
                                      {"inside_factorisations", "1"},
                                      {"correction", "m/s"},
                                      {"residual", "N*s"},
                                      {"inside_correction", "m/s"},
                                      {"inside_residual", "N*s"},
                                      {"rate", "1"},
                                      {"stops", "1"},
                                      {"waited_for", ""}};

}  // namespace

TraceFile::TraceFile(const std::filesystem::path& path) : file_(File::create(path)) { file_.write(csv_header(kColumns)); }

TraceFile::~TraceFile() { file_.write_some(waiting_); }

void TraceFile::write(const Simulation& simulation, const StepReport& report) {
    fmt::format_to(std::back_inserter(waiting_), "{},{},{},{},{},{},{:.3g},{:.3g},{:.3g},{:.3g},{:.3g},{},", report.step,
                   report.time, simulation.step_size(), report.passes, report.factorisations, report.inside_factorisations,
                   report.correction, report.residual, report.inside_correction, report.inside_residual, report.rate,
                   report.stops);
    add_csv_field(simulation.waited_for(report), waiting_);
    waiting_ += '\n';
    if (waiting_.size() < kMostWaiting) return;
    file_.write(waiting_);
    waiting_.clear();
}

}  // namespace dttmm::host
