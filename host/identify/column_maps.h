// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <set>
#include <string>
#include <vector>

#include "analysis/request.h"
#include "model/model.h"

namespace dttmm::host {

/// What columns of measured files are by --map and [measured], which columns there are, and which channels have their data.
class ColumnMaps {
public:
    /// --map goes before [measured]. Throws Error(usage) for a --map of another form.
    ColumnMaps(const Request& request, const MeasuredSettings& settings);

    /// What the column called so is; null: nothing says it. The column counts as one that the files have.
    const MeasuredChannel* find(const std::string& column);
    /// The same of what drove a response.
    const MeasuredChannel* find_reference(const std::string& name);
    /// In another file a channel may have its data again: a repeat.
    void begin_file() { claimed_.clear(); }
    /// Throws Error(usage) if the file has data of this channel already.
    void claim(const std::string& channel, const std::string& place);
    /// Throws Error(usage) for a map whose column no file has.
    void check_all_found(const std::vector<std::string>& files) const;
    const std::vector<std::string>& columns() const { return columns_; }

private:
    void add(const std::string& text);

    std::vector<MeasuredChannel> channels_;
    std::set<std::string> found_;
    std::vector<std::string> columns_;
    std::map<std::string, std::string> claimed_;  ///< channel → place of its data
};

}  // namespace dttmm::host
