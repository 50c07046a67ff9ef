// SPDX-License-Identifier: BSD-3-Clause
#include "identify/fit_curves.h"

#include <fmt/format.h>

#include <cmath>

#include "model/index.h"
#include "record/atomic_file.h"
#include "record/csv_table.h"

namespace dttmm::host {

namespace {

/// Curves over equal times or frequencies.
struct CurveTable {
    const std::vector<double>* x;
    std::vector<size_t> curves;
};

template <class Observed>
std::vector<CurveTable> group_by_x(const std::vector<Observed>& all, std::vector<double> Observed::*x) {
    std::vector<CurveTable> tables;
    for (size_t i = 0; i < all.size(); ++i) {
        CurveTable* own = nullptr;
        for (CurveTable& table : tables)
            if (*table.x == all[i].*x) own = &table;
        if (!own) own = &tables.emplace_back(CurveTable{&(all[i].*x), {}});
        own->curves.push_back(i);
    }
    return tables;
}

}  // namespace

void write_fit_curves(const ResultsFolder& folder, const Observations& observations, const Comparison& comparison,
                      const Eigen::VectorXd& predicted) {
    const auto& groups = comparison.groups();
    const Eigen::VectorXd& data = comparison.data();
    size_t number = 0;
    for (const CurveTable& table : group_by_x(observations.histories, &ObservedHistory::times)) {
        std::vector<Column> columns = {{"time", "s"}};
        for (const size_t c : table.curves)
            for (const char* part : {".measured", ".predicted", ".residual"})
                columns.push_back({observations.histories[c].channel + part, observations.histories[c].unit});
        CsvTable csv(columns);
        for (size_t i = 0; i < table.x->size(); ++i) {
            csv.add((*table.x)[i]);
            for (const size_t c : table.curves) {
                const Eigen::Index row = groups[c].first + as_row(i);
                csv.add(data(row)).add(predicted(row)).add(data(row) - predicted(row));
            }
            csv.end_row();
        }
        write_atomically(folder.file(fmt::format("histories-{}.csv", ++number)), csv.text());
    }
    number = 0;
    for (const CurveTable& table : group_by_x(observations.responses, &ObservedResponse::frequencies)) {
        std::vector<Column> columns = {{"frequency", "Hz"}};
        for (const size_t c : table.curves)
            for (const char* part : {".measured.re", ".measured.im", ".predicted.re", ".predicted.im"})
                columns.push_back({observations.responses[c].channel + "/" + observations.responses[c].input + part,
                                   observations.responses[c].unit});
        CsvTable csv(columns);
        for (size_t i = 0; i < table.x->size(); ++i) {
            csv.add((*table.x)[i]);
            for (const size_t c : table.curves) {
                const Eigen::Index row = groups[observations.histories.size() + c].first + as_row(2 * i);
                csv.add(data(row)).add(data(row + 1)).add(predicted(row)).add(predicted(row + 1));
            }
            csv.end_row();
        }
        write_atomically(folder.file(fmt::format("responses-{}.csv", ++number)), csv.text());
    }
}

Json describe_pairs(const Observations& observations, const std::vector<ModePair>& pairs) {
    Json list = Json::array();
    for (size_t i = 0; i < pairs.size(); ++i)
        list.push_back({{"measured", observations.modes[i].frequency},
                        {"mode", pairs[i].mode},
                        {"predicted", pairs[i].frequency},
                        {"mac", std::isnan(pairs[i].mac) ? Json() : Json(pairs[i].mac)}});
    return list;
}

void print_pairs(const Observations& observations, const std::vector<ModePair>& pairs) {
    for (size_t i = 0; i < pairs.size(); ++i) {
        const double measured = observations.modes[i].frequency, own = pairs[i].frequency;
        fmt::print("measured {:.6g} Hz: mode {} of the model, {:.6g} Hz, {:+.2g} %{}\n", measured, pairs[i].mode, own,
                   100 * (own / measured - 1), std::isnan(pairs[i].mac) ? "" : fmt::format(", MAC {:.4f}", pairs[i].mac));
    }
}

}  // namespace dttmm::host
