// SPDX-License-Identifier: BSD-3-Clause
#include "study/case_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "model/error.h"
#include "model/index.h"
#include "model/names.h"
#include "model/parameters.h"
#include "model/units.h"
#include "model/wording.h"
#include "record/csv_file.h"
#include "study/text_list.h"

namespace dttmm::host {

namespace {

/// The fields of one record, without the blanks around them; one without any is a blank line.
std::vector<std::string> split_cells(std::string_view text, size_t& begin) {
    std::vector<std::string> cells = csv_record(text, begin);
    for (std::string& cell : cells) cell = without_blanks_around(cell);
    if (cells.size() == 1 && cells.front().empty()) cells.clear();
    return cells;
}

bool is_number(const std::string& cell) {
    if (cell == "nan" || cell == "inf" || cell == "-inf" || cell == "NaN" || cell == "NA") return true;  // no unit
    try {
        parse_quantity(cell);
        return true;
    } catch (const Error&) {
        return false;
    }
}

/// Of one table while it is read.
class TableText {
public:
    TableText(const std::filesystem::path& file, const std::vector<Parameter>& parameters)
        : file_(file), parameters_(parameters) {}

    CaseTable read() {
        const std::string text = read_whole_file(file_);
        std::vector<std::vector<std::string>> rows;
        std::vector<size_t> lines;
        size_t line = 1;
        for (size_t begin = text.starts_with("\xEF\xBB\xBF") ? 3 : 0; begin < text.size();) {
            const size_t start = begin;
            std::vector<std::string> cells;
            if (text[begin] == '#')
                begin = std::min(text.find('\n', begin), text.size() - 1) + 1;
            else
                cells = split_cells(text, begin);
            if (!cells.empty()) {
                rows.push_back(std::move(cells));
                lines.push_back(line);
            }
            line +=
                as_size(std::count(text.begin() + as_row(start), text.begin() + as_row(std::min(begin, text.size())), '\n'));
        }
        if (rows.empty()) throw Error(ExitCode::model_invalid, fmt::format("{}: the table is empty", file_.string()));
        read_head(rows.front());
        size_t first = 1;
        if (rows.size() > 1 && is_unit_row(rows[1])) {
            units_ = rows[first++];
            check_units(lines[1]);
        }
        if (as_row(rows.size() - first) > kMostStudyCases || rows.size() == first)
            throw Error(ExitCode::model_invalid, fmt::format("{}: it has {} rows of values; 1 to {} are possible",
                                                             file_.string(), rows.size() - first, kMostStudyCases));
        table_.values.resize(as_row(rows.size() - first), as_row(table_.parameters.size()));
        for (size_t r = first; r < rows.size(); ++r) read_row(r - first, rows[r], lines[r]);
        return std::move(table_);
    }

private:
    void read_head(std::vector<std::string> names) {
        for (std::string& name : names) name = normalise_name(name);
        std::vector<std::string> known;
        for (const Parameter& parameter : parameters_) known.push_back(parameter.name);
        for (size_t c = 0; c < names.size(); ++c) {
            if (names[c] == "case") {
                case_column_ = c;
                continue;
            }
            const auto found = std::ranges::find(parameters_, names[c], &Parameter::name);
            if (found == parameters_.end())
                throw Error(ExitCode::usage,
                            fmt::format("{}:1: column {} is no parameter of the model{}", file_.string(), quote(names[c]),
                                        names[c].find_first_of(";\t") != names[c].npos ? "; fields are separated by commas"
                                                                                       : suggestion(names[c], known)));
            if (std::ranges::find(table_.parameters, names[c], &Column::name) != table_.parameters.end())
                throw Error(ExitCode::usage,
                            fmt::format("{}:1: two columns are called {}", file_.string(), quote(names[c])));
            table_.parameters.push_back({found->name, found->unit});
            from_.push_back(&*found);
            columns_.push_back(c);
        }
        width_ = names.size();
        if (columns_.empty())
            throw Error(ExitCode::usage, fmt::format("{}:1: no column is a parameter of the model", file_.string()));
    }

    /// Units only: at least one cell of the columns has one, and none is a number.
    bool is_unit_row(const std::vector<std::string>& cells) const {
        bool has_unit = false;
        for (const size_t c : columns_) {
            if (c >= cells.size() || cells[c].empty()) continue;
            if (cells[c] != "1" && is_number(cells[c])) return false;
            has_unit = has_unit || cells[c] != "1";
        }
        return has_unit;
    }

    void check_units(size_t line) const {
        for (size_t p = 0; p < columns_.size(); ++p) {
            const std::string unit = columns_[p] < units_.size() ? units_[columns_[p]] : "";
            if (unit.empty() || unit == "1" || from_[p]->unit.empty()) continue;
            try {
                parse_quantity("1 " + unit, from_[p]->unit);
            } catch (const Error& error) {
                throw Error(ExitCode::model_invalid,
                            fmt::format("{}:{}: unit of {}: {}", file_.string(), line, from_[p]->name, error.what()));
            }
        }
    }

