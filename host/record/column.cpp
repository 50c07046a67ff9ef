// SPDX-License-Identifier: BSD-3-Clause
#include "record/column.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <unordered_set>

#include "model/error.h"

namespace dttmm::host {

namespace {

bool has_control_character(const std::string& text) {
    return std::any_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; });
}

}  // namespace

void check_columns(const std::vector<Column>& columns) {
    if (columns.empty() || columns.front().name != "time")
        throw Error(ExitCode::internal_error, "channel 0 must be \"time\"; this is a fault of dttmm, please report it");
    std::unordered_set<std::string_view> names;
    names.reserve(columns.size());
    for (const Column& column : columns) {
        const bool sound = !column.name.empty() && column.name != "." && column.name.find('/') == std::string::npos &&
                           !has_control_character(column.name) && !has_control_character(column.unit);
        if (!sound || !names.insert(column.name).second)
            throw Error(ExitCode::internal_error,
                        fmt::format("channel {:?} [{:?}]: the name is empty, taken, or holds a character that no file can "
                                    "store; rename what it belongs to",
                                    column.name, column.unit));
    }
}

}  // namespace dttmm::host
