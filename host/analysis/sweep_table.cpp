// SPDX-License-Identifier: BSD-3-Clause
#include "analysis/sweep_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>
#include <unordered_map>

#include "model/error.h"
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

std::string make_sweep_table(const std::vector<Parameter>& parameters, const std::vector<Column>& columns,
                             const std::vector<SweepRow>& rows) {
    std::vector<Column> heads = {{"case", ""}};
    // The result of an expression has no unit of its own: it is a plain number in SI
    for (const Parameter& parameter : parameters) heads.push_back({parameter.name, parameter.unit});
    heads.insert(heads.end(), columns.begin(), columns.end());
    CsvTable table(heads);
    for (size_t r = 0; r < rows.size(); ++r) {
        table.add(case_name(r));
        std::unordered_map<std::string_view, double> values;
        for (const Parameter& parameter : rows[r].parameters) values.emplace(parameter.name, parameter.value);
        for (const Parameter& parameter : parameters) {
            const auto found = values.find(parameter.name);
            table.add(found == values.end() ? std::nan("") : found->second);
        }
        for (const auto& cell : rows[r].cells) std::visit([&](const auto& field) { table.add(field); }, cell);
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