    void read_row(size_t row, const std::vector<std::string>& cells, size_t line) {
        const auto refuse = [&](ExitCode code, const std::string& fault) {
            throw Error(code, fmt::format("{}:{}: {}", file_.string(), line, fault));
        };
        if (cells.size() != width_)
            refuse(ExitCode::model_invalid,
                   fmt::format("{}, but the first row has {}", counted(cells.size(), "cell", "cells"), width_));
        if (case_column_ && cells[*case_column_] != std::to_string(row + 1))
            refuse(ExitCode::model_invalid,
                   fmt::format("case is {}, but cases count 1, 2, 3 and so on; this is row {}. Leave the "
                               "column out, or keep your own numbers outside of the table",
                               quote(cells[*case_column_]), row + 1));
        for (size_t p = 0; p < columns_.size(); ++p) {
            std::string text = cells[columns_[p]];
            if (text.empty()) refuse(ExitCode::model_invalid, fmt::format("{} has no value", from_[p]->name));
            const std::string unit = columns_[p] < units_.size() ? units_[columns_[p]] : "";
            if (!unit.empty() && unit != "1" && unit_text_of(text).empty()) text += " " + unit;
            std::optional<std::string> missing;
            try {
                missing = find_missing_unit(*from_[p], text);
                if (!missing)
                    table_.values(as_row(row), as_row(p)) =
                        from_[p]->unit.empty() ? parse_quantity(text).value : parse_quantity(text, from_[p]->unit);
            } catch (const Error& error) {
                refuse(ExitCode::model_invalid, fmt::format("{}: {}", from_[p]->name, error.what()));
            }
            if (missing)
                refuse(ExitCode::usage,
                       fmt::format("{} = {} of which unit? the model gives {}: write {} into the second row, "
                                   "which has the units",
                                   from_[p]->name, text, *missing, *missing));
        }
    }

    static std::string unit_text_of(const std::string& text) { return is_number(text) ? unit_text(text) : ""; }

    const std::filesystem::path& file_;
    const std::vector<Parameter>& parameters_;
    CaseTable table_;
    std::vector<const Parameter*> from_;
    std::vector<size_t> columns_;  ///< of the file, for each parameter
    std::vector<std::string> units_;
    std::optional<size_t> case_column_;
    size_t width_ = 0;
};

}  // namespace

std::vector<std::pair<std::string, std::string>> CaseTable::settings(size_t index) const {
    std::vector<std::pair<std::string, std::string>> all;
    for (size_t p = 0; p < parameters.size(); ++p) {
        const std::string number = number_text(values(as_row(index), as_row(p)));
        const std::string& unit = parameters[p].unit;
        all.emplace_back(parameters[p].name, unit.empty() || unit == "1" ? number : number + " " + unit);
    }
    return all;
}

std::string CaseTable::text() const {
    std::string names = "case", units = "1", rows;
    for (const Column& column : parameters) {
        names += "," + column.name;
        units += "," + (column.unit.empty() ? std::string("1") : column.unit);
    }
    for (size_t i = 0; i < cases(); ++i) {
        rows += std::to_string(i + 1);
        for (size_t p = 0; p < parameters.size(); ++p) rows += "," + number_text(values(as_row(i), as_row(p)));
        rows += '\n';
    }
    return names + "\n" + units + "\n" + rows;
}

CaseTable CaseTable::parse(const std::string& text, const std::filesystem::path& file) {
    const auto refuse = [&] { throw Error(ExitCode::input_output, fmt::format("{}: it is damaged", file.string())); };
    std::vector<std::string> lines;
    for (size_t begin = 0; begin < text.size();) {
        const size_t end = std::min(text.find('\n', begin), text.size());
        lines.push_back(text.substr(begin, end - begin));
        begin = end + 1;
    }
    if (lines.size() < 2) refuse();
    const std::vector<std::string> names = split_list(lines[0]), units = split_list(lines[1]);
    if (names.size() != units.size() || names.size() < 2) refuse();
    CaseTable table;
    for (size_t c = 1; c < names.size(); ++c) table.parameters.push_back({names[c], units[c]});
    table.values.resize(as_row(lines.size() - 2), as_row(names.size() - 1));
    for (size_t i = 0; i < table.cases(); ++i) {
        const std::string& line = lines[i + 2];
        const char *at = line.data(), *const end = at + line.size();
        for (size_t c = 0; c < names.size(); ++c) {
            double value = 0;
            const auto [next, fault] = std::from_chars(at, end, value);
            const bool is_last = c + 1 == names.size();
            if (fault != std::errc() || (is_last ? next != end : next == end || *next != ',')) refuse();
            if (c == 0 ? value != static_cast<double>(i + 1) : !std::isfinite(value)) refuse();
            if (c > 0) table.values(as_row(i), as_row(c - 1)) = value;
            at = next + 1;
        }
    }
    return table;
}

CaseTable read_case_table(const std::filesystem::path& file, const std::vector<Parameter>& parameters) {
    return TableText(file, parameters).read();
}

}  // namespace dttmm::host
