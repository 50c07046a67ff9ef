// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/sweep_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <unordered_map>

#include "model/error.h"
#include "model/index.h"
#include "model/wording.h"
#include "record/csv_table.h"
#include "record/tell.h"

namespace dttmm::host {

namespace {

/// "curve12" for the stem "curve".
bool is_numbered(std::string_view name, std::string_view stem) {
    return name.starts_with(stem) && name.size() > stem.size() &&
           name.find_first_not_of("0123456789", stem.size()) == std::string_view::npos;
}

bool is_own_column(std::string_view name) {
    return name == "case" || name == "status" || name == "reason" || name == "warnings" || is_numbered(name, "curve") ||
           is_numbered(name, "mac");
}

}  // namespace

std::string case_name(size_t index) { return fmt::format("case-{:06}", index + 1); }

void tell_of_earlier_cases(const std::filesystem::path& folder, size_t count) {
    std::error_code fault;
    if (std::filesystem::exists(folder / case_name(count), fault))
        tell(fmt::format("note: {} and the cases behind it are of an earlier sweep; sweep.csv does not have them",
                         case_name(count)));
}

void merge_names(std::vector<std::string>& all, const std::vector<std::string>& own) {
    size_t next = 0;  // behind the name before
    for (const std::string& name : own) {
        if (next < all.size() && all[next] == name) {  // most cases have the names of the case before
            ++next;
            continue;
        }
        auto at = std::ranges::find(all, name);
        if (at == all.end()) at = all.insert(all.begin() + as_row(next), name);
        next = as_size(at - all.begin()) + 1;
    }
}

std::string make_sweep_table(const std::vector<Parameter>& parameters, const std::vector<SweepRow>& rows) {
    std::vector<std::string> names;
    std::unordered_map<std::string_view, std::string_view> units;
    for (const SweepRow& row : rows) {
        std::vector<std::string> own;
        for (const SweepCell& cell : row.cells) {
            own.push_back(cell.column.name);
            units.emplace(cell.column.name, cell.column.unit);
        }
        merge_names(names, own);
    }
    std::vector<Column> heads = {{"case", ""}};
    // The result of an expression has no unit of its own: it is a plain number in SI
    for (const Parameter& parameter : parameters) heads.push_back({parameter.name, parameter.unit});
    for (const std::string& name : names) heads.push_back({name, std::string(units.at(name))});
    CsvTable table(heads);
    for (size_t r = 0; r < rows.size(); ++r) {
        table.add(case_name(r));
        std::unordered_map<std::string_view, double> values;
        for (const Parameter& parameter : rows[r].parameters) values.emplace(parameter.name, parameter.value);
        for (const Parameter& parameter : parameters) {
            const auto found = values.find(parameter.name);
            table.add(found == values.end() ? std::nan("") : found->second);
        }
        std::unordered_map<std::string_view, const SweepCell*> cells;
        for (const SweepCell& cell : rows[r].cells) cells.emplace(cell.column.name, &cell);
        for (const std::string& name : names) {
            const auto found = cells.find(name);
            if (found == cells.end())
                table.add(std::nan(""));
            else
                std::visit([&](const auto& field) { table.add(field); }, found->second->value);
        }
        table.end_row();
    }
    return table.text();
}

void refuse_column_names(const Model& model) {
    for (const Parameter& parameter : model.parameters)
        if (is_own_column(parameter.name))
            throw Error(
                ExitCode::model_invalid,
                fmt::format("{}: the parameter {} is called like a column of sweep.csv; call it {}, or anything else",
                            model.path, quote(parameter.name), quote(parameter.name + "_")));
}

}  // namespace dttmm::host
